//! What every pixel of a patch does itself: interpolates the fields, and sums the rule with its own
//! distance from the light.

use super::control::CONTROL;
use crate::light::{Source, ToLight};
use crate::num::{Lanes, Num};
use crate::phase::PhaseFunction;
use crate::quadrature::gauss_legendre;
use crate::vector::V3;
use fearless_simd::Simd;
use std::sync::LazyLock;

/// A field on a patch: coefficients of quadratics, those that the eight rays' values determine.
pub type Quadratic = [f32; CONTROL];

/// Nodes of a tail, and terms of the polynomials along it.
pub const TAIL: usize = 4;

/// A section of what lies before the first end of a layer's rays.
pub struct Head {
    /// The place of the share 0 [m].
    pub begin: Quadratic,
    /// What a share of 1 is long [m].
    pub range: Quadratic,
    /// The nodes of its rule.
    pub nodes: Vec<Node>,
}

/// One node of a rule.
pub struct Node {
    /// Where on the section, as a share.
    pub share: f32,
    /// ln(w β) − T, w the node's weight [m].
    pub log: Quadratic,
    /// Its largest value on the eight rays: quadratics may overshoot.
    pub most: f32,
    /// T(x, s)/d [1/m].
    pub mean: Quadratic,
}

/// What lies between the first and the last end: polynomials in (t − begin)/range.
pub struct Tail {
    /// Where it begins [m].
    pub from: f32,
    /// The place of the share 0 [m].
    pub begin: Quadratic,
    /// What a share of 1 is long [m].
    pub range: Quadratic,
    /// ln β − T.
    pub log: [Quadratic; TAIL],
    /// Its largest value.
    pub most: f32,
    /// T(x, s)/d [1/m].
    pub mean: [Quadratic; TAIL],
}

/// Coefficients of 1, x, y, x², xy, y², x²y, xy² that meet the eight rays' values.
pub fn quadratic([a, b, c, d, top, bottom, left, right]: [f32; CONTROL]) -> Quadratic {
    // Half sums and differences along the sides.
    let (upper, lower) = (0.5 * (a + b), 0.5 * (c + d));
    let (upper_x, lower_x) = (0.5 * (b - a), 0.5 * (d - c));
    let (upper_xx, lower_xx) = (upper - top, lower - bottom);
    let (left_yy, right_yy) = (0.5 * (a + c) - left, 0.5 * (b + d) - right);
    let xx = 0.5 * (upper_xx + lower_xx);
    let xxy = 0.5 * (lower_xx - upper_xx);
    let yy = 0.5 * (left_yy + right_yy);
    let xyy = 0.5 * (right_yy - left_yy);
    let one = 0.5 * (top + bottom) - yy;
    let x = 0.5 * (right - left);
    let y = 0.5 * (bottom - top);
    let xy = 0.5 * (lower_x - upper_x);
    [one, x, y, xx, xy, yy, xxy, xyy]
}

/// A field at a place of the square [−1, 1]².
pub fn at(field: &Quadratic, x: f32, y: f32) -> f32 {
    let [one, a, b, c, d, e, f, g] = field;
    one + a * x + b * y + c * x * x + d * x * y + e * y * y + f * x * x * y + g * x * y * y
}

/// The terms of a [`Quadratic`] at a pixel.
#[derive(Clone, Copy)]
pub struct Terms<S: Simd> {
    x: Lanes<S>,
    y: Lanes<S>,
    xx: Lanes<S>,
    xy: Lanes<S>,
    yy: Lanes<S>,
    xxy: Lanes<S>,
    xyy: Lanes<S>,
}

impl<S: Simd> Terms<S> {
    /// At a place of the square [−1, 1]².
    #[inline(always)]
    pub fn new(x: Lanes<S>, y: Lanes<S>) -> Self {
        let (xx, xy, yy) = (x * x, x * y, y * y);
        Self { x, y, xx, xy, yy, xxy: xx * y, xyy: x * yy }
    }

    #[inline(always)]
    fn value(&self, simd: S, field: &Quadratic) -> Lanes<S> {
        let even = self.xx.mul_add(Lanes::splat(simd, field[3]), Lanes::splat(simd, field[0]));
        let even = self.yy.mul_add(Lanes::splat(simd, field[5]), even);
        let even = self.xy.mul_add(Lanes::splat(simd, field[4]), even);
        let odd = self.x * Lanes::splat(simd, field[1]);
        let odd = self.y.mul_add(Lanes::splat(simd, field[2]), odd);
        let odd = self.xxy.mul_add(Lanes::splat(simd, field[6]), odd);
        let odd = self.xyy.mul_add(Lanes::splat(simd, field[7]), odd);
        even + odd
    }
}

/// A light relative to rays in lanes.
pub struct Light<S: Simd> {
    to: ToLight<Lanes<S>>,
    phase: PhaseFunction,
}

impl<S: Simd> Light<S> {
    /// Before rays from their starts in their directions.
    #[inline(always)]
    pub fn new(
        phase: PhaseFunction,
        light: Source,
        start: V3<Lanes<S>>,
        direction: V3<Lanes<S>>,
    ) -> Self {
        Self { to: light.beside(start, direction), phase }
    }

    /// The same light before one ray.
    #[inline(always)]
    pub fn of(
        simd: S,
        phase: PhaseFunction,
        &ToLight { closest, miss, tilt }: &ToLight<f64>,
    ) -> Self {
        let splat = |value: f64| Lanes::splat(simd, value as f32);
        Self {
            to: ToLight { closest: splat(closest), miss: splat(miss), tilt: splat(tilt) },
            phase,
        }
    }

    /// √(k(α) e^(log − mean · d)) at the ray parameter `t`.
    #[inline(always)]
    pub fn root(&self, t: Lanes<S>, log: Lanes<S>, mean: Lanes<S>) -> Lanes<S> {
        let arrival = self.to.at(t);
        let falling = ((log - mean * arrival.distance) * t.lit(0.5)).exp();
        falling * self.phase.value(arrival.cos).sqrt()
    }

    /// k(α) e^(log − mean · d)/d² at the ray parameter `t`.
    #[inline(always)]
    pub fn scattered(&self, t: Lanes<S>, log: Lanes<S>, mean: Lanes<S>) -> Lanes<S> {
        self.scattered_aside(t - self.to.closest, log, mean)
    }

    /// The same at distance `aside` from the closest point.
    #[inline(always)]
    fn scattered_aside(&self, aside: Lanes<S>, log: Lanes<S>, mean: Lanes<S>) -> Lanes<S> {
        let zero = aside.lit(0.0);
        let arrival = self.to.at_aside(aside);
        let falling = arrival.falloff((log - mean.max(zero) * arrival.distance).exp());
        if self.phase.is_isotropic() {
            return falling * aside.lit(PhaseFunction::ISOTROPIC.value(0.0));
        }
        falling * self.phase.value(arrival.cos)
    }
}

/// Airlight of a head per unit of ω·I₀.
#[inline(always)]
pub fn head<S: Simd>(simd: S, head: &Head, terms: &Terms<S>, light: &Light<S>) -> Lanes<S> {
    let begin = terms.value(simd, &head.begin) - light.to.closest;
    let range = terms.value(simd, &head.range);
    let mut sum = Lanes::splat(simd, 0.0);
    for node in &head.nodes {
        let log = terms.value(simd, &node.log).min(Lanes::splat(simd, node.most));
        let mean = terms.value(simd, &node.mean);
        let aside = range.mul_add(Lanes::splat(simd, node.share), begin);
        sum += light.scattered_aside(aside, log, mean);
    }
    sum
}

/// A field of a tail at the pixels: a cubic along the ray.
struct Cubic<S: Simd>(Lanes<S>, Lanes<S>, Lanes<S>, Lanes<S>);

impl<S: Simd> Cubic<S> {
    #[inline(always)]
    fn new(simd: S, terms: &Terms<S>, field: &[Quadratic; TAIL]) -> Self {
        Self(
            terms.value(simd, &field[0]),
            terms.value(simd, &field[1]),
            terms.value(simd, &field[2]),
            terms.value(simd, &field[3]),
        )
    }

    #[inline(always)]
    fn at(&self, x: Lanes<S>) -> Lanes<S> {
        x.mul_add(x.mul_add(x.mul_add(self.3, self.2), self.1), self.0)
    }
}

/// Where a tail's share 0 is at the pixels [m], and its share by metre.
#[inline(always)]
fn chart<S: Simd>(simd: S, tail: &Tail, terms: &Terms<S>) -> (Lanes<S>, Lanes<S>) {
    let range = terms.value(simd, &tail.range);
    let least = range.lit(f64::from(f32::MIN_POSITIVE));
    (terms.value(simd, &tail.begin), range.lit(1.0) / range.max(least))
}

/// Airlight of a tail per unit of ω·I₀, for rays of their own `length`.
#[inline(always)]
pub fn tail<S: Simd>(
    simd: S,
    tail: &Tail,
    terms: &Terms<S>,
    light: &Light<S>,
    length: Lanes<S>,
) -> Lanes<S> {
    let zero = length.lit(0.0);
    let log = Cubic::new(simd, terms, &tail.log);
    let mean = Cubic::new(simd, terms, &tail.mean);
    let chart = chart(simd, tail, terms);
    let start = Lanes::splat(simd, tail.from) - light.to.closest;
    let end = (length - light.to.closest).max(start);
    let turn = zero.max(start).min(end);
    let mut sum = zero;
    // Apart at the closest point, either piece spans less than a right angle from the light.
    for (from, to) in [(start, turn), (turn, end)] {
        if !Lanes::<S>::any(from.lt(to)) {
            continue;
        }
        sum += piece(simd, tail, chart, [&log, &mean], light, (from, to));
    }
    sum
}

/// A short Gauss rule in the chord between the ends' directions from the light, nearly their angle:
/// 1/d² is almost constant in it.
#[inline(always)]
fn piece<S: Simd>(
    simd: S,
    tail: &Tail,
    (tail_begin, scale): (Lanes<S>, Lanes<S>),
    [log, mean]: [&Cubic<S>; 2],
    light: &Light<S>,
    (from, to): (Lanes<S>, Lanes<S>),
) -> Lanes<S> {
    let one = from.lit(1.0);
    let near = from.mul_add(from, light.to.miss.squared()).sqrt();
    let far = to.mul_add(to, light.to.miss.squared()).sqrt();
    let range = (to - from) * near * far;
    let begin = tail_begin - light.to.closest;
    let most = Lanes::splat(simd, tail.most);
    let mut sum = from.lit(0.0);
    for i in 0..TAIL {
        let (x, weight) = (Lanes::splat(simd, SHORT.0[i]), Lanes::splat(simd, SHORT.1[i]));
        let rest = one - x;
        let inverse = one / rest.mul_add(far, x * near);
        let aside = rest.mul_add(from * far, x * to * near) * inverse;
        let at = (aside - begin) * scale;
        let value = light.scattered_aside(aside, log.at(at).min(most), mean.at(at));
        sum += weight * range * inverse.squared() * value;
    }
    sum
}

/// Gauss–Legendre abscissae and weights of a tail.
static SHORT: LazyLock<([f32; TAIL], [f32; TAIL])> = LazyLock::new(|| {
    let (nodes, weights) = gauss_legendre(TAIL);
    (std::array::from_fn(|i| nodes[i] as f32), std::array::from_fn(|i| weights[i] as f32))
});
