//! How an extinction depends on height: everywhere the same, a slab, or falling off exponentially.
//!
//! The optical depth of a segment is its length times the mean of β between the heights of its ends,
//! whatever its slope: dT = β dy / sin θ. So the mean between two heights is all that any path needs, to
//! the eye or to a light. It is closed form: a slab is the overlap of two intervals, an exponential
//! ∫ e^(−k y) dy = (e^(−k a) − e^(−k b))/k.
//!
//! Heights are counted from where rays start: a nearly level ray crosses a boundary where a small
//! difference of heights says, which large ones would not have.

use crate::json::tagged::tagged;
use crate::json::{Checker, Code, limits};
use crate::num::Num;
use glam::Vec4;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

tagged!(
    /// How an extinction depends on height.
    Vertical {
        /// Not at all.
        Uniform = "uniform",
        /// A layer with a floor and a ceiling.
        Slab = "slab",
        /// Thinner and thinner above a height.
        Exponential = "exponential",
    }
);

/// The same at every height.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Uniform {}

/// Fog between two heights, and none elsewhere.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Slab {
    /// Where it begins [m].
    #[schemars(range(min = limits::COORDINATE.min, max = limits::COORDINATE.max))]
    pub min_m: f64,
    /// Where it ends, above `min_m` [m].
    #[schemars(range(min = limits::COORDINATE.min, max = limits::COORDINATE.max))]
    pub max_m: f64,
}

impl Default for Slab {
    fn default() -> Self {
        Self { min_m: 0.0, max_m: 2.0 }
    }
}

/// Fog that is the same up to a height and falls off above it: exp(−falloff · (y − base)).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Exponential {
    /// From here on upwards it falls off [m].
    #[schemars(range(min = limits::COORDINATE.min, max = limits::COORDINATE.max))]
    pub base_m: f64,
    /// By how much: 1/e a metre at 1, and not at all at 0 [1/m].
    #[schemars(range(min = limits::EXTINCTION.min, max = limits::EXTINCTION.max))]
    #[schemars(extend("x-usual" = limits::USUAL_EXTINCTION))]
    pub falloff_per_m: f64,
}

impl Default for Exponential {
    fn default() -> Self {
        Self { base_m: 0.0, falloff_per_m: 0.3 }
    }
}

impl Vertical {
    /// Looks at its numbers; `at` names its members.
    pub fn check(&self, check: &mut Checker, at: impl Fn(&str) -> String) {
        match self {
            Self::Uniform(_) => {}
            Self::Slab(Slab { min_m, max_m }) => {
                check.number(*min_m, limits::COORDINATE, || at("min_m"));
                check.number(*max_m, limits::COORDINATE, || at("max_m"));
                if min_m >= max_m {
                    check.refuse(Code::Conflict, || at("max_m"), "max_m must lie above min_m");
                }
            }
            Self::Exponential(Exponential { base_m, falloff_per_m }) => {
                check.number(*base_m, limits::COORDINATE, || at("base_m"));
                check.number(*falloff_per_m, limits::EXTINCTION, || at("falloff_per_m"));
            }
        }
    }

    /// What it says.
    pub fn profile(&self) -> Profile {
        match self {
            Self::Slab(Slab { min_m, max_m }) => Profile::Slab { min: *min_m, max: *max_m },
            Self::Exponential(Exponential { base_m, falloff_per_m }) if *falloff_per_m > 0.0 => {
                Profile::Exponential { base: *base_m, falloff: *falloff_per_m }
            }
            Self::Uniform(_) | Self::Exponential(_) => Profile::Uniform,
        }
    }
}

/// A share of an extinction, by height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Profile {
    /// 1.
    Uniform,
    /// 1 between two heights, 0 elsewhere.
    Slab {
        /// The lower height [m].
        min: f64,
        /// The upper height [m].
        max: f64,
    },
    /// 1 up to a height, falling off above it.
    Exponential {
        /// The height [m].
        base: f64,
        /// Above 0 [1/m].
        falloff: f64,
    },
}

impl Profile {
    /// The same, heights counted from another one.
    pub fn seen_from(self, height: f64) -> Self {
        match self {
            Self::Uniform => Self::Uniform,
            Self::Slab { min, max } => Self::Slab { min: min - height, max: max - height },
            Self::Exponential { base, falloff } => {
                Self::Exponential { base: base - height, falloff }
            }
        }
    }

    /// Heights at which it jumps or kinks.
    pub fn edges(self) -> impl Iterator<Item = f64> {
        let edges = match self {
            Self::Uniform => [None, None],
            Self::Slab { min, max } => [Some(min), Some(max)],
            Self::Exponential { base, .. } => [Some(base), None],
        };
        edges.into_iter().flatten()
    }

    /// Ray parameters between which there is any of it on a ray from height 0 that gains `climb` a metre [m].
    pub fn span(self, climb: f64, length_m: f64) -> Option<(f64, f64)> {
        let Self::Slab { min, max } = self else { return Some((0.0, length_m)) };
        if climb == 0.0 {
            return (min <= 0.0 && 0.0 <= max).then_some((0.0, length_m));
        }
        let (a, b) = (min / climb, max / climb);
        let (from, to) = (a.min(b).max(0.0), a.max(b).min(length_m));
        (from < to).then_some((from, to))
    }

    /// The share at a height.
    #[inline(always)]
    pub fn at<N: Num>(self, y: N) -> N {
        let (zero, one) = (y.lit(0.0), y.lit(1.0));
        match self {
            Self::Uniform => one,
            Self::Slab { min, max } => {
                let share = N::select(y.lt(y.lit(min)), zero, one);
                N::select(y.lit(max).lt(y), zero, share)
            }
            Self::Exponential { base, falloff } => {
                (-((y - y.lit(base)).max(zero) * y.lit(falloff))).exp()
            }
        }
    }

    /// The mean share between two heights.
    #[inline(always)]
    pub fn mean<N: Num>(self, a: N, b: N) -> N {
        let (zero, low, high) = (a.lit(0.0), a.min(b), a.max(b));
        let sum = match self {
            Self::Uniform => return a.lit(1.0),
            Self::Slab { min, max } => (high.min(a.lit(max)) - low.max(a.lit(min))).max(zero),
            Self::Exponential { base, falloff } => {
                let turn = high.min(a.lit(base)).max(low);
                let above = high - turn;
                let begins = (-((turn - a.lit(base)).max(zero) * a.lit(falloff))).exp();
                (above * begins).mul_add(falling_mean(above * a.lit(falloff)), turn - low)
            }
        };
        N::select(low.lt(high), sum / (high - low), self.at(a))
    }

    /// How far a way that climbs so a metre goes from a height until there is nothing left of it [m]; none if it
    /// has no end.
    #[inline(always)]
    pub fn ends<N: Num>(self, y: N, climb: f64) -> Option<N> {
        /// e^(−30) is 1e-13.
        const GONE: f64 = 30.0;
        let zero = y.lit(0.0);
        let until = |height: f64| (y.lit(height) - y).max(zero);
        match self {
            Self::Slab { max, .. } if climb > 0.0 => Some(until(max) * y.lit(1.0 / climb)),
            Self::Slab { min, .. } if climb < 0.0 => {
                Some((y - y.lit(min)).max(zero) * y.lit(-1.0 / climb))
            }
            Self::Exponential { base, falloff } if climb > 0.0 => {
                Some((until(base) + y.lit(GONE / falloff)) * y.lit(1.0 / climb))
            }
            _ => None,
        }
    }

    /// ∫ of the share over a way that climbs so a metre, from a height to where it ends, or as far as what has no
    /// end counts [m].
    #[inline(always)]
    pub fn beyond<N: Num>(self, y: N, climb: f64, path_m: f64) -> N {
        let length = self.ends(y, climb).unwrap_or(y.lit(path_m));
        self.mean(y, length.mul_add(y.lit(climb), y)) * length
    }

    /// As the shader reads it, with an extinction [1/m]: that, the lower and the upper end, the falloff.
    pub fn row(self, extinction: f64) -> Vec4 {
        /// Higher than anything: what has no end there.
        const FAR: f32 = 3e38;
        let beta = extinction as f32;
        match self {
            Self::Uniform => Vec4::new(beta, -FAR, FAR, 0.0),
            Self::Slab { min, max } => Vec4::new(beta, min as f32, max as f32, 0.0),
            Self::Exponential { base, falloff } => {
                Vec4::new(beta, base as f32, FAR, falloff as f32)
            }
        }
    }
}

/// (1 − e^(−x))/x: the mean of e^(−x) from 0 on.
#[inline(always)]
fn falling_mean<N: Num>(x: N) -> N {
    /// Up to here the series is exact to 3e-12, and beyond the difference keeps its digits.
    const SMALL: f64 = 0.05;
    let one = x.lit(1.0);
    let series = x.mul_add(x.lit(-1.0 / 720.0), x.lit(1.0 / 120.0));
    let series = x.mul_add(series, x.lit(-1.0 / 24.0));
    let series = x.mul_add(series, x.lit(1.0 / 6.0));
    let series = x.mul_add(x.mul_add(series, x.lit(-0.5)), one);
    let is_small = x.lt(x.lit(SMALL));
    let safe = x.max(x.lit(SMALL));
    N::select(is_small, series, (one - (-safe).exp()) / safe)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::adaptive;

    const PROFILES: [Profile; 4] = [
        Profile::Uniform,
        Profile::Slab { min: -1.0, max: 2.5 },
        Profile::Exponential { base: 0.5, falloff: 0.7 },
        Profile::Exponential { base: -2.0, falloff: 1e-4 },
    ];

    /// The mean is the integral of the share, whichever end is higher, and the share itself where both
    /// ends are one.
    #[test]
    fn the_mean_is_that_of_the_shares() {
        for profile in PROFILES {
            for (a, b) in [(-3.0, 4.0), (1.0, -1.5), (3.0, 9.0), (-9.0, -4.0), (0.4, 0.6)] {
                let mut panels: Vec<f64> = profile.edges().collect();
                panels.extend([a, b]);
                panels.retain(|y| (f64::min(a, b)..=f64::max(a, b)).contains(y));
                panels.sort_by(f64::total_cmp);
                let sum = adaptive(&panels, 1e-12, |y| profile.at(y));
                let mean = sum / f64::abs(b - a);
                let (there, back) = (profile.mean(a, b), profile.mean(b, a));
                assert!((there - mean).abs() < 1e-10, "{profile:?} {a} {b}: {there} {mean}");
                assert_eq!(there, back);
            }
            assert_eq!(profile.mean(0.7, 0.7), profile.at(0.7));
        }
    }
}
