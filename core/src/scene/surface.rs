//! What stands in the fog: shapes and their materials.

use crate::json::bounded;
use crate::json::document::{Part, parts};
use crate::json::limits::{self, COUNTS};
use crate::json::tagged::tagged;
use crate::json::{Albedo, Rgb, Vec3};
use crate::shared::Shared;
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

/// Reads the surfaces of a scene; what they take together is bounded.
pub fn list<'de, D: Deserializer<'de>>(input: D) -> Result<Vec<Surface>, D::Error> {
    let rows = |surface: &Surface| match &surface.shape {
        Shape::Heightfield(field) => field.heights.len(),
        _ => 0,
    };
    bounded::list_in_all::<{ COUNTS.surfaces }, _, _>(input, limits::GRID_ROWS, rows)
}

/// One visible thing. Surfaces are two-sided.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Surface {
    /// Name of this surface, unique among the surfaces.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1, max = limits::COUNTS.id_chars))]
    pub id: Option<String>,
    /// False hides it.
    pub enabled: bool,
    /// Whether it throws shadows; false lets light through, as the glass around a lamp does.
    pub shadows: bool,
    /// Its form.
    pub shape: Shape,
    /// How it reflects and glows.
    pub material: Material,
}

parts!(Surface { shape });

impl Part for Shape {
    fn values(&self) -> usize {
        match self {
            Self::Mesh(mesh) => 16 + 4 * (mesh.positions.len() + mesh.indices.len()),
            Self::Heightfield(field) => 16 + field.heights.iter().map(Vec::len).sum::<usize>(),
            Self::Plane(_) | Self::Sphere(_) | Self::Box(_) => 16,
        }
    }
}

impl Default for Surface {
    fn default() -> Self {
        let shape = Shape::Plane(Plane::default());
        Self { id: None, enabled: true, shadows: true, shape, material: Material::default() }
    }
}

/// How a surface reflects and glows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Material {
    /// Diffuse albedo ρ: the BRDF is ρ/π.
    pub diffuse: Albedo,
    /// Strength of the mirror-like lobe (Sun's k_s): it reflects `specular` · I · cosⁿ of the angle
    /// to the mirrored light, not normalised.
    pub specular: Rgb,
    /// Exponent n of that lobe: large is a small, sharp highlight.
    #[schemars(range(min = limits::SHININESS.min, max = limits::SHININESS.max))]
    pub shininess: f64,
    /// Radiance that the surface sends out by itself [W/(m² sr)].
    #[schemars(extend("x-usual" = limits::USUAL_RADIANCE))]
    pub emission: Rgb,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            diffuse: Albedo::splat(0.5),
            specular: Rgb::splat(0.0),
            shininess: 20.0,
            emission: Rgb::splat(0.0),
        }
    }
}

tagged!(
    /// The form of a surface.
    Shape {
        /// An infinite plane.
        Plane = "plane",
        /// A ball.
        Sphere = "sphere",
        /// A box along the axes; closed, and it may be seen from inside.
        Box = "box",
        /// Triangles.
        Mesh = "mesh",
        /// A terrain over a grid.
        Heightfield = "heightfield",
    }
);

/// An infinite plane.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Plane {
    /// Any point of it [m].
    pub point: Vec3,
    /// Its normal; any length but zero.
    #[schemars(extend("not" = { "const": [0, 0, 0] }))]
    pub normal: Vec3,
}

impl Default for Plane {
    fn default() -> Self {
        Self { point: Vec3::splat(0.0), normal: Vec3([0.0, 1.0, 0.0]) }
    }
}

/// A ball.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Sphere {
    /// Its centre [m].
    pub center: Vec3,
    /// Its radius [m].
    #[schemars(range(min = limits::RADIUS.min, max = limits::RADIUS.max))]
    pub radius: f64,
}

impl Default for Sphere {
    fn default() -> Self {
        Self { center: Vec3::splat(0.0), radius: 1.0 }
    }
}

/// A box along the axes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Box {
    /// The corner with the smallest coordinates [m].
    pub min: Vec3,
    /// The corner with the largest coordinates [m]; above `min` on every axis.
    pub max: Vec3,
}

impl Default for Box {
    fn default() -> Self {
        Self { min: Vec3::splat(-0.5), max: Vec3::splat(0.5) }
    }
}

/// Triangles. Without `normals` each triangle is flat.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Mesh {
    /// The corners [m].
    #[serde(deserialize_with = "bounded::shared::<{ COUNTS.vertices }, _, _>")]
    #[schemars(length(max = COUNTS.vertices))]
    pub positions: Shared<Vec<Vec3>>,
    /// Three places in `positions` for each triangle.
    #[serde(deserialize_with = "bounded::shared::<{ COUNTS.triangles }, _, _>")]
    #[schemars(length(max = COUNTS.triangles), inner(inner(range(max = COUNTS.vertices - 1))))]
    pub indices: Shared<Vec<[u32; 3]>>,
    /// One normal for each position, for smooth shading.
    #[serde(
        deserialize_with = "bounded::shared_or_null::<{ COUNTS.vertices }, _, _>",
        skip_serializing_if = "Option::is_none"
    )]
    #[schemars(length(max = COUNTS.vertices))]
    pub normals: Option<Shared<Vec<Vec3>>>,
}

/// A terrain: heights over a grid, two triangles a cell, shaded smoothly.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Heightfield {
    /// The corner with the smallest x and z [m]; heights count from its y.
    pub origin: Vec3,
    /// Its length along x and along z [m].
    #[schemars(inner(range(min = limits::RADIUS.min, max = limits::RADIUS.max)))]
    pub size: [f64; 2],
    /// Heights [m]: rows along +z, each of the same length along +x, at least 2×2.
    #[serde(deserialize_with = "bounded::rows::<{ limits::GRID_SIDE }, _, _>")]
    #[schemars(
        length(min = 2, max = limits::GRID_SIDE),
        inner(
            length(min = 2, max = limits::GRID_SIDE),
            inner(range(min = limits::COORDINATE.min, max = limits::COORDINATE.max))
        ),
        extend("x-items-in-all" = limits::GRID_ROWS)
    )]
    pub heights: Shared<Vec<Vec<f64>>>,
}

impl Default for Heightfield {
    fn default() -> Self {
        Self { origin: Vec3::splat(0.0), size: [1.0, 1.0], heights: vec![vec![0.0; 2]; 2].into() }
    }
}
