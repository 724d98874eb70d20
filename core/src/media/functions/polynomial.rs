//! Polynomials of up to three variables on a period of space, repeated or not (Biri and Michelin 2002, section
//! 3.2.2): β(x) = Σ c Π uᵢ^pᵢ, u = fract(x/period + 1/2) on every axis that has a period.
//!
//! Between two borders of its periods a polynomial along a segment is one in the segment's parameter, so that a
//! Gauss rule of half its degree integrates it exactly. Of one variable the whole periods between the ends
//! count as often as there are; of several, borders are passed one by one.

use super::bernstein::{centred, least_of};
use super::horner::Horner;
use super::member::member;
use super::monomial::{Monomial, Monomials};
use crate::json::limits::{self, COUNTS};
use crate::json::{Checker, Code};
use crate::media::Words;
use crate::media::closed::crossing;
use crate::media::toward::Toward;
use crate::num::Num;
use crate::quadrature::gauss_legendre;
use crate::vector::V3;
use glam::{DVec3, Vec3, Vec4};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The periods along the three axes [m]; null where the member does not depend on that axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct Periods(
    #[schemars(inner(range(min = limits::RADIUS.min, max = limits::RADIUS.max)))]
    pub  [Option<f64>; 3],
);

impl Periods {
    /// Which axes have one.
    pub fn axes(self) -> [bool; 3] {
        self.0.map(|period| period.is_some())
    }
}

impl Toward for Periods {
    fn toward(&self, other: &Self, share: f64) -> Self {
        let axis = |k: usize| Some(self.0[k]?.toward(&other.0[k]?, share));
        Self([0, 1, 2].map(axis))
    }
}

impl Toward for bool {
    fn toward(&self, _other: &Self, _share: f64) -> Self {
        *self
    }
}

member!(
    /// A polynomial on a period of space.
    Polynomial, PolynomialMorph, PolynomialParameters {
        /// Its monomials in u = fract(x / period + 1/2), which runs from 0 to 1 on every axis.
        monomials: Monomials = Monomials(vec![
            Monomial { powers: [0, 0, 0], coefficient: 0.1 },
            Monomial { powers: [1, 0, 0], coefficient: -0.1 },
            Monomial { powers: [2, 0, 0], coefficient: 0.1 },
        ]),
        /// Its periods along x, y and z [m]; null where it does not depend on that axis.
        period_m: Periods = Periods([Some(8.0), None, None]),
        /// Whether it repeats; else it is 0 outside of the period around the origin.
        repeat: bool = true,
    }
);

impl PolynomialParameters {
    /// Looks at all of its numbers; `at` names its members.
    pub fn check(&self, check: &mut Checker, at: &dyn Fn(&str) -> String, far_m: f64) {
        check.count(self.monomials.0.len(), COUNTS.monomials, "monomials", || at("monomials"));
        for (i, Monomial { powers, coefficient }) in self.monomials.0.iter().enumerate() {
            let of = |name: &str| at(&format!("monomials/{i}/{name}"));
            check.number(*coefficient, limits::SIGNED_EXTINCTION, || of("coefficient"));
            for (axis, power) in powers.iter().enumerate() {
                check.number(f64::from(*power), limits::POWER, || of(&format!("powers/{axis}")));
            }
            let degree: f64 = powers.iter().map(|power| f64::from(*power)).sum();
            if degree > limits::POWER.max
                && powers.iter().all(|p| f64::from(*p) <= limits::POWER.max)
            {
                let detail =
                    format!("together the powers are {degree}, more than {}", limits::POWER.max);
                check.refuse(Code::OutOfRange, || of("powers"), detail);
            }
            for axis in (0..3).filter(|k| powers[*k] > 0 && self.period_m.0[*k].is_none()) {
                let detail = "a power of a variable without a period";
                check.refuse(Code::Conflict, || of(&format!("powers/{axis}")), detail);
            }
        }
        for (axis, period) in self.period_m.0.iter().enumerate() {
            let Some(period) = period else { continue };
            check.number(*period, limits::RADIUS, || at(&format!("period_m/{axis}")));
        }
        self.check_count(check, at, far_m);
    }

    /// The longest ray that it may be asked for: one variable takes no time for its periods, several take some
    /// for each [m].
    pub fn longest_m(&self) -> f64 {
        let periods = || self.period_m.0.iter().flatten();
        if !self.repeat || periods().count() < 2 {
            return f64::INFINITY;
        }
        COUNTS.periods as f64 * periods().fold(f64::INFINITY, |a: f64, b| a.min(*b))
    }

    fn check_count(&self, check: &mut Checker, at: &dyn Fn(&str) -> String, far_m: f64) {
        if far_m <= self.longest_m() {
            return;
        }
        for (axis, period) in self.period_m.0.iter().enumerate() {
            if period.is_some_and(|period| far_m > COUNTS.periods as f64 * period) {
                let detail =
                    format!("fits more than {} times into far_m, {far_m} m", COUNTS.periods);
                check.refuse(Code::OutOfRange, || at(&format!("period_m/{axis}")), detail);
            }
        }
    }
}

/// An axis of space as a polynomial meets it: u = rate · x + offset.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Axis {
    rate: f64,
    offset: f64,
}

/// A polynomial, seen from an origin.
#[derive(Clone, Debug, PartialEq)]
pub struct Periodic {
    /// What is summed up at a place: of u, or of 2u − 1.
    sum: Horner,
    is_centred: bool,
    /// Coefficients of its antiderivative if it has one variable: Σ c u^(i + 1).
    whole: Option<Vec<f64>>,
    axes: [Option<Axis>; 3],
    repeat: bool,
    /// A rule on [0, 1] that is exact along any segment within a period.
    rule: Vec<(f64, f64)>,
    bounds: [f64; 2],
    /// Its mean over a period.
    average: f64,
}

/// By how much smaller terms of 2u − 1 must be, of which sums that nearly cancel keep their digits, to be worth as many
/// more of them.
const WORTH: f64 = 4.0;

/// Σ |c|.
fn size(monomials: &[Monomial]) -> f64 {
    monomials.iter().map(|one| one.coefficient.abs()).sum()
}

impl Periodic {
    /// Of some parameters, times a factor.
    pub fn new(from: &PolynomialParameters, scale: f64) -> Self {
        let scaled = |one: &Monomial| Monomial { coefficient: scale * one.coefficient, ..*one };
        let monomials: Vec<_> = from.monomials.0.iter().map(scaled).collect();
        let degree = |one: &Monomial| one.powers.iter().map(|power| usize::from(*power)).sum();
        let degree: usize = monomials.iter().map(degree).max().unwrap_or(0);
        let (nodes, weights) = gauss_legendre(degree / 2 + 1);
        let axis = |period: f64| Axis { rate: 1.0 / period, offset: 0.5 };
        let least = least_of(&monomials);
        let negated = |one: &Monomial| Monomial { coefficient: -one.coefficient, ..*one };
        let most = -least_of(&monomials.iter().map(negated).collect::<Vec<_>>());
        let around_middle = centred(&monomials);
        let is_centred = WORTH * size(&around_middle) < size(&monomials);
        Self {
            whole: whole(&monomials, &from.period_m.0).filter(|_| from.repeat),
            average: monomials.iter().map(Monomial::average).sum(),
            is_centred,
            sum: Horner::new(if is_centred { &around_middle } else { &monomials }),
            axes: from.period_m.0.map(|period| period.map(axis)),
            repeat: from.repeat,
            rule: nodes.into_iter().zip(weights).collect(),
            bounds: if from.repeat { [least, most] } else { [least.min(0.0), most.max(0.0)] },
        }
    }

    /// The same from another origin.
    pub fn seen_from(&self, origin: DVec3) -> Self {
        let mut seen = self.clone();
        for (axis, x) in seen.axes.iter_mut().zip(origin.to_array()) {
            let Some(axis) = axis else { continue };
            axis.offset += axis.rate * x;
            if self.repeat {
                axis.offset -= axis.offset.floor();
            }
        }
        seen
    }

    /// The least and the most that it adds [1/m].
    pub fn bounds(&self) -> [f64; 2] {
        self.bounds
    }

    /// Monomials that it has.
    pub fn count(&self) -> usize {
        self.sum.count()
    }

    /// How many periods a way passes; 1 where that takes no time.
    pub fn passed(&self, way: DVec3) -> usize {
        if !self.repeat || self.whole.is_some() {
            return 1;
        }
        let turns = self.axes.iter().zip(way.to_array());
        let turns = turns.filter_map(|(axis, way)| Some((axis.as_ref()?.rate * way).abs()));
        1 + (turns.sum::<f64>() as usize).min(COUNTS.periods)
    }

    /// The shortest period that a ray passes, if it repeats [m].
    pub fn shortest_m(&self, direction: DVec3) -> f64 {
        if !self.repeat {
            return f64::INFINITY;
        }
        let rates = self.axes.iter().zip(direction.to_array());
        let rates = rates.filter_map(|(axis, way)| Some((axis.as_ref()?.rate * way).abs()));
        1.0 / rates.fold(0.0, f64::max)
    }

    /// Where a ray passes the planes around the only period [m].
    pub fn jumps(&self, start: DVec3, direction: DVec3, edge: &mut dyn FnMut(f64)) {
        if self.repeat {
            return;
        }
        for (k, axis) in self.axes.iter().enumerate() {
            let Some(Axis { rate, offset }) = axis else { continue };
            let u = rate * start[k] + offset;
            for end in [0.0, 1.0] {
                edge(crossing((end - u) / rate, direction[k]));
            }
        }
    }

    /// Where a ray from the origin passes the borders of repeated periods, as far as those are few [m].
    pub fn borders(&self, direction: DVec3, length_m: f64, edge: &mut dyn FnMut(f64)) {
        /// More than this are passed by who sums up masses anyway.
        const MOST: f64 = 1024.0;
        for (axis, way) in self.axes.iter().zip(direction.to_array()) {
            let Some(Axis { rate, offset }) = axis.filter(|_| self.repeat) else { continue };
            let turns = rate * way * length_m;
            if turns == 0.0 || turns.abs() > MOST {
                continue;
            }
            let (low, high) = (offset.min(offset + turns), offset.max(offset + turns));
            let mut border = low.ceil();
            while border < high {
                edge((border - offset) / (rate * way));
                border += 1.0;
            }
        }
    }

    /// From where to where a ray from the origin is within the only period [m].
    pub fn extent(&self, direction: DVec3, length_m: f64) -> Option<(f64, f64)> {
        let (from, to) = (DVec3::ZERO, length_m * direction);
        if self.repeat {
            return Some((0.0, length_m));
        }
        let [begin, end] = self.clip(self.place::<f64>(from.into()), self.place(to.into()));
        (begin < end).then_some((begin * length_m, end * length_m))
    }

    /// The variables at a point, counted on from period to period.
    #[inline(always)]
    fn place<N: Num>(&self, x: V3<N>) -> V3<N> {
        let [u, v, w] = self.axes;
        V3::new(along(u, x.x), along(v, x.y), along(w, x.z))
    }

    /// At a point [1/m].
    #[inline(always)]
    pub fn at<N: Num>(&self, x: V3<N>) -> N {
        let place = self.place(x);
        if self.repeat {
            return self.value(place - floor(place));
        }
        let (zero, one) = (x.x.lit(0.0), x.x.lit(1.0));
        let low = place.x.min(place.y).min(place.z);
        let high = place.x.max(place.y).max(place.z);
        let value = N::select(low.lt(zero), zero, self.value(place));
        N::select(high.lt(one), value, zero)
    }

    /// Its mean between two points [1/m].
    #[inline(always)]
    pub fn mean<N: Num>(&self, a: V3<N>, b: V3<N>) -> N {
        let (a, b) = (self.place(a), self.place(b));
        if !self.repeat {
            let [from, to] = self.clip(a, b);
            let within = (to - from).max(from.lit(0.0));
            return within * self.between(a, b - a, [from, to], V3::lit(from, DVec3::ZERO));
        }
        match (&self.whole, self.axes) {
            (Some(whole), [Some(_), _, _]) => self.in_periods(whole, a, b, [a.x, b.x]),
            (Some(whole), [_, Some(_), _]) => self.in_periods(whole, a, b, [a.y, b.y]),
            (Some(whole), _) => self.in_periods(whole, a, b, [a.z, b.z]),
            (None, _) => self.step_by_step(a, b),
        }
    }

    /// Of one variable, given its value at both ends: parts of two periods, and the whole ones between them.
    #[inline(always)]
    fn in_periods<N: Num>(&self, whole: &[f64], a: V3<N>, b: V3<N>, [from, to]: [N; 2]) -> N {
        let (low, high) = (from.min(to), from.max(to));
        let (first, last) = (low.floor(), high.floor());
        let passed = last - first;
        let half = low.lit(0.5);
        let cell = V3::new(
            floor_of(self.axes[0], first),
            floor_of(self.axes[1], first),
            floor_of(self.axes[2], first),
        );
        let within = self.between(a, b - a, [low.lit(0.0), low.lit(1.0)], cell);
        if !N::any(half.lt(passed)) {
            return within;
        }
        let sum = passed * antiderivative(whole, low.lit(1.0)) - antiderivative(whole, low - first)
            + antiderivative(whole, high - last);
        let safe = N::select(half.lt(passed), high - low, half);
        N::select(half.lt(passed), sum / safe, within)
    }

    /// Of several variables: from border to border, as many as a ray may pass; the rest of a longer way, from a
    /// light far away, counts by the mean of all periods.
    #[inline(always)]
    fn step_by_step<N: Num>(&self, a: V3<N>, b: V3<N>) -> N {
        let (zero, one) = (a.x.lit(0.0), a.x.lit(1.0));
        let way = b - a;
        let turns = way.x.abs() + way.y.abs() + way.z.abs();
        let end = (zero.lit(COUNTS.periods as f64) / turns.max(one)).min(one);
        let mut borders = Borders::new(a, way);
        let (mut from, mut sum) = (zero, zero);
        while N::any(from.lt(end)) {
            let to = borders.next().min(end);
            let middle = (from + to) * zero.lit(0.5);
            let cell = floor(a + way.scale(middle));
            sum = (to - from).mul_add(self.between(a, way, [from, to], cell), sum);
            from = to;
        }
        (one - end).mul_add(zero.lit(self.average), sum)
    }

    /// The mean between two shares of a segment that lie in one period.
    #[inline(always)]
    fn between<N: Num>(&self, a: V3<N>, way: V3<N>, [from, to]: [N; 2], cell: V3<N>) -> N {
        let start = a - cell;
        let mut sum = from.lit(0.0);
        for (node, weight) in &self.rule {
            let share = (to - from).mul_add(from.lit(*node), from);
            sum = self.value(start + way.scale(share)).mul_add(from.lit(*weight), sum);
        }
        sum
    }

    /// Between which shares of a segment it is in the only period.
    #[inline(always)]
    fn clip<N: Num>(&self, a: V3<N>, b: V3<N>) -> [N; 2] {
        let mut shares = [a.x.lit(0.0), a.x.lit(1.0)];
        for (axis, a, b) in
            [(self.axes[0], a.x, b.x), (self.axes[1], a.y, b.y), (self.axes[2], a.z, b.z)]
        {
            if axis.is_none() {
                continue;
            }
            let (zero, one) = (a.lit(0.0), a.lit(1.0));
            // A level segment is inside all along, or nowhere.
            let way = b - a;
            let tiny = one.lit(1e-30);
            let safe = N::select(way.abs().lt(tiny), tiny, way);
            let (first, second) = (-a / safe, (one - a) / safe);
            shares[0] = shares[0].max(first.min(second)).min(one);
            shares[1] = shares[1].min(first.max(second)).max(zero);
        }
        shares
    }

    /// Σ c Π uᵢ^pᵢ.
    #[inline(always)]
    fn value<N: Num>(&self, u: V3<N>) -> N {
        let (one, two) = (u.x.lit(1.0), u.x.lit(2.0));
        let centred =
            V3::new(u.x.mul_add(two, -one), u.y.mul_add(two, -one), u.z.mul_add(two, -one));
        self.sum.value(if self.is_centred { centred } else { u })
    }

    /// Bytes that it takes besides its own.
    pub fn size(&self) -> usize {
        self.sum.size()
    }

    /// As the shader reads it; its monomials stand among the numbers.
    pub fn words(&self, numbers: &mut Vec<f32>) -> Words {
        let rate = self.axes.map(|axis| axis.map_or(0.0, |axis| axis.rate as f32));
        let offset = self.axes.map(|axis| axis.map_or(0.5, |axis| axis.offset as f32));
        let first = numbers.len() as f32;
        numbers.extend([self.average as f32, self.rule.len() as f32]);
        numbers.extend(self.sum.words());
        let [least, most] = self.bounds.map(|bound| bound as f32);
        let kind = if self.repeat { 1.0 } else { 5.0 };
        vec![
            Vec3::from(rate).extend(first),
            Vec3::from(offset).extend(self.sum.count() as f32),
            Vec4::new(least, most, f32::from(u8::from(self.is_centred)), kind),
        ]
    }
}

/// A variable, counted on from period to period; the middle of a period where there is none.
#[inline(always)]
fn along<N: Num>(axis: Option<Axis>, x: N) -> N {
    match axis {
        Some(Axis { rate, offset }) => x.mul_add(x.lit(rate), x.lit(offset)),
        None => x.lit(0.5),
    }
}

/// A whole number of periods on an axis that has any.
#[inline(always)]
fn floor_of<N: Num>(axis: Option<Axis>, whole: N) -> N {
    if axis.is_some() { whole } else { whole.lit(0.0) }
}

#[inline(always)]
fn floor<N: Num>(v: V3<N>) -> V3<N> {
    V3::new(v.x.floor(), v.y.floor(), v.z.floor())
}

/// The borders of periods along a segment, as shares of it.
struct Borders<N> {
    first: V3<N>,
    step: V3<N>,
    /// How many of each axis are behind.
    passed: V3<N>,
}

impl<N: Num> Borders<N> {
    #[inline(always)]
    fn new(a: V3<N>, way: V3<N>) -> Self {
        let (x, y, z) =
            (first_border(a.x, way.x), first_border(a.y, way.y), first_border(a.z, way.z));
        Self {
            first: V3::new(x.0, y.0, z.0),
            step: V3::new(x.1, y.1, z.1),
            passed: V3::lit(a.x, DVec3::ZERO),
        }
    }

    /// The next border, or the end.
    #[inline(always)]
    fn next(&mut self) -> N {
        let Self { first, step, passed } = *self;
        let x = passed.x.mul_add(step.x, first.x);
        let y = passed.y.mul_add(step.y, first.y);
        let z = passed.z.mul_add(step.z, first.z);
        let (zero, one) = (x.lit(0.0), x.lit(1.0));
        let next = x.min(y).min(z);
        self.passed = V3::new(
            passed.x + N::select(next.lt(x), zero, one),
            passed.y + N::select(next.lt(y), zero, one),
            passed.z + N::select(next.lt(z), zero, one),
        );
        next.min(one)
    }
}

/// Where a variable passes its first whole number, and after which share the next.
#[inline(always)]
fn first_border<N: Num>(a: N, way: N) -> (N, N) {
    let (zero, one) = (a.lit(0.0), a.lit(1.0));
    let step = one / way.abs().max(a.lit(1e-30));
    let part = a - a.floor();
    // Downwards from a whole number the first border is a period away.
    let down = N::select(zero.lt(part), part, one);
    let ahead = N::select(way.lt(zero), down, one - part);
    (ahead * step, step)
}

/// Its antiderivative's coefficients, if it has one variable.
fn whole(monomials: &[Monomial], periods: &[Option<f64>; 3]) -> Option<Vec<f64>> {
    let axis = periods.iter().position(Option::is_some).unwrap_or(0);
    if periods.iter().flatten().count() > 1 {
        return None;
    }
    let mut whole = vec![0.0; 16];
    for Monomial { powers, coefficient } in monomials {
        let power = usize::from(powers[axis]);
        whole[power] += coefficient / (power + 1) as f64;
    }
    Some(whole)
}

/// Σ c u^(i + 1).
#[inline(always)]
fn antiderivative<N: Num>(whole: &[f64], u: N) -> N {
    let mut sum = u.lit(0.0);
    for c in whole.iter().rev() {
        sum = sum.mul_add(u, u.lit(*c));
    }
    sum * u
}
