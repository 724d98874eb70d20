//! What a client sends: camera, surfaces, lights and fog.
//!
//! [`Scene`] is the JSON as it came; [`Scene::check`] is the only way to a [`CheckedScene`], and
//! everything that computes takes that.

pub(crate) mod bounded;
mod camera;
mod check;
mod fog;
mod light;
pub mod limits;
mod strict;
mod surface;
pub mod tagged;
mod values;

pub use camera::{Camera, Orthographic, Perspective, Projection};
pub use check::{CheckedScene, Checker, Problem};
pub use fog::{
    Airlight, Blob, Fog, Gaussians, HenyeyGreenstein, Homogeneous, Isotropic, Phase,
    SurfaceLighting, Term, Uniform, Vertical,
};
pub use light::{Light, Point};
pub use surface::{Box, Heightfield, Material, Mesh, Plane, Shape, Sphere, Surface};
pub use values::{Albedo, Rgb, Vec3};

use limits::COUNTS;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A scene: everything that a picture depends on but its size. `{}` is a valid scene.
///
/// Lengths are metres, angles degrees, colours linear Rec. 709; the world is right-handed, +Y up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Scene {
    /// Where the picture is taken from.
    pub camera: Camera,
    /// Radiance where a ray meets nothing [W/(m² sr)].
    #[schemars(extend("x-usual" = limits::USUAL_RADIANCE))]
    pub background: Rgb,
    /// What stands in the fog.
    #[serde(deserialize_with = "bounded::list::<{ COUNTS.surfaces }, _, _>")]
    pub surfaces: Vec<Surface>,
    /// What shines.
    #[serde(deserialize_with = "bounded::list::<{ COUNTS.lights }, _, _>")]
    pub lights: Vec<Light>,
    /// The fog.
    pub fog: Fog,
    /// Time of the picture [s].
    #[schemars(range(min = limits::TIME.min, max = limits::TIME.max))]
    pub time_s: f64,
    /// Where a ray that meets nothing ends [m]; keeps every optical depth finite.
    #[schemars(range(min = limits::FAR.min, max = limits::FAR.max))]
    pub far_m: f64,
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            camera: Camera::default(),
            background: Rgb::splat(0.0),
            surfaces: Vec::new(),
            lights: Vec::new(),
            fog: Fog::default(),
            time_s: 0.0,
            far_m: 10_000.0,
        }
    }
}

/// Reads JSON into any documented type.
///
/// # Errors
/// A [`ReadError`] with the JSON pointer of the offending place.
pub fn read<'a, T: Deserialize<'a>>(json: &'a [u8]) -> Result<T, ReadError> {
    let mut input = serde_json::Deserializer::from_slice(json);
    let strict = strict::Strict(&mut input);
    let value = serde_path_to_error::deserialize(strict).map_err(ReadError::from)?;
    input.end().map_err(|error| ReadError::NotJson(error.to_string()))?;
    Ok(value)
}

/// Why some JSON is not what it should be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReadError {
    /// It is not JSON at all.
    #[error("not JSON: {0}")]
    NotJson(String),
    /// It is JSON, but not of the documented form.
    #[error("{}: {}", .0.pointer, .0.detail)]
    Invalid(Problem),
}

impl From<serde_path_to_error::Error<serde_json::Error>> for ReadError {
    fn from(error: serde_path_to_error::Error<serde_json::Error>) -> Self {
        let text = error.inner().to_string();
        let out_of_range = text.starts_with("number out of range");
        if !error.inner().is_data() && !out_of_range {
            return Self::NotJson(text);
        }
        let (below, detail) = tagged::split_error(&text);
        let pointer = tagged::pointer_of(error.path()) + &below;
        Self::Invalid(Problem { pointer, detail })
    }
}
