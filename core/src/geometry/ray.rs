//! One ray in f64.

use glam::DVec3;

/// Where a ray starts and where it goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts [m].
    pub origin: DVec3,
    /// Unit vector.
    pub direction: DVec3,
}

impl Ray {
    /// The ray from one point towards another, and how far that is [m]; along +Z where they coincide.
    pub fn between(from: DVec3, to: DVec3) -> (Self, f64) {
        let length_m = from.distance(to);
        let direction = if length_m > 0.0 { (to - from) / length_m } else { DVec3::Z };
        (Self { origin: from, direction }, length_m)
    }

    /// The point at the ray parameter `t` [m].
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + t * self.direction
    }
}
