//! Shadows of surfaces on surfaces: which hits of a batch a lamp does not reach.
//!
//! Ways from a batch's points to a lamp run close together, so the hierarchy is walked once for all: a node is opened for
//! those registers of points of which some way meets its box. What stands there
//! is asked of them in lanes: behind a triangle's plane and within the planes through its sides
//! and the lamp, which are the same for neighbours to the last bit, so that no light comes through between.

use super::shade::ends;
use crate::frame::context::{Context, Lamp};
use crate::frame::viewpoint::Tile;
use crate::geometry::batch::{Hits, NOTHING, Rays, Row, Rows, SIZE, get3, load3};
use crate::geometry::bundle::Bundle;
use crate::geometry::hierarchy::WAITING;
use crate::geometry::{Beyond, Origin};
use crate::num::{Lanes, Num};
use crate::shapes::{BEHIND, Cuboid, Geometry, IN_PLANE, LIFT, Plane, Solid, Sphere, Triangle};
use crate::vector::V3;
use fearless_simd::{Simd, dispatch};
use glam::{DVec2, DVec3, Vec3};

/// Optical depth that stands for a shadow.
const DARK: f32 = 1e4;

/// Where pixels at the rim of a shadow are looked at again, from their centres [px].
const WITHIN: [[f64; 2]; 4] = [[-0.125, -0.375], [0.375, -0.125], [0.125, 0.375], [-0.375, 0.125]];

/// How much of a lamp reaches the hits of a batch, 1 or 0; `None` where nothing hides it.
pub fn lit(context: &Context, lamp: &Lamp, (rays, hits): (&Rays, &Hits)) -> Option<Box<Row>> {
    if !lamp.is_shaded || hits.surface.iter().all(|surface| *surface == NOTHING) {
        return None;
    }
    let points = lifted(context, rays, hits);
    let caster = Caster::new(context, 0.0, lamp, rays.count, hits, &points)?;
    let mut lit = Box::new(facing(lamp, hits, &points));
    caster.cast(context, &points, &mut lit);
    let unseen = lit.iter_mut().zip(&hits.surface).filter(|(_, surface)| **surface == NOTHING);
    unseen.for_each(|(lit, _)| *lit = 1.0);
    lit.iter().any(|lit| *lit < 1.0).then_some(lit)
}

/// 1 where a surface looks at a lamp and may get light of it, else 0.
fn facing(lamp: &Lamp, hits: &Hits, points: &Rows) -> Row {
    let light = lamp.from_camera.origin();
    let faces = |at: usize| {
        let normal = get3(&hits.normal, at);
        let height = match light {
            // Above the surface itself: the point is so much above that.
            Origin::At(apex) => {
                normal.dot(apex.as_vec3() - get3(points, at)) + LIFT as f32 * hits.length[at]
            }
            Origin::Beyond(Beyond { toward, .. }) => normal.dot(toward.as_vec3()),
        };
        hits.surface[at] != NOTHING && height > 0.0
    };
    std::array::from_fn(|at| f32::from(u8::from(faces(at))))
}

/// Adds what stands for a lamp's shadows to its optical depths.
pub fn add(lit: &Row, depth: &mut Row) {
    for (depth, lit) in depth.iter_mut().zip(lit) {
        *depth += if *lit > 0.0 { -lit.ln() } else { DARK };
    }
}

/// Where rays end, a little above the surface.
fn lifted(context: &Context, rays: &Rays, hits: &Hits) -> Rows {
    let mut points = dispatch!(context.job.level, simd => ends(simd, rays, hits));
    for (row, normal) in points.iter_mut().zip(&hits.normal) {
        for at in 0..rays.count {
            row[at] += normal[at] * (LIFT as f32 * hits.length[at]);
        }
    }
    points
}

/// Gives some pixels of a tile as much light of a lamp as reaches some places of them.
pub fn soften(
    context: &Context,
    lamp: &Lamp,
    (rays, hits): (&Rays, &Hits),
    (tile, rim): (Tile, &[usize]),
    lit: &mut Row,
) {
    let points = lifted(context, rays, hits);
    let beside = context.viewpoint.pixel();
    let Some(caster) = Caster::new(context, beside, lamp, rays.count, hits, &points) else {
        return;
    };
    for some in rim.chunks(SIZE / WITHIN.len()) {
        let (mut places, mut seen) = ([[0.0; SIZE]; 3], [1.0; SIZE]);
        for (i, place) in places_within(context, tile, hits, &points, some).enumerate() {
            (0..3).for_each(|k| places[k][i] = place[k]);
        }
        // What stands behind the last of them is nobody's.
        seen[WITHIN.len() * some.len()..].fill(0.0);
        caster.cast(context, &places, &mut seen);
        for (at, seen) in some.iter().zip(seen.chunks(WITHIN.len())) {
            lit[*at] = seen.iter().sum::<f32>() / WITHIN.len() as f32;
        }
    }
}

/// Where rays through some places of pixels meet the planes of what their own rays have met.
fn places_within<'a>(
    context: &'a Context,
    tile: Tile,
    hits: &'a Hits,
    points: &'a Rows,
    pixels: &'a [usize],
) -> impl Iterator<Item = Vec3> + 'a {
    pixels.iter().flat_map(move |at| {
        let (x, y) = tile.pixel(*at);
        let (normal, point) = (get3(&hits.normal, *at), get3(points, *at));
        WITHIN.into_iter().map(move |[dx, dy]| {
            let pixel = DVec2::new(x as f64 + 0.5 + dx, y as f64 + 0.5 + dy);
            let (start, direction) = context.viewpoint.ray(pixel);
            let (start, direction) = (start.as_vec3(), direction.as_vec3());
            let t = (point - start).dot(normal) / direction.dot(normal);
            let on_plane = start + t * direction;
            // Across an edge or at a grazing angle the plane leads astray.
            let is_near = (on_plane - point).length() < 0.1 * (point - start).length();
            if is_near { on_plane } else { point }
        })
    })
}

/// A lamp before some points, relative to the camera.
struct Caster<'a> {
    geometry: &'a Geometry,
    light: Origin,
    /// The anchor.
    shift: DVec3,
    /// What the ways of light lie within, as a box and as a cone.
    min: DVec3,
    max: DVec3,
    bundle: Bundle,
    /// Rounding counts up to here [m].
    off: f64,
}

impl<'a> Caster<'a> {
    /// `beside` is how far beside the points others may be asked for, as a share of their distance.
    fn new(
        context: &'a Context,
        beside: f64,
        lamp: &Lamp,
        count: usize,
        hits: &Hits,
        points: &Rows,
    ) -> Option<Self> {
        let (mut min, mut max) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for at in (0..count).filter(|at| hits.surface[*at] != NOTHING) {
            let point = get3(points, at);
            (min, max) = (min.min(point), max.max(point));
        }
        let far = min.abs().max(max.abs()).max_element();
        let room = DVec3::splat(f64::from(far) * beside);
        let (mut min, mut max) = (min.as_dvec3() - room, max.as_dvec3() + room);
        let light = lamp.from_camera.origin();
        let (middle, radius) = (0.5 * (min + max), 0.5 * (max - min).length() * 1.000_001);
        let bundle = match light {
            Origin::At(apex) => {
                (min, max) = (min.min(apex), max.max(apex));
                let whole = middle.distance(apex) + radius;
                Bundle::toward_ball(apex, middle, radius).unwrap_or(Bundle::all_around(apex, whole))
            }
            Origin::Beyond(Beyond { toward: axis, .. }) => {
                for k in 0..3 {
                    if axis[k] > 0.0 {
                        max[k] = f64::INFINITY;
                    } else if axis[k] < 0.0 {
                        min[k] = f64::NEG_INFINITY;
                    }
                }
                Bundle { origin: middle, axis, radius, tan: 0.0, length: f64::INFINITY }
            }
        };
        let shift = context.geometry.anchor - context.viewpoint.position;
        let off = BEHIND * (middle.abs().max_element() + radius);
        radius.is_finite().then_some(Self {
            geometry: context.geometry,
            light,
            shift,
            min,
            max,
            bundle,
            off,
        })
    }

    fn meets(&self, min: Vec3, max: Vec3) -> bool {
        let (min, max) = (min.as_dvec3() + self.shift, max.as_dvec3() + self.shift);
        if min.cmpgt(self.max).any() || max.cmplt(self.min).any() {
            return false;
        }
        let place = self.bundle.place(0.5 * (min + max));
        self.bundle.distance(place) <= 0.5 * (max - min).length() * 1.000_01
    }

    /// Takes the light from what is hidden.
    fn cast(&self, context: &Context, points: &Rows, lit: &mut Row) {
        dispatch!(context.job.level, simd => self.walk(simd, points, lit));
    }

    #[inline(always)]
    fn walk<S: Simd>(&self, simd: S, points: &Rows, lit: &mut Row) {
        let geometry = self.geometry;
        let planes = geometry.planes.iter().filter(|plane| geometry.throws(plane.surface));
        for halves in planes.map(|plane| self.of_plane(plane)) {
            for at in (0..SIZE).step_by(Lanes::<S>::COUNT) {
                hide_behind(simd, &halves, self.off, (points, at), lit);
            }
        }
        let ways = Ways::new(simd, self, points);
        let mut open = [(0u32, u64::MAX >> (64 - SIZE / Lanes::<S>::COUNT)); WAITING];
        let mut count = usize::from(!geometry.hierarchy.nodes.is_empty());
        while count > 0 {
            count -= 1;
            let (node, asking) = open[count];
            let node = geometry.hierarchy.nodes[node as usize];
            if !self.meets(node.bounds.min, node.bounds.max) {
                continue;
            }
            let bounds = [node.bounds.min, node.bounds.max].map(|end| end.as_dvec3() + self.shift);
            let met = ways.meeting(simd, bounds, asking, lit);
            if met == 0 {
                continue;
            }
            if node.count == 0 {
                open[count] = (node.first, met);
                open[count + 1] = (node.first + 1, met);
                count += 2;
                continue;
            }
            let first = node.first as usize;
            for solid in &geometry.solids[first..first + node.count as usize] {
                self.hide(simd, solid, points, met, lit);
            }
        }
    }

    /// Takes the light from the points of some registers that a solid hides.
    #[inline(always)]
    fn hide<S: Simd>(&self, simd: S, solid: &Solid, points: &Rows, asking: u64, lit: &mut Row) {
        let geometry = self.geometry;
        match *solid {
            Solid::Triangle(at) => {
                let triangle = &geometry.triangles[at as usize];
                if !geometry.throws(triangle.surface) {
                    return;
                }
                let Some(halves) = self.of_triangle(triangle) else { return };
                for at in registers::<S>(asking) {
                    hide_behind(simd, &halves, self.off, (points, at), lit);
                }
            }
            Solid::Sphere(at) => {
                let sphere = &geometry.spheres[at as usize];
                if geometry.throws(sphere.surface) {
                    self.hide_in_ball(simd, sphere, points, asking, lit);
                }
            }
            Solid::Cuboid(at) => {
                let cuboid = &geometry.cuboids[at as usize];
                if geometry.throws(cuboid.surface) {
                    self.hide_in_box(simd, cuboid, points, asking, lit);
                }
            }
        }
    }

    /// Behind a plane, the same plane thrice for want of others.
    fn of_plane(&self, plane: &Plane) -> [Half; 4] {
        let on = plane.point + self.shift;
        let half = match self.side(plane.normal, on, 1e-12) {
            0.0 => Half::NONE,
            side => Half::new(-side * plane.normal, on),
        };
        [half, Half::ALL, Half::ALL, Half::ALL]
    }

    /// Behind a triangle's plane, and within those through its sides and the light.
    fn of_triangle(&self, triangle: &Triangle) -> Option<[Half; 4]> {
        let [a, b, c] = triangle.corners.map(|corner| corner.as_dvec3() + self.shift);
        let face = (b - a).cross(c - a);
        let side = self.side(face, a, IN_PLANE);
        if side == 0.0 {
            return None;
        }
        let edge = |from: DVec3, to: DVec3| match self.light {
            Origin::At(apex) => Half::through(-side * (from - apex).cross(to - apex), apex),
            Origin::Beyond(Beyond { toward, .. }) => {
                Half::through(-side * (to - from).cross(toward), from)
            }
        };
        Some([Half::new(-side * face, a), edge(a, b), edge(b, c), edge(c, a)])
    }

    /// On which side of a plane the light is; 0 in it, but for a share of the coordinates.
    fn side(&self, normal: DVec3, on: DVec3, share: f64) -> f64 {
        let (height, scale) = match self.light {
            Origin::At(apex) => {
                ((apex - on).dot(normal), (apex - self.shift).abs() + (on - self.shift).abs())
            }
            Origin::Beyond(Beyond { toward, .. }) => (toward.dot(normal), toward.abs()),
        };
        if height.abs() <= share * scale.dot(normal.abs()) { 0.0 } else { height.signum() }
    }

    #[inline(always)]
    fn hide_in_ball<S: Simd>(
        &self,
        simd: S,
        sphere: &Sphere,
        points: &Rows,
        asking: u64,
        lit: &mut Row,
    ) {
        let like = Lanes::splat(simd, 0.0);
        let center = V3::lit(like, sphere.center.as_dvec3() + self.shift);
        let radius2 = like.lit(f64::from(sphere.radius).powi(2));
        for at in registers::<S>(asking) {
            let point = load3(simd, points, at);
            let (way, length) = self.way(point);
            let to = center - point;
            let along = to.dot(way);
            let half2 = radius2 - to.cross(way).length_squared();
            let half = half2.max(like).sqrt();
            let is_met = like.lt(half2);
            let hidden = self.blocked([along - half, along + half], length);
            let hidden = Lanes::select(is_met, hidden, like);
            let left = Lanes::load(simd, &lit[at..]) * (like.lit(1.0) - hidden);
            left.store(&mut lit[at..]);
        }
    }

    #[inline(always)]
    fn hide_in_box<S: Simd>(
        &self,
        simd: S,
        cuboid: &Cuboid,
        points: &Rows,
        asking: u64,
        lit: &mut Row,
    ) {
        let like = Lanes::splat(simd, 0.0);
        let min = V3::lit(like, cuboid.min.as_dvec3() + self.shift);
        let max = V3::lit(like, cuboid.max.as_dvec3() + self.shift);
        for at in registers::<S>(asking) {
            let point = load3(simd, points, at);
            let (way, length) = self.way(point);
            let (a, b) = (min - point, max - point);
            let [x, y, z] =
                [between(a.x, b.x, way.x), between(a.y, b.y, way.y), between(a.z, b.z, way.z)];
            let (near, far) = (x[0].max(y[0]).max(z[0]), x[1].min(y[1]).min(z[1]));
            let hidden = self.blocked([near, far], length);
            let hidden = Lanes::select(near.lt(far), hidden, like);
            let left = Lanes::load(simd, &lit[at..]) * (like.lit(1.0) - hidden);
            left.store(&mut lit[at..]);
        }
    }

    /// 1 where one of two places lies on a way of such a length.
    #[inline(always)]
    fn blocked<S: Simd>(&self, [near, far]: [Lanes<S>; 2], length: Lanes<S>) -> Lanes<S> {
        let off = near.lit(self.off);
        on_way(near, off, length).max(on_way(far, off, length))
    }

    /// The unit vector from points to the light, and how far that is.
    #[inline(always)]
    fn way<S: Simd>(&self, point: V3<Lanes<S>>) -> (V3<Lanes<S>>, Lanes<S>) {
        let like = point.x;
        match self.light {
            Origin::At(apex) => {
                let way = V3::lit(like, apex) - point;
                let length =
                    way.length_squared().sqrt().max(like.lit(f64::from(f32::MIN_POSITIVE)));
                (way.scale(like.lit(1.0) / length), length)
            }
            Origin::Beyond(Beyond { toward, .. }) => (V3::lit(like, toward), like.lit(1e30)),
        }
    }
}

/// 1 where a place lies on a way, a little off its ends.
#[inline(always)]
fn on_way<S: Simd>(t: Lanes<S>, off: Lanes<S>, length: Lanes<S>) -> Lanes<S> {
    let (zero, one) = (t.lit(0.0), t.lit(1.0));
    let behind = Lanes::select(off.lt(t), one, zero);
    Lanes::select(t.lt(length - off), behind, zero)
}

/// Where a way is between two planes across an axis, in units of its length.
#[inline(always)]
fn between<S: Simd>(a: Lanes<S>, b: Lanes<S>, way: Lanes<S>) -> [Lanes<S>; 2] {
    let tiny = way.lit(1e-30);
    let way = Lanes::select(way.abs().lt(tiny), tiny, way);
    let (p, q) = (a / way, b / way);
    [p.min(q), p.max(q)]
}

/// The points on one side of a plane: normal · point + offset ≥ 0 [m].
#[derive(Clone, Copy)]
struct Half {
    normal: [f32; 3],
    offset: f32,
}

impl Half {
    const ALL: Self = Self { normal: [0.0; 3], offset: 1.0 };
    const NONE: Self = Self { normal: [0.0; 3], offset: -1.0 };

    fn new(normal: DVec3, on: DVec3) -> Self {
        Self::through(normal.normalize_or_zero(), on)
    }

    /// The same, but for a scale.
    fn through(normal: DVec3, on: DVec3) -> Self {
        Self { normal: normal.as_vec3().to_array(), offset: -normal.dot(on) as f32 }
    }
}

/// Where the registers begin that have a bit.
#[inline(always)]
fn registers<S: Simd>(mut asking: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let register = asking.trailing_zeros() as usize;
        asking &= asking.wrapping_sub(1);
        (register < 64).then_some(register * Lanes::<S>::COUNT)
    })
}

/// The ways from points to a lamp, by the inverse of their directions: what they meet is told in shares of a way, or in
/// metres where it has no end.
struct Ways<'a> {
    points: &'a Rows,
    inverse: Rows,
    end: f64,
    /// Boxes are larger by this, for rounding [m].
    room: DVec3,
}

impl<'a> Ways<'a> {
    #[inline(always)]
    fn new<S: Simd>(simd: S, caster: &Caster, points: &'a Rows) -> Self {
        let mut inverse = [[0.0; SIZE]; 3];
        let end = if matches!(caster.light, Origin::At(_)) { 1.0 } else { 1e20 };
        for at in (0..SIZE).step_by(Lanes::<S>::COUNT) {
            let point = load3(simd, points, at);
            let way = match caster.light {
                Origin::At(apex) => V3::lit(point.x, apex) - point,
                Origin::Beyond(Beyond { toward, .. }) => V3::lit(point.x, toward),
            };
            let [x, y, z] = &mut inverse;
            inverse_of(way.x).store(&mut x[at..]);
            inverse_of(way.y).store(&mut y[at..]);
            inverse_of(way.z).store(&mut z[at..]);
        }
        Self { points, inverse, end, room: DVec3::splat(2.0 * caster.off) }
    }

    /// The registers among some of which a lit point's way meets a box.
    #[inline(always)]
    fn meeting<S: Simd>(&self, simd: S, [min, max]: [DVec3; 2], asking: u64, lit: &Row) -> u64 {
        let zero = Lanes::splat(simd, 0.0);
        let (min, max) = (V3::lit(zero, min - self.room), V3::lit(zero, max + self.room));
        let (end, far_away) = (zero.lit(self.end), zero.lit(1e20));
        let mut met = 0;
        for at in registers::<S>(asking) {
            let (point, inverse) = (load3(simd, self.points, at), load3(simd, &self.inverse, at));
            let (a, b) = (min - point, max - point);
            let x = ordered(a.x * inverse.x, b.x * inverse.x);
            let y = ordered(a.y * inverse.y, b.y * inverse.y);
            let z = ordered(a.z * inverse.z, b.z * inverse.z);
            let near = x[0].max(y[0]).max(z[0]).max(zero);
            let far = x[1].min(y[1]).min(z[1]).min(end);
            // Rounding in the last digits of both.
            let near = near.min(far_away) * zero.lit(1.0 - 1e-5);
            let is_met = near.lt(far * zero.lit(1.0 + 1e-5));
            let own = Lanes::select(is_met, Lanes::load(simd, &lit[at..]), zero);
            if Lanes::<S>::any(zero.lt(own)) {
                met |= 1 << (at / Lanes::<S>::COUNT);
            }
        }
        met
    }
}

#[inline(always)]
fn ordered<S: Simd>(a: Lanes<S>, b: Lanes<S>) -> [Lanes<S>; 2] {
    [a.min(b), a.max(b)]
}

/// Its inverse, of none a very large one.
#[inline(always)]
fn inverse_of<S: Simd>(way: Lanes<S>) -> Lanes<S> {
    let tiny = way.lit(1e-25);
    let way = Lanes::select(way.abs().lt(tiny), tiny, way);
    way.lit(1.0) / way
}

/// Takes the light from points of a register that lie behind the first plane by some distance, and within the others.
#[inline(always)]
fn hide_behind<S: Simd>(
    simd: S,
    [face, a, b, c]: &[Half; 4],
    off: f64,
    (points, at): (&Rows, usize),
    lit: &mut Row,
) {
    let zero = Lanes::splat(simd, 0.0);
    let point = load3(simd, points, at);
    let behind = height(simd, face, point) - zero.lit(off);
    let within = height(simd, a, point).min(height(simd, b, point)).min(height(simd, c, point));
    let own = Lanes::load(simd, &lit[at..]);
    let own = Lanes::select(behind.min(within).lt(zero), own, zero);
    own.store(&mut lit[at..]);
}

#[inline(always)]
fn height<S: Simd>(simd: S, half: &Half, point: V3<Lanes<S>>) -> Lanes<S> {
    V3::splat(simd, half.normal).dot(point) + Lanes::splat(simd, half.offset)
}
