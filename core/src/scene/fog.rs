//! The fog: its terms, what it does to light, and how that is computed.

use crate::airlight::{Airlight, refusal};
use crate::json::bounded;
use crate::json::document::parts;
use crate::json::limits::{self, COUNTS};
use crate::json::{Albedo, Rgb};
use crate::media::noise::Noise;
use crate::media::{
    Bands, Moment, MultipleScattering, Octave, Scattering, Term, Wind, scatterings,
};
use crate::phase::{Isotropic, Phase};
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

/// The fog of a scene. Its extinction is the sum of its terms.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Fog {
    /// Share of the extinguished light that is scattered, not absorbed (single-scattering albedo); for terms
    /// that have none of their own.
    pub albedo: Albedo,
    /// Into which directions the fog scatters; for terms that do not say it themselves.
    pub phase: Phase,
    /// Radiance of the veil that dense fog tends to [W/(m² sr)], besides the light of the lamps.
    #[schemars(extend("x-usual" = limits::USUAL_RADIANCE))]
    pub ambient: Rgb,
    /// How the light scattered into a view ray is computed.
    pub airlight: Airlight,
    /// How the fog between lamps and surfaces is accounted for.
    pub surface_lighting: SurfaceLighting,
    /// Fog that sun and sky came through where the fog has no end towards them [m].
    #[schemars(range(min = limits::DISTANCE.min, max = limits::DISTANCE.max))]
    pub light_path_m: f64,
    /// Light that was scattered more than once.
    pub multiple_scattering: MultipleScattering,
    /// What carries the fog along while time goes on.
    pub wind: Wind,
    /// Irregularity of blobs and particles.
    pub noise: Noise,
    /// What the fog is made of; extinctions add.
    #[serde(deserialize_with = "terms")]
    #[schemars(length(max = COUNTS.terms))]
    pub terms: Vec<Term>,
}

parts!(Fog { terms });

impl Default for Fog {
    fn default() -> Self {
        Self {
            albedo: Albedo::splat(1.0),
            phase: Phase::Isotropic(Isotropic {}),
            ambient: Rgb::splat(0.0),
            airlight: Airlight::Auto,
            surface_lighting: SurfaceLighting::Auto,
            light_path_m: 100.0,
            multiple_scattering: MultipleScattering::default(),
            wind: Wind::default(),
            noise: Noise::default(),
            terms: Vec::new(),
        }
    }
}

impl Fog {
    /// How each group of its terms scatters.
    pub fn scatterings(&self) -> Vec<Scattering> {
        scatterings(&self.terms, self.albedo, &self.phase)
    }

    /// The longest ray that it may be asked for [m].
    pub fn longest_m(&self) -> f64 {
        let terms = self.terms.iter().filter(|term| term.common().enabled);
        terms.map(Term::longest_m).fold(f64::INFINITY, f64::min)
    }

    /// The moment of a time; one and the same while nothing moves.
    pub fn moment(&self, time_s: f64) -> Moment {
        let mut terms = self.terms.iter().filter(|term| term.common().enabled);
        if self.wind.is_calm() && !terms.any(Term::changes) {
            return Moment::default();
        }
        Moment { time_s, wind: self.wind.clone(), ..Moment::default() }
    }

    /// The octaves in which light is scattered, from the fog itself on.
    pub fn octaves(&self) -> Vec<Octave> {
        [Octave::FIRST].into_iter().chain(self.multiple_scattering.each()).collect()
    }

    /// Numbers that an optical depth has in it: 1 if every extinction is grey, else 3.
    pub fn bands(&self) -> usize {
        Bands::count(&self.terms)
    }

    /// Why an estimator cannot take this fog, if so.
    pub fn refusal(&self, asked: Airlight) -> Option<String> {
        refusal(&self.terms, &self.scatterings(), asked)
    }
}

/// Reads the terms of a fog; what they take together is bounded.
fn terms<'de, D: Deserializer<'de>>(input: D) -> Result<Vec<Term>, D::Error> {
    bounded::list_in_all::<{ COUNTS.terms }, _, _>(input, COUNTS.blobs, Term::blobs)
}

/// How light reaches a surface through the fog.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SurfaceLighting {
    /// The best for this scene.
    #[default]
    Auto,
    /// Direct light as in clear air: the fog dims only what the eye sees.
    Clear,
    /// Direct light, attenuated by the fog on its way.
    Attenuated,
}
