//! What every pass of a frame reads, on either backend.

use super::light_table::LightTable;
use super::shafts::Shafts;
use super::skies::{self, OfSky, Sky};
use super::viewpoint::{Grid, Viewpoint};
use crate::airlight::Method;
use crate::airlight::fogshop2007::LitBlobs;
use crate::airlight::mapped::OPAQUE;
use crate::geometry::batch::TILE;
use crate::geometry::{Beyond, Ray};
use crate::light::{Source, sun};
use crate::media::noise::Bend;
use crate::media::{Field, Purpose, Scattering};
use crate::phase::PhaseFunction;
use crate::progress::{Job, Progress};
use crate::request::{Layer, Quality, View};
use crate::scene::{Camera, CheckedScene, Lit, Material, Octave, SurfaceLighting};
use crate::shapes::Geometry;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;
use std::sync::Arc;

/// Pixels of a draft from one of which fog is computed to the next.
pub const DRAFT_STEP: usize = 4;

/// A light as the passes need it.
pub struct Lamp {
    /// Where its light comes from.
    pub source: Source,
    /// The same, seen from the camera.
    pub from_camera: Source,
    /// Colour and strength.
    pub strength: DVec3,
    /// Whether some surface may hide it from what is seen.
    pub is_shaded: bool,
    /// Whether a plane hides it from all of the fog before the eye.
    pub is_cut_off: bool,
    /// What surfaces hide of it from view rays, where airlight asks for that.
    pub shafts: Option<Arc<Shafts>>,
    /// For the mapped airlight, where many blobs shade the light.
    pub table: Arc<Option<LightTable>>,
    /// The part of a sky that it stands for, if it is no lamp.
    pub of_sky: Option<OfSky>,
}

impl Lamp {
    /// One that nothing hides, seen from anywhere.
    pub fn new(source: Source, strength: DVec3) -> Self {
        Self {
            source,
            from_camera: source,
            strength,
            is_shaded: false,
            is_cut_off: false,
            shafts: None,
            table: Arc::default(),
            of_sky: None,
        }
    }

    /// Whether its light goes on as a sun's would that is scattered evenly.
    pub fn is_even(&self) -> bool {
        self.of_sky.is_none_or(|own| own.phase.is_isotropic())
    }

    /// Where it appears in the picture [px], if it stands somewhere in front of the camera.
    pub fn image(&self, viewpoint: &Viewpoint) -> Option<DVec2> {
        viewpoint.project(self.from_camera.apex()?)
    }

    /// Whether it lights parts of rays only.
    pub fn is_parted(&self) -> bool {
        self.is_shaded || self.source.beam().is_some()
    }
}

/// A sky, by its place in the frame, as lamps for all phase functions of the fog.
fn lamps_of(place: usize, sky: &Sky, scatterings: &[Scattering]) -> Vec<Lamp> {
    let mut phases: Vec<PhaseFunction> = Vec::new();
    for own in scatterings {
        if !phases.contains(&own.phase) {
            phases.push(own.phase);
        }
    }
    let source = Source::Sun(sun::Place(Beyond { toward: DVec3::Y, path_m: sky.path_m }));
    let of_phase = |phase: PhaseFunction| {
        let most = skies::most(sky.radiance, phase);
        let lamp = move |(i, (channel, colour)): (usize, &(usize, DVec3))| {
            let most = most[*channel];
            let strength = *colour * (4.0 * PI * most * sun::DISTANCE_M * sun::DISTANCE_M);
            let of_sky = Some(OfSky { sky: place, place: i, phase, most });
            Lamp { of_sky, ..Lamp::new(source, strength) }
        };
        sky.channels.iter().enumerate().map(lamp)
    };
    phases.into_iter().flat_map(of_phase).collect()
}

/// What a group of terms scatters of a lamp.
#[derive(Clone, Copy, Debug)]
pub struct Scatter {
    /// The lamp, by its place.
    pub lamp: usize,
    /// The group, by its place in the field.
    pub group: usize,
    /// Where its light goes.
    pub phase: PhaseFunction,
    /// The lamp's strength times the group's albedo.
    pub colour: DVec3,
}

/// What every pass of a frame reads, in one band of colour.
pub struct Context<'a> {
    /// What it is made with.
    pub job: Job<'a>,
    /// Surfaces.
    pub geometry: &'a Arc<Geometry>,
    /// Which channel of several it is, if they differ.
    pub band: Option<usize>,
    /// Extinction in this band.
    pub field: &'a Arc<Field>,
    /// The camera as the scene has it.
    pub camera: &'a Camera,
    /// The camera as rays.
    pub viewpoint: Viewpoint,
    /// The picture.
    pub grid: Grid,
    /// Where a ray that meets nothing ends [m].
    pub far_m: f32,
    /// The enabled lamps, and behind them the skies as lamps.
    pub lamps: Vec<Lamp>,
    /// The enabled skies.
    pub skies: Vec<Sky<'a>>,
    /// Whether their light reaches surfaces as in clear air.
    pub is_clear: bool,
    /// What is scattered, lamp by lamp: airlight is formed once for each.
    pub scatters: Vec<Scatter>,
    /// The airlight estimator.
    pub method: Method,
    /// The one that was asked for, which may be matched by another.
    pub asked: Method,
    /// For the published airlight, one a lamp.
    pub lit_blobs: Vec<LitBlobs>,
    /// Diffuse, specular, emission and shininess of every surface.
    pub materials: Vec<[f32; 10]>,
    /// What stands for a material where nothing is hit.
    pub background: [f32; 10],
    /// Radiance of the veil.
    pub ambient: [f32; 3],
    /// The octave of light whose airlight it is; all but the first show nothing else.
    pub octave: Octave,
    /// What bends view rays before blobs, if anything does.
    pub noise: Option<Bend>,
    /// What is asked for.
    pub view: View,
}

impl<'a> Context<'a> {
    /// What a frame of a scene is made from, before any pass.
    pub fn new(
        scene: &'a CheckedScene,
        geometry: &'a Arc<Geometry>,
        (field, octave, band): (&'a Arc<Field>, Octave, Option<usize>),
        view: &View,
        progress: &'a Progress,
    ) -> Self {
        let grid = Grid { width: view.width as usize, height: view.height as usize };
        let viewpoint = Viewpoint::new(&scene.camera, grid.width, grid.height);
        let lamps = scene.lamps().map(|(_, Lit { light, source, strength })| {
            let from_camera = source.seen_from(viewpoint.position);
            let eye = (!viewpoint.parallel).then_some(viewpoint.position);
            let is_shaded = light.shadows() && geometry.may_hide(source.origin(), eye);
            let is_cut_off =
                light.shadows() && eye.is_some_and(|eye| geometry.cuts_off(source.origin(), eye));
            Lamp { from_camera, is_shaded, is_cut_off, ..Lamp::new(source, strength) }
        });
        let mut lamps = lamps.collect::<Vec<_>>();
        let scatterings = scene.fog.scatterings();
        let scatterings: Vec<_> = scatterings.iter().map(|own| own.in_octave(octave)).collect();
        let layer = if octave == Octave::FIRST { view.layer } else { Layer::Airlight };
        let asked = view.estimator.unwrap_or(scene.fog.airlight.into());
        let skies =
            scene.skies().map(|(_, sky)| Sky::new(sky, scene.fog.light_path_m, band, asked));
        let skies: Vec<_> = skies.collect();
        lamps.extend(skies.iter().enumerate().flat_map(|(i, sky)| lamps_of(i, sky, &scatterings)));
        // Skies stand behind everything in its place.
        let background = if skies.is_empty() { scene.background.0 } else { [0.0; 3] };
        let [r, g, b] = background.map(|v| v as f32);
        Self {
            job: Job::new(progress),
            geometry,
            band,
            field,
            camera: &scene.camera,
            viewpoint,
            grid,
            far_m: scene.far_m as f32,
            scatters: scatters(&lamps, &scatterings),
            method: method(scene, asked, field, &lamps),
            lamps,
            skies,
            asked,
            is_clear: scene.fog.surface_lighting == SurfaceLighting::Clear,
            lit_blobs: Vec::new(),
            materials: geometry.materials.iter().map(numbers).collect(),
            background: [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, r, g, b, 1.0],
            ambient: scene.fog.ambient.0.map(|v| v as f32),
            noise: Bend::new(&scene.fog.noise, scene.time_s).filter(|_| field.lumps() > 0),
            octave,
            view: View { layer, ..*view },
        }
    }

    /// The parts of a ray that a lamp does not reach, ascending [m].
    pub fn shadows(&self, lamp: &Lamp, ray: &Ray, length: f64) -> Vec<[f64; 2]> {
        if !lamp.is_shaded {
            return Vec::new();
        }
        self.geometry.shadows(lamp.source.origin(), ray, length)
    }

    /// Whether pixels at the rims of shadows are looked at again.
    pub fn softens(&self) -> bool {
        self.view.for_screen && self.view.quality == Quality::Full
    }

    /// Whether the layer shows light that the fog scatters.
    pub fn shows_airlight(&self) -> bool {
        matches!(self.view.layer, Layer::Beauty | Layer::Airlight)
    }

    /// Whether the light of the lamps in the fog is shown.
    pub fn is_lit(&self) -> bool {
        self.shows_airlight() && self.method != Method::None
    }

    /// What optical depth along view rays is for: who states it follows it to its end.
    pub fn purpose(&self) -> Purpose {
        if self.shows_airlight() { Purpose::Sight } else { Purpose::Depth }
    }

    /// Optical depth behind which airlight is not seen.
    pub fn opaque(&self) -> f32 {
        self.view.options.opaque().min(OPAQUE as f32)
    }

    /// Whether the mapped airlight is shown.
    pub fn is_mapped(&self) -> bool {
        self.method == Method::Auto && self.shows_airlight()
    }

    /// Whether the layer shows lit surfaces.
    pub fn shows_surfaces(&self) -> bool {
        matches!(self.view.layer, Layer::Beauty | Layer::Surface)
    }

    /// Whether the layer depends on the fog along view rays.
    pub fn shows_fog(&self) -> bool {
        self.shows_airlight()
            || matches!(self.view.layer, Layer::OpticalDepth | Layer::Transmittance)
    }

    /// Whether the picture is for the eye.
    pub fn is_for_the_eye(&self) -> bool {
        self.view.for_screen || self.view.quality == Quality::Draft
    }

    /// The lamps that surfaces are lit by from one side.
    pub fn direct(&self) -> &[Lamp] {
        let count = self.lamps.partition_point(|lamp| lamp.of_sky.is_none());
        &self.lamps[..count]
    }

    /// The lamp of what is scattered, by its place.
    pub fn lamp_of(&self, scatter: usize) -> &Lamp {
        &self.lamps[self.scatters[scatter].lamp]
    }

    /// Whether the mapped airlight stands on a grid of rays, from which the lumps' optical depths are taken, too:
    /// for the eye, and where fog changes too fast for rules of nodes.
    pub fn interpolates(&self) -> bool {
        let on_grid = self.is_for_the_eye() || self.field.is_rippled();
        on_grid && self.is_mapped() && !self.scatters.is_empty()
    }

    /// Whether a grid of rays tells only which share of a lamp's airlight is left by cones and shadows: for numbers.
    pub fn takes_shares(&self) -> bool {
        let is_parted = self.lamps.iter().any(Lamp::is_parted);
        is_parted && !self.interpolates() && self.is_mapped() && !self.scatters.is_empty()
    }

    /// Whether there is a grid of rays at all, which all lamps share.
    pub fn has_grid(&self) -> bool {
        self.interpolates() || self.takes_shares()
    }

    /// Whether surfaces look T from lamps up in the lamps' tables.
    pub fn looks_up_lights(&self) -> bool {
        self.interpolates() && self.is_for_the_eye()
    }

    /// Pixels from one of which fog is computed to the next, where it is computed for some of them only: a power of
    /// two.
    pub fn step(&self) -> usize {
        let wanted = (1.0 / self.view.options.fog_scale).clamp(1.0, TILE as f64) as usize;
        let asked = 1 << wanted.ilog2();
        if self.view.quality == Quality::Draft { DRAFT_STEP.max(asked) } else { asked }
    }

    /// Whether fog is computed for some of the pixels only.
    pub fn is_low(&self) -> bool {
        self.step() > 1
            && !self.field.is_empty()
            && !self.interpolates()
            && !self.is_per_vertex()
            // What noise makes of a pixel its neighbours do not tell.
            && self.noise.is_none()
            && (self.shows_fog() || self.shows_surfaces())
    }

    /// Whether what meshes lose of their light is computed at their corners: where no light is scattered that would
    /// have to be formed for every pixel.
    pub fn is_per_vertex(&self) -> bool {
        let is_lit = self.is_lit() && !self.scatters.is_empty();
        self.view.options.per_vertex && self.shows_fog() && !is_lit
    }
}

/// What computes airlight. A closed form stands for `auto` only where all of a ray is lit.
fn method(scene: &CheckedScene, asked: Method, field: &Field, lamps: &[Lamp]) -> Method {
    let matched = scene.matched(asked, field);
    let is_shaded = lamps.iter().any(|lamp| lamp.is_shaded);
    if asked == Method::Auto && matched == Method::Sun2005 && is_shaded { asked } else { matched }
}

/// Every lamp with every group; what scatters nothing is left out.
fn scatters(lamps: &[Lamp], scatterings: &[Scattering]) -> Vec<Scatter> {
    let groups = || scatterings.iter().enumerate().filter(|(_, own)| own.albedo != DVec3::ZERO);
    let of_lamp = |(lamp, light): (usize, &Lamp)| {
        let (strength, of_sky) = (light.strength, light.of_sky);
        let own_groups =
            groups().filter(move |(_, own)| of_sky.is_none_or(|sky| sky.phase == own.phase));
        own_groups.map(move |(group, own)| Scatter {
            lamp,
            group,
            // What a phase function makes of a sky stands in its lamp.
            phase: if of_sky.is_some() { PhaseFunction::ISOTROPIC } else { own.phase },
            // A number in f32, however bright and thin.
            colour: (strength * own.albedo).min(DVec3::splat(1e38)),
        })
    };
    let lamps = lamps.iter().enumerate().filter(|(_, lamp)| !lamp.is_cut_off);
    lamps.flat_map(of_lamp).collect()
}

fn numbers(material: &Material) -> [f32; 10] {
    let [d, s, e] = [material.diffuse.0, material.specular.0, material.emission.0];
    let all = [d[0], d[1], d[2], s[0], s[1], s[2], e[0], e[1], e[2], material.shininess];
    all.map(|v| v as f32)
}
