//! A lamp without size that shines into a cone: I₀/d² times a weight of the direction (Macklin 2010).

use super::beam::{Beam, Crossed};
use super::{LampKind, LightKind, Shines, ToLight, Toward};
use crate::geometry::Origin;
use crate::json::{Checker, Code, Rgb, Vec3, limits};
use crate::num::Num;
use crate::vector::V3;
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A lamp without size that shines into a cone: full within the inner angle, none outside of the outer one, and a
/// smoothstep of the cosine between. Equal angles give a hard cone. Its light falls with the square of the distance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Spot {
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
    /// Where the middle of its light travels; any length but zero.
    pub direction: Vec3,
    /// Angle from the middle within which it is full [degrees].
    #[schemars(range(min = limits::CONE.min, max = limits::CONE.max))]
    pub inner_angle_deg: f64,
    /// Angle from the middle where it ends; at least the inner angle [degrees].
    #[schemars(range(min = limits::CONE.min, max = limits::CONE.max))]
    pub outer_angle_deg: f64,
    /// Radiant intensity within the inner angle, per channel [W/sr].
    #[schemars(extend("x-usual" = limits::USUAL_INTENSITY))]
    pub intensity: Rgb,
}

impl Default for Spot {
    fn default() -> Self {
        Self {
            id: None,
            enabled: true,
            shadows: true,
            position: Vec3([0.0, 5.0, 0.0]),
            direction: Vec3([0.0, -1.0, 0.0]),
            inner_angle_deg: 20.0,
            outer_angle_deg: 30.0,
            intensity: Rgb::splat(100.0),
        }
    }
}

impl LightKind for Spot {
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
        check.direction(self.direction, || at("direction"));
        check.number(self.inner_angle_deg, limits::CONE, || at("inner_angle_deg"));
        check.number(self.outer_angle_deg, limits::CONE, || at("outer_angle_deg"));
        if self.outer_angle_deg < self.inner_angle_deg {
            let inner = self.inner_angle_deg;
            let why = format!("must be at least inner_angle_deg, {inner}");
            check.refuse(Code::OutOfRange, || at("outer_angle_deg"), why);
        }
        check.triple(self.intensity.0, limits::INTENSITY, || at("intensity"));
    }
}

impl LampKind for Spot {
    type Place = Place;

    fn place(&self, _path_m: f64) -> Place {
        let axis = self.direction.vector().normalize_or(DVec3::NEG_Y);
        let beam = Beam::new(axis, self.inner_angle_deg, self.outer_angle_deg);
        Place { apex: self.position.vector(), beam }
    }

    fn strength(&self) -> DVec3 {
        self.intensity.vector()
    }
}

/// Where such a lamp is [m], and its cone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Where it is [m].
    pub apex: DVec3,
    /// Where its light goes.
    pub beam: Beam,
}

impl Shines for Place {
    fn seen_from(self, origin: DVec3) -> Self {
        Self { apex: self.apex - origin, ..self }
    }

    fn origin(self) -> Origin {
        Origin::At(self.apex)
    }

    #[inline(always)]
    fn beside<N: Num>(self, start: V3<N>, direction: V3<N>) -> ToLight<N> {
        ToLight::new(V3::lit(start.x, self.apex) - start, direction)
    }

    #[inline(always)]
    fn toward<N: Num>(self, point: V3<N>, floor: N) -> Toward<N> {
        let toward = Toward::new(V3::lit(floor, self.apex) - point, floor);
        toward.weighed(self.beam.weight(-toward.direction))
    }

    fn beam(self) -> Option<Beam> {
        Some(self.beam)
    }

    #[inline(always)]
    fn crossed<N: Num>(self, start: V3<N>, direction: V3<N>) -> Option<Crossed<N>> {
        Some(self.beam.beside(V3::lit(start.x, self.apex) - start, direction))
    }
}
