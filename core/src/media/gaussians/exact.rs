//! Blobs along one ray in f64, to rounding: what does not change along it is formed once.

use super::draw::{HALF_SLAB, gathered};
use super::{Blobs, ENDS, Gaussian};
use crate::geometry::{Beyond, Ray};
use crate::media::{Along, Ways};
use glam::DVec3;

/// A blob that a ray meets.
#[derive(Debug)]
struct MetBlob {
    /// Scale a [1/m].
    a: f64,
    /// Ray parameter of its closest point [m].
    at: f64,
    /// Its extinction there [1/m].
    peak: f64,
    /// Half of T along the whole line.
    half_depth: f64,
    /// erf at the ray's origin, or what a slab has for it.
    erf_start: f64,
    is_slab: bool,
}

impl MetBlob {
    /// What has been gathered up to a place, in radii from its middle: −1 before all, 1 behind.
    fn gathered(place: f64, is_slab: bool) -> f64 {
        if is_slab { gathered(place) } else { libm::erf(place) }
    }
}

/// The blobs that a ray meets.
#[derive(Debug)]
pub struct OnRay {
    met: Vec<MetBlob>,
    length_m: f64,
}

impl OnRay {
    /// Gathers them.
    pub fn new(blobs: &Blobs, ray: &Ray, length_m: f64) -> Self {
        let met = |place: usize| {
            let blob = &blobs.all()[place];
            let to = blob.center - ray.origin;
            let (at, a) = (to.dot(ray.direction), blob.a);
            let miss = to.cross(ray.direction).length() * a;
            let through = (-miss * miss).exp();
            let (peak, half_depth) = (blob.c * through, blob.half_depth() * through);
            let is_slab = blob.is_slab;
            let erf_start = MetBlob::gathered(-a * at, is_slab);
            MetBlob { a, at, peak, half_depth, erf_start, is_slab }
        };
        Self { met: blobs.on_ray(ray, length_m).into_iter().map(met).collect(), length_m }
    }
}

impl Along for OnRay {
    fn terms(&self) -> usize {
        self.met.len()
    }

    fn is_smooth(&self) -> bool {
        false
    }

    fn beta(&self, t: f64) -> f64 {
        let blobs = self.met.iter().map(|MetBlob { a, at, peak, half_depth, is_slab, .. }| {
            let s = a * (t - at);
            match (is_slab, s.abs() < HALF_SLAB) {
                (false, _) => peak * (-s * s).exp(),
                (true, true) => half_depth * a / HALF_SLAB,
                (true, false) => 0.0,
            }
        });
        blobs.sum()
    }

    fn depth(&self, t: f64) -> f64 {
        let blobs =
            self.met.iter().map(|MetBlob { a, at, half_depth, erf_start, is_slab, .. }| {
                half_depth * (MetBlob::gathered(a * (t - at), *is_slab) - erf_start)
            });
        blobs.sum()
    }

    fn span(&self) -> Option<(f64, f64)> {
        let from = self.met.iter().map(|met| met.at - ENDS / met.a).fold(f64::INFINITY, f64::min);
        let to = self.met.iter().map(|met| met.at + ENDS / met.a).fold(0.0, f64::max);
        let (from, to) = (from.max(0.0), to.min(self.length_m));
        (from < to).then_some((from, to))
    }

    fn edges(&self) -> Vec<f64> {
        /// Of more slabs than this each matters less than quadratures may miss.
        const MOST: usize = 1024;
        let slabs = || self.met.iter().filter(|met| met.is_slab);
        if slabs().count() > MOST {
            return Vec::new();
        }
        slabs().flat_map(|MetBlob { a, at, .. }| [at - HALF_SLAB / a, at + HALF_SLAB / a]).collect()
    }

    fn finest_m(&self, from: f64, to: f64) -> f64 {
        /// Thinner blobs may be overlooked: below the error that integrals are allowed.
        const UNSEEN: f64 = 1e-9;
        let is_crossed = |met: &&MetBlob| {
            let reach = ENDS / met.a;
            met.half_depth > UNSEEN && met.at + reach > from && met.at - reach < to
        };
        self.met.iter().filter(is_crossed).map(|met| 1.0 / met.a).fold(f64::INFINITY, f64::min)
    }
}

/// The blobs between a point and the points of a segment.
#[derive(Debug)]
pub struct Between {
    /// Where the ways begin [m].
    pub apex: DVec3,
    /// Those that some way meets.
    pub blobs: Vec<Gaussian>,
}

impl Ways for Between {
    fn terms(&self) -> usize {
        self.blobs.len()
    }

    fn depth_to(&self, point: DVec3) -> f64 {
        let (ray, length_m) = Ray::between(self.apex, point);
        self.blobs.iter().map(|blob| blob.depth_if_near(&ray, length_m)).sum()
    }
}

/// Farther than any blob lies from any point [m].
pub const EVERYWHERE_M: f64 = 1e10;

/// The blobs between beyond everything and the points of a segment.
#[derive(Debug)]
pub struct FromBeyond {
    /// Where the ways come from.
    pub beyond: Beyond,
    /// Those that some way meets.
    pub blobs: Vec<Gaussian>,
}

impl Ways for FromBeyond {
    fn terms(&self) -> usize {
        self.blobs.len()
    }

    fn depth_to(&self, point: DVec3) -> f64 {
        let ray = Ray { origin: point, direction: self.beyond.toward };
        self.blobs.iter().map(|blob| blob.depth_if_near(&ray, EVERYWHERE_M)).sum()
    }
}
