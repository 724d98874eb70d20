//! Pipelines, named by what they are composed of and made on first use.

use super::compose::{Composition, Pass, module};
use super::device::{Device, Failure, Stage};
use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};
use wgpu::naga::Module;
use wgpu::naga::valid::{Capabilities, ValidationFlags, Validator};
use wgpu::{BlendComponent, BlendFactor, BlendState, ColorTargetState, ColorWrites, TextureFormat};

/// What light and fog are written to.
pub const LIGHT: TextureFormat = TextureFormat::Rgba32Float;
/// What the number of the surface, and marks of edges, are written to.
pub const NUMBER: TextureFormat = TextureFormat::R32Uint;
/// What hides farther surfaces.
pub const DEPTH: TextureFormat = TextureFormat::Depth32Float;
/// What a screen shows.
pub const SCREEN: TextureFormat = TextureFormat::Rgba8Unorm;

/// A pipeline of either kind.
#[derive(Debug)]
pub enum Kind {
    /// Draws.
    Render(wgpu::RenderPipeline),
    /// Computes.
    Compute(wgpu::ComputePipeline),
}

/// A pipeline and what its passes read.
#[derive(Debug)]
pub struct Pipeline {
    /// The pipeline.
    pub kind: Kind,
    /// Bindings that its text uses.
    bindings: Vec<u32>,
}

impl Pipeline {
    /// What its passes read, by number; what its text does not use is left out.
    pub fn bind(
        &self,
        device: &Device,
        entries: &[(u32, wgpu::BindingResource<'_>)],
    ) -> wgpu::BindGroup {
        let layout = match &self.kind {
            Kind::Render(pipeline) => pipeline.get_bind_group_layout(0),
            Kind::Compute(pipeline) => pipeline.get_bind_group_layout(0),
        };
        let used = entries.iter().filter(|(binding, _)| self.bindings.contains(binding));
        let entries: Vec<_> = used
            .map(|(binding, resource)| wgpu::BindGroupEntry {
                binding: *binding,
                resource: resource.clone(),
            })
            .collect();
        device.handle.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &layout,
            entries: &entries,
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
        device.reached(Stage::Pipeline);
        let pipeline = Arc::new(make(device, key)?);
        made.insert(key.clone(), Arc::clone(&pipeline));
        Ok(pipeline)
    }
}

/// What is invalid is refused before a driver sees it: some lose the device over it.
fn make(device: &Device, key: &Composition) -> Result<Pipeline, Failure> {
    let module = module(key).map_err(Failure::Refused)?;
    let bindings = bindings(&module)?;
    let label = Some(key.pass.stem());
    let shader = device.handle.create_shader_module(wgpu::ShaderModuleDescriptor {
        label,
        source: wgpu::ShaderSource::Naga(Cow::Owned(module)),
    });
    let kind = if is_compute(key.pass) {
        Kind::Compute(device.handle.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label,
            layout: None,
            module: &shader,
            entry_point: None,
            // Passes write their own memory before they read it; one invocation would clear all of it.
            compilation_options: wgpu::PipelineCompilationOptions {
                zero_initialize_workgroup_memory: false,
                ..Default::default()
            },
            cache: None,
        }))
    } else {
        Kind::Render(render(device, key, &shader))
    };
    device.look().map(|()| Pipeline { kind, bindings })
}

/// The bindings that a module's entry points use.
fn bindings(module: &Module) -> Result<Vec<u32>, Failure> {
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::default());
    let info = validator.validate(module);
    let info = info.map_err(|error| Failure::Refused(error.into_inner().to_string()))?;
    let points = 0..module.entry_points.len();
    let used = module.global_variables.iter().filter_map(|(handle, variable)| {
        let is_used = points.clone().any(|i| !info.get_entry_point(i)[handle].is_empty());
        variable.binding.as_ref().filter(|_| is_used).map(|place| place.binding)
    });
    Ok(used.collect())
}

fn is_compute(pass: Pass) -> bool {
    matches!(pass, Pass::BlobTiles | Pass::Bend | Pass::LightDepth | Pass::Knots | Pass::Grid)
}

/// What a composition draws to.
fn targets(key: &Composition) -> Vec<Option<ColorTargetState>> {
    let target =
        |format, blend| Some(ColorTargetState { format, blend, write_mask: ColorWrites::ALL });
    let sum = BlendComponent { dst_factor: BlendFactor::One, ..BlendComponent::REPLACE };
    let add = Some(BlendState { color: sum, alpha: sum });
    match key.pass {
        Pass::Triangles | Pass::Shapes => vec![target(LIGHT, None), target(NUMBER, None)],
        Pass::Tonemap if key.defines.contains(&"SCREEN") => vec![target(SCREEN, None)],
        Pass::Tonemap => vec![target(LIGHT, None)],
        Pass::Lit => vec![target(NUMBER, None)],
        Pass::Composite if key.defines.contains(&"MARK_EDGES") => {
            vec![target(LIGHT, add), target(NUMBER, None)]
        }
        _ => vec![target(LIGHT, add)],
    }
}

fn render(device: &Device, key: &Composition, shader: &wgpu::ShaderModule) -> wgpu::RenderPipeline {
    let nearest = wgpu::DepthStencilState {
        format: DEPTH,
        depth_write_enabled: Some(true),
        depth_compare: Some(wgpu::CompareFunction::Greater),
        stencil: Default::default(),
        bias: Default::default(),
    };
    let finds_surfaces = matches!(key.pass, Pass::Triangles | Pass::Shapes);
    let topology = match key.pass {
        Pass::Shapes => wgpu::PrimitiveTopology::TriangleStrip,
        _ => wgpu::PrimitiveTopology::TriangleList,
    };
    device.handle.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(key.pass.stem()),
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
            targets: &targets(key),
        }),
        multiview_mask: None,
        cache: None,
    })
}
