//! The GPU backend: the passes in WGSL, on whatever Vulkan adapter there is.
//!
//! Its pictures mean what the CPU's mean: the same rays, the same first hits, the same maths, in
//! f32. What it has no pass for is the CPU's: [`Gpu::render`] says so before anything is sent.

mod buffers;
pub mod compose;
pub mod device;
mod frame;
mod layout;
mod pipelines;
mod staging;
mod timer;

#[cfg(test)]
mod tests;

pub use device::{Failure, Wanted};

use crate::airlight::Method;
use crate::cpu::cache::Cache;
use crate::cpu::edges;
use crate::cpu::frame::{CENTER, Context, fill_tables, light_sides};
use crate::cpu::mapped::LightTable;
use crate::geometry::Geometry;
use crate::renderer::{Frame, Progress};
use crate::request::View;
use crate::scene::CheckedScene;
use buffers::{Kept, Lists, Table, Triangles};
use device::Device;
use pipelines::Pipelines;
use staging::Staging;
use std::time::{Duration, Instant};

/// How blobs along view rays are summed up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlobPass {
    /// As bounding quads that the blending unit adds up.
    Quads,
    /// By lists, tile by tile, in compute shaders.
    Tiles,
}

/// Geometries whose triangles stay on a device.
const GEOMETRIES: usize = 2;
/// Tables of lights that stay there: of a frame with the most lights, or of several with few.
const TABLES: usize = 64;

/// A device and all that is kept on it.
#[derive(Debug)]
pub struct Gpu {
    device: Device,
    pipelines: Pipelines,
    staging: Staging,
    triangles: Kept<Geometry, Triangles>,
    tables: Kept<Option<LightTable>, Option<Table>>,
    blob_pass: BlobPass,
    /// Whether it forms the mapped airlight.
    maps: bool,
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
        // A tile's sum stays in registers, where every pixel of a quad is read and written in
        // memory: measured on a driver in software (docs/speed.md), expected of hardware.
        let blob_pass = BlobPass::Tiles;
        // A driver in software takes minutes for what the CPU's lanes do in a tenth of a second.
        let maps = device.is_hardware();
        Self {
            device,
            pipelines: Pipelines::default(),
            staging: Staging::default(),
            triangles: Kept::new(GEOMETRIES),
            tables: Kept::new(TABLES),
            blob_pass,
            maps,
        }
    }

    /// Sums up blobs in another way than the adapter suggests.
    #[must_use]
    pub fn with_blob_pass(self, blob_pass: BlobPass) -> Self {
        Self { blob_pass, ..self }
    }

    /// Forms the mapped airlight, whatever the adapter.
    #[must_use]
    pub fn with_mapped(self) -> Self {
        Self { maps: true, ..self }
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
    fn takes(&self, context: &Context) -> bool {
        let has_pass = match context.method {
            Method::None | Method::Sun2005 | Method::Fogshop2007 => true,
            Method::Mapped => self.maps,
            Method::Reference | Method::March(_) => false,
        };
        has_pass || !context.shows_airlight()
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
        let begun = Instant::now();
        let (geometry, field) = (cache.geometry(scene), cache.field(scene));
        let mut context = Context::new(scene, &geometry, &field, view, progress);
        if !self.takes(&context) {
            return Ok(None);
        }
        context.lit_blobs = light_sides(&context, cache, scene);
        if self.maps {
            fill_tables(&mut context, cache, scene);
        }
        let make = || Triangles::new(&self.device, &geometry);
        let triangles = self.triangles.get(&geometry, make)?;
        let lists = Lists::new(&self.device, &context)?;
        let mut timings = vec![("prepare", begun.elapsed())];
        let shifts = match view.samples {
            Some(samples) if samples > 1 => edges::shifts(samples as usize),
            _ => vec![CENTER],
        };
        let mut mean = Mean::new(&context);
        for (i, shift) in shifts.iter().enumerate() {
            if progress.is_over() {
                return Err(Failure::Interrupted);
            }
            let finds_edges = shifts.len() > 1 && i == 0;
            let (pixels, times) =
                frame::render(self, &context, &triangles, &lists, *shift, finds_edges)?;
            mean.add(&context, &pixels, i == 0);
            times.into_iter().for_each(|(name, time)| add(&mut timings, name, time));
        }
        let (width, height) = (context.grid.width, context.grid.height);
        let pixels = mean.pixels();
        Ok(Some(Frame { width, height, layer: view.layer, pixels, timings, backend: "gpu" }))
    }

    /// Leaves a device that failed.
    pub fn abandon(self) {
        self.device.abandon();
    }
}

fn add(timings: &mut Vec<(&'static str, Duration)>, name: &'static str, time: Duration) {
    match timings.iter_mut().find(|(known, _)| *known == name) {
        Some((_, sum)) => *sum += time,
        None => timings.push((name, time)),
    }
}

/// The weighted mean of samples, pixel by pixel; but of the first alone where no edge is.
struct Mean {
    sums: Vec<f32>,
    weights: Vec<f32>,
    edges: Vec<bool>,
    channels: usize,
}

impl Mean {
    fn new(context: &Context) -> Self {
        let (pixels, channels) =
            (context.grid.width * context.grid.height, context.view.layer.channels());
        Self {
            sums: vec![0.0; pixels * channels],
            weights: vec![0.0; pixels],
            edges: vec![true; pixels],
            channels,
        }
    }

    fn add(&mut self, context: &Context, pixels: &[f32], is_first: bool) {
        let sums = self.sums.chunks_exact_mut(self.channels);
        let all = sums.zip(&mut self.weights).zip(&mut self.edges).zip(pixels.chunks_exact(4));
        for (((sum, weights), edge), pixel) in all {
            if !*edge {
                continue;
            }
            *edge = !is_first || pixel[3] > 0.0;
            let weight = edges::weight(context, [pixel[0], pixel[1], pixel[2]]);
            *weights += weight;
            sum.iter_mut().zip(pixel).for_each(|(sum, value)| *sum += weight * value);
        }
    }

    fn pixels(mut self) -> Vec<f32> {
        for (sum, weight) in self.sums.chunks_exact_mut(self.channels).zip(&self.weights) {
            sum.iter_mut().for_each(|value| *value /= weight);
        }
        self.sums
    }
}
