//! The numbers along single rays, in f64: L = e^(−T) L_p + Σ L_a + L_fog (1 − e^(−T)).

use crate::airlight::fogshop2007::{CenterDepths, Eye, Sighted};
use crate::airlight::{Estimator, Method, Path, least_distance, mapped, march, reference, sun2005};
use crate::geometry::Ray;
use crate::media::Field;
use crate::progress::{Interrupted, Progress};
use crate::request::ProbeRay;
use crate::scene::{CheckedScene, Projection, Rgb, Vec3};
use crate::shapes::{self, Geometry};
use crate::surface::attenuated;
use glam::DVec3;
use schemars::JsonSchema;
use serde::Serialize;
use std::sync::Arc;

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
    /// For the published method: the depths from every enabled light.
    from_lights: &'a [Arc<CenterDepths>],
    /// The same from where the last ray started.
    from_eye: Option<(Eye, CenterDepths)>,
    progress: &'a Progress,
}

/// The airlight estimator of a scene.
pub(crate) fn method(scene: &CheckedScene, field: &Field) -> Method {
    Method::new(Estimator::Scene(scene.fog.airlight), &scene.fog.phase, field)
}

impl<'a> Prober<'a> {
    /// For a scene with its geometry and field; `from_lights` for the published method alone.
    pub fn new(
        scene: &'a CheckedScene,
        geometry: &'a Geometry,
        field: &'a Field,
        from_lights: &'a [Arc<CenterDepths>],
        progress: &'a Progress,
    ) -> Self {
        let method = method(scene, field);
        Self { scene, geometry, field, method, from_lights, from_eye: None, progress }
    }

    /// Everything along one ray.
    ///
    /// # Errors
    /// [`Interrupted`] when the job's progress says so.
    pub fn answer(&mut self, ray: &ProbeRay) -> Result<RayAnswer, Interrupted> {
        let ProbeRay { origin, direction, max_distance_m } = *ray;
        let limit = max_distance_m.unwrap_or(self.scene.far_m);
        let hit = self.geometry.first_hit(origin, direction, limit);
        let length = hit.map_or(limit, |hit| hit.distance);
        let ray = Ray { origin, direction };
        let optical_depth = self.field.depth(&ray, length);
        let transmittance = (-optical_depth).exp();
        let airlight_by_light = self.airlight_by_light(ray, length)?;
        let airlight = airlight_by_light.iter().sum::<DVec3>();
        let ambient = self.scene.fog.ambient.vector() * (0.0 - (-optical_depth).exp_m1());
        let (surface, hit) = match hit {
            None => (self.scene.background.vector(), None),
            Some(hit) => {
                let radiance = self.surface_radiance(&hit, origin, direction)?;
                (radiance, Some(self.describe(&hit, origin, direction, radiance)))
            }
        };
        Ok(RayAnswer {
            optical_depth,
            transmittance,
            airlight: rgb(airlight),
            airlight_by_light: airlight_by_light.into_iter().map(rgb).collect(),
            ambient: rgb(ambient),
            radiance: rgb(surface * transmittance + airlight + ambient),
            hit,
        })
    }

    fn airlight_by_light(&mut self, ray: Ray, length: f64) -> Result<Vec<DVec3>, Interrupted> {
        let phase = self.scene.fog.phase.function();
        let sighted = self.sighted(ray, length)?;
        let mut by_light = vec![DVec3::ZERO; self.scene.lights.len()];
        for (place, (i, light)) in self.scene.lights().enumerate() {
            self.progress.check()?;
            let at = light.position.vector();
            let path = || Path::new(self.field, at, ray, length).of(self.progress);
            let unit = match self.method {
                Method::None => 0.0,
                Method::Sun2005 => {
                    let beta = self.field.uniform_beta().unwrap_or_default();
                    let toward = (at - ray.origin).into();
                    sun2005::airlight(beta, toward, ray.direction.into(), length)
                }
                Method::Fogshop2007 => match &sighted {
                    Some(sighted) => {
                        sighted.airlight(self.field, at, &self.from_lights[place], self.progress)?
                    }
                    None => 0.0,
                },
                Method::Mapped => mapped::airlight_along(&path(), phase),
                Method::Reference => reference::airlight_along(&path(), phase),
                Method::March(steps) => march::airlight_along(&path(), phase, steps),
            };
            by_light[i] = unit * light.intensity.vector() * self.scene.fog.albedo.vector();
        }
        // What was summed up after the end is none.
        self.progress.check()?;
        Ok(by_light)
    }

    /// For the published method: a ray with what its eye knows, which the last ray's may have been.
    fn sighted(&mut self, ray: Ray, length: f64) -> Result<Option<Sighted>, Interrupted> {
        if self.method != Method::Fogshop2007 {
            return Ok(None);
        }
        let eye = match self.scene.camera.projection {
            Projection::Perspective(_) => Eye::Point(ray.origin),
            Projection::Orthographic(_) => Eye::Plane(ray.origin, ray.direction),
        };
        let shared = self.from_eye.take().filter(|(shared, _)| shared.is_same(&eye));
        let (_, from_eye) = self
            .from_eye
            .insert(shared.unwrap_or_else(|| (eye, CenterDepths::new(self.field, eye))));
        Sighted::new(self.field, from_eye, (ray, length), self.progress).map(Some)
    }

    fn surface_radiance(
        &self,
        hit: &shapes::Hit,
        origin: DVec3,
        direction: DVec3,
    ) -> Result<DVec3, Interrupted> {
        let point = origin + hit.distance * direction;
        let material = &self.geometry.materials[hit.surface as usize];
        let mut radiance = material.emission.vector();
        for (_, light) in self.scene.lights() {
            self.progress.check()?;
            let to_light = light.position.vector() - point;
            let reflection = attenuated::reflection(
                hit.normal.into(),
                direction.into(),
                to_light.into(),
                material.shininess,
                least_distance(hit.distance),
            );
            let depth = self.field.depth_between(light.position.vector(), point);
            let reflected = material.diffuse.vector() * reflection.diffuse
                + material.specular.vector() * reflection.specular;
            radiance += (-depth).exp() * light.intensity.vector() * reflected;
        }
        Ok(radiance)
    }

    fn describe(&self, hit: &shapes::Hit, origin: DVec3, direction: DVec3, radiance: DVec3) -> Hit {
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
