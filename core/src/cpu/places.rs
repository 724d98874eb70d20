//! Rays of some batches, by their places in the picture.

use crate::frame::context::Context;
use crate::geometry::batch::{Ends, Rays, Row, SIZE, get3};
use crate::geometry::control::{Each, PADDED};
use crate::media::PatchCone;
use glam::Vec2;

/// Rays that stand for a square of the picture: its corners and the middles of its sides.
pub const CONTROL: usize = 8;

/// Corners of the square [−1, 1]² and middles of its sides, in the order of control rays.
pub const PLACES: [[f32; 2]; CONTROL] = [
    [-1.0, -1.0],
    [1.0, -1.0],
    [-1.0, 1.0],
    [1.0, 1.0],
    [0.0, -1.0],
    [0.0, 1.0],
    [-1.0, 0.0],
    [1.0, 0.0],
];

/// The cone around the rays through a place of the picture and some that stand this far from it [px].
pub fn cone(context: &Context, middle: Vec2, rims: &[Vec2], longest: f32) -> PatchCone {
    let ray = |place: Vec2| {
        let (offset, direction) = context.viewpoint.ray(place.as_dvec2());
        (offset.as_vec3(), direction.as_vec3())
    };
    let (offset, axis) = ray(middle);
    let (mut spread, mut width) = (0.0f32, 0.0f32);
    for rim in rims {
        let (rim_offset, rim) = ray(middle + *rim);
        spread = spread.max(rim.distance(axis));
        width = width.max(rim_offset.distance(offset));
    }
    PatchCone { offset, axis, spread, width, longest }
}

/// Rays of some batches that stand together.
pub struct Samples<'a> {
    /// The rays, and where they end.
    pub block: &'a [Ends<'a>],
    /// Where they pass through the picture.
    pub places: &'a Places,
}

impl Samples<'_> {
    /// Place in the picture, direction, start and length of a few of them, in so many lanes; the last one
    /// repeated.
    #[inline(always)]
    pub fn gather(&self, members: &[Member], lanes: usize) -> [Each; 9] {
        let mut rows = [[0.0; PADDED]; 9];
        for lane in 0..lanes {
            let ray = members[lane.min(members.len() - 1)];
            let (Ends { rays, hits }, at) = (&self.block[ray.batch()], ray.at());
            [rows[0][lane], rows[1][lane]] = self.places.get(ray).to_array();
            for k in 0..3 {
                rows[2 + k][lane] = rays.direction[k][at];
                rows[5 + k][lane] = rays.offset[k][at];
            }
            rows[8][lane] = hits.length[at];
        }
        rows
    }
}

/// Where rays pass through the picture [px], batch by batch.
pub struct Places(Vec<[Row; 2]>);

impl Places {
    /// Of some batches' rays.
    pub fn new(context: &Context, block: &[Ends<'_>]) -> Self {
        Self(block.iter().map(|ends| places(context, ends.rays)).collect())
    }

    /// The corners of the rectangle that a batch's first rays pass through [px].
    pub fn corners(&self, batch: usize, count: usize) -> [Vec2; 2] {
        let (mut min, mut max) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        let [x, y] = &self.0[batch];
        for (x, y) in x.iter().zip(y).take(count) {
            min =
                Vec2::new(if *x < min.x { *x } else { min.x }, if *y < min.y { *y } else { min.y });
            max =
                Vec2::new(if *x > max.x { *x } else { max.x }, if *y > max.y { *y } else { max.y });
        }
        [min, max]
    }

    /// Where those of a batch pass [px].
    pub fn batch(&self, batch: usize) -> &[Row; 2] {
        &self.0[batch]
    }

    /// Of one ray.
    pub fn get(&self, ray: Member) -> Vec2 {
        let [x, y] = &self.0[ray.batch()];
        Vec2::new(x[ray.at()], y[ray.at()])
    }
}

fn places(context: &Context, rays: &Rays) -> [Row; 2] {
    let viewpoint = &context.viewpoint;
    let (across, down) = viewpoint.picture_axes();
    let forward = viewpoint.forward.as_vec3();
    let half = 0.5 * viewpoint.size().as_vec2();
    let (mut x, mut y) = ([0.0; SIZE], [0.0; SIZE]);
    for (at, (x, y)) in x.iter_mut().zip(&mut y).enumerate().take(rays.count) {
        let point = if viewpoint.parallel {
            get3(&rays.offset, at)
        } else {
            let direction = get3(&rays.direction, at);
            direction / direction.dot(forward)
        };
        *x = (point.dot(across) + 1.0) * half.x;
        *y = (point.dot(down) + 1.0) * half.y;
    }
    [x, y]
}

/// A ray of some batches.
#[derive(Clone, Copy, Debug)]
pub struct Member(u32);

impl Member {
    /// From the batch and the place in it.
    pub fn new(batch: usize, at: usize) -> Self {
        Self((batch * SIZE + at) as u32)
    }

    /// Its batch.
    pub fn batch(self) -> usize {
        self.0 as usize / SIZE
    }

    /// Whether so many stand side by side in one batch; they are in order.
    pub fn are_run(members: &[Self], count: usize) -> bool {
        let (first, last) = (members[0], members[members.len() - 1]);
        members.len() == count
            && last.0 - first.0 == count as u32 - 1
            && first.batch() == last.batch()
    }

    /// Its place in the batch.
    pub fn at(self) -> usize {
        self.0 as usize % SIZE
    }

    /// Where it ends [m].
    pub fn length(self, block: &[Ends<'_>]) -> f32 {
        block[self.batch()].hits.length[self.at()]
    }
}
