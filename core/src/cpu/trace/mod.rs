//! First hits of the rays of a block of tiles: the hierarchy is walked once for all of them, front to back, and
//! what remains is met by as many rays at once as there are lanes.

mod best;
mod groups;
mod linear;
mod meet;
mod resolve;
mod screen;
mod target;
mod triangle;

pub use groups::{Groups, Order, extent};

use crate::frame::context::Context;
use crate::frame::viewpoint::{Tile, Viewpoint};
use crate::geometry::batch::{Hits, NOTHING, Rays, SIZE, TILE};
use crate::geometry::hierarchy::{Bounds, WAITING};
use crate::progress::Progress;
use crate::shapes::Geometry;
use best::{Best, Sample};
use fearless_simd::{Simd, dispatch};
use glam::{DVec2, DVec3};
use screen::Screen;
use target::{Sides, Target};
use triangle::Waiting;

/// Solids between two looks at how far a tile's rays still reach.
const SOLIDS_A_LOOK: usize = 24;
/// The bits of an id that tell its kind; the rest is a place among that kind in [`Geometry`].
const KIND: u32 = 3 << 30;
const TRIANGLE: u32 = 0;
const SPHERE: u32 = 1 << 30;
const CUBOID: u32 = 2 << 30;
const PLANE: u32 = 3 << 30;

/// Tiles along a side of a block: so many share a walk and what is made of a triangle, while their rays
/// stay in the cache of a core.
pub const ACROSS: usize = 4;

/// A rectangle of pixels, of whole tiles.
pub struct Block {
    /// Left column.
    pub x: usize,
    /// Top row.
    pub y: usize,
    /// Pixels across and down.
    pub size: [usize; 2],
}

/// A tile's rays, which stand in that order.
pub struct Cast<'r> {
    /// The tile.
    pub tile: Tile,
    /// Its rays.
    pub rays: &'r [Rays],
    /// Where they stand.
    pub groups: &'r Groups,
}

/// First hits of the rays of neighbouring tiles, [`ACROSS`] by as many at most, which are shifted within their pixels by so much; some
/// are missing if the job is over.
pub fn block(context: &Context, shifts: [DVec2; 2], casts: &[Cast<'_>]) -> Vec<Vec<Box<Hits>>> {
    let Some(block) = Block::around(casts.iter().map(|cast| cast.tile)) else { return Vec::new() };
    let tracer = Tracer::new(context, &block, shifts, casts);
    dispatch!(context.job.level, simd => tracer.trace(simd, &block, casts, context.far_m))
}

impl Block {
    fn around(tiles: impl Iterator<Item = Tile> + Clone) -> Option<Self> {
        let (xs, ys) = (|| tiles.clone().map(|tile| tile.x), || tiles.clone().map(|tile| tile.y));
        let (x, y) = (xs().min()?, ys().min()?);
        Some(Self { x, y, size: [xs().max()? + TILE - x, ys().max()? + TILE - y] })
    }
}

/// What a block's walk through the geometry needs.
struct Tracer<'a> {
    geometry: &'a Geometry,
    viewpoint: &'a Viewpoint,
    /// The anchor relative to the camera [m].
    anchor: DVec3,
    screen: Screen,
    sides: Sides,
    /// Places among the targets of the block's tiles, row by row; of tiles without rays, none.
    tiles: [usize; ACROSS * ACROSS],
    /// Whether triangles that are hit are told.
    tells_triangles: bool,
    progress: &'a Progress,
}

impl<'a> Tracer<'a> {
    fn new(context: &'a Context, block: &Block, shifts: [DVec2; 2], casts: &[Cast<'_>]) -> Self {
        let (geometry, viewpoint) = (context.geometry, &context.viewpoint);
        let anchor = geometry.anchor - viewpoint.position;
        let screen = Screen::new(viewpoint, block, shifts);
        let sides = Sides::new(block, viewpoint);
        let mut tiles = [usize::MAX; ACROSS * ACROSS];
        for (place, Cast { tile, .. }) in casts.iter().enumerate() {
            tiles[(tile.y - block.y) / TILE * ACROSS + (tile.x - block.x) / TILE] = place;
        }
        let (tells_triangles, progress) = (context.is_per_vertex(), context.job.progress);
        Self { geometry, viewpoint, anchor, screen, sides, tiles, tells_triangles, progress }
    }

    /// Where the rays of all tiles end, in one walk, which a job that is over leaves early.
    #[inline(always)]
    fn trace<S: Simd>(
        &self,
        simd: S,
        block: &Block,
        casts: &[Cast<'_>],
        far_m: f32,
    ) -> Vec<Vec<Box<Hits>>> {
        let mut targets = Vec::with_capacity(casts.len());
        for Cast { tile, rays, groups } in casts {
            let sides =
                Sides::new(&Block { x: tile.x, y: tile.y, size: [TILE; 2] }, self.viewpoint);
            let (x, y) = (tile.x - block.x, tile.y - block.y);
            let mut samples = Vec::with_capacity(rays.len());
            for rays in *rays {
                samples.push(self.sample(simd, rays, far_m));
            }
            let reach = vec![0.0; groups.count()];
            let secant = self.secant(*tile);
            let (farthest, met) = (0.0, 0);
            let mut target = Target { x, y, sides, groups, samples, reach, farthest, secant, met };
            target.reach_anew(simd);
            targets.push(target);
        }
        self.walk(simd, &mut targets);
        let mut hits = Vec::with_capacity(targets.len());
        for target in &targets {
            let mut batches = Vec::with_capacity(target.samples.len());
            for Sample { rays, best } in &target.samples {
                batches.push(self.resolve(simd, rays, best));
            }
            hits.push(batches);
        }
        hits
    }

    /// Rays that have met nothing but planes.
    #[inline(always)]
    fn sample<'r, S: Simd>(&self, simd: S, rays: &'r Rays, far_m: f32) -> Sample<'r> {
        let zero = [0.0; SIZE];
        let mut best = Best { length: [far_m; SIZE], u: zero, v: zero, id: [NOTHING; SIZE] };
        // What fills a batch up must not look as if it still reached far.
        best.length[rays.count..].fill(0.0);
        for (id, plane) in (PLANE..).zip(&self.geometry.planes) {
            self.meet_plane(simd, plane, id, rays, &mut best);
        }
        Sample { rays, best }
    }

    #[inline(always)]
    fn walk<S: Simd>(&self, simd: S, targets: &mut [Target<'_>]) {
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
        let mut waiting = Waiting::default();
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
                    self.meet(simd, place, &mut waiting, targets);
                }
                if met >= SOLIDS_A_LOOK {
                    if self.progress.is_over() {
                        return;
                    }
                    met = 0;
                    farthest = targets.iter().map(|target| target.farthest).fold(0.0, f32::max);
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
        self.meet_waiting(simd, &mut waiting, targets);
    }

    /// Length of the tile's ray that is nearest to the view direction, a metre deep [m].
    fn secant(&self, tile: Tile) -> f32 {
        if self.viewpoint.parallel {
            return 1.0;
        }
        let middle = 0.5 * self.viewpoint.size();
        let corner = DVec2::new(tile.x as f64, tile.y as f64);
        let nearest = middle.clamp(corner, corner + TILE as f64);
        // A little less, for rounding.
        (0.999_999 / self.viewpoint.ray(nearest).1.dot(self.viewpoint.forward)) as f32
    }
}
