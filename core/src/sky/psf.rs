//! Glow of a sky by the point spread function of single scattering: a sky seen through fog of the depth T is blurred by
//! T e^(−T) NPSF (Sun 2005, eqs. 22 and 25–27; Fogshop 2007, eqs. 18 and 28). It stands for light that comes from a
//! sphere as far away as the fog is long; its factorisation is exact only at T = 1, and far off beyond small angles:
//! the error is 21 % at an angle of 0.1, 42 % at 0.3 and above 100 % beyond 1 rad.

use super::Radiance;
use super::harmonics;
use glam::DVec3;
use std::f64::consts::PI;

/// Factors of the normalised point spread function's first bands, √(4π/(2l+1)) times its coefficients (errata 16: the
/// printed ones are 6e-6 to 3e-5 too high).
const COEFFICIENTS: [f64; 6] =
    [0.332_812_4, 0.332_478_5, 0.302_415_2, 0.275_756_0, 0.254_029_0, 0.236_306_3];

/// A sky blurred by the normalised point spread function.
#[derive(Clone, Debug, PartialEq)]
pub struct Glow(Vec<DVec3>);

impl Glow {
    /// Of a sky.
    pub fn new(sky: &Radiance) -> Self {
        let factor = |l: usize| (4.0 * PI / (2 * l + 1) as f64).sqrt() * COEFFICIENTS[l];
        Self(sky.blurred(&std::array::from_fn::<_, 6, _>(factor)))
    }

    /// L ∗ NPSF in a direction [W/(m² sr)].
    pub fn toward(&self, d: DVec3) -> DVec3 {
        let values = harmonics::all(COEFFICIENTS.len(), d);
        let sum: DVec3 = self.0.iter().zip(values).map(|(factor, value)| *factor * value).sum();
        sum.max(DVec3::ZERO)
    }

    /// T e^(−T) L ∗ NPSF: what fog of the depth T scatters of it into a ray [W/(m² sr)].
    pub fn airlight(&self, depth: f64, d: DVec3) -> DVec3 {
        self.toward(d) * (depth * (-depth).exp())
    }
}

/// Depth of the fog before a sky along a ray of some length: of what is the same everywhere no more counts than the
/// light's own path.
pub fn depth_before(depth: f64, beta: f64, length_m: f64, path_m: f64) -> f64 {
    (depth - beta * (length_m - path_m).max(0.0)).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::adaptive;

    /// The coefficients are those of the function itself (Sun 21): F(u, v) = ∫ e^(−u tan ξ) dξ up to v.
    #[test]
    fn the_coefficients_are_the_functions() {
        let npsf = |angle: f64| {
            let u = angle.sin();
            let f = adaptive(&[0.5 * angle, 0.5 * PI - 1e-9], 1e-10, |xi| (-u * xi.tan()).exp());
            f / (2.0 * PI * u * (angle.cos() - 1.0).exp())
        };
        for (l, expected) in COEFFICIENTS.iter().enumerate() {
            let value = |angle: f64| {
                let own = harmonics::all(6, DVec3::new(angle.sin(), 0.0, angle.cos()))[l * l + l];
                2.0 * PI * angle.sin() * npsf(angle) * own
            };
            let sum = adaptive(&[1e-9, 0.1, 1.0, PI - 1e-9], 1e-8, value);
            assert!((sum - expected).abs() < 1e-6, "{l}: {sum}");
        }
    }

    /// A sky of one colour stays one, √(4π) c₀ times as bright.
    #[test]
    fn an_even_sky_glows_evenly() {
        let glow = Glow::new(&Radiance::default());
        let factor = (4.0 * PI).sqrt() * COEFFICIENTS[0];
        let expected = DVec3::new(0.3, 0.4, 0.5) * factor;
        for d in [DVec3::X, DVec3::Y, DVec3::new(0.6, -0.8, 0.0)] {
            assert!(glow.toward(d).distance(expected) < 1e-12);
            assert!(glow.airlight(1.0, d).distance(expected * (-1.0f64).exp()) < 1e-12);
        }
    }
}
