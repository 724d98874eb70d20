//! Where triangles appear on the screen, as many of them at once as there are lanes.

use super::linear::Linear;
use super::{ACROSS, Block};
use crate::frame::viewpoint::Viewpoint;
use crate::geometry::batch::TILE;
use crate::geometry::control::Each;
use crate::num::{Lanes, Num};
use crate::vector::V3;
use fearless_simd::{Simd, SimdBase, SimdFloat, SimdMask};
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

impl Area {
    /// Places of the tiles that it is in, among those of the block row by row.
    #[inline(always)]
    pub fn tiles(&self) -> impl Iterator<Item = usize> + use<> {
        let [x, y] = [self.x, self.y].map(|[first, last]| first / TILE..=last / TILE);
        y.flat_map(move |y| x.clone().map(move |x| y * ACROSS + x))
    }

    /// How many pixels.
    pub fn count(&self) -> usize {
        (self.x[1] - self.x[0] + 1) * (self.y[1] - self.y[0] + 1)
    }
}

/// Where points relative to the camera appear among the samples of a block of pixels.
pub struct Screen {
    /// Products with a point, divided by its depth under perspective [px].
    x: Vec3A,
    y: Vec3A,
    /// The view direction.
    pub forward: Vec3,
    /// Added to that: the picture's middle relative to the block, less the samples' largest and
    /// smallest shifts [px].
    first: Vec2,
    last: Vec2,
    /// Pixels across and down.
    size: [usize; 2],
    /// Whether all rays are parallel.
    pub parallel: bool,
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
            forward: viewpoint.forward.as_vec3(),
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

    /// Writes the block's pixels that triangles may cover, and how near they are; tells those that may cover any.
    #[inline(always)]
    pub fn cover<S: Simd>(
        &self,
        simd: S,
        [a, b, c]: &[V3<Lanes<S>>; 3],
        [left, right, top, bottom]: &mut [Each; 4],
        near: &mut Each,
    ) -> u64 {
        let forward = V3::splat(simd, self.forward.to_array());
        let depths = [a.dot(forward), b.dot(forward), c.dot(forward)];
        let size = largest(a).max(largest(b)).max(largest(c));
        let ([nearest, farthest], slack) = (ends(depths), size.lit(1e-6) * size);
        (nearest - slack).store(near);
        let ahead = Lanes::lt(-slack, farthest);
        // Close to the eye's plane the projection says nothing.
        let beside = if self.parallel { None } else { Some(nearest.lt(size.lit(1e-3) * size)) };
        let axes = [V3::splat(simd, self.x.to_array()), V3::splat(simd, self.y.to_array())];
        let mut places = [
            [a.dot(axes[0]), b.dot(axes[0]), c.dot(axes[0])],
            [a.dot(axes[1]), b.dot(axes[1]), c.dot(axes[1])],
        ];
        if !self.parallel {
            for (k, depth) in depths.into_iter().enumerate() {
                let inverse = size.lit(1.0) / depth;
                places[0][k] = places[0][k] * inverse;
                places[1][k] = places[1][k] * inverse;
            }
        }
        let [x, y] = places;
        let x = range(ends(x), [self.first.x, self.last.x], self.size[0], beside);
        let y = range(ends(y), [self.first.y, self.last.y], self.size[1], beside);
        let mut seen = ahead;
        for ([first, last], [from, to]) in [(x, [left, right]), (y, [top, bottom])] {
            first.store(from);
            last.store(to);
            seen &= first.0.simd_le(last.0);
        }
        seen.to_bitmask()
    }
}

/// The largest coordinate.
#[inline(always)]
fn largest<S: Simd>(v: &V3<Lanes<S>>) -> Lanes<S> {
    v.x.abs().max(v.y.abs()).max(v.z.abs())
}

/// Smallest and largest.
#[inline(always)]
fn ends<S: Simd>([a, b, c]: [Lanes<S>; 3]) -> [Lanes<S>; 2] {
    [a.min(b).min(c), a.max(b).max(c)]
}

/// First and last pixel, of so many, whose sample lies between corners, and a hundredth for the rounding of
/// projections: the last one before the first if there is none; all pixels where a mask says so.
#[inline(always)]
fn range<S: Simd>(
    [least, most]: [Lanes<S>; 2],
    [first, last]: [f32; 2],
    size: usize,
    all: Option<S::mask32s>,
) -> [Lanes<S>; 2] {
    const ROOM: f64 = 0.01;
    let zero = least.lit(0.0);
    let end = zero.lit((size - 1) as f64);
    // Rounded up.
    let from = least + zero.lit(f64::from(first) + 1.0 - 2.0 * ROOM);
    let from = Lanes(from.0.floor()).max(zero);
    let to = Lanes((most + zero.lit(f64::from(last) + ROOM)).0.floor()).min(end);
    match all {
        Some(all) => [Lanes::select(all, zero, from), Lanes::select(all, end, to)],
        None => [from, to],
    }
}
