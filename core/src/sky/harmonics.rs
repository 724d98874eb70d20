//! Spherical harmonics: real, orthonormal, index l² + l + m, polar axis +Z, no Condon–Shortley sign.

use crate::json::limits::COUNTS;
use glam::DVec3;
use std::f64::consts::{PI, SQRT_2};
use std::sync::LazyLock;

/// Most bands.
const BANDS: usize = COUNTS.harmonics.isqrt();

/// The factors of the recurrence in l by l and m, of functions that are normalised, and their inverses.
static STEPS: LazyLock<Vec<[f64; 2]>> = LazyLock::new(|| {
    let step = |place: usize| {
        let (l, m) = ((place / BANDS + 1) as f64, (place % BANDS) as f64);
        let step = ((4.0 * l * l - 1.0) / (l * l - m * m)).sqrt();
        [step, 1.0 / step]
    };
    (0..BANDS * BANDS).map(step).collect()
});

/// The factor from the band before `l`, and its inverse.
fn step(l: usize, m: usize) -> [f64; 2] {
    STEPS[(l - 1) * BANDS + m]
}

/// All functions of the bands below `order` towards a unit vector.
pub fn all(order: usize, d: DVec3) -> Vec<f64> {
    let mut values = vec![0.0; order * order];
    fill(order, d, &mut values);
    values
}

/// The same into a list of that length. No more bands than a sky may have.
pub fn fill(order: usize, d: DVec3, values: &mut [f64]) {
    // (x + iy)ᵐ, and Pₗᵐ / sinᵐ: no angle is ever needed.
    let (mut cos, mut sin) = (1.0, 0.0);
    let mut diagonal = (0.25 / PI).sqrt();
    for m in 0..order {
        let (mut before, mut own) = (0.0, diagonal);
        for l in m..order {
            let place = l * l + l;
            if m == 0 {
                values[place] = own;
            } else {
                values[place + m] = SQRT_2 * own * cos;
                values[place - m] = SQRT_2 * own * sin;
            }
            let below = if l > m { before * step(l, m)[1] } else { 0.0 };
            (before, own) = (own, step(l + 1, m)[0] * (d.z * own - below));
        }
        (cos, sin) = (d.x * cos - d.y * sin, d.x * sin + d.y * cos);
        diagonal *= ((2 * m + 3) as f64 / (2 * m + 2) as f64).sqrt();
    }
}

/// The band of each function below `order`.
pub fn bands(order: usize) -> impl Iterator<Item = usize> {
    (0..order).flat_map(|l| std::iter::repeat_n(l, 2 * l + 1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sky::parts::{Fineness, around};

    /// They are orthonormal, and the addition theorem holds.
    #[test]
    fn the_functions_are_orthonormal() {
        const ORDER: usize = 7;
        let mut sums = vec![[0.0; ORDER * ORDER]; ORDER * ORDER];
        for (d, weight) in around(DVec3::Z, &Fineness::REFERENCE.even(), 32) {
            let values = all(ORDER, d);
            for (row, a) in sums.iter_mut().zip(&values) {
                row.iter_mut().zip(&values).for_each(|(sum, b)| *sum += weight * a * b);
            }
        }
        for (i, row) in sums.iter().enumerate() {
            for (k, sum) in row.iter().enumerate() {
                assert!((sum - f64::from(u8::from(i == k))).abs() < 1e-12, "{i} {k}: {sum}");
            }
        }
        let (a, b) = (DVec3::new(0.6, 0.0, 0.8), DVec3::new(-0.36, 0.48, 0.8));
        let (a, b, cos) = (all(3, a), all(3, b), a.dot(b));
        let sum = |from: usize, to: usize| (from..to).map(|i| a[i] * b[i]).sum::<f64>();
        assert!((sum(1, 4) - 3.0 / (4.0 * PI) * cos).abs() < 1e-14);
        assert!((sum(4, 9) - 5.0 / (4.0 * PI) * (1.5 * cos * cos - 0.5)).abs() < 1e-14);
    }

    /// As the scene's format says: index 3 grows towards +x, 1 towards +y, 2 towards +z.
    #[test]
    fn the_first_band_is_the_axes() {
        let scale = (0.75 / PI).sqrt();
        let d = DVec3::new(0.2, -0.3, (1.0f64 - 0.13).sqrt());
        let values = all(2, d);
        for (place, axis) in [(1, d.y), (2, d.z), (3, d.x)] {
            assert!((values[place] - scale * axis).abs() < 1e-15);
        }
    }
}
