//! The airbrush (Fogshop 2007, section 6): an emitter whose particles have no end, bounce off surfaces and diffuse, until
//! it stops and they are frozen. It fills a room, or a mesh from inside.

use super::particles::{MOST_STEPS, Motion, Particle, Spray, advance, steps};
use super::stroke::{Trail, check_stroke};
use super::term::{Name, gaussians, painted};
use super::{Desk, Refused, Tool, paint_stroke};
use crate::json::limits::{self, COUNTS};
use crate::json::{Checker, Code, Spectrum, Vec3};
use crate::random::lattice;
use crate::rounding::rounded;
use crate::scene::{Blob, CheckedScene, Scene};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Sprays particles from a place into all directions, and freezes them at the end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Airbrush {
    /// Where they come from [m].
    pub position: Vec3,
    /// How many a second [Hz].
    #[schemars(range(min = limits::RATE.min, max = limits::RATE.max))]
    pub rate_hz: f64,
    /// For how long [s].
    #[schemars(range(min = limits::PERIOD.min, max = limits::PERIOD.max))]
    pub duration_s: f64,
    /// How fast they leave [m/s].
    #[serde(default)]
    #[schemars(range(min = limits::SPEED.min, max = limits::SPEED.max))]
    pub speed: f64,
    /// How fast they spread [m²/s]: in open air by √(6 D t) in the mean.
    #[serde(default)]
    #[schemars(range(min = limits::DIFFUSION.min, max = limits::DIFFUSION.max))]
    pub diffusion_m2_per_s: f64,
    /// Their radius [m].
    #[schemars(range(min = limits::RADIUS.min, max = limits::RADIUS.max))]
    pub radius: f64,
    /// Extinction in the middle of each [1/m].
    #[schemars(schema_with = "Spectrum::extinction")]
    pub extinction: Spectrum,
    /// Chooses their ways.
    #[serde(default)]
    pub seed: u32,
    /// The term that they are added to; the last one of blobs where nothing is said, made if there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub term: Option<Name>,
    /// Names the stroke: with the same name the particles so far fly on, and all of it is undone together. Another
    /// change in between freezes them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1, max = COUNTS.id_chars))]
    pub stroke: Option<String>,
}

impl Tool for Airbrush {
    fn check(&self, check: &mut Checker, at: &dyn Fn(&str) -> String) {
        check.triple(self.position.0, limits::COORDINATE, || at("position"));
        check.number(self.rate_hz, limits::RATE, || at("rate_hz"));
        check.number(self.duration_s, limits::PERIOD, || at("duration_s"));
        check.number(self.speed, limits::SPEED, || at("speed"));
        check.number(self.diffusion_m2_per_s, limits::DIFFUSION, || at("diffusion_m2_per_s"));
        check.number(self.radius, limits::RADIUS, || at("radius"));
        check.spectrum(self.extinction, limits::EXTINCTION, || at("extinction"));
        check_stroke(self.stroke(), check, at);
        let born = self.rate_hz * self.duration_s;
        check.count(born.min(1e15) as usize, COUNTS.blobs, "blobs", || at("duration_s"));
    }

    fn apply(&self, scene: &CheckedScene, desk: &mut Desk) -> Result<Scene, Refused> {
        let mut after = (**scene).clone();
        let spray = desk.strokes.spray(self.stroke());
        let mut spray = match spray {
            Some(spray) => spray,
            None => {
                let (term, gaussians) = painted(&mut after, self.term.as_ref())?;
                Spray { term, first: gaussians.blobs.len(), velocities: Vec::new(), time_s: 0.0 }
            }
        };
        let gaussians = gaussians(&mut after, &Name::Place(spray.term))?;
        let in_air = gaussians.blobs.get(spray.first..).unwrap_or_default();
        let mut particles = self.particles(&spray, in_air);
        is_affordable(&particles)?;
        let motion = Motion {
            acceleration: DVec3::ZERO,
            diffusion: self.diffusion_m2_per_s,
            seed: u64::from(self.seed) ^ spray.time_s.to_bits(),
        };
        advance(&mut particles, &motion, &*(desk.surfaces)(scene)?);
        let steps = paint_stroke::steps(self.radius);
        let places = particles.iter().map(|particle| rounded(particle.position, steps));
        let (old, new) = (in_air.len(), places.clone().skip(in_air.len()));
        for (blob, center) in gaussians.blobs[spray.first..].iter_mut().zip(places.take(old)) {
            blob.center = center;
        }
        let blob = |center| Blob { center, radius: self.radius, extinction: self.extinction };
        gaussians.blobs.extend(new.map(blob).collect::<Vec<_>>());
        spray.velocities = particles.iter().map(|p| p.velocity.to_array()).collect();
        spray.time_s += self.duration_s;
        desk.strokes.leave(self.stroke(), Trail::Spray(spray));
        Ok(after)
    }

    fn stroke(&self) -> Option<&str> {
        self.stroke.as_deref()
    }
}

/// Whether particles may go on for their times.
fn is_affordable(particles: &[Particle]) -> Result<(), Refused> {
    let steps: f64 = particles.iter().map(|particle| steps(1.0, particle.time_s)).sum();
    if steps <= MOST_STEPS {
        return Ok(());
    }
    let detail = format!(
        "the particles take {steps} steps of a thirtieth of a second together, more than the limit of {MOST_STEPS}"
    );
    Err(Refused::Member { member: "duration_s".into(), code: Code::TooMany, detail })
}

impl Airbrush {
    /// Those in the air, and those that are born meanwhile: particle k at k/rate, whatever the calls.
    fn particles(&self, spray: &Spray, in_air: &[Blob]) -> Vec<Particle> {
        let old =
            in_air.iter().zip(&spray.velocities).zip(0u64..).map(|((blob, velocity), number)| {
                let position = blob.center.vector();
                Particle {
                    position,
                    velocity: DVec3::from(*velocity),
                    time_s: self.duration_s,
                    number,
                }
            });
        let (begin, end) = (spray.time_s, spray.time_s + self.duration_s);
        // The first of them comes at once.
        let first = (begin * self.rate_hz).ceil() as u64;
        let last = (end * self.rate_hz).ceil() as u64;
        let new = (first..last).zip(spray.velocities.len() as u64..).map(|(k, number)| Particle {
            position: self.position.vector(),
            velocity: self.velocity(number),
            time_s: end - k as f64 / self.rate_hz,
            number,
        });
        old.chain(new).collect()
    }

    /// Even over all directions.
    fn velocity(&self, number: u64) -> DVec3 {
        let [height, turn] = [0, 1].map(|i| lattice(number as i64, i, self.seed.into()));
        let cos = 1.0 - 2.0 * height;
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let (side, other) = (TAU * turn).sin_cos();
        self.speed * DVec3::new(sin * other, cos, sin * side)
    }
}
