//! A lamp without size that shines the same in all directions: I₀/d² at the distance d.

use super::{LampKind, LightKind, Shines, ToLight, Toward};
use crate::geometry::Origin;
use crate::json::{Checker, Rgb, Vec3, limits};
use crate::num::Num;
use crate::vector::V3;
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

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
    /// Whether surfaces hide its light from others, and from fog.
    pub shadows: bool,
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
            shadows: true,
            position: Vec3([0.0, 3.0, 0.0]),
            intensity: Rgb::splat(100.0),
        }
    }
}

impl LightKind for Point {
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
        check.triple(self.position.0, limits::COORDINATE, || at("position"));
        check.triple(self.intensity.0, limits::INTENSITY, || at("intensity"));
    }
}

impl LampKind for Point {
    type Place = Place;

    fn place(&self, _path_m: f64) -> Place {
        Place(self.position.vector())
    }

    fn strength(&self) -> DVec3 {
        self.intensity.vector()
    }
}

/// Where such a lamp is [m].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place(pub DVec3);

impl Shines for Place {
    fn seen_from(self, origin: DVec3) -> Self {
        Self(self.0 - origin)
    }

    fn origin(self) -> Origin {
        Origin::At(self.0)
    }

    #[inline(always)]
    fn beside<N: Num>(self, start: V3<N>, direction: V3<N>) -> ToLight<N> {
        ToLight::new(V3::lit(start.x, self.0) - start, direction)
    }

    #[inline(always)]
    fn toward<N: Num>(self, point: V3<N>, floor: N) -> Toward<N> {
        Toward::new(V3::lit(floor, self.0) - point, floor)
    }
}
