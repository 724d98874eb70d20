//! The sky as a light: it shines from all around, and stands behind everything.

use super::LightKind;
use crate::json::{Checker, limits};
use crate::sky::Radiance;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A sky around everything. Rays that meet nothing see it through the fog. Fog that has no end towards it counts as far
/// as the fog's `light_path_m`; slabs, blobs, maps, and what thins out upwards as far as they reach. Surfaces do not
/// hide it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Environment {
    /// Name of this light, unique among the lights.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1, max = limits::COUNTS.id_chars))]
    pub id: Option<String>,
    /// False turns it off.
    pub enabled: bool,
    /// How bright it is, by direction.
    pub radiance: Radiance,
}

impl Default for Environment {
    fn default() -> Self {
        Self { id: None, enabled: true, radiance: Radiance::default() }
    }
}

impl LightKind for Environment {
    fn id(&self) -> Option<&str> {
        self.id.as_deref()
    }

    fn enabled(&self) -> bool {
        self.enabled
    }

    fn shadows(&self) -> bool {
        false
    }

    fn check(&self, check: &mut Checker, at: &dyn Fn(&str) -> String) {
        self.radiance.check(check, &|name| at(&format!("radiance/{name}")));
    }
}
