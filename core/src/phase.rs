//! The phase function k(α): which share of the scattered light goes where, per solid angle [1/sr].
//!
//! Henyey and Greenstein 1941: k = (1 − g²) / (4π (1 + g² − 2 g cos α)^(3/2)), α the angle between
//! the direction in which the light travels and the direction back to the eye (erratum 9 of
//! Fogshop: minus the cosine printed there). With g > 0 fog glows around a lamp that one looks at.

use crate::num::Num;
use crate::scene;

/// A phase function; g = 0 is the isotropic one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Phase {
    /// Mean cosine of the scattering angle, in (−1, 1).
    pub g: f64,
}

impl Phase {
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
        let scale = (1.0 - self.g * self.g) / (4.0 * std::f64::consts::PI);
        cos.lit(scale) / (square * square.sqrt())
    }
}

impl From<&scene::Phase> for Phase {
    fn from(phase: &scene::Phase) -> Self {
        match phase {
            scene::Phase::Isotropic(_) => Self::ISOTROPIC,
            scene::Phase::HenyeyGreenstein(phase) => Self { g: phase.g },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Phase;
    use crate::quadrature::adaptive;
    use std::f64::consts::PI;

    /// ∫ f(cos α) k(α) dω over the sphere.
    fn over_the_sphere(g: f64, f: impl Fn(f64) -> f64) -> f64 {
        adaptive(&[-1.0, 0.0, 1.0], 1e-10, |cos| 2.0 * PI * f(cos) * Phase { g }.value(cos))
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
        assert!((Phase { g: 0.99 }.value(1.0) / peak - 1.0).abs() < 1e-12);
        assert_eq!(Phase { g: -0.99 }.value(-1.0), Phase { g: 0.99 }.value(1.0));
        assert_eq!(Phase::ISOTROPIC.value(0.7), 1.0 / (4.0 * PI));
    }
}
