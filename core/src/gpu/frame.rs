//! One frame on the device, read top to bottom as a list of passes.

use super::buffers::{self, Lists, Table, Triangles};
use super::compose::{self, Composition, Pass};
use super::device::{Buffer, Failure, Texture};
use super::layout::{self, Span};
use super::pipelines::{DEPTH, LIGHT, Pipeline, SURFACE};
use super::timer::{Timer, Times};
use super::{BlobPass, Gpu};
use crate::airlight::Method;
use crate::cpu::frame::Context;
use crate::request::Layer;
use glam::{DVec2, UVec4};
use std::sync::Arc;
use wgpu::{BufferUsages, LoadOp, StoreOp};

/// Pixels along the side of a workgroup.
const TILE: u32 = 16;
/// Pixels along the sides of patches of the mapped airlight.
const SIDES: [u32; 5] = [TILE, 8, 4, 2, 1];
/// Workgroups of a row of a dispatch over patches.
const ACROSS: u32 = 1 << 15;
/// A list of patches, and of workgroups that take them.
const PATCHES: BufferUsages = BufferUsages::STORAGE.union(BufferUsages::INDIRECT);
/// Blobs of one dispatch: no loop of a shader comes near 65 535 turns, where drivers may end it.
const BLOBS_A_DISPATCH: u32 = 1 << 15;
/// Bytes of the depths from lights to pixels that stand at a time.
const LIGHT_DEPTH_BYTES: u64 = 128 << 20;

/// What a frame's passes write to.
struct Targets {
    /// Normal, and distance along the ray.
    hits: Texture,
    /// Place of the surface.
    surfaces: Texture,
    depth: Texture,
    /// Light from surfaces.
    radiance: Texture,
    /// Airlight, and optical depth.
    fog: Texture,
    /// The same from passes that compute.
    computed: Option<Buffer>,
    /// What the layer shows.
    picture: Texture,
}

impl Targets {
    fn new(gpu: &Gpu, width: u32, height: u32, computes: bool) -> Result<Self, Failure> {
        let target = |format| gpu.device.target(width, height, format);
        let pixels = u64::from(width) * u64::from(height);
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let computed = computes.then(|| gpu.device.buffer(16 * pixels, usage));
        Ok(Self {
            hits: target(LIGHT)?,
            surfaces: target(SURFACE)?,
            depth: target(DEPTH)?,
            radiance: target(LIGHT)?,
            fog: target(LIGHT)?,
            computed: computed.transpose()?,
            picture: target(LIGHT)?,
        })
    }
}

/// A frame while it is recorded.
struct Recorder<'a> {
    gpu: &'a Gpu,
    context: &'a Context<'a>,
    lists: &'a Lists,
    triangles: &'a Triangles,
    targets: &'a Targets,
    view: Buffer,
    /// Whether the picture says where more samples are worth while.
    finds_edges: bool,
    /// Buffers that must live until the commands are submitted.
    kept: Vec<Buffer>,
    encoder: wgpu::CommandEncoder,
    timer: Timer,
}

/// Renders the layer's picture, `[height][width][4]`, its pixels sampled at a place within them; and
/// what each pass took, where the device can tell. The fourth channel is 1 at edges, if asked for.
pub fn render(
    gpu: &Gpu,
    context: &Context,
    triangles: &Triangles,
    lists: &Lists,
    sample: DVec2,
    finds_edges: bool,
) -> Result<(Vec<f32>, Times), Failure> {
    let (width, height) = (context.grid.width as u32, context.grid.height as u32);
    let device = &gpu.device;
    let is_mapped = context.method == Method::Mapped && context.shows_airlight();
    let computes = gpu.blob_pass == BlobPass::Tiles || is_mapped;
    let targets = Targets::new(gpu, width, height, computes)?;
    let view = layout::one(&buffers::view(context, sample));
    let mut frame = Recorder {
        gpu,
        context,
        lists,
        triangles,
        targets: &targets,
        view: device.filled(&view, BufferUsages::UNIFORM)?,
        finds_edges,
        kept: Vec::new(),
        encoder: device.handle.create_command_encoder(&Default::default()),
        timer: Timer::new(device)?,
    };
    frame.surfaces()?;
    if context.shows_surfaces() {
        frame.surface_radiance()?;
    }
    if let Some(computed) = &targets.computed {
        frame.encoder.clear_buffer(&computed.handle, 0, None);
    }
    if context.shows_fog() {
        frame.homogeneous()?;
        frame.blobs()?;
    }
    if is_mapped {
        frame.mapped()?;
    }
    frame.composite()?;
    let staging = gpu.staging.take(device, width, height)?;
    staging.copy(&mut frame.encoder, &targets.picture);
    frame.timer.resolve(&mut frame.encoder);
    let Recorder { encoder, timer, kept: _kept, .. } = frame;
    let pixels = staging.read(device, encoder.finish())?;
    Ok((pixels, timer.read(device)))
}

impl Recorder<'_> {
    fn pipeline(
        &self,
        pass: Pass,
        defines: &'static [&'static str],
    ) -> Result<Arc<Pipeline>, Failure> {
        self.gpu.pipelines.get(&self.gpu.device, &Composition { pass, defines })
    }

    /// First hits.
    fn surfaces(&mut self) -> Result<(), Failure> {
        let (triangles, shapes) =
            (self.pipeline(Pass::Triangles, &[])?, self.pipeline(Pass::Shapes, &[])?);
        let (lists, targets) = (self.lists, self.targets);
        let view = self.view.handle.as_entire_binding();
        let of_triangles = [
            entry(0, view.clone()),
            entry(1, lists.anchor.handle.as_entire_binding()),
            entry(2, self.triangles.corners.handle.as_entire_binding()),
            entry(3, self.triangles.normals.handle.as_entire_binding()),
        ];
        let of_shapes = [entry(0, view), entry(1, lists.shapes.handle.as_entire_binding())];
        let device = &self.gpu.device;
        let binds = [triangles.bind(device, &of_triangles), shapes.bind(device, &of_shapes)];
        let nothing = wgpu::Color { r: f64::from(u32::MAX), ..wgpu::Color::TRANSPARENT };
        let far = wgpu::Color { a: f64::from(self.context.far_m), ..wgpu::Color::TRANSPARENT };
        let mut pass = self.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[
                attachment(&targets.hits, LoadOp::Clear(far)),
                attachment(&targets.surfaces, LoadOp::Clear(nothing)),
            ],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &targets.depth.view,
                depth_ops: Some(wgpu::Operations {
                    load: LoadOp::Clear(0.0),
                    store: StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            timestamp_writes: self.timer.render("surfaces"),
            ..Default::default()
        });
        if let (Pipeline::Render(triangles), true) = (&*triangles, self.triangles.count > 0) {
            pass.set_pipeline(triangles);
            pass.set_bind_group(0, &binds[0], &[]);
            pass.draw(0..3 * self.triangles.count, 0..1);
        }
        if let (Pipeline::Render(shapes), true) = (&*shapes, lists.shape_count > 0) {
            pass.set_pipeline(shapes);
            pass.set_bind_group(0, &binds[1], &[]);
            pass.draw(0..4, 0..lists.shape_count);
        }
        Ok(())
    }

    /// Light from the surfaces, a few lamps at a time.
    fn surface_radiance(&mut self) -> Result<(), Failure> {
        let pixels = (self.context.grid.width * self.context.grid.height) as u64;
        let lamps = self.context.lamps.len() as u32;
        let has_blobs = !self.context.field.blobs.is_empty() && lamps > 0;
        let most = if has_blobs { (LIGHT_DEPTH_BYTES / (4 * pixels)).max(1) as u32 } else { lamps };
        let depths = has_blobs.then(|| {
            self.gpu.device.buffer(4 * pixels * u64::from(most.min(lamps)), BufferUsages::STORAGE)
        });
        let depths = depths.transpose()?;
        let mut first = 0;
        loop {
            let end = (first + most.max(1)).min(lamps);
            if let Some(depths) = &depths {
                for lamp in first..end {
                    self.light_depth(depths, lamp, lamp - first)?;
                }
            }
            self.reflect(depths.as_ref(), first..end)?;
            first = end;
            if first >= lamps {
                break;
            }
        }
        self.kept.extend(depths);
        Ok(())
    }

    /// What lies between one lamp and the surfaces.
    fn light_depth(&mut self, depths: &Buffer, lamp: u32, place: u32) -> Result<(), Failure> {
        let pipeline = self.pipeline(Pass::LightDepth, &[])?;
        for blobs in self.spans() {
            let span = self.span([blobs.start, blobs.end, lamp, place])?;
            let (lists, targets) = (self.lists, self.targets);
            let entries = [
                entry(0, self.view.handle.as_entire_binding()),
                entry(1, texture(&targets.hits)),
                entry(2, lists.blobs.handle.as_entire_binding()),
                entry(3, depths.handle.as_entire_binding()),
                entry(4, span.handle.as_entire_binding()),
                entry(5, lists.lamps.handle.as_entire_binding()),
                entry(6, texture(&targets.surfaces)),
            ];
            let bind = pipeline.bind(&self.gpu.device, &entries);
            self.dispatch("light_depth", &pipeline, &bind, 1);
            self.kept.push(span);
        }
        Ok(())
    }

    fn reflect(
        &mut self,
        depths: Option<&Buffer>,
        lamps: std::ops::Range<u32>,
    ) -> Result<(), Failure> {
        let defines: &[&str] = if depths.is_some() { &["BLOBS"] } else { &[] };
        let pipeline = self.pipeline(Pass::Surface, defines)?;
        let is_first = lamps.start == 0;
        let span = self.span([lamps.start, lamps.end, 0, 0])?;
        let (lists, targets) = (self.lists, self.targets);
        let mut entries = vec![
            entry(0, self.view.handle.as_entire_binding()),
            entry(1, texture(&targets.hits)),
            entry(2, texture(&targets.surfaces)),
            entry(3, lists.lamps.handle.as_entire_binding()),
            entry(4, lists.materials.handle.as_entire_binding()),
            entry(5, span.handle.as_entire_binding()),
        ];
        entries.extend(depths.map(|depths| entry(6, depths.handle.as_entire_binding())));
        let bind = pipeline.bind(&self.gpu.device, &entries);
        self.draw("surface_radiance", &targets.radiance, is_first, &pipeline, &bind, (3, 1));
        self.kept.push(span);
        Ok(())
    }

    /// The homogeneous fog along view rays; clears the fog's target.
    fn homogeneous(&mut self) -> Result<(), Failure> {
        let is_lit = self.shows_published() && !self.context.lamps.is_empty();
        let defines: &[&str] = if is_lit { &["AIRLIGHT_SUN2005"] } else { &[] };
        let pipeline = self.pipeline(Pass::Homogeneous, defines)?;
        let (lists, targets) = (self.lists, self.targets);
        let mut entries =
            vec![entry(0, self.view.handle.as_entire_binding()), entry(1, texture(&targets.hits))];
        if is_lit {
            entries.push(entry(2, lists.lamps.handle.as_entire_binding()));
        }
        let bind = pipeline.bind(&self.gpu.device, &entries);
        self.draw("homogeneous", &targets.fog, true, &pipeline, &bind, (3, 1));
        Ok(())
    }

    /// Whether the airlight is one of those that every pass adds on its own.
    fn shows_published(&self) -> bool {
        let published = matches!(self.context.method, Method::Sun2005 | Method::Fogshop2007);
        published && self.context.shows_airlight()
    }

    /// The blobs along view rays.
    fn blobs(&mut self) -> Result<(), Failure> {
        if self.context.field.blobs.is_empty() {
            return Ok(());
        }
        let is_lit = self.context.method == Method::Fogshop2007 && self.context.shows_airlight();
        let defines: &[&str] = if is_lit { &["AIRLIGHT_FOGSHOP2007"] } else { &[] };
        match self.gpu.blob_pass {
            BlobPass::Quads => self.blob_quads(defines, is_lit),
            BlobPass::Tiles => self.blob_tiles(defines, is_lit),
        }
    }

    fn blob_quads(
        &mut self,
        defines: &'static [&'static str],
        is_lit: bool,
    ) -> Result<(), Failure> {
        let pipeline = self.pipeline(Pass::BlobQuads, defines)?;
        let (lists, targets) = (self.lists, self.targets);
        let mut entries = vec![
            entry(0, self.view.handle.as_entire_binding()),
            entry(1, texture(&targets.hits)),
            entry(2, lists.blobs.handle.as_entire_binding()),
        ];
        if is_lit {
            entries.push(entry(3, lists.lamps.handle.as_entire_binding()));
            entries.push(entry(4, lists.lit.handle.as_entire_binding()));
        }
        let bind = pipeline.bind(&self.gpu.device, &entries);
        let count = self.context.field.blobs.len() as u32;
        self.draw("blobs", &targets.fog, false, &pipeline, &bind, (4, count));
        Ok(())
    }

    fn blob_tiles(
        &mut self,
        defines: &'static [&'static str],
        is_lit: bool,
    ) -> Result<(), Failure> {
        let pipeline = self.pipeline(Pass::BlobTiles, defines)?;
        let Some(fogged) = &self.targets.computed else { return Ok(()) };
        for blobs in self.spans() {
            let span = self.span([blobs.start, blobs.end, 0, 0])?;
            let (lists, targets) = (self.lists, self.targets);
            let mut entries = vec![
                entry(0, self.view.handle.as_entire_binding()),
                entry(1, texture(&targets.hits)),
                entry(2, lists.blobs.handle.as_entire_binding()),
                entry(3, fogged.handle.as_entire_binding()),
                entry(4, span.handle.as_entire_binding()),
            ];
            if is_lit {
                entries.push(entry(5, lists.lamps.handle.as_entire_binding()));
                entries.push(entry(6, lists.lit.handle.as_entire_binding()));
            }
            let bind = pipeline.bind(&self.gpu.device, &entries);
            self.dispatch("blobs", &pipeline, &bind, 1);
            self.kept.push(span);
        }
        Ok(())
    }

    /// Airlight by the mapped rule, lamp by lamp, in patches that get smaller.
    fn mapped(&mut self) -> Result<(), Failure> {
        let (columns, rows) = self.tiles();
        let device = &self.gpu.device;
        // A bit a pixel, tile by tile.
        let all = vec![u8::MAX; 32 * (columns * rows) as usize];
        let whole = patches(columns, rows);
        for lamp in 0..self.context.lamps.len() as u32 {
            let table = Arc::clone(&self.context.lamps[lamp as usize].table);
            let table = self.gpu.tables.get(&table, || Table::of(device, &table))?;
            let left = device.filled(&all, BufferUsages::STORAGE)?;
            let mut now = device.filled(&whole, PATCHES)?;
            for side in SIDES {
                let next = device.buffer(list_bytes(columns * rows * quarters(side)), PATCHES)?;
                self.mapped_patches(lamp, table.as_ref().as_ref(), &left, side, [&now, &next])?;
                self.kept.push(now);
                now = next;
            }
            self.kept.extend([now, left]);
        }
        Ok(())
    }

    fn mapped_patches(
        &mut self,
        lamp: u32,
        table: Option<&Table>,
        left: &Buffer,
        side: u32,
        [now, next]: [&Buffer; 2],
    ) -> Result<(), Failure> {
        let Some(fogged) = &self.targets.computed else { return Ok(()) };
        let defines: &[&str] = if table.is_some() { &["LIGHT_TABLE"] } else { &[] };
        let pipeline = self.pipeline(Pass::Mapped, defines)?;
        let span = self.span([lamp, lamp + 1, side, 0])?;
        let (lists, targets) = (self.lists, self.targets);
        let mut entries = vec![
            entry(0, self.view.handle.as_entire_binding()),
            entry(1, texture(&targets.hits)),
            entry(2, lists.blobs.handle.as_entire_binding()),
            entry(3, fogged.handle.as_entire_binding()),
            entry(4, span.handle.as_entire_binding()),
            entry(5, lists.lamps.handle.as_entire_binding()),
            entry(6, lists.rules.handle.as_entire_binding()),
            entry(7, left.handle.as_entire_binding()),
            entry(8, lists.tolerance.handle.as_entire_binding()),
            entry(11, now.handle.as_entire_binding()),
            entry(12, next.handle.as_entire_binding()),
        ];
        if let Some(table) = table {
            entries.push(entry(9, table.extent.handle.as_entire_binding()));
            entries.push(entry(10, table.means.handle.as_entire_binding()));
        }
        let bind = pipeline.bind(&self.gpu.device, &entries);
        let mut pass = self.encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: None,
            timestamp_writes: self.timer.compute("airlight"),
        });
        if let Pipeline::Compute(pipeline) = &*pipeline {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &bind, &[]);
            pass.dispatch_workgroups_indirect(&now.handle, 0);
        }
        drop(pass);
        self.kept.push(span);
        Ok(())
    }

    fn tiles(&self) -> (u32, u32) {
        let tiles = |count: usize| (count as u32).div_ceil(TILE);
        (tiles(self.context.grid.width), tiles(self.context.grid.height))
    }

    /// What the layer shows.
    fn composite(&mut self) -> Result<(), Failure> {
        let tiles = self.targets.computed.is_some();
        let edges = self.finds_edges;
        let key = compose::composite(self.context.view.layer, tiles, edges);
        let pipeline = self.gpu.pipelines.get(&self.gpu.device, &key)?;
        let targets = self.targets;
        let reads: &[u32] = match self.context.view.layer {
            Layer::Beauty => &[0, 2, 3, 4],
            Layer::Surface => &[2],
            Layer::Normal | Layer::Depth => &[1],
            Layer::Airlight | Layer::OpticalDepth | Layer::Transmittance => &[3, 4],
        };
        let mut entries = vec![
            entry(1, texture(&targets.hits)),
            entry(2, texture(&targets.radiance)),
            entry(3, texture(&targets.fog)),
            entry(0, self.view.handle.as_entire_binding()),
        ];
        if let Some(fogged) = &targets.computed {
            entries.push(entry(4, fogged.handle.as_entire_binding()));
        }
        entries.retain(|e| match e.binding {
            // The buffer is found by the picture's width, edges end at it.
            0 => edges || reads.contains(&0) || tiles && reads.contains(&4),
            1 => edges || reads.contains(&1),
            binding => reads.contains(&binding),
        });
        entries.extend(edges.then(|| entry(5, texture(&targets.surfaces))));
        let bind = pipeline.bind(&self.gpu.device, &entries);
        self.draw("composite", &targets.picture, true, &pipeline, &bind, (3, 1));
        Ok(())
    }

    /// Parts of the list of blobs that one dispatch takes.
    fn spans(&self) -> Vec<std::ops::Range<u32>> {
        let count = self.context.field.blobs.len() as u32;
        let starts = (0..count).step_by(BLOBS_A_DISPATCH as usize);
        starts.map(|start| start..(start + BLOBS_A_DISPATCH).min(count)).collect()
    }

    fn span(&self, range: [u32; 4]) -> Result<Buffer, Failure> {
        let span = Span { range: UVec4::from_array(range) };
        self.gpu.device.filled(&layout::one(&span), BufferUsages::UNIFORM)
    }

    fn draw(
        &mut self,
        name: &'static str,
        target: &Texture,
        clears: bool,
        pipeline: &Pipeline,
        bind: &wgpu::BindGroup,
        (vertices, instances): (u32, u32),
    ) {
        let load = if clears { LoadOp::Clear(wgpu::Color::TRANSPARENT) } else { LoadOp::Load };
        let mut pass = self.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[attachment(target, load)],
            timestamp_writes: self.timer.render(name),
            ..Default::default()
        });
        if let Pipeline::Render(pipeline) = pipeline {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, bind, &[]);
            pass.draw(0..vertices, 0..instances);
        }
    }

    /// So many workgroups a tile.
    fn dispatch(
        &mut self,
        name: &'static str,
        pipeline: &Pipeline,
        bind: &wgpu::BindGroup,
        a_tile: u32,
    ) {
        let tiles = |count: usize| (count as u32).div_ceil(TILE);
        let mut pass = self.encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: None,
            timestamp_writes: self.timer.compute(name),
        });
        if let Pipeline::Compute(pipeline) = pipeline {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, bind, &[]);
            let grid = self.context.grid;
            pass.dispatch_workgroups(tiles(grid.width), tiles(grid.height), a_tile);
        }
    }
}

/// All tiles of a picture, as patches for a dispatch.
fn patches(columns: u32, rows: u32) -> Vec<u8> {
    let count = columns * rows;
    let head = [count.min(ACROSS), count.div_ceil(ACROSS), 1, count];
    let places = (0..rows).flat_map(|y| (0..columns).map(move |x| x | (y << 16)));
    let mut bytes: Vec<_> = head.into_iter().chain(places).flat_map(u32::to_le_bytes).collect();
    bytes.resize(list_bytes(count) as usize, 0);
    bytes
}

/// Bytes of a list of so many patches: a multiple of its first row.
fn list_bytes(patches: u32) -> u64 {
    16 + (4 * u64::from(patches)).next_multiple_of(16)
}

/// Patches half as large as those of that side, in a tile.
fn quarters(side: u32) -> u32 {
    4 * (TILE / side) * (TILE / side)
}

fn entry(binding: u32, resource: wgpu::BindingResource<'_>) -> wgpu::BindGroupEntry<'_> {
    wgpu::BindGroupEntry { binding, resource }
}

fn texture(target: &Texture) -> wgpu::BindingResource<'_> {
    wgpu::BindingResource::TextureView(&target.view)
}

fn attachment(
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
