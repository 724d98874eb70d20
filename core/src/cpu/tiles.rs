//! Work on all tiles of a picture.

use crate::frame::context::Context;
use crate::frame::viewpoint::Grid;
use crate::geometry::batch::{Row, TILE};
use crate::progress::Interrupted;
use rayon::prelude::*;
use std::ops::Range;

/// Whole lines of a picture's tiles, whose light is formed together: what it takes in memory does not
/// grow with the picture.
#[derive(Clone, Debug)]
pub struct Strip {
    /// Its tiles.
    pub tiles: Range<usize>,
}

impl Strip {
    /// Lines of tiles that no strip cuts: a draft's fog is interpolated across as many.
    const LINES: usize = 4;
    /// Bytes of rows that stand at a time, but for those of edges.
    const BYTES: usize = 128 << 20;

    /// The strips of a picture of which each tile has so many rows of numbers: all of it, if they fit.
    pub fn all(grid: Grid, rows: usize) -> Vec<Self> {
        let line = grid.width.div_ceil(TILE);
        let bytes = Self::LINES * line * rows * size_of::<Row>();
        let step = Self::LINES * line * (Self::BYTES / bytes.max(1)).max(1);
        let starts = (0..grid.count()).step_by(step);
        starts.map(|first| Self { tiles: first..(first + step).min(grid.count()) }).collect()
    }

    /// Its lines of pixels.
    pub fn lines(&self, grid: Grid) -> Range<usize> {
        let line = |tile: usize| (tile / grid.width.div_ceil(TILE) * TILE).min(grid.height);
        line(self.tiles.start)..line(self.tiles.end)
    }

    /// Where a tile of the picture stands in it.
    pub fn place(&self, tile: usize) -> usize {
        tile - self.tiles.start
    }
}

/// What is made of some tiles, unless the job ends: then the rest is `blank`, which lets every
/// tile be written at its place.
pub fn tiles<T: Clone + Send + Sync>(
    context: &Context,
    places: Range<usize>,
    blank: &T,
    work: impl Fn(usize) -> T + Sync + Send,
) -> Result<Vec<T>, Interrupted> {
    /// Tiles that one thread takes at once: inside its pool a job would be cut in a few pieces only,
    /// and threads would wait for the slowest.
    const AT_ONCE: usize = 8;
    let is_over = || context.job.progress.is_over();
    let tile = |index| if is_over() { blank.clone() } else { work(index) };
    let done = places.into_par_iter().with_max_len(AT_ONCE).map(tile).collect();
    context.job.progress.check().map(|()| done)
}

/// The same of blocks of up to `across` by `across` neighbouring tiles at once, one by one, because some take ten
/// times as long as others: `work` is given a block's tiles in order. No block may reach out of `places`.
pub fn by_blocks<T: Default + Send>(
    context: &Context,
    places: Range<usize>,
    across: usize,
    work: impl Fn(&[usize]) -> Vec<T> + Sync + Send,
) -> Result<Vec<T>, Interrupted> {
    let mut blocks = context.grid.blocks(across);
    blocks.retain(|block| places.contains(&block[0]));
    let is_over = || context.job.progress.is_over();
    let block = |block: &Vec<usize>| if is_over() { Vec::new() } else { work(block) };
    let made: Vec<_> = blocks.par_iter().with_max_len(1).map(block).collect();
    context.job.progress.check()?;
    let mut by_tile = Vec::new();
    by_tile.resize_with(places.len(), T::default);
    for (index, made) in blocks.into_iter().flatten().zip(made.into_iter().flatten()) {
        by_tile[index - places.start] = made;
    }
    Ok(by_tile)
}
