//! A triangle as rays meet it: where it appears on the screen, and its edge functions.

use crate::frame::viewpoint::{Tile, Viewpoint};
use crate::geometry::batch::TILE;
use crate::num::Lanes;
use crate::vector::V3;
use fearless_simd::Simd;
use glam::{DVec2, Vec2, Vec3, Vec3A};

/// A rectangle of a tile's pixels, ends included.
pub struct Area {
    /// First column.
    pub left: usize,
    /// Last column.
    pub right: usize,
    /// First row.
    pub top: usize,
    /// Last row.
    pub bottom: usize,
}

/// Where points relative to the camera appear among a tile's samples.
pub struct Screen {
    forward: Vec3A,
    /// Products with a point, divided by its depth under perspective [px].
    x: Vec3A,
    y: Vec3A,
    /// Added to that: the picture's middle relative to the tile, less the samples' largest and
    /// smallest shifts [px].
    first: Vec2,
    last: Vec2,
    parallel: bool,
}

impl Screen {
    /// For a tile whose rays are shifted within their pixels by so much.
    pub fn new(viewpoint: &Viewpoint, tile: Tile, [least, most]: [DVec2; 2]) -> Self {
        let half = 0.5 * viewpoint.size();
        let (x, y) = viewpoint.picture_axes();
        let middle = half - DVec2::new(tile.x as f64, tile.y as f64);
        Self {
            forward: viewpoint.forward.as_vec3a(),
            x: Vec3A::from(x) * half.x as f32,
            y: Vec3A::from(y) * half.y as f32,
            first: (middle - most).as_vec2(),
            last: (middle - least).as_vec2(),
            parallel: viewpoint.parallel,
        }
    }

    /// The tile's pixels that a triangle may cover.
    #[inline(always)]
    pub fn covered(&self, [a, b, c]: [Vec3; 3]) -> Option<Area> {
        // The corners side by side.
        let xs = Vec3A::new(a.x, b.x, c.x);
        let ys = Vec3A::new(a.y, b.y, c.y);
        let zs = Vec3A::new(a.z, b.z, c.z);
        let along = |v: Vec3A| xs * v.x + ys * v.y + zs * v.z;
        let (mut x, mut y) = (along(self.x), along(self.y));
        if !self.parallel {
            let depth = along(self.forward);
            // Close to the eye's plane the projection says nothing.
            if depth.cmplt(1e-3 * xs.abs().max(ys.abs()).max(zs.abs())).any() {
                return Some(Area { left: 0, right: TILE - 1, top: 0, bottom: TILE - 1 });
            }
            let inverse = depth.recip();
            (x, y) = (x * inverse, y * inverse);
        }
        let (left, right) = range(x, self.first.x, self.last.x)?;
        let (top, bottom) = range(y, self.first.y, self.last.y)?;
        Some(Area { left, right, top, bottom })
    }
}

/// Pixels whose sample lies between corners, and a hundredth for the rounding of projections.
#[inline(always)]
fn range(corners: Vec3A, first: f32, last: f32) -> Option<(usize, usize)> {
    const ROOM: f32 = 0.01;
    let last = corners.max_element() + last + ROOM;
    // Truncation of a little less than one more: rounds up, by way of one instruction.
    let first = (corners.min_element() + first + (1.0 - 2.0 * ROOM)) as usize;
    (last >= first as f32 && first < TILE).then(|| (first, (last as usize).min(TILE - 1)))
}

/// A function that is linear in the ray: a constant and a vector.
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

/// Three edge functions and the numerator of the distance.
pub struct Edges(pub [Linear; 4]);

impl Edges {
    /// Of a triangle relative to the camera.
    #[inline(always)]
    pub fn new([a, b, c]: [Vec3; 3], viewpoint: &Viewpoint) -> Self {
        let face = (b - a).cross(c - a);
        let d = viewpoint.forward.as_vec3();
        let edge = |p: Vec3, q: Vec3| {
            // Always formed from the same end: what two triangles share is then equal to the bit,
            // and the difference of the ends keeps the digits of a small triangle far away.
            let flipped = (p.x, p.y, p.z) > (q.x, q.y, q.z);
            let (p, q, sign) = if flipped { (q, p, -1.0) } else { (p, q, 1.0) };
            if viewpoint.parallel {
                let aside = p - d * p.dot(d);
                Linear(sign * d.dot(aside.cross(q - p)), sign * (p - q).cross(d))
            } else {
                Linear(0.0, sign * p.cross(q - p))
            }
        };
        let slope = if viewpoint.parallel { -face } else { Vec3::ZERO };
        Self([edge(b, c), edge(c, a), edge(a, b), Linear(a.dot(face), slope)])
    }
}
