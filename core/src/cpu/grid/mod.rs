//! Airlight of pictures for the eye and of drafts: tabulated on a coarse grid of rays, cumulative along depth,
//! and looked up by every sample at its own ray and its own end. Silhouettes, edge samples and ends before a
//! lamp are look-ups like any other.
//!
//! What is tabulated varies little from ray to ray and along a ray: the airlight up to t, L(t), divided by
//! what is known in closed form,
//!
//! ```text
//! R(t) = L(t) / (M(t) · (1 − e^(−T(t)) + ε t)/t),   M(t) = ∫ dt/d² from 0 to t = angle/h,
//! ```
//!
//! M the glow of a lamp without fog, its angle seen over its distance h from the ray (Macklin 2010), and T
//! that of the view ray. A sample multiplies R by its own M and T again. T of the haze is its own; that of
//! the lumps comes from the same rays.
//!
//! Of a lamp that lights parts of rays only, by a cone or between shadows, a sample takes a share of that: of the means of
//! β e^(−T) from knot to knot, each times the glow of what its own ray passes of the light there.
//!
//! A block of the picture shares its knots along depth, and its rays serve several lamps. It is cut into square
//! cells; eight rays around a cell tell what lies between. A cell is quartered near a lamp's image, where
//! lumps are too small for it, an edge of the fog passes, or a ninth ray shows that the eight do not tell it.
//! Samples of the smallest cells of which that holds get rays of their own.

mod cells;
mod glow;
mod knots;
mod look_up;
mod rule;
mod table;

use super::places::{Places, Samples};
use super::views::{lengths, near_views};
use crate::frame::context::Context;
use crate::frame::tolerance::Fineness;
use crate::frame::viewpoint::Tile;
use crate::geometry::batch::{Ends, Fogged};
use crate::media::{Legs, Patched, Purpose, Smooth, Sum};
use cells::{Cell, Passed};
use glam::Vec2;
use glow::Glow;
use knots::Knots;
use table::Table;

/// Pixels along the side of a block.
pub const BLOCK: usize = 64;

/// How much is tabulated on the same rays: the cells of more lamps would cut up each other's, and all their numbers
/// would not stay near.
const TOGETHER: usize = 8;

/// What all blocks of a frame share.
pub struct Grid<'a> {
    context: &'a Context<'a>,
    scattered: Vec<Scattered<'a>>,
    haze: Sum<dyn Smooth>,
    /// Whether that has edges.
    has_edges: bool,
    fineness: Fineness,
    /// Whether shares of the light are told, not the light.
    tells_shares: bool,
}

/// What is scattered of a few lamps, tabulated on the same rays.
struct Scattered<'a> {
    asked: &'a [usize],
    /// How many come before them.
    before: usize,
    /// Whether none come after them.
    is_last: bool,
    /// How the lamp of each glows.
    glows: Vec<Glow>,
    /// Where it appears [px].
    images: Vec<Option<Vec2>>,
    /// Whether it lights parts of rays only.
    are_parted: Vec<bool>,
}

impl Scattered<'_> {
    /// Whether any lamp lights parts of rays only.
    fn has_parted(&self) -> bool {
        self.are_parted.contains(&true)
    }
}

/// A block's samples, and the fog before them.
struct Block<'a> {
    corner: Vec2,
    samples: Samples<'a>,
    fog: Sum<dyn Patched>,
    knots: Knots,
    passed: Passed,
}

impl<'a> Grid<'a> {
    /// For what is scattered of some lamps.
    pub fn new(context: &'a Context<'a>, asked: &'a [usize]) -> Self {
        let haze = context.field.smooth(context.viewpoint.position, Legs::OfEyes);
        let together = |(i, some): (usize, &'a [usize])| Scattered {
            asked: some,
            before: i * TOGETHER,
            is_last: i * TOGETHER + some.len() == asked.len(),
            glows: some.iter().map(|i| Glow::new(context.scatters[*i].phase)).collect(),
            images: cells::images(context, some),
            are_parted: some.iter().map(|i| context.lamp_of(*i).is_parted()).collect(),
        };
        Self {
            context,
            scattered: asked.chunks(TOGETHER).enumerate().map(together).collect(),
            has_edges: haze.has_edges(),
            haze,
            fineness: Fineness::of(&context.view, context.field),
            tells_shares: context.takes_shares(),
        }
    }

    /// Adds what is scattered along the rays of some batches that pass through a block of the picture, given
    /// by its first tile, and what the lumps take away.
    pub fn light(&self, corner: Tile, block: &[Ends<'_>], fogged: &mut [Fogged]) {
        let context = self.context;
        let corner = Vec2::new(corner.x as f32, corner.y as f32);
        let places = Places::new(context, block);
        let fog = near_views(context, block, Purpose::Nodes).patched();
        let samples = Samples { block, places: &places };
        let [_, deepest] = lengths(context, block);
        let Some(knots) = Knots::new(self, &fog, corner, deepest) else { return };
        let passed = Passed::new(self, &samples, knots.ends());
        let block = Block { corner, samples, fog, knots, passed };
        for scattered in &self.scattered {
            self.light_of(scattered, &block, fogged);
        }
    }

    /// Leaves of the light that is there what cones and shadows leave.
    pub fn take_shares(&self, corner: Tile, block: &[Ends<'_>], fogged: &mut [Fogged]) {
        let lamps = self.scattered.iter().map(|own| own.asked.len()).sum();
        let mut shares: Vec<_> = block.iter().map(|_| Fogged::clear(lamps)).collect();
        self.light(corner, block, &mut shares);
        let parted = self.scattered.iter().flat_map(|own| &own.are_parted);
        for (slot, _) in parted.enumerate().filter(|(_, parted)| **parted) {
            for (fogged, shares) in fogged.iter_mut().zip(&shares) {
                let light = fogged.airlight[slot].iter_mut().zip(&shares.airlight[slot]);
                light.for_each(|(light, share)| *light *= share);
            }
        }
    }

    /// The same of a few lamps.
    fn light_of(&self, scattered: &Scattered, block: &Block, fogged: &mut [Fogged]) {
        let Block { corner, samples, .. } = block;
        let fineness = self.fineness;
        let mut open = cells::of_block(samples, *corner, fineness.side);
        let mut table = Table::new(self, scattered, block);
        let mut alone = Vec::new();
        while !open.is_empty() && !self.context.job.progress.is_over() {
            let (whole, mut split): (Vec<_>, Vec<_>) =
                open.into_iter().partition(|cell| !cell.is_coarse(self, scattered, block));
            table.follow(whole.iter().flat_map(Cell::rays));
            let first = table.add(&whole.iter().map(Cell::check).collect::<Vec<_>>());
            for (i, cell) in whole.into_iter().enumerate() {
                if table.is_rough(&cell, first + i, fineness.rough) {
                    split.push(cell);
                } else {
                    look_up::cell(&table, &cell, samples, fogged);
                }
            }
            let (least, larger) = split.into_iter().partition::<Vec<_>, _>(Cell::is_least);
            alone.extend(least.into_iter().flat_map(|cell| cell.alone(samples)));
            open = larger.into_iter().flat_map(|cell| cell.quarters(samples)).collect();
        }
        // Where neighbours have nothing to tell each other.
        let first = table.add(&alone.iter().map(Cell::middle).collect::<Vec<_>>());
        for (i, cell) in alone.iter_mut().enumerate() {
            cell.own = Some(first + i);
            look_up::cell(&table, cell, samples, fogged);
        }
    }
}
