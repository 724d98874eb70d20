//! Airlight in a sum of Gaussians and homogeneous fog as published (Fogshop 2007, eqs. 8–17),
//! isotropic.
//!
//! Each blob's share of the integral is its line integral times the integrand at the projection of
//! its centre onto the ray (eqs. 10–11). There the blob itself is attenuated along the true path
//! light → projection → eye (eq. 12), all others along light → centre → eye (eq. 13). The
//! homogeneous share is [`sun2005`] times C_sv (eqs. 15–17).
//!
//! Errata applied: cos γ towards the light (8); β₀ along light → centre → eye in eq. 13 (10);
//! exponents added before exponentiating (11); projection clamped to the ray (13); dot and cross
//! products for eq. 31 (14). Ours: with an orthographic camera, which has no single eye, a blob's
//! eye is the point of the camera's plane straight in front of it.
//!
//! Against the exact integral the approximation is off by 5–30 % at the median, and by several
//! times next to a light close to a blob.

mod centers;
mod lanes;

pub use centers::depths;
pub use lanes::{LightRow, LitBlobs, Reach, add_airlight};

use super::about::{About, Exactness, PICTURES, Takes};
use super::sun2005;
use crate::geometry::{Beyond, Origin, Ray, parts::without};
use crate::light::{Beam, Source, least_distance};
use crate::media::gaussians::{Draw, Gaussian, Seen, draw_of};
use crate::media::{Field, Medium, Term};
use crate::num::Num;
use crate::progress::{Interrupted, Progress};
use crate::vector::V3;
use glam::DVec3;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// What is said about it.
pub const ABOUT: About = About {
    source: "Zhou, Hou, Gong, Snyder, Guo, Shum: Fogshop (Pacific Graphics 2007): analytic \
        approximation of single scattering in a sum of Gaussians.",
    takes: Some(Takes {
        name: "fogshop2007",
        what: "homogeneous fog, gaussians and emitters",
        term: takes,
        several: false,
    }),
    error: Exactness::measured(PICTURES, [0.036, 0.53, 1.4]),
};

/// Whether it takes a term.
pub fn takes(term: &Term) -> bool {
    sun2005::takes(term) || draw_of(term) == Some(Draw::Gaussian)
}

/// The blobs of a fog that this method takes.
pub fn blobs(field: &Field) -> &[Gaussian] {
    field.only().gaussians.all()
}

/// The extinction of what is the same everywhere in it [1/m].
pub fn haze(field: &Field) -> f64 {
    field.only().homogeneous.uniform_beta().unwrap_or_default()
}

/// Where view rays start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Eye {
    /// All in one point.
    Point(DVec3),
    /// On a plane through this point, all in this unit direction.
    Plane(DVec3, DVec3),
}

impl Eye {
    /// Whether rays from both see the same, but for rounding.
    pub fn is_same(&self, other: &Self) -> bool {
        match (*self, *other) {
            (Self::Point(a), Self::Point(b)) => a == b,
            (Self::Plane(a, direction), Self::Plane(b, other)) => {
                let apart = (a - b).dot(direction).abs();
                direction == other && apart <= 1e-12 * (a.length() + b.length())
            }
            _ => false,
        }
    }

    /// Where the ray starts that looks at `point`.
    pub fn facing(&self, point: DVec3) -> DVec3 {
        match *self {
            Self::Point(eye) => eye,
            Self::Plane(on, direction) => point - (point - on).dot(direction) * direction,
        }
    }
}

/// A blob and a light, relative to the eye: what eq. 12 and 13 need of them.
#[derive(Clone, Copy, Debug)]
pub struct Lit<N> {
    /// a · (centre − light), without unit.
    pub from_light: V3<N>,
    /// Exponent of f¹ (eq. 13) with the blob's own two depths taken out again (eq. 12).
    pub exponent: N,
    /// The cone into which the light shines, if it is one.
    pub beam: Option<Beam>,
}

/// Line integrals of one ray through one blob.
#[derive(Clone, Copy, Debug)]
pub struct Crossing<N> {
    /// T_i(v, p).
    pub depth: N,
    /// T_i(v, b_i^r).
    before: N,
    /// a · (b_i^r − centre).
    aside: V3<N>,
    /// Squared distance of b_i^r from the centre in units of the radius.
    aside2: N,
}

impl<N: Num> Crossing<N> {
    /// Follows a ray through a blob; without `TAILS` the depth is off by up to 3e-6 · k in f32
    /// lanes.
    #[inline(always)]
    pub fn new<const TAILS: bool>(blob: &Seen<N>, direction: V3<N>, length: N) -> Self {
        let zero = length.lit(0.0);
        let line = blob.line(direction, length);
        let density = blob.k * line.peak;
        let (start, end) = (line.start.erf(), line.end.erf());
        let at = (-line.start).max(zero).min(line.end - line.start);
        let shift = at + line.start;
        let between = if TAILS { N::erf_difference(line.start, line.end) } else { end - start };
        Self {
            depth: density * between,
            before: density * (end.min(zero) - start.min(zero)),
            aside: direction.scale(at) - blob.b,
            aside2: shift.mul_add(shift, line.miss2),
        }
    }

    /// Follows a ray through a blob in which it neither starts nor ends.
    #[inline(always)]
    pub fn whole(blob: &Seen<N>, direction: V3<N>) -> Self {
        let miss2 = blob.b.cross(direction).length_squared();
        let before = blob.k * (-miss2).exp();
        let aside = direction.scale(blob.b.dot(direction)) - blob.b;
        Self { depth: before + before, before, aside, aside2: miss2 }
    }

    /// L_i per unit of ω·I₀/(4π) [1/m²] (eq. 11).
    #[inline(always)]
    pub fn scattered(&self, blob: &Seen<N>, lit: &Lit<N>, floor: N) -> N {
        // The way from the light to b_i^r: as a sum of vectors it keeps a small distance's digits.
        let way = lit.from_light + self.aside;
        let distance2 = way.length_squared().max((blob.a * floor).squared());
        let distance = distance2.sqrt();
        let inverse = floor.lit(1.0) / distance;
        // Its ends, counted from its point closest to the centre.
        let end = self.aside.dot(way) * inverse;
        let start = end - distance;
        let miss2 = (self.aside2 - end.squared()).max(floor.lit(0.0));
        let own = blob.k * (-miss2).exp() * N::erf_plain_difference(start, end);
        let falloff = (blob.a * inverse).squared();
        let seen = self.depth * (lit.exponent - own - self.before).exp() * falloff;
        // Ours: a cone lights as much of a blob as of its centre on the ray.
        match lit.beam {
            Some(beam) => seen * beam.weight(way.scale(inverse)),
            None => seen,
        }
    }
}

/// What the published method knows of one light before any ray: f¹ of every blob and C_sv.
#[derive(Clone, Debug)]
pub struct LightSide {
    /// Exponent of [`Lit`] for each blob of the field.
    pub exponents: Vec<f64>,
    /// C_sv (eq. 16).
    pub homogeneous_factor: f64,
}

impl LightSide {
    /// From the depths T(v, b) and T(s, b) of all blobs' own centres, without homogeneous part.
    pub fn new(field: &Field, eye: Eye, light: Source, to_eye: &[f64], to_light: &[f64]) -> Self {
        let blobs = blobs(field).par_iter().zip(to_eye).zip(to_light);
        let exponents = blobs.map(|((blob, to_eye), to_light)| {
            exponent(field, blob, (eye, *to_eye), (light, *to_light))
        });
        let homogeneous_factor = homogeneous_factor(field, eye, light);
        Self { exponents: exponents.collect(), homogeneous_factor }
    }
}

/// Exponent of [`Lit`] for a blob, from T(v, b) and T(s, b) to its centre.
fn exponent(
    field: &Field,
    blob: &Gaussian,
    (eye, to_eye): (Eye, f64),
    (light, to_light): (Source, f64),
) -> f64 {
    let from = eye.facing(blob.center);
    let lit_from = outlook(field, light).facing(blob.center);
    let (d_eye, d_light) = (from.distance(blob.center), lit_from.distance(blob.center));
    let hazy = match light.origin() {
        Origin::At(_) => d_light,
        Origin::Beyond(beyond) => beyond.path_m,
    };
    // The blob's own part of a path that ends at its centre: half depth times erf.
    let own = |d: f64| blob.half_depth() * libm::erf(blob.a * d);
    own(d_eye) + own(d_light) - to_eye - to_light - haze(field) * (d_eye + hazy)
}

/// C_sv (eq. 16); 0 where there is no homogeneous fog for it.
fn homogeneous_factor(field: &Field, eye: Eye, light: Source) -> f64 {
    if haze(field) == 0.0 {
        return 0.0;
    }
    let (from, to) = match (light.apex(), eye) {
        (Some(apex), _) => (apex, eye.facing(apex)),
        (None, Eye::Point(eye) | Eye::Plane(eye, _)) => (outlook(field, light).facing(eye), eye),
    };
    let (ray, distance) = Ray::between(from, to);
    (-field.only().gaussians.depth_nearby(&ray, distance)).exp()
}

/// Where the ways of a light to blobs begin: of the sun on a plane behind which there are none.
pub fn outlook(field: &Field, light: Source) -> Eye {
    match light.origin() {
        Origin::At(apex) => Eye::Point(apex),
        Origin::Beyond(Beyond { toward, .. }) => {
            Eye::Plane(toward * field.reach(DVec3::ZERO), -toward)
        }
    }
}

/// T without homogeneous part from a start to a blob's centre, to rounding.
pub fn depth_to_center(field: &Field, start: DVec3, center: DVec3) -> f64 {
    let (ray, length) = Ray::between(start, center);
    field.only().gaussians.depth_nearby(&ray, length)
}

/// T without homogeneous part from where paths start to blobs' centres, to rounding: those that have
/// been asked for. A ray asks for the blobs that it meets, which are few among many; so no ray takes as
/// many sums as there are pairs of blobs.
#[derive(Debug)]
pub struct CenterDepths {
    eye: Eye,
    /// Bits of depths, blob by blob; of a NaN while nobody has asked.
    depths: Vec<AtomicU64>,
}

impl CenterDepths {
    /// None of them yet.
    pub fn new(field: &Field, eye: Eye) -> Self {
        let unasked = |_: &Gaussian| AtomicU64::new(f64::NAN.to_bits());
        Self { eye, depths: blobs(field).iter().map(unasked).collect() }
    }

    /// The depths to some blobs, by their places.
    ///
    /// # Errors
    /// [`Interrupted`] when `progress` says so.
    pub fn get(
        &self,
        field: &Field,
        places: &[usize],
        progress: &Progress,
    ) -> Result<Vec<f64>, Interrupted> {
        let depth = |place: &usize| {
            // Two threads may form the same number at once; it is the same.
            let known = f64::from_bits(self.depths[*place].load(Ordering::Relaxed));
            if !known.is_nan() {
                return Ok(known);
            }
            progress.check()?;
            let center = blobs(field)[*place].center;
            let depth = depth_to_center(field, self.eye.facing(center), center);
            self.depths[*place].store(depth.to_bits(), Ordering::Relaxed);
            Ok(depth)
        };
        places.par_iter().map(depth).collect()
    }

    /// Bytes that they take.
    pub fn bytes(&self) -> usize {
        size_of_val(self.depths.as_slice())
    }
}

/// A ray in f64 with all that the published method asks about its blobs but the lights.
#[derive(Debug)]
pub struct Sighted {
    ray: Ray,
    length: f64,
    /// Blobs that it meets, to rounding.
    places: Vec<usize>,
    eye: Eye,
    /// T(v, b) of each.
    to_eye: Vec<f64>,
}

impl Sighted {
    /// A ray up to `length` [m], as one of those that start where `from_eye` does.
    ///
    /// # Errors
    /// [`Interrupted`] when `progress` says so.
    pub fn new(
        field: &Field,
        from_eye: &CenterDepths,
        (ray, length): (Ray, f64),
        progress: &Progress,
    ) -> Result<Self, Interrupted> {
        let places = field.only().gaussians.on_ray(&ray, length);
        let to_eye = from_eye.get(field, &places, progress)?;
        Ok(Self { ray, length, places, eye: from_eye.eye, to_eye })
    }

    /// L_a per unit of ω·I₀ [1/m²] of a light that does not reach some parts of the ray [m].
    ///
    /// # Errors
    /// [`Interrupted`] when `progress` says so.
    pub fn airlight(
        &self,
        field: &Field,
        light: Source,
        from_light: &CenterDepths,
        shadows: &[[f64; 2]],
        progress: &Progress,
    ) -> Result<f64, Interrupted> {
        let Self { ray: Ray { origin, direction }, length, .. } = *self;
        let parts = without([0.0, length], shadows);
        let is_lit = |t: f64| parts.iter().any(|[from, to]| *from <= t && t <= *to);
        let at = light.place();
        let floor = least_distance(at.distance(origin));
        let ray = V3::from(direction);
        let to_light = from_light.get(field, &self.places, progress)?;
        let depths = self.to_eye.iter().zip(to_light);
        let blobs = self.places.iter().zip(depths).map(|(place, (to_eye, to_light))| {
            let blob = &blobs(field)[*place];
            let seen = blob.seen_from(origin);
            let from_light = V3::from((blob.center - at) * blob.a);
            let exponent = exponent(field, blob, (self.eye, *to_eye), (light, to_light));
            // Ours: a blob is lit as its centre on the ray is.
            if !is_lit((blob.center - origin).dot(direction).clamp(0.0, length)) {
                return 0.0;
            }
            let lit = Lit { from_light, exponent, beam: light.beam() };
            Crossing::new::<true>(&seen, ray, length).scattered(&seen, &lit, floor)
        });
        let (to, cone) = (light.beside(origin.into(), ray), light.crossed(origin.into(), ray));
        let of_part =
            |ends: &[f64; 2]| sun2005::within(haze(field), light, to, cone.as_ref(), *ends);
        let homogeneous = homogeneous_factor(field, self.eye, light)
            * parts.iter().map(of_part).fold(0.0, |a, b| a + b);
        Ok(homogeneous + blobs.sum::<f64>() / (4.0 * std::f64::consts::PI))
    }
}
