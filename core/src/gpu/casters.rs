//! What throws shadows, brought to the device: on surfaces by the hierarchy over all solids, in fog by rows of heights.

use super::device::{Buffer, Device, Failure};
use super::layout::{self, Counts, Shaft};
use crate::frame::context::Context;
use crate::frame::shafts::{Ends, Shafts};
use crate::shapes::{Geometry, Solid};
use glam::{UVec4, Vec3};
use wgpu::{BindingResource, BufferUsages};

/// Planes, nodes and solids, row by row (`shaders/casters.wgsl`).
#[derive(Debug)]
pub struct Casters {
    /// The rows.
    pub rows: Buffer,
    planes: u32,
    nodes: u32,
}

impl Casters {
    /// Of a geometry.
    ///
    /// # Errors
    /// Where there is no memory for them.
    pub fn new(device: &Device, geometry: &Geometry) -> Result<Self, Failure> {
        let planes = geometry.planes.iter().filter(|plane| geometry.throws(plane.surface));
        let planes = planes.map(|plane| {
            let height = plane.normal.dot(plane.point) as f32;
            row(plane.normal.as_vec3(), height.to_bits())
        });
        let planes: Vec<UVec4> = planes.collect();
        let nodes =
            geometry.hierarchy.nodes.iter().flat_map(|node| {
                [row(node.bounds.min, node.first), row(node.bounds.max, node.count)]
            });
        let solids = geometry.solids.iter().flat_map(|solid| solid_rows(geometry, solid));
        let counts = (planes.len() as u32, geometry.hierarchy.nodes.len() as u32);
        let rows: Vec<UVec4> = planes.into_iter().chain(nodes).chain(solids).collect();
        Ok(Self {
            rows: device.filled(&layout::list(rows), BufferUsages::STORAGE)?,
            planes: counts.0,
            nodes: counts.1,
        })
    }

    /// How many of each there are, as a camera sees them.
    ///
    /// # Errors
    /// Where there is no memory for them.
    pub fn counts(&self, device: &Device, context: &Context) -> Result<Buffer, Failure> {
        let shift = (context.viewpoint.position - context.geometry.anchor).as_vec3();
        let counts = Counts { shift, planes: self.planes, nodes: self.nodes };
        device.filled(&layout::one(&counts), BufferUsages::UNIFORM)
    }
}

/// A solid's rows; one that throws no shadow is none of the known kinds.
fn solid_rows(geometry: &Geometry, solid: &Solid) -> [UVec4; 3] {
    const NONE: u32 = u32::MAX;
    let (places, number, kind, surface) = match *solid {
        Solid::Triangle(at) => {
            let triangle = &geometry.triangles[at as usize];
            (triangle.corners, 0.0, 0, triangle.surface)
        }
        Solid::Sphere(at) => {
            let sphere = &geometry.spheres[at as usize];
            ([sphere.center, Vec3::ZERO, Vec3::ZERO], sphere.radius, 1, sphere.surface)
        }
        Solid::Cuboid(at) => {
            let cuboid = &geometry.cuboids[at as usize];
            ([cuboid.min, cuboid.max, Vec3::ZERO], 0.0, 2, cuboid.surface)
        }
    };
    let [a, b, c] = places;
    let kind = if geometry.throws(surface) { kind } else { NONE };
    [row(a, number.to_bits()), row(b, 0), row(c, kind)]
}

/// Three numbers by their bits, and one more word: small whole numbers would be no normal floats.
fn row(place: Vec3, word: u32) -> UVec4 {
    let [x, y, z] = place.to_array().map(f32::to_bits);
    UVec4::new(x, y, z, word)
}

/// The rows of heights of all lamps.
#[derive(Debug)]
pub struct Rows {
    /// What each lamp's rows are.
    pub shafts: Buffer,
    /// Their heights, one lamp after the other.
    pub heights: Buffer,
}

impl Rows {
    /// Both, under the numbers of `fogbank::grid::shafts`.
    pub fn entries(&self) -> [(u32, BindingResource<'_>); 2] {
        [(18, &self.shafts), (19, &self.heights)]
            .map(|(binding, buffer)| (binding, buffer.handle.as_entire_binding()))
    }

    /// Of a frame's lamps, some of which may have none.
    ///
    /// # Errors
    /// Where there is no memory for them.
    pub fn new(device: &Device, context: &Context) -> Result<Self, Failure> {
        let of_lamps = || context.lamps.iter().map(|lamp| lamp.shafts.as_deref());
        let mut place = 0;
        let shaft = |shafts: Option<&Shafts>| {
            let own = shafts.map_or(Shaft::default(), |shafts| shaft(shafts, place));
            place += shafts.map_or(0, |shafts| shafts.heights().len() as u32);
            own
        };
        let list = layout::list(of_lamps().map(shaft).collect());
        let heights = device.joined(of_lamps().flatten().map(Shafts::heights))?;
        Ok(Self { shafts: device.filled(&list, BufferUsages::STORAGE)?, heights })
    }
}

fn shaft(shafts: &Shafts, place: u32) -> Shaft {
    let pencil = &shafts.pencil;
    let [right, up] = pencil.across.map(|unit| unit.as_vec3());
    let ends = match pencil.ends {
        Ends::Both => 0,
        Ends::Eye => 1,
        Ends::Lamp => 2,
        Ends::Neither => 3,
    };
    Shaft {
        origin: pencil.origin.as_vec3(),
        ends,
        axis: pencil.axis.as_vec3(),
        far: pencil.far as f32,
        right,
        middle: pencil.middle as f32,
        up,
        first: shafts.first as f32,
        density: (1.0 / shafts.step) as f32,
        begin: shafts.angles[0] as f32,
        scale: (shafts.bins as f64 / (shafts.angles[1] - shafts.angles[0])) as f32,
        slices: shafts.slices as u32,
        bins: shafts.bins as u32,
        place,
    }
}
