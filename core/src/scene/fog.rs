//! The fog: its terms, what it does to light, and how that is computed.

use crate::airlight::Airlight;
use crate::json::bounded;
use crate::json::limits::{self, COUNTS};
use crate::json::{Albedo, Rgb};
use crate::media::Term;
use crate::phase::{Isotropic, Phase};
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

/// The fog of a scene. Its extinction is the sum of its terms.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Fog {
    /// Share of the extinguished light that is scattered, not absorbed (single-scattering albedo).
    pub albedo: Albedo,
    /// Into which directions the fog scatters.
    pub phase: Phase,
    /// Radiance of the veil that dense fog tends to [W/(m² sr)], besides the light of the lamps.
    #[schemars(extend("x-usual" = limits::USUAL_RADIANCE))]
    pub ambient: Rgb,
    /// How the light scattered into a view ray is computed.
    pub airlight: Airlight,
    /// How the fog between lamps and surfaces is accounted for.
    pub surface_lighting: SurfaceLighting,
    /// What the fog is made of; extinctions add.
    #[serde(deserialize_with = "terms")]
    #[schemars(length(max = COUNTS.terms))]
    pub terms: Vec<Term>,
}

impl Default for Fog {
    fn default() -> Self {
        Self {
            albedo: Albedo::splat(1.0),
            phase: Phase::Isotropic(Isotropic {}),
            ambient: Rgb::splat(0.0),
            airlight: Airlight::Auto,
            surface_lighting: SurfaceLighting::Auto,
            terms: Vec::new(),
        }
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
    /// Direct light, attenuated by the fog on its way.
    Attenuated,
}
