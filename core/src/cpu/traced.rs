//! All rays of a frame and where they end: the pixels' centres tile by tile, and the samples of edges.

use super::edges::Samples;

use super::tiles::by_blocks;
use super::trace::{self, Cast, Groups, Order};
use crate::frame::context::Context;
use crate::frame::samples::CENTER;
use crate::geometry::batch::{Ends, Hits, Rays, SIZE};
use crate::progress::Interrupted;

/// Where the rays of a frame end.
#[derive(Debug)]
pub struct Traced {
    /// The pixels' centres, tile by tile.
    pub tiles: Vec<Box<Hits>>,
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
            Some(count) if count > 1 => Samples::of_all(context, &hits)?,
            _ => Vec::new(),
        };
        Ok(Self { tiles: hits, samples })
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        let samples = self.samples.iter().map(Samples::bytes).sum::<usize>();
        self.tiles.iter().map(|hits| hits.bytes()).sum::<usize>() + samples
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

fn first_hits(context: &Context) -> Result<Vec<Box<Hits>>, Interrupted> {
    let places: [usize; SIZE] = std::array::from_fn(|place| place);
    let groups = Groups::new(&Order { places: &places, shifts: &[CENTER] }, context.job.level);
    by_blocks(context, 0..context.grid.count(), trace::ACROSS, |block| {
        let tiles = block.iter().map(|index| context.grid.tile(*index));
        let rays: Vec<_> =
            tiles.clone().map(|tile| [context.viewpoint.tile(tile, CENTER)]).collect();
        let casts = tiles.zip(&rays).map(|(tile, rays)| Cast { tile, rays, groups: &groups });
        let hits = trace::block(context, [CENTER; 2], &casts.collect::<Vec<_>>());
        hits.into_iter().flatten().collect()
    })
}
