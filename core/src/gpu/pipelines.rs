//! Pipelines, named by what they are composed of and made on first use.

use super::compose::{Composition, Pass, module};
use super::device::{Device, Failure};
use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};
use wgpu::{BlendState, ColorTargetState, ColorWrites, TextureFormat};

/// What light and fog are written to.
pub const LIGHT: TextureFormat = TextureFormat::Rgba32Float;
/// What the number of the surface is written to.
pub const SURFACE: TextureFormat = TextureFormat::R32Uint;
/// What hides farther surfaces.
pub const DEPTH: TextureFormat = TextureFormat::Depth32Float;

/// A pipeline of either kind.
#[derive(Debug)]
pub enum Pipeline {
    /// Draws.
    Render(wgpu::RenderPipeline),
    /// Computes.
    Compute(wgpu::ComputePipeline),
}

impl Pipeline {
    /// What its passes read, by number.
    pub fn bind(&self, device: &Device, entries: &[wgpu::BindGroupEntry<'_>]) -> wgpu::BindGroup {
        let layout = match self {
            Self::Render(pipeline) => pipeline.get_bind_group_layout(0),
            Self::Compute(pipeline) => pipeline.get_bind_group_layout(0),
        };
        device.handle.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &layout,
            entries,
        })
    }
}

/// The pipelines of one device.
#[derive(Debug, Default)]
pub struct Pipelines(Mutex<HashMap<Composition, Arc<Pipeline>>>);

impl Pipelines {
    /// The pipeline of a composition.
    ///
    /// # Errors
    /// Where the device does not take it.
    pub fn get(&self, device: &Device, key: &Composition) -> Result<Arc<Pipeline>, Failure> {
        let mut made = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(pipeline) = made.get(key) {
            return Ok(Arc::clone(pipeline));
        }
        let pipeline = Arc::new(make(device, key)?);
        made.insert(*key, Arc::clone(&pipeline));
        Ok(pipeline)
    }
}

fn make(device: &Device, key: &Composition) -> Result<Pipeline, Failure> {
    let module = module(key).map_err(Failure::Refused)?;
    let label = Some(key.pass.stem());
    let shader = device.handle.create_shader_module(wgpu::ShaderModuleDescriptor {
        label,
        source: wgpu::ShaderSource::Naga(Cow::Owned(module)),
    });
    let pipeline = if is_compute(key.pass) {
        Pipeline::Compute(device.handle.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label,
            layout: None,
            module: &shader,
            entry_point: None,
            compilation_options: Default::default(),
            cache: None,
        }))
    } else {
        Pipeline::Render(render(device, key.pass, &shader))
    };
    device.look().map(|()| pipeline)
}

fn is_compute(pass: Pass) -> bool {
    matches!(pass, Pass::BlobTiles | Pass::LightDepth | Pass::Mapped)
}

fn render(device: &Device, pass: Pass, shader: &wgpu::ShaderModule) -> wgpu::RenderPipeline {
    let target =
        |format, blend| Some(ColorTargetState { format, blend, write_mask: ColorWrites::ALL });
    let add = Some(BlendState {
        color: wgpu::BlendComponent {
            src_factor: wgpu::BlendFactor::One,
            dst_factor: wgpu::BlendFactor::One,
            operation: wgpu::BlendOperation::Add,
        },
        alpha: wgpu::BlendComponent {
            src_factor: wgpu::BlendFactor::One,
            dst_factor: wgpu::BlendFactor::One,
            operation: wgpu::BlendOperation::Add,
        },
    });
    let finds_surfaces = matches!(pass, Pass::Triangles | Pass::Shapes);
    let targets = match pass {
        Pass::Triangles | Pass::Shapes => vec![target(LIGHT, None), target(SURFACE, None)],
        Pass::Composite => vec![target(LIGHT, None)],
        _ => vec![target(LIGHT, add)],
    };
    let nearest = wgpu::DepthStencilState {
        format: DEPTH,
        depth_write_enabled: Some(true),
        depth_compare: Some(wgpu::CompareFunction::Greater),
        stencil: Default::default(),
        bias: Default::default(),
    };
    let strip = matches!(pass, Pass::Shapes | Pass::BlobQuads);
    let topology = if strip {
        wgpu::PrimitiveTopology::TriangleStrip
    } else {
        wgpu::PrimitiveTopology::TriangleList
    };
    device.handle.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(pass.stem()),
        layout: None,
        vertex: wgpu::VertexState {
            module: shader,
            entry_point: None,
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState { topology, ..Default::default() },
        depth_stencil: finds_surfaces.then_some(nearest),
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: shader,
            entry_point: None,
            compilation_options: Default::default(),
            targets: &targets,
        }),
        multiview_mask: None,
        cache: None,
    })
}
