//! Waves: β(x) = c cos(k · x + φ) (Biri and Michelin 2002, section 3.2.1). Along a segment of the length L from a
//! to b the integral is L c cos(k · (a + b)/2 + φ) sin(w)/w, w = k · (b − a)/2, which is eq. 8 with its missing
//! factor (the derivative of the phase along the ray).

use super::member::member;
use crate::json::{Checker, limits};
use crate::media::Words;
use crate::media::toward::Toward;
use crate::num::Num;
use crate::vector::V3;
use glam::{DVec3, Vec4};
use std::f64::consts::{PI, TAU};

/// Components of a wave vector `[x, y, z]` [rad/m].
#[derive(
    Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(transparent)]
pub struct WaveVector(
    #[schemars(inner(range(min = limits::WAVE_VECTOR.min, max = limits::WAVE_VECTOR.max)))]
    pub  [f64; 3],
);

impl Toward for WaveVector {
    fn toward(&self, other: &Self, share: f64) -> Self {
        Self(self.0.toward(&other.0, share))
    }
}

member!(
    /// A wave: amplitude · cos(wave_vector · x + phase_rad).
    Cosine, CosineMorph, CosineParameters {
        /// The most that it adds or takes away [1/m].
        #[schemars(range(min = limits::SIGNED_EXTINCTION.min, max = limits::SIGNED_EXTINCTION.max))]
        amplitude: f64 = 0.1,
        /// Where it repeats, and how often: its length is 2π a wavelength [rad/m]. Zero makes a constant.
        wave_vector: WaveVector = WaveVector([0.0, 3.0, 0.0]),
        /// Its phase at the origin [rad].
        #[schemars(range(min = limits::PHASE.min, max = limits::PHASE.max))]
        phase_rad: f64 = 0.0,
    }
);

impl CosineParameters {
    /// Looks at all of its numbers; `at` names its members.
    pub fn check(&self, check: &mut Checker, at: &dyn Fn(&str) -> String) {
        check.number(self.amplitude, limits::SIGNED_EXTINCTION, || at("amplitude"));
        check.triple(self.wave_vector.0, limits::WAVE_VECTOR, || at("wave_vector"));
        check.number(self.phase_rad, limits::PHASE, || at("phase_rad"));
    }
}

/// A wave, seen from an origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wave {
    /// [1/m].
    amplitude: f64,
    /// Wave vector [turns/m].
    pub k: DVec3,
    /// Phase of the sine at the origin [turns]: that of the cosine and a quarter.
    phase: f64,
}

impl Wave {
    /// Of some parameters, times a factor.
    pub fn new(cosine: &CosineParameters, scale: f64) -> Self {
        let k = DVec3::from(cosine.wave_vector.0) / TAU;
        Self { amplitude: scale * cosine.amplitude, k, phase: cosine.phase_rad / TAU + 0.25 }
    }

    /// The same from another origin.
    pub fn seen_from(self, origin: DVec3) -> Self {
        let phase = self.phase + self.k.dot(origin);
        Self { phase: phase - phase.floor(), ..self }
    }

    /// The least and the most that it adds [1/m].
    pub fn bounds(&self) -> [f64; 2] {
        if self.k == DVec3::ZERO {
            return [self.amplitude * self.phase.sin_turns(); 2];
        }
        [-self.amplitude.abs(), self.amplitude.abs()]
    }

    /// At a point [1/m].
    #[inline(always)]
    pub fn at<N: Num>(&self, x: V3<N>) -> N {
        let k = V3::lit(x.x, self.k);
        (k.dot(x) + x.x.lit(self.phase)).sin_turns() * x.x.lit(self.amplitude)
    }

    /// Its mean between two points [1/m].
    #[inline(always)]
    pub fn mean<N: Num>(&self, a: V3<N>, b: V3<N>) -> N {
        /// Up to here sin(x)/x is its series to 1e-10 of itself.
        const SHORT: f64 = 0.02;
        let half = a.x.lit(0.5);
        let turns = V3::lit(half, self.k).dot(b - a);
        let w = turns * half.lit(PI);
        let is_short = w.abs().lt(half.lit(SHORT));
        let square = w.squared();
        let series = square
            .mul_add(square.mul_add(half.lit(1.0 / 120.0), half.lit(-1.0 / 6.0)), half.lit(1.0));
        let safe = N::select(is_short, half, w);
        let share = N::select(is_short, series, (turns * half).sin_turns() / safe);
        self.at((a + b).scale(half)) * share
    }

    /// As the shader reads it.
    pub fn words(&self) -> Words {
        let k = self.k.as_vec3();
        vec![
            k.extend(self.phase as f32),
            Vec4::new(self.amplitude as f32, 0.0, 0.0, 0.0),
            Vec4::ZERO,
        ]
    }
}
