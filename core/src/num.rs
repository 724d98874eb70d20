//! The number type of the maths: f64 for one ray, or a vector of f32 for as many pixels as the
//! machine has lanes. One text of a formula, written over [`Num`], serves both.
//!
//! A constant takes its lanes from a value at hand: `x.lit(0.5)`.

use fearless_simd::{ExtractToken, Select, Simd, SimdBase, SimdFloat, SimdMask};
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// A real number, or several at once.
///
/// Relative accuracy of `exp`, `ln` and the error functions: rounding in f64; better than 1e-6 in
/// f32 lanes for arguments that the maths of fog meets (`exp` stops falling at e⁻⁸⁷).
pub trait Num:
    Copy
    + Add<Output = Self>
    + AddAssign
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The outcome of a comparison.
    type Mask: Copy;

    /// A constant in the lanes of `self`.
    fn lit(self, value: f64) -> Self;
    /// `self · b + c`, rounded once where the machine can.
    fn mul_add(self, b: Self, c: Self) -> Self;
    /// √self.
    fn sqrt(self) -> Self;
    /// |self|.
    fn abs(self) -> Self;
    /// The smaller one.
    fn min(self, other: Self) -> Self;
    /// The larger one.
    fn max(self, other: Self) -> Self;
    /// e^self.
    fn exp(self) -> Self;
    /// What is left of a Gaussian, e^(−self) of a square. In lanes it ends at 4e-18: products of numbers that are
    /// almost none take a processor a hundred times as long.
    fn bell(self) -> Self;
    /// Natural logarithm of a positive number.
    fn ln(self) -> Self;
    /// The largest whole number that is not above it.
    fn floor(self) -> Self;
    /// sin 2πx of an angle in turns; in f32 lanes its absolute error is below 2e-7 and that of the angle's own
    /// rounding.
    fn sin_turns(self) -> Self;
    /// Arc tangent; in f32 lanes its absolute error is below 2e-7.
    fn atan(self) -> Self;
    /// The angle from 0 to π whose sine and cosine are as `opposite` ≥ 0 to `adjacent`.
    #[inline(always)]
    fn angle(opposite: Self, adjacent: Self) -> Self {
        // A zero with a sign would be divided by to the wrong side.
        let adjacent = adjacent + adjacent.lit(0.0);
        let acute = (opposite / adjacent).atan();
        let obtuse = adjacent.lt(adjacent.lit(0.0));
        Self::select(obtuse, acute + acute.lit(std::f64::consts::PI), acute)
    }
    /// 1 − e^(−T) of an optical depth, which keeps its digits in thin fog.
    #[inline(always)]
    fn absorptance(self) -> Self {
        /// Up to here the series is exact to 1e-7 of it.
        const THIN: f64 = 0.01;
        let one = self.lit(1.0);
        let bend = self.mul_add(self.lit(1.0 / 6.0), self.lit(-0.5));
        let series = self * self.mul_add(bend, one);
        Self::select(self.lt(self.lit(THIN)), series, one - (-self).exp())
    }
    /// Error function; in f32 lanes its absolute error is below 1.5e-6, and smooth.
    fn erf(self) -> Self;
    /// erf(y) − erf(x) for x ≤ y, with relative accuracy also where both terms are almost equal:
    /// far out in a tail, and in f64 close together.
    fn erf_difference(x: Self, y: Self) -> Self;
    /// erf(y) − erf(x) as two look-ups would give it: cheaper, its absolute error below 3e-6 in f32
    /// lanes.
    fn erf_plain_difference(x: Self, y: Self) -> Self;
    /// self < other.
    fn lt(self, other: Self) -> Self::Mask;
    /// Whether the mask holds in any lane.
    fn any(mask: Self::Mask) -> bool;
    /// `a` where the mask holds, else `b`.
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self;
    /// The smallest and the largest lane.
    fn range(self) -> [f64; 2];
    /// What a function of two numbers makes of each lane: for look-ups, which lanes cannot do.
    fn each(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self;

    /// self².
    #[inline(always)]
    fn squared(self) -> Self {
        self * self
    }
}

impl Num for f64 {
    type Mask = bool;

    #[inline(always)]
    fn lit(self, value: f64) -> f64 {
        value
    }
    #[inline(always)]
    fn mul_add(self, b: f64, c: f64) -> f64 {
        // f64::mul_add without the instruction is a slow call; rounding twice is fine here.
        self * b + c
    }
    #[inline(always)]
    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }
    #[inline(always)]
    fn abs(self) -> f64 {
        f64::abs(self)
    }
    #[inline(always)]
    fn min(self, other: f64) -> f64 {
        f64::min(self, other)
    }
    #[inline(always)]
    fn max(self, other: f64) -> f64 {
        f64::max(self, other)
    }
    #[inline(always)]
    fn exp(self) -> f64 {
        f64::exp(self)
    }
    #[inline(always)]
    fn bell(self) -> f64 {
        f64::exp(-self)
    }
    #[inline(always)]
    fn ln(self) -> f64 {
        f64::ln(self)
    }
    #[inline(always)]
    fn floor(self) -> f64 {
        f64::floor(self)
    }
    #[inline(always)]
    fn sin_turns(self) -> f64 {
        (std::f64::consts::TAU * (self - self.round())).sin()
    }
    #[inline(always)]
    fn atan(self) -> f64 {
        f64::atan(self)
    }
    #[inline(always)]
    fn erf(self) -> f64 {
        libm::erf(self)
    }
    #[inline(always)]
    fn erf_difference(x: f64, y: f64) -> f64 {
        let (middle, width) = (0.5 * (x + y), y - x);
        if width * (1.0 + middle.abs()) < 1e-3 {
            // Taylor around the middle; the next term is below 1e-12 of the sum.
            let square = middle * middle;
            let bend = 1.0 + width * width * (4.0 * square - 2.0) / 24.0;
            std::f64::consts::FRAC_2_SQRT_PI * f64::exp(-square) * width * bend
        } else if x > 0.5 {
            libm::erfc(x) - libm::erfc(y)
        } else if y < -0.5 {
            libm::erfc(-y) - libm::erfc(-x)
        } else {
            libm::erf(y) - libm::erf(x)
        }
    }
    #[inline(always)]
    fn erf_plain_difference(x: f64, y: f64) -> f64 {
        libm::erf(y) - libm::erf(x)
    }
    #[inline(always)]
    fn lt(self, other: f64) -> bool {
        self < other
    }
    #[inline(always)]
    fn any(mask: bool) -> bool {
        mask
    }
    #[inline(always)]
    fn select(mask: bool, a: f64, b: f64) -> f64 {
        if mask { a } else { b }
    }
    #[inline(always)]
    fn range(self) -> [f64; 2] {
        [self; 2]
    }
    #[inline(always)]
    fn each(self, other: f64, f: impl Fn(f64, f64) -> f64) -> f64 {
        f(self, other)
    }
}

/// As many f32 as one register of the machine holds.
#[derive(Clone, Copy, Debug)]
pub struct Lanes<S: Simd>(pub S::f32s);

impl<S: Simd> Lanes<S> {
    /// How many.
    pub const COUNT: usize = S::f32s::LEN;

    /// The same number in every lane.
    #[inline(always)]
    pub fn splat(simd: S, value: f32) -> Self {
        Self(S::f32s::splat(simd, value))
    }

    /// The first lanes of a slice that is at least that long.
    #[inline(always)]
    pub fn load(simd: S, values: &[f32]) -> Self {
        Self(S::f32s::from_slice(simd, &values[..Self::COUNT]))
    }

    /// Writes to the start of a slice.
    #[inline(always)]
    pub fn store(self, out: &mut [f32]) {
        self.0.store_slice(&mut out[..Self::COUNT]);
    }

    /// The largest lane.
    #[inline(always)]
    pub fn largest(self) -> f32 {
        self.0.reduce_max()
    }

    /// The smallest and the largest of some numbers, none of which is NaN; both infinite if there are none.
    #[inline(always)]
    pub fn extremes(simd: S, row: &[f32]) -> [f32; 2] {
        let mut least = Self::splat(simd, f32::INFINITY);
        let mut most = Self::splat(simd, f32::NEG_INFINITY);
        let whole = row.chunks_exact(Self::COUNT);
        let rest = whole.remainder();
        for some in whole {
            let some = Self::load(simd, some);
            (least, most) = (least.min(some), most.max(some));
        }
        let ends = [least.0.reduce_min(), most.0.reduce_max()];
        rest.iter().fold(ends, |[least, most], one| [least.min(*one), most.max(*one)])
    }

    #[inline(always)]
    fn constant(self, value: f32) -> S::f32s {
        S::f32s::splat(self.0.token(), value)
    }

    /// Σ c_i xⁱ.
    #[inline(always)]
    fn polynomial<const D: usize>(self, coefficients: [f32; D]) -> S::f32s {
        let mut sum = self.constant(coefficients[D - 1]);
        for c in coefficients[..D - 1].iter().rev() {
            sum = sum.mul_add(self.0, self.constant(*c));
        }
        sum
    }

    /// c₀ + c₁x.
    #[inline(always)]
    fn line(self, c0: f32, c1: f32) -> S::f32s {
        self.0.mul_add(self.constant(c1), self.constant(c0))
    }

    /// Σ c_i xⁱ by Estrin's scheme, given x²: a short chain of operations, which the kernels need
    /// more than few operations.
    #[inline(always)]
    fn cubic(self, square: S::f32s, [a, b, c, d]: [f32; 4]) -> S::f32s {
        square.mul_add(self.line(c, d), self.line(a, b))
    }

    /// The same to the fifth power.
    #[inline(always)]
    fn quintic(self, square: S::f32s, [a, b, c, d, e, f]: [f32; 6]) -> S::f32s {
        let high = square.mul_add(self.line(e, f), self.line(c, d));
        square.mul_add(high, self.line(a, b))
    }

    /// erf as a fraction x·P(x²)/Q(x²), clamped where it is 1 to 1.2e-7.
    #[inline(always)]
    fn erf_fraction(self) -> (Self, Self) {
        const P: [f32; 6] = [
            1.128_385_2,
            0.141_688_87,
            0.042_172_465,
            0.000_528_144_7,
            1.003_509_2e-5,
            -2.489_076_4e-7,
        ];
        const Q: [f32; 4] = [1.0, 0.458_962_8, 0.090_178_76, 0.008_686_423];
        let end = self.lit(3.75);
        let x = self.min(end).max(-end);
        let t = x.squared();
        let square = t.0 * t.0;
        (Self(x.0 * t.quintic(square, P)), Self(t.cubic(square, Q)))
    }

    /// erfc for x ≥ 0 with a relative error below 1e-6.
    #[inline(always)]
    fn erfc_positive(self) -> Self {
        // Minimax fit of erfcx(x)/t in t = 1/(1 + x/2), written in z = 2t − 1.
        const FIT: [f32; 9] = [
            0.510_791_54,
            0.343_580_87,
            0.139_726_83,
            0.018_210_603,
            -0.010_692_768,
            -0.003_194_282_5,
            0.001_393_227_6,
            0.000_355_675_7,
            -0.000_171_308_75,
        ];
        let one = self.lit(1.0);
        let t = one / self.mul_add(self.lit(0.5), one);
        let z = t.mul_add(self.lit(2.0), -one);
        self.squared().bell() * t * Self(z.polynomial(FIT))
    }
}

macro_rules! lanewise {
    ($($trait:ident $method:ident),*) => {$(
        impl<S: Simd> $trait for Lanes<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0))
            }
        }
    )*};
}
lanewise!(Add add, Sub sub, Mul mul, Div div);

impl<S: Simd> AddAssign for Lanes<S> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        self.0 = self.0 + other.0;
    }
}

impl<S: Simd> Neg for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl<S: Simd> Num for Lanes<S> {
    type Mask = S::mask32s;

    #[inline(always)]
    fn lit(self, value: f64) -> Self {
        Self(self.constant(value as f32))
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        Self(self.0.mul_add(b.0, c.0))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs())
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(self.0.min(other.0))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(self.0.max(other.0))
    }

    /// 2^n · 2^f with n by the rounding of a large addend and a minimax fit of 2^f on [−½, ½].
    #[inline(always)]
    fn exp(self) -> Self {
        const FIT: [f32; 6] =
            [1.000_000_1, 0.693_146_94, 0.240_221_2, 0.055_507_135, 0.009_675_541, 0.001_327_646_7];
        const ROUND: f32 = 12_582_912.0; // 1.5 · 2²³: the sum's low bits are the rounded addend
        const LOG2_E: f32 = std::f32::consts::LOG2_E;
        let x = self.0.max(self.constant(-87.0)).min(self.constant(88.0));
        let shifted = x.mul_add(self.constant(LOG2_E), self.constant(ROUND));
        let n = shifted - ROUND;
        let f = Self(x.mul_add(self.constant(LOG2_E), -n));
        let scale = (shifted.to_bits() << 23) + 0x3f80_0000;
        Self(f.quintic(f.0 * f.0, FIT) * S::f32s::from_bits(scale))
    }

    #[inline(always)]
    fn bell(self) -> Self {
        Self::select(self.lt(self.lit(40.0)), (-self).exp(), self.lit(0.0))
    }

    /// Exponent and mantissa taken apart; a minimax fit of ln(1 + m)/m around 1.
    #[inline(always)]
    fn ln(self) -> Self {
        const FIT: [f32; 8] = [
            0.999_999_94,
            -0.500_003_46,
            0.333_356_08,
            -0.249_715_6,
            0.198_842_39,
            -0.172_124_37,
            0.163_381_16,
            -0.103_786_424,
        ];
        const SQRT_HALF: u32 = 0x3f35_04f3;
        const EXPONENT_BIAS: u32 = 127 << 23;
        let bits = self.0.max(self.constant(f32::MIN_POSITIVE)).to_bits();
        let biased = (bits + (EXPONENT_BIAS - SQRT_HALF)) >> 23;
        // 2²³ + biased, read as a float.
        let exponent = S::f32s::from_bits(biased + 0x4b00_0000) - (8_388_608.0 + 127.0);
        let mantissa = S::f32s::from_bits((bits + EXPONENT_BIAS) - (biased << 23));
        let m = Self(mantissa - 1.0);
        let log = m.0 * m.polynomial(FIT);
        Self(exponent.mul_add(self.constant(std::f32::consts::LN_2), log))
    }

    #[inline(always)]
    fn floor(self) -> Self {
        Self(self.0.floor())
    }

    /// Folded to a quarter turn on either side of 0; there a minimax fit of odd powers.
    #[inline(always)]
    fn sin_turns(self) -> Self {
        const FIT: [f32; 5] =
            [std::f32::consts::TAU, -41.341_656, 81.601_006, -76.549_78, 39.536_705];
        let half = self.lit(0.5);
        let turn = self - (self + half).floor();
        let quarter = self.lit(0.25);
        let folded = Self::select(quarter.lt(turn), half - turn, turn);
        let x = Self::select(turn.lt(-quarter), -half - turn, folded);
        x * Self(x.squared().polynomial(FIT))
    }

    /// Abramowitz and Stegun 4.4.49 on [0, 1]; beyond, π/2 − atan(1/x).
    #[inline(always)]
    fn atan(self) -> Self {
        const FIT: [f32; 9] = [
            1.0,
            -0.333_331_45,
            0.199_935_5,
            -0.142_089,
            0.106_562_64,
            -0.075_289_64,
            0.042_909_614,
            -0.016_165_737,
            0.002_866_225_7,
        ];
        let (one, size) = (self.lit(1.0), self.abs());
        let beyond = one.lt(size);
        let x = Self::select(beyond, one / size.max(one), size);
        let angle = x * Self(x.squared().polynomial(FIT));
        let angle = Self::select(beyond, self.lit(std::f64::consts::FRAC_PI_2) - angle, angle);
        Self::select(self.lt(self.lit(0.0)), -angle, angle)
    }
    #[inline(always)]
    fn erf(self) -> Self {
        let (numerator, denominator) = self.erf_fraction();
        numerator / denominator
    }

    /// One division for both.
    #[inline(always)]
    fn erf_plain_difference(x: Self, y: Self) -> Self {
        let (x, x_below) = x.erf_fraction();
        let (y, y_below) = y.erf_fraction();
        y.mul_add(x_below, -(x * y_below)) / (x_below * y_below)
    }

    #[inline(always)]
    fn erf_difference(x: Self, y: Self) -> Self {
        let plain = Self::erf_plain_difference(x, y);
        // The nearer end's distance from 0 where both lie on one side, else negative.
        let near = x.max(-y);
        let tail = x.lit(1.2).lt(near);
        if !Self::any(tail) {
            return plain;
        }
        let far = y.max(-x);
        let exact = near.erfc_positive() - far.erfc_positive();
        Self::select(tail, exact, plain)
    }

    #[inline(always)]
    fn lt(self, other: Self) -> Self::Mask {
        self.0.simd_lt(other.0)
    }
    #[inline(always)]
    fn any(mask: Self::Mask) -> bool {
        mask.any_true()
    }
    #[inline(always)]
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self {
        Self(mask.select(a.0, b.0))
    }
    #[inline(always)]
    fn range(self) -> [f64; 2] {
        [f64::from(self.0.reduce_min()), f64::from(self.0.reduce_max())]
    }
    #[inline(always)]
    fn each(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut lanes = [[0.0; 16]; 2];
        self.store(&mut lanes[0]);
        other.store(&mut lanes[1]);
        let [own, others] = &mut lanes;
        for (a, b) in own.iter_mut().zip(others).take(Self::COUNT) {
            *a = f(f64::from(*a), f64::from(*b)) as f32;
        }
        Self::load(self.0.token(), &lanes[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};

    /// Largest error of `f` in f32 lanes over `points`, weighed by `scale`.
    fn worst(
        points: impl Iterator<Item = f64>,
        lanes: impl Fn(f32) -> f32,
        exact: impl Fn(f64) -> f64,
        scale: impl Fn(f64) -> f64,
    ) -> f64 {
        let error = |x: f64| {
            let x = f64::from(x as f32);
            (f64::from(lanes(x as f32)) - exact(x)).abs() / scale(exact(x))
        };
        points.map(error).fold(0.0, f64::max)
    }

    macro_rules! in_lanes {
        ($f:expr) => {
            |x: f32| {
                let mut out = [0.0; 16];
                dispatch!(Level::new(), simd => {
                    let f = $f;
                    f(Lanes::splat(simd, x)).store(&mut out);
                });
                out[0]
            }
        };
    }

    fn grid(from: f64, to: f64) -> impl Iterator<Item = f64> {
        (0..=4000).map(move |i| from + (to - from) * f64::from(i) / 4000.0)
    }

    #[test]
    fn atan_is_right_everywhere() {
        for reach in [1.0, 3.0, 1e3, 1e9] {
            let off = worst(grid(-reach, reach), in_lanes!(|x| Num::atan(x)), f64::atan, |_| 1.0);
            assert!(off < 2e-7, "{off} up to {reach}");
        }
    }

    #[test]
    fn exp_is_right_to_rounding_of_its_argument() {
        // An f32 argument near 80 is itself only known to 4e-6.
        let relative = worst(grid(-86.0, 80.0), in_lanes!(|x| Num::exp(x)), f64::exp, f64::abs);
        assert!(relative < 8e-6, "{relative}");
        let near = worst(grid(-2.0, 2.0), in_lanes!(|x| Num::exp(x)), f64::exp, f64::abs);
        assert!(near < 5e-7, "{near}");
        assert!(in_lanes!(|x| Num::exp(x))(-1e30) < 2e-38);
    }

    #[test]
    fn sines_are_right_in_every_quarter() {
        let sine = |x: f64| (std::f64::consts::TAU * x).sin();
        let error = worst(grid(-3.0, 3.0), in_lanes!(|x| Num::sin_turns(x)), sine, |_| 1.0);
        assert!(error < 4e-7, "{error}");
        let exact =
            worst(grid(-3.0, 3.0), in_lanes!(|x| Num::sin_turns(x)), Num::sin_turns, |_| 1.0);
        assert!(exact < 4e-7, "{exact}");
    }

    #[test]
    fn ln_inverts_exp() {
        let error =
            worst(grid(-80.0, 80.0).map(f64::exp), in_lanes!(|x| Num::ln(x)), f64::ln, |y| {
                y.abs().max(1.0)
            });
        assert!(error < 5e-7, "{error}");
    }

    #[test]
    fn erf_keeps_its_stated_error() {
        let error = worst(grid(-6.0, 6.0), in_lanes!(|x| Num::erf(x)), libm::erf, |_| 1.0);
        assert!(error < 1.5e-6, "{error}");
    }

    #[test]
    fn erf_difference_keeps_its_digits_in_the_tails() {
        // The squared argument of exp limits f32 to x² · 6e-8 · 2.
        for (x, y) in [(1.3, 1.4), (2.0, 9.0), (-7.0, -3.0), (5.0, 5.5), (-0.5, 2.0), (-4.0, 4.0)] {
            let exact = f64::erf_difference(x, y);
            let mut out = [0.0; 16];
            dispatch!(Level::new(), simd => {
                let (x, y) = (Lanes::splat(simd, x as f32), Lanes::splat(simd, y as f32));
                Num::erf_difference(x, y).store(&mut out);
            });
            let relative = (f64::from(out[0]) / exact - 1.0).abs();
            assert!(relative < 1e-5, "erf({y}) − erf({x}): {relative}");
        }
    }
}
