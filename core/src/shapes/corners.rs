//! Corners of triangles, each once: neighbours of a mesh share them.

use super::Triangle;
use glam::Vec3;
use std::collections::HashMap;

/// Corners of triangles.
#[derive(Debug, Default)]
pub struct Corners {
    /// Where they are, relative to the geometry's anchor [m]: about in the order of the triangles.
    pub places: Vec<Vec3>,
    /// Those of every triangle, by place.
    pub of: Vec<[u32; 3]>,
    /// The longest side of every triangle [m].
    pub longest: Vec<f32>,
}

impl Corners {
    /// The most that they take a triangle: four numbers, and three places where it shares none.
    pub const BYTES: usize = 52;

    /// Of some triangles.
    pub fn new(triangles: &[Triangle]) -> Self {
        let longest = triangles.iter().map(longest_side).collect();
        let mut corners = Self { longest, ..Self::default() };
        let mut known = HashMap::with_capacity(triangles.len());
        for triangle in triangles {
            corners.of.push(triangle.corners.map(|place| {
                *known.entry(place.to_array().map(f32::to_bits)).or_insert_with(|| {
                    corners.places.push(place);
                    corners.places.len() as u32 - 1
                })
            }));
        }
        corners
    }
}

fn longest_side(triangle: &Triangle) -> f32 {
    let [a, b, c] = triangle.corners;
    a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a)).sqrt()
}
