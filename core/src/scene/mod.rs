//! What a client sends: camera, surfaces, lights and fog.
//!
//! [`Scene`] is the JSON as it came; [`Scene::check`] is the only way to a [`CheckedScene`], and
//! everything that computes takes that.

mod camera;
mod check;
mod fog;
#[cfg(test)]
mod reading;
mod surface;

pub use crate::airlight::Airlight;
pub use crate::json::{
    Albedo, Checker, Code, Problem, ReadError, Rgb, Spectrum, Vec3, limits, read, tagged,
};
pub use crate::light::{Environment, Light, Point};
pub use crate::media::gaussians::{Blob, BlobFrame, Gaussians};
pub use crate::media::homogeneous::Homogeneous;
pub use crate::media::vertical::{Exponential, Slab, Uniform, Vertical};
pub use crate::media::{Moment, MultipleScattering, Octave, Term, Velocity, Wind, WindKey};
pub use crate::phase::{HenyeyGreenstein, Isotropic, Phase};
pub use crate::sky::Radiance;
pub use camera::{Camera, Orthographic, Perspective, Projection};
pub use check::{CheckedScene, Lit};
pub use fog::{Fog, SurfaceLighting};
pub use surface::{Box, Heightfield, Material, Mesh, Plane, Shape, Sphere, Surface};

use crate::json::bounded;
use crate::json::document::parts;
use limits::COUNTS;
use schemars::JsonSchema;
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

parts!(Scene { surfaces, lights, fog });

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
