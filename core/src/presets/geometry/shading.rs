//! Smooth normals that keep sharp edges sharp.

use super::MeshBuilder;
use crate::rounding::rounded;
use crate::scene::{Mesh, Vec3};
use glam::DVec3;

/// Faces that meet at a smaller angle are shaded as one curved surface: cos 40°.
const CREASE_COSINE: f64 = 0.766;

impl MeshBuilder {
    /// The mesh with normals, smooth where faces meet at less than 40° and sharp elsewhere.
    ///
    /// A corner on a sharp edge is repeated, once for each of its normals.
    pub fn smooth(self) -> Mesh {
        let faces: Vec<DVec3> = self.indices.iter().map(|t| self.area_normal(*t)).collect();
        let around = self.faces_around();
        let (mut mesh, mut normals) = (Mesh::default(), Vec::new());
        let mut copies = Copies::of(self.positions.len());
        for (face, triangle) in self.indices.iter().enumerate() {
            let corners = triangle.map(|corner| {
                let normal = corner_normal(faces[face], around.of(corner), &faces);
                // Thousandths are finer than the eye, and equal normals become one vertex.
                let normal = rounded(normal, 1e3);
                copies.find(corner, normal, &normals).unwrap_or_else(|| {
                    mesh.positions.push(rounded(self.positions[corner as usize], 1e3));
                    normals.push(normal);
                    copies.add(corner)
                })
            });
            mesh.indices.push(corners);
        }
        Mesh { normals: Some(normals.into()), ..mesh }
    }

    /// The normal of a triangle; its length is twice the area.
    fn area_normal(&self, triangle: [u32; 3]) -> DVec3 {
        let [a, b, c] = triangle.map(|corner| self.positions[corner as usize]);
        (b - a).cross(c - a)
    }

    fn faces_around(&self) -> FacesAround {
        let mut starts = vec![0u32; self.positions.len() + 1];
        for corner in self.indices.iter().flatten() {
            starts[*corner as usize + 1] += 1;
        }
        for k in 1..starts.len() {
            starts[k] += starts[k - 1];
        }
        let mut next = starts.clone();
        let mut faces = vec![0u32; self.indices.len() * 3];
        for (face, triangle) in self.indices.iter().enumerate() {
            for corner in triangle {
                faces[next[*corner as usize] as usize] = face as u32;
                next[*corner as usize] += 1;
            }
        }
        FacesAround { starts, faces }
    }
}

/// For each corner the faces that meet there, in one list.
struct FacesAround {
    starts: Vec<u32>,
    faces: Vec<u32>,
}

impl FacesAround {
    fn of(&self, corner: u32) -> &[u32] {
        let (start, end) = (self.starts[corner as usize], self.starts[corner as usize + 1]);
        &self.faces[start as usize..end as usize]
    }
}

/// For each corner the vertices of the mesh that repeat it, as chained lists.
struct Copies {
    newest: Vec<Option<u32>>,
    older: Vec<Option<u32>>,
}

impl Copies {
    fn of(corners: usize) -> Self {
        Self { newest: vec![None; corners], older: Vec::new() }
    }

    fn find(&self, corner: u32, normal: Vec3, normals: &[Vec3]) -> Option<u32> {
        let mut copy = self.newest[corner as usize];
        while let Some(vertex) = copy.filter(|vertex| normals[*vertex as usize] != normal) {
            copy = self.older[vertex as usize];
        }
        copy
    }

    fn add(&mut self, corner: u32) -> u32 {
        let vertex = self.older.len() as u32;
        self.older.push(self.newest[corner as usize].replace(vertex));
        vertex
    }
}

fn corner_normal(own: DVec3, around: &[u32], faces: &[DVec3]) -> DVec3 {
    let direction = own.normalize_or(DVec3::Y);
    let smooth = around.iter().map(|face| faces[*face as usize]).filter(|other| {
        let cosine = other.dot(direction);
        cosine > 0.0 && cosine * cosine >= CREASE_COSINE.powi(2) * other.length_squared()
    });
    smooth.sum::<DVec3>().normalize_or(direction)
}
