//! What a frame's passes read, brought to the device: the scene's lists relative to the camera, and
//! its triangles. All are kept while what they are made from stays the same.

use super::casters::{Casters, Rows};
use super::compose::NUMBERS_BINDING;
use super::device::{Buffer, Device, Failure};
use super::layout::{
    self, Anchor, Bend, Blob, Extent, Lamp, Material, Scatter, Shape, Smooth, Triangle, View,
};
use super::skies::{Backdrops, KeptNumbers, SkyTables};
use crate::airlight::fogshop2007::Eye;
use crate::airlight::{Method, sun2005};
use crate::frame::cache::Cache;
use crate::frame::context::Context;
use crate::frame::light_table::LightTable;
use crate::frame::lights::light_sides;
use crate::frame::samples::{self, CENTER};
use crate::frame::shafts::Shafts;
use crate::frame::tolerance::Fineness;
use crate::frame::viewpoint::Grid;
use crate::geometry::{Beyond, Origin};
use crate::kept::{Kept, Most, Same};
use crate::light::{Source, sun};
use crate::media::gaussians::Gaussian;
use crate::media::noise;
use crate::media::{Field, Media, PICTURE_LOSS, Words};
use crate::phase::PhaseFunction;
use crate::shapes::Geometry;
use crate::sky::Radiance;
use glam::{DVec2, DVec3, Vec2, Vec3, Vec4};
use std::sync::Arc;
use wgpu::{BindingResource, BufferUsages};

/// Depth at which triangles are cut off in front of the camera [m].
const CUT_OFF: f32 = 1e-5;
/// The number of the binding that `fogbank::grid::light_table` has for its samples.
const SAMPLES_BINDING: u32 = 16;
/// Optical depth that airlight on the grid may lose of all blobs together.
const TAILS: f64 = 1e-7;

/// Triangles of a scene's meshes and heightfields.
#[derive(Debug)]
pub struct Triangles {
    /// The triangles.
    pub corners: Buffer,
    /// Normals of the smooth ones.
    pub normals: Buffer,
    /// How many.
    pub count: u32,
}

/// The tables of all lights on the device.
#[derive(Debug)]
pub struct Tables {
    /// What each covers.
    pub extents: Buffer,
    /// Their samples, one table after the other.
    pub samples: Buffer,
}

impl Tables {
    /// Of a frame's lamps, some of which may have none.
    ///
    /// # Errors
    /// Where there is no memory for them.
    pub fn new(device: &Device, context: &Context) -> Result<Self, Failure> {
        let tables = || context.lamps.iter().map(|lamp| lamp.table.as_ref().as_ref());
        let mut begin = 0;
        let extent = |table: Option<&LightTable>| {
            let Some(table) = table else { return Extent::default() };
            let [across, down, toward] = table.axes().map(|axis| axis.as_vec3());
            let [first, density, side, shells] = table.scale();
            let reach = table.reach();
            let own = begin as u32;
            begin += table.values().len();
            Extent {
                across,
                reach,
                down,
                first,
                toward,
                density,
                side,
                shells,
                begin: own,
                parallel: u32::from(table.is_parallel()),
            }
        };
        let extents = layout::list(tables().map(extent).collect());
        let samples = device.joined(tables().flatten().map(LightTable::values))?;
        Ok(Self { extents: device.filled(&extents, BufferUsages::STORAGE)?, samples })
    }

    /// Both, the extents under a number of the pass.
    pub fn entries(&self, extents: u32) -> [(u32, BindingResource<'_>); 2] {
        [(extents, &self.extents), (SAMPLES_BINDING, &self.samples)]
            .map(|(binding, buffer)| (binding, buffer.handle.as_entire_binding()))
    }
}

impl Triangles {
    /// The triangles of a geometry.
    ///
    /// # Errors
    /// Where there is no memory for them.
    pub fn new(device: &Device, geometry: &Geometry) -> Result<Self, Failure> {
        let corners = geometry.triangles.iter().map(|triangle| {
            let [a, b, c] = triangle.corners;
            Triangle { a, surface: triangle.surface, b, normals: triangle.smooth, c }
        });
        let normals = geometry.smooth.iter().map(|normals| {
            let [a, b, c] = *normals;
            Smooth { a, b, c }
        });
        let list = |bytes: Vec<u8>| device.filled(&bytes, BufferUsages::STORAGE);
        Ok(Self {
            corners: list(layout::list(corners.collect()))?,
            normals: list(layout::list(normals.collect()))?,
            count: geometry.triangles.len() as u32,
        })
    }
}

/// Planes, spheres and boxes.
#[derive(Debug)]
pub struct Shapes {
    /// The list.
    pub list: Buffer,
    /// How many.
    pub count: u32,
}

/// What the published airlight knows of the lamps.
#[derive(Debug)]
pub struct Lit {
    /// What each light does to each blob.
    list: Buffer,
    /// Share of each light's homogeneous part that the blobs let through.
    shares: Vec<f32>,
}

/// A fog as it is seen from a place.
type Seen = (Same<Field>, DVec3);

/// Lists of pictures that clients go to and fro between. Each is counted among the device's bytes.
const LISTS: Most = Most { entries: 8, bytes: usize::MAX };

/// Rows of what hides lamps: a moved camera has others.
const ROWS: Most = Most { entries: 2, bytes: usize::MAX };

/// What a device keeps from frame to frame, by what it is made from: while the camera rests nothing but
/// the lamps' colours is uploaded, and under a moving one what does not depend on it stays.
#[derive(Debug)]
pub struct KeptLists {
    shapes: Kept<(Same<Geometry>, DVec3), Shapes>,
    materials: Kept<(Same<Geometry>, [f32; 10]), Buffer>,
    haze: Kept<Seen, Vec<Buffer>>,
    blobs: Kept<(Seen, bool), Buffer>,
    lit: Kept<(Same<Field>, Eye, Vec<Source>), Lit>,
    tables: Kept<Vec<Same<Option<LightTable>>>, Tables>,
    phases: Kept<Vec<PhaseFunction>, Buffer>,
    casters: Kept<Same<Geometry>, Casters>,
    rows: Kept<Vec<Option<Same<Shafts>>>, Rows>,
    /// Numbers of their tables.
    skies: KeptNumbers,
    backdrops: Kept<Vec<Radiance>, Backdrops>,
}

impl Default for KeptLists {
    fn default() -> Self {
        Self {
            shapes: Kept::new(LISTS, |_, _| 0),
            materials: Kept::new(LISTS, |_, _| 0),
            haze: Kept::new(LISTS, |_, _| 0),
            blobs: Kept::new(LISTS, |_, _| 0),
            lit: Kept::new(LISTS, |_, _| 0),
            tables: Kept::new(LISTS, |_, _| 0),
            phases: Kept::new(LISTS, |_, _| 0),
            casters: Kept::new(LISTS, |_, _| 0),
            rows: Kept::new(ROWS, |_, _| 0),
            skies: Kept::new(LISTS, |_, _| 0),
            backdrops: Kept::new(ROWS, |_, _| 0),
        }
    }
}

impl KeptLists {
    /// Lets go of all.
    pub fn clear(&self) {
        self.shapes.clear();
        self.materials.clear();
        self.haze.clear();
        self.blobs.clear();
        self.lit.clear();
        self.tables.clear();
        self.phases.clear();
        self.casters.clear();
        self.rows.clear();
        self.skies.clear();
        self.backdrops.clear();
    }
}

/// The lists of one frame.
#[derive(Debug)]
pub struct Lists {
    /// Where triangles are relative to.
    pub anchor: Buffer,
    /// Planes, spheres and boxes.
    pub shapes: Arc<Shapes>,
    /// Lights.
    pub lamps: Buffer,
    /// What is scattered of them.
    pub scatters: Buffer,
    /// The media that stand in closed form, one list each.
    haze: Arc<Vec<Buffer>>,
    /// Gaussians.
    pub blobs: Arc<Buffer>,
    /// For the published airlight.
    lit: Arc<Lit>,
    /// Materials, the background behind them.
    pub materials: Arc<Buffer>,
    /// What bends view rays, where there is noise.
    pub noise: Option<Noise>,
    /// What the grid reads, in pictures that it serves.
    pub on_grid: Option<OnGrid>,
    /// What surfaces hide of the lamps from view rays, if anything.
    pub rows: Option<Arc<Rows>>,
    /// What throws shadows on surfaces, if anything does, and how much of it there is.
    pub casters: Option<(Arc<Casters>, Buffer)>,
    /// Light of skies that surfaces get, and skies themselves, if there are any.
    pub skies: Option<(SkyTables, Arc<Backdrops>)>,
}

/// What bends view rays before blobs.
#[derive(Debug)]
pub struct Noise {
    /// Its numbers.
    pub bend: Buffer,
    /// Three gradients a place of its lattice.
    pub gradients: Buffer,
}

impl Noise {
    fn new(device: &Device, noise: &noise::Bend, camera: DVec3) -> Result<Self, Failure> {
        let [strength, rate] = noise.scale().map(|v| v as f32);
        let moved = noise.in_lattice(camera).as_vec3();
        let bend = Bend { moved, rate, strength, reach: noise.reach() as f32 };
        let gradients = noise.gradients().iter().flatten().map(|own| own.as_vec3().extend(0.0));
        let gradients = layout::list(gradients.collect());
        Ok(Self {
            bend: device.filled(&layout::one(&bend), BufferUsages::UNIFORM)?,
            gradients: device.filled(&gradients, BufferUsages::STORAGE)?,
        })
    }
}

/// What airlight on the grid reads.
#[derive(Debug)]
pub struct OnGrid {
    /// The lamps' tables.
    pub tables: Arc<Tables>,
    /// The phase functions of all groups, tabulated.
    pub phases: Arc<Buffer>,
    /// What surfaces hide of the lamps.
    pub rows: Arc<Rows>,
    /// What is left of skies.
    pub skies: SkyTables,
    /// How fine it is.
    pub fineness: Fineness,
}

impl OnGrid {
    fn new(device: &Device, kept: &KeptLists, context: &Context) -> Result<Self, Failure> {
        let progress = context.job.progress;
        let lamps: Vec<_> = context.lamps.iter().map(|lamp| Same::new(&lamp.table)).collect();
        let phases = phases(context);
        let tabulated = || device.filled(&layout::list(tabulated(&phases)), BufferUsages::STORAGE);
        Ok(Self {
            tables: kept.tables.get(&lamps, progress, || Tables::new(device, context))?,
            phases: kept.phases.get(&phases, progress, tabulated)?,
            rows: of_lamps(device, kept, context)?,
            skies: SkyTables::of_fog(device, &kept.skies, context)?,
            fineness: Fineness::of(&context.view, context.field),
        })
    }
}

impl Lists {
    /// Of a frame.
    ///
    /// # Errors
    /// Where there is no memory for them, or the job ends.
    pub fn new(
        device: &Device,
        kept: &KeptLists,
        context: &Context,
        (cache, geometry): (&Cache, &Arc<Geometry>),
    ) -> Result<Self, Failure> {
        let progress = context.job.progress;
        let list = |bytes: Vec<u8>| device.filled(&bytes, BufferUsages::STORAGE);
        let position = context.viewpoint.position;
        let shift = (context.geometry.anchor - position).as_vec3();
        let on_scene = (Same::new(geometry), position);
        let shapes = || -> Result<_, Failure> {
            let shapes = shapes(context.geometry, position);
            Ok(Shapes { count: shapes.len() as u32, list: list(layout::list(shapes))? })
        };
        let of_scene = (Same::new(geometry), context.background);
        let seen = (Same::new(context.field), position);
        let haze = || haze(context).into_iter().map(list).collect();
        let is_mapped = context.method == Method::Auto;
        let lit = lit(device, kept, context, cache)?;
        let noise = context.noise.as_ref().map(|noise| Noise::new(device, noise, position));
        let on_grid = || OnGrid::new(device, kept, context);
        Ok(Self {
            anchor: device.filled(&layout::one(&Anchor { shift }), BufferUsages::UNIFORM)?,
            shapes: kept.shapes.get(&on_scene, progress, shapes)?,
            lamps: list(layout::list(lamps(context)))?,
            scatters: list(layout::list(scatters(context, &lit.shares)))?,
            haze: kept.haze.get(&seen, progress, haze)?,
            blobs: kept
                .blobs
                .get(&(seen, is_mapped), progress, || list(layout::list(blobs(context))))?,
            lit,
            materials: kept
                .materials
                .get(&of_scene, progress, || list(layout::list(materials(context))))?,
            noise: noise.transpose()?,
            on_grid: context.interpolates().then(on_grid).transpose()?,
            rows: rows(device, kept, context)?,
            casters: casters(device, kept, context)?,
            skies: skies(device, kept, context)?,
        })
    }

    /// What `fogbank::haze` reads, under its numbers.
    pub fn haze(&self) -> impl Iterator<Item = (u32, BindingResource<'_>)> {
        (NUMBERS_BINDING..)
            .zip(self.haze.iter())
            .map(|(binding, list)| (binding, list.handle.as_entire_binding()))
    }

    /// For the published airlight: what each light does to each blob.
    pub fn lit(&self) -> &Buffer {
        &self.lit.list
    }
}

/// The rows of all lamps.
fn of_lamps(device: &Device, kept: &KeptLists, context: &Context) -> Result<Arc<Rows>, Failure> {
    let shafts = context.lamps.iter().map(|lamp| lamp.shafts.as_ref().map(Same::new));
    let shafts: Vec<_> = shafts.collect();
    kept.rows.get(&shafts, context.job.progress, || Rows::new(device, context))
}

/// The same where some lamp has any.
fn rows(
    device: &Device,
    kept: &KeptLists,
    context: &Context,
) -> Result<Option<Arc<Rows>>, Failure> {
    let has_any = context.lamps.iter().any(|lamp| lamp.shafts.is_some());
    has_any.then(|| of_lamps(device, kept, context)).transpose()
}

/// What throws shadows on surfaces that are shown.
fn casters(
    device: &Device,
    kept: &KeptLists,
    context: &Context,
) -> Result<Option<(Arc<Casters>, Buffer)>, Failure> {
    let is_shaded = context.lamps.iter().any(|lamp| lamp.is_shaded);
    if !is_shaded || !context.shows_surfaces() {
        return Ok(None);
    }
    let key = Same::new(context.geometry);
    let make = || Casters::new(device, context.geometry);
    let casters = kept.casters.get(&key, context.job.progress, make)?;
    let counts = casters.counts(device, context)?;
    Ok(Some((casters, counts)))
}

/// Skies as surfaces see them, and as they stand behind those.
fn skies(
    device: &Device,
    kept: &KeptLists,
    context: &Context,
) -> Result<Option<(SkyTables, Arc<Backdrops>)>, Failure> {
    if context.skies.is_empty() || !context.shows_surfaces() {
        return Ok(None);
    }
    let tables = if context.is_clear {
        SkyTables::clear(device, context)
    } else {
        SkyTables::of_fog(device, &kept.skies, context)
    };
    let key: Vec<_> = context.skies.iter().map(|sky| sky.radiance.clone()).collect();
    let make = || Backdrops::new(device, context);
    Ok(Some((tables?, kept.backdrops.get(&key, context.job.progress, make)?)))
}

/// For the published airlight; empty for all others.
fn lit(
    device: &Device,
    kept: &KeptLists,
    context: &Context,
    cache: &Cache,
) -> Result<Arc<Lit>, Failure> {
    let sources = context.lamps.iter().map(|lamp| lamp.source).collect();
    let is_lit = context.method == Method::Fogshop2007 && context.shows_airlight();
    let sources = if is_lit { sources } else { Vec::new() };
    let key = (Same::new(context.field), context.viewpoint.eye(), sources);
    kept.lit.get(&key, context.job.progress, || {
        let sides = light_sides(context, cache)?;
        let rows: Vec<Vec4> = sides.iter().flat_map(|lit| lit.rows()).collect();
        Ok(Lit {
            list: device.filled(&layout::list(rows), BufferUsages::STORAGE)?,
            shares: sides.iter().map(|lit| lit.homogeneous_factor as f32).collect(),
        })
    })
}

/// Where the light of every group goes; nothing is read of those that scatter none.
fn phases(context: &Context) -> Vec<PhaseFunction> {
    let of_group = |group: usize| {
        let own = context.scatters.iter().find(|scatter| scatter.group == group);
        own.map_or(PhaseFunction::ISOTROPIC, |own| own.phase)
    };
    (0..context.field.groups().len()).map(of_group).collect()
}

/// k and ∫ k dα of each, one after the other.
fn tabulated(phases: &[PhaseFunction]) -> Vec<Vec2> {
    let of_one = |phase: &PhaseFunction| {
        let [values, sums] = phase.tabulated();
        values.into_iter().zip(sums).map(|(value, sum)| Vec2::new(value, sum))
    };
    phases.iter().flat_map(of_one).collect()
}

/// The list of numbers that the media in closed form share; then rows of each, a list a medium: the groups one
/// after the other, the group behind each row.
fn haze(context: &Context) -> Vec<Vec<u8>> {
    let camera = context.viewpoint.position;
    let mut numbers = Vec::new();
    let groups = context.field.groups().iter();
    let by_group: Vec<_> = groups.map(|media| media.shaded(camera, &mut numbers)).collect();
    let list = |medium: usize| {
        let rows = by_group.iter().enumerate().flat_map(|(group, media)| {
            media[medium].rows.iter().map(move |row| (row, group as u32))
        });
        let bytes = |(row, group): (&Words, u32)| {
            let words = row.iter().flat_map(|four| four.to_array()).flat_map(f32::to_le_bytes);
            words.chain(group.to_le_bytes()).collect::<Vec<_>>()
        };
        rows.flat_map(bytes).collect()
    };
    [layout::list(numbers)].into_iter().chain((0..by_group[0].len()).map(list)).collect()
}

/// Planes, spheres and boxes relative to the camera.
fn shapes(geometry: &Geometry, position: DVec3) -> Vec<Shape> {
    let shift = geometry.anchor - position;
    let planes = geometry.planes.iter().map(|plane| {
        let height = plane.normal.dot(plane.point + shift) as f32;
        let first = plane.normal.as_vec3().extend(height);
        Shape { first, second: Vec4::ZERO, kind: 0, surface: plane.surface }
    });
    let place = |local: Vec3| local.as_dvec3() + shift;
    let spheres = geometry.spheres.iter().map(|sphere| {
        let center = place(sphere.center);
        let power = center.length_squared() - f64::from(sphere.radius).powi(2);
        Shape {
            first: center.as_vec3().extend(sphere.radius),
            second: Vec3::ZERO.extend(power as f32),
            kind: 1,
            surface: sphere.surface,
        }
    });
    let cuboids = geometry.cuboids.iter().map(|cuboid| Shape {
        first: place(cuboid.min).as_vec3().extend(0.0),
        second: place(cuboid.max).as_vec3().extend(0.0),
        kind: 2,
        surface: cuboid.surface,
    });
    planes.chain(spheres).chain(cuboids).collect()
}

fn lamps(context: &Context) -> Vec<Lamp> {
    let lamp = |lamp: &crate::frame::context::Lamp| {
        let strength = lamp.strength.as_vec3();
        let is_shaded = u32::from(lamp.is_shaded);
        let everywhere = Lamp { strength, is_shaded, ..Lamp::default() };
        let everywhere = lamp.of_sky.map_or(everywhere, |own| Lamp {
            sky: own.sky as u32 + 1,
            channel: own.place as u32,
            sky_g: own.phase.g as f32,
            log_most: own.most.ln() as f32,
            ..everywhere
        });
        let cone = lamp.source.beam().map_or(everywhere, |beam| Lamp {
            axis: beam.axis.as_vec3(),
            inner: beam.inner as f32,
            outer: beam.outer as f32,
            ..everywhere
        });
        match lamp.from_camera.origin() {
            Origin::At(apex) => {
                let (position, distance_m) = (apex.as_vec3(), apex.length() as f32);
                Lamp { position, distance_m, ..cone }
            }
            Origin::Beyond(Beyond { toward, path_m }) => {
                let table = lamp.table.as_ref().as_ref().map(LightTable::apex);
                let position = table.map_or(DVec3::ZERO, |apex| apex - context.viewpoint.position);
                let (toward, path_m) = (toward.as_vec3(), path_m as f32);
                let distance_m = sun::DISTANCE_M as f32;
                Lamp { position: position.as_vec3(), distance_m, path_m, toward, ..cone }
            }
        }
    };
    context.lamps.iter().map(lamp).collect()
}

/// `seen` is the share of each lamp's light that the blobs let through, if that is known.
fn scatters(context: &Context, seen: &[f32]) -> Vec<Scatter> {
    let share = |lamp: usize, group: usize| match context.method {
        Method::Sun2005 | Method::Macklin2010 => sun2005::share(context.field, group) as f32,
        _ => seen.get(lamp).copied().unwrap_or(1.0),
    };
    let scatter = |scatter: &crate::frame::context::Scatter| Scatter {
        colour: scatter.colour.as_vec3(),
        g: scatter.phase.g as f32,
        lamp: scatter.lamp as u32,
        group: scatter.group as u32,
        share: share(scatter.lamp, scatter.group),
    };
    context.scatters.iter().map(scatter).collect()
}

fn blobs(context: &Context) -> Vec<Blob> {
    // All that are left out weigh less than a picture may lose; where fog is nothing but the tails of
    // blobs, light is scattered by them.
    let all = if context.method == Method::Auto { TAILS } else { PICTURE_LOSS };
    let loss = all / context.field.lumps().max(1) as f64;
    let of_group = |(group, media): (usize, &Media)| {
        let blob = |blob: &Gaussian| Blob {
            place: ((blob.center - context.viewpoint.position) * blob.a).as_vec3(),
            a: blob.a as f32,
            half_depth: blob.half_depth() as f32,
            reach_m: blob.reach(loss) as f32,
            group: group as u32,
            is_slab: u32::from(blob.is_slab),
        };
        media.gaussians.all().iter().map(blob).collect::<Vec<_>>()
    };
    context.field.groups().iter().enumerate().flat_map(of_group).collect()
}

fn materials(context: &Context) -> Vec<Material> {
    let all = context.materials.iter().chain([&context.background]);
    let material = |m: &[f32; 10]| Material {
        diffuse: Vec3::new(m[0], m[1], m[2]),
        shininess: m[9],
        specular: Vec3::new(m[3], m[4], m[5]),
        emission: Vec3::new(m[6], m[7], m[8]),
    };
    all.map(material).collect()
}

/// The camera and the picture, its pixels sampled at a place within them; for targets of which a
/// pixel stands for `step` of the picture across and down.
pub fn view(context: &Context, sample: DVec2, targets: Grid, step: usize) -> View {
    let viewpoint = &context.viewpoint;
    let (right, up) = viewpoint.half_axes();
    let exposure = context.view.exposure_ev.exp2() as f32;
    let pixels = |grid: Grid| Vec2::new(grid.width as f32, grid.height as f32);
    View {
        forward: viewpoint.forward.as_vec3(),
        far_m: context.far_m,
        right: right.as_vec3(),
        sample_x: sample.x as f32,
        up: up.as_vec3(),
        sample_y: sample.y as f32,
        size: pixels(context.grid),
        targets: pixels(targets),
        ambient: Vec3::from(context.ambient),
        cut_off_m: CUT_OFF,
        weighing: if samples::weighs(&context.view) { exposure } else { 0.0 },
        exposure,
        parallel: u32::from(viewpoint.parallel),
        step: step as u32,
        blobs: context.field.lumps() as u32,
        scatters: context.scatters.len() as u32,
        opaque: context.view.options.opaque(),
        // Further samples soften for themselves.
        soft: u32::from(context.softens() && sample == CENTER),
    }
}
