//! What every pass of a frame reads, on either backend.

use super::light_table::LightTable;
use super::viewpoint::{Grid, Viewpoint};
use crate::airlight::Method;
use crate::airlight::fogshop2007::LitBlobs;
use crate::airlight::mapped::OPAQUE;
use crate::geometry::batch::TILE;
use crate::light::Source;
use crate::media::noise::Bend;
use crate::media::{Field, Purpose, Scattering};
use crate::phase::PhaseFunction;
use crate::progress::{Job, Progress};
use crate::request::{Layer, Quality, View};
use crate::scene::{CheckedScene, Material, SurfaceLighting};
use crate::shapes::Geometry;
use glam::{DVec2, DVec3};
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
    /// For the mapped airlight, where many blobs shade the light.
    pub table: Arc<Option<LightTable>>,
}

impl Lamp {
    /// Where it appears in the picture [px], if it stands somewhere in front of the camera.
    pub fn image(&self, viewpoint: &Viewpoint) -> Option<DVec2> {
        viewpoint.project(self.from_camera.apex()?)
    }
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
    pub geometry: &'a Geometry,
    /// Whether it is one of several.
    pub is_band: bool,
    /// Extinction in this band.
    pub field: &'a Arc<Field>,
    /// The camera.
    pub viewpoint: Viewpoint,
    /// The picture.
    pub grid: Grid,
    /// Where a ray that meets nothing ends [m].
    pub far_m: f32,
    /// The enabled lights.
    pub lamps: Vec<Lamp>,
    /// Whether their light reaches surfaces as in clear air.
    pub is_clear: bool,
    /// What is scattered, lamp by lamp: airlight is formed once for each.
    pub scatters: Vec<Scatter>,
    /// The airlight estimator.
    pub method: Method,
    /// For the published airlight, one a lamp.
    pub lit_blobs: Vec<LitBlobs>,
    /// Diffuse, specular, emission and shininess of every surface.
    pub materials: Vec<[f32; 10]>,
    /// What stands for a material where nothing is hit.
    pub background: [f32; 10],
    /// Radiance of the veil.
    pub ambient: [f32; 3],
    /// What bends view rays before blobs, if anything does.
    pub noise: Option<Bend>,
    /// What is asked for.
    pub view: View,
}

impl<'a> Context<'a> {
    /// What a frame of a scene is made from, before any pass.
    pub fn new(
        scene: &CheckedScene,
        geometry: &'a Geometry,
        field: &'a Arc<Field>,
        view: &View,
        progress: &'a Progress,
    ) -> Self {
        let grid = Grid { width: view.width as usize, height: view.height as usize };
        let viewpoint = Viewpoint::new(&scene.camera, grid.width, grid.height);
        let lamps = scene.lights().map(|(_, light)| {
            let (source, strength) = (scene.source(light), light.strength());
            let from_camera = source.seen_from(viewpoint.position);
            Lamp { source, from_camera, strength, table: Arc::default() }
        });
        let (lamps, scatterings) = (lamps.collect::<Vec<_>>(), scene.fog.scatterings());
        let asked = view.estimator.unwrap_or(scene.fog.airlight.into());
        let [r, g, b] = scene.background.0.map(|v| v as f32);
        Self {
            job: Job::new(progress),
            geometry,
            is_band: false,
            field,
            viewpoint,
            grid,
            far_m: scene.far_m as f32,
            scatters: scatters(&lamps, &scatterings),
            method: scene.matched(asked, field),
            lamps,
            is_clear: scene.fog.surface_lighting == SurfaceLighting::Clear,
            lit_blobs: Vec::new(),
            materials: geometry.materials.iter().map(numbers).collect(),
            background: [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, r, g, b, 1.0],
            ambient: scene.fog.ambient.0.map(|v| v as f32),
            noise: Bend::new(&scene.fog.noise, scene.time_s).filter(|_| field.lumps() > 0),
            view: *view,
        }
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

    /// Whether the mapped airlight stands on a grid of rays, from which the lumps' optical depths are taken, too:
    /// for the eye, and where fog changes too fast for rules of nodes.
    pub fn interpolates(&self) -> bool {
        let on_grid = self.is_for_the_eye() || self.field.is_rippled();
        on_grid && self.is_mapped() && !self.scatters.is_empty()
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

/// Every lamp with every group; what scatters nothing is left out.
fn scatters(lamps: &[Lamp], scatterings: &[Scattering]) -> Vec<Scatter> {
    let groups = || scatterings.iter().enumerate().filter(|(_, own)| own.albedo != DVec3::ZERO);
    let of_lamp = |(lamp, light): (usize, &Lamp)| {
        let strength = light.strength;
        groups().map(move |(group, own)| Scatter {
            lamp,
            group,
            phase: own.phase,
            colour: strength * own.albedo,
        })
    };
    lamps.iter().enumerate().flat_map(of_lamp).collect()
}

fn numbers(material: &Material) -> [f32; 10] {
    let [d, s, e] = [material.diffuse.0, material.specular.0, material.emission.0];
    let all = [d[0], d[1], d[2], s[0], s[1], s[2], e[0], e[1], e[2], material.shininess];
    all.map(|v| v as f32)
}
