//! One frame on the device, read top to bottom as a list of passes.

use super::Gpu;
use super::buffers::{self, Lists, Triangles};
use super::compose::{Composition, Pass, of_media};
use super::device::{Buffer, Failure, Stage, Texture};
use super::layout::{self, Span};
use super::pipelines::{DEPTH, Kind, LIGHT, NUMBER, Pipeline};
use super::timer::{Timer, Times};
use crate::frame::context::{Context, DRAFT_STEP};
use crate::frame::samples::{self, CENTER};
use crate::frame::viewpoint::Grid;
use crate::request::{Layer, Quality};
use glam::DVec2;
use std::ops::Range;
use std::sync::Arc;
use wgpu::{BindingResource, BufferUsages, LoadOp, StoreOp, SubmissionIndex};

/// Pixels along the side of a tile.
pub const TILE: u32 = 16;
/// Blobs of one dispatch: no loop of a shader comes near 65 535 turns, where drivers may end it.
pub const BLOBS_A_DISPATCH: u32 = 1 << 15;

/// What a frame shows.
#[derive(Debug)]
pub enum Picture {
    /// `[height][width][channels]`, as the layer has them.
    Linear(Vec<f32>),
    /// `[height][width][3]`, for a screen.
    Screen(Vec<u8>),
}

impl Picture {
    /// Adds numbers of the same layer to its own.
    pub fn add(&mut self, other: &Self) {
        if let (Self::Linear(sums), Self::Linear(own)) = (self, other) {
            sums.iter_mut().zip(own).for_each(|(sum, value)| *sum += value);
        }
    }

    /// Of one band, or of red, green and blue, each of which gives its own channel.
    pub fn of_bands(mut bands: Vec<Self>, layer: Layer) -> Option<Self> {
        let (own, all) = (layer.channels(1), layer.channels(3));
        match bands.as_slice() {
            [Self::Linear(red), Self::Linear(green), Self::Linear(blue)] if all == 3 => {
                let at = |pixel: usize, k: usize| pixel * own + k.min(own - 1);
                let rgb = |i| [red[at(i, 0)], green[at(i, 1)], blue[at(i, 2)]];
                Some(Self::Linear((0..red.len() / own).flat_map(rgb).collect()))
            }
            _ => bands.pop(),
        }
    }
}

/// The pixels that a pass over blobs takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resolution {
    /// All.
    Full,
    /// One in 16.
    Low,
    /// Those that have no like neighbour among these.
    Missing,
}

impl Resolution {
    /// The name by which passes know it.
    pub fn defines(self) -> &'static [&'static str] {
        if self == Self::Missing { &["MISSING"] } else { &[] }
    }
}

/// What the passes of a frame write to.
pub struct Targets {
    /// Normal, and distance along the ray.
    pub hits: Texture,
    /// Place of the surface.
    pub surfaces: Texture,
    pub depth: Texture,
    /// Which lamps they see, if anything hides one.
    pub marks: Option<Texture>,
    /// Light from surfaces.
    pub radiance: Texture,
    /// Airlight, and optical depth.
    pub fog: Texture,
    /// The same from passes that compute.
    pub computed: Option<Buffer>,
    /// The blobs' share in a draft's low resolution.
    pub low: Option<Buffer>,
    /// Where more samples are worth while, if there are several.
    pub edges: Option<Texture>,
    /// What the layer shows: the sum of its samples, and of their weights.
    pub sums: Texture,
}

/// A frame while it is recorded.
pub struct Recorder<'a> {
    pub gpu: &'a Gpu,
    pub context: &'a Context<'a>,
    /// Whether its picture is all that is shown.
    pub is_whole: bool,
    pub lists: &'a Lists,
    pub triangles: &'a Triangles,
    pub targets: Targets,
    /// The camera and the picture, for the sample that is recorded.
    pub view: Buffer,
    /// The same in a draft's low resolution, if there is one.
    pub low_view: Option<Buffer>,
    /// Buffers that count as taken until the frame is done.
    pub kept: Vec<Buffer>,
    pub encoder: wgpu::CommandEncoder,
    pub timer: Timer,
    /// What is under way, and the buffers that it counts.
    submitted: Option<(SubmissionIndex, Vec<Buffer>)>,
}

/// Renders the layer's picture, and tells what each pass took, where the device can.
pub fn render(
    gpu: &Gpu,
    (context, is_whole): (&Context, bool),
    triangles: &Triangles,
    lists: &Lists,
) -> Result<(Picture, Times), Failure> {
    let shifts = match context.view.samples {
        Some(samples) if samples > 1 => samples::shifts(samples as usize),
        _ => vec![CENTER],
    };
    let mut frame = Recorder::new(gpu, (context, is_whole), (triangles, lists), shifts.len())?;
    for (i, shift) in shifts.iter().enumerate() {
        frame.sample(*shift, i == 0)?;
    }
    frame.show()
}

impl<'a> Recorder<'a> {
    fn new(
        gpu: &'a Gpu,
        (context, is_whole): (&'a Context<'a>, bool),
        (triangles, lists): (&'a Triangles, &'a Lists),
        samples: usize,
    ) -> Result<Self, Failure> {
        let device = &gpu.device;
        let frame = Self {
            gpu,
            context,
            is_whole,
            lists,
            triangles,
            targets: Targets::new(gpu, context, samples, lists.casters.is_some())?,
            view: view(gpu, context, CENTER, 1)?,
            low_view: is_low(context)
                .then(|| view(gpu, context, CENTER, DRAFT_STEP))
                .transpose()?,
            kept: Vec::new(),
            encoder: device.handle.create_command_encoder(&Default::default()),
            timer: Timer::new(device)?,
            submitted: None,
        };
        device.reached(Stage::Upload);
        Ok(frame)
    }

    /// What pixels show that are sampled at a place within them.
    fn sample(&mut self, place: DVec2, is_first: bool) -> Result<(), Failure> {
        if !is_first {
            let shifted = view(self.gpu, self.context, place, 1)?;
            self.kept.push(std::mem::replace(&mut self.view, shifted));
            if let Some(low_view) = &mut self.low_view {
                let shifted = view(self.gpu, self.context, place, DRAFT_STEP)?;
                self.kept.push(std::mem::replace(low_view, shifted));
            }
        }
        self.surfaces()?;
        if self.context.shows_surfaces() {
            self.surface_radiance()?;
        }
        if let Some(computed) = &self.targets.computed {
            self.encoder.clear_buffer(&computed.handle, 0, None);
        }
        if self.context.shows_fog() {
            self.haze()?;
            if self.context.interpolates() { self.grid(is_first) } else { self.blobs() }?;
            self.bend()?;
        }
        self.composite(is_first)?;
        self.submit()
    }

    /// Hands over what is recorded. Nothing else is under way then, so that a frame that nobody waits
    /// for ends soon; the next passes are recorded meanwhile.
    pub fn submit(&mut self) -> Result<(), Failure> {
        let device = &self.gpu.device;
        let next = device.handle.create_command_encoder(&Default::default());
        let commands = std::mem::replace(&mut self.encoder, next).finish();
        if let Some((last, buffers)) = self.submitted.take() {
            device.finish(&last)?;
            drop(buffers);
        }
        if self.context.job.progress.is_over() {
            return Err(Failure::Interrupted);
        }
        let submission = device.submit(commands)?;
        self.submitted = Some((submission, std::mem::take(&mut self.kept)));
        Ok(())
    }

    pub fn pipeline(
        &self,
        pass: Pass,
        defines: &[&[&'static str]],
    ) -> Result<Arc<Pipeline>, Failure> {
        let media = if pass.sees_haze() { of_media(self.context.field) } else { Vec::new() };
        let key = Composition::new(pass, &[defines, &[&media]].concat());
        self.gpu.pipelines.get(&self.gpu.device, &key)
    }

    /// Parts of the list of blobs that one dispatch takes.
    pub fn spans(&self) -> Vec<Range<u32>> {
        let count = self.context.field.lumps() as u32;
        let starts = (0..count).step_by(BLOBS_A_DISPATCH as usize);
        starts.map(|start| start..(start + BLOBS_A_DISPATCH).min(count)).collect()
    }

    pub fn span(&self, part: Range<u32>, [lamp, slot]: [u32; 2]) -> Result<Buffer, Failure> {
        let span = Span { first: part.start, end: part.end, lamp, slot };
        self.gpu.device.filled(&layout::one(&span), BufferUsages::UNIFORM)
    }

    /// What blobs are summed up for: all pixels; or those of a draft's low resolution, and then
    /// those that it lends nothing to.
    pub fn resolutions(&self) -> Vec<Resolution> {
        if self.low_view.is_none() {
            return vec![Resolution::Full];
        }
        vec![Resolution::Low, Resolution::Missing]
    }

    /// The view and the grid of a resolution.
    pub fn view_of(&self, resolution: Resolution) -> (&Buffer, Grid) {
        match &self.low_view {
            Some(view) if resolution == Resolution::Low => (view, low(self.context.grid)),
            _ => (&self.view, self.context.grid),
        }
    }

    /// A workgroup a tile.
    pub fn dispatch(
        &mut self,
        name: &'static str,
        pipeline: &Pipeline,
        bind: &wgpu::BindGroup,
        grid: Grid,
    ) {
        let (columns, rows) = tiles(grid);
        self.compute(name, pipeline, bind, |pass| pass.dispatch_workgroups(columns, rows, 1));
    }

    /// A pass that computes.
    pub fn compute(
        &mut self,
        name: &'static str,
        pipeline: &Pipeline,
        bind: &wgpu::BindGroup,
        dispatch: impl FnOnce(&mut wgpu::ComputePass<'_>),
    ) {
        let mut pass = self.encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: None,
            timestamp_writes: self.timer.compute(name),
        });
        if let Kind::Compute(pipeline) = &pipeline.kind {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, bind, &[]);
            dispatch(&mut pass);
        }
    }
}

impl Targets {
    fn new(gpu: &Gpu, context: &Context, samples: usize, casts: bool) -> Result<Self, Failure> {
        let grid = context.grid;
        let target = |format| gpu.device.target(grid.width as u32, grid.height as u32, format);
        let list = |grid: Grid| {
            let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
            gpu.device.buffer(16 * (grid.width * grid.height) as u64, usage)
        };
        let is_low = is_low(context) && context.shows_fog() && !context.interpolates();
        Ok(Self {
            hits: target(LIGHT)?,
            surfaces: target(NUMBER)?,
            depth: target(DEPTH)?,
            marks: casts.then(|| target(NUMBER)).transpose()?,
            radiance: target(LIGHT)?,
            fog: target(LIGHT)?,
            computed: context.shows_fog().then(|| list(grid)).transpose()?,
            low: is_low.then(|| list(low(grid))).transpose()?,
            edges: (samples > 1).then(|| target(NUMBER)).transpose()?,
            sums: target(LIGHT)?,
        })
    }
}

fn view(gpu: &Gpu, context: &Context, sample: DVec2, step: usize) -> Result<Buffer, Failure> {
    let grid = if step == 1 { context.grid } else { low(context.grid) };
    let view = layout::one(&buffers::view(context, sample, grid, step));
    gpu.device.filled(&view, BufferUsages::UNIFORM)
}

/// Whether blobs are summed up for one pixel in 16 only.
pub fn is_low(context: &Context) -> bool {
    // What noise makes of a pixel its neighbours do not tell.
    context.view.quality == Quality::Draft && context.field.lumps() > 0 && context.noise.is_none()
}

/// The pixels of a draft's low resolution.
pub fn low(grid: Grid) -> Grid {
    Grid { width: grid.width.div_ceil(DRAFT_STEP), height: grid.height.div_ceil(DRAFT_STEP) }
}

/// Tiles across and down.
pub fn tiles(grid: Grid) -> (u32, u32) {
    ((grid.width as u32).div_ceil(TILE), (grid.height as u32).div_ceil(TILE))
}

/// All of a buffer, under a number.
pub fn all(binding: u32, buffer: &Buffer) -> (u32, BindingResource<'_>) {
    (binding, buffer.handle.as_entire_binding())
}

/// A texture, under a number.
pub fn texture(binding: u32, target: &Texture) -> (u32, BindingResource<'_>) {
    (binding, BindingResource::TextureView(&target.view))
}

/// What a pass draws to.
pub fn attachment(
    target: &Texture,
    load: LoadOp<wgpu::Color>,
) -> Option<wgpu::RenderPassColorAttachment<'_>> {
    Some(wgpu::RenderPassColorAttachment {
        view: &target.view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations { load, store: StoreOp::Store },
    })
}

/// Clears a target, or keeps what is there.
pub fn clearing(clears: bool) -> LoadOp<wgpu::Color> {
    if clears { LoadOp::Clear(wgpu::Color::TRANSPARENT) } else { LoadOp::Load }
}

/// Runs a pass over the whole picture.
pub fn cover(
    encoder: &mut wgpu::CommandEncoder,
    times: Option<wgpu::RenderPassTimestampWrites<'_>>,
    targets: &[Option<wgpu::RenderPassColorAttachment<'_>>],
    (pipeline, bind): (&Pipeline, &wgpu::BindGroup),
) {
    /// A triangle that covers all of it.
    const COVER: (u32, u32) = (3, 1);
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        color_attachments: targets,
        timestamp_writes: times,
        ..Default::default()
    });
    draw(&mut pass, pipeline, bind, COVER);
}

/// Draws so many vertices and instances.
pub fn draw(
    pass: &mut wgpu::RenderPass<'_>,
    pipeline: &Pipeline,
    bind: &wgpu::BindGroup,
    (vertices, instances): (u32, u32),
) {
    if let Kind::Render(pipeline) = &pipeline.kind {
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, bind, &[]);
        pass.draw(0..vertices, 0..instances);
    }
}
