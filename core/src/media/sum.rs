//! The sum of all media: what callers see as one.

use super::closed::hull;
use super::gaussians::{Blobs, Gaussian, Pruning};
use super::groups::groups;
use super::places::Places;
use super::{
    Along, Legs, Lumps, Media, Medium, Moment, Near, OnRays, Outline, PatchCone, Patched, Purpose,
    Search, Smooth, Term, Ways,
};
use crate::geometry::batch::{Rays, Row};
use crate::geometry::bundle::Bundle;
use crate::geometry::control::{Control, Each, PADDED};
use crate::geometry::{Beyond, Origin, Ray};
use crate::num::{Lanes, Num};
use crate::progress::Job;
use fearless_simd::{Level, Simd, dispatch};
use glam::{DVec3, Vec3};
use std::hash::{DefaultHasher, Hasher};

/// The extinction of a scene as one channel meets it: the sum of its enabled terms, those that scatter
/// alike as one group.
#[derive(Debug)]
pub struct Field {
    /// At least one, which may be empty.
    groups: Vec<Media>,
}

/// Several media, seen in one way; they add up. Beside each, the group that it belongs to.
#[derive(Debug)]
pub struct Sum<T: ?Sized>(Vec<(usize, Box<T>)>);

/// Σ, which is never −0.
fn total(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |a, b| a + b)
}

impl Field {
    /// The field of some terms, as a channel meets it at a moment: 0 is red, 2 blue.
    pub fn new(terms: &[Term], channel: usize, moment: &Moment) -> Self {
        let groups = groups(terms).into_iter().map(|terms| Media::new(&terms, channel, moment));
        let mut groups: Vec<_> = groups.collect();
        if groups.is_empty() {
            groups.push(Media::default());
        }
        Self { groups }
    }

    /// The same with fewer blobs far from the eye, so that the mean optical depth is off by no more than a share of
    /// itself; `None` where all stay.
    pub fn pruned(&self, eye: DVec3, error: f64) -> Option<Self> {
        let pruning = Pruning::new(self.blobs(), eye, error)?;
        let group = |media: &Media| Media {
            gaussians: Blobs::new(pruning.of(media.gaussians.all())),
            ..media.clone()
        };
        Some(Self { groups: self.groups.iter().map(group).collect() })
    }

    /// All Gaussians, for what is about them.
    pub fn blobs(&self) -> impl Iterator<Item = &Gaussian> {
        self.groups.iter().flat_map(|media| media.gaussians.all())
    }

    /// The groups, for methods that are about one medium.
    pub fn groups(&self) -> &[Media] {
        &self.groups
    }

    /// The media of a fog whose terms all scatter alike.
    pub fn only(&self) -> &Media {
        &self.groups[0]
    }

    /// All media that are there, group by group.
    fn each(&self) -> impl Iterator<Item = (usize, &dyn Medium)> {
        let groups = self.groups.iter().enumerate();
        let media = groups.flat_map(|(group, media)| media.each().map(move |one| (group, one)));
        media.filter(|(_, medium)| !medium.is_empty())
    }

    /// Whether there is nothing at all.
    pub fn is_empty(&self) -> bool {
        self.each().next().is_none()
    }

    /// β₀ [1/m] if the fog is the same everywhere.
    pub fn uniform_beta(&self) -> Option<f64> {
        self.groups.iter().flat_map(Media::each).map(Medium::uniform_beta).sum()
    }

    /// The most that a single lump weighs on any ray.
    pub fn heaviest(&self) -> f64 {
        self.each().map(|(_, medium)| medium.heaviest()).fold(0.0, f64::max)
    }

    /// Whether it changes in places so fast that only differences of T tell what is there.
    pub fn is_rippled(&self) -> bool {
        self.each().any(|(_, medium)| medium.is_rippled())
    }

    /// No lump lies farther from a point than this [m].
    pub fn reach(&self, from: DVec3) -> f64 {
        self.each().map(|(_, medium)| medium.reach(from)).fold(0.0, f64::max)
    }

    /// How many lumps there are.
    pub fn lumps(&self) -> usize {
        self.groups.iter().flat_map(Media::each).map(Medium::lumps).sum()
    }

    /// β(x) [1/m].
    pub fn beta(&self, x: DVec3) -> f64 {
        total(self.each().map(|(_, medium)| medium.beta(x)))
    }

    /// T along a ray of that length [m]; nothing left out.
    pub fn depth(&self, ray: &Ray, length_m: f64) -> f64 {
        total(self.each().map(|(_, medium)| medium.depth(ray, length_m)))
    }

    /// T between two points.
    pub fn depth_between(&self, from: DVec3, to: DVec3) -> f64 {
        let (ray, length_m) = Ray::between(from, to);
        self.depth(&ray, length_m)
    }

    /// T from where light comes from to a point: all of it, whatever view rays see.
    pub fn depth_from(&self, origin: Origin, to: DVec3) -> f64 {
        match origin {
            Origin::At(_) => self.ways(origin, [to; 2]).depth_to(to),
            Origin::Beyond(beyond) => {
                total(self.each().map(|(_, medium)| medium.depth_beyond(to, &beyond)))
            }
        }
    }

    /// All media, seen in one way.
    fn sum<T: ?Sized>(&self, see: impl Fn(&dyn Medium) -> Box<T>) -> Sum<T> {
        Sum(self.each().map(|(group, medium)| (group, see(medium))).collect())
    }

    /// The fog along one ray.
    pub fn along(&self, ray: &Ray, length_m: f64) -> Sum<dyn Along> {
        self.sum(|medium| medium.along(ray, length_m))
    }

    /// The fog between where light comes from and the points of a segment.
    pub fn ways(&self, origin: Origin, ends: [DVec3; 2]) -> Sum<dyn Ways> {
        self.sum(|medium| medium.ways(origin, ends))
    }

    /// What matters to the rays of a bundle, none of which is shorter than `shortest_m`.
    pub fn near(
        &self,
        level: Level,
        bundle: Bundle,
        shortest_m: f64,
        purpose: Purpose,
    ) -> Sum<dyn Near> {
        let search = |medium: &dyn Medium| self.search_for(medium, bundle, shortest_m, purpose);
        self.near_those(|_| true, level, search)
    }

    /// What matters of the lumps alone to ways from a light.
    pub fn near_lumps(
        &self,
        level: Level,
        bundle: Bundle,
        shortest_m: f64,
        purpose: Purpose,
    ) -> Sum<dyn Near> {
        let search = |medium: &dyn Medium| {
            let of_eyes = self.search_for(medium, bundle, shortest_m, purpose);
            Search { legs: Legs::OfLights, ..of_eyes }
        };
        self.near_those(|medium| medium.lumps() > 0, level, search)
    }

    /// The same of what is smooth alone.
    pub fn near_haze(
        &self,
        level: Level,
        bundle: Bundle,
        shortest_m: f64,
        purpose: Purpose,
    ) -> Sum<dyn Near> {
        let search = |medium: &dyn Medium| self.search_for(medium, bundle, shortest_m, purpose);
        self.near_those(|medium| medium.lumps() == 0, level, search)
    }

    fn near_those(
        &self,
        is_wanted: impl Fn(&dyn Medium) -> bool,
        level: Level,
        search: impl Fn(&dyn Medium) -> Search,
    ) -> Sum<dyn Near> {
        let wanted = self.each().filter(|(_, medium)| is_wanted(*medium));
        let near =
            |(group, medium): (usize, &dyn Medium)| (group, medium.near(level, &search(medium)));
        Sum(wanted.map(near).collect())
    }

    /// What is looked for of one medium around a bundle of view rays, beside all others.
    pub fn search_for(
        &self,
        medium: &dyn Medium,
        bundle: Bundle,
        shortest_m: f64,
        purpose: Purpose,
    ) -> Search {
        // Airlight comes from around the lumps and the lamps: there the others make up for what is left
        // out, not along the rest of a long ray.
        let along = match purpose {
            Purpose::Nodes if medium.lumps() > 0 => shortest_m.min(medium.reach(bundle.origin)),
            _ => shortest_m,
        };
        let others = self.each().filter(|(_, other)| !std::ptr::addr_eq(*other, medium));
        let sure = total(others.map(|(_, other)| other.least(along)));
        Search { bundle, shortest_m, purpose, legs: Legs::OfEyes, sure }
    }

    /// What is smooth, for rays from an origin.
    pub fn smooth(&self, origin: DVec3, legs: Legs) -> Sum<dyn Smooth> {
        Sum(self
            .each()
            .filter_map(|(group, medium)| Some((group, medium.smooth(origin, legs)?)))
            .collect())
    }

    /// What a table of T around a light must resolve.
    pub fn outline(&self, apex: DVec3) -> Outline {
        self.each().map(|(_, medium)| medium.outline(apex)).fold(Outline::default(), Outline::join)
    }

    /// Where a table over space must resolve it; `None` where no table can.
    pub fn places(&self) -> Option<Places> {
        let mut places = Places::default();
        let is_told = self.each().all(|(_, medium)| medium.places(&mut places));
        // Surfaces are lit beside it, too, and haze.
        (0..3).for_each(|axis| places.widen(axis));
        is_told.then_some(places)
    }

    /// Bytes that it takes besides its own, near enough.
    pub fn bytes(&self) -> usize {
        self.groups.iter().flat_map(Media::each).map(Medium::bytes).sum()
    }
}

impl Sum<dyn Along> {
    /// Terms that a sum has.
    pub fn terms(&self) -> usize {
        self.0.iter().map(|(_, medium)| medium.terms()).sum()
    }

    /// Lumps apart from what is smooth.
    pub fn parted(self) -> [Self; 2] {
        let (smooth, lumps) = self.0.into_iter().partition(|(_, medium)| medium.is_smooth());
        [Self(smooth), Self(lumps)]
    }

    /// The media of one group.
    fn of(&self, group: usize) -> impl Iterator<Item = &dyn Along> {
        let own = self.0.iter().filter(move |(own, _)| *own == group);
        own.map(|(_, medium)| medium.as_ref())
    }

    /// Terms that the sum over a group has.
    pub fn terms_of(&self, group: usize) -> usize {
        self.of(group).map(Along::terms).sum()
    }

    /// β [1/m] at the ray parameter `t` [m].
    pub fn beta(&self, t: f64) -> f64 {
        total(self.0.iter().map(|(_, medium)| medium.beta(t)))
    }

    /// The same of one group.
    pub fn beta_of(&self, group: usize, t: f64) -> f64 {
        total(self.of(group).map(|medium| medium.beta(t)))
    }

    /// T to the ray parameter `t` [m].
    pub fn depth(&self, t: f64) -> f64 {
        total(self.0.iter().map(|(_, medium)| medium.depth(t)))
    }

    /// The same of one group.
    pub fn depth_of(&self, group: usize, t: f64) -> f64 {
        total(self.of(group).map(|medium| medium.depth(t)))
    }

    /// From where to where there is any fog [m].
    pub fn span(&self) -> Option<(f64, f64)> {
        hull(self.0.iter().filter_map(|(_, medium)| medium.span()))
    }

    /// From where to where there is any fog of a group [m].
    pub fn span_of(&self, group: usize) -> Option<(f64, f64)> {
        hull(self.of(group).filter_map(Along::span))
    }

    /// The finest length over which it changes between two ray parameters [m].
    pub fn finest_m(&self, from: f64, to: f64) -> f64 {
        self.0.iter().map(|(_, medium)| medium.finest_m(from, to)).fold(f64::INFINITY, f64::min)
    }

    /// Ray parameters between two others where β, or its slope, jumps, in order [m].
    pub fn edges_between(&self, from: f64, to: f64) -> Vec<f64> {
        let edges = self.0.iter().flat_map(|(_, medium)| medium.edges());
        let mut edges: Vec<_> = edges.filter(|edge| from < *edge && *edge < to).collect();
        edges.sort_unstable_by(f64::total_cmp);
        edges
    }
}

impl Sum<dyn Ways> {
    /// Terms that a sum has.
    pub fn terms(&self) -> usize {
        self.0.iter().map(|(_, medium)| medium.terms()).sum()
    }

    /// T from there to a point of the segment.
    pub fn depth_to(&self, point: DVec3) -> f64 {
        total(self.0.iter().map(|(_, medium)| medium.depth_to(point)))
    }
}

impl<T: Near + ?Sized> Sum<T> {
    /// Adds T along every ray.
    pub fn add_depth(&self, job: &Job, rays: &Rays, parallel: bool, length: &Row, depth: &mut Row) {
        self.0.iter().for_each(|(_, near)| near.add_depth(job, rays, parallel, length, depth));
    }

    /// The same media for the few rays that stand for a patch.
    pub fn patched(&self) -> Sum<dyn Patched> {
        Sum(self.0.iter().map(|(group, near)| (*group, near.patched())).collect())
    }
}

impl Sum<dyn Smooth> {
    /// Adds T(x, s)/d between a light and points of rays.
    pub fn add_mean(
        &self,
        level: Level,
        apex: Vec3,
        rays: &Control,
        t: &[Each],
        mean: &mut [Each],
    ) {
        self.0.iter().for_each(|(_, smooth)| smooth.add_mean(level, apex, rays, t, mean));
    }

    /// Adds T from points to beyond everything.
    pub fn add_beyond(
        &self,
        level: Level,
        beyond: &Beyond,
        points: [&[f32]; 3],
        depth: &mut [f32],
    ) {
        self.0.iter().for_each(|(_, smooth)| smooth.add_beyond(level, beyond, points, depth));
    }

    /// Whether there is nothing.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Whether it has edges.
    pub fn has_edges(&self) -> bool {
        let mut edges = Vec::new();
        self.edges(Vec3::ZERO, Vec3::ONE, &mut edges);
        !edges.is_empty()
    }

    /// From where to where there is any of it on a ray from `start`, relative to the origin [m].
    pub fn span(&self, start: DVec3, direction: DVec3, length_m: f64) -> Option<(f64, f64)> {
        hull(self.0.iter().filter_map(|(_, smooth)| smooth.span(start, direction, length_m)))
    }

    /// Appends where β, or its slope, jumps on a ray [m].
    pub fn edges(&self, start: Vec3, direction: Vec3, edges: &mut Vec<f32>) {
        self.0.iter().for_each(|(_, smooth)| smooth.edges(start, direction, edges));
    }
}

impl Sum<dyn Patched> {
    /// Terms that a sum has.
    pub fn terms(&self) -> usize {
        self.0.iter().map(|(_, medium)| medium.terms()).sum()
    }

    /// A number that sums with other depths along rays hardly have; `None` where it cannot be told.
    pub fn fingerprint(&self) -> Option<u64> {
        let mut hasher = DefaultHasher::new();
        let is_told = self.0.iter().all(|(_, medium)| medium.tell(&mut hasher));
        is_told.then(|| hasher.finish())
    }

    /// What the rays of a smaller patch meet, and what its lumps come to beside the haze.
    pub fn within(&self, cone: &PatchCone) -> (Self, Lumps) {
        let mut lumps = Lumps::default();
        let each = self.0.iter();
        let within = each.map(|(group, medium)| (*group, medium.within(cone, &mut lumps)));
        let within = Self(within.collect());
        lumps.depth += within.haze_before(&lumps, cone);
        (within, lumps)
    }

    /// What its lumps around a smaller patch come to beside the haze.
    pub fn lumps(&self, cone: &PatchCone) -> Lumps {
        let mut lumps = Lumps::default();
        self.0.iter().for_each(|(_, medium)| medium.weigh(cone, &mut lumps));
        lumps.depth += self.haze_before(&lumps, cone);
        lumps
    }

    /// T of the haze up to the last lump: it hides what is missed of lumps, but not that behind them.
    fn haze_before(&self, lumps: &Lumps, cone: &PatchCone) -> f32 {
        let length = lumps.end.min(cone.longest);
        self.0.iter().map(|(_, medium)| medium.haze(cone, length)).sum()
    }

    /// Follows rays; without the lumps of which all meet less than the share `least`.
    pub fn on_rays(
        &self,
        level: Level,
        rays: &Control,
        parallel: bool,
        least: f32,
    ) -> Sum<dyn OnRays> {
        let on_rays = |(group, medium): &(usize, Box<dyn Patched>)| {
            (*group, medium.on_rays(level, rays, parallel, least))
        };
        Sum(self.0.iter().map(on_rays).collect())
    }
}

/// What rays meet, row by row.
#[derive(Clone, Debug)]
pub struct Profile {
    /// ln β of the group that scatters.
    pub log_beta: Vec<Each>,
    /// β of all others; no rows if there are none.
    pub other_beta: Vec<Each>,
    /// T from the start, of all.
    pub depth: Vec<Each>,
}

/// The same at the knots of a grid.
#[derive(Clone, Debug)]
pub struct Knotted {
    /// β and T of every group.
    pub groups: Vec<[Vec<Each>; 2]>,
    /// β of the lumps of all groups.
    pub lumps_beta: Vec<Each>,
    /// And T.
    pub lumps_depth: Vec<Each>,
    /// T of all.
    pub depth: Vec<Each>,
}

impl Sum<dyn OnRays> {
    /// β and T of every group and of all lumps, at ray parameters `t`, ascending from row to row.
    pub fn knotted(&self, level: Level, groups: usize, t: &[Each]) -> Knotted {
        let zero = vec![[0.0; PADDED]; t.len()];
        let mut fields = vec![[zero.clone(), zero]; groups];
        let mut add = |is_smooth: bool| {
            for (group, medium) in self.0.iter().filter(|(_, one)| one.is_smooth() == is_smooth) {
                let [beta, depth] = &mut fields[*group];
                medium.add(level, t, beta, depth);
            }
            let sum = |field: usize| sum_of(fields.iter().map(|fields| fields[field].as_slice()));
            [sum(0), sum(1)]
        };
        let [lumps_beta, lumps_depth] = add(false);
        let [_, depth] = add(true);
        Knotted { groups: fields, lumps_beta, lumps_depth, depth }
    }

    /// ln β of a group, and T, at ray parameters `t`, ascending from row to row.
    pub fn profile(&self, level: Level, group: usize, t: &[Each]) -> Profile {
        let zero = || vec![[0.0; PADDED]; t.len()];
        let (mut log_beta, mut depth) = (zero(), zero());
        let is_alone = self.0.iter().all(|(own, _)| *own == group);
        let mut other_beta = if is_alone { Vec::new() } else { zero() };
        self.each_lumps_first(|own, medium| {
            let beta = if own == group { &mut log_beta } else { &mut other_beta };
            medium.add(level, t, beta, &mut depth);
        });
        dispatch!(level, simd => logarithms(simd, &mut log_beta));
        Profile { log_beta, other_beta, depth }
    }

    /// β and T.
    pub fn fields(&self, level: Level, t: &[Each]) -> [Vec<Each>; 2] {
        self.fields_of(level, t, |_| true)
    }

    /// T alone, which costs half.
    pub fn depth(&self, level: Level, t: &[Each]) -> Vec<Each> {
        let mut depth = vec![[0.0; PADDED]; t.len()];
        self.each_lumps_first(|_, medium| medium.add(level, t, &mut [], &mut depth));
        depth
    }

    /// β and T of what is smooth.
    pub fn haze(&self, level: Level, t: &[Each]) -> [Vec<Each>; 2] {
        self.fields_of(level, t, |medium| medium.is_smooth())
    }

    /// T of what is smooth, to one place of the first ray.
    pub fn haze_to(&self, level: Level, t: f32) -> f32 {
        self.haze(level, &[[t; PADDED]])[1][0][0]
    }

    fn fields_of(
        &self,
        level: Level,
        t: &[Each],
        is_wanted: impl Fn(&dyn OnRays) -> bool,
    ) -> [Vec<Each>; 2] {
        let zero = vec![[0.0; PADDED]; t.len()];
        let (mut beta, mut depth) = (zero.clone(), zero);
        self.each_lumps_first(|_, medium| {
            if is_wanted(medium) {
                medium.add(level, t, &mut beta, &mut depth);
            }
        });
        [beta, depth]
    }

    /// All media with their groups, lumps first: many small numbers lose digits on top of a large one.
    fn each_lumps_first(&self, mut visit: impl FnMut(usize, &dyn OnRays)) {
        for is_smooth in [false, true] {
            let own = self.0.iter().filter(|(_, medium)| medium.is_smooth() == is_smooth);
            own.for_each(|(group, medium)| visit(*group, medium.as_ref()));
        }
    }

    /// From where to where there is any fog of a group on rays up to `length` [m]; `None` if there is
    /// none.
    pub fn span_of(&self, group: usize, length: f32) -> Option<(f32, f32)> {
        self.within(length, |own, _| own == group)
    }

    /// The same of the lumps of all groups.
    pub fn dense(&self, length: f32) -> Option<(f32, f32)> {
        self.within(length, |_, medium| !medium.is_smooth())
    }

    fn within(
        &self,
        length: f32,
        is_wanted: impl Fn(usize, &dyn OnRays) -> bool,
    ) -> Option<(f32, f32)> {
        let wanted = self.0.iter().filter(|(group, medium)| is_wanted(*group, medium.as_ref()));
        let (from, to) = hull(wanted.filter_map(|(_, medium)| medium.span()))?;
        let (from, to) = (from.max(0.0), to.min(length));
        (from < to).then_some((from, to))
    }

    /// The smallest radius of the lumps that stand out between two ray parameters [m].
    pub fn finest(&self, from: f32, to: f32) -> f32 {
        /// Share of the fog around it from which on a lump stands out.
        const OUTSTANDING: f32 = 0.3;
        let all = self.0.iter().map(|(_, medium)| medium.most(from, to)).sum::<f32>();
        let finest = self.0.iter().map(|(_, medium)| medium.finest(from, to, OUTSTANDING * all));
        finest.fold(f32::INFINITY, f32::min)
    }

    /// The most that any ray meets up to `length`.
    pub fn most(&self, length: f32) -> f32 {
        self.0.iter().map(|(_, medium)| medium.most(0.0, length)).sum()
    }

    /// Where what is smooth has surely added that much optical depth behind a ray parameter [m].
    pub fn hides_from(&self, from: f32, depth: f32) -> f32 {
        self.0
            .iter()
            .map(|(_, medium)| medium.hides_from(from, depth))
            .fold(f32::INFINITY, f32::min)
    }

    /// Ray parameters where β, or its slope, jumps, ray by ray [m].
    pub fn edges(&self) -> Vec<Each> {
        self.0.iter().flat_map(|(_, medium)| medium.edges()).collect()
    }
}

/// Rows added up.
fn sum_of<'a>(mut fields: impl Iterator<Item = &'a [Each]>) -> Vec<Each> {
    let mut sum = fields.next().map_or(Vec::new(), <[Each]>::to_vec);
    for own in fields {
        let each = sum.as_flattened_mut().iter_mut().zip(own.as_flattened());
        each.for_each(|(sum, own)| *sum += own);
    }
    sum
}

/// ln of rows, with a floor where there is nothing.
#[inline(always)]
fn logarithms<S: Simd>(simd: S, rows: &mut [Each]) {
    for row in rows {
        for at in (0..PADDED).step_by(Lanes::<S>::COUNT) {
            let value = Lanes::load(simd, &row[at..]);
            value.max(value.lit(1e-30)).ln().store(&mut row[at..]);
        }
    }
}
