//! Where lumps of fog lie as a light sees them, and how finely a table must resolve them.

use super::gaussians::ENDS;
use glam::DVec3;

/// What cubics between samples may miss of a lump's half depth, in optical depth.
const ERROR: f64 = 8e-3;

/// The lumps around a light.
#[derive(Clone, Debug)]
pub struct Outline {
    /// Corners of a box around them [m].
    pub min: DVec3,
    /// See `min`.
    pub max: DVec3,
    /// How near to the light the first begins [m].
    pub near: f64,
    /// How far from it the last ends [m].
    pub far: f64,
    /// Spacing of samples that each of them needs [rad].
    pub spacings: Vec<f64>,
}

impl Default for Outline {
    fn default() -> Self {
        let (min, max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        Self { min, max, near: f64::INFINITY, far: 0.0, spacings: Vec::new() }
    }
}

impl Outline {
    /// Adds a lump of that radius [m]; `half_depth` is half of T through its middle.
    pub fn add(&mut self, apex: DVec3, center: DVec3, radius: f64, half_depth: f64) {
        let reach = DVec3::splat(ENDS * radius);
        (self.min, self.max) = (self.min.min(center - reach), self.max.max(center + reach));
        let distance = center.distance(apex);
        // The fourth derivative of a Gaussian, met by the error of cubics.
        let sharp = (ERROR / (0.28 * half_depth)).powf(0.25).min(1.5);
        self.spacings.push(sharp * radius / distance.max(radius));
        self.near = self.near.min(radius.max(distance - ENDS * radius));
        self.far = self.far.max(distance + ENDS * radius);
    }

    /// The lumps of both.
    pub fn join(mut self, other: Self) -> Self {
        (self.min, self.max) = (self.min.min(other.min), self.max.max(other.max));
        (self.near, self.far) = (self.near.min(other.near), self.far.max(other.far));
        self.spacings.extend(other.spacings);
        self
    }
}
