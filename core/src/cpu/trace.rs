//! First hits of a tile of rays: the hierarchy is walked once for the whole tile, front to back, and
//! what remains is met by as many rays at once as there are lanes.

use super::triangle::{Edges, LinearLanes, Screen};
use crate::frame::context::Context;
use crate::frame::viewpoint::{Tile, Viewpoint};
use crate::geometry::batch::{Hits, NOTHING, Rays, Row, SIZE, TILE, get3, load3};
use crate::geometry::hierarchy::{Bounds, WAITING};
use crate::num::{Lanes, Num};
use crate::progress::Progress;
use crate::shapes::{Geometry, Plane, Solid, Triangle};
use crate::vector::V3;
use fearless_simd::{Simd, SimdBase, SimdMask, dispatch};
use glam::{DVec2, DVec3, Vec3, Vec4};
use std::ops::Range;

/// Solids between two looks at how far the tile's farthest ray still reaches.
const SOLIDS_A_LOOK: usize = 24;
/// Marks an id as a plane's; ids of solids are places in [`Geometry::solids`].
const PLANE: u32 = 1 << 31;

/// First hits of a tile's rays, which stand in that order; some are missing if the job is over.
pub fn tile(context: &Context, index: usize, rays: &[Rays], order: &Order) -> Vec<Hits> {
    let (tile, job) = (context.grid.tile(index), &context.job);
    let tracer = Tracer::new(context.geometry, &context.viewpoint, tile, order, job.progress);
    dispatch!(job.level, simd => tracer.trace(simd, rays, context.far_m))
}

/// What a tile's walk through the geometry needs.
struct Tracer<'a> {
    geometry: &'a Geometry,
    viewpoint: &'a Viewpoint,
    /// The anchor relative to the camera [m].
    anchor: DVec3,
    screen: Screen,
    sides: Sides,
    order: &'a Order,
    progress: &'a Progress,
}

/// How a tile's rays stand in its batches.
pub struct Order {
    /// Where the rays of each row of pixels start, counted through all batches; and their end.
    pub starts: [usize; TILE + 1],
    /// Whether there is one ray a pixel.
    pub is_dense: bool,
    /// Smallest and largest shift of the rays within their pixels.
    pub shifts: [DVec2; 2],
}

/// The four planes that bound a tile's rays, side by side; points on a positive side are outside.
struct Sides {
    normals: [Vec4; 3],
    /// Their absolute values.
    sizes: [Vec4; 3],
    offset: Vec4,
}

/// A batch of rays and their nearest hits so far.
struct Sample<'r> {
    rays: &'r Rays,
    best: Best,
}

/// Nearest hits so far.
struct Best {
    length: Row,
    /// Barycentric weights of the first two corners.
    u: Row,
    v: Row,
    /// Bits of an id.
    id: Row,
}

impl<'a> Tracer<'a> {
    /// For one tile, whose rays stand in that order.
    pub fn new(
        geometry: &'a Geometry,
        viewpoint: &'a Viewpoint,
        tile: Tile,
        order: &'a Order,
        progress: &'a Progress,
    ) -> Self {
        let anchor = geometry.anchor - viewpoint.position;
        let screen = Screen::new(viewpoint, tile, order.shifts);
        let sides = Sides::new(tile, viewpoint);
        Self { geometry, viewpoint, anchor, screen, sides, order, progress }
    }

    /// Where the rays of all batches end, in one walk, which a job that is over leaves early.
    #[inline(always)]
    pub fn trace<S: Simd>(&self, simd: S, rays: &[Rays], far_m: f32) -> Vec<Hits> {
        let zero = [0.0; SIZE];
        let nothing = [f32::from_bits(NOTHING); SIZE];
        let mut samples = Vec::with_capacity(rays.len());
        for rays in rays {
            let mut best = Best { length: [far_m; SIZE], u: zero, v: zero, id: nothing };
            // What fills a batch up must not look as if it still reached far.
            best.length[rays.count..].fill(0.0);
            for (id, plane) in (PLANE..).zip(&self.geometry.planes) {
                self.meet_plane(simd, plane, id, rays, &mut best);
            }
            samples.push(Sample { rays, best });
        }
        self.walk(simd, &mut samples);
        samples.iter().map(|sample| self.resolve(sample.rays, &sample.best)).collect()
    }

    #[inline(always)]
    fn walk<S: Simd>(&self, simd: S, samples: &mut [Sample<'_>]) {
        let nodes = &self.geometry.hierarchy.nodes;
        let shift = self.anchor.as_vec3();
        let forward = self.viewpoint.forward.as_vec3();
        let axial = |at: usize| {
            let Bounds { min, max } = nodes[at].bounds;
            let (min, max) = (min + shift, max + shift);
            let (middle, half) = (0.5 * (min + max), 0.5 * (max - min));
            let outside = self.sides.exclude(middle, half);
            let near = middle.dot(forward) - half.dot(forward.abs());
            let behind = middle.dot(forward) + half.dot(forward.abs()) < 0.0;
            (!outside && !behind).then_some((near, at))
        };
        let mut stack = [(0.0f32, 0usize); WAITING];
        let mut top = 0;
        if let Some(root) = nodes.first().and_then(|_| axial(0)) {
            (stack[0], top) = (root, 1);
        }
        let (mut farthest, mut met) = (f32::INFINITY, 0);
        while top > 0 {
            top -= 1;
            let (near, at) = stack[top];
            if near > farthest {
                continue;
            }
            let node = &nodes[at];
            let first = node.first as usize;
            if node.count > 0 {
                let places = first..first + node.count as usize;
                met += places.len();
                for place in places {
                    self.meet(simd, place, samples);
                }
                if met >= SOLIDS_A_LOOK {
                    if self.progress.is_over() {
                        return;
                    }
                    (farthest, met) = (0.0, 0);
                    for sample in &*samples {
                        farthest = largest(simd, &sample.best.length).max(farthest);
                    }
                }
                continue;
            }
            let pair = match (axial(first), axial(first + 1)) {
                (Some(a), Some(b)) if a.0 < b.0 => [Some(b), Some(a)],
                pair => [pair.0, pair.1],
            };
            for child in pair.into_iter().flatten() {
                stack[top] = child;
                top += 1;
            }
        }
    }

    #[inline(always)]
    fn meet<S: Simd>(&self, simd: S, place: usize, samples: &mut [Sample<'_>]) {
        let id = place as u32;
        match self.geometry.solids[place] {
            Solid::Triangle(at) => {
                let triangle = &self.geometry.triangles[at as usize];
                self.meet_triangle(simd, triangle, id, samples);
            }
            Solid::Sphere { center, radius, .. } => {
                let to = self.anchor + center.as_dvec3();
                let power = to.length_squared() - f64::from(radius).powi(2);
                for Sample { rays, best } in samples {
                    self.meet_sphere(simd, (to, power, f64::from(radius)), id, rays, best);
                }
            }
            Solid::Box { min, max, .. } => {
                let corners = [min, max].map(|corner| self.anchor + corner.as_dvec3());
                for Sample { rays, best } in samples {
                    self.meet_box(simd, corners, id, rays, best);
                }
            }
        }
    }

    #[inline(always)]
    fn meet_plane<S: Simd>(&self, simd: S, plane: &Plane, id: u32, rays: &Rays, best: &mut Best) {
        let one = Lanes::splat(simd, 1.0);
        let normal = V3::lit(one, plane.normal);
        let height = one.lit(plane.normal.dot(self.anchor + plane.point));
        for at in (0..rays.count).step_by(Lanes::<S>::COUNT) {
            let direction = load3(simd, &rays.direction, at);
            let offset = load3(simd, &rays.offset, at);
            let distance = (height - normal.dot(offset)) / normal.dot(direction);
            best.keep(simd, at, one.lit(0.0).lt(distance), distance, (one, one), id);
        }
    }

    #[inline(always)]
    fn meet_sphere<S: Simd>(
        &self,
        simd: S,
        (to, power, radius): (DVec3, f64, f64),
        id: u32,
        rays: &Rays,
        best: &mut Best,
    ) {
        let one = Lanes::splat(simd, 1.0);
        let zero = one.lit(0.0);
        let center = V3::lit(one, to);
        for at in (0..rays.count).step_by(Lanes::<S>::COUNT) {
            let direction = load3(simd, &rays.direction, at);
            let offset = load3(simd, &rays.offset, at);
            let to = center - offset;
            // The power of the origin, |to|² − r²: formed in f64 where it would cancel most.
            let power = one.lit(power) + offset.dot(offset - center - center);
            let along = to.dot(direction);
            let half2 = one.lit(radius * radius) - to.cross(direction).length_squared();
            let half = half2.max(zero).sqrt();
            let outside = zero.lt(power);
            let distance = Lanes::select(outside, power / (along + half), along + half);
            let distance = Lanes::select(half2.lt(zero), -one, distance);
            best.keep(simd, at, zero.lt(distance), distance, (one, one), id);
        }
    }

    #[inline(always)]
    fn meet_box<S: Simd>(
        &self,
        simd: S,
        [min, max]: [DVec3; 2],
        id: u32,
        rays: &Rays,
        best: &mut Best,
    ) {
        let one = Lanes::splat(simd, 1.0);
        let (min, max) = (V3::lit(one, min), V3::lit(one, max));
        for at in (0..rays.count).step_by(Lanes::<S>::COUNT) {
            let direction = load3(simd, &rays.direction, at);
            let offset = load3(simd, &rays.offset, at);
            let inverse = V3::new(
                one / guarded(direction.x),
                one / guarded(direction.y),
                one / guarded(direction.z),
            );
            let (a, b) = ((min - offset) * inverse, (max - offset) * inverse);
            let near = a.x.min(b.x).max(a.y.min(b.y)).max(a.z.min(b.z));
            let far = a.x.max(b.x).min(a.y.max(b.y)).min(a.z.max(b.z));
            let zero = one.lit(0.0);
            let distance = Lanes::select(zero.lt(near), near, far);
            let distance = Lanes::select(far.lt(near), -one, distance);
            best.keep(simd, at, zero.lt(distance), distance, (one, one), id);
        }
    }

    /// Edge functions: volumes of the ray's direction (under parallel projection its offset) with
    /// the corners, equal and opposite for the two triangles of an edge, so that none leaves a gap.
    #[inline(always)]
    fn meet_triangle<S: Simd>(
        &self,
        simd: S,
        triangle: &Triangle,
        id: u32,
        samples: &mut [Sample<'_>],
    ) {
        let shift = self.anchor.as_vec3();
        let [a, b, c] = triangle.corners.map(|corner| corner + shift);
        let Some(area) = self.screen.covered([a, b, c]) else { return };
        let Edges([u, v, w, numerator]) = Edges::new([a, b, c], self.viewpoint);
        let edges = [u.lanes(simd), v.lanes(simd), w.lanes(simd)];
        let met = (edges, numerator.lanes(simd), id);
        let (lanes, starts) = (Lanes::<S>::COUNT, &self.order.starts);
        if !self.order.is_dense || lanes >= TILE {
            self.meet_span(simd, &met, starts[area.top]..starts[area.bottom + 1], samples);
            return;
        }
        // Registers shorter than a row of pixels: the ones beside the triangle are left out.
        for start in &starts[area.top..=area.bottom] {
            let span = start + area.left..start + area.right + 1;
            self.meet_span(simd, &met, span, samples);
        }
    }

    /// Meets a triangle with some rays, counted through all batches.
    #[inline(always)]
    fn meet_span<S: Simd>(
        &self,
        simd: S,
        (edges, numerator, id): &([LinearLanes<S>; 3], LinearLanes<S>, u32),
        span: Range<usize>,
        samples: &mut [Sample<'_>],
    ) {
        let lanes = Lanes::<S>::COUNT;
        for place in (span.start / lanes * lanes..span.end).step_by(lanes) {
            let (Sample { rays, best }, at) = (&mut samples[place / SIZE], place % SIZE);
            let variable = if self.viewpoint.parallel { &rays.offset } else { &rays.direction };
            let ray = load3(simd, variable, at);
            best.meet(simd, at, edges, numerator, ray, *id);
        }
    }

    /// Normals and surfaces of the nearest hits.
    fn resolve(&self, rays: &Rays, best: &Best) -> Hits {
        let mut hits = Hits::nothing(0.0);
        hits.length = best.length;
        for at in 0..rays.count {
            let id = best.id[at].to_bits();
            if id == NOTHING {
                continue;
            }
            let direction = get3(&rays.direction, at);
            let offset = get3(&rays.offset, at);
            let point = offset + direction * best.length[at] - self.anchor.as_vec3();
            let (normal, surface) = if id & PLANE != 0 {
                let plane = &self.geometry.planes[(id & !PLANE) as usize];
                (plane.normal.as_vec3(), plane.surface)
            } else {
                let weights = [best.u[at], best.v[at]];
                self.normal(&self.geometry.solids[id as usize], point, weights, direction)
            };
            let normal = if normal.dot(direction) > 0.0 { -normal } else { normal };
            let normal = normal.normalize_or_zero();
            hits.surface[at] = surface;
            for k in 0..3 {
                hits.normal[k][at] = normal[k];
            }
        }
        hits
    }

    fn normal(&self, solid: &Solid, point: Vec3, [u, v]: [f32; 2], ray: Vec3) -> (Vec3, u32) {
        match *solid {
            Solid::Triangle(at) => {
                let triangle = &self.geometry.triangles[at as usize];
                let Some([a, b, c]) = self.geometry.smooth.get(triangle.smooth as usize) else {
                    return (triangle.face(), triangle.surface);
                };
                let smooth = u * *a + v * *b + (1.0 - u - v) * *c;
                // A smooth normal on the far side of its face would light the wrong side.
                let flipped = smooth.dot(ray) * triangle.face().dot(ray) < 0.0;
                (if flipped { -smooth } else { smooth }, triangle.surface)
            }
            Solid::Sphere { center, surface, .. } => (point - center, surface),
            Solid::Box { min, max, surface } => {
                let at = (point - 0.5 * (min + max)) / (max - min);
                let axis = usize::from(at.y.abs() > at.x.abs());
                let axis = if at.z.abs() > at[axis].abs() { 2 } else { axis };
                (Vec3::AXES[axis], surface)
            }
        }
    }
}

impl Sides {
    fn new(tile: Tile, viewpoint: &Viewpoint) -> Self {
        let origin = DVec2::new(tile.x as f64, tile.y as f64);
        let size = TILE as f64;
        let corners = [(0.0, 0.0), (size, 0.0), (size, size), (0.0, size)];
        let corners = corners.map(|(x, y)| viewpoint.ray(origin + DVec2::new(x, y)));
        let outward = [0, 1, 2, 3].map(|k| {
            let (a, b) = (corners[k], corners[(k + 1) % 4]);
            let normal = if viewpoint.parallel { (a.0 - b.0).cross(a.1) } else { a.1.cross(b.1) };
            // Corners run clockwise in the picture: their products point inwards.
            -normal.normalize()
        });
        let row = |of: &dyn Fn(usize) -> f64| Vec4::from_array([0, 1, 2, 3].map(|k| of(k) as f32));
        let normals = [0, 1, 2].map(|axis| row(&|k| outward[k][axis]));
        let offset = row(&|k| outward[k].dot(corners[k].0));
        Self { normals, sizes: normals.map(Vec4::abs), offset }
    }

    fn exclude(&self, middle: Vec3, half: Vec3) -> bool {
        let ([x, y, z], [w, h, d]) = (self.normals, self.sizes);
        let beyond = x * middle.x + y * middle.y + z * middle.z - self.offset;
        let reach = w * half.x + h * half.y + d * half.z;
        beyond.cmpgt(reach * 1.000_001).any()
    }
}

impl Best {
    /// Keeps a triangle where it is in front.
    #[inline(always)]
    fn meet<S: Simd>(
        &mut self,
        simd: S,
        at: usize,
        [u, v, w]: &[LinearLanes<S>; 3],
        numerator: &LinearLanes<S>,
        ray: V3<Lanes<S>>,
        id: u32,
    ) {
        let (u, v, w) = (u.at(ray), v.at(ray), w.at(ray));
        let inside = u.min(v).min(w).0.simd_ge(0.0) | u.max(v).max(w).0.simd_le(0.0);
        if !inside.any_true() {
            return;
        }
        let sum = u + v + w;
        let distance = numerator.at(ray) / sum;
        let front = inside & Lanes::lt(u.lit(0.0), distance);
        self.keep(simd, at, front, distance, (u / sum, v / sum), id);
    }

    #[inline(always)]
    fn keep<S: Simd>(
        &mut self,
        simd: S,
        at: usize,
        met: S::mask32s,
        distance: Lanes<S>,
        (u, v): (Lanes<S>, Lanes<S>),
        id: u32,
    ) {
        let length = Lanes::load(simd, &self.length[at..]);
        let nearer = met & distance.lt(length);
        if !nearer.any_true() {
            return;
        }
        write(simd, &mut self.length, at, nearer, distance);
        write(simd, &mut self.u, at, nearer, u);
        write(simd, &mut self.v, at, nearer, v);
        write(simd, &mut self.id, at, nearer, Lanes::splat(simd, f32::from_bits(id)));
    }
}

#[inline(always)]
fn write<S: Simd>(simd: S, row: &mut Row, at: usize, mask: S::mask32s, value: Lanes<S>) {
    let old = Lanes::load(simd, &row[at..]);
    Lanes::select(mask, value, old).store(&mut row[at..]);
}

/// A ray within a side of a box divides 0 by this instead of by 0.
#[inline(always)]
fn guarded<S: Simd>(d: Lanes<S>) -> Lanes<S> {
    let least = d.lit(1e-30);
    Lanes::select(d.abs().lt(least), least, d)
}

#[inline(always)]
fn largest<S: Simd>(simd: S, row: &Row) -> f32 {
    let mut most = Lanes::load(simd, row);
    for at in (0..SIZE).step_by(Lanes::<S>::COUNT) {
        most = most.max(Lanes::load(simd, &row[at..]));
    }
    most.0.as_slice().iter().copied().fold(0.0, f32::max)
}
