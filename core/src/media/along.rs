//! A field along one ray: β and T at any of its points, without looking at blobs far aside again.

use super::Field;
use super::gaussians::Gaussian;
use crate::num::Num;
use glam::DVec3;

/// Radii from its middle on a ray at which a blob has ended there: exp(−4²) is 1e-7.
pub const ENDS: f64 = 4.0;

/// The blobs that one ray meets.
#[derive(Clone, Debug)]
pub struct Along {
    beta: f64,
    length: f64,
    met: Vec<Met>,
}

/// A blob that the ray meets.
#[derive(Clone, Copy, Debug)]
struct Met {
    a: f64,
    /// Ray parameter of its closest point [m].
    at: f64,
    /// β there [1/m].
    beta: f64,
    /// Half of what the whole line gathers of it.
    half_depth: f64,
}

impl Met {
    fn new(blob: &Gaussian, origin: DVec3, direction: DVec3) -> Self {
        let to = blob.center - origin;
        let miss = to.cross(direction).length() * blob.a;
        let peak = (-miss * miss).exp();
        let (beta, half_depth) = (blob.c * peak, blob.half_depth() * peak);
        Self { a: blob.a, at: to.dot(direction), beta, half_depth }
    }
}

impl Field {
    /// What a ray from `origin` in the unit `direction` meets up to `length` [m], to rounding.
    pub fn along(&self, origin: DVec3, direction: DVec3, length: f64) -> Along {
        let mut met = Vec::new();
        self.near_segment(origin, direction, length, |blob| {
            met.push(Met::new(blob, origin, direction));
            0.0
        });
        met.retain(|met| met.half_depth > 0.0);
        Along { beta: self.homogeneous.beta, length, met }
    }
}

impl Along {
    /// β [1/m] and T from the origin at a ray parameter [m].
    pub fn at(&self, t: f64) -> (f64, f64) {
        let (mut beta, mut depth) = (self.beta, self.beta * t);
        for met in &self.met {
            let s = met.a * (t - met.at);
            beta += met.beta * (-s * s).exp();
            depth += met.half_depth * f64::erf_difference(-met.a * met.at, s);
        }
        (beta, depth)
    }

    /// From where to where there is fog [m]; `None` if there is none.
    pub fn span(&self) -> Option<(f64, f64)> {
        if self.beta > 0.0 {
            return (self.length > 0.0).then_some((0.0, self.length));
        }
        let start = |met: &Met| met.at - ENDS / met.a;
        let end = |met: &Met| met.at + ENDS / met.a;
        let from = self.met.iter().map(start).fold(f64::INFINITY, f64::min).max(0.0);
        let to = self.met.iter().map(end).fold(0.0, f64::max).min(self.length);
        (from < to).then_some((from, to))
    }

    /// Where T reaches `opaque` between two ray parameters, else the second one [m].
    pub fn reaches(&self, opaque: f64, from: f64, to: f64) -> f64 {
        let (mut low, mut high) = (from, to);
        if self.at(to).1 <= opaque {
            return to;
        }
        // To a thousandth of itself is near enough for an end that nothing is seen of.
        while high - low > 1e-3 * (high - from) && high - low > 1e-12 * high {
            let middle = 0.5 * (low + high);
            if self.at(middle).1 > opaque { high = middle } else { low = middle }
        }
        high
    }
}
