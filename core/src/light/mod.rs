//! What shines.

use crate::json::limits;
use crate::json::tagged::tagged;
use crate::json::{Rgb, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

tagged!(
    /// A source of light.
    Light {
        /// A lamp that shines the same in all directions.
        Point = "point",
    }
);

impl Light {
    /// The name given to it, if any.
    pub fn id(&self) -> Option<&str> {
        match self {
            Self::Point(light) => light.id.as_deref(),
        }
    }

    /// Whether it shines.
    pub fn enabled(&self) -> bool {
        match self {
            Self::Point(light) => light.enabled,
        }
    }
}

/// A lamp without size that shines the same in all directions; its light falls with the square of
/// the distance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Point {
    /// Name of this light, unique among the lights.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1, max = limits::COUNTS.id_chars))]
    pub id: Option<String>,
    /// False turns it off.
    pub enabled: bool,
    /// Where it is [m].
    pub position: Vec3,
    /// Radiant intensity per channel [W/sr].
    #[schemars(extend("x-usual" = limits::USUAL_INTENSITY))]
    pub intensity: Rgb,
}

impl Default for Point {
    fn default() -> Self {
        Self {
            id: None,
            enabled: true,
            position: Vec3([0.0, 3.0, 0.0]),
            intensity: Rgb::splat(100.0),
        }
    }
}
