//! Antialiasing of surface edges: only pixels whose neighbours see another surface, another
//! orientation or another depth are sampled again, within their area.

use super::tiles::by_blocks;
use super::trace::{self, Cast, Groups, Order, extent};
use crate::frame::context::Context;
use crate::frame::samples::{shifts, weighs};
use crate::frame::viewpoint::Tile;
use crate::geometry::batch::{Ends, Hits, Rays, SIZE, TILE, get3};
use crate::progress::Interrupted;
use glam::DVec2;

/// The samples of a tile's edge pixels, as many side by side as a batch holds.
#[derive(Clone, Debug, Default)]
pub struct Samples {
    /// Places of the pixels in the tile, whose samples follow each other.
    pub places: Vec<usize>,
    rays: Vec<Rays>,
    hits: Vec<Box<Hits>>,
}

impl Samples {
    /// Finds the edges of all tiles and where their samples end, tile by tile.
    ///
    /// # Errors
    /// [`Interrupted`] when the job's progress says so.
    pub fn of_all(context: &Context, hits: &[Box<Hits>]) -> Result<Vec<Self>, Interrupted> {
        let shifts = shifts(context.view.samples.unwrap_or(1) as usize);
        by_blocks(context, 0..context.grid.count(), trace::ACROSS, |block| {
            Self::of_block(context, hits, &shifts, block)
        })
    }

    fn of_block(
        context: &Context,
        all: &[Box<Hits>],
        shifts: &[DVec2],
        block: &[usize],
    ) -> Vec<Self> {
        let mut samples = Vec::with_capacity(block.len());
        let mut groups = Vec::with_capacity(block.len());
        for index in block {
            let places = edge_places(context, all, *index);
            let order = Order { places: &places, shifts };
            let rays = rays(context, context.grid.tile(*index), &order);
            groups.push(Groups::new(&order, context.job.level));
            samples.push(Self { places, rays, hits: Vec::new() });
        }
        let casts = block.iter().zip(&samples).zip(&groups).map(|((index, samples), groups)| {
            Cast { tile: context.grid.tile(*index), rays: &samples.rays, groups }
        });
        let casts: Vec<_> = casts.filter(|cast| !cast.rays.is_empty()).collect();
        let mut made = trace::block(context, extent(shifts), &casts).into_iter();
        for samples in samples.iter_mut().filter(|samples| !samples.is_empty()) {
            samples.hits = made.next().unwrap_or_default();
            for (rays, hits) in samples.rays.iter().zip(&mut samples.hits) {
                hits.pad(rays.count - 1);
            }
        }
        samples
    }

    /// Their batches.
    pub fn ends(&self) -> impl Iterator<Item = Ends<'_>> {
        self.rays.iter().zip(&self.hits).map(|(rays, hits)| Ends { rays, hits })
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Bytes that they take.
    pub fn bytes(&self) -> usize {
        size_of_val(self.places.as_slice())
            + self.rays.iter().map(Rays::bytes).sum::<usize>()
            + self.hits.iter().map(|hits| hits.bytes()).sum::<usize>()
    }
}

/// Places of the tile whose pixel differs from a neighbour.
fn edge_places(context: &Context, hits: &[Box<Hits>], index: usize) -> Vec<usize> {
    let (grid, tile) = (context.grid, context.grid.tile(index));
    let mut edge = [false; SIZE];
    // Every pair once: each pixel with the next to its right and the next below, from the last column
    // and the last line of the tiles before on.
    for (dx, dy) in [(1, 0), (0, 1)] {
        for y in (tile.y + 1 - dy).saturating_sub(1)..(tile.y + TILE).min(grid.height - dy) {
            for x in (tile.x + 1 - dx).saturating_sub(1)..(tile.x + TILE).min(grid.width - dx) {
                let (a, i) = grid.locate(x, y);
                let (b, j) = grid.locate(x + dx, y + dy);
                if is_edge(&hits[a], i, &hits[b], j) {
                    edge[i] |= a == index;
                    edge[j] |= b == index;
                }
            }
        }
    }
    (0..SIZE).filter(|place| edge[*place]).collect()
}

fn is_edge(a: &Hits, i: usize, b: &Hits, j: usize) -> bool {
    if a.surface[i] != b.surface[j] {
        return true;
    }
    let (normal, other) = (get3(&a.normal, i), get3(&b.normal, j));
    let (near, far) = (a.length[i].min(b.length[j]), a.length[i].max(b.length[j]));
    let bent = normal != other && normal.dot(other) < 0.8;
    // A jump between two parts of one surface that face the same way.
    bent || far > 1.5 * near
}

/// The samples of one pixel after the other.
fn rays(context: &Context, tile: Tile, order: &Order) -> Vec<Rays> {
    let mut batches: Vec<Rays> = Vec::new();
    for place in order.places {
        let (x, y) = tile.pixel(*place);
        for shift in order.shifts {
            if batches.last().is_none_or(|batch| batch.count == SIZE) {
                batches.push(Rays::empty());
            }
            let ray = context.viewpoint.ray(DVec2::new(x as f64, y as f64) + *shift);
            if let Some(batch) = batches.last_mut() {
                batch.push_ray(ray);
            }
        }
    }
    if let Some(last) = batches.last_mut() {
        last.pad();
    }
    batches
}

/// On a screen a lamp's rim is a rim only if its radiance counts no more than white.
pub fn weight(context: &Context, value: [f32; 3]) -> f32 {
    if !weighs(&context.view) {
        return 1.0;
    }
    let exposed = value.into_iter().fold(0.0, f32::max) * context.view.exposure_ev.exp2() as f32;
    // Of endless light nothing would be left to divide by.
    1.0 / (1.0 + exposed.min(f32::MAX))
}
