//! FLIP for pictures of 8 bits (Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild
//! 2020, "FLIP: A Difference Evaluator for Alternating Images"): the difference that an observer sees
//! who flips between a reference and a test picture. Names are the paper's. For a pixel:
//!
//! ΔE = ΔE_c^(1 − ΔE_f)
//!
//! ΔE_c is the difference of colours after the eye's blur, ΔE_f that of edges and points. Outside of a
//! picture its border goes on.

use crate::progress::{Interrupted, Progress};
use glam::{Mat3, Vec3};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Pixels a degree of an observer 0.7 m before a screen 0.7 m and 3840 pixels wide.
pub const PIXELS_PER_DEGREE: f64 = 3840.0 * PI / 180.0;

/// q_c: bends the distance of colours, so that small ones count for more.
const Q_C: f32 = 0.7;
/// p_c: where the distance bends, as a share of the largest.
const P_C: f32 = 0.4;
/// p_t: what the share p_c becomes.
const P_T: f32 = 0.95;
/// q_f: bends the difference of features.
const Q_F: f32 = 0.5;
/// w: how wide edges and points are [degrees].
const W: f64 = 0.082;

/// The eye's contrast sensitivity as sums of Gaussians (a, b), for Y, Cx and Cz.
const CONTRAST_SENSITIVITY: [&[(f64, f64)]; 3] =
    [&[(1.0, 0.0047)], &[(1.0, 0.0053)], &[(34.1, 0.04), (13.5, 0.025)]];

/// Linear sRGB to XYZ, row by row (primaries of Rec. 709, white D65).
const XYZ_OF_RGB: [[f32; 3]; 3] = [
    [0.412_386_56, 0.357_591_5, 0.180_450_5],
    [0.212_636_82, 0.715_183, 0.072_180_2],
    [0.019_330_62, 0.119_197_17, 0.950_372_6],
];

/// The mean of [`map`], in [0, 1]: 0 for the same picture, 0.97 for white and black, 1 for green and blue.
///
/// # Errors
/// [`Interrupted`] when `progress` says so.
pub fn mean(
    reference: &[u8],
    test: &[u8],
    width: usize,
    progress: &Progress,
) -> Result<f64, Interrupted> {
    let map = map(reference, test, width, progress)?;
    Ok(map.iter().map(|error| f64::from(*error)).sum::<f64>() / map.len().max(1) as f64)
}

/// ΔE of each pixel of two sRGB pictures, `[height][width][3]`, of one size.
///
/// # Errors
/// [`Interrupted`] when `progress` says so.
pub fn map(
    reference: &[u8],
    test: &[u8],
    width: usize,
    progress: &Progress,
) -> Result<Vec<f32>, Interrupted> {
    let eye = Eye::new(width, progress);
    let (reference, test) = (eye.look(reference)?, eye.look(test)?);
    let redistribution = Redistribution::new(&eye.space);
    eye.rows(reference.colours.len().min(test.colours.len()), |y, row| {
        for (x, error) in row.iter_mut().enumerate() {
            let i = y * eye.width + x;
            let distance = hyab(reference.colours[i], test.colours[i]);
            let feature = feature_difference(reference.features[i], test.features[i]);
            *error = redistribution.of(distance).powf(1.0 - feature);
        }
    })
}

/// What an observer sees of a picture.
struct Seen {
    /// L*a*b* after the blur, adjusted after Hunt.
    colours: Vec<Vec3>,
    /// How much edge and how much point there is.
    features: Vec<[f32; 2]>,
}

/// The observer: looks at pictures of one width until told to stop.
struct Eye<'a> {
    width: usize,
    progress: &'a Progress,
    space: ColourSpace,
    /// Linear light of an sRGB byte (IEC 61966-2-1).
    linear: [f32; 256],
}

impl<'a> Eye<'a> {
    fn new(width: usize, progress: &'a Progress) -> Self {
        let linear = |byte: usize| {
            let v = byte as f32 / 255.0;
            if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
        };
        let linear = std::array::from_fn(linear);
        Self { width: width.max(1), progress, space: ColourSpace::new(), linear }
    }

    fn look(&self, srgb: &[u8]) -> Result<Seen, Interrupted> {
        let [y, cx, cz] = [0, 1, 2].map(|channel| self.ycxcz(srgb, channel));
        let y = y?;
        let features = self.features(&y)?;
        let colours = self.colours(&[y, cx?, cz?])?;
        Ok(Seen { colours, features })
    }

    /// One channel of YCxCz of each pixel.
    fn ycxcz(&self, srgb: &[u8], channel: usize) -> Result<Vec<f32>, Interrupted> {
        self.rows(srgb.len() / 3, |y, row| {
            for (value, rgb) in row.iter_mut().zip(srgb[3 * y * self.width..].chunks_exact(3)) {
                let rgb = [0, 1, 2].map(|k| self.linear[usize::from(rgb[k])]);
                *value = self.space.ycxcz(rgb.into())[channel];
            }
        })
    }

    /// YCxCz blurred by the eye, kept to what sRGB can show, as L*a*b* adjusted after Hunt.
    fn colours(&self, ycxcz: &[Vec<f32>; 3]) -> Result<Vec<Vec3>, Interrupted> {
        let [y, cx, cz] = [0, 1, 2].map(|channel| self.blur(&ycxcz[channel], channel));
        let blurred = [y?, cx?, cz?];
        self.rows(blurred[0].len(), |y, row| {
            for (x, colour) in row.iter_mut().enumerate() {
                let ycxcz = Vec3::from([0, 1, 2].map(|k| blurred[k][y * self.width + x]));
                let rgb = self.space.rgb(ycxcz).clamp(Vec3::ZERO, Vec3::ONE);
                *colour = hunt(self.space.lab(rgb));
            }
        })
    }

    /// Blurs a channel by its contrast sensitivity.
    fn blur(&self, plane: &[f32], channel: usize) -> Result<Vec<f32>, Interrupted> {
        let mut sum = vec![0.0; plane.len()];
        for kernel in contrast_sensitivity(CONTRAST_SENSITIVITY[channel]) {
            let part = self.along_y(&self.along_x(plane, &kernel)?, &kernel)?;
            add(&mut sum, 1.0, &part);
        }
        Ok(sum)
    }

    /// ‖∇I‖ for edges and ‖(∂²I/∂x², ∂²I/∂y²)‖ for points of I = (Y + 16) / 116, smoothed.
    fn features(&self, y: &[f32]) -> Result<Vec<[f32; 2]>, Interrupted> {
        let luma = y.iter().map(|y| (y + 16.0) / 116.0).collect::<Vec<_>>();
        let [smooth, edge, point] = feature_kernels();
        let across = self.along_x(&luma, &smooth)?;
        let edges =
            [self.along_y(&self.along_x(&luma, &edge)?, &smooth)?, self.along_y(&across, &edge)?];
        let points =
            [self.along_y(&self.along_x(&luma, &point)?, &smooth)?, self.along_y(&across, &point)?];
        let norm = |[x, y]: &[Vec<f32>; 2], i: usize| (x[i] * x[i] + y[i] * y[i]).sqrt();
        Ok((0..luma.len()).map(|i| [norm(&edges, i), norm(&points, i)]).collect())
    }

    fn along_x(&self, plane: &[f32], kernel: &[f32]) -> Result<Vec<f32>, Interrupted> {
        let radius = kernel.len() / 2;
        self.rows(plane.len(), |y, row| {
            let from = &plane[y * self.width..][..row.len()];
            let mut padded = vec![from[0]; radius];
            padded.extend_from_slice(from);
            padded.resize(from.len() + 2 * radius, from[from.len() - 1]);
            for (offset, weight) in kernel.iter().enumerate() {
                add(row, *weight, &padded[offset..]);
            }
        })
    }

    fn along_y(&self, plane: &[f32], kernel: &[f32]) -> Result<Vec<f32>, Interrupted> {
        let radius = kernel.len() / 2;
        let last = (plane.len() / self.width).saturating_sub(1);
        self.rows(plane.len(), |y, row| {
            for (offset, weight) in kernel.iter().enumerate() {
                let from = (y + offset).saturating_sub(radius).min(last);
                add(row, *weight, &plane[from * self.width..]);
            }
        })
    }

    /// So many numbers, row by row on all cores.
    fn rows<T: Clone + Default + Send>(
        &self,
        count: usize,
        fill: impl Fn(usize, &mut [T]) + Sync,
    ) -> Result<Vec<T>, Interrupted> {
        let mut plane = vec![T::default(); count];
        plane.par_chunks_mut(self.width).enumerate().try_for_each(|(y, row)| {
            if self.progress.is_over() {
                return Err(Interrupted);
            }
            fill(y, row);
            Ok(())
        })?;
        Ok(plane)
    }
}

/// Adds what is `weight` times as much.
fn add(sum: &mut [f32], weight: f32, values: &[f32]) {
    for (sum, value) in sum.iter_mut().zip(values) {
        *sum += weight * value;
    }
}

/// Linear sRGB and XYZ relative to its white, so that white is (1, 1, 1).
struct ColourSpace {
    xyz_of_rgb: Mat3,
    rgb_of_xyz: Mat3,
}

impl ColourSpace {
    fn new() -> Self {
        let absolute = Mat3::from_cols_array_2d(&XYZ_OF_RGB).transpose();
        let white = absolute * Vec3::ONE;
        let xyz_of_rgb = Mat3::from_diagonal(white.recip()) * absolute;
        Self { xyz_of_rgb, rgb_of_xyz: xyz_of_rgb.inverse() }
    }

    /// Y = 116 y − 16, Cx = 500 (x − y), Cz = 200 (y − z).
    fn ycxcz(&self, rgb: Vec3) -> Vec3 {
        opponents(self.xyz_of_rgb * rgb)
    }

    /// Back from YCxCz.
    fn rgb(&self, ycxcz: Vec3) -> Vec3 {
        let y = (ycxcz.x + 16.0) / 116.0;
        self.rgb_of_xyz * Vec3::new(y + ycxcz.y / 500.0, y, y - ycxcz.z / 200.0)
    }

    /// L*a*b* (CIE 1976): the opponents of f(x), f(y) and f(z), f(t) = t^(1/3), a line below (6/29)³.
    fn lab(&self, rgb: Vec3) -> Vec3 {
        const DELTA: f32 = 6.0 / 29.0;
        let f = |t: f32| {
            let line = t / (3.0 * DELTA * DELTA) + 4.0 / 29.0;
            if t > DELTA.powi(3) { t.cbrt() } else { line }
        };
        opponents((self.xyz_of_rgb * rgb).map(f))
    }
}

/// Light against dark, red against green, yellow against blue.
fn opponents(v: Vec3) -> Vec3 {
    Vec3::new(116.0 * v.y - 16.0, 500.0 * (v.x - v.y), 200.0 * (v.y - v.z))
}

/// Hunt: colours are more colourful in more light, a_h = 0.01 L* a*, b_h = 0.01 L* b*.
fn hunt(lab: Vec3) -> Vec3 {
    lab * Vec3::new(1.0, 0.01 * lab.x, 0.01 * lab.x)
}

/// ΔE_HyAB = |ΔL*| + ‖(Δa_h, Δb_h)‖.
fn hyab(a: Vec3, b: Vec3) -> f32 {
    let difference = a - b;
    difference.x.abs() + difference.y.hypot(difference.z)
}

/// ΔE_c of ΔE_HyAB^q_c: [0, p_c c_max) becomes [0, p_t), the rest up to c_max becomes [p_t, 1].
struct Redistribution {
    /// c_max, the most that sRGB can show: that of green and blue.
    most: f32,
}

impl Redistribution {
    fn new(space: &ColourSpace) -> Self {
        let [green, blue] = [Vec3::Y, Vec3::Z].map(|rgb| hunt(space.lab(rgb)));
        Self { most: hyab(green, blue).powf(Q_C) }
    }

    fn of(&self, distance: f32) -> f32 {
        let share = distance.powf(Q_C) / self.most;
        if share < P_C {
            share * P_T / P_C
        } else {
            (P_T + (share - P_C) / (1.0 - P_C) * (1.0 - P_T)).min(1.0)
        }
    }
}

/// ΔE_f = (max(|Δedge|, |Δpoint|) / √2)^q_f.
fn feature_difference(a: [f32; 2], b: [f32; 2]) -> f32 {
    let difference = (a[0] - b[0]).abs().max((a[1] - b[1]).abs());
    (difference * std::f32::consts::FRAC_1_SQRT_2).min(1.0).powf(Q_F)
}

/// g(x, y) = Σ a √(π/b) e^(−π² (x² + y²) / b) [x in degrees], weighed so that it sums to 1: a sum of
/// Gaussians, each of them the product of one kernel along x and y. All reach as far as 3 σ of the
/// widest, σ² = b / (2π²).
fn contrast_sensitivity(gaussians: &[(f64, f64)]) -> Vec<Vec<f32>> {
    let widest =
        CONTRAST_SENSITIVITY.iter().copied().flatten().map(|(_, b)| *b).fold(0.0, f64::max);
    let radius = 3.0 * (widest / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE;
    let kernel = |&(a, b): &(f64, f64)| {
        let height = (a * (PI / b).sqrt()).sqrt();
        let value = |x: f64| height * (-(PI * x / PIXELS_PER_DEGREE).powi(2) / b).exp();
        sampled(radius, value)
    };
    let kernels = gaussians.iter().map(kernel).collect::<Vec<_>>();
    let total = kernels.iter().map(|kernel| kernel.iter().sum::<f64>().powi(2)).sum::<f64>().sqrt();
    kernels.iter().map(|kernel| single(kernel.iter().map(|value| value / total))).collect()
}

/// G, ∂G/∂x and ∂²G/∂x² with G = e^(−x² / (2σ²)), σ = w/2, up to 3 σ. Positive weights sum to 1,
/// negative ones to −1.
fn feature_kernels() -> [Vec<f32>; 3] {
    let sigma = 0.5 * W * PIXELS_PER_DEGREE;
    let gaussian = |x: f64| (-0.5 * (x / sigma).powi(2)).exp();
    let smooth = sampled(3.0 * sigma, gaussian);
    let edge = sampled(3.0 * sigma, |x| -x * gaussian(x));
    let point = sampled(3.0 * sigma, |x| ((x / sigma).powi(2) - 1.0) * gaussian(x));
    [smooth, edge, point].map(|kernel| {
        let sum = |sign: f64| kernel.iter().map(|v| (sign * v).max(0.0)).sum::<f64>();
        let (positive, negative) = (sum(1.0), sum(-1.0));
        single(kernel.iter().map(|v| if *v > 0.0 { v / positive } else { v / negative.max(1e-9) }))
    })
}

/// A function at each pixel from −radius to radius, rounded up.
fn sampled(radius: f64, value: impl Fn(f64) -> f64) -> Vec<f64> {
    let radius = radius.ceil() as i32;
    (-radius..=radius).map(|x| value(f64::from(x))).collect()
}

fn single(values: impl Iterator<Item = f64>) -> Vec<f32> {
    values.map(|value| value as f32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blurs_keep_what_is_even_and_features_see_nothing_in_it() {
        for gaussians in CONTRAST_SENSITIVITY {
            let kernels = contrast_sensitivity(gaussians);
            let sum: f32 = kernels.iter().map(|k| k.iter().sum::<f32>().powi(2)).sum();
            assert!((sum - 1.0).abs() < 1e-6, "{sum}");
        }
        let sums = feature_kernels().map(|kernel| kernel.iter().sum::<f32>());
        for (sum, expected) in sums.iter().zip([1.0, 0.0, 0.0]) {
            assert!((sum - expected).abs() < 1e-6, "{sum}");
        }
    }

    #[test]
    fn colours_come_back_from_their_opponents() {
        let space = ColourSpace::new();
        for rgb in [Vec3::ZERO, Vec3::ONE, Vec3::new(0.1, 0.7, 0.3)] {
            assert!(space.rgb(space.ycxcz(rgb)).abs_diff_eq(rgb, 1e-6), "{rgb}");
        }
        assert!(space.lab(Vec3::ONE).abs_diff_eq(Vec3::new(100.0, 0.0, 0.0), 1e-3));
    }

    #[test]
    fn differences_go_from_none_to_all() {
        let even = |rgb: [u8; 3]| rgb.repeat(12);
        let mean = |a, b| mean(&even(a), &even(b), 4, &Progress::default());
        assert_eq!(mean([9, 200, 77], [9, 200, 77]), Ok(0.0));
        let most = mean([0, 255, 0], [0, 0, 255]).unwrap();
        assert!((most - 1.0).abs() < 1e-6, "{most}");
        let black = mean([0; 3], [255; 3]).unwrap();
        assert!((0.9..1.0).contains(&black), "{black}");
    }

    #[test]
    fn it_stops_when_told_to() {
        let progress = Progress::default();
        progress.cancel();
        assert_eq!(mean(&[0; 12], &[1; 12], 2, &progress), Err(Interrupted));
    }
}
