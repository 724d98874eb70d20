//! The passes that outlive a frame. Each is a value that holds all that its output depends on and compares
//! equal exactly where that would be the same: large inputs by their address, the rest by value. What is
//! kept is found by it.
//!
//! Airlight and the depth towards surfaces are kept lamp by lamp, at unit intensity: a lamp that moves
//! recomputes its own, and a change of colour or exposure none. Lamps that share a grid share it in this,
//! too: if one moves, the light of all is made again.

use super::traced::Traced;
use crate::airlight::Method;
use crate::frame::context::{Context, Lamp};
use crate::frame::light_table::LightTable;
use crate::frame::skies::OfSky;
use crate::frame::sky_table::SkyTable;
use crate::frame::viewpoint::Grid;
use crate::geometry::batch::{Fogged, Row};
use crate::kept::{Kept, Most, Same};
use crate::light::Source;
use crate::media::noise::Bend;
use crate::media::{Field, Purpose};
use crate::phase::PhaseFunction;
use crate::request::{Options, Quality};
use crate::scene::Camera;
use crate::shapes::Geometry;
use crate::sky::Radiance;
use std::sync::Arc;

/// First hits, with the samples of edges.
#[derive(Clone, Debug, PartialEq)]
pub struct Tracing {
    pub geometry: Same<Geometry>,
    pub camera: Camera,
    pub grid: Grid,
    pub far_m: f64,
    /// Samples of a pixel at an edge.
    pub samples: u32,
    /// Whether triangles that are hit are told.
    pub tells_triangles: bool,
}

/// The fog along view rays: the light of one lamp that a group of its terms scatters, or what it takes away
/// alone.
#[derive(Clone, Debug, PartialEq)]
pub struct Fogging {
    traced: Same<Traced>,
    field: Same<Field>,
    noise: Option<Bend>,
    options: Options,
    /// What for: a picture ends where all is hidden, and who states T does not.
    purpose: Purpose,
    method: Method,
    /// The group, and where its light goes.
    group: Option<(usize, PhaseFunction)>,
    quality: Quality,
    for_screen: bool,
    is_hasty: bool,
    lamp: Option<Light>,
    /// Lamps around whose images a draft computes all pixels.
    glows: Vec<Source>,
    /// Lamps whose light is tabulated on the same grid.
    together: Vec<Light>,
}

/// What lies between a lamp and the surfaces.
#[derive(Clone, Debug, PartialEq)]
pub struct Shading {
    traced: Same<Traced>,
    field: Same<Field>,
    /// Pixels over which it is carried from one to the next.
    step: usize,
    is_clear: bool,
    /// Whether the rims of shadows are looked at again.
    is_fine: bool,
    lamp: Light,
}

/// A lamp as its fog sees it: no matter how bright.
#[derive(Clone, Debug, PartialEq)]
struct Light {
    source: Source,
    /// Whether surfaces hide it: which ones do follows from the rays.
    is_shaded: bool,
    table: Option<Same<Option<LightTable>>>,
    sky: Option<UnderSky>,
}

/// A lamp that stands for a sky: how bright that is, what is left of it over space, and which channel by which phase
/// function it is.
type UnderSky = (Radiance, Same<Option<SkyTable>>, OfSky);

impl Light {
    fn new(context: &Context, lamp: &Lamp) -> Self {
        let table = lamp.table.is_some().then(|| Same::new(&lamp.table));
        let sky = lamp.of_sky.map(|own| {
            let sky = &context.skies[own.sky];
            (sky.radiance.clone(), Same::new(&sky.table), own)
        });
        Self { source: lamp.source, is_shaded: lamp.is_shaded, table, sky }
    }
}

impl Fogging {
    /// Of a frame's rays and what is scattered of one lamp, by its place.
    pub fn new(context: &Context, traced: &Arc<Traced>, scatter: Option<usize>) -> Self {
        let sources = context.lamps.iter().map(|lamp| lamp.source);
        let of = |i: usize| &context.scatters[i];
        let light = |i: usize| Light::new(context, &context.lamps[of(i).lamp]);
        let together = if context.has_grid() { context.lamps.as_slice() } else { &[] };
        Self {
            traced: Same::new(traced),
            field: Same::new(context.field),
            noise: context.noise.clone(),
            options: context.view.options,
            purpose: context.purpose(),
            method: if context.shows_airlight() { context.method } else { Method::None },
            group: scatter.map(|i| (of(i).group, of(i).phase)),
            quality: context.view.quality,
            for_screen: context.view.for_screen,
            is_hasty: context.view.is_hasty,
            lamp: scatter.map(light),
            glows: if context.is_low() { sources.collect() } else { Vec::new() },
            together: together.iter().map(|lamp| Light::new(context, lamp)).collect(),
        }
    }
}

impl Shading {
    /// Of a frame's surfaces and one of its lamps, by its place.
    pub fn new(context: &Context, traced: &Arc<Traced>, lamp: usize) -> Self {
        let lamp = &context.lamps[lamp];
        let mut light = Light::new(context, lamp);
        light.table = light.table.filter(|_| context.looks_up_lights());
        let (traced, field) = (Same::new(traced), Same::new(context.field));
        let step = if context.is_low() { context.step() } else { 1 };
        let (is_clear, is_fine) = (context.is_clear, context.softens());
        Self { traced, field, step, is_clear, is_fine, lamp: light }
    }
}

/// What the fog does along all batches of a frame, tile by tile; as one run made it for what is scattered of
/// some lamps.
pub type Fog = Vec<Vec<Fogged>>;
/// Depths from some lamps to all batches of a frame, tile by tile, batch by batch, lamp by lamp.
pub type Depths = Vec<Vec<Vec<Row>>>;

/// One lamp's share of a run.
#[derive(Debug)]
pub struct Share<T> {
    /// What the run made.
    pub run: Arc<T>,
    /// The lamp's place in it.
    pub slot: usize,
    /// Bytes of the share.
    bytes: usize,
}

impl<T> Share<T> {
    /// A part of a run of so many bytes a lamp.
    pub fn new(run: &Arc<T>, slot: usize, bytes: usize) -> Self {
        Self { run: Arc::clone(run), slot, bytes }
    }
}

/// Pictures whose first hits are kept.
const PICTURES: Most = Most { entries: 2, bytes: 128 << 20 };
/// Light and depths by lamp: of two pictures at rest with many lamps. A dragged lamp leaves some behind at
/// every place.
const BY_LAMP: Most = Most { entries: 160, bytes: 128 << 20 };

/// What the CPU's passes keep.
#[derive(Debug)]
pub struct Passes {
    /// First hits.
    pub traced: Kept<Tracing, Traced>,
    /// Fog along view rays.
    pub fog: Kept<Fogging, Share<Fog>>,
    /// Depths from lamps to surfaces.
    pub depths: Kept<Shading, Share<Depths>>,
}

impl Passes {
    /// Lets go of what belongs to pictures that are not kept any more: under a moving camera its memory
    /// serves the next frame.
    pub fn forget_old_pictures(&self) {
        self.fog.forget(|fogging| fogging.traced.is_gone());
        self.depths.forget(|shading| shading.traced.is_gone());
    }
}

impl Default for Passes {
    fn default() -> Self {
        Self {
            traced: Kept::new(PICTURES, |_, traced| traced.bytes()),
            fog: Kept::new(BY_LAMP, |_, share| share.bytes),
            depths: Kept::new(BY_LAMP, |_, share| share.bytes),
        }
    }
}
