//! The GPU backend: the passes in WGSL, on whatever Vulkan adapter there is.
//!
//! Its pictures mean what the CPU's mean: the same rays, the same first hits, the same maths, in
//! f32. What it has no pass for is the CPU's: [`Gpu::render`] says so before anything is sent.

mod buffers;
mod casters;
pub mod compose;
pub mod device;
mod frame;
mod layout;
mod passes;
mod pipelines;
mod skies;
mod staging;
mod timer;

#[cfg(test)]
mod tests;

pub use device::{Failure, Wanted};

use crate::airlight::Method;
use crate::frame::cache::Cache;
use crate::frame::context::{Context, DRAFT_STEP};
use crate::frame::lights::{cast, fill_skies, fill_tables};
use crate::frame::skies::Sky;
use crate::frame::{Frame, Lap};
use crate::kept::{Kept, Most, Same};
use crate::progress::Progress;
use crate::request::{Quality, View};
use crate::scene::CheckedScene;
use crate::shapes::Geometry;
use buffers::{KeptLists, Lists, Triangles};
use compose::Pass;
use device::Device;
use frame::Picture;
use pipelines::Pipelines;
use staging::Staging;
use std::sync::Arc;
use std::time::Instant;
use timer::Times;

/// Blobs that are summed up towards a light without a table at each place. More take a device longer than it is
/// waited for.
const MOST_UNTABLED: usize = 1024;
/// Geometries whose triangles stay on a device, which itself counts bytes.
const GEOMETRIES: Most = Most { entries: 2, bytes: usize::MAX };

/// A device and all that is kept on it.
#[derive(Debug)]
pub struct Gpu {
    device: Device,
    pipelines: Pipelines,
    staging: Staging,
    triangles: Kept<Same<Geometry>, Triangles>,
    lists: KeptLists,
}

impl Gpu {
    /// Opens the best adapter that will do.
    ///
    /// # Errors
    /// Where there is none.
    pub fn open(wanted: Wanted) -> Result<Self, Failure> {
        Device::open(wanted).map(Self::new)
    }

    /// Opens an adapter of [`device::adapters`].
    ///
    /// # Errors
    /// Where it does not have what the passes need.
    pub fn of(adapter: &wgpu::Adapter) -> Result<Self, Failure> {
        Device::of(adapter).map(Self::new)
    }

    fn new(device: Device) -> Self {
        Self {
            device,
            pipelines: Pipelines::default(),
            staging: Staging::default(),
            triangles: Kept::new(GEOMETRIES, |_, _| 0),
            lists: KeptLists::default(),
        }
    }

    /// Makes the pipelines that usual frames need, before they do.
    ///
    /// # Errors
    /// Where the device does not take one.
    pub fn warm_up(&self) -> Result<(), Failure> {
        let usual = compose::compositions().into_iter().filter(|key| {
            // Other layers and media are put together on first use.
            let is_usual = key.pass != Pass::Composite || key.defines.contains(&"LAYER_BEAUTY");
            is_usual && key.media() < 2
        });
        usual.map(|key| self.pipelines.get(&self.device, &key)).try_for_each(|made| made.map(drop))
    }

    /// The adapter's name.
    pub fn name(&self) -> &str {
        &self.device.info.name
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        self.device.bytes()
    }

    /// Ends the device's life, as drivers do; for tests.
    pub fn destroy(&self) {
        self.device.handle.destroy();
    }

    /// Whether there is a pass for the airlight that is asked for; what is not shown needs none.
    fn takes(context: &Context) -> bool {
        // Published answers for skies are the CPU's.
        let is_published = context.asked != Method::Auto && !context.skies.is_empty();
        let has_pass = match context.method {
            _ if is_published => false,
            Method::None | Method::Sun2005 | Method::Fogshop2007 | Method::Macklin2010 => true,
            // Numbers are the CPU's.
            Method::Auto => context.is_for_the_eye() || context.scatters.is_empty(),
            Method::Reference | Method::March(_) => false,
        };
        // One dispatch bends rays before all blobs.
        let bends_too_many =
            context.noise.is_some() && context.field.lumps() > frame::BLOBS_A_DISPATCH as usize;
        // Fog at corners or for some pixels is the CPU's, but for that of drafts.
        let is_draft = context.view.quality == Quality::Draft && context.step() == DRAFT_STEP;
        (!context.is_low() || is_draft)
            && !context.is_per_vertex()
            && !bends_too_many
            && (has_pass || !context.shows_airlight())
    }

    /// Renders one layer; `None` if there is no pass for it.
    ///
    /// # Errors
    /// Where the device fails, or `progress` says so.
    pub fn render(
        &self,
        cache: &Cache,
        scene: &CheckedScene,
        view: &View,
        progress: &Progress,
    ) -> Result<Option<Frame>, Failure> {
        let geometry = cache.geometry(scene, progress)?;
        let octaves = view.octaves(&scene.fog);
        let fields = octaves.iter().map(|own| cache.seen_bands(scene, *own, view, progress));
        let fields = fields.collect::<Result<Vec<_>, _>>()?;
        let count = fields[0].each().len();
        let contexts = count * octaves.len();
        let mut bands = Vec::new();
        for band in 0..count {
            let mut sum = None;
            for (octave, fields) in octaves.iter().zip(&fields) {
                let field = (&fields.each()[band], *octave, (count > 1).then_some(band));
                let context = Context::new(scene, &geometry, field, view, progress);
                let Some(own) = self.part(cache, context, &geometry, contexts)? else {
                    return Ok(None);
                };
                sum = Some(own.behind(sum));
            }
            bands.extend(sum);
        }
        let channels = view.layer.channels(bands.len());
        let parts = bands.into_iter().map(|Part { picture, laps }| (picture, laps));
        let (pictures, timings): (Vec<_>, Vec<_>) = parts.unzip();
        let timings = total(timings);
        let (pixels, shown) = match Picture::of_bands(pictures, view.layer) {
            Some(Picture::Screen(bytes)) => (Vec::new(), Some(bytes)),
            Some(Picture::Linear(pixels)) => (pixels, None),
            None => return Ok(None),
        };
        let (width, height) = (view.width as usize, view.height as usize);
        let (layer, camera, backend) = (view.layer, scene.camera.clone(), "gpu");
        Ok(Some(Frame { width, height, channels, layer, camera, pixels, shown, timings, backend }))
    }

    /// One of so many parts of a picture; `None` if there is no pass for it.
    fn part(
        &self,
        cache: &Cache,
        mut context: Context,
        geometry: &Arc<Geometry>,
        contexts: usize,
    ) -> Result<Option<Part>, Failure> {
        let begun = Instant::now();
        if !Self::takes(&context) {
            return Ok(None);
        }
        fill_tables(&mut context, cache)?;
        fill_skies(&mut context, cache, contexts)?;
        cast(&mut context, cache)?;
        if sums_too_many(&context) {
            return Ok(None);
        }
        let mut laps = vec![Lap::new("prepare", begun.elapsed())];
        let is_whole = contexts == 1;
        let drawn = match self.draw(cache, &context, geometry, is_whole) {
            // What idles on the device makes room for what is asked for.
            Err(Failure::Memory(_)) => {
                self.forget();
                self.draw(cache, &context, geometry, is_whole)
            }
            drawn => drawn,
        };
        let (picture, times) = drawn?;
        laps.extend(times.into_iter().map(|(pass, took)| Lap::new(pass, took)));
        Ok(Some(Part { picture, laps }))
    }

    fn draw(
        &self,
        cache: &Cache,
        context: &Context,
        geometry: &Arc<Geometry>,
        is_whole: bool,
    ) -> Result<(Picture, Times), Failure> {
        let make = || Triangles::new(&self.device, geometry);
        let triangles = self.triangles.get(&Same::new(geometry), context.job.progress, make)?;
        let lists = Lists::new(&self.device, &self.lists, context, (cache, geometry))?;
        frame::render(self, (context, is_whole), &triangles, &lists)
    }

    /// Lets go of all that is kept between frames but the pipelines.
    fn forget(&self) {
        self.staging.clear();
        self.triangles.clear();
        self.lists.clear();
    }

    /// Leaves a device that failed.
    pub fn abandon(&self) {
        self.device.abandon();
    }
}

/// A picture in one band of colour and one octave of light, and what its passes took.
struct Part {
    picture: Picture,
    laps: Vec<Lap>,
}

impl Part {
    /// Behind the octaves before, if there are any.
    fn behind(mut self, before: Option<Self>) -> Self {
        let Some(mut sum) = before else { return self };
        sum.picture.add(&self.picture);
        sum.laps.append(&mut self.laps);
        sum
    }
}

/// What the passes of all bands took, pass by pass.
fn total(bands: Vec<Vec<Lap>>) -> Vec<Lap> {
    let mut laps: Vec<Lap> = Vec::new();
    for lap in bands.into_iter().flatten() {
        match laps.iter_mut().find(|own| own.pass == lap.pass) {
            Some(own) => own.took += lap.took,
            None => laps.push(lap),
        }
    }
    laps
}

/// Whether lights without a table have too many blobs around them, or a sky has none where it is looked up.
fn sums_too_many(context: &Context) -> bool {
    let has_none = context.direct().iter().any(|lamp| lamp.table.is_none());
    let is_untabled = |sky: &Sky| {
        let on_surfaces = context.shows_surfaces();
        let in_fog = context.interpolates() || on_surfaces && !context.is_clear;
        let is_lit = !sky.channels.is_empty();
        let is_clear = on_surfaces && context.is_clear;
        is_lit && (in_fog && sky.table.is_none() || is_clear && sky.clear.is_none())
    };
    context.interpolates() && has_none && context.field.lumps() > MOST_UNTABLED
        || context.skies.iter().any(is_untabled)
}
