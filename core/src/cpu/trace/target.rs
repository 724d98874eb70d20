//! The tiles of a block while their rays are traced.

use super::best::Sample;
use super::groups::{Groups, Part};
use super::screen::Area;
use super::{Block, SOLIDS_A_LOOK};
use crate::frame::viewpoint::Viewpoint;
use crate::geometry::batch::{SIZE, TILE};
use crate::num::{Lanes, Num};
use fearless_simd::Simd;
use glam::{DVec2, Vec3, Vec4};

/// A tile whose rays are traced.
pub struct Target<'r> {
    /// Its corner in the block [px].
    pub x: usize,
    /// Likewise, downwards.
    pub y: usize,
    /// What bounds its rays.
    pub sides: Sides,
    /// Where they stand.
    pub groups: &'r Groups,
    /// They and their nearest hits.
    pub samples: Vec<Sample<'r>>,
    /// How far the rays of each group still reach [m], at most.
    pub reach: Vec<f32>,
    /// How far all of them do [m].
    pub farthest: f32,
    /// Length of the ray that is nearest to the view direction, a metre deep [m].
    pub secant: f32,
    /// Solids that were met since that was looked at.
    pub met: usize,
}

/// The four planes that bound a block's rays, side by side; points on a positive side are outside.
pub struct Sides {
    normals: [Vec4; 3],
    /// Their absolute values.
    sizes: [Vec4; 3],
    offset: Vec4,
}

impl Target<'_> {
    /// What of a triangle may be seen here before all else; its slopes are told on the block's screen.
    #[inline(always)]
    pub fn part(&self, area: &Area, slopes: Option<&[[f32; 3]; 3]>) -> Option<Part> {
        let near = area.near * self.secant;
        if near > self.farthest {
            return None;
        }
        let within = |[first, last]: [usize; 2], start: usize| {
            [first.saturating_sub(start), (last - start).min(TILE - 1)]
        };
        let (x, y) = (self.x as f32, self.y as f32);
        let own = |[a, b, c]: [f32; 3]| [a, b, c + a * x + b * y];
        let slopes = slopes.map(|[u, v, w]| [own(*u), own(*v), own(*w)]);
        Some(Part { x: within(area.x, self.x), y: within(area.y, self.y), near, slopes })
    }

    /// Has met a solid: looks from time to time how far its rays still reach.
    #[inline(always)]
    pub fn look<S: Simd>(&mut self, simd: S) {
        self.met += 1;
        if self.met < SOLIDS_A_LOOK {
            return;
        }
        self.met = 0;
        self.farthest = largest(simd, &self.reach);
    }

    /// Has met a solid with all of its rays.
    #[inline(always)]
    pub fn reach_anew<S: Simd>(&mut self, simd: S) {
        for (group, reach) in self.reach.iter_mut().enumerate() {
            let place = group * Lanes::<S>::COUNT;
            if let Some(sample) = self.samples.get(place / SIZE) {
                *reach = sample.best.farthest(simd, place % SIZE);
            }
        }
        self.farthest = largest(simd, &self.reach);
    }
}

impl Sides {
    /// Of a block.
    pub fn new(block: &Block, viewpoint: &Viewpoint) -> Self {
        let origin = DVec2::new(block.x as f64, block.y as f64);
        let [w, h] = block.size.map(|size| size as f64);
        let corners = [(0.0, 0.0), (w, 0.0), (w, h), (0.0, h)];
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

    /// Whether a box lies beside all rays.
    pub fn exclude(&self, middle: Vec3, half: Vec3) -> bool {
        let ([x, y, z], [w, h, d]) = (self.normals, self.sizes);
        let beyond = x * middle.x + y * middle.y + z * middle.z - self.offset;
        let reach = w * half.x + h * half.y + d * half.z;
        beyond.cmpgt(reach * 1.000_001).any()
    }
}

#[inline(always)]
fn largest<S: Simd>(simd: S, all: &[f32]) -> f32 {
    let mut most = Lanes::splat(simd, 0.0);
    for at in (0..all.len()).step_by(Lanes::<S>::COUNT) {
        most = most.max(Lanes::load(simd, &all[at..]));
    }
    most.largest()
}
