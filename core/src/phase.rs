//! The phase function k(α): which share of the scattered light goes where, per solid angle [1/sr].
//!
//! Henyey and Greenstein 1941: k = (1 − g²) / (4π (1 + g² − 2 g cos α)^(3/2)), α the angle between
//! the direction in which the light travels and the direction back to the eye (erratum 9 of
//! Fogshop: minus the cosine printed there). With g > 0 fog glows around a lamp that one looks at.

use crate::json::tagged::tagged;
use crate::json::{Checker, limits};
use crate::num::Num;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

tagged!(
    /// The phase function.
    Phase {
        /// Light is scattered the same into all directions: 1/(4π).
        Isotropic = "isotropic",
        /// Light is scattered more ahead or more back, by one number (Henyey and Greenstein 1941).
        HenyeyGreenstein = "henyey_greenstein",
    }
);

/// The same into all directions.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Isotropic {}

/// (1 − g²) / (4π (1 + g² − 2 g cos α)^1.5), α between the light's direction and that to the eye.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct HenyeyGreenstein {
    /// Mean cosine of the scattering angle: above 0 the fog glows when looking towards the light,
    /// below 0 with the light behind one's back, and 0 is isotropic.
    #[schemars(range(min = limits::ANISOTROPY.min, max = limits::ANISOTROPY.max))]
    pub g: f64,
}

impl Default for HenyeyGreenstein {
    fn default() -> Self {
        Self { g: 0.5 }
    }
}

/// A phase function; g = 0 is the isotropic one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PhaseFunction {
    /// Mean cosine of the scattering angle, in (−1, 1).
    pub g: f64,
}

impl PhaseFunction {
    /// The same into all directions: 1/(4π).
    pub const ISOTROPIC: Self = Self { g: 0.0 };

    /// Whether light is scattered the same into all directions.
    pub fn is_isotropic(self) -> bool {
        self.g == 0.0
    }

    /// k(α) [1/sr] for a cosine in [−1, 1].
    #[inline(always)]
    pub fn value<N: Num>(self, cos: N) -> N {
        // 1 + g² − 2 g cos α as a sum of what is not negative: it keeps the digits of a sharp peak.
        let toward = if self.g < 0.0 { -cos } else { cos };
        let off = (cos.lit(1.0) - toward).max(cos.lit(0.0));
        let sharp = 1.0 - self.g.abs();
        let square = off.mul_add(cos.lit(2.0 * self.g.abs()), cos.lit(sharp * sharp));
        let scale = (1.0 - self.g * self.g) / (4.0 * PI);
        cos.lit(scale) / (square * square.sqrt())
    }
}

/// Steps of a tabulated phase function: a peak of g = 0.95 is twenty of them wide.
pub const STEPS: usize = 1024;

impl PhaseFunction {
    /// k and ∫ k dα, by the angle between the light's direction and that to the eye, at even steps from 0 to π.
    pub fn tabulated(self) -> [Vec<f32>; 2] {
        let step = PI / STEPS as f64;
        let value = |i: f64| self.value((i * step).cos());
        let mut sum = 0.0;
        let (mut values, mut sums) = (vec![value(0.0) as f32], vec![0.0]);
        for i in 0..STEPS {
            // Simpson's rule.
            let at = i as f64;
            sum += step / 6.0 * (value(at) + 4.0 * value(at + 0.5) + value(at + 1.0));
            values.push(value(at + 1.0) as f32);
            sums.push(sum as f32);
        }
        [values, sums]
    }
}

impl Phase {
    /// What it says.
    pub fn function(&self) -> PhaseFunction {
        match self {
            Self::Isotropic(_) => PhaseFunction::ISOTROPIC,
            Self::HenyeyGreenstein(phase) => PhaseFunction { g: phase.g },
        }
    }

    /// Looks at its numbers; `at` is where it stands.
    pub fn check(&self, check: &mut Checker, at: impl Fn() -> String) {
        if let Self::HenyeyGreenstein(phase) = self {
            check.number(phase.g, limits::ANISOTROPY, || at() + "/g");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::PhaseFunction;
    use crate::quadrature::adaptive;
    use std::f64::consts::PI;

    /// ∫ f(cos α) k(α) dω over the sphere.
    fn over_the_sphere(g: f64, f: impl Fn(f64) -> f64) -> f64 {
        adaptive(&[-1.0, 0.0, 1.0], 1e-10, |cos| 2.0 * PI * f(cos) * PhaseFunction { g }.value(cos))
    }

    /// All scattered light goes somewhere, and g is the mean cosine of where.
    #[test]
    fn the_whole_is_one_and_the_mean_cosine_is_g() {
        for g in [-0.99, -0.5, 0.0, 0.3, 0.9, 0.99] {
            assert!((over_the_sphere(g, |_| 1.0) - 1.0).abs() < 1e-8, "g = {g}");
            assert!((over_the_sphere(g, |cos| cos) - g).abs() < 1e-8, "g = {g}");
        }
    }

    /// Straight on, the peak is (1 + g) / (4π (1 − g)²).
    #[test]
    fn the_peak_lies_ahead_where_g_is_positive() {
        let peak = 1.99 / (4.0 * PI * 1e-4);
        assert!((PhaseFunction { g: 0.99 }.value(1.0) / peak - 1.0).abs() < 1e-12);
        assert_eq!(PhaseFunction { g: -0.99 }.value(-1.0), PhaseFunction { g: 0.99 }.value(1.0));
        assert_eq!(PhaseFunction::ISOTROPIC.value(0.7), 1.0 / (4.0 * PI));
    }
}
