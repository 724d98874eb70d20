//! What a frame's passes read, brought to the device: the scene's lists relative to the camera, and
//! its triangles, which are kept while the surfaces stay the same.

use super::compose::HAZE_BINDING;
use super::device::{Buffer, Device, Failure};
use super::layout::{
    self, Anchor, Blob, Extent, Lamp, Material, Shape, Smooth, Tolerance, Triangle, View,
};
use crate::airlight::Method;
use crate::frame::context::Context;
use crate::frame::light_table::LightTable;
use crate::frame::samples;
use crate::frame::tolerance::{self, THIN};
use crate::frame::viewpoint::Grid;
use crate::media::PICTURE_LOSS;
use crate::quadrature::gauss_legendre;
use crate::shapes::{Geometry, Solid};
use glam::{DVec2, DVec3, UVec4, Vec2, Vec3, Vec4};
use std::sync::LazyLock;
use wgpu::{BindingResource, BufferUsages};

/// Depth at which triangles are cut off in front of the camera [m].
const CUT_OFF: f32 = 1e-5;
/// Optical depth that the mapped airlight may lose of all blobs together.
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

/// A light's table on the device.
#[derive(Debug)]
pub struct Table {
    /// What it covers.
    pub extent: Buffer,
    /// Its samples.
    pub means: Buffer,
}

impl Table {
    /// The table of a light.
    ///
    /// # Errors
    /// Where there is no memory for it.
    pub fn new(device: &Device, table: &LightTable) -> Result<Self, Failure> {
        let [across, down, toward] = table.axes().map(|axis| axis.as_vec3().extend(0.0));
        let toward = toward.with_w(table.reach());
        let extent = Extent { across, down, toward, scale: Vec4::from_array(table.scale()) };
        let means: &[u8] = bytemuck::cast_slice(table.values());
        Ok(Self {
            extent: device.filled(&layout::one(&extent), BufferUsages::UNIFORM)?,
            means: device.filled(means, BufferUsages::STORAGE)?,
        })
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
            Triangle {
                a: a.extend(layout::bits(triangle.surface)),
                b: b.extend(layout::bits(triangle.smooth)),
                c: c.extend(0.0),
            }
        });
        let normals = geometry.smooth.iter().map(|normals| {
            let [a, b, c] = normals.map(|normal| normal.extend(0.0));
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

/// The lists of one frame.
#[derive(Debug)]
pub struct Lists {
    /// Where triangles are relative to.
    pub anchor: Buffer,
    /// Planes, spheres and boxes.
    pub shapes: Buffer,
    /// How many.
    pub shape_count: u32,
    /// Lights.
    pub lamps: Buffer,
    /// The media that stand in closed form, one list each.
    haze: Vec<Buffer>,
    /// Gaussians.
    pub blobs: Buffer,
    /// For the published airlight: what each light does to each of them.
    pub lit: Buffer,
    /// Materials, the background behind them.
    pub materials: Buffer,
    /// Abscissae and weights of Gauss–Legendre rules, one rule after the other.
    pub rules: Buffer,
    /// What a patch of the mapped airlight may miss.
    pub tolerance: Buffer,
}

/// Nodes of the rules that shaders choose from.
const SIZES: [usize; 5] = [32, 64, 128, 256, 512];

/// The rules, as shaders read them: the same in every frame.
static RULES: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let rule = |size: usize| {
        let (nodes, weights) = gauss_legendre(size);
        nodes.into_iter().zip(weights).map(|(x, w)| Vec2::new(x as f32, w as f32))
    };
    layout::list(SIZES.into_iter().flat_map(rule).collect())
});

fn tolerance(context: &Context) -> Tolerance {
    let t = tolerance::Tolerance::new(&context.view, context.field.lumps());
    Tolerance {
        whole: Vec4::new(t.near, t.hidden, t.wide, t.rough as f32),
        rule: Vec4::new(t.agree as f32, t.unmet as f32, 0.0, 0.0),
        layers: Vec4::new(t.layer, THIN, 0.0, 0.0),
    }
}

impl Lists {
    /// Of a frame.
    ///
    /// # Errors
    /// Where there is no memory for them.
    pub fn new(device: &Device, context: &Context) -> Result<Self, Failure> {
        let list = |bytes: Vec<u8>| device.filled(&bytes, BufferUsages::STORAGE);
        let position = context.viewpoint.position;
        let shift = (context.geometry.anchor - position).as_vec3();
        let anchor = layout::one(&Anchor { shift: shift.extend(0.0) });
        let shapes = shapes(context.geometry, position);
        let rows = context.field.media().rows(position).into_iter();
        let lit: Vec<Vec4> = context.lit_blobs.iter().flat_map(|lit| lit.rows()).collect();
        Ok(Self {
            anchor: device.filled(&anchor, BufferUsages::UNIFORM)?,
            shape_count: shapes.len() as u32,
            shapes: list(layout::list(shapes))?,
            lamps: list(layout::list(lamps(context)))?,
            haze: rows.map(|(_, rows)| list(layout::list(rows))).collect::<Result<_, _>>()?,
            blobs: list(layout::list(blobs(context)))?,
            lit: list(layout::list(lit))?,
            materials: list(layout::list(materials(context)))?,
            rules: device.filled(&RULES, BufferUsages::STORAGE)?,
            tolerance: device.filled(&layout::one(&tolerance(context)), BufferUsages::UNIFORM)?,
        })
    }
}

impl Lists {
    /// What `fogbank::haze` reads, under its numbers.
    pub fn haze(&self) -> impl Iterator<Item = (u32, BindingResource<'_>)> {
        (HAZE_BINDING..)
            .zip(&self.haze)
            .map(|(binding, list)| (binding, list.handle.as_entire_binding()))
    }
}

/// Planes, spheres and boxes relative to the camera.
fn shapes(geometry: &Geometry, position: DVec3) -> Vec<Shape> {
    let shift = geometry.anchor - position;
    let planes = geometry.planes.iter().map(|plane| {
        let height = plane.normal.dot(plane.point + shift) as f32;
        let first = plane.normal.as_vec3().extend(height);
        Shape { first, second: Vec4::ZERO, kind: UVec4::new(0, plane.surface, 0, 0) }
    });
    let place = |local: Vec3| local.as_dvec3() + shift;
    let solids = geometry.solids.iter().filter_map(|solid| match *solid {
        Solid::Triangle(_) => None,
        Solid::Sphere { center, radius, surface } => {
            let center = place(center);
            let power = center.length_squared() - f64::from(radius).powi(2);
            Some(Shape {
                first: center.as_vec3().extend(radius),
                second: Vec3::ZERO.extend(power as f32),
                kind: UVec4::new(1, surface, 0, 0),
            })
        }
        Solid::Box { min, max, surface } => Some(Shape {
            first: place(min).as_vec3().extend(0.0),
            second: place(max).as_vec3().extend(0.0),
            kind: UVec4::new(2, surface, 0, 0),
        }),
    });
    planes.chain(solids).collect()
}

fn lamps(context: &Context) -> Vec<Lamp> {
    let lamp = |(i, lamp): (usize, &crate::frame::context::Lamp)| {
        let position = lamp.from_camera.as_vec3();
        let seen = context.lit_blobs.get(i).map_or(1.0, |lit| lit.homogeneous_factor as f32);
        Lamp {
            position: position.extend(position.length()),
            intensity: lamp.intensity.as_vec3().extend(seen),
            scattered: lamp.scattered.as_vec3().extend(0.0),
        }
    };
    context.lamps.iter().enumerate().map(lamp).collect()
}

fn blobs(context: &Context) -> Vec<Blob> {
    let blobs = context.field.media().gaussians.all();
    // All that are left out weigh less than a picture may lose; where fog is nothing but the tails of
    // blobs, light is scattered by them.
    let all = if context.method == Method::Mapped { TAILS } else { PICTURE_LOSS };
    let loss = all / blobs.len().max(1) as f64;
    let blob = |blob: &crate::media::gaussians::Gaussian| {
        let place = (blob.center - context.viewpoint.position) * blob.a;
        let weight = Vec4::new(blob.half_depth() as f32, blob.reach(loss) as f32, 0.0, 0.0);
        Blob { place: place.as_vec3().extend(blob.a as f32), weight }
    };
    blobs.iter().map(blob).collect()
}

fn materials(context: &Context) -> Vec<Material> {
    let all = context.materials.iter().chain([&context.background]);
    let material = |m: &[f32; 10]| Material {
        diffuse: Vec4::new(m[0], m[1], m[2], m[9]),
        specular: Vec4::new(m[3], m[4], m[5], 0.0),
        emission: Vec4::new(m[6], m[7], m[8], 0.0),
    };
    all.map(material).collect()
}

/// The camera and the picture, its pixels sampled at a place within them; for targets of which a
/// pixel stands for `step` of the picture across and down.
pub fn view(context: &Context, sample: DVec2, targets: Grid, step: usize) -> View {
    let viewpoint = &context.viewpoint;
    let (right, up) = viewpoint.half_axes();
    let (width, height) = (context.grid.width as f32, context.grid.height as f32);
    let [r, g, b] = context.ambient;
    let counts = [step, context.field.lumps(), context.lamps.len()].map(|count| count as u32);
    let exposure = context.view.exposure_ev.exp2() as f32;
    let weighing = if samples::weighs(&context.view) { exposure } else { 0.0 };
    View {
        forward: viewpoint.forward.as_vec3().extend(context.far_m),
        right: right.as_vec3().extend(sample.x as f32),
        up: up.as_vec3().extend(sample.y as f32),
        size: Vec4::new(width, height, targets.width as f32, targets.height as f32),
        ambient: Vec4::new(r, g, b, 0.0),
        optics: Vec4::new(context.phase.g as f32, CUT_OFF, weighing, exposure),
        counts: UVec4::new(u32::from(viewpoint.parallel), counts[0], counts[1], counts[2]),
    }
}
