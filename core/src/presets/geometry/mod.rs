//! Meshes from a few lines of description. Triangles wind counter-clockwise seen from outside.

mod facade;
mod revolve;
mod shading;
mod sweep;

pub use facade::Facade;
pub use revolve::{ball, lathe, lathe_with, spline};
pub use sweep::{along, bezier, rod, tube};

use crate::scene::Mesh;
use glam::{DAffine3, DVec3};

/// Triangles that grow part by part until they become a [`Mesh`].
#[derive(Clone, Debug, Default)]
pub struct MeshBuilder {
    positions: Vec<DVec3>,
    indices: Vec<[u32; 3]>,
}

impl MeshBuilder {
    /// Adds a corner and answers its place.
    pub fn vertex(&mut self, position: DVec3) -> u32 {
        self.positions.push(position);
        self.positions.len() as u32 - 1
    }

    /// Adds a triangle between known corners.
    pub fn triangle(&mut self, corners: [u32; 3]) {
        self.indices.push(corners);
    }

    /// Adds two triangles between four known corners, in order around them.
    pub fn quad(&mut self, [a, b, c, d]: [u32; 4]) {
        self.indices.push([a, b, c]);
        self.indices.push([a, c, d]);
    }

    /// Adds four corners, in order around them, and the face between them.
    pub fn face(&mut self, corners: [DVec3; 4]) {
        let places = corners.map(|corner| self.vertex(corner));
        self.quad(places);
    }

    /// Adds a copy of another part, moved by `place`.
    pub fn add(&mut self, part: &Self, place: DAffine3) {
        let first = self.positions.len() as u32;
        self.positions.extend(part.positions.iter().map(|p| place.transform_point3(*p)));
        self.indices.extend(part.indices.iter().map(|t| t.map(|corner| first + corner)));
    }

    /// Adds a copy of another part, shifted.
    pub fn add_at(&mut self, part: &Self, offset: DVec3) {
        self.add(part, DAffine3::from_translation(offset));
    }

    /// Adds a box along the axes.
    pub fn block(&mut self, min: DVec3, max: DVec3) {
        self.frustum([min, max], DVec3::ZERO);
    }

    /// Adds a box whose upper face is drawn in by `inset.x` and `inset.z` on every side: a
    /// paving stone, a plinth, a pyramid.
    pub fn frustum(&mut self, [min, max]: [DVec3; 2], inset: DVec3) {
        let ring = |low: DVec3, high: DVec3, y: f64| {
            [(low.x, low.z), (low.x, high.z), (high.x, high.z), (high.x, low.z)]
                .map(|(x, z)| DVec3::new(x, y, z))
        };
        let inset = DVec3::new(inset.x, 0.0, inset.z);
        let low = ring(min, max, min.y).map(|p| self.vertex(p));
        let high = ring(min + inset, max - inset, max.y).map(|p| self.vertex(p));
        for k in 0..4 {
            let next = (k + 1) % 4;
            self.quad([low[k], low[next], high[next], high[k]]);
        }
        self.quad(high);
        self.quad([low[3], low[2], low[1], low[0]]);
    }

    /// Adds a box whose twelve edges are cut off by `bevel`.
    pub fn beveled_block(&mut self, min: DVec3, max: DVec3, bevel: f64) {
        let cut = DVec3::new(bevel, 0.0, bevel);
        let rise = DVec3::new(0.0, bevel, 0.0);
        let levels = [
            (min + cut, max - cut, min.y),
            (min, max, min.y + rise.y),
            (min, max, max.y - rise.y),
            (min + cut, max - cut, max.y),
        ];
        let rings = levels.map(|(low, high, y)| {
            eight_corners(low, high, bevel, y).map(|corner| self.vertex(corner))
        });
        for pair in rings.windows(2) {
            for k in 0..8 {
                let next = (k + 1) % 8;
                self.quad([pair[0][k], pair[0][next], pair[1][next], pair[1][k]]);
            }
        }
        for k in 1..7 {
            self.triangle([rings[3][0], rings[3][k], rings[3][k + 1]]);
            self.triangle([rings[0][0], rings[0][k + 1], rings[0][k]]);
        }
    }

    /// Adds a cone without a floor that stands on `foot`, between two heights above it.
    pub fn cone(&mut self, foot: DVec3, [low, high]: [f64; 2], radius: f64, turn: f64, sides: u32) {
        let top = self.vertex(foot + DVec3::Y * high);
        let ring: Vec<u32> = (0..sides)
            .map(|k| {
                let angle = turn - std::f64::consts::TAU * f64::from(k) / f64::from(sides);
                let out = DVec3::new(angle.cos(), 0.0, angle.sin()) * radius;
                self.vertex(foot + out + DVec3::Y * low)
            })
            .collect();
        for (k, corner) in ring.iter().enumerate() {
            self.triangle([*corner, ring[(k + 1) % ring.len()], top]);
        }
    }

    /// The same with its corners rounded to 1 / `steps`, for what is seen from afar.
    pub fn rounded(mut self, steps: f64) -> Self {
        for corner in &mut self.positions {
            *corner = crate::rounding::rounded(*corner, steps).vector();
        }
        self
    }

    /// The mesh with flat triangles, for what is made of planes.
    pub fn flat(self) -> Mesh {
        let positions = self.positions.iter().map(|p| crate::rounding::rounded(*p, 1e3)).collect();
        Mesh { positions, indices: self.indices.into(), normals: None }
    }
}

/// The corners of a rectangle without its corners, counter-clockwise seen from above.
fn eight_corners(low: DVec3, high: DVec3, cut: f64, y: f64) -> [DVec3; 8] {
    [
        (low.x, low.z + cut),
        (low.x, high.z - cut),
        (low.x + cut, high.z),
        (high.x - cut, high.z),
        (high.x, high.z - cut),
        (high.x, low.z + cut),
        (high.x - cut, low.z),
        (low.x + cut, low.z),
    ]
    .map(|(x, z)| DVec3::new(x, y, z))
}
