//! The numbers along single rays, in f64: L = e^(−T) L_p + Σ L_a + L_fog (1 − e^(−T)).

use crate::airlight::fogshop2007::{Eye, LightSide, depths_to_centers};
use crate::airlight::{
    Estimator, Method, fogshop2007, least_distance, mapped, march, reference, sun2005,
};
use crate::geometry::{self, Geometry};
use crate::media::{Field, toward};
use crate::phase::Phase;
use crate::request::ProbeRay;
use crate::scene::{CheckedScene, Projection, Rgb, Vec3};
use crate::surface::attenuated;
use glam::DVec3;
use schemars::JsonSchema;
use serde::Serialize;

/// What a probe finds along one ray.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct RayAnswer {
    /// ∫ β along the ray.
    pub optical_depth: f64,
    /// exp(−optical depth).
    pub transmittance: f64,
    /// Light of all lamps scattered into the ray [W/(m² sr)].
    pub airlight: Rgb,
    /// The same lamp by lamp, in scene order.
    pub airlight_by_light: Vec<Rgb>,
    /// The veil: ambient · (1 − transmittance).
    pub ambient: Rgb,
    /// surface · transmittance + airlight + ambient; `background` stands for the surface where
    /// nothing is hit.
    pub radiance: Rgb,
    /// The surface at the end of the ray, or null.
    pub hit: Option<Hit>,
}

/// A surface at the end of a ray.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Hit {
    /// Distance from the origin [m].
    pub distance_m: f64,
    /// The point [m].
    pub point: Vec3,
    /// Unit normal, towards the origin.
    pub normal: Vec3,
    /// Its id, or its place in the list of surfaces.
    pub surface: SurfaceName,
    /// What it sends towards the origin [W/(m² sr)].
    pub surface_radiance: Rgb,
}

/// Names a surface.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum SurfaceName {
    /// By the id that the scene gives it.
    Id(String),
    /// By its place in the list.
    Index(usize),
}

/// Evaluates rays of one scene, one after the other. What rays from the same origin share is kept.
pub struct Prober<'a> {
    scene: &'a CheckedScene,
    geometry: &'a Geometry,
    field: &'a Field,
    method: Method,
    shared: Option<(Eye, Vec<LightSide>)>,
}

impl<'a> Prober<'a> {
    /// For a scene with its geometry and field.
    pub fn new(scene: &'a CheckedScene, geometry: &'a Geometry, field: &'a Field) -> Self {
        let method = Method::new(Estimator::Scene(scene.fog.airlight), &scene.fog, field);
        Self { scene, geometry, field, method, shared: None }
    }

    /// Everything along one ray.
    pub fn answer(&mut self, ray: &ProbeRay) -> RayAnswer {
        let ProbeRay { origin, direction, max_distance_m } = *ray;
        let limit = max_distance_m.unwrap_or(self.scene.far_m);
        let hit = self.geometry.first_hit(origin, direction, limit);
        let length = hit.map_or(limit, |hit| hit.distance);
        let optical_depth = self.field.optical_depth(origin, direction, length);
        let transmittance = (-optical_depth).exp();
        let airlight_by_light = self.airlight_by_light(origin, direction, length);
        let airlight = airlight_by_light.iter().sum::<DVec3>();
        let ambient = self.scene.fog.ambient.vector() * (0.0 - (-optical_depth).exp_m1());
        let (surface, hit) = match hit {
            None => (self.scene.background.vector(), None),
            Some(hit) => {
                let radiance = self.surface_radiance(&hit, origin, direction);
                (radiance, Some(self.describe(&hit, origin, direction, radiance)))
            }
        };
        RayAnswer {
            optical_depth,
            transmittance,
            airlight: rgb(airlight),
            airlight_by_light: airlight_by_light.into_iter().map(rgb).collect(),
            ambient: rgb(ambient),
            radiance: rgb(surface * transmittance + airlight + ambient),
            hit,
        }
    }

    fn airlight_by_light(&mut self, origin: DVec3, direction: DVec3, length: f64) -> Vec<DVec3> {
        if self.method == Method::Fogshop2007 {
            self.share(origin, direction);
        }
        let phase = Phase::from(&self.scene.fog.phase);
        let mut by_light = vec![DVec3::ZERO; self.scene.lights.len()];
        for (place, (i, light)) in self.scene.lights().enumerate() {
            let at = light.position.vector();
            let unit = match self.method {
                Method::None => 0.0,
                Method::Sun2005 => {
                    let beta = self.field.homogeneous.beta;
                    sun2005::airlight(beta, (at - origin).into(), direction.into(), length)
                }
                Method::Fogshop2007 => self.shared.as_ref().map_or(0.0, |(_, sides)| {
                    let side = &sides[place];
                    fogshop2007::airlight(self.field, side, at, origin, direction, length)
                }),
                Method::Mapped => {
                    mapped::airlight(self.field, phase, at, origin, direction, length)
                }
                Method::Reference => {
                    reference::airlight(self.field, phase, at, origin, direction, length)
                }
                Method::March(steps) => {
                    march::airlight(self.field, phase, at, origin, direction, length, steps)
                }
            };
            by_light[i] = unit * light.intensity.vector() * self.scene.fog.albedo.vector();
        }
        by_light
    }

    /// Prepares the published method for an eye, unless the last ray had the same.
    fn share(&mut self, origin: DVec3, direction: DVec3) {
        let eye = match self.scene.camera.projection {
            Projection::Perspective(_) => Eye::Point(origin),
            Projection::Orthographic(_) => Eye::Plane(origin, direction),
        };
        if self.shared.as_ref().is_some_and(|(shared, _)| shared.is_same(&eye)) {
            return;
        }
        let to_eye = depths_to_centers(self.field, |center| eye.facing(center));
        let side = |light: DVec3| {
            let to_light = depths_to_centers(self.field, |_| light);
            LightSide::new(self.field, eye, light, &to_eye, &to_light)
        };
        let sides = self.scene.lights().map(|(_, light)| side(light.position.vector()));
        self.shared = Some((eye, sides.collect()));
    }

    fn surface_radiance(&self, hit: &geometry::Hit, origin: DVec3, direction: DVec3) -> DVec3 {
        let point = origin + hit.distance * direction;
        let material = &self.geometry.materials[hit.surface as usize];
        let mut radiance = material.emission.vector();
        for (_, light) in self.scene.lights() {
            let to_light = light.position.vector() - point;
            let reflection = attenuated::reflection(
                hit.normal.into(),
                direction.into(),
                to_light.into(),
                material.shininess,
                least_distance(hit.distance),
            );
            let (toward_point, distance) = toward(light.position.vector(), point);
            let depth = self.field.optical_depth(light.position.vector(), toward_point, distance);
            let reflected = material.diffuse.vector() * reflection.diffuse
                + material.specular.vector() * reflection.specular;
            radiance += (-depth).exp() * light.intensity.vector() * reflected;
        }
        radiance
    }

    fn describe(
        &self,
        hit: &geometry::Hit,
        origin: DVec3,
        direction: DVec3,
        radiance: DVec3,
    ) -> Hit {
        let place = hit.surface as usize;
        let id = self.scene.surfaces[place].id.clone();
        Hit {
            distance_m: hit.distance,
            point: Vec3((origin + hit.distance * direction).to_array()),
            normal: Vec3(hit.normal.to_array()),
            surface: id.map_or(SurfaceName::Index(place), SurfaceName::Id),
            surface_radiance: rgb(radiance),
        }
    }
}

fn rgb(v: DVec3) -> Rgb {
    Rgb(v.to_array())
}
