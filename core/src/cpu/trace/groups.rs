//! Where the rays of a tile stand on the screen: a box around as many as a register holds, so that a
//! triangle meets those registers only that it may touch.

use crate::geometry::batch::TILE;
use crate::num::{Lanes, Num};
use fearless_simd::{Level, Simd, SimdMask, dispatch};
use glam::DVec2;
use std::ops::Range;

/// How a tile's rays stand in its batches: pixel after pixel, each with the same samples.
#[derive(Clone, Copy)]
pub struct Order<'a> {
    /// Places of the pixels in the tile, in order.
    pub places: &'a [usize],
    /// The samples of each, within it.
    pub shifts: &'a [DVec2],
}

/// Smallest and largest of some shifts within a pixel.
pub fn extent(shifts: &[DVec2]) -> [DVec2; 2] {
    let all = || shifts.iter().copied();
    [all().fold(DVec2::ONE, DVec2::min), all().fold(DVec2::ZERO, DVec2::max)]
}

/// Boxes around the rays of each register, side by side [px of the tile].
pub struct Groups {
    left: Vec<f32>,
    right: Vec<f32>,
    top: Vec<f32>,
    bottom: Vec<f32>,
    /// The groups that each row of pixels is in.
    rows: [Range<usize>; TILE],
}

/// What of a tile something may touch.
pub struct Part {
    /// First and last column.
    pub x: [usize; 2],
    /// First and last row.
    pub y: [usize; 2],
    /// Lower bound of the distance at which it begins [m].
    pub near: f32,
    /// Three functions c + a·x + b·y as (a, b, c), of which none is negative where it appears.
    pub slopes: Option<[[f32; 3]; 3]>,
}

/// Where a function that is linear on the screen may be positive: c + a·x + b·y.
struct Slope<'a> {
    a: f32,
    b: f32,
    c: f32,
    /// The sides of the boxes on which it is largest.
    x: &'a [f32],
    y: &'a [f32],
}

impl Groups {
    /// The boxes of this machine's registers.
    pub fn new(order: &Order<'_>, level: Level) -> Self {
        let lanes = dispatch!(level, simd => lanes(simd));
        let Order { places, shifts } = order;
        let count = (places.len() * shifts.len()).div_ceil(lanes);
        // Boxes of no rays are met by nothing.
        let empty = vec![f32::NAN; count.next_multiple_of(lanes)];
        let (mut left, mut right) = (empty.clone(), empty.clone());
        let (mut top, mut bottom) = (empty.clone(), empty);
        let [least, most] = extent(shifts);
        for group in 0..count {
            let pixel = |ray: usize| (ray / shifts.len()).min(places.len() - 1);
            let (first, last) = (pixel(group * lanes), pixel((group + 1) * lanes - 1));
            let columns = || places[first..=last].iter().map(|place| (place % TILE) as f32);
            left[group] = columns().fold(f32::MAX, f32::min) + least.x as f32;
            right[group] = columns().fold(0.0, f32::max) + most.x as f32;
            top[group] = (places[first] / TILE) as f32 + least.y as f32;
            bottom[group] = (places[last] / TILE) as f32 + most.y as f32;
        }
        let before = |row| places.partition_point(|place| *place < row * TILE) * shifts.len();
        let rows = |row| before(row) / lanes..before(row + 1).div_ceil(lanes);
        Self { left, right, top, bottom, rows: std::array::from_fn(rows) }
    }

    /// How many groups there are, and as many more as fill a register.
    pub fn count(&self) -> usize {
        self.left.len()
    }

    /// Where the registers of groups start that are in a part of the tile.
    #[inline(always)]
    pub fn registers<S: Simd>(
        &self,
        _simd: S,
        part: &Part,
    ) -> impl Iterator<Item = usize> + use<S> {
        let lanes = Lanes::<S>::COUNT;
        let groups = self.rows_of(part);
        (groups.start / lanes * lanes..groups.end).step_by(lanes)
    }

    fn rows_of(&self, part: &Part) -> Range<usize> {
        self.rows[part.y[0]].start..self.rows[part.y[1]].end
    }

    /// Bits of the groups from a place on, as many as there are lanes, that reach a part of the tile and of which a
    /// ray may lie in it.
    #[inline(always)]
    pub fn open<S: Simd>(&self, simd: S, at: usize, part: &Part, reach: &[f32]) -> u64 {
        let near = Lanes::splat(simd, part.near);
        let left = near.lit(part.x[0] as f64);
        let right = near.lit(part.x[1] as f64 + 1.0);
        let mut open = near.lt(Lanes::load(simd, &reach[at..]))
            & Lanes::load(simd, &self.left[at..]).lt(right)
            & left.lt(Lanes::load(simd, &self.right[at..]));
        if let Some([u, v, w]) = part.slopes {
            let (u, v, w) = (self.slope(u), self.slope(v), self.slope(w));
            let least = u.most(simd, at).min(v.most(simd, at)).min(w.most(simd, at));
            open &= least.lit(0.0).lt(least);
        }
        // Of the first and the last register only those in the rows.
        let rows = self.rows_of(part);
        open.to_bitmask() & ones(rows.start.max(at) - at, rows.end - at)
    }

    #[inline(always)]
    fn slope(&self, [a, b, c]: [f32; 3]) -> Slope<'_> {
        let x = if a > 0.0 { &self.right } else { &self.left };
        let y = if b > 0.0 { &self.bottom } else { &self.top };
        Slope { a, b, c, x, y }
    }
}

/// Bits from a place to before another one, as far as a word goes.
#[inline(always)]
fn ones(from: usize, to: usize) -> u64 {
    (u64::MAX >> (64 - to.min(64))) & (u64::MAX << from)
}

#[inline(always)]
fn lanes<S: Simd>(_simd: S) -> usize {
    Lanes::<S>::COUNT
}

impl Slope<'_> {
    /// Its largest values in boxes.
    #[inline(always)]
    fn most<S: Simd>(&self, simd: S, at: usize) -> Lanes<S> {
        let [x, y] = [self.x, self.y].map(|side| Lanes::load(simd, &side[at..]));
        let [a, b, c] = [self.a, self.b, self.c].map(|k| Lanes::splat(simd, k));
        x.mul_add(a, y.mul_add(b, c))
    }
}
