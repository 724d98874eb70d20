//! All rays of a frame and where they end: the pixels' centres tile by tile, and the samples of edges.

use super::edges::Samples;
use super::tiles::tiles;
use super::trace::{self, Order};
use crate::frame::context::Context;
use crate::frame::samples::CENTER;
use crate::geometry::batch::{Ends, Hits, Rays, TILE};
use crate::progress::Interrupted;

/// Where the rays of a frame end.
#[derive(Debug)]
pub struct Traced {
    /// The pixels' centres, tile by tile.
    pub tiles: Vec<Hits>,
    /// The samples of edge pixels, tile by tile; none if pixels have one sample.
    pub samples: Vec<Samples>,
}

impl Traced {
    /// Traces them.
    ///
    /// # Errors
    /// [`Interrupted`] when the job's progress says so.
    pub fn new(context: &Context) -> Result<Self, Interrupted> {
        let hits = first_hits(context)?;
        let samples = match context.view.samples {
            Some(count) if count > 1 => {
                let none = Samples::default();
                let of_tile = |index| Samples::new(context, &hits, index);
                tiles(context, 0..context.grid.count(), &none, of_tile)?
            }
            _ => Vec::new(),
        };
        Ok(Self { tiles: hits, samples })
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        let samples = self.samples.iter().map(Samples::bytes).sum::<usize>();
        size_of_val(self.tiles.as_slice()) + samples
    }

    /// The batches of a tile: its pixels, whose rays are given, and its samples.
    pub fn batches<'a>(
        &'a self,
        index: usize,
        rays: &'a Rays,
    ) -> impl Iterator<Item = Ends<'a>> + 'a {
        let pixels = Ends { rays, hits: &self.tiles[index] };
        let samples = self.samples.get(index).into_iter().flat_map(Samples::ends);
        [pixels].into_iter().chain(samples)
    }
}

fn first_hits(context: &Context) -> Result<Vec<Hits>, Interrupted> {
    let starts = std::array::from_fn(|row| row * TILE);
    let order = Order { starts, is_dense: true, shifts: [CENTER; 2] };
    let nothing = Hits::nothing(context.far_m);
    tiles(context, 0..context.grid.count(), &nothing, |index| {
        let rays = context.viewpoint.tile(context.grid.tile(index), CENTER);
        trace::tile(context, index, &[rays], &order).pop().unwrap_or_else(|| nothing.clone())
    })
}
