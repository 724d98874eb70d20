//! One frame on the CPU, read top to bottom as a list of passes over tiles.

use super::batch::{Fogged, Hits, NOTHING, Rays, Row, Rows, SIZE, TILE};
use super::cache::Cache;
use super::edges::{self, Samples};
use super::fog::{Ends, LitBlobs};
use super::mapped::{self, Fineness, LightTable};
use super::trace::{Order, Tracer};
use super::viewpoint::{Grid, Viewpoint};
use super::{centers, composite, fog, shade, upsample};
use crate::airlight::fogshop2007::LightSide;
use crate::airlight::{Estimator, Method};
use crate::geometry::Geometry;
use crate::media::Field;
use crate::phase::Phase;
use crate::progress::{Interrupted, Progress};
use crate::renderer::Frame;
use crate::request::{Layer, Quality, View};
use crate::scene::{CheckedScene, Material};
use fearless_simd::{Level, dispatch};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Where a pixel is sampled: its centre.
pub const CENTER: DVec2 = DVec2::splat(0.5);

/// A light as the passes need it.
pub struct Lamp {
    /// Where it is [m].
    pub position: DVec3,
    /// The same relative to the camera [m].
    pub from_camera: DVec3,
    /// Radiant intensity [W/sr].
    pub intensity: DVec3,
    /// Intensity times the fog's albedo [W/sr].
    pub scattered: DVec3,
    /// For [`Method::Mapped`], where many blobs shade the light.
    pub table: Arc<Option<LightTable>>,
}

/// What every pass of a frame reads.
pub struct Context<'a> {
    /// SIMD of this machine.
    pub level: Level,
    /// Surfaces.
    pub geometry: &'a Geometry,
    /// Extinction.
    pub field: &'a Arc<Field>,
    /// The camera.
    pub viewpoint: Viewpoint,
    /// The picture.
    pub grid: Grid,
    /// Where a ray that meets nothing ends [m].
    pub far_m: f32,
    /// The enabled lights.
    pub lamps: Vec<Lamp>,
    /// The airlight estimator.
    pub method: Method,
    /// The phase function.
    pub phase: Phase,
    /// For the published airlight, one a lamp.
    pub lit_blobs: Vec<LitBlobs>,
    /// Diffuse, specular, emission and shininess of every surface.
    pub materials: Vec<[f32; 10]>,
    /// What stands for a material where nothing is hit.
    pub background: [f32; 10],
    /// Radiance of the veil.
    pub ambient: [f32; 3],
    /// What is asked for.
    pub view: View,
    /// Whether to go on.
    pub progress: &'a Progress,
}

/// Renders one layer.
pub fn render(
    cache: &Cache,
    scene: &CheckedScene,
    view: &View,
    progress: &Progress,
) -> Result<Frame, Interrupted> {
    let mut clock = Clock::start(progress);
    let geometry = cache.geometry(scene, progress)?;
    let field = cache.field(scene, progress)?;
    clock.lap("prepare")?;
    let mut context = Context::new(scene, &geometry, &field, view, progress);

    let trace = || first_hits(&context);
    let hits = cache.first_hits(scene, &geometry, context.grid, progress, trace)?;
    clock.lap("surfaces")?;

    context.lit_blobs = light_sides(&context, cache)?;
    fill_tables(&mut context, cache)?;
    clock.lap("light_depth")?;

    let draft = view.quality == Quality::Draft && context.needs_low_resolution();
    let low = draft.then(|| upsample::Low::render(&context, &hits)).transpose()?;
    let low = low.as_ref();
    clock.lap_if(draft, "low_resolution")?;

    let surface = surfaces(&context, &hits, low)?;
    clock.lap("surface_radiance")?;

    let blocks = blocks(&context);
    let fog = fog(&context, &hits, low, &blocks);
    let has_edges = fog.iter().any(|block| !block.edges.is_empty());
    clock.lap(if has_edges { "airlight_and_edges" } else { "airlight" })?;

    let along_views = by_tile(&context, &blocks, &fog);
    let mut pixels = composite::picture(&context, &hits, &surface, &along_views);
    for (index, edges) in fog.iter().flat_map(|block| &block.edges) {
        edges::place(&context, *index, edges, &mut pixels);
    }
    clock.lap("composite")?;

    let (width, height) = (context.grid.width, context.grid.height);
    let (layer, camera) = (view.layer, scene.camera.clone());
    let (timings, backend) = (clock.laps, "cpu");
    Ok(Frame { width, height, layer, camera, pixels, shown: None, timings, backend })
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
            let (position, intensity) = (light.position.vector(), light.intensity.vector());
            let scattered = intensity * scene.fog.albedo.vector();
            let from_camera = position - viewpoint.position;
            Lamp { position, from_camera, intensity, scattered, table: Arc::default() }
        });
        let asked = view.estimator.unwrap_or(Estimator::Scene(scene.fog.airlight));
        let [r, g, b] = scene.background.0.map(|v| v as f32);
        Self {
            level: Level::new(),
            geometry,
            field,
            viewpoint,
            grid,
            far_m: scene.far_m as f32,
            lamps: lamps.collect(),
            method: Method::new(asked, &scene.fog, field),
            phase: Phase::from(&scene.fog.phase),
            lit_blobs: Vec::new(),
            materials: geometry.materials.iter().map(numbers).collect(),
            background: [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, r, g, b, 1.0],
            ambient: scene.fog.ambient.0.map(|v| v as f32),
            view: *view,
            progress,
        }
    }

    /// Whether the layer shows light that the fog scatters.
    pub fn shows_airlight(&self) -> bool {
        matches!(self.view.layer, Layer::Beauty | Layer::Airlight)
    }

    /// Whether the mapped airlight is shown.
    pub fn is_mapped(&self) -> bool {
        self.method == Method::Mapped && self.shows_airlight()
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

    /// Whether a picture for the eye takes optical depths, too, from what the mapped airlight
    /// interpolates.
    pub fn interpolates(&self) -> bool {
        let for_the_eye = self.view.for_screen || self.view.quality == Quality::Draft;
        for_the_eye && self.is_mapped() && !self.lamps.is_empty()
    }

    fn needs_low_resolution(&self) -> bool {
        !self.field.is_empty()
            && !self.interpolates()
            && (self.shows_fog() || self.shows_surfaces())
    }

    /// First hits of a tile's rays, which stand in that order; some are missing if the job is over.
    pub fn trace(&self, index: usize, rays: &[Rays], order: &Order) -> Vec<Hits> {
        let tile = self.grid.tile(index);
        let tracer = Tracer::new(self.geometry, &self.viewpoint, tile, order, self.progress);
        dispatch!(self.level, simd => tracer.trace(simd, rays, self.far_m))
    }

    /// What the fog does along a batch, as far as the layer shows it; but for an airlight that
    /// interpolates across the picture, which is formed for several batches at once.
    pub fn fog(&self, rays: &Rays, hits: &Hits) -> Fogged {
        if self.shows_fog() {
            fog::along(self, rays, hits, self.shows_airlight())
        } else {
            Fogged::clear()
        }
    }

    /// Surface radiance of a batch, every light's depth exact; black if the layer shows none.
    pub fn shade(&self, rays: &Rays, hits: &Hits) -> Rows {
        if !self.shows_surfaces() {
            return [[0.0; SIZE]; 3];
        }
        let depths: Vec<_> =
            self.lamps.iter().map(|lamp| shade::light_depth(self, lamp, rays, hits)).collect();
        shade::surface_radiance(self, rays, hits, &depths)
    }
}

fn numbers(material: &Material) -> [f32; 10] {
    let [d, s, e] = [material.diffuse.0, material.specular.0, material.emission.0];
    let all = [d[0], d[1], d[2], s[0], s[1], s[2], e[0], e[1], e[2], material.shininess];
    all.map(|v| v as f32)
}

/// What is made of so many tiles, unless the job ends: then the rest is `blank`, which lets every
/// tile be written at its place.
pub fn tiles<T: Clone + Send + Sync>(
    context: &Context,
    count: usize,
    blank: &T,
    work: impl Fn(usize) -> T + Sync + Send,
) -> Result<Vec<T>, Interrupted> {
    /// Tiles that one thread takes at once: inside its pool a job would be cut in a few pieces only,
    /// and threads would wait for the slowest.
    const AT_ONCE: usize = 8;
    let is_over = || context.progress.is_over();
    let tile = |index| if is_over() { blank.clone() } else { work(index) };
    let done = (0..count).into_par_iter().with_max_len(AT_ONCE).map(tile).collect();
    context.progress.check().map(|()| done)
}

fn first_hits(context: &Context) -> Result<Vec<Hits>, Interrupted> {
    let starts = std::array::from_fn(|row| row * TILE);
    let order = Order { starts, is_dense: true, shifts: [CENTER; 2] };
    let nothing = Hits::nothing(context.far_m);
    tiles(context, context.grid.count(), &nothing, |index| {
        let rays = context.viewpoint.tile(context.grid.tile(index), CENTER);
        context.trace(index, &[rays], &order).pop().unwrap_or_else(|| nothing.clone())
    })
}

/// For the published airlight: what lies between every blob and the lights and the eye.
///
/// # Errors
/// [`Interrupted`] when the job's progress says so.
pub fn light_sides(context: &Context, cache: &Cache) -> Result<Vec<LitBlobs>, Interrupted> {
    if context.method != Method::Fogshop2007 || !context.shows_airlight() {
        return Ok(Vec::new());
    }
    let (field, progress, eye) = (context.field, context.progress, context.viewpoint.eye());
    let to_eye = centers::depths(context, |center| eye.facing(center))?;
    let side = |lamp: &Lamp| {
        let make = || centers::depths(context, |_| lamp.position);
        let to_light = cache.to_light(field, lamp.position, progress, make)?;
        progress.check()?;
        let side = LightSide::new(field, eye, lamp.position, &to_eye, &to_light);
        Ok(LitBlobs::new(context, lamp.position, side))
    };
    context.lamps.iter().map(side).collect()
}

/// For the mapped airlight: what lies between the lights and everything else.
///
/// # Errors
/// [`Interrupted`] when the job's progress says so.
pub fn fill_tables(context: &mut Context, cache: &Cache) -> Result<(), Interrupted> {
    if !context.is_mapped() || !mapped::tables_pay(context.field) {
        return Ok(());
    }
    let fineness = Fineness::of(context.lamps.len());
    let table = |lamp: &Lamp| {
        let make = || LightTable::new(context, lamp.position, fineness);
        cache.light_table(context.field, lamp.position, fineness, context.progress, make)
    };
    let tables = context.lamps.iter().map(table).collect::<Result<Vec<_>, _>>()?;
    for (lamp, table) in context.lamps.iter_mut().zip(tables) {
        lamp.table = table;
    }
    Ok(())
}

fn surfaces(
    context: &Context,
    hits: &[Hits],
    low: Option<&upsample::Low>,
) -> Result<Vec<Rows>, Interrupted> {
    if !context.shows_surfaces() {
        return Ok(Vec::new());
    }
    tiles(context, context.grid.count(), &[[0.0; SIZE]; 3], |index| {
        let rays = context.viewpoint.tile(context.grid.tile(index), CENTER);
        match low {
            Some(low) => {
                let depths = low.light_depths(context, index, &rays, &hits[index]);
                shade::surface_radiance(context, &rays, &hits[index], &depths)
            }
            None => context.shade(&rays, &hits[index]),
        }
    })
}

/// What fog does to a block of tiles.
struct Fog {
    /// Tile by tile, if the layer shows it.
    along_views: Vec<Fogged>,
    /// The edge pixels of some tiles, by the tile's place.
    edges: Vec<(usize, edges::Resolved)>,
}

/// Tiles whose fog is formed together: what is interpolated across the picture serves them all.
fn blocks(context: &Context) -> Vec<Vec<usize>> {
    // What a draft interpolates reaches farther.
    let across = if context.view.quality == Quality::Draft { 4 } else { 2 };
    context.grid.blocks(across)
}

/// The fog of each block, for its pixels and the samples of its edges.
fn fog(
    context: &Context,
    hits: &[Hits],
    low: Option<&upsample::Low>,
    blocks: &[Vec<usize>],
) -> Vec<Fog> {
    let edges = context.view.samples.is_some_and(|samples| samples > 1);
    if !context.shows_fog() && !edges {
        return Vec::new();
    }
    let tiles = if context.shows_fog() { context.grid.count() } else { 0 };
    context.progress.start(tiles, 1.0);
    // One by one, because some take ten times as long as others.
    blocks.par_iter().with_max_len(1).map(|block| fog_of(context, hits, low, block)).collect()
}

/// The fog of each tile; of none if the layer shows no fog.
fn by_tile<'a>(context: &Context, blocks: &[Vec<usize>], fog: &'a [Fog]) -> Vec<&'a Fogged> {
    let tiles = blocks.iter().zip(fog).flat_map(|(block, fog)| block.iter().zip(&fog.along_views));
    let mut tiles: Vec<_> = tiles.collect();
    tiles.sort_unstable_by_key(|(index, _)| **index);
    debug_assert!(tiles.is_empty() || tiles.len() == context.grid.count());
    tiles.into_iter().map(|(_, fogged)| fogged).collect()
}

fn fog_of(context: &Context, hits: &[Hits], low: Option<&upsample::Low>, block: &[usize]) -> Fog {
    if context.progress.is_over() {
        return Fog { along_views: Vec::new(), edges: Vec::new() };
    }
    let rays = |index: &usize| context.viewpoint.tile(context.grid.tile(*index), CENTER);
    let rays: Vec<_> = block.iter().map(rays).collect();
    let samples: Vec<_> = block.iter().map(|index| Samples::new(context, hits, *index)).collect();
    // Tiles first, then the samples.
    let tiles = if context.shows_fog() { block.len() } else { 0 };
    let ends = |(index, rays): (&usize, _)| Ends { rays, hits: &hits[*index] };
    let mut ends: Vec<_> = block.iter().zip(&rays).take(tiles).map(ends).collect();
    ends.extend(samples.iter().flat_map(Samples::ends));
    let fog = |(at, Ends { rays, hits }): (usize, &Ends)| {
        let fogged = match low {
            Some(low) if at < tiles => low.fog(context, block[at], rays, hits),
            _ => context.fog(rays, hits),
        };
        if at < tiles && !context.is_mapped() {
            context.progress.advance();
        }
        fogged
    };
    let mut along_views: Vec<_> = ends.iter().enumerate().map(fog).collect();
    if context.is_mapped() {
        mapped::add(context, &ends, &mut along_views);
        (0..tiles).for_each(|_| context.progress.advance());
    }
    let along_samples = along_views.split_off(tiles);
    let mut rest = along_samples.as_slice();
    let mut edges = Vec::new();
    for (index, samples) in block.iter().zip(&samples) {
        let (own, others) = rest.split_at(samples.ends().count());
        rest = others;
        if !own.is_empty() {
            edges.push((*index, samples.resolve(context, own)));
        }
    }
    Fog { along_views, edges }
}

/// Times passes, and stops between them.
struct Clock<'a> {
    progress: &'a Progress,
    since: Instant,
    laps: Vec<(&'static str, Duration)>,
}

impl<'a> Clock<'a> {
    fn start(progress: &'a Progress) -> Self {
        Self { progress, since: Instant::now(), laps: Vec::new() }
    }

    fn lap(&mut self, name: &'static str) -> Result<(), Interrupted> {
        self.lap_if(true, name)
    }

    fn lap_if(&mut self, ran: bool, name: &'static str) -> Result<(), Interrupted> {
        if ran {
            self.laps.push((name, self.since.elapsed()));
        }
        self.since = Instant::now();
        self.progress.check()
    }
}

/// Whether a place of a batch sees no surface.
pub fn is_nothing(hits: &Hits, at: usize) -> bool {
    hits.surface[at] == NOTHING
}

/// One row of zeros for each light.
pub fn rows_for_lamps(context: &Context) -> Vec<Row> {
    vec![[0.0; SIZE]; context.lamps.len()]
}
