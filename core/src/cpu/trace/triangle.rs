//! A triangle as rays meet it: where it appears on the screen, and its edge functions.

use super::Block;
use crate::frame::viewpoint::Viewpoint;
use crate::num::Lanes;
use crate::vector::V3;
use fearless_simd::Simd;
use glam::{DVec2, Vec2, Vec3, Vec3A};

/// A rectangle of a block's pixels, ends included, and how near what appears there begins.
pub struct Area {
    /// First and last column.
    pub x: [usize; 2],
    /// First and last row.
    pub y: [usize; 2],
    /// Lower bound of its depth in front of the eye [m].
    pub near: f32,
}

/// Where points relative to the camera appear among the samples of a block of pixels.
pub struct Screen {
    forward: Vec3A,
    /// Products with a point, divided by its depth under perspective [px].
    x: Vec3A,
    y: Vec3A,
    /// Added to that: the picture's middle relative to the block, less the samples' largest and
    /// smallest shifts [px].
    first: Vec2,
    last: Vec2,
    /// Pixels across and down.
    size: [usize; 2],
    parallel: bool,
    /// A ray at the block's corner, unnormalised, or its offset under parallel projection; and what one
    /// pixel to the right and one down adds to it.
    corner: Vec3A,
    step_x: Vec3A,
    step_y: Vec3A,
    /// What rounding may change, per metre of the vectors that a ray is multiplied by.
    slack: f32,
}

impl Screen {
    /// For a block of pixels whose rays are shifted within them by so much.
    pub fn new(viewpoint: &Viewpoint, block: &Block, [least, most]: [DVec2; 2]) -> Self {
        let half = 0.5 * viewpoint.size();
        let (x, y) = viewpoint.picture_axes();
        let middle = half - DVec2::new(block.x as f64, block.y as f64);
        let (right, up) = viewpoint.half_axes();
        let (step_x, step_y) = (right / half.x, -up / half.y);
        let aside = step_x * -middle.x + step_y * -middle.y;
        let corner = if viewpoint.parallel { aside } else { viewpoint.forward + aside };
        let [across, down] = block.size.map(|size| size as f64);
        let reach = corner.length() + across * step_x.length() + down * step_y.length();
        Self {
            forward: viewpoint.forward.as_vec3a(),
            x: Vec3A::from(x) * half.x as f32,
            y: Vec3A::from(y) * half.y as f32,
            first: (middle - most).as_vec2(),
            last: (middle - least).as_vec2(),
            size: block.size,
            parallel: viewpoint.parallel,
            corner: corner.as_vec3a(),
            step_x: step_x.as_vec3a(),
            step_y: step_y.as_vec3a(),
            // The three products of f32 numbers in each of both ways to a value, and their sums.
            slack: 2e-6 * reach as f32,
        }
    }

    /// A function of rays on the screen, c + a·x + b·y, as (a, b, c): nowhere smaller than what rays
    /// themselves would say, each times a positive number.
    #[inline(always)]
    pub fn slope(&self, of: &Linear) -> [f32; 3] {
        let Linear(constant, vector) = of;
        let slack = self.slack * vector.abs().element_sum() + 2e-6 * constant.abs();
        let vector = Vec3A::from(*vector);
        let c = constant + vector.dot(self.corner) + slack;
        [vector.dot(self.step_x), vector.dot(self.step_y), c]
    }

    /// The block's pixels that a triangle may cover.
    #[inline(always)]
    pub fn covered(&self, [a, b, c]: [Vec3; 3]) -> Option<Area> {
        // The corners side by side.
        let xs = Vec3A::new(a.x, b.x, c.x);
        let ys = Vec3A::new(a.y, b.y, c.y);
        let zs = Vec3A::new(a.z, b.z, c.z);
        let along = |v: Vec3A| xs * v.x + ys * v.y + zs * v.z;
        let (mut x, mut y, depth) = (along(self.x), along(self.y), along(self.forward));
        let size = xs.abs().max(ys.abs()).max(zs.abs());
        let near = (depth - 1e-6 * size).min_element();
        if !self.parallel {
            // Close to the eye's plane the projection says nothing.
            if depth.cmplt(1e-3 * size).any() {
                return Some(self.everywhere(near));
            }
            let inverse = depth.recip();
            (x, y) = (x * inverse, y * inverse);
        }
        let x = range(x, self.first.x, self.last.x, self.size[0])?;
        let y = range(y, self.first.y, self.last.y, self.size[1])?;
        Some(Area { x, y, near })
    }

    fn everywhere(&self, near: f32) -> Area {
        let [across, down] = self.size;
        Area { x: [0, across - 1], y: [0, down - 1], near }
    }
}

/// Pixels whose sample lies between corners, and a hundredth for the rounding of projections.
#[inline(always)]
fn range(corners: Vec3A, first: f32, last: f32, size: usize) -> Option<[usize; 2]> {
    const ROOM: f32 = 0.01;
    let last = corners.max_element() + last + ROOM;
    // Truncation of a little less than one more: rounds up, by way of one instruction.
    let first = (corners.min_element() + first + (1.0 - 2.0 * ROOM)) as usize;
    (last >= first as f32 && first < size).then(|| [first, (last as usize).min(size - 1)])
}

/// A function that is linear in the ray: a constant and a vector.
#[derive(Clone, Copy)]
pub struct Linear(f32, Vec3);

/// The same in lanes.
pub struct LinearLanes<S: Simd>(Lanes<S>, V3<Lanes<S>>);

impl Linear {
    /// In the lanes of this machine.
    #[inline(always)]
    pub fn lanes<S: Simd>(&self, simd: S) -> LinearLanes<S> {
        let constant = Lanes::splat(simd, self.0);
        LinearLanes(constant, V3::lit(constant, self.1.as_dvec3()))
    }
}

impl<S: Simd> LinearLanes<S> {
    /// Its value for rays.
    #[inline(always)]
    pub fn at(&self, ray: V3<Lanes<S>>) -> Lanes<S> {
        self.0 + self.1.dot(ray)
    }
}

impl std::ops::Neg for &Linear {
    type Output = Linear;
    fn neg(self) -> Linear {
        Linear(-self.0, -self.1)
    }
}

/// Three edge functions and the numerator of the distance.
pub struct Edges(pub [Linear; 4]);

impl Edges {
    /// Of a triangle relative to the camera.
    #[inline(always)]
    pub fn new([a, b, c]: [Vec3; 3], viewpoint: &Viewpoint) -> Self {
        let face = (b - a).cross(c - a);
        let along = viewpoint.parallel.then(|| viewpoint.forward.as_vec3());
        let slope = if viewpoint.parallel { -face } else { Vec3::ZERO };
        Self([edge(b, c, along), edge(c, a, along), edge(a, b, along), Linear(a.dot(face), slope)])
    }

    /// The edge functions, with the sign that makes them positive on the triangle where it is seen.
    #[inline(always)]
    pub fn seen_from(&self, parallel: bool) -> impl Iterator<Item = [Linear; 3]> {
        let Self([u, v, w, numerator]) = self;
        // Under parallel projection the distance has no sign of its own: it may be seen from both sides.
        let front = (parallel || numerator.0 > 0.0).then_some([*u, *v, *w]);
        let back = (parallel || numerator.0 < 0.0).then(|| [-u, -v, -w]);
        front.into_iter().chain(back)
    }
}

/// The function that vanishes on the plane through an edge and the eye, or through an edge along a
/// direction.
#[inline(always)]
fn edge(p: Vec3, q: Vec3, along: Option<Vec3>) -> Linear {
    // Always formed from the same end: what two triangles share is then equal to the bit, and the
    // difference of the ends keeps the digits of a small triangle far away.
    let flipped = (p.x, p.y, p.z) > (q.x, q.y, q.z);
    let (p, q, sign) = if flipped { (q, p, -1.0) } else { (p, q, 1.0) };
    let Some(d) = along else { return Linear(0.0, sign * p.cross(q - p)) };
    let aside = p - d * p.dot(d);
    Linear(sign * d.dot(aside.cross(q - p)), sign * (p - q).cross(d))
}
