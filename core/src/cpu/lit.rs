//! Which parts of samples' rays a lamp reaches, by the rows of its slices.

use crate::airlight::fogshop2007::Reach;
use crate::frame::shafts::{BLOCK, Ends, Pencil, Shafts};
use crate::geometry::control::{Each, PADDED};
use crate::light::ToLight;
use crate::num::{Lanes, Num};
use crate::vector::V3;
use fearless_simd::Simd;
use glam::DVec3;

/// Heights of neighbouring rows that differ by less than this share belong to one surface, and what lies between is a
/// line; else an edge is half way.
const ONE_SURFACE: f64 = 0.3;
/// Along a row they do if they differ by no more than so many times what those before or behind do.
const STEADY: f64 = 3.0;
/// Parts before the end of a ray that are as lit as the one before: what it ends on begins there, and rows tell only
/// nearly where.
const AT_END: usize = 2;
/// A shorter part of a row is as good as a place.
const SHORT: f64 = 1e-3;

/// How much of its row a ray sees lit.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Sees {
    All,
    Parts,
    Nothing,
}

/// What is lit of some rays, one a lane.
pub struct Lit<'a> {
    shafts: &'a Shafts,
    /// Unit vectors across the pencil's line, the first one to the middle of its slices.
    across: [DVec3; 2],
    /// How much of its row each sees lit up to each place, row by row.
    sums: Vec<f32>,
    /// Whether there is anything that is not lit, and whether nothing is.
    pub is_hidden: bool,
    pub is_dark: bool,
    /// Where rays start in X, and how it grows along them, where both eye and lamp are far away; else the sine of their
    /// angle to the line, in place of the latter.
    start: Each,
    rate: Each,
    scale: f32,
    /// Where their rows end for them.
    last: Each,
}

impl<'a> Lit<'a> {
    pub fn new(shafts: &'a Shafts) -> Self {
        let [first, last] = shafts.angles;
        let scale = (shafts.bins as f64 / (last - first)) as f32;
        let sums = vec![0.0; PADDED * (shafts.bins + 1)];
        let [start, rate, last] = [[0.0; PADDED]; 3];
        let Pencil { ends, across: [right, up], middle, .. } = shafts.pencil;
        let across = match ends {
            Ends::Neither => [right, up],
            _ => {
                [right * middle.cos() + up * middle.sin(), up * middle.cos() - right * middle.sin()]
            }
        };
        Self { shafts, across, sums, is_hidden: false, is_dark: false, start, rate, scale, last }
    }

    /// Looks at rays up to some ray parameters.
    #[inline(always)]
    pub fn see<S: Simd>(
        &mut self,
        simd: S,
        start: V3<Lanes<S>>,
        direction: V3<Lanes<S>>,
        to: &ToLight<Lanes<S>>,
        t: Lanes<S>,
    ) {
        let [slice, height] = self.seen(start, direction);
        let mut slices = [[0.0; PADDED]; 2];
        slice.store(&mut slices[0]);
        height.store(&mut slices[1]);
        let zero = t.lit(0.0);
        let ends =
            [self.place(simd, to, to.first_angle(), zero), self.place(simd, to, to.angle_at(t), t)];
        let mut places = [[0.0; PADDED]; 2];
        ends[0].store(&mut places[0]);
        ends[1].store(&mut places[1]);
        (self.is_hidden, self.is_dark) = (false, true);
        for lane in 0..Lanes::<S>::COUNT {
            let ends = [places[0][lane], places[1][lane]];
            self.last[lane] = ends[1];
            let sees = self.sum_up(simd, lane, [slices[0][lane], slices[1][lane]], ends);
            self.is_hidden |= sees != Sees::All;
            self.is_dark &= sees == Sees::Nothing;
        }
    }

    /// The slices of rays and their heights; and keeps where they start, and how they move on.
    #[inline(always)]
    fn seen<S: Simd>(&mut self, start: V3<Lanes<S>>, direction: V3<Lanes<S>>) -> [Lanes<S>; 2] {
        let Pencil { ends, origin, axis, middle, .. } = self.shafts.pencil;
        let like = direction.x;
        let [right, up] = [V3::lit(like, self.across[0]), V3::lit(like, self.across[1])];
        let (zero, axis) = (like.lit(0.0), V3::lit(like, axis));
        let way = if ends == Ends::Lamp { start - V3::lit(like, origin) } else { direction };
        let (x, y) = (way.dot(right), way.dot(up));
        let aside = x.mul_add(x, y.squared()).sqrt().max(like.lit(f64::from(f32::MIN_POSITIVE)));
        let (slice, height, begin, rate) = match ends {
            Ends::Neither => (
                start.dot(right) - like.lit(middle),
                start.dot(axis),
                start.dot(up),
                direction.dot(up),
            ),
            _ => {
                let turn = Lanes::angle(y.abs(), x);
                let slice = Lanes::select(y.lt(zero), -turn, turn);
                let along = if ends == Ends::Lamp { like.lit(1.0) } else { direction.dot(axis) };
                (slice, along / aside, zero, aside)
            }
        };
        begin.store(&mut self.start);
        rate.store(&mut self.rate);
        [(slice - like.lit(self.shafts.first)) * like.lit(1.0 / self.shafts.step), height]
    }

    /// The place in its row of a ray parameter, of which the angle at the lamp is known.
    #[inline(always)]
    pub fn place<S: Simd>(
        &self,
        simd: S,
        to: &ToLight<Lanes<S>>,
        angle: Lanes<S>,
        t: Lanes<S>,
    ) -> Lanes<S> {
        let rate = Lanes::load(simd, &self.rate);
        let value = match self.shafts.pencil.ends {
            Ends::Both => angle - to.first_angle(),
            Ends::Lamp => angle,
            Ends::Eye => Lanes::angle(t * rate, t.lit(self.shafts.pencil.far)),
            Ends::Neither => t.mul_add(rate, Lanes::load(simd, &self.start)),
        };
        let last = t.lit(self.shafts.bins as f64);
        (value * Lanes::splat(simd, self.scale)).max(t.lit(0.0)).min(last)
    }

    /// Sums up what of a row a ray sees lit between two places.
    #[inline(always)]
    fn sum_up<S: Simd>(
        &mut self,
        simd: S,
        lane: usize,
        [slice, height]: [f32; 2],
        ends: [f32; 2],
    ) -> Sees {
        let shafts = self.shafts;
        let place = slice.clamp(0.0, (shafts.slices - 1) as f32);
        let first = (place as usize).min(shafts.slices - 2);
        let part = place - first as f32;
        let (rows, ranges) = (
            [shafts.row(first), shafts.row(first + 1)],
            [shafts.ranges(first), shafts.ranges(first + 1)],
        );
        let begin = ends[0] as usize / BLOCK;
        let end = (ends[1] as usize / BLOCK).min(shafts.bins / BLOCK - 1);
        let sums = &mut self.sums[lane * (shafts.bins + 1)..][..=shafts.bins];
        sums[begin * BLOCK] = 0.0;
        let [one, other] = [shafts.whole(first), shafts.whole(first + 1)];
        if height >= one[1].max(other[1]) {
            go_on(&mut sums[begin * BLOCK + 1..=(end + 1) * BLOCK], 0.0, 1.0);
            return Sees::All;
        }
        if height < one[0].min(other[0]) {
            sums[begin * BLOCK + 1..=(end + 1) * BLOCK].fill(0.0);
            return Sees::Nothing;
        }
        let mut sum = 0.0;
        let mut is_hidden = false;
        for block in begin..=end {
            let ([low, high], [lower, higher]) = (ranges[0][block], ranges[1][block]);
            let upto = &mut sums[block * BLOCK + 1..=(block + 1) * BLOCK];
            let is_open = height >= high.max(higher);
            is_hidden |= !is_open;
            if is_open || height < low.min(lower) {
                sum = go_on(upto, sum, f32::from(u8::from(is_open)));
                continue;
            }
            let mut lit = [0.0f32; BLOCK];
            for at in (0..BLOCK).step_by(Lanes::<S>::COUNT) {
                let own = lit_of(simd, rows, block * BLOCK + at, [height, part]);
                own.store(&mut lit[at..]);
            }
            sum = add_up(upto, sum, &lit);
        }
        let known = (ends[1] as usize).min(shafts.bins - 1).saturating_sub(AT_END);
        let known = known.max((ends[0] as usize).min(shafts.bins - 1));
        let own = sums[known + 1] - sums[known];
        let upto = sums[known + 1];
        let sum = go_on(&mut sums[known + 2..=(end + 1) * BLOCK], upto, own);
        match sum {
            _ if !is_hidden => Sees::All,
            0.0 => Sees::Nothing,
            _ => Sees::Parts,
        }
    }

    /// Share that is lit between two ray parameters.
    #[inline(always)]
    pub fn between<S: Simd>(
        &self,
        simd: S,
        to: &ToLight<Lanes<S>>,
        [from, until]: [Lanes<S>; 2],
    ) -> Lanes<S> {
        let begin = self.look(simd, self.place(simd, to, to.angle_at(from), from));
        let end = self.look(simd, self.place(simd, to, to.angle_at(until), until));
        end.share_since(&begin)
    }

    /// What is lit up to a place of each row.
    #[inline(always)]
    pub fn look<S: Simd>(&self, simd: S, place: Lanes<S>) -> Upto<S> {
        // Beyond the ray's end stands what another one left.
        let place = place.min(Lanes::load(simd, &self.last));
        let [mut places, mut lit, mut sum] = [[0.0; PADDED]; 3];
        place.store(&mut places);
        for lane in 0..Lanes::<S>::COUNT {
            let sums = &self.sums[lane * (self.shafts.bins + 1)..][..=self.shafts.bins];
            let first = (places[lane] as usize).min(sums.len() - 2);
            lit[lane] = sums[first + 1] - sums[first];
            sum[lane] = sums[first] + lit[lane] * (places[lane] - first as f32);
        }
        Upto { place, lit: Lanes::load(simd, &lit), sum: Lanes::load(simd, &sum) }
    }
}

/// What is lit of rows up to some places.
#[derive(Clone, Copy)]
pub struct Upto<S: Simd> {
    place: Lanes<S>,
    /// How much is there.
    lit: Lanes<S>,
    /// How much is before.
    sum: Lanes<S>,
}

impl<S: Simd> Upto<S> {
    /// Share that is lit since a place before.
    #[inline(always)]
    pub fn share_since(&self, before: &Self) -> Lanes<S> {
        let (short, one) = (self.place.lit(SHORT), self.place.lit(1.0));
        let width = self.place - before.place;
        let share = (self.sum - before.sum) / width.max(short);
        let share = Lanes::select(width.lt(short), self.lit, share);
        share.max(self.place.lit(0.0)).min(one)
    }
}

impl Reach for Lit<'_> {
    #[inline(always)]
    fn look<S: Simd>(
        &mut self,
        simd: S,
        start: V3<Lanes<S>>,
        direction: V3<Lanes<S>>,
        light: &ToLight<Lanes<S>>,
        length: Lanes<S>,
    ) {
        self.see(simd, start, direction, light, length);
    }

    #[inline(always)]
    fn at<S: Simd>(&self, simd: S, light: &ToLight<Lanes<S>>, t: Lanes<S>) -> Lanes<S> {
        if !self.is_hidden {
            return t.lit(1.0);
        }
        self.look(simd, self.place(simd, light, light.angle_at(t), t)).lit
    }
}

/// Sums of parts that are all as lit, behind a sum; tells the last one.
#[inline(always)]
fn go_on(sums: &mut [f32], before: f32, lit: f32) -> f32 {
    // Each for itself: none waits for the one before.
    for (i, sum) in sums.iter_mut().enumerate() {
        *sum = before + lit * (i + 1) as f32;
    }
    before + lit * sums.len() as f32
}

/// Sums of parts behind a sum; tells the last one.
#[inline(always)]
fn add_up(sums: &mut [f32], before: f32, lit: &[f32; BLOCK]) -> f32 {
    /// Parts that are summed up one after the other: chains of four instead of one of sixteen.
    const CHAIN: usize = 4;
    let mut sum = before;
    for (sums, lit) in sums.chunks_exact_mut(CHAIN).zip(lit.chunks_exact(CHAIN)) {
        let (pair, rest) = (lit[0] + lit[1], lit[2] + lit[3]);
        sums[0] = sum + lit[0];
        sums[1] = sum + pair;
        sums[2] = sum + (pair + lit[2]);
        sum += pair + rest;
        sums[3] = sum;
    }
    sum
}

/// How much of each part of a row a ray of some height sees lit, between two rows.
#[inline(always)]
fn lit_of<S: Simd>(
    simd: S,
    [near, far]: [&[f32]; 2],
    at: usize,
    [height, part]: [f32; 2],
) -> Lanes<S> {
    let (height, part) = (Lanes::splat(simd, height), Lanes::splat(simd, part));
    // The first number of a row stands twice.
    let (a, b) = (Lanes::load(simd, &near[at + 1..]), Lanes::load(simd, &far[at + 1..]));
    let (c, d) = (Lanes::load(simd, &near[at + 2..]), Lanes::load(simd, &far[at + 2..]));
    let (left, right) = (place_of(height, part, a, b), place_of(height, part, c, d));
    let (zero, half) = (height.lit(0.0), height.lit(0.5));
    // Within one surface the edge is where a line passes the ray's height.
    let before = (a - Lanes::load(simd, &near[at..])).abs();
    let behind = (Lanes::load(simd, &near[at + 3..]) - c).abs();
    let steady =
        before.max(behind) * height.lit(STEADY) + (c.abs() + height.lit(1.0)) * height.lit(1e-3);
    let one = height.lit(1.0);
    let is_steady = Lanes::select((c - a).abs().lt(steady), one, zero);
    let is_one = half.lt(is_steady * left.is_one * right.is_one);
    let (p, q) = (height - left.own, height - right.own);
    let above = p.max(zero) + q.max(zero);
    let whole = (p.abs() + q.abs()).max(height.lit(f64::from(f32::MIN_POSITIVE)));
    Lanes::select(is_one, above / whole, (left.lit + right.lit) * half)
}

/// What a place of two rows says to a height.
struct Between<S: Simd> {
    /// The height between them.
    own: Lanes<S>,
    /// 1 if they belong to one surface, else 0.
    is_one: Lanes<S>,
    /// Share that is lit.
    lit: Lanes<S>,
}

#[inline(always)]
fn place_of<S: Simd>(height: Lanes<S>, part: Lanes<S>, a: Lanes<S>, b: Lanes<S>) -> Between<S> {
    let (zero, one) = (height.lit(0.0), height.lit(1.0));
    let own = (b - a).mul_add(part, a);
    let is_one = (b - a).abs().lt((a.abs() + one) * height.lit(ONE_SURFACE));
    let hard = Lanes::select(height.lt(own), zero, one);
    let first = Lanes::select(height.lt(a), zero, one - part);
    let second = Lanes::select(height.lt(b), zero, part);
    let lit = Lanes::select(is_one, hard, first + second);
    Between { own, is_one: Lanes::select(is_one, one, zero), lit }
}
