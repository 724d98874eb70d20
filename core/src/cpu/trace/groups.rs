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

    /// Calls back for every group in some rows of pixels that still reaches `near`, and of which a ray may
    /// lie where none of three functions c + a·x + b·y is negative, each told as (a, b, c).
    #[inline(always)]
    pub fn within<S: Simd>(
        &self,
        simd: S,
        [top, bottom]: [usize; 2],
        [u, v, w]: [[f32; 3]; 3],
        (near, reach): (f32, &mut [f32]),
        mut meet: impl FnMut(usize, &mut f32),
    ) {
        let [u, v, w] = [self.slope(u), self.slope(v), self.slope(w)];
        let groups = self.rows[top].start..self.rows[bottom].end;
        let lanes = Lanes::<S>::COUNT;
        for at in (groups.start / lanes * lanes..groups.end).step_by(lanes) {
            let least = u.most(simd, at).min(v.most(simd, at)).min(w.most(simd, at));
            let open = Lanes::splat(simd, near).lt(Lanes::load(simd, &reach[at..]));
            let mut bits = (least.lit(0.0).lt(least) & open).to_bitmask();
            while bits != 0 {
                let group = at + bits.trailing_zeros() as usize;
                meet(group, &mut reach[group]);
                bits &= bits - 1;
            }
        }
    }

    #[inline(always)]
    fn slope(&self, [a, b, c]: [f32; 3]) -> Slope<'_> {
        let x = if a > 0.0 { &self.right } else { &self.left };
        let y = if b > 0.0 { &self.bottom } else { &self.top };
        Slope { a, b, c, x, y }
    }
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
