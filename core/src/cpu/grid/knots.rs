//! Where the rays of a block are tabulated along depth.
//!
//! Edges of the fog cut every ray into sections, each from edge to edge as that ray passes them; a ray that
//! passes fewer has empty ones. A knot belongs to a section: it stands at the same distance on all rays, but
//! for those whose section begins later or ends sooner, where it stands at that end. So what is
//! tabulated stays continuous across the picture, and smooth along every section.

use super::{BLOCK, Grid};
use crate::cpu::places::{PLACES, cone};
use crate::frame::context::Lamp;
use crate::geometry::control::{Control, Each, PADDED};
use crate::light::ToLight;
use crate::media::{OnRays, Patched, Smooth, Sum, hull};
use glam::{Vec2, Vec3};

/// Share of the knots that lie evenly in the angles seen from the lamps.
const LIGHT: f64 = 0.45;
/// Share of them that lie evenly in the light that the fog removes; the rest lies evenly among the lumps.
const FOG: f64 = 0.45;
/// Places that are looked at: evenly, halfway to the beginning again and again, among the lumps, and where
/// the first lamps see even angles.
const EVENLY: usize = 12;
const HALVINGS: i32 = 12;
const AMONG: usize = 32;
const OF_A_LAMP: usize = 6;
const LAMPS: usize = 4;
/// Rays of a block that they are looked at on.
const RAYS: usize = 4;
/// The first knot, as a share of the next.
const FIRST: f32 = 0.05;
/// Distances of a lamp from a ray at which it is left behind: from there on it sees the rest of the ray under
/// less than a third of a right angle.
const BEHIND: f64 = 2.0;
/// A section's first and last knot stand this share of their distance within it: at the edge itself β
/// has two values.
pub const WITHIN: f64 = 1e-5;
/// Most edges that are followed.
pub const EDGES: usize = 6;

/// Where the sections of a ray begin and end [m].
pub type Bounds = [f32; EDGES + 2];

/// The knots of a block.
pub struct Knots {
    /// From where to where there is fog [m].
    from: f32,
    to: f32,
    /// Edges that rays pass.
    edges: usize,
    /// The first knot behind all lumps and lamps.
    behind: usize,
    /// Section and distance [m].
    at: Vec<(usize, f32)>,
}

/// What of the picture a block covers [px].
#[derive(Clone, Copy)]
struct Area {
    middle: Vec2,
    half: Vec2,
}

impl Area {
    /// Of a block with that corner: rays beside the picture would see other fog.
    fn new(grid: &Grid, corner: Vec2) -> Self {
        let size = grid.context.viewpoint.size().as_vec2();
        let half = 0.5 * (size - corner).min(Vec2::splat(BLOCK as f32));
        Self { middle: corner + half, half }
    }
}

/// From where to where the rays of a block meet fog that is seen, and lumps [m].
struct Reach {
    from: f32,
    to: f32,
    dense: Option<[f32; 2]>,
}

impl Knots {
    /// Even steps in a mixture of the angles that the ray through the block's middle turns through before the
    /// lamps, the light that fog removes of some of its rays, and plain distance among the lumps. `None` if
    /// there is no fog.
    pub fn new(grid: &Grid, fog: &Sum<dyn Patched>, corner: Vec2, deepest: f32) -> Option<Self> {
        let viewpoint = &grid.context.viewpoint;
        let area = Area::new(grid, corner);
        let place = |c: usize| {
            let at = Vec2::new((c % RAYS % 2) as f32, (c % RAYS / 2) as f32);
            area.middle + area.half * (at - 0.5)
        };
        let rays = Control::new(|c| viewpoint.ray(place(c).as_dvec2()));
        let met = fog.on_rays(grid.context.job.level, &rays, viewpoint.parallel, 0.0);
        let reach = Reach::new(grid, fog, &met, area, deepest)?;
        let (even, behind) = evenly(grid, &met, &reach, area);
        let Reach { from, to, .. } = reach;
        let mut knots = Self { from, to, edges: 0, behind: usize::MAX, at: Vec::new() };
        knots.cut(grid, area, &even);
        if !knots.has_edges() {
            knots.part(behind);
        }
        Some(knots)
    }

    /// Cuts knots at the edges that the rays of a block pass.
    fn cut(&mut self, grid: &Grid, area: Area, even: &[f32]) {
        let inner = &even[1..even.len() - 1];
        let place = |c: usize| {
            let at = Vec2::new((c % 4) as f32, (c / 4) as f32) / 1.5 - 1.0;
            area.middle + area.half * at
        };
        let rays: [_; PADDED] = std::array::from_fn(|c| {
            let (start, direction) = grid.context.viewpoint.ray(place(c).as_dvec2());
            (start.as_vec3(), direction.as_vec3())
        });
        let passed = |ray: &(Vec3, Vec3)| passed(&grid.haze, *ray, [self.from, self.to]).len();
        self.edges = rays.iter().map(passed).max().unwrap_or(0).min(EDGES);
        if self.edges == 0 {
            self.at = even.iter().map(|t| (0, *t)).collect();
            return;
        }
        let each = rays.map(|(start, direction)| self.bounds(&grid.haze, start, direction));
        for section in 0..=self.edges {
            let begin = each.iter().map(|bounds| bounds[section]).fold(f32::INFINITY, f32::min);
            let end = each.iter().map(|bounds| bounds[section + 1]).fold(0.0, f32::max);
            let first = if section == 0 { even[0] } else { 0.0 };
            self.at.push((section, first));
            let own = inner.iter().filter(|t| (begin..end).contains(*t));
            self.at.extend(own.map(|t| (section, *t)));
            self.at.push((section, f32::INFINITY));
        }
    }

    /// Puts two knots where all lumps and lamps lie before: one tells of them, one of what is behind.
    fn part(&mut self, behind: f32) {
        if behind < self.to {
            let place = self.at.partition_point(|(_, t)| *t < behind);
            self.at.splice(place..place, [(0, behind), (0, behind)]);
            self.behind = place + 1;
        }
    }

    /// Whether a knot tells of what is behind all lumps and lamps.
    #[inline(always)]
    pub fn is_behind(&self, knot: usize) -> bool {
        knot >= self.behind
    }

    /// How many.
    pub fn count(&self) -> usize {
        self.at.len()
    }

    /// The section of a knot, and its distance there [m], but for where that section begins and ends.
    #[inline(always)]
    pub fn at(&self, knot: usize) -> (usize, f32) {
        self.at[knot]
    }

    /// Whether rays pass edges.
    pub fn has_edges(&self) -> bool {
        self.edges > 0
    }

    /// From where to where there is fog [m].
    pub fn ends(&self) -> [f32; 2] {
        [self.from, self.to]
    }

    /// The sections of a ray from the viewpoint.
    pub fn bounds(&self, haze: &Sum<dyn Smooth>, start: Vec3, direction: Vec3) -> Bounds {
        let mut bounds = [self.to; EDGES + 2];
        bounds[0] = self.from;
        if self.has_edges() {
            let passed = passed(haze, (start, direction), [self.from, self.to]);
            bounds[1..=self.edges].iter_mut().zip(passed).for_each(|(bound, edge)| *bound = edge);
        }
        bounds
    }

    /// Where a knot lies on a ray of such sections [m].
    pub fn on(&self, bounds: &Bounds, knot: usize) -> f32 {
        let (section, t) = self.at[knot];
        let [begin, end] = self.within(bounds[section], bounds[section + 1]);
        t.min(end).max(begin)
    }

    /// From where to where the knots of a section lie [m].
    fn within(&self, begin: f32, end: f32) -> [f32; 2] {
        if self.has_edges() {
            [begin * (1.0 + WITHIN) as f32, end * (1.0 - WITHIN) as f32]
        } else {
            [begin, end]
        }
    }

    /// Where the knots lie on sixteen rays.
    pub fn rows(&self, haze: &Sum<dyn Smooth>, rays: &Control) -> Vec<Each> {
        let direction = |c: usize| Vec3::from_array([0, 1, 2].map(|k| rays.direction[k][c]));
        let bounds: [Bounds; PADDED] =
            std::array::from_fn(|c| self.bounds(haze, rays.point(c, 0.0), direction(c)));
        let row = |knot| std::array::from_fn(|c| self.on(&bounds[c], knot));
        (0..self.count()).map(row).collect()
    }
}

/// Where a ray passes edges between two ray parameters, ascending.
fn passed(haze: &Sum<dyn Smooth>, ray: (Vec3, Vec3), ends: [f32; 2]) -> Vec<f32> {
    let mut edges = Vec::new();
    between(haze, ray, ends, &mut edges);
    edges.sort_unstable_by(f32::total_cmp);
    edges
}

/// The same in any order, in place of what `edges` held.
pub fn between(
    haze: &Sum<dyn Smooth>,
    ray: (Vec3, Vec3),
    [from, to]: [f32; 2],
    edges: &mut Vec<f32>,
) {
    edges.clear();
    haze.edges(ray.0, ray.1, edges);
    edges.retain(|edge| *edge > from && *edge < to);
}

/// The knots of a block as if there were no edges, from the first to the last; and where all lumps and lamps
/// lie before [m].
fn evenly(grid: &Grid, met: &Sum<dyn OnRays>, reach: &Reach, area: Area) -> (Vec<f32>, f32) {
    let context = grid.context;
    let (offset, axis) = context.viewpoint.ray(area.middle.as_dvec2());
    let beside = |lamp: &Lamp| lamp.from_camera.beside(offset.into(), axis.into());
    let lamps: Vec<_> = context.lamps.iter().map(beside).collect();
    let at = places(reach, &lamps);
    let rows = at
        .chunks(PADDED / RAYS)
        .map(|some| std::array::from_fn(|c| some[(c / RAYS).min(some.len() - 1)]));
    let depth = met.depth(context.job.level, &rows.collect::<Vec<Each>>());
    let removed = depth
        .as_flattened()
        .chunks(RAYS)
        .map(|of_rays| of_rays.iter().map(|depth| -f64::from(-depth).exp_m1()).sum::<f64>());
    let removed: Vec<f64> = removed.take(at.len()).collect();
    let share = mixture(reach, &lamps, &at, &removed);
    let (first, last) = (share[0], share[at.len() - 1]);
    let count = grid.fineness.knots;
    let mut knots = Vec::with_capacity(count + 1);
    let mut place = 0;
    for k in 1..count {
        let wanted = first + (last - first) * k as f64 / count as f64;
        while place + 2 < at.len() && share[place + 1] < wanted {
            place += 1;
        }
        let rise = (share[place + 1] - share[place]).max(f64::MIN_POSITIVE);
        let part = ((wanted - share[place]) / rise).clamp(0.0, 1.0) as f32;
        knots.push((at[place + 1] - at[place]).mul_add(part, at[place]));
    }
    knots.extend(seen_from_near(grid, area.middle));
    knots.retain(|t| *t > reach.from && *t < reach.to);
    knots.sort_unstable_by(f32::total_cmp);
    let first = knots.first().copied().unwrap_or(reach.to);
    knots.insert(0, reach.from.max(first * FIRST));
    knots.push(reach.to);
    knots.dedup_by(|next, last| *next <= *last * 1.000_01);
    let lit = lamps.iter().map(|lamp| (lamp.closest.max(0.0) + BEHIND * lamp.miss) as f32);
    let lumps = reach.dense.map_or(0.0, |dense| dense[1]);
    (knots, lit.fold(lumps, f32::max))
}

/// Where the lamps are whose images are near: T towards a lamp has a cone there.
fn seen_from_near(grid: &Grid, middle: Vec2) -> impl Iterator<Item = f32> {
    let viewpoint = &grid.context.viewpoint;
    let closest = move |lamp: &Lamp| {
        let image = lamp.image(viewpoint)?;
        let is_near = image.as_vec2().distance(middle) < 2.0 * BLOCK as f32;
        let (offset, axis) = viewpoint.ray(image);
        let to_light = lamp.from_camera.beside(offset.into(), axis.into());
        is_near.then_some(to_light.closest as f32)
    };
    grid.context.lamps.iter().filter_map(closest).take(LAMPS)
}

/// Where the fog of a block is looked at, ascending [m].
fn places(reach: &Reach, lamps: &[ToLight<f64>]) -> Vec<f32> {
    let &Reach { from, to, dense } = reach;
    let evenly = |[from, to]: [f32; 2], count: usize| {
        (0..count).map(move |i| from + (to - from) * (i as f32 + 0.5) / count as f32)
    };
    let mut at = vec![from, to];
    at.extend(evenly([from, to], EVENLY));
    at.extend((1..=HALVINGS).map(|i| from + (to - from) * 0.5f32.powi(i)));
    at.extend(dense.into_iter().flat_map(|dense| evenly(dense, AMONG)));
    for lamp in lamps.iter().take(LAMPS) {
        let angle = |t: f32| ((f64::from(t) - lamp.closest) / lamp.miss).atan() as f32;
        let t = |angle: f32| (lamp.closest + lamp.miss * f64::from(angle).tan()) as f32;
        let seen = evenly([angle(from), angle(to)], OF_A_LAMP).map(t);
        at.extend(seen.filter(|t| *t > from && *t < to));
    }
    at.sort_unstable_by(f32::total_cmp);
    at
}

/// How many of the knots should stand before each of some places, as a share.
fn mixture(reach: &Reach, lamps: &[ToLight<f64>], at: &[f32], removed: &[f64]) -> Vec<f64> {
    let [from, to] = [reach.from, reach.to].map(f64::from);
    let [low, high] = reach.dense.unwrap_or([reach.from, reach.to]).map(f64::from);
    let angles = lamps.iter().map(|lamp| lamp.angle(from, to).max(f64::MIN_POSITIVE));
    let angles: Vec<f64> = angles.collect();
    let of_a_lamp = LIGHT / lamps.len().max(1) as f64;
    let (first, last) = (removed[0], removed[at.len() - 1]);
    let share = |(t, removed): (&f32, &f64)| {
        let t = f64::from(*t);
        let turned = lamps.iter().zip(&angles).map(|(lamp, whole)| lamp.angle(from, t) / whole);
        of_a_lamp * turned.sum::<f64>()
            + FOG * (removed - first) / (last - first).max(f64::MIN_POSITIVE)
            + (1.0 - LIGHT - FOG) * ((t - low) / (high - low)).clamp(0.0, 1.0)
    };
    at.iter().zip(removed).map(share).collect()
}

/// From where to where the rays of a block meet what is smooth [m]; all of them where none that is looked at does.
fn hazy(grid: &Grid, area: Area, deepest: f32) -> [f32; 2] {
    /// Rays across a block that are looked at; between them fog may begin sooner and end later by this share.
    const ACROSS: usize = 7;
    const ROOM: f64 = 0.1;
    let place = |i: usize| 2.0 * i as f32 / (ACROSS - 1) as f32 - 1.0;
    let span = |i: usize| {
        let at = Vec2::new(place(i % ACROSS), place(i / ACROSS));
        let (start, direction) =
            grid.context.viewpoint.ray((area.middle + area.half * at).as_dvec2());
        grid.haze.span(start, direction, deepest.into())
    };
    let Some((from, to)) = hull((0..ACROSS * ACROSS).filter_map(span)) else {
        return [0.0, deepest];
    };
    [(from * (1.0 - ROOM)) as f32, (to * (1.0 + ROOM)).min(deepest.into()) as f32]
}

impl Reach {
    /// Of a block's rays, given what some of them meet; `None` if there is no fog.
    fn new(
        grid: &Grid,
        fog: &Sum<dyn Patched>,
        met: &Sum<dyn OnRays>,
        area: Area,
        deepest: f32,
    ) -> Option<Self> {
        let deepest = deepest.min(met.hides_from(0.0, grid.context.opaque()));
        let rims = PLACES[..4].iter().map(|place| area.half * Vec2::from(*place));
        let rims = rims.collect::<Vec<_>>();
        let lumps = fog.lumps(&cone(grid.context, area.middle, &rims, deepest));
        let dense = [lumps.begin.max(0.0), lumps.end.min(deepest)];
        let dense = (dense[0] < dense[1]).then_some(dense);
        let [from, to] = if grid.haze.is_empty() { dense? } else { hazy(grid, area, deepest) };
        let [low, high] = dense.unwrap_or([from, to]);
        let (from, to) = (from.min(low), to.max(high));
        (from < to).then_some(Self { from, to, dense })
    }
}
