//! The numbers along single rays, in f64: L = e^(−T) L_p + Σ L_a + L_fog (1 − e^(−T)).

use crate::airlight::fogshop2007::{CenterDepths, Eye, Sighted};
use crate::airlight::{Method, Path, Under, macklin2010, mapped, march, reference, sun2005};
use crate::geometry::{Beyond, Origin, Ray, parts::without};
use crate::light::{Source, least_distance};
use crate::media::noise::{self, Bend};
use crate::media::{Field, Scattering, in_channels};
use crate::progress::{Interrupted, Progress};
use crate::request::ProbeRay;
use crate::scene::{
    CheckedScene, Lit, Material, Octave, Projection, Rgb, Spectrum, SurfaceLighting, Vec3,
};
use crate::shapes::{self, Geometry};
use crate::sky::{Part, Radiance};
use crate::surface::attenuated;
use glam::DVec3;
use schemars::JsonSchema;
use serde::Serialize;
use std::f64::consts::FRAC_1_PI;
use std::sync::Arc;

/// What a probe finds along one ray.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct RayAnswer {
    /// ∫ β along the ray; a number while every extinction is grey, else one a channel.
    pub optical_depth: Spectrum,
    /// exp(−optical depth), likewise.
    pub transmittance: Spectrum,
    /// Light of all lamps scattered into the ray [W/(m² sr)].
    pub airlight: Rgb,
    /// The same lamp by lamp, in scene order.
    pub airlight_by_light: Vec<Rgb>,
    /// The veil: ambient · (1 − transmittance).
    pub ambient: Rgb,
    /// surface · transmittance + airlight + ambient; the sky stands for the surface where nothing is hit, and
    /// `background` where there is none.
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

/// A band of a scene's fog, before its rays, in an octave of its light.
pub struct Band {
    octave: Octave,
    field: Arc<Field>,
    method: Method,
    /// For the published method: the depths from every enabled light.
    from_lights: Vec<Arc<CenterDepths>>,
}

impl Band {
    /// Of a scene; `from_light` makes the depths for the published method alone.
    ///
    /// # Errors
    /// What `from_light` fails with.
    pub fn new(
        scene: &CheckedScene,
        octave: Octave,
        field: &Arc<Field>,
        from_light: impl Fn(Source) -> Result<Arc<CenterDepths>, Interrupted>,
    ) -> Result<Self, Interrupted> {
        let method = scene.matched(scene.fog.airlight.into(), field);
        let lamps = scene.lamps().filter(|_| method == Method::Fogshop2007);
        let from_lights = lamps.map(|(_, lamp)| from_light(lamp.source));
        let from_lights = from_lights.collect::<Result<_, _>>()?;
        Ok(Self { octave, field: Arc::clone(field), method, from_lights })
    }
}

/// A band with what the published method knows of where the last ray started.
type Known<'a> = (&'a Band, Option<(Eye, CenterDepths)>);

/// Evaluates rays of one scene, one after the other. What rays from the same origin share is kept.
pub struct Prober<'a> {
    scene: &'a CheckedScene,
    geometry: &'a Geometry,
    /// Octave by octave, each with what the published method knows of where the last ray started.
    octaves: Vec<Vec<Known<'a>>>,
    scatterings: Vec<Scattering>,
    /// What bends rays before blobs, if anything does.
    noise: Option<Bend>,
    progress: &'a Progress,
}

impl<'a> Prober<'a> {
    /// For a scene with its geometry and the bands of its fog, octave by octave.
    pub fn new(
        scene: &'a CheckedScene,
        geometry: &'a Geometry,
        octaves: &'a [Vec<Band>],
        progress: &'a Progress,
    ) -> Self {
        let each = |bands: &'a Vec<Band>| bands.iter().map(|band| (band, None)).collect();
        let octaves = octaves.iter().map(each).collect();
        let noise = Bend::new(&scene.fog.noise, scene.time_s);
        Self { scene, geometry, octaves, scatterings: scene.fog.scatterings(), noise, progress }
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
        let (depths, shares) = self.depths(&ray, length);
        let optical_depth = spectrum(&depths);
        let transmittance = spectrum(&transmittances(&depths));
        let airlight_by_light = self.airlight_by_light(ray, length, &shares)?;
        let airlight = airlight_by_light.iter().sum::<DVec3>();
        let absorptance = channels(optical_depth).map(|depth| 0.0 - (-depth).exp_m1());
        let ambient = self.scene.fog.ambient.vector() * absorptance;
        let (surface, hit) = match hit {
            None => (self.scene.behind_all(direction), None),
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
            radiance: rgb(surface * channels(transmittance) + airlight + ambient),
            hit,
        })
    }

    /// A number of every band.
    fn each_band(&self, of: impl Fn(&Field) -> f64) -> Vec<f64> {
        self.octaves[0].iter().map(|(band, _)| of(&band.field)).collect()
    }

    /// T of every band, and what noise leaves of airlight in it.
    fn depths(&self, ray: &Ray, length: f64) -> (Vec<f64>, Vec<f64>) {
        let straight = self.each_band(|field| field.depth(ray, length));
        let Some(noise) = &self.noise else { return (straight.clone(), vec![1.0; straight.len()]) };
        let changes = self.each_band(|field| noise.change_of(field, ray, length));
        let bent = straight.iter().zip(changes).map(|(depth, change)| (depth + change).max(0.0));
        let bent: Vec<_> = bent.collect();
        let shares = straight.iter().zip(&bent).map(|(depth, bent)| noise::share(*depth, *bent));
        let shares = shares.collect();
        (bent, shares)
    }

    /// Airlight lamp by lamp; `shares` is what noise leaves of it in each band.
    fn airlight_by_light(
        &mut self,
        ray: Ray,
        length: f64,
        shares: &[f64],
    ) -> Result<Vec<DVec3>, Interrupted> {
        let shadows = |(_, lamp): (usize, Lit)| match lamp.light.shadows() {
            true => self.geometry.shadows(lamp.source.origin(), &ray, length),
            false => Vec::new(),
        };
        let shadows: Vec<_> = self.scene.lamps().map(shadows).collect();
        let mut by_band = Vec::with_capacity(shares.len());
        for (band, share) in shares.iter().enumerate() {
            let mut sum = vec![DVec3::ZERO; self.scene.lights.len()];
            for octave in 0..self.octaves.len() {
                let straight = self.airlight_in([octave, band], ray, length, &shadows)?;
                sum.iter_mut().zip(straight).for_each(|(sum, light)| *sum += light * *share);
                for (i, own) in self.of_skies([octave, band], ray, length)? {
                    sum[i] += own * *share;
                }
            }
            by_band.push(sum);
        }
        let of_light =
            |i: usize| in_channels(&by_band.iter().map(|by_light| by_light[i]).collect::<Vec<_>>());
        Ok((0..self.scene.lights.len()).map(of_light).collect())
    }

    /// The same as one band has it.
    fn airlight_in(
        &mut self,
        [octave, band]: [usize; 2],
        ray: Ray,
        length: f64,
        shadows: &[Vec<[f64; 2]>],
    ) -> Result<Vec<DVec3>, Interrupted> {
        let sighted = self.sighted([octave, band], ray, length)?;
        let band = self.octaves[octave][band].0;
        let field = &*band.field;
        let mut by_light = vec![DVec3::ZERO; self.scene.lights.len()];
        for (place, (i, lamp)) in self.scene.lamps().enumerate() {
            let source = lamp.source;
            let shadows = &shadows[place];
            for (group, own) in self.scatterings.iter().enumerate() {
                let Scattering { albedo, phase } = own.in_octave(band.octave);
                self.progress.check()?;
                let path = || {
                    let path = Path::new(field, group, source, ray, length).shaded(shadows);
                    path.of(self.progress)
                };
                let unit = match band.method {
                    Method::None => 0.0,
                    Method::Sun2005 | Method::Macklin2010 => {
                        let parts = without([0.0, length], shadows);
                        let of_part = |ends| closed(field, group, band.method, source, &ray, ends);
                        parts.into_iter().map(of_part).sum()
                    }
                    Method::Fogshop2007 => match &sighted {
                        Some(sighted) => {
                            let from_light = &band.from_lights[place];
                            sighted.airlight(field, source, from_light, shadows, self.progress)?
                        }
                        None => 0.0,
                    },
                    Method::Auto => mapped::airlight_along(&path(), phase),
                    Method::Reference => reference::airlight_along(&path(), phase),
                    Method::March(steps) => march::airlight_along(&path(), phase, steps),
                };
                by_light[i] += unit * lamp.strength * albedo;
            }
        }
        // What was summed up after the end is none.
        self.progress.check()?;
        Ok(by_light)
    }

    /// The same of the skies, by their places among the lights.
    fn of_skies(
        &self,
        [octave, place]: [usize; 2],
        ray: Ray,
        length: f64,
    ) -> Result<Vec<(usize, DVec3)>, Interrupted> {
        let (band, bands) = (&self.octaves[octave][place].0, self.octaves[octave].len());
        let channels = std::array::from_fn(|channel| bands == 1 || channel == place);
        let (path_m, asked) = (self.scene.fog.light_path_m, self.scene.fog.airlight.into());
        let of_sky = |(i, sky): (usize, &Radiance)| {
            let under = Under { sky, path_m, ray, length, channels };
            let of_group = |(group, own): (usize, &Scattering)| {
                self.progress.check()?;
                let Scattering { albedo, phase } = own.in_octave(band.octave);
                let unit = under.airlight(&band.field, (group, phase), asked, self.progress);
                Ok(unit * albedo)
            };
            let groups = self.scatterings.iter().enumerate().map(of_group);
            let sum = groups.sum::<Result<DVec3, Interrupted>>()?;
            self.progress.check()?;
            Ok((i, sum))
        };
        self.scene.skies().map(of_sky).collect()
    }

    /// For the published method: a ray with what its eye knows, which the last ray's may have been.
    fn sighted(
        &mut self,
        [octave, band]: [usize; 2],
        ray: Ray,
        length: f64,
    ) -> Result<Option<Sighted>, Interrupted> {
        let (band, from_eye) = &mut self.octaves[octave][band];
        if band.method != Method::Fogshop2007 {
            return Ok(None);
        }
        let eye = match self.scene.camera.projection {
            Projection::Perspective(_) => Eye::Point(ray.origin),
            Projection::Orthographic(_) => Eye::Plane(ray.origin, ray.direction),
        };
        let shared = from_eye.take().filter(|(shared, _)| shared.is_same(&eye));
        let (_, from_eye) =
            from_eye.insert(shared.unwrap_or_else(|| (eye, CenterDepths::new(&band.field, eye))));
        Sighted::new(&band.field, from_eye, (ray, length), self.progress).map(Some)
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
        for (_, lamp) in self.scene.lamps() {
            self.progress.check()?;
            let source = lamp.source;
            if lamp.light.shadows() && self.geometry.hides_hit(source.origin(), point, hit) {
                continue;
            }
            let toward = source.toward(point.into(), least_distance(hit.distance));
            let (normal, shininess) = (hit.normal.into(), material.shininess);
            let diffuse = attenuated::diffuse(normal, &toward);
            let specular = attenuated::specular(normal, direction.into(), &toward, shininess);
            let is_clear = self.scene.fog.surface_lighting == SurfaceLighting::Clear;
            let depth = |field: &Field| field.depth_from(source.origin(), point);
            let depths = self.each_band(|field| if is_clear { 0.0 } else { depth(field) });
            let through = channels(spectrum(&transmittances(&depths)));
            let reflected =
                material.diffuse.vector() * diffuse + material.specular.vector() * specular;
            radiance += through * lamp.strength * reflected;
        }
        for (_, sky) in self.scene.skies() {
            self.progress.check()?;
            radiance += self.reflected(sky, material, (point, hit.normal, direction));
        }
        Ok(radiance)
    }

    /// What a surface sends on of a sky's light: ∫ L e^(−T(p,ω)) (ρ/π cos θ + k_s cosⁿ θ′) dω.
    fn reflected(
        &self,
        sky: &Radiance,
        material: &Material,
        (point, normal, direction): (DVec3, DVec3, DVec3),
    ) -> DVec3 {
        let is_clear = self.scene.fog.surface_lighting == SurfaceLighting::Clear;
        let path_m = self.scene.fog.light_path_m;
        let through = |part: &Part| {
            let origin = Origin::Beyond(Beyond { toward: part.toward, path_m });
            let depth = |field: &Field| field.depth_from(origin, point);
            let depths = self.each_band(|field| if is_clear { 0.0 } else { depth(field) });
            part.weight * channels(spectrum(&transmittances(&depths)))
        };
        let matte: DVec3 = sky.on_surface(normal).iter().map(through).sum();
        let mut radiance = material.diffuse.vector() * matte * FRAC_1_PI;
        if material.specular.vector() != DVec3::ZERO {
            let lobe = sky.in_lobe(normal, direction, material.shininess);
            let glossy: DVec3 = lobe.iter().map(through).sum();
            radiance += material.specular.vector() * glossy;
        }
        radiance
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

/// Airlight of a light along a part of a ray by a method in closed form, of one group of terms.
fn closed(
    field: &Field,
    group: usize,
    method: Method,
    source: Source,
    ray: &Ray,
    ends: [f64; 2],
) -> f64 {
    let (start, direction) = (ray.origin.into(), ray.direction.into());
    let (to, cone) = (source.beside(start, direction), source.crossed(start, direction));
    let cone = cone.as_ref();
    let (beta, share) = (sun2005::haze(field), sun2005::share(field, group));
    if method == Method::Sun2005 {
        return share * sun2005::within(beta, source, to, cone, ends);
    }
    let [first, last] = ends;
    let within = |beta: f64, slab: [f64; 2]| {
        macklin2010::within(beta, to, cone, slab.map(|end| end.clamp(first, last)))
    };
    share * within(beta, ends) + macklin2010::of_slabs(field, group, ray, last, within)
}

/// The numbers of all bands.
fn spectrum(bands: &[f64]) -> Spectrum {
    match *bands {
        [r, g, b] => Spectrum::Rgb([r, g, b]),
        _ => Spectrum::Grey(bands.iter().sum()),
    }
}

fn transmittances(depths: &[f64]) -> Vec<f64> {
    depths.iter().map(|depth| (-depth).exp()).collect()
}

fn channels(spectrum: Spectrum) -> DVec3 {
    spectrum.channels().into()
}

fn rgb(v: DVec3) -> Rgb {
    Rgb(v.to_array())
}
