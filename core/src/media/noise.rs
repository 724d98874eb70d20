//! Noise that makes blobs look irregular (Fogshop 2007, section 5.5): before each blob the view ray is bent, and
//! where it is bent to depends on the place of the ray that is nearest to the blob's centre. So what a ray meets does
//! not depend on where the camera looks.
//!
//! It is a look, not a medium: β stays what it is, and so do ways of lights. Of airlight, which is formed along the
//! straight ray, as much is left as the bent one removes of light in proportion.
//!
//! The paper reads a tileable texture of Perlin noise; ours is that noise itself, whose lattice repeats.

use super::gaussians::{ENDS, Seen};
use super::{Field, Velocity};
use crate::geometry::Ray;
use crate::json::{Checker, limits};
use crate::random::Random;
use crate::vector::V3;
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Irregularity of blobs and particles.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Noise {
    /// By how much of its radius a blob is shifted at most, near enough; 0 is none.
    #[schemars(range(min = limits::NOISE_STRENGTH.min, max = limits::NOISE_STRENGTH.max))]
    pub strength: f64,
    /// After how far it repeats [m]; its lumps are an eighth of that.
    #[schemars(range(min = limits::CELL.min, max = limits::CELL.max))]
    pub scale_m: f64,
    /// How it moves [m/s].
    pub drift: Velocity,
    /// Another number makes another noise.
    #[schemars(range(max = u32::MAX))]
    pub seed: u32,
}

impl Default for Noise {
    fn default() -> Self {
        Self { strength: 0.0, scale_m: 1.0, drift: Velocity([0.0; 3]), seed: 1 }
    }
}

impl Noise {
    /// Looks at all of its numbers; `at` names its members.
    pub fn check(&self, check: &mut Checker, at: &dyn Fn(&str) -> String) {
        check.number(self.strength, limits::NOISE_STRENGTH, || at("strength"));
        check.number(self.scale_m, limits::CELL, || at("scale_m"));
        check.triple(self.drift.0, limits::VELOCITY, || at("drift"));
    }
}

/// Cells of the lattice along a period.
const CELLS: usize = 8;
/// No noise is longer: of eight unit gradients each component of it is below 1.
const LONGEST: f64 = 1.733;
/// What stands for light removed where there is hardly any fog: else a ray past a blob's last tail, bent into
/// it, would take a number without digits times a thousand.
const HARDLY: f64 = 1e-4;

/// The noise at a time.
#[derive(Clone, Debug, PartialEq)]
pub struct Bend {
    strength: f64,
    /// Cells a metre.
    rate: f64,
    /// How far it has moved, in cells.
    moved: DVec3,
    /// At every place of the lattice a gradient for each component.
    gradients: Vec<[DVec3; 3]>,
}

impl Bend {
    /// `None` where there is no noise.
    pub fn new(noise: &Noise, time_s: f64) -> Option<Self> {
        if noise.strength == 0.0 {
            return None;
        }
        let mut random = Random::new(noise.seed.into());
        let mut gradient = || {
            let (y, angle) = (random.between(-1.0, 1.0), random.between(0.0, TAU));
            let aside = (1.0 - y * y).sqrt();
            DVec3::new(aside * angle.cos(), y, aside * angle.sin())
        };
        let gradients = (0..CELLS.pow(3)).map(|_| [gradient(), gradient(), gradient()]);
        let rate = CELLS as f64 / noise.scale_m;
        let period = CELLS as f64;
        let moved = DVec3::from(noise.drift.0) * (time_s * rate);
        Some(Self {
            strength: noise.strength,
            rate,
            moved: moved - (moved / period).floor() * period,
            gradients: gradients.collect(),
        })
    }

    /// Its strength, and cells of its lattice a metre.
    pub fn scale(&self) -> [f64; 2] {
        [self.strength, self.rate]
    }

    /// Where a place stands in the lattice, in cells of the first period.
    pub fn in_lattice(&self, place: DVec3) -> DVec3 {
        let (at, period) = (place * self.rate + self.moved, CELLS as f64);
        at - (at / period).floor() * period
    }

    /// The gradients of all places of the lattice, along x first, one for each component.
    pub fn gradients(&self) -> &[[DVec3; 3]] {
        &self.gradients
    }

    /// How far from its straight ray a blob counts, in radii.
    pub fn reach(&self) -> f64 {
        ENDS + LONGEST * self.strength
    }

    /// The noise at a place.
    fn at(&self, place: DVec3) -> DVec3 {
        let place = place * self.rate + self.moved;
        let corner = place.floor();
        let part = place - corner;
        let index =
            |k: usize, step: usize| (corner[k].rem_euclid(CELLS as f64) as usize + step) % CELLS;
        let fade = part * part * part * (part * (part * 6.0 - 15.0) + 10.0);
        let mut sum = DVec3::ZERO;
        for i in 0..8 {
            let step = [i & 1, i >> 1 & 1, i >> 2];
            let from = DVec3::from(step.map(|step| step as f64));
            let share = from * fade + (1.0 - from) * (1.0 - fade);
            let [x, y, z] = [0, 1, 2].map(|k| index(k, step[k]));
            let gradients = &self.gradients[(z * CELLS + y) * CELLS + x];
            let way = part - from;
            sum += share.element_product() * DVec3::from(gradients.map(|own| own.dot(way)));
        }
        sum
    }

    /// By how much T of a blob grows where the ray is bent before it; `seen` from the ray's start.
    pub fn change(&self, seen: &Seen<f64>, ray: &Ray, length_m: f64) -> f64 {
        let straight = V3::from(ray.direction);
        let along = seen.b.dot(straight);
        let distance = seen.b.length_squared().sqrt();
        if distance * distance - along * along > self.reach().powi(2) {
            return 0.0;
        }
        let offset = self.strength / distance.max(1.0) * self.at(ray.at(along / seen.a));
        let bent = (ray.direction + offset).normalize_or(ray.direction);
        seen.optical_depth(bent.into(), length_m) - seen.optical_depth(straight, length_m)
    }

    /// The same of all blobs of a field.
    pub fn change_of(&self, field: &Field, ray: &Ray, length_m: f64) -> f64 {
        let blobs =
            field.blobs().map(|blob| self.change(&blob.seen_by_eye(ray.origin), ray, length_m));
        blobs.sum()
    }
}

/// What is left of airlight where T grows from one number to another.
pub fn share(straight: f64, bent: f64) -> f64 {
    let removed = |depth: f64| HARDLY - (-depth).exp_m1();
    removed(bent) / removed(straight)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bend(noise: Noise, time_s: f64) -> Bend {
        Bend::new(&noise, time_s).expect("some noise")
    }

    /// It repeats after its scale in every direction, drifts as it says, and no place has more than it may.
    #[test]
    fn noise_repeats_drifts_and_is_bounded() {
        let noise =
            Noise { strength: 1.0, scale_m: 2.0, drift: Velocity([0.5, 0.0, -0.3]), seed: 3 };
        let (still, later) = (bend(noise.clone(), 0.0), bend(noise, 1.5));
        let mut random = Random::new(7);
        let mut longest = 0.0f64;
        for _ in 0..2000 {
            let place = DVec3::from([0; 3].map(|_| random.between(-5.0, 5.0)));
            let value = still.at(place);
            for axis in DVec3::AXES {
                assert!((still.at(place + 2.0 * axis) - value).length() < 1e-9);
            }
            let moved = place - DVec3::new(0.75, 0.0, -0.45);
            assert!((later.at(moved) - value).length() < 1e-9);
            longest = longest.max(value.length());
        }
        assert!((0.5..LONGEST).contains(&longest), "{longest}");
    }
}
