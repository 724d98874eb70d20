//! Shapes ready for rays: a bounding volume hierarchy over triangles, spheres and boxes, and the
//! infinite planes beside it.

mod corners;
mod hit;
mod mesh;
mod shadow;

pub use corners::Corners;
pub use hit::Hit;
pub use mesh::Triangle;
pub use shadow::{BEHIND, IN_PLANE, LIFT};

use crate::geometry::hierarchy::{Bounds, Hierarchy};
use crate::progress::{Interrupted, Progress};
use crate::scene::{Material, Shape, Surface};
use glam::{DVec3, Vec3};
use std::sync::OnceLock;

/// What a step in the hierarchy costs, in solids that are met: rays of pictures meet many triangles at once, which
/// are read faster in a row than boxes here and there.
const STEP: f32 = 4.0;

/// An infinite plane.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    /// A point of it, relative to the anchor [m].
    pub point: DVec3,
    /// Unit normal.
    pub normal: DVec3,
    /// Place among the scene's surfaces.
    pub surface: u32,
}

/// A ball; coordinates relative to the anchor.
#[derive(Clone, Copy, Debug)]
pub struct Sphere {
    /// Centre [m].
    pub center: Vec3,
    /// Radius [m].
    pub radius: f32,
    /// Place among the scene's surfaces.
    pub surface: u32,
}

/// A box along the axes; coordinates relative to the anchor.
#[derive(Clone, Copy, Debug)]
pub struct Cuboid {
    /// Smallest corner [m].
    pub min: Vec3,
    /// Largest corner [m].
    pub max: Vec3,
    /// Place among the scene's surfaces.
    pub surface: u32,
}

/// Something with an end, as the hierarchy holds it: by its place among its kind.
#[derive(Clone, Copy, Debug)]
pub enum Solid {
    /// In [`Geometry::triangles`].
    Triangle(u32),
    /// In [`Geometry::spheres`].
    Sphere(u32),
    /// In [`Geometry::cuboids`].
    Cuboid(u32),
}

/// All enabled surfaces of a scene.
#[derive(Default)]
pub struct Geometry {
    /// Where the local coordinates start, in the middle of the solids [m]: keeps f32 exact in
    /// scenes far from the origin.
    pub anchor: DVec3,
    /// Infinite planes.
    pub planes: Vec<Plane>,
    /// Triangles of all meshes and heightfields, in the order of the hierarchy's leaves.
    pub triangles: Vec<Triangle>,
    /// Corner normals of smooth triangles, in the same order.
    pub smooth: Vec<[Vec3; 3]>,
    /// Balls.
    pub spheres: Vec<Sphere>,
    /// Boxes.
    pub cuboids: Vec<Cuboid>,
    /// What the hierarchy's leaves hold, in their order.
    pub solids: Vec<Solid>,
    /// The hierarchy over `solids`.
    pub hierarchy: Hierarchy,
    /// Materials, by place among the scene's surfaces.
    pub materials: Vec<Material>,
    /// Whether surfaces throw shadows, by their places.
    throwing: Vec<bool>,
    /// Corners of triangles, each once, from the first time that they are asked for.
    corners: OnceLock<Corners>,
}

impl std::fmt::Debug for Geometry {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Geometry({} planes, {} solids)", self.planes.len(), self.solids.len())
    }
}

impl Geometry {
    /// Builds what rays need from checked surfaces.
    ///
    /// # Errors
    /// [`Interrupted`] when `progress` says so.
    pub fn build(surfaces: &[Surface], progress: &Progress) -> Result<Self, Interrupted> {
        let enabled = || (0u32..).zip(surfaces).filter(|(_, surface)| surface.enabled);
        let anchor = anchor(enabled().map(|(_, surface)| &surface.shape));
        let mut geometry = Self {
            anchor,
            materials: surfaces.iter().map(|surface| surface.material.clone()).collect(),
            throwing: surfaces.iter().map(|surface| surface.shadows).collect(),
            ..Self::default()
        };
        for (place, surface) in enabled() {
            progress.check()?;
            geometry.add(&surface.shape, place);
        }
        geometry.index(progress)?;
        Ok(geometry)
    }

    /// Bytes that it takes, near enough.
    pub fn bytes(&self) -> usize {
        size_of_val(self.triangles.as_slice())
            + self.triangles.len() * Corners::BYTES
            + size_of_val(self.smooth.as_slice())
            + size_of_val(self.spheres.as_slice())
            + size_of_val(self.cuboids.as_slice())
            + size_of_val(self.solids.as_slice())
            + size_of_val(self.materials.as_slice())
            + self.hierarchy.bytes()
    }

    /// Corners of triangles, each once.
    pub fn corners(&self) -> &Corners {
        self.corners.get_or_init(|| Corners::new(&self.triangles))
    }

    /// How far it reaches from the origin of a shift, at least 1 [m].
    pub fn reach(&self, shift: DVec3) -> f64 {
        let Some(root) = self.hierarchy.nodes.first() else { return 1.0 };
        let [min, max] = [root.bounds.min, root.bounds.max].map(|end| end.as_dvec3() + shift);
        min.abs().max(max.abs()).length().max(1.0)
    }

    fn add(&mut self, shape: &Shape, surface: u32) {
        let local = |v: DVec3| (v - self.anchor).as_vec3();
        match shape {
            Shape::Plane(plane) => self.planes.push(Plane {
                point: plane.point.vector() - self.anchor,
                normal: plane.normal.vector().normalize(),
                surface,
            }),
            Shape::Sphere(sphere) => {
                self.solids.push(Solid::Sphere(self.spheres.len() as u32));
                let (center, radius) = (local(sphere.center.vector()), sphere.radius as f32);
                self.spheres.push(Sphere { center, radius, surface });
            }
            Shape::Box(b) => {
                self.solids.push(Solid::Cuboid(self.cuboids.len() as u32));
                let (min, max) = (local(b.min.vector()), local(b.max.vector()));
                self.cuboids.push(Cuboid { min, max, surface });
            }
            Shape::Mesh(mesh) => self.add_triangles(mesh::of_mesh(mesh, self.anchor, surface)),
            Shape::Heightfield(field) => {
                self.add_triangles(mesh::of_heightfield(field, self.anchor, surface));
            }
        }
    }

    fn add_triangles(&mut self, triangles: Vec<(Triangle, Option<[Vec3; 3]>)>) {
        for (mut triangle, normals) in triangles {
            if let Some(normals) = normals {
                triangle.smooth = self.smooth.len() as u32;
                self.smooth.push(normals);
            }
            self.solids.push(Solid::Triangle(self.triangles.len() as u32));
            self.triangles.push(triangle);
        }
    }

    /// Builds the hierarchy and brings solids and triangles into the order of its leaves.
    fn index(&mut self, progress: &Progress) -> Result<(), Interrupted> {
        let bounds = self.solids.iter().map(|solid| self.bounds(solid));
        self.hierarchy = Hierarchy::build(bounds, STEP, progress)?;
        // From now on the solids themselves stand in the order of the leaves.
        let order = std::mem::take(&mut self.hierarchy.items);
        self.solids = order.into_iter().map(|i| self.solids[i as usize]).collect();
        let mut triangles = Vec::with_capacity(self.triangles.len());
        let mut smooth = Vec::with_capacity(self.smooth.len());
        for solid in &mut self.solids {
            let Solid::Triangle(at) = solid else { continue };
            let mut triangle = self.triangles[*at as usize];
            *at = triangles.len() as u32;
            if let Some(normals) = self.smooth.get(triangle.smooth as usize) {
                triangle.smooth = smooth.len() as u32;
                smooth.push(*normals);
            }
            triangles.push(triangle);
        }
        (self.triangles, self.smooth) = (triangles, smooth);
        Ok(())
    }

    fn bounds(&self, solid: &Solid) -> Bounds {
        let (min, max) = match *solid {
            Solid::Triangle(at) => {
                let [a, b, c] = self.triangles[at as usize].corners;
                (a.min(b).min(c), a.max(b).max(c))
            }
            Solid::Sphere(at) => {
                let Sphere { center, radius, .. } = self.spheres[at as usize];
                (center - radius, center + radius)
            }
            Solid::Cuboid(at) => (self.cuboids[at as usize].min, self.cuboids[at as usize].max),
        };
        // Rays are traced in f32 too: room for their rounding.
        let slack = Vec3::splat(1e-6) * min.abs().max(max.abs()) + Vec3::splat(1e-30);
        Bounds { min: min - slack, max: max + slack }
    }
}

/// The middle of everything that has an end.
fn anchor<'a>(shapes: impl Iterator<Item = &'a Shape>) -> DVec3 {
    let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let mut include = |v: DVec3| {
        min = min.min(v);
        max = max.max(v);
    };
    for shape in shapes {
        match shape {
            Shape::Plane(_) => {}
            Shape::Sphere(sphere) => include(sphere.center.vector()),
            Shape::Box(b) => {
                include(b.min.vector());
                include(b.max.vector());
            }
            Shape::Mesh(mesh) => mesh.positions.iter().for_each(|p| include(p.vector())),
            Shape::Heightfield(field) => {
                let [x, z] = field.size;
                include(field.origin.vector());
                include(field.origin.vector() + DVec3::new(x, 0.0, z));
            }
        }
    }
    if min.x <= max.x { 0.5 * (min + max) } else { DVec3::ZERO }
}
