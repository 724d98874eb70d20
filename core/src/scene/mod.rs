//! What a client sends: camera, surfaces, lights and fog.
//!
//! [`Scene`] is the JSON as it came; [`Scene::check`] is the only way to a [`CheckedScene`], and
//! everything that computes takes that.

pub(crate) mod bounded;
mod camera;
mod check;
mod diagnose;
mod fog;
mod form;
mod light;
pub mod limits;
mod problem;
mod strict;
mod surface;
pub mod tagged;
mod values;

pub use camera::{Camera, Orthographic, Perspective, Projection};
pub use check::CheckedScene;
pub use fog::{
    Airlight, Blob, Fog, Gaussians, HenyeyGreenstein, Homogeneous, Isotropic, Phase,
    SurfaceLighting, Term, Uniform, Vertical,
};
pub use light::{Light, Point};
pub use problem::{Checker, Code, Problem};
pub use surface::{Box, Heightfield, Material, Mesh, Plane, Shape, Sphere, Surface};
pub use values::{Albedo, Rgb, Vec3};

use limits::COUNTS;
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// A scene: everything that a picture depends on but its size. `{}` is a valid scene.
///
/// Lengths are metres, angles degrees, colours linear Rec. 709; the world is right-handed, +Y up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Scene {
    /// Where an editor finds the schema of this file; has no meaning here.
    #[serde(rename = "$schema", skip_serializing_if = "Option::is_none")]
    pub schema: Option<String>,
    /// Where the picture is taken from.
    pub camera: Camera,
    /// Radiance where a ray meets nothing [W/(m² sr)].
    #[schemars(extend("x-usual" = limits::USUAL_RADIANCE))]
    pub background: Rgb,
    /// What stands in the fog.
    #[serde(deserialize_with = "surface::list")]
    #[schemars(length(max = COUNTS.surfaces))]
    pub surfaces: Vec<Surface>,
    /// What shines.
    #[serde(deserialize_with = "bounded::list::<{ COUNTS.lights }, _, _>")]
    #[schemars(length(max = COUNTS.lights))]
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
            schema: None,
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
/// Nothing is noted on the way: only a text that cannot be read is walked a second time, to tell
/// everything that is wrong with it.
///
/// # Errors
/// That it is no JSON, or what is wrong with it, each with its JSON pointer.
pub fn read<T: DeserializeOwned + JsonSchema>(json: &[u8]) -> Result<T, ReadError> {
    let text = std::str::from_utf8(json).map_err(|error| {
        ReadError::NotJson(format!("no UTF-8 after {} bytes", error.valid_up_to()))
    })?;
    parse(text).map_err(|error| diagnose::errors::<T>(text, &error))
}

fn parse<T: DeserializeOwned>(text: &str) -> Result<T, serde_json::Error> {
    let mut input = serde_json::Deserializer::from_str(text);
    let value = T::deserialize(strict::Strict(&mut input))?;
    input.end().map(|()| value)
}

/// Why some JSON is not what it should be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReadError {
    /// It is not JSON at all.
    #[error("not JSON: {0}")]
    NotJson(String),
    /// It is JSON, but not of the documented form.
    #[error("{} problems", .0.len())]
    Invalid(Vec<Problem>),
}
