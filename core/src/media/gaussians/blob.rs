//! Sums of Gaussians: βᵢ(x) = cᵢ exp(−aᵢ² |x − bᵢ|²) (Fogshop 2007, eqs. 6–7).
//!
//! [`Line`] is eq. 31, the integral of one Gaussian along a segment. Ours: the paper's angle ξ is
//! replaced by dot and cross products, which have no singularity at the blob's centre; erf is not
//! the printed polynomial, whose error of 2e-4 swallows the tails.
//!
//! Valid for any radius and extinction of the scene's limits. Lengths in metres; inside [`Line`]
//! they are in units of the blob's radius 1/a.

use super::Blob;
use super::draw::{Draw, HALF_SLAB, Slab, gathered_between};
use crate::geometry::Ray;
use crate::num::Num;
use crate::vector::V3;
use glam::DVec3;

/// √π / 2.
pub const HALF_SQRT_PI: f64 = 0.886_226_925_452_758;

/// One blob.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gaussian {
    /// Centre b [m].
    pub center: DVec3,
    /// Scale a = 1/radius [1/m].
    pub a: f64,
    /// Extinction c at the centre [1/m].
    pub c: f64,
    /// Whether view rays see a slab.
    pub is_slab: bool,
}

impl Gaussian {
    /// A blob as one channel meets it.
    pub fn new(blob: &Blob, channel: usize) -> Self {
        let c = blob.extinction.channels()[channel];
        Self { center: blob.center.vector(), a: 1.0 / blob.radius, c, is_slab: false }
    }

    /// The same with a share of its extinction.
    #[must_use]
    pub fn thinned(self, share: f64) -> Self {
        Self { c: self.c * share, ..self }
    }

    /// The same, seen so.
    #[must_use]
    pub fn drawn(self, draw: Draw) -> Self {
        Self { is_slab: draw == Draw::Slab, ..self }
    }

    /// The same elsewhere.
    #[must_use]
    pub fn moved(self, shift: DVec3) -> Self {
        Self { center: self.center + shift, ..self }
    }

    /// β(x) [1/m].
    pub fn beta(&self, x: DVec3) -> f64 {
        self.c * (-self.a * self.a * (x - self.center).length_squared()).exp()
    }

    /// Optical depth from infinity to the centre, c√π/(2a): half of what a ray through it meets.
    pub fn half_depth(&self) -> f64 {
        self.c * HALF_SQRT_PI / self.a
    }

    /// T along a ray of that length [m].
    pub fn depth(&self, ray: &Ray, length_m: f64) -> f64 {
        self.seen_from(ray.origin).optical_depth(ray.direction.into(), length_m)
    }

    /// The same along a view ray.
    pub fn seen_depth(&self, ray: &Ray, length_m: f64) -> f64 {
        self.seen_by_eye(ray.origin).optical_depth(ray.direction.into(), length_m)
    }

    /// That of the field, at once 0 where the ray passes so far aside that it gathers less than rounding.
    pub fn depth_if_near(&self, ray: &Ray, length_m: f64) -> f64 {
        /// In radii, squared: e⁻⁴⁵ is 3e-20.
        const FAR2: f64 = 45.0;
        let seen = self.seen_from(ray.origin);
        let direction = V3::from(ray.direction);
        if seen.b.cross(direction).length_squared() > FAR2 {
            return 0.0;
        }
        seen.optical_depth(direction, length_m)
    }

    /// The blob relative to an origin.
    pub fn seen_from(&self, origin: DVec3) -> Seen<f64> {
        let b = (self.center - origin) * self.a;
        Seen { b: b.into(), a: self.a, k: self.half_depth(), is_slab: false }
    }

    /// The same as view rays see it.
    pub fn seen_by_eye(&self, origin: DVec3) -> Seen<f64> {
        Seen { is_slab: self.is_slab, ..self.seen_from(origin) }
    }

    /// Distance beyond which no segment gathers more than `loss` of optical depth from it [m].
    pub fn reach(&self, loss: f64) -> f64 {
        (2.0 * self.half_depth() / loss).ln().max(0.0).sqrt() / self.a
    }
}

/// A blob relative to the origin of rays.
#[derive(Clone, Copy, Debug)]
pub struct Seen<N> {
    /// a · (centre − origin), without unit.
    pub b: V3<N>,
    /// Scale a [1/m].
    pub a: N,
    /// Half depth c√π/(2a).
    pub k: N,
    /// Whether it is a slab.
    pub is_slab: bool,
}

/// A segment relative to a blob, lengths in units of the blob's radius.
#[derive(Clone, Copy, Debug)]
pub struct Line<N> {
    /// Where it starts, counted from its point closest to the centre.
    pub start: N,
    /// Where it ends.
    pub end: N,
    /// Squared distance of its line from the centre.
    pub miss2: N,
    /// exp(−miss2).
    pub peak: N,
}

impl<N: Num> Line<N> {
    /// erf(end) − erf(start), given the segment's own length: of a short one inside a large blob
    /// the difference of the ends keeps few digits in f32.
    #[inline(always)]
    pub fn between(&self, length: N) -> N {
        /// Up to here the series below is exact to 1e-10, and beyond the difference to 2e-5.
        const SHORT: f64 = 5e-3;
        let plain = N::erf_difference(self.start, self.end);
        let short = length.lt(length.lit(SHORT));
        if !N::any(short) {
            return plain;
        }
        let square = length.mul_add(length.lit(0.5), self.start).squared();
        let curved = square.mul_add(length.lit(4.0), length.lit(-2.0));
        let bend = (length.squared() * curved).mul_add(length.lit(1.0 / 24.0), length.lit(1.0));
        let scale = length * length.lit(std::f64::consts::FRAC_2_SQRT_PI);
        N::select(short, scale * square.bell() * bend, plain)
    }
}

impl<N: Num> Seen<N> {
    /// The segment from the origin in the unit direction up to `length` [m].
    #[inline(always)]
    pub fn line(&self, direction: V3<N>, length: N) -> Line<N> {
        let start = -self.b.dot(direction);
        let miss2 = self.b.cross(direction).length_squared();
        Line { start, end: self.a.mul_add(length, start), miss2, peak: miss2.bell() }
    }

    /// T along that segment (Fogshop 31).
    #[inline(always)]
    pub fn optical_depth(&self, direction: V3<N>, length: N) -> N {
        let line = self.line(direction, length);
        if self.is_slab {
            let gathered = gathered_between([line.start, line.end], self.a * length);
            return self.k * line.peak * gathered;
        }
        self.k * line.peak * line.between(self.a * length)
    }

    /// T along that segment without the care for tails: off by up to 3e-6 · k in f32 lanes.
    #[inline(always)]
    pub fn plain_depth(&self, direction: V3<N>, length: N) -> N {
        let line = self.line(direction, length);
        self.k * line.peak * N::erf_plain_difference(line.start, line.end)
    }

    /// T along that segment when both its ends lie far outside of the blob.
    #[inline(always)]
    pub fn whole_depth(&self, direction: V3<N>) -> N {
        let miss = self.b.cross(direction);
        (self.k + self.k) * miss.length_squared().bell()
    }

    /// What a ray of that length meets of it as a slab.
    #[inline(always)]
    pub fn slab(&self, direction: V3<N>, length: N) -> Slab<N> {
        let line = self.line(direction, length);
        let (zero, half) = (length.lit(0.0), length.lit(HALF_SLAB));
        let end = |side: N| ((side - line.start) / self.a).max(zero).min(length);
        let beta = self.k * line.peak * self.a * length.lit(1.0 / HALF_SLAB);
        Slab { beta, ends: [end(-half), end(half)] }
    }
}
