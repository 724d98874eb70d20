//! The sun: light that comes side by side from a direction, equally strong everywhere.
//!
//! It is a lamp as far away as the sun, of which only the direction is kept: 1/d² is the same everywhere, and what
//! it is multiplied by is chosen so that a surface that faces it gets its irradiance. So all that is known of a lamp
//! beside a ray holds for it too, to (length of the ray / distance of the sun)², 1e-12 for 100 km.

use super::{LampKind, LightKind, Shines, ToLight, Toward};
use crate::geometry::{Beyond, Origin};
use crate::json::{Checker, Rgb, Vec3, limits};
use crate::num::Num;
use crate::vector::V3;
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How far away the sun is [m].
pub const DISTANCE_M: f64 = 1.495_978_707e11;

/// Parallel light from far away. Fog that has no end towards it counts as far as the fog's `light_path_m`; slabs,
/// blobs, maps, and what thins out upwards as far as they reach.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Sun {
    /// Name of this light, unique among the lights.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1, max = limits::COUNTS.id_chars))]
    pub id: Option<String>,
    /// False turns it off.
    pub enabled: bool,
    /// Whether surfaces hide its light from others, and from fog.
    pub shadows: bool,
    /// Where its light travels; any length but zero.
    pub direction: Vec3,
    /// Power that a surface facing it gets per area and channel [W/m²].
    #[schemars(extend("x-usual" = limits::USUAL_IRRADIANCE))]
    pub irradiance: Rgb,
}

impl Default for Sun {
    fn default() -> Self {
        Self {
            id: None,
            enabled: true,
            shadows: true,
            direction: Vec3([0.3, -1.0, 0.2]),
            irradiance: Rgb([3.0, 3.0, 2.8]),
        }
    }
}

impl LightKind for Sun {
    fn id(&self) -> Option<&str> {
        self.id.as_deref()
    }

    fn enabled(&self) -> bool {
        self.enabled
    }

    fn shadows(&self) -> bool {
        self.shadows
    }

    fn check(&self, check: &mut Checker, at: &dyn Fn(&str) -> String) {
        check.direction(self.direction, || at("direction"));
        check.triple(self.irradiance.0, limits::INTENSITY, || at("irradiance"));
    }
}

impl LampKind for Sun {
    type Place = Place;

    fn place(&self, path_m: f64) -> Place {
        Place(Beyond { toward: -self.direction.vector().normalize_or(DVec3::NEG_Y), path_m })
    }

    fn strength(&self) -> DVec3 {
        self.irradiance.vector() * (DISTANCE_M * DISTANCE_M)
    }
}

/// Where its light comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place(pub Beyond);

impl Shines for Place {
    fn seen_from(self, _origin: DVec3) -> Self {
        self
    }

    fn origin(self) -> Origin {
        Origin::Beyond(self.0)
    }

    /// As beside a lamp whose distance is never less than the sun's, and whose light comes at one angle.
    #[inline(always)]
    fn beside<N: Num>(self, start: V3<N>, direction: V3<N>) -> ToLight<N> {
        let tilt = V3::lit(start.x, self.0.toward).dot(direction);
        ToLight { closest: start.x.lit(0.0), miss: start.x.lit(DISTANCE_M), tilt }
    }

    #[inline(always)]
    fn toward<N: Num>(self, _point: V3<N>, floor: N) -> Toward<N> {
        let distance = floor.lit(DISTANCE_M);
        Toward::along(V3::lit(floor, self.0.toward), distance.squared())
    }
}
