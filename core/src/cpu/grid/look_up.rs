//! What every sample does itself: it interpolates the tabulated rays around it, and multiplies by its own glow
//! of the lamp and its own fog.

use super::cells::{Cell, weights};
use super::glow::Glow;
use super::knots::{EDGES, WITHIN};
use super::rule::bulk;
use super::table::{BETA, DEPTH, RATIO, Table};
use crate::cpu::lit::{Lit, Upto};
use crate::cpu::places::{CONTROL, Member, Samples};
use crate::frame::context::Lamp;
use crate::geometry::batch::{Ends, Fogged, Row, load3};
use crate::geometry::control::PADDED;
use crate::light::{Crossed, ToLight};
use crate::num::{Lanes, Num};
use crate::vector::V3;
use fearless_simd::{Simd, dispatch};
use glam::Vec3;

/// Airlight, and T of the lumps, of a cell's samples.
pub fn cell(table: &Table, cell: &Cell, samples: &Samples, fogged: &mut [Fogged]) {
    let level = table.grid.context.job.level;
    dispatch!(level, simd => in_lanes(simd, table, cell, samples, fogged));
}

#[inline(always)]
fn in_lanes<S: Simd>(
    simd: S,
    table: &Table,
    cell: &Cell,
    samples: &Samples,
    fogged: &mut [Fogged],
) {
    let (grid, scattered) = (table.grid, table.scattered);
    let is_near = cell.near(grid, scattered);
    let sums_up = is_near.contains(&true) || scattered.has_parted();
    let [first, last] = if sums_up || table.knots.has_edges() {
        [0, table.knots.count() - 1]
    } else {
        let [first, last] = table.around(cell);
        [first.saturating_sub(1), (last + 1).min(table.knots.count() - 1)]
    };
    let rays = Rays { values: table.copy(cell, first, last), first, width: table.light() };
    let lamp = |i: &usize| &grid.context.lamps[grid.context.scatters[*i].lamp];
    let lamps: Vec<&Lamp> = scattered.asked.iter().map(lamp).collect();
    let has_lumps = grid.context.field.lumps() > 0;
    let (middle, scale) = (
        cell.middle(),
        Lanes::splat(simd, if cell.own.is_some() { 0.0 } else { 1.0 / cell.half() }),
    );
    let (zero, one) = (Lanes::splat(simd, 0.0), Lanes::splat(simd, 1.0));
    let mut ratios = vec![zero; lamps.len()];
    let fixed = fixed(simd, table);
    let shafts = lamps.iter().map(|lamp| lamp.shafts.as_deref());
    let mut lit: Vec<Option<Lit>> = shafts.map(|shafts| shafts.map(Lit::new)).collect();
    for members in cell.members.chunks(Lanes::<S>::COUNT) {
        let lanes = Gathered::new(simd, samples, members, fogged);
        let x = (lanes.x - Lanes::splat(simd, middle.x)) * scale;
        let y = (lanes.y - Lanes::splat(simd, middle.y)) * scale;
        let around = Around { rays: &rays, weights: weights(x, y) };
        let t = lanes.length.min(Lanes::splat(simd, table.knots.ends()[1]));
        let along = Along::new(simd, table, fixed, &lanes, t);
        let (mut lumps, mut is_behind) = (zero, zero);
        for k in along.low..along.high {
            let (here, at) = along.within(k, t);
            if !Lanes::<S>::any(here) {
                continue;
            }
            if has_lumps {
                let value = around.lumps(simd, k, &along, t, at);
                lumps = Lanes::select(here, value, lumps);
            }
            for (slot, ratio) in ratios.iter_mut().enumerate().filter(|(slot, _)| !is_near[*slot]) {
                let a = around.value(simd, k, RATIO + slot);
                let value = if table.knots.is_behind(k) {
                    // The light so far, and what the rest of the way adds.
                    let to = lamps[slot].from_camera.beside(lanes.start, lanes.direction);
                    let mean = around.value(simd, k + 1, RATIO + lamps.len() + slot);
                    let from = along.place(k);
                    a + mean * scattered.glows[slot].between(simd, &to, from, t.max(from))
                } else {
                    let b = around.value(simd, k + 1, RATIO + slot);
                    (b - a).mul_add(at, a)
                };
                *ratio = Lanes::select(here, value, *ratio);
            }
            is_behind = Lanes::select(
                here,
                Lanes::splat(simd, f32::from(table.knots.is_behind(k))),
                is_behind,
            );
        }
        let depth = lanes.haze + lumps;
        let (bulk, is_behind) = (bulk(depth, t), zero.lt(is_behind));
        let mut put = Put { members, fogged, is_run: lanes.is_run };
        // Until all have read what it is without the lumps.
        if scattered.is_last {
            put.put(None, depth);
        }
        for (slot, (ratio, lamp)) in ratios.iter().zip(&lamps).enumerate() {
            let to = lamp.from_camera.beside(lanes.start, lanes.direction);
            let glow = &scattered.glows[slot];
            let whole = if is_near[slot] {
                around.near(simd, lamps.len() + slot, glow, &to, &along, t)
            } else {
                let ratio = ratio.max(zero);
                Lanes::select(is_behind, ratio, ratio * glow.between(simd, &to, zero, t) * bulk)
            };
            let whole = if grid.tells_shares { one } else { whole };
            let mut light = whole;
            if scattered.are_parted[slot] {
                let cone = lamp.from_camera.crossed(lanes.start, lanes.direction);
                if let Some(lit) = &mut lit[slot] {
                    lit.see(simd, lanes.start, lanes.direction, &to, t);
                }
                let lit = lit[slot].as_ref().filter(|lit| lit.is_hidden);
                if lit.is_some_and(|lit| lit.is_dark) {
                    light = zero;
                } else if cone.is_some() || lit.is_some() {
                    let parts = Parts { cone: cone.as_ref(), lit };
                    light = whole * around.share(simd, slot, glow, &to, &parts, &along, t);
                }
            }
            put.put(Some(scattered.before + slot), light);
        }
    }
}

/// What the rays around a cell have at some knots.
struct Rays {
    /// `[knot][field][ray]`.
    values: Vec<[f32; CONTROL]>,
    first: usize,
    width: usize,
}

/// The rays around a cell, and how much they count for some samples.
struct Around<'a, S: Simd> {
    rays: &'a Rays,
    weights: [Lanes<S>; CONTROL],
}

impl<S: Simd> Around<'_, S> {
    /// A field at a knot.
    #[inline(always)]
    fn value(&self, simd: S, knot: usize, field: usize) -> Lanes<S> {
        let values = &self.rays.values[(knot - self.rays.first) * self.rays.width + field];
        let value = |i: usize| Lanes::splat(simd, values[i]);
        let [a, b, c, d, e, f, g, h] = self.weights;
        let even = c.mul_add(value(2), a * value(0));
        let odd = d.mul_add(value(3), b * value(1));
        let even = g.mul_add(value(6), e.mul_add(value(4), even));
        let odd = h.mul_add(value(7), f.mul_add(value(5), odd));
        even + odd
    }

    /// T of the lumps behind a knot: the cubic that meets T and β at the next one, too.
    #[inline(always)]
    fn lumps(&self, simd: S, k: usize, along: &Along<S>, t: Lanes<S>, at: Lanes<S>) -> Lanes<S> {
        let (begin, end) = (along.place(k), along.place(k + 1));
        let (near, far) = (self.value(simd, k, DEPTH), self.value(simd, k + 1, DEPTH));
        let width = end - begin;
        let rise = self.value(simd, k, BETA) * width;
        let slope = self.value(simd, k + 1, BETA) * width;
        let (one, rest) = (at.lit(1.0), at.lit(1.0) - at);
        let cubic = near * rest.squared() * (one + at + at)
            + far * at.squared() * (at.lit(3.0) - at - at)
            + at * rest * (rise * rest - slope * at);
        let kept = cubic.max(near.min(far)).min(near.max(far)).max(at.lit(0.0));
        // Before the first knot it grows from nothing.
        kept * (t / begin.max(t.lit(f64::from(f32::MIN_POSITIVE)))).min(one)
    }

    /// The airlight near a lamp: the means between knots, each times its part of the glow.
    #[inline(always)]
    fn near(
        &self,
        simd: S,
        slot: usize,
        glow: &Glow,
        to: &ToLight<Lanes<S>>,
        along: &Along<S>,
        t: Lanes<S>,
    ) -> Lanes<S> {
        let zero = t.lit(0.0);
        let mut sum = zero;
        let (mut from, mut angle) = (zero, to.first_angle());
        for k in 0..=along.high {
            let until = if k < along.high { along.place(k).min(t) } else { t };
            let turn = to.angle(from, until.max(from));
            let mean = self.value(simd, k, RATIO + slot).max(zero);
            sum += mean * glow.over(simd, angle, turn);
            angle += turn;
            from = until.max(from);
        }
        sum / to.miss
    }

    /// Share of the airlight of a lamp that lights parts of a ray only: from knot to knot the glow of what it lights, times
    /// the mean there of β e^(−T), which is a square that meets its values at both knots and its mean between; over the
    /// same of the whole ray.
    #[expect(clippy::too_many_arguments, reason = "all that a sample knows")]
    #[inline(always)]
    fn share(
        &self,
        simd: S,
        slot: usize,
        glow: &Glow,
        to: &ToLight<Lanes<S>>,
        parts: &Parts<S>,
        along: &Along<S>,
        t: Lanes<S>,
    ) -> Lanes<S> {
        let zero = t.lit(0.0);
        let least = t.lit(f64::from(f32::MIN_POSITIVE));
        let count = along.table.scattered.asked.len();
        let [mean, seen] = [RATIO + count + slot, RATIO + 2 * count + slot];
        let (mut sum, mut whole_sum) = (zero, zero);
        let (mut from, mut angle) = (zero, to.first_angle());
        let mut before = self.value(simd, 0, seen);
        let mut lit_upto = parts.lit.map(|lit| lit.look(simd, lit.place(simd, to, angle, zero)));
        for k in 0..=along.high {
            let knot = along.place(k).max(from);
            let until = (if k < along.high { knot.min(t) } else { t }).max(from);
            let (whole, turn) = (to.angle(from, knot).max(least), to.angle(from, until));
            let next = self.value(simd, k, seen);
            let own = self.value(simd, k, mean).max(zero);
            let upto = between([before, next], own, [zero, turn / whole]);
            whole_sum += upto * glow.over(simd, angle, turn);
            // From the angle at the knot before: the sun's hardly change.
            let [a, b] = match parts.cone {
                Some(cone) => {
                    let [a, b] = cone.narrowed([angle, angle + turn]);
                    [a - angle, b - angle]
                }
                None => [zero, turn],
            };
            if Lanes::<S>::any(a.lt(b)) {
                let share = parts.share(simd, to, angle, [a, b], [from, until], &mut lit_upto);
                let lit = glow.over(simd, angle + a, b - a) * share;
                sum += between([before, next], own, [a / whole, b / whole]) * lit;
            }
            angle += turn;
            (from, before) = (until, next);
        }
        (sum / whole_sum.max(least)).min(t.lit(1.0))
    }
}

/// What parts of some rays a lamp lights.
struct Parts<'a, S: Simd> {
    cone: Option<&'a Crossed<Lanes<S>>>,
    lit: Option<&'a Lit<'a>>,
}

impl<S: Simd> Parts<'_, S> {
    /// Share of its light between two angles at it beyond another, which are those of two ray parameters where it is
    /// far away. What is lit up to the first of them is known where no cone cuts a part out, and that up to the second
    /// is then kept.
    #[inline(always)]
    fn share(
        &self,
        simd: S,
        to: &ToLight<Lanes<S>>,
        angle: Lanes<S>,
        [a, b]: [Lanes<S>; 2],
        [from, until]: [Lanes<S>; 2],
        upto: &mut Option<Upto<S>>,
    ) -> Lanes<S> {
        let one = a.lit(1.0);
        let least = a.lit(f64::from(f32::MIN_POSITIVE));
        let width = (b - a).max(least);
        let (a, b) = (angle + a, angle + b);
        let visible = match (self.lit, upto) {
            (Some(lit), Some(upto)) => {
                if self.cone.is_some() {
                    *upto = lit.look(simd, lit.place(simd, to, a, from));
                }
                let next = lit.look(simd, lit.place(simd, to, b, until));
                let share = next.share_since(upto);
                *upto = next;
                share
            }
            _ => one,
        };
        match self.cone {
            Some(cone) => visible * (cone.turn([a, b]) / width),
            None => visible,
        }
    }
}

/// The mean over a part of a square's way, given its values at both ends and its mean between.
#[inline(always)]
fn between<N: Num>([first, last]: [N; 2], mean: N, [from, to]: [N; 2]) -> N {
    let bend = (first + last) * mean.lit(3.0) - mean * mean.lit(6.0);
    let rise = last - first - bend;
    let squares = from.mul_add(from, to.mul_add(to, from * to));
    let value = bend.mul_add(squares * mean.lit(1.0 / 3.0), first);
    let value = rise.mul_add((from + to) * mean.lit(0.5), value);
    // Where what is seen leaps no square tells it.
    value.max(mean.lit(0.0)).min(mean * mean.lit(3.0))
}

/// Where some samples end among the knots.
struct Along<'a, S: Simd> {
    simd: S,
    table: &'a Table<'a>,
    bounds: [Lanes<S>; EDGES + 2],
    /// The first knot before any of them, and the last behind.
    low: usize,
    high: usize,
}

impl<'a, S: Simd> Along<'a, S> {
    #[inline(always)]
    fn new(
        simd: S,
        table: &'a Table<'a>,
        fixed: [Lanes<S>; EDGES + 2],
        lanes: &Gathered<S>,
        t: Lanes<S>,
    ) -> Self {
        let has_edges = table.knots.has_edges();
        let bounds = if has_edges { bounds(simd, table, lanes) } else { fixed };
        let last = table.knots.count() - 1;
        let mut along = Self { simd, table, bounds, low: 0, high: last };
        while along.low + 1 < last && !Lanes::<S>::any(t.lt(along.place(along.low + 1))) {
            along.low += 1;
        }
        along.high = along.low + 1;
        while along.high < last && Lanes::<S>::any(along.place(along.high).lt(t)) {
            along.high += 1;
        }
        along
    }

    /// A knot on the samples' rays [m].
    #[inline(always)]
    fn place(&self, knot: usize) -> Lanes<S> {
        let (section, t) = self.table.knots.at(knot);
        let t = Lanes::splat(self.simd, t);
        if !self.table.knots.has_edges() {
            return t;
        }
        let (begin, end) = (self.bounds[section], self.bounds[section + 1]);
        t.min(end * t.lit(1.0 - WITHIN)).max(begin * t.lit(1.0 + WITHIN))
    }

    /// Which samples end behind a knot, and where on the way to the next.
    #[inline(always)]
    fn within(&self, knot: usize, t: Lanes<S>) -> (S::mask32s, Lanes<S>) {
        let (begin, end) = (self.place(knot), self.place(knot + 1));
        let width = (end - begin).max(t.lit(f64::from(f32::MIN_POSITIVE)));
        let at = ((t - begin) / width).max(t.lit(0.0)).min(t.lit(1.0));
        // Knot by knot, what ends behind this one takes the place of what was found before.
        let is_first = knot == self.low;
        let here = if is_first { t.lt(t + t.lit(1.0)) } else { begin.lt(t) };
        (here, at)
    }
}

/// Some samples in lanes.
struct Gathered<S: Simd> {
    /// Place in the picture [px].
    x: Lanes<S>,
    y: Lanes<S>,
    direction: V3<Lanes<S>>,
    start: V3<Lanes<S>>,
    /// Where they end [m].
    length: Lanes<S>,
    /// T of what is smooth.
    haze: Lanes<S>,
    /// Whether they stand side by side.
    is_run: bool,
}

impl<S: Simd> Gathered<S> {
    #[inline(always)]
    fn new(simd: S, samples: &Samples, members: &[Member], fogged: &[Fogged]) -> Self {
        let (batch, at) = (members[0].batch(), members[0].at());
        let is_run = Member::are_run(members, Lanes::<S>::COUNT);
        if is_run {
            let (Ends { rays, hits }, [x, y]) =
                (&samples.block[batch], samples.places.batch(batch));
            let load = |row: &[f32]| Lanes::load(simd, &row[at..]);
            return Self {
                x: load(x),
                y: load(y),
                direction: load3(simd, &rays.direction, at),
                start: load3(simd, &rays.offset, at),
                length: load(&hits.length),
                haze: load(&fogged[batch].depth),
                is_run,
            };
        }
        let rows = samples.gather(members, Lanes::<S>::COUNT);
        let mut haze = [0.0; PADDED];
        for (lane, haze) in haze.iter_mut().enumerate().take(Lanes::<S>::COUNT) {
            let ray = members[lane.min(members.len() - 1)];
            *haze = fogged[ray.batch()].depth[ray.at()];
        }
        let row = |i: usize| Lanes::load(simd, &rows[i]);
        let (direction, start) = (V3::new(row(2), row(3), row(4)), V3::new(row(5), row(6), row(7)));
        Self {
            x: row(0),
            y: row(1),
            direction,
            start,
            length: row(8),
            haze: Lanes::load(simd, &haze),
            is_run,
        }
    }
}

/// Where the values of some samples go.
struct Put<'a> {
    members: &'a [Member],
    fogged: &'a mut [Fogged],
    is_run: bool,
}

impl Put<'_> {
    /// Sets their T, or what is scattered of a lamp.
    #[inline(always)]
    fn put<S: Simd>(&mut self, slot: Option<usize>, values: Lanes<S>) {
        if self.is_run {
            let first = self.members[0];
            values.store(&mut row(&mut self.fogged[first.batch()], slot)[first.at()..]);
            return;
        }
        let mut each = [0.0; PADDED];
        values.store(&mut each);
        for (value, member) in each.iter().zip(self.members) {
            row(&mut self.fogged[member.batch()], slot)[member.at()] = *value;
        }
    }
}

/// T, or the airlight of a lamp.
#[inline(always)]
fn row(fogged: &mut Fogged, slot: Option<usize>) -> &mut Row {
    match slot {
        Some(slot) => &mut fogged.airlight[slot],
        None => &mut fogged.depth,
    }
}

/// The sections of rays that pass no edge.
#[inline(always)]
fn fixed<S: Simd>(simd: S, table: &Table) -> [Lanes<S>; EDGES + 2] {
    let [from, to] = table.knots.ends();
    let mut bounds = [Lanes::splat(simd, to); EDGES + 2];
    bounds[0] = Lanes::splat(simd, from);
    bounds
}

/// The sections of some samples' rays.
#[inline(always)]
fn bounds<S: Simd>(simd: S, table: &Table, lanes: &Gathered<S>) -> [Lanes<S>; EDGES + 2] {
    let V3 { x: a, y: b, z: c } = lanes.start;
    let V3 { x: d, y: e, z: f } = lanes.direction;
    let mut rays = [[0.0; PADDED]; 6];
    for (row, lanes) in rays.iter_mut().zip([a, b, c, d, e, f]) {
        lanes.store(row);
    }
    let mut rows = [[0.0; PADDED]; EDGES + 2];
    for lane in 0..Lanes::<S>::COUNT {
        let get = |i: usize| Vec3::new(rays[i][lane], rays[i + 1][lane], rays[i + 2][lane]);
        let bounds = table.bounds(get(0), get(3));
        rows.iter_mut().zip(bounds).for_each(|(row, bound)| row[lane] = bound);
    }
    let mut bounds = [Lanes::splat(simd, 0.0); EDGES + 2];
    for (bound, row) in bounds.iter_mut().zip(&rows) {
        *bound = Lanes::load(simd, row);
    }
    bounds
}
