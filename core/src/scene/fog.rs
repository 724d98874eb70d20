//! The fog: its terms, what it does to light, and how that is computed.

use super::bounded;
use super::limits::{self, COUNTS};
use super::tagged::tagged;
use super::values::{Albedo, Rgb, Vec3};
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
    let blobs = |term: &Term| match term {
        Term::Gaussians(term) => term.blobs.len(),
        Term::Homogeneous(_) => 0,
    };
    bounded::list_in_all::<{ COUNTS.terms }, _, _>(input, COUNTS.blobs, blobs)
}

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

/// The estimator of light scattered into the view ray.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Airlight {
    /// The best for real time on this scene.
    #[default]
    Auto,
    /// No airlight: only the veil.
    None,
    /// Sun 2005: exact for homogeneous fog alone.
    Sun2005,
    /// Fogshop 2007: its published approximation for homogeneous fog and Gaussians.
    Fogshop2007,
    /// The integral itself by adaptive quadrature: slow, for comparison.
    Reference,
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

tagged!(
    /// One part of the fog.
    Term {
        /// The same extinction everywhere.
        Homogeneous = "homogeneous",
        /// A sum of Gaussian blobs.
        Gaussians = "gaussians",
    }
);

impl Term {
    /// The name given to it, if any.
    pub fn id(&self) -> Option<&str> {
        match self {
            Self::Homogeneous(term) => term.id.as_deref(),
            Self::Gaussians(term) => term.id.as_deref(),
        }
    }

    /// Whether it is part of the fog.
    pub fn enabled(&self) -> bool {
        match self {
            Self::Homogeneous(term) => term.enabled,
            Self::Gaussians(term) => term.enabled,
        }
    }
}

/// Fog that is the same everywhere. Give `extinction` or `visibility_m`, not both.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[schemars(extend("not" = {
    "required": ["extinction", "visibility_m"],
    "properties": { "extinction": { "type": "number" }, "visibility_m": { "type": "number" } },
}))]
pub struct Homogeneous {
    /// Name of this term, unique among the terms.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1, max = limits::COUNTS.id_chars))]
    pub id: Option<String>,
    /// False removes it from the fog.
    pub enabled: bool,
    /// Extinction β [1/m]; 0.02 when neither it nor the visibility is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = limits::EXTINCTION.min, max = limits::EXTINCTION.max))]
    #[schemars(extend("x-usual" = limits::USUAL_EXTINCTION))]
    pub extinction: Option<f64>,
    /// Meteorological visibility V [m]: extinction = −ln 0.05 / V.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = limits::VISIBILITY.min, max = limits::VISIBILITY.max))]
    #[schemars(extend("x-usual" = limits::USUAL_VISIBILITY))]
    #[schemars(extend("x-reciprocal-of" = ReciprocalOf::extinction()))]
    pub visibility_m: Option<f64>,
    /// How the extinction depends on height.
    pub vertical: Vertical,
}

impl Default for Homogeneous {
    fn default() -> Self {
        Self {
            id: None,
            enabled: true,
            extinction: None,
            visibility_m: None,
            vertical: Vertical::Uniform(Uniform {}),
        }
    }
}

impl Homogeneous {
    /// Extinction β [1/m] of this term.
    pub fn extinction_per_m(&self) -> f64 {
        let ReciprocalOf { product, default, .. } = ReciprocalOf::extinction();
        match (self.extinction, self.visibility_m) {
            (Some(extinction), _) => extinction,
            (None, Some(visibility_m)) => product / visibility_m,
            (None, None) => default,
        }
    }
}

/// Says of a number that it is another way to give a property beside it: the hint `x-reciprocal-of`
/// of the JSON schema. With it a client converts one into the other and need not know why they are
/// related.
#[derive(Clone, Copy, Debug, Serialize)]
struct ReciprocalOf {
    /// The property.
    property: &'static str,
    /// The number times that property.
    product: f64,
    /// What that property is when neither is given.
    default: f64,
}

impl ReciprocalOf {
    /// A black object at the meteorological visibility keeps 5 % of its contrast.
    fn extinction() -> Self {
        const CONTRAST_THRESHOLD: f64 = 0.05;
        Self { property: "extinction", product: -CONTRAST_THRESHOLD.ln(), default: 0.02 }
    }
}

tagged!(
    /// How an extinction depends on height.
    Vertical {
        /// Not at all.
        Uniform = "uniform",
    }
);

/// The same at every height.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Uniform {}

/// A sum of Gaussian blobs: β(x) = Σ extinction · exp(−|x − center|² / radius²).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Gaussians {
    /// Name of this term, unique among the terms.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1, max = limits::COUNTS.id_chars))]
    pub id: Option<String>,
    /// False removes it from the fog.
    pub enabled: bool,
    /// The blobs.
    #[serde(deserialize_with = "bounded::list::<{ COUNTS.blobs }, _, _>")]
    #[schemars(length(max = COUNTS.blobs), extend("x-items-in-all" = COUNTS.blobs))]
    pub blobs: Vec<Blob>,
}

impl Default for Gaussians {
    fn default() -> Self {
        Self { id: None, enabled: true, blobs: Vec::new() }
    }
}

/// One Gaussian blob of fog.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Blob {
    /// Where it is densest [m].
    pub center: Vec3,
    /// Distance from the centre at which the extinction has fallen to 1/e [m].
    #[schemars(range(min = limits::RADIUS.min, max = limits::RADIUS.max))]
    pub radius: f64,
    /// Extinction at the centre [1/m].
    #[schemars(range(min = limits::EXTINCTION.min, max = limits::EXTINCTION.max))]
    #[schemars(extend("x-usual" = limits::USUAL_EXTINCTION))]
    pub extinction: f64,
}

impl Default for Blob {
    fn default() -> Self {
        Self { center: Vec3::splat(0.0), radius: 1.0, extinction: 0.4 }
    }
}
