//! Fewer blobs far away (stochastic pruning: Cook, Halstead, Planck, Ryu 2007, as Macklin 2010 retells it). At z times the
//! distance from which on it counts, the share u = z^(−log_h 2) of the blobs stays, and each of them weighs 1/u, so
//! that all together weigh the same.
//!
//! Ours: h is 2, and where pruning begins follows from the error that is allowed. What stays is decided by numbers that
//! are a blob's own, and what is about to go fades first, so that nothing pops while the camera moves.

use super::Gaussian;
use crate::random::lattice;
use glam::DVec3;

/// Standard deviations that an error stays within.
const SURE: f64 = 3.0;
/// Share of the survivors that fade: from where a blob begins to go to where it has gone it is a quarter farther.
const FADING: f64 = 0.2;
/// Halvings of the logarithm of the distance at which pruning begins.
const HALVINGS: u32 = 12;
/// Of fewer blobs none is left out.
const FEW: usize = 64;

/// From where on blobs are pruned.
#[derive(Clone, Copy, Debug)]
pub struct Pruning {
    eye: DVec3,
    start_m: f64,
}

impl Pruning {
    /// Such that the mean optical depth of what is seen from the eye is off by no more than a share of it; `None` where
    /// that leaves none out.
    pub fn new<'a>(
        blobs: impl Iterator<Item = &'a Gaussian>,
        eye: DVec3,
        error: f64,
    ) -> Option<Self> {
        // Each by its distance and by what it adds to the mean: its depth times the part of the sight that it fills.
        let seen = |blob: &Gaussian| {
            let distance = eye.distance(blob.center).max(1.0 / blob.a);
            (distance, blob.half_depth() / (blob.a * distance).powi(2))
        };
        let seen: Vec<_> = blobs.map(seen).collect();
        if seen.len() < FEW {
            return None;
        }
        let whole: f64 = seen.iter().map(|(_, weight)| weight).sum();
        let off = |start: f64| {
            let variance = |(distance, weight): &(f64, f64)| {
                weight * weight * (1.0 / counted(limit(distance / start)) - 1.0)
            };
            SURE * seen.iter().map(variance).sum::<f64>().sqrt() / whole
        };
        let nearest = seen.iter().map(|(distance, _)| *distance).fold(f64::INFINITY, f64::min);
        let farthest = seen.iter().map(|(distance, _)| *distance).fold(0.0, f64::max);
        // A thousandth of the nearest leaves one of a thousand.
        let (mut low, mut high) = ((1e-3 * nearest).ln(), farthest.ln());
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if off(middle.exp()) > error { low = middle } else { high = middle }
        }
        let start_m = high.exp();
        (start_m < farthest).then_some(Self { eye, start_m })
    }

    /// What stays of some blobs.
    pub fn of(&self, all: &[Gaussian]) -> Vec<Gaussian> {
        let kept = |(i, blob): (usize, &Gaussian)| {
            let weight = self.weight(blob, lattice(i as i64, 0, 1));
            (weight > 0.0).then_some(Gaussian { c: blob.c * weight, ..*blob })
        };
        all.iter().enumerate().filter_map(kept).collect()
    }

    /// How much a blob counts, given its own number from 0 to 1.
    fn weight(&self, blob: &Gaussian, rank: f64) -> f64 {
        let limit = limit(self.eye.distance(blob.center) / self.start_m);
        let part = (limit - rank) / (FADING * limit);
        part.clamp(0.0, 1.0) / counted(limit)
    }
}

/// The number from which on blobs are gone at so many times the distance at which pruning begins: there the last one
/// begins to fade.
fn limit(times: f64) -> f64 {
    1.0 / (times.max(1.0) * (1.0 - FADING))
}

/// The mean of what all numbers count.
fn counted(limit: f64) -> f64 {
    let (whole, last) = (limit * (1.0 - FADING), limit.min(1.0));
    whole + ((limit - whole).powi(2) - (limit - last).powi(2)) / (2.0 * FADING * limit)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All numbers together weigh one at every distance, and a step of the camera changes little.
    #[test]
    fn survivors_weigh_as_much_as_all_and_fade() {
        let blob = Gaussian { center: DVec3::ZERO, a: 1.0, c: 1.0, is_slab: false };
        for distance in [0.5, 1.0, 1.01, 1.1, 1.5, 4.0, 50.0] {
            let weight = |distance: f64, rank: f64| {
                Pruning { eye: distance * DVec3::X, start_m: 1.0 }.weight(&blob, rank)
            };
            let ranks = (0..100_000).map(|i| (f64::from(i) + 0.5) / 1e5);
            let mean = ranks.clone().map(|rank| weight(distance, rank)).sum::<f64>() / 1e5;
            assert!((mean - 1.0).abs() < 1e-3, "{distance}: {mean}");
            let moved =
                ranks.map(|rank| (weight(distance * 1.001, rank) - weight(distance, rank)).abs());
            let most = moved.fold(0.0, f64::max) / distance.max(1.0);
            assert!(most < 0.02, "{distance}: {most}");
        }
    }
}
