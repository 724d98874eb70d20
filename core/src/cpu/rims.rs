//! Soft rims of shadows on surfaces: pixels beside which there is another light are looked at again, tile by tile.

use super::passes::Depths;
use super::shadow;
use super::tiles::{Strip, tiles};
use super::traced::Traced;
use crate::frame::context::Context;
use crate::frame::samples::CENTER;
use crate::geometry::batch::{NOTHING, Row, SIZE, TILE};
use crate::progress::Interrupted;

/// How much of some lamps reaches the pixels of all tiles of a strip, lamp by lamp; `None` where nothing hides it.
pub type Seen = Vec<Vec<Option<Box<Row>>>>;

/// Adds shadows with soft rims to depths from some lamps to the pixels of a strip.
///
/// # Errors
/// [`Interrupted`] when the job's progress says so.
pub fn add(
    context: &Context,
    (traced, strip): (&Traced, &Strip),
    lamps: &[usize],
    seen: &Seen,
    depths: &mut Depths,
) -> Result<(), Interrupted> {
    let rims = Rims { context, traced, strip, seen };
    let soft = tiles(context, strip.tiles.clone(), &Vec::new(), |index| {
        let of_lamp = |(slot, lamp): (usize, &usize)| rims.softened(index, slot, *lamp);
        lamps.iter().enumerate().map(of_lamp).collect::<Vec<_>>()
    })?;
    for (own, tile) in soft.iter().zip(depths) {
        let Some(pixels) = tile.first_mut() else { continue };
        let shaded = own.iter().zip(pixels).filter_map(|(lit, depth)| Some((lit.as_ref()?, depth)));
        shaded.for_each(|(lit, depth)| shadow::add(lit, depth));
    }
    Ok(())
}

struct Rims<'a, 'c> {
    context: &'a Context<'c>,
    traced: &'a Traced,
    strip: &'a Strip,
    seen: &'a Seen,
}

impl Rims<'_, '_> {
    /// What reaches the pixels of a tile of a lamp, by its place and its slot among those that are asked for.
    fn softened(&self, index: usize, slot: usize, lamp: usize) -> Option<Box<Row>> {
        let across = self.across();
        let beside = [index + 1, index.wrapping_sub(1), index + across, index.wrapping_sub(across)];
        if self.of_tile(index, slot).is_none()
            && beside.iter().all(|i| self.of_tile(*i, slot).is_none())
        {
            return None;
        }
        let (tile, hits) = (self.context.grid.tile(index), &self.traced.tiles[index]);
        let is_rim = |at: &usize| {
            let (x, y) = tile.pixel(*at);
            let own = self.light_at(slot, x, y);
            let beside = [(x + 1, y), (x.wrapping_sub(1), y), (x, y + 1), (x, y.wrapping_sub(1))];
            let mut others = beside.into_iter().filter_map(|(x, y)| self.light_at(slot, x, y));
            own.is_some_and(|own| others.any(|other| other != own))
        };
        let rim: Vec<_> = (0..SIZE).filter(is_rim).collect();
        let own = self.of_tile(index, slot).map(|lit| Box::new(*lit));
        if rim.is_empty() {
            return own;
        }
        let mut lit = own.unwrap_or_else(|| Box::new([1.0; SIZE]));
        let rays = self.context.viewpoint.tile(tile, CENTER);
        let lamp = &self.context.lamps[lamp];
        shadow::soften(self.context, lamp, (&rays, hits), (tile, &rim), &mut lit);
        Some(lit)
    }

    /// What reaches a pixel, if it is one of the strip's and sees a surface.
    fn light_at(&self, slot: usize, x: usize, y: usize) -> Option<f32> {
        let grid = self.context.grid;
        if x >= grid.width || y >= grid.height {
            return None;
        }
        let index = y / TILE * self.across() + x / TILE;
        let at = y % TILE * TILE + x % TILE;
        if !self.strip.tiles.contains(&index) || self.traced.tiles[index].surface[at] == NOTHING {
            return None;
        }
        Some(self.of_tile(index, slot).map_or(1.0, |lit| lit[at]))
    }

    /// The same of a tile that may be one of the strip's; `None` where nothing is hidden.
    fn of_tile(&self, index: usize, slot: usize) -> Option<&Row> {
        if !self.strip.tiles.contains(&index) {
            return None;
        }
        self.seen[self.strip.place(index)].get(slot)?.as_deref()
    }

    /// Tiles of a line.
    fn across(&self) -> usize {
        self.context.grid.width.div_ceil(TILE)
    }
}
