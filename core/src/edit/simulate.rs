//! Painted blobs that are let go as particles (Fogshop 2007, section 6) and frozen where they are then.

use super::particles::{MOST_STEPS, Motion, Particle, advance, steps};
use super::term::{Name, gaussians};
use super::{Desk, Refused, Tool, paint_stroke};
use crate::json::limits;
use crate::json::{Checker, Code};
use crate::rounding::rounded;
use crate::scene::{CheckedScene, Scene};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Lets all blobs of a term go as particles that bounce off surfaces, and freezes them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Simulate {
    /// The term: its id, or its place.
    pub term: Name,
    /// For how long [s].
    #[schemars(range(min = limits::PERIOD.min, max = limits::PERIOD.max))]
    pub duration_s: f64,
    /// What accelerates them: buoyancy, or gravity [m/s²].
    #[serde(default)]
    #[schemars(inner(range(min = limits::VELOCITY.min, max = limits::VELOCITY.max)))]
    pub acceleration: [f64; 3],
    /// How fast they spread [m²/s].
    #[serde(default)]
    #[schemars(range(min = limits::DIFFUSION.min, max = limits::DIFFUSION.max))]
    pub diffusion_m2_per_s: f64,
    /// Chooses their ways.
    #[serde(default)]
    pub seed: u32,
}

impl Tool for Simulate {
    fn check(&self, check: &mut Checker, at: &dyn Fn(&str) -> String) {
        check.number(self.duration_s, limits::PERIOD, || at("duration_s"));
        check.triple(self.acceleration, limits::VELOCITY, || at("acceleration"));
        check.number(self.diffusion_m2_per_s, limits::DIFFUSION, || at("diffusion_m2_per_s"));
    }

    fn apply(&self, scene: &CheckedScene, desk: &mut Desk) -> Result<Scene, Refused> {
        let mut after = (**scene).clone();
        let gaussians = gaussians(&mut after, &self.term)?;
        if steps(gaussians.blobs.len() as f64, self.duration_s) > MOST_STEPS {
            let detail =
                format!("{} blobs take too many steps in this time", gaussians.blobs.len());
            return Err(Refused::Member {
                member: "duration_s".into(),
                code: Code::TooMany,
                detail,
            });
        }
        let particle = |(number, position): (u64, DVec3)| Particle {
            position,
            velocity: DVec3::ZERO,
            time_s: self.duration_s,
            number,
        };
        let centers = gaussians.blobs.iter().map(|blob| blob.center.vector());
        let mut particles: Vec<_> = (0..).zip(centers).map(particle).collect();
        let motion = Motion {
            acceleration: DVec3::from(self.acceleration),
            diffusion: self.diffusion_m2_per_s,
            seed: self.seed.into(),
        };
        advance(&mut particles, &motion, &*(desk.surfaces)(scene)?);
        for (blob, particle) in gaussians.blobs.iter_mut().zip(&particles) {
            blob.center = rounded(particle.position, paint_stroke::steps(blob.radius));
        }
        Ok(after)
    }
}
