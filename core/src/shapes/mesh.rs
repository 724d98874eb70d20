//! Triangles of meshes and heightfields.

use crate::scene::{Heightfield, Mesh};
use glam::{DVec3, Vec3};

/// A triangle; coordinates relative to the geometry's anchor.
#[derive(Clone, Copy, Debug)]
pub struct Triangle {
    /// Its corners [m].
    pub corners: [Vec3; 3],
    /// Place among the scene's surfaces.
    pub surface: u32,
    /// Place of its corner normals, or [`Triangle::FLAT`].
    pub smooth: u32,
}

impl Triangle {
    /// Marks a triangle without corner normals.
    pub const FLAT: u32 = u32::MAX;

    /// Unnormalised face normal.
    pub fn face(&self) -> Vec3 {
        let [a, b, c] = self.corners;
        (b - a).cross(c - a)
    }
}

type Smooth = (Triangle, Option<[Vec3; 3]>);

/// Triangles of a mesh, those without area left out.
pub fn of_mesh(mesh: &Mesh, anchor: DVec3, surface: u32) -> Vec<Smooth> {
    let corner = |i: u32| (mesh.positions[i as usize].vector() - anchor).as_vec3();
    let triangles = mesh.indices.iter().map(|&indices| {
        let triangle = Triangle { corners: indices.map(corner), surface, smooth: Triangle::FLAT };
        let normals = mesh
            .normals
            .as_ref()
            .map(|normals| indices.map(|i| normals[i as usize].vector().normalize().as_vec3()));
        (triangle, normals)
    });
    triangles.filter(|(triangle, _)| triangle.face() != Vec3::ZERO).collect()
}

/// Two triangles for every cell of a heightfield, with normals from central differences.
pub fn of_heightfield(field: &Heightfield, anchor: DVec3, surface: u32) -> Vec<Smooth> {
    let (rows, columns) = (field.heights.len(), field.heights[0].len());
    let step_x = field.size[0] / (columns - 1) as f64;
    let step_z = field.size[1] / (rows - 1) as f64;
    let point = |i: usize, j: usize| {
        let offset = DVec3::new(i as f64 * step_x, field.heights[j][i], j as f64 * step_z);
        (field.origin.vector() + offset - anchor).as_vec3()
    };
    let normal = |i: usize, j: usize| {
        let (west, east) = (i.saturating_sub(1), (i + 1).min(columns - 1));
        let (north, south) = (j.saturating_sub(1), (j + 1).min(rows - 1));
        let slope_x = field.heights[j][east] - field.heights[j][west];
        let slope_z = field.heights[south][i] - field.heights[north][i];
        let along_x = slope_x / ((east - west) as f64 * step_x);
        let along_z = slope_z / ((south - north) as f64 * step_z);
        DVec3::new(-along_x, 1.0, -along_z).normalize().as_vec3()
    };
    let mut triangles = Vec::with_capacity(2 * (rows - 1) * (columns - 1));
    for j in 0..rows - 1 {
        for i in 0..columns - 1 {
            let [a, b, c, d] = [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)];
            for corners in [[a, c, b], [b, c, d]] {
                let triangle = Triangle {
                    corners: corners.map(|(i, j)| point(i, j)),
                    surface,
                    smooth: Triangle::FLAT,
                };
                triangles.push((triangle, Some(corners.map(|(i, j)| normal(i, j)))));
            }
        }
    }
    triangles
}
