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
const SHORT: f32 = 1e-3;

/// What is lit of some rays, one a lane.
pub struct Lit<'a> {
    shafts: &'a Shafts,
    /// How much of its row each sees lit up to each place, row by row.
    sums: Vec<f32>,
    /// Whether there is anything that is not lit.
    pub is_hidden: bool,
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
        Self { shafts, sums, is_hidden: false, start, rate, scale, last }
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
        let mut rays = [[0.0; PADDED]; 6];
        let [a, b, c, d, e, f] = &mut rays;
        start.x.store(a);
        start.y.store(b);
        start.z.store(c);
        direction.x.store(d);
        direction.y.store(e);
        direction.z.store(f);
        let mut slices = [[0.0; PADDED]; 2];
        for lane in 0..Lanes::<S>::COUNT {
            let get = |i: usize| {
                DVec3::new(rays[i][lane].into(), rays[i + 1][lane].into(), rays[i + 2][lane].into())
            };
            let [slice, height, begin, rate] = seen(&self.shafts.pencil, get(0), get(3));
            slices[0][lane] = ((slice - self.shafts.first) / self.shafts.step) as f32;
            slices[1][lane] = height as f32;
            (self.start[lane], self.rate[lane]) = (begin as f32, rate as f32);
        }
        let zero = t.lit(0.0);
        let ends =
            [self.place(simd, to, to.first_angle(), zero), self.place(simd, to, to.angle_at(t), t)];
        let mut places = [[0.0; PADDED]; 2];
        ends[0].store(&mut places[0]);
        ends[1].store(&mut places[1]);
        self.is_hidden = false;
        for lane in 0..Lanes::<S>::COUNT {
            let ends = [places[0][lane], places[1][lane]];
            self.last[lane] = ends[1];
            self.is_hidden |= self.sum_up(simd, lane, [slices[0][lane], slices[1][lane]], ends);
        }
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

    /// Sums up what of a row a ray sees lit between two places; tells whether some is not.
    #[inline(always)]
    fn sum_up<S: Simd>(
        &mut self,
        simd: S,
        lane: usize,
        [slice, height]: [f32; 2],
        ends: [f32; 2],
    ) -> bool {
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
        let mut sum = 0.0;
        let mut is_hidden = false;
        sums[begin * BLOCK] = 0.0;
        for block in begin..=end {
            let ([low, high], [lower, higher]) = (ranges[0][block], ranges[1][block]);
            let mut lit = [0.0f32; BLOCK];
            if height >= high.max(higher) {
                lit = [1.0; BLOCK];
            } else {
                is_hidden = true;
                if height >= low.min(lower) {
                    for at in (0..BLOCK).step_by(Lanes::<S>::COUNT) {
                        let from = block * BLOCK + at;
                        let own = lit_of(simd, rows, from, [height, part]);
                        own.store(&mut lit[at..]);
                    }
                }
            }
            for (sum_to, lit) in sums[block * BLOCK + 1..=(block + 1) * BLOCK].iter_mut().zip(lit) {
                sum += lit;
                *sum_to = sum;
            }
        }
        let known = (ends[1] as usize).min(shafts.bins - 1).saturating_sub(AT_END);
        let known = known.max((ends[0] as usize).min(shafts.bins - 1));
        let own = sums[known + 1] - sums[known];
        for place in known + 1..(end + 1) * BLOCK {
            sums[place + 1] = sums[place] + own;
        }
        is_hidden
    }

    /// Share that is lit between two ray parameters.
    #[inline(always)]
    pub fn between<S: Simd>(
        &self,
        simd: S,
        to: &ToLight<Lanes<S>>,
        [from, until]: [Lanes<S>; 2],
    ) -> Lanes<S> {
        let begin = self.place(simd, to, to.angle_at(from), from);
        let end = self.place(simd, to, to.angle_at(until), until);
        self.share(simd, begin, end)
    }

    /// Share that is lit between two places of each row.
    #[inline(always)]
    pub fn share<S: Simd>(&self, simd: S, from: Lanes<S>, to: Lanes<S>) -> Lanes<S> {
        let mut lanes = [[0.0; PADDED]; 2];
        from.store(&mut lanes[0]);
        to.store(&mut lanes[1]);
        let mut share = [0.0; PADDED];
        for lane in 0..Lanes::<S>::COUNT {
            let sums = &self.sums[lane * (self.shafts.bins + 1)..][..=self.shafts.bins];
            // Beyond the ray's end stands what another one left.
            let last = self.last[lane].max(SHORT);
            let a = lanes[0][lane].min(last - SHORT);
            let b = lanes[1][lane].min(last).max(a + SHORT);
            share[lane] = ((sum_at(sums, b) - sum_at(sums, a)) / (b - a)).clamp(0.0, 1.0);
        }
        Lanes::load(simd, &share)
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
        let place = self.place(simd, light, light.angle_at(t), t);
        self.share(simd, place, place)
    }
}

/// The sum up to a place.
#[inline(always)]
fn sum_at(sums: &[f32], place: f32) -> f32 {
    let first = (place as usize).min(sums.len() - 2);
    let part = place - first as f32;
    sums[first] + (sums[first + 1] - sums[first]) * part
}

/// The slice of a ray and its height; and where it starts, and how it moves on.
fn seen(pencil: &Pencil, start: DVec3, direction: DVec3) -> [f64; 4] {
    let Pencil { ends, origin, axis, across: [right, up], middle, .. } = *pencil;
    let turned = |x: f64, y: f64| {
        let angle = y.atan2(x) - middle;
        angle - std::f64::consts::TAU * (angle / std::f64::consts::TAU).round()
    };
    let least = f64::from(f32::MIN_POSITIVE);
    match ends {
        Ends::Both | Ends::Eye => {
            let (x, y) = (direction.dot(right), direction.dot(up));
            let sine = x.hypot(y);
            [turned(x, y), direction.dot(axis) / sine.max(least), 0.0, sine]
        }
        Ends::Lamp => {
            let way = start - origin;
            let (x, y) = (way.dot(right), way.dot(up));
            [turned(x, y), 1.0 / x.hypot(y).max(least), 0.0, 0.0]
        }
        Ends::Neither => {
            [start.dot(right) - middle, start.dot(axis), start.dot(up), direction.dot(up)]
        }
    }
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
