//! Media in closed form: whoever answers β at a point, and its mean between two, is a medium. T is the length
//! times that mean, along a ray, to a light and at the knots of a grid alike.
//!
//! All is asked relative to where rays start, so that differences keep their digits.

use super::places::Places;
use super::{
    Along, Legs, Lumps, Medium, Near, OPAQUE_DEPTH, OnRays, PatchCone, Patched, Purpose, Search,
    Smooth, Ways, Words,
};
use crate::geometry::batch::{Rays, Row, SIZE, load3};
use crate::geometry::control::{Control, Each, PADDED};
use crate::geometry::{Beyond, Origin, Ray};
use crate::num::{Lanes, Num};
use crate::progress::Job;
use crate::vector::V3;
use fearless_simd::{Level, Simd, dispatch};
use glam::{DVec3, Vec3};
use std::fmt::Debug;

/// What a medium in closed form answers.
pub trait Closed: Clone + Debug + Send + Sync + 'static {
    /// Whether it is nothing at all.
    fn is_nothing(&self) -> bool;

    /// The same, seen from another origin.
    #[must_use]
    fn seen_from(&self, origin: DVec3) -> Self;

    /// Terms that a sum has: what β at a point costs.
    fn count(&self) -> usize;

    /// What the mean along a way costs, in such terms: of what has cells, those that it passes count.
    fn cost(&self, _way: DVec3) -> usize {
        self.count()
    }

    /// β at a point [1/m].
    fn at<N: Num>(&self, x: V3<N>) -> N;

    /// The mean of β between two points [1/m].
    fn mean<N: Num>(&self, a: V3<N>, b: V3<N>) -> N;

    /// The same as view rays see it, which begin at the first point.
    #[inline(always)]
    fn view_mean<N: Num>(&self, a: V3<N>, b: V3<N>) -> N {
        self.mean(a, b)
    }

    /// T from a point to beyond everything: as far as it reaches, or as what has no end counts.
    #[inline(always)]
    fn beyond<N: Num>(&self, x: V3<N>, beyond: &Beyond) -> N {
        let way = V3::lit(x.x, beyond.path_m * beyond.toward);
        self.mean(x, x + way) * x.x.lit(beyond.path_m)
    }

    /// Whether view rays see it otherwise than lights do.
    fn is_cut(&self) -> bool {
        false
    }

    /// The same, seen by view rays as by lights.
    #[must_use]
    fn whole(&self) -> Self {
        self.clone()
    }

    /// The same for those who ask no more once that much optical depth lies behind, which then may stay short of the
    /// truth.
    #[must_use]
    fn until(&self, _depth: f64) -> Self {
        self.clone()
    }

    /// The least β anywhere [1/m].
    fn least_beta(&self) -> f64;

    /// The largest β anywhere [1/m].
    fn most_beta(&self) -> f64;

    /// β [1/m] if it is the same everywhere.
    fn uniform(&self) -> Option<f64>;

    /// Tells ray parameters at which β, or its slope, jumps [m]: always as many, in the same order. What a ray does
    /// not pass lies behind its start.
    fn jumps(&self, start: DVec3, direction: DVec3, edge: &mut dyn FnMut(f64));

    /// From where to where there is any of it on a ray from the origin [m].
    fn extent(&self, direction: DVec3, length_m: f64) -> Option<(f64, f64)>;

    /// Whether it changes between its edges so fast that quadratures must know.
    fn is_rippled(&self) -> bool {
        false
    }

    /// The finest length over which it does between two parameters of a ray from the origin [m].
    fn ripple_m(&self, _direction: DVec3, _from: f64, _to: f64) -> f64 {
        f64::INFINITY
    }

    /// Tells further ray parameters at which it jumps or kinks on a ray from the origin [m]: those that are too many
    /// for pictures.
    fn borders(&self, _direction: DVec3, _length_m: f64, _edge: &mut dyn FnMut(f64)) {}

    /// What its shader reads, seen from the camera; what has no fixed length goes to a list of numbers.
    fn words(&self, numbers: &mut Vec<f32>) -> Vec<Words>;

    /// Bytes that it takes besides its own, near enough.
    fn size(&self) -> usize;

    /// See [`Medium::places`].
    fn places(&self, _places: &mut Places) -> bool {
        self.is_nothing()
    }
}

impl<C: Closed> Medium for C {
    fn is_empty(&self) -> bool {
        self.is_nothing()
    }

    fn uniform_beta(&self) -> Option<f64> {
        self.uniform()
    }

    fn is_rippled(&self) -> bool {
        Closed::is_rippled(self)
    }

    fn beta(&self, x: DVec3) -> f64 {
        self.at(x.into())
    }

    fn depth(&self, ray: &Ray, length_m: f64) -> f64 {
        OnRay::new(self, ray, length_m).depth(length_m)
    }

    fn depth_beyond(&self, x: DVec3, beyond: &Beyond) -> f64 {
        Closed::seen_from(self, x).beyond(V3::from(DVec3::ZERO), beyond)
    }

    fn along(&self, ray: &Ray, length_m: f64) -> Box<dyn Along> {
        Box::new(OnRay::new(self, ray, length_m))
    }

    fn ways(&self, origin: Origin, ends: [DVec3; 2]) -> Box<dyn Ways> {
        match origin {
            Origin::At(apex) => {
                let medium = Closed::seen_from(self, apex);
                let cost = ends.map(|end| medium.cost(end - apex)).into_iter().max().unwrap_or(0);
                Box::new(FromApex { medium, apex, cost })
            }
            Origin::Beyond(beyond) => {
                let medium = Closed::seen_from(self, ends[0]);
                let cost = medium.cost(beyond.path_m * beyond.toward);
                Box::new(FromBeyond { medium, origin: ends[0], beyond, cost })
            }
        }
    }

    fn near(&self, _level: Level, search: &Search) -> Box<dyn Near> {
        let seen = Closed::seen_from(self, search.bundle.origin);
        Box::new(if search.purpose == Purpose::Sight { seen.until(OPAQUE_DEPTH) } else { seen })
    }

    fn smooth(&self, origin: DVec3, legs: Legs) -> Option<Box<dyn Smooth>> {
        let seen = Closed::seen_from(self, origin);
        Some(Box::new(if legs == Legs::OfLights { seen.whole() } else { seen }))
    }

    fn least(&self, length_m: f64) -> f64 {
        self.least_beta().max(0.0) * length_m
    }

    fn is_in_shaders(&self) -> bool {
        true
    }

    fn places(&self, places: &mut Places) -> bool {
        Closed::places(self, places)
    }

    fn rows(&self, camera: DVec3, numbers: &mut Vec<f32>) -> Option<Vec<Words>> {
        Some(Closed::seen_from(self, camera).words(numbers))
    }

    fn bytes(&self) -> usize {
        self.size()
    }
}

/// Along one ray, seen from where it starts.
#[derive(Debug)]
struct OnRay<C> {
    medium: C,
    direction: DVec3,
    length_m: f64,
    /// T at even places of the ray, which cost what they cost once.
    known: Vec<f64>,
}

impl<C: Closed> OnRay<C> {
    fn new(medium: &C, ray: &Ray, length_m: f64) -> Self {
        /// Terms between two places; and most places.
        const BETWEEN: usize = 64;
        const MOST: usize = 4096;
        let medium = Closed::seen_from(medium, ray.origin);
        let mut on_ray = Self { medium, direction: ray.direction, length_m, known: vec![0.0] };
        let parts = (on_ray.medium.cost(length_m * ray.direction) / BETWEEN).min(MOST);
        // What is seen up to a share of a ray's own length does not add up from part to part.
        if parts > on_ray.medium.count() && !on_ray.medium.is_cut() {
            let at = |i: usize| length_m * i as f64 / parts as f64;
            let mut sum = 0.0;
            for i in 0..parts {
                sum += on_ray.between(at(i), at(i + 1));
                on_ray.known.push(sum);
            }
        }
        on_ray
    }

    /// T between two ray parameters.
    fn between(&self, from: f64, to: f64) -> f64 {
        let [a, b] = [from, to].map(|t| t * self.direction);
        (to - from) * self.medium.view_mean::<f64>(a.into(), b.into())
    }
}

impl<C: Closed> Along for OnRay<C> {
    fn terms(&self) -> usize {
        // From a known place on a call passes a part of what there is.
        self.medium.cost(self.length_m * self.direction) / self.known.len()
    }

    fn is_smooth(&self) -> bool {
        !Closed::is_rippled(&self.medium)
    }

    fn beta(&self, t: f64) -> f64 {
        self.medium.at((t * self.direction).into())
    }

    fn depth(&self, t: f64) -> f64 {
        let parts = self.known.len() - 1;
        if parts == 0 {
            return self.between(0.0, t);
        }
        let place = t / self.length_m * parts as f64;
        let i = (place.max(0.0) as usize).min(parts - 1);
        self.known[i] + self.between(self.length_m * i as f64 / parts as f64, t)
    }

    fn span(&self) -> Option<(f64, f64)> {
        if self.length_m <= 0.0 {
            return None;
        }
        self.medium.extent(self.direction, self.length_m)
    }

    fn finest_m(&self, from: f64, to: f64) -> f64 {
        self.medium.ripple_m(self.direction, from, to)
    }

    fn edges(&self) -> Vec<f64> {
        let mut edges = Vec::new();
        self.medium.jumps(DVec3::ZERO, self.direction, &mut |t| edges.push(t));
        self.medium.borders(self.direction, self.length_m, &mut |t| edges.push(t));
        edges
    }
}

/// Between a point, from which it is seen, and others.
#[derive(Debug)]
struct FromApex<C> {
    medium: C,
    apex: DVec3,
    /// What the longest way costs.
    cost: usize,
}

impl<C: Closed> Ways for FromApex<C> {
    fn terms(&self) -> usize {
        self.cost
    }

    fn depth_to(&self, point: DVec3) -> f64 {
        let way = point - self.apex;
        way.length() * self.medium.mean(DVec3::ZERO.into(), way.into())
    }
}

/// Between beyond everything and points, seen from one of them.
#[derive(Debug)]
struct FromBeyond<C> {
    medium: C,
    origin: DVec3,
    beyond: Beyond,
    /// What a way costs.
    cost: usize,
}

impl<C: Closed> Ways for FromBeyond<C> {
    fn terms(&self) -> usize {
        self.cost
    }

    fn depth_to(&self, point: DVec3) -> f64 {
        self.medium.beyond((point - self.origin).into(), &self.beyond)
    }
}

impl<C: Closed> Near for C {
    fn add_depth(&self, job: &Job, rays: &Rays, _parallel: bool, length: &Row, depth: &mut Row) {
        dispatch!(job.level, simd => add_depth(simd, self, rays, length, depth));
    }

    fn patched(&self) -> Box<dyn Patched> {
        Box::new(self.clone())
    }
}

impl<C: Closed> Smooth for C {
    fn add_mean(&self, level: Level, apex: Vec3, rays: &Control, t: &[Each], mean: &mut [Each]) {
        dispatch!(level, simd => add_mean(simd, self, apex, rays, t, mean));
    }

    fn add_beyond(&self, level: Level, beyond: &Beyond, points: [&[f32]; 3], depth: &mut [f32]) {
        dispatch!(level, simd => add_beyond(simd, self, beyond, points, depth));
    }

    fn span(&self, start: DVec3, direction: DVec3, length_m: f64) -> Option<(f64, f64)> {
        if start == DVec3::ZERO {
            return self.extent(direction, length_m);
        }
        Closed::seen_from(self, start).extent(direction, length_m)
    }

    fn edges(&self, start: Vec3, direction: Vec3, edges: &mut Vec<f32>) {
        self.jumps(start.as_dvec3(), direction.as_dvec3(), &mut |t| edges.push(t as f32));
    }
}

impl<C: Closed> Patched for C {
    fn terms(&self) -> usize {
        self.count()
    }

    fn within(&self, _cone: &PatchCone, _lumps: &mut Lumps) -> Box<dyn Patched> {
        Box::new(self.clone())
    }

    fn haze(&self, cone: &PatchCone, length: f32) -> f32 {
        let (start, way) = (cone.offset.as_dvec3(), f64::from(length) * cone.axis.as_dvec3());
        length * self.view_mean::<f64>(start.into(), (start + way).into()) as f32
    }

    fn on_rays(&self, _: Level, rays: &Control, _parallel: bool, _: f32) -> Box<dyn OnRays> {
        Box::new(OnSixteen { medium: self.clone(), rays: rays.clone() })
    }
}

/// On sixteen rays.
#[derive(Debug)]
struct OnSixteen<C> {
    medium: C,
    rays: Control,
}

impl<C: Closed> OnRays for OnSixteen<C> {
    fn is_smooth(&self) -> bool {
        true
    }

    fn add(&self, level: Level, t: &[Each], beta: &mut [Each], depth: &mut [Each]) {
        dispatch!(level, simd => add_fields(simd, self, t, beta, depth));
    }

    fn most(&self, from: f32, to: f32) -> f32 {
        self.medium.most_beta() as f32 * (to - from)
    }

    fn span(&self) -> Option<(f32, f32)> {
        Some((0.0, f32::INFINITY))
    }

    fn hides_from(&self, from: f32, depth: f32) -> f32 {
        from + depth / self.medium.least_beta().max(0.0) as f32
    }

    fn edges(&self) -> Vec<Each> {
        let mut each = Vec::new();
        for c in 0..PADDED {
            let direction = Vec3::from_array([0, 1, 2].map(|k| self.rays.direction[k][c]));
            let mut own = Vec::new();
            Smooth::edges(&self.medium, self.rays.point(c, 0.0), direction, &mut own);
            each.resize(own.len(), [0.0; PADDED]);
            each.iter_mut().zip(own).for_each(|(row, t): (&mut Each, f32)| row[c] = t);
        }
        each
    }
}

/// The hull of some intervals.
pub fn hull<N: PartialOrd + Copy>(spans: impl Iterator<Item = (N, N)>) -> Option<(N, N)> {
    let lower = |a: N, b: N| if b < a { b } else { a };
    let upper = |a: N, b: N| if b > a { b } else { a };
    spans.reduce(|a, b| (lower(a.0, b.0), upper(a.1, b.1)))
}

/// Where a ray passes a plane that it moves away from by `climb` a metre and that lies `ahead` of its start
/// [m]; behind its start if it does not.
pub fn crossing(ahead: f64, climb: f64) -> f64 {
    let t = ahead / climb;
    // A level ray passes none.
    if t.is_finite() { t } else { -1.0 }
}

/// Adds T along a batch of rays.
#[inline(always)]
fn add_depth<S: Simd, C: Closed>(simd: S, medium: &C, rays: &Rays, length: &Row, depth: &mut Row) {
    for at in (0..SIZE).step_by(Lanes::<S>::COUNT) {
        let (start, length) = (load3(simd, &rays.offset, at), Lanes::load(simd, &length[at..]));
        let end = along(start, load3(simd, &rays.direction, at), length);
        let before = Lanes::load(simd, &depth[at..]);
        length.mul_add(medium.view_mean(start, end), before).store(&mut depth[at..]);
    }
}

/// Adds the mean of β between a light and points of rays.
#[inline(always)]
fn add_mean<S: Simd, C: Closed>(
    simd: S,
    medium: &C,
    apex: Vec3,
    rays: &Control,
    t: &[Each],
    mean: &mut [Each],
) {
    let apex = V3::splat(simd, apex.to_array());
    for (mean, t) in mean.iter_mut().zip(t) {
        for at in (0..PADDED).step_by(Lanes::<S>::COUNT) {
            let start = load3(simd, &rays.offset, at);
            let direction = load3(simd, &rays.direction, at);
            let point = along(start, direction, Lanes::load(simd, &t[at..]));
            let before = Lanes::load(simd, &mean[at..]);
            (medium.mean(apex, point) + before).store(&mut mean[at..]);
        }
    }
}

/// Adds T from points to beyond everything.
#[inline(always)]
fn add_beyond<S: Simd, C: Closed>(
    simd: S,
    medium: &C,
    beyond: &Beyond,
    [x, y, z]: [&[f32]; 3],
    depth: &mut [f32],
) {
    for at in (0..depth.len()).step_by(Lanes::<S>::COUNT) {
        let load = |row: &[f32]| Lanes::load(simd, &row[at..]);
        let point = V3::new(load(x), load(y), load(z));
        let before = Lanes::load(simd, &depth[at..]);
        (medium.beyond(point, beyond) + before).store(&mut depth[at..]);
    }
}

/// Adds β, if there are rows for it, and T at ray parameters `t`.
#[inline(always)]
fn add_fields<S: Simd, C: Closed>(
    simd: S,
    on_rays: &OnSixteen<C>,
    t: &[Each],
    beta: &mut [Each],
    depth: &mut [Each],
) {
    let OnSixteen { medium, rays } = on_rays;
    for (k, (t, depth)) in t.iter().zip(depth).enumerate() {
        for at in (0..PADDED).step_by(Lanes::<S>::COUNT) {
            let (t, start) = (Lanes::load(simd, &t[at..]), load3(simd, &rays.offset, at));
            let point = along(start, load3(simd, &rays.direction, at), t);
            if let Some(beta) = beta.get_mut(k) {
                (medium.at(point) + Lanes::load(simd, &beta[at..])).store(&mut beta[at..]);
            }
            let before = Lanes::load(simd, &depth[at..]);
            t.mul_add(medium.view_mean(start, point), before).store(&mut depth[at..]);
        }
    }
}

/// A point of a ray.
#[inline(always)]
fn along<N: Num>(start: V3<N>, direction: V3<N>, t: N) -> V3<N> {
    V3::new(
        t.mul_add(direction.x, start.x),
        t.mul_add(direction.y, start.y),
        t.mul_add(direction.z, start.z),
    )
}
