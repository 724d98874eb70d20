//! `GET /v1/limits`: every bound that a request must respect.

use crate::answer;
use crate::app::App;
use crate::extract::BODY_BYTES;
use crate::openapi::Operation;
use crate::routes::probe::RAY_LIGHTS;
use axum::extract::State;
use axum::response::Response;
use fogbank_core::scene::limits::{self, COUNTS, Counts, Range};
use schemars::{JsonSchema, SchemaGenerator};
use serde::Serialize;

/// Every bound that a request must respect.
#[derive(Serialize, JsonSchema)]
struct Limits {
    /// Bytes of a request's body.
    body_bytes: usize,
    /// Requests that may wait while one is rendered, short and long ones each; one more is refused
    /// with 503, and one client may hold all places but one.
    queue: usize,
    /// Time for an answer, waiting included [s].
    deadline_s: f64,
    /// The same for `reference`, as a scene's airlight or a side of a comparison [s].
    reference_deadline_s: f64,
    /// Rays times lights of a probe.
    ray_lights: usize,
    /// How many of each thing there may be.
    counts: Counts,
    /// Which numbers are accepted.
    ranges: Ranges,
}

/// Accepted numbers, both ends included.
#[derive(Serialize, JsonSchema)]
struct Ranges {
    /// World coordinates and components of directions [m].
    coordinate: Range,
    /// Distances that may be zero [m].
    distance: Range,
    /// `far_m` [m].
    far: Range,
    /// Radii, and sizes that must not vanish [m].
    radius: Range,
    /// Extinction [1/m].
    extinction: Range,
    /// Meteorological visibility [m].
    visibility: Range,
    /// Radiant intensity [W/sr], irradiance [W/m²] and radiance [W/(m² sr)].
    intensity: Range,
    /// Albedos.
    fraction: Range,
    /// Mean cosine g of a phase function.
    anisotropy: Range,
    /// Exponent of the Phong lobe.
    shininess: Range,
    /// Vertical field of view [degrees].
    field_of_view: Range,
    /// Extinction that a member of a family adds or takes away [1/m].
    signed_extinction: Range,
    /// Factors of a sky's spherical harmonics [W/(m² sr)].
    harmonic: Range,
    /// Components of a wave vector [rad/m].
    wave_vector: Range,
    /// Phases of waves [rad].
    phase: Range,
    /// What an equipotential is divided by at its object.
    divisor: Range,
    /// By how much that grows with the square of the distance [1/m²].
    divisor_growth: Range,
    /// Powers of a monomial, together.
    power: Range,
    /// Relative error that pruning may leave in the mean optical depth.
    lod_error: Range,
    /// Transmittance below which a ray ends.
    far_cut: Range,
    /// Fraction of a picture that fog is computed for.
    fog_scale: Range,
    /// Sides of a map's cells, and periods of noise [m].
    cell: Range,
    /// By how much noise shifts a blob, in its radii.
    noise_strength: Range,
    /// Particles born a second [Hz].
    rate: Range,
    /// Angles by which a direction is turned [degrees].
    spread: Range,
    /// Half angles of a cone of light [degrees].
    cone: Range,
    /// Octaves of light that was scattered several times.
    octaves: Range,
    /// Extinction of an octave as a share of that before.
    thinning: Range,
    /// Growth of a radius as a share of itself.
    growth: Range,
    /// Lifetimes, and times in which something comes back to where it was [s].
    period: Range,
    /// Components of velocities [m/s] and accelerations [m/s²].
    velocity: Range,
    /// Scene time [s].
    time: Range,
    /// Exposure [stops].
    exposure: Range,
    /// Distance of a brush's dabs, in its radii.
    spacing: Range,
    /// Speeds of particles [m/s].
    speed: Range,
    /// How fast particles spread [m²/s].
    diffusion: Range,
    /// Width of a picture as a share of its height.
    aspect: Range,
}

const RANGES: Ranges = Ranges {
    coordinate: limits::COORDINATE,
    distance: limits::DISTANCE,
    far: limits::FAR,
    radius: limits::RADIUS,
    extinction: limits::EXTINCTION,
    visibility: limits::VISIBILITY,
    intensity: limits::INTENSITY,
    fraction: limits::FRACTION,
    anisotropy: limits::ANISOTROPY,
    shininess: limits::SHININESS,
    field_of_view: limits::FIELD_OF_VIEW,
    signed_extinction: limits::SIGNED_EXTINCTION,
    harmonic: limits::HARMONIC,
    wave_vector: limits::WAVE_VECTOR,
    phase: limits::PHASE,
    divisor: limits::DIVISOR,
    divisor_growth: limits::DIVISOR_GROWTH,
    power: limits::POWER,
    lod_error: limits::LOD_ERROR,
    far_cut: limits::FAR_CUT,
    fog_scale: limits::FOG_SCALE,
    cell: limits::CELL,
    noise_strength: limits::NOISE_STRENGTH,
    rate: limits::RATE,
    spread: limits::SPREAD,
    cone: limits::CONE,
    octaves: limits::OCTAVES,
    thinning: limits::THINNING,
    growth: limits::GROWTH,
    period: limits::PERIOD,
    velocity: limits::VELOCITY,
    time: limits::TIME,
    exposure: limits::EXPOSURE,
    spacing: limits::SPACING,
    speed: limits::SPEED,
    diffusion: limits::DIFFUSION,
    aspect: limits::ASPECT,
};

/// The bounds of this server.
pub async fn list(State(app): State<App>) -> Response {
    answer::json(&Limits {
        body_bytes: BODY_BYTES,
        queue: app.options.queue,
        deadline_s: app.options.deadline_s,
        reference_deadline_s: app.options.reference_deadline_s,
        ray_lights: RAY_LIGHTS,
        counts: COUNTS,
        ranges: RANGES,
    })
}

/// Its documentation.
pub fn operation(schemas: &mut SchemaGenerator) -> Operation {
    let summary = "Every bound that a request must respect.";
    Operation::get("get_limits", "service", summary).json::<Limits>(schemas)
}
