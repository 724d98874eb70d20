//! Triangles as rays meet them, with their edge functions: as many triangles at once as there are lanes.

use super::linear::{Linear, LinearLanes};
use super::screen::{Area, Screen};
use crate::geometry::control::{Each, PADDED};
use crate::num::{Lanes, Num};
use crate::vector::V3;
use fearless_simd::{Simd, SimdBase};
use glam::Vec3;

/// Triangles relative to the camera that wait until they fill a register.
#[derive(Default)]
pub struct Waiting {
    corners: [[Each; 3]; 3],
    ids: [u32; PADDED],
    count: usize,
}

impl Waiting {
    /// One more.
    #[inline(always)]
    pub fn push(&mut self, corners: [Vec3; 3], id: u32) {
        let at = self.count;
        for (rows, corner) in self.corners.iter_mut().zip(corners) {
            for (row, coordinate) in rows.iter_mut().zip(corner.to_array()) {
                row[at] = coordinate;
            }
        }
        self.ids[at] = id;
        self.count += 1;
    }

    /// Whether they fill a register.
    #[inline(always)]
    pub fn is_full<S: Simd>(&self, _simd: S) -> bool {
        self.count == Lanes::<S>::COUNT
    }

    /// All of them, ready to be met; none wait any more.
    #[inline(always)]
    pub fn take<S: Simd>(&mut self, simd: S, screen: &Screen) -> Ready {
        let [a, b, c] = &self.corners;
        let corners = [load(simd, a), load(simd, b), load(simd, c)];
        let mut ready = Ready::new(simd, &corners, screen);
        ready.seen &= (1 << self.count) - 1;
        ready.ids = self.ids;
        self.count = 0;
        ready
    }
}

#[inline(always)]
fn load<S: Simd>(simd: S, [x, y, z]: &[Each; 3]) -> V3<Lanes<S>> {
    V3::new(Lanes::load(simd, x), Lanes::load(simd, y), Lanes::load(simd, z))
}

/// Triangles with all that rays need to meet them.
pub struct Ready {
    /// Bits of those that may be seen at all.
    pub seen: u64,
    ids: [u32; PADDED],
    /// First and last column and row on the screen.
    area: [Each; 4],
    near: Each,
    /// The three edge functions and the numerator of the distance: constant and vector.
    linear: [[Each; 4]; 4],
}

impl Ready {
    #[inline(always)]
    fn new<S: Simd>(simd: S, corners: &[V3<Lanes<S>>; 3], screen: &Screen) -> Self {
        let empty = [0.0; PADDED];
        let (area, near, linear) = ([empty; 4], empty, [[empty; 4]; 4]);
        let mut ready = Self { seen: 0, ids: [0; PADDED], area, near, linear };
        ready.seen = screen.cover(simd, corners, &mut ready.area, &mut ready.near);
        if ready.seen == 0 {
            return ready;
        }
        let [a, b, c] = *corners;
        let [u, v, w, numerator] = &mut ready.linear;
        let face = cross(b - a, c - a);
        let along = screen.parallel.then(|| V3::splat(simd, screen.forward.to_array()));
        edge(b, c, along).store(u);
        edge(c, a, along).store(v);
        edge(a, b, along).store(w);
        let zero = face.x.lit(0.0);
        let slope = if along.is_some() { -face } else { V3::new(zero, zero, zero) };
        LinearLanes(a.plain_dot(face), slope).store(numerator);
        ready
    }

    /// The id of one.
    pub fn id(&self, at: usize) -> u32 {
        self.ids[at]
    }

    /// Where one appears.
    #[inline(always)]
    pub fn area(&self, at: usize) -> Area {
        let [left, right, top, bottom] = self.area.each_ref().map(|row| row[at] as i32 as usize);
        Area { x: [left, right], y: [top, bottom], near: self.near[at] }
    }

    /// The edge functions and the numerator of the distance of one.
    #[inline(always)]
    pub fn linear(&self, at: usize) -> [Linear; 4] {
        self.linear
            .each_ref()
            .map(|[constant, x, y, z]| Linear(constant[at], Vec3::new(x[at], y[at], z[at])))
    }
}

/// The functions that vanish on the planes through edges and the eye, or through edges along a direction.
#[inline(always)]
fn edge<S: Simd>(p: V3<Lanes<S>>, q: V3<Lanes<S>>, along: Option<V3<Lanes<S>>>) -> LinearLanes<S> {
    // Always formed from the same end: what two triangles share is then equal to the bit, and the
    // difference of the ends keeps the digits of a small triangle far away.
    let equal = [p.x.0.simd_eq(q.x.0), p.y.0.simd_eq(q.y.0)];
    let flipped = q.x.lt(p.x) | (equal[0] & (q.y.lt(p.y) | (equal[1] & q.z.lt(p.z))));
    let one = p.x.lit(1.0);
    let sign = Lanes::select(flipped, -one, one);
    let (p, q) = (V3::select(flipped, q, p), V3::select(flipped, p, q));
    let Some(d) = along else { return LinearLanes(one.lit(0.0), cross(p, q - p).scale(sign)) };
    let aside = p - d.scale(p.plain_dot(d));
    LinearLanes(sign * d.plain_dot(cross(aside, q - p)), cross(p - q, d).scale(sign))
}

/// A vector product of which every product is rounded: a fused one differs in the last bit with the order of its
/// factors, and with it on which side of an edge a ray passes.
#[inline(always)]
fn cross<S: Simd>(a: V3<Lanes<S>>, b: V3<Lanes<S>>) -> V3<Lanes<S>> {
    V3::new(a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y)
}
