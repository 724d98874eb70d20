//! Rays of a block, tabulated at its knots.

use super::cells::{CHECK, Cell, weights};
use super::knots::{Bounds, Knots};
use super::rule::{Met, Page, cumulate};
use super::{BLOCK, Block, Grid, Scattered};
use crate::cpu::mapped::toward_light;
use crate::cpu::places::CONTROL;
use crate::frame::context::Context;
use crate::geometry::control::{Control, Each, PADDED};
use crate::media::{Patched, Sum};
use fearless_simd::dispatch;
use glam::{Vec2, Vec3};

/// Up to this share of what a ray shows at its end an error does not matter.
const FAINT: f32 = 1e-3;
/// Lumps of which sixteen rays meet less than this share are left out: more, and where nothing but their
/// tails is seen rays that are followed together would differ from others.
const ASIDE: f32 = 1e-6;

/// What is tabulated of a ray at a knot: T and β of the lumps; then, each of all that is scattered, R, the mean of β e^(−T)
/// since the knot before, β e^(−T) itself where some lamp lights parts of rays only, and the airlight.
pub const DEPTH: usize = 0;
pub const BETA: usize = 1;
pub const RATIO: usize = 2;

/// Rays of a block at its knots.
pub struct Table<'a> {
    pub grid: &'a Grid<'a>,
    /// What of them is tabulated.
    pub scattered: &'a Scattered<'a>,
    fog: &'a Sum<dyn Patched>,
    corner: Vec2,
    /// Where they are along depth.
    pub knots: &'a Knots,
    /// Which ray passes through a place of the block, by whole pixels.
    known: Vec<u32>,
    /// Sixteen rays a page, each `[knot][field]`.
    pages: Vec<Vec<Each>>,
}

const SIDE: usize = BLOCK + 1;
const NONE: u32 = u32::MAX;

impl<'a> Table<'a> {
    pub fn new(grid: &'a Grid<'a>, scattered: &'a Scattered<'a>, block: &'a Block) -> Self {
        let Block { corner, fog, knots, .. } = block;
        let known = vec![NONE; SIDE * SIDE];
        Self { grid, scattered, fog, corner: *corner, knots, known, pages: Vec::new() }
    }

    /// The sections of a sample's ray.
    pub fn bounds(&self, start: Vec3, direction: Vec3) -> Bounds {
        self.knots.bounds(&self.grid.haze, start, direction)
    }

    /// Numbers of a ray at a knot.
    fn fields(&self) -> usize {
        self.light() + self.scattered.asked.len()
    }

    /// The first field of the airlight; those before it are looked up.
    pub fn light(&self) -> usize {
        let each = if self.scattered.has_parted() { 3 } else { 2 };
        RATIO + each * self.scattered.asked.len()
    }

    fn place(&self, place: Vec2) -> usize {
        let at = place - self.corner;
        at.y as usize * SIDE + at.x as usize
    }

    /// A field of a ray at a knot.
    #[inline(always)]
    pub fn at(&self, ray: usize, knot: usize, field: usize) -> f32 {
        self.pages[ray / PADDED][knot * self.fields() + field][ray % PADDED]
    }

    /// What the rays around a cell have at its knots `first` to `last`: `[knot][field][ray]`.
    pub fn copy(&self, cell: &Cell, first: usize, last: usize) -> Vec<[f32; CONTROL]> {
        let width = self.light();
        let mut copy = Vec::with_capacity((last + 1 - first) * width);
        let rays = self.rays(cell);
        for knot in first..=last {
            for field in 0..width {
                copy.push(rays.map(|ray| self.at(ray, knot, field)));
            }
        }
        copy
    }

    /// The rays of a cell.
    pub fn rays(&self, cell: &Cell) -> [usize; CONTROL] {
        if let Some(own) = cell.own {
            return [own; CONTROL];
        }
        cell.rays().map(|place| self.known[self.place(place)] as usize)
    }

    /// Tabulates the rays through some places, as far as they are not known.
    pub fn follow(&mut self, places: impl Iterator<Item = Vec2>) {
        let mut new = Vec::new();
        for place in places {
            let at = self.place(place);
            if self.known[at] == NONE {
                self.known[at] = (self.pages.len() * PADDED + new.len()) as u32;
                new.push(place);
            }
        }
        self.add(&new);
    }

    /// Tabulates rays through some other places; returns the first.
    pub fn add(&mut self, places: &[Vec2]) -> usize {
        let first = self.pages.len() * PADDED;
        for some in places.chunks(PADDED) {
            let page = self.page(some);
            self.pages.push(page);
        }
        first
    }

    /// The rays through up to sixteen places.
    fn page(&self, places: &[Vec2]) -> Vec<Each> {
        let Context { job, viewpoint, lamps, scatters, .. } = self.grid.context;
        let place = |c: usize| places[c.min(places.len() - 1)].as_dvec2();
        let rays = Control::new(|c| viewpoint.ray(place(c)));
        let met = self.fog.on_rays(job.level, &rays, viewpoint.parallel, ASIDE);
        let groups = self.grid.context.field.groups().len();
        let t = self.knots.rows(&self.grid.haze, &rays);
        let fields = met.knotted(job.level, groups, &t);
        let count = self.scattered.asked.len();
        let mut page = vec![[0.0; PADDED]; t.len() * self.fields()];
        for (k, rows) in page.chunks_mut(self.fields()).enumerate() {
            (rows[DEPTH], rows[BETA]) = (fields.lumps_depth[k], fields.lumps_beta[k]);
        }
        let mut of_lamp = None;
        let mut mean = Vec::new();
        for (slot, i) in self.scattered.asked.iter().enumerate() {
            let scatter = &scatters[*i];
            let lamp = &lamps[scatter.lamp];
            if of_lamp != Some(scatter.lamp) {
                mean = toward_light(self.grid.context, lamp, &rays, &t);
                of_lamp = Some(scatter.lamp);
            }
            let glow = &self.scattered.glows[slot];
            let [beta, own] = &fields.groups[scatter.group];
            let met = Met { t: &t, beta, own, depth: &fields.depth, mean: &mean };
            let fields = [RATIO + slot, RATIO + count + slot, self.light() + slot];
            let seen = self.scattered.has_parted().then_some(RATIO + 2 * count + slot);
            let (knots, width) = (self.knots, self.fields());
            let mut put = Page { knots, rows: &mut page, width, fields, seen };
            dispatch!(job.level, simd => cumulate(simd, glow, lamp, &rays, &met, &mut put));
        }
        page
    }

    /// The knots before the nearest and behind the farthest end of a cell's samples, on the ray that it is
    /// checked by.
    pub fn around(&self, cell: &Cell) -> [usize; 2] {
        let (start, direction) = self.grid.context.viewpoint.ray(cell.check().as_dvec2());
        let bounds = self.bounds(start.as_vec3(), direction.as_vec3());
        let count = self.knots.count();
        let behind =
            |end: f32| (0..count).find(|k| self.knots.on(&bounds, *k) >= end).unwrap_or(count - 1);
        let [nearest, deepest] = cell.ends.map(behind);
        [nearest.saturating_sub(1), deepest]
    }

    /// Whether a ray within a cell differs from what those around make of it, where samples end.
    pub fn is_rough(&self, cell: &Cell, own: usize, tolerance: f32) -> bool {
        let around = self.rays(cell);
        let weights = weights(CHECK[0], CHECK[1]).map(|weight| weight as f32);
        let [first, last] = self.around(cell);
        let between = |k: usize, field: usize| {
            let each = around.iter().zip(weights);
            each.map(|(ray, weight)| weight * self.at(*ray, k, field)).sum::<f32>()
        };
        let count = self.scattered.asked.len();
        let is_near = cell.near(self.grid, self.scattered);
        (first..=last).any(|k| {
            let depth = self.at(own, k, DEPTH);
            let off = (between(k, DEPTH) - depth).abs() * (-depth).exp();
            let seen = -(-depth).exp_m1();
            if off > tolerance * seen.max(self.grid.fineness.unseen) {
                return true;
            }
            // What no haze fills and few lumps reach.
            if self.grid.haze.is_empty() && depth < self.grid.fineness.unseen {
                return false;
            }
            let faint = |slot: usize| {
                let light = self.light() + slot;
                self.at(own, k, light) <= FAINT * self.at(own, last, light)
            };
            (0..count).any(|slot| {
                let exact = self.at(own, k, RATIO + slot);
                !is_near[slot]
                    && !faint(slot)
                    && (between(k, RATIO + slot) - exact).abs() > tolerance * exact
            })
        }) || (0..count).filter(|slot| is_near[*slot]).any(|slot| {
            // What the interpolated means miss of the light up to each knot.
            let (mean, light) = (RATIO + count + slot, self.light() + slot);
            let (mut off, mut before) = (0.0, 0.0);
            (0..=last).any(|k| {
                let [exact, sum] = [mean, light].map(|field| self.at(own, k, field));
                let gain = sum - before;
                before = sum;
                if exact > 0.0 {
                    off += (between(k, mean) / exact - 1.0) * gain;
                }
                k >= first && sum > FAINT * self.at(own, last, light) && off.abs() > tolerance * sum
            })
        })
    }
}
