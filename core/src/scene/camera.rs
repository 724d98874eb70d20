//! Where the picture is taken from.

use crate::json::Vec3;
use crate::json::limits;
use crate::json::tagged::tagged;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The eye: it looks from `position` to `target`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Camera {
    /// Where the eye is [m].
    pub position: Vec3,
    /// The point in the middle of the picture [m]; differs from `position`.
    pub target: Vec3,
    /// Which way is up in the picture; not along the view.
    #[schemars(extend("not" = { "const": [0, 0, 0] }))]
    pub up: Vec3,
    /// How space is laid onto the picture.
    pub projection: Projection,
}

impl Default for Camera {
    fn default() -> Self {
        Self {
            position: Vec3([0.0, 1.7, 8.0]),
            target: Vec3([0.0, 1.0, 0.0]),
            up: Vec3([0.0, 1.0, 0.0]),
            projection: Projection::Perspective(Perspective::default()),
        }
    }
}

tagged!(
    /// How space is laid onto the picture.
    Projection {
        /// Far things look smaller.
        Perspective = "perspective",
        /// All rays are parallel: far things keep their size.
        Orthographic = "orthographic",
    }
);

/// A pinhole camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Perspective {
    /// Angle between the lower and the upper edge of the picture [degrees].
    #[schemars(range(min = limits::FIELD_OF_VIEW.min, max = limits::FIELD_OF_VIEW.max))]
    pub vertical_fov_deg: f64,
}

impl Default for Perspective {
    fn default() -> Self {
        Self { vertical_fov_deg: 45.0 }
    }
}

/// A camera without perspective.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Orthographic {
    /// Height of the picture in the world [m].
    #[schemars(range(min = limits::RADIUS.min, max = limits::RADIUS.max))]
    pub height_m: f64,
}

impl Default for Orthographic {
    fn default() -> Self {
        Self { height_m: 10.0 }
    }
}
