//! Particles that drift, diffuse and bounce off surfaces.
//!
//! In a step dt a particle goes v dt + √(2 D dt) ξ with ξ from a normal distribution: its mean square distance
//! grows by 6 D a second in open space, and by as much in any number of steps.

use crate::geometry::Ray;
use crate::json::limits::COUNTS;
use crate::random::Random;
use crate::shapes::Geometry;
use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Length of a step [s]: between two pictures of a film.
const STEP_S: f64 = 1.0 / 30.0;

/// Bounces within a step; in a narrow corner a particle stays where it is then.
const BOUNCES: usize = 8;

/// What keeps particles off surfaces, as a share of their coordinates: the surfaces' corners are kept in f32.
const ROUNDING: f64 = 1e-6;

/// What moves particles.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    /// What accelerates them [m/s²].
    pub acceleration: DVec3,
    /// How fast they spread [m²/s].
    pub diffusion: f64,
    /// Chooses their ways.
    pub seed: u64,
}

/// A particle in the air.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Particle {
    /// Where it is [m].
    pub position: DVec3,
    /// How fast it goes [m/s].
    pub velocity: DVec3,
    /// How long it goes on [s].
    pub time_s: f64,
    /// Its number: with the seed, it chooses its way.
    pub number: u64,
}

/// Particles of an airbrush that are still in the air: blobs of a term, in a row.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spray {
    /// The place of the term.
    pub term: u32,
    /// The place of the first blob.
    pub first: usize,
    /// How fast each of them goes [m/s].
    pub velocities: Vec<[f64; 3]>,
    /// How long it has been sprayed [s].
    pub time_s: f64,
}

/// Steps that some particles take together.
pub fn steps(particles: f64, time_s: f64) -> f64 {
    particles * (time_s / STEP_S).ceil().max(1.0)
}

/// The most that particles of one edit may take: about a second's work.
pub const MOST_STEPS: f64 = COUNTS.particle_steps as f64;

/// Moves every particle for its time.
pub fn advance(particles: &mut [Particle], motion: &Motion, surfaces: &Geometry) {
    particles.par_iter_mut().for_each(|particle| particle.advance(motion, surfaces));
}

impl Particle {
    fn advance(&mut self, motion: &Motion, surfaces: &Geometry) {
        let steps = (self.time_s / STEP_S).ceil();
        let step_s = self.time_s / steps;
        let spread = (2.0 * motion.diffusion * step_s).sqrt();
        let mut random = Random::new(motion.seed ^ self.number.wrapping_mul(0xd1b5_4a32_d192_ed03));
        for _ in 0..steps as u64 {
            self.velocity += step_s * motion.acceleration;
            let by_chance = DVec3::new(random.bell(), random.bell(), random.bell());
            self.go(self.velocity * step_s + spread * by_chance, surfaces);
        }
    }

    /// Goes a way, and bounces off what is in it.
    fn go(&mut self, mut way: DVec3, surfaces: &Geometry) {
        for _ in 0..BOUNCES {
            let Some(direction) = way.try_normalize() else { return };
            let length = way.length();
            let apart = ROUNDING * (self.position.abs().max_element() + length + 1.0);
            let ray = Ray { origin: self.position, direction };
            let Some(hit) = surfaces.first_hit(ray.origin, ray.direction, length + apart) else {
                self.position += way;
                return;
            };
            let free = (hit.distance - apart).clamp(0.0, length);
            self.position += free * direction;
            let reflect = |v: DVec3| v - 2.0 * v.dot(hit.normal) * hit.normal;
            way = reflect((length - free) * direction);
            self.velocity = reflect(self.velocity);
        }
    }
}
