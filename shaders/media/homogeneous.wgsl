// Fog that is the same everywhere: β(x) = β₀, T(a, b) = β₀ |a − b| (Sun 2005, eq. 3).
//
// A medium in closed form: the generated module `fogbank::haze` sums these functions over its rows.
//
// Twin: core/src/media/homogeneous.rs.

#define_import_path fogbank::media::homogeneous

/// A row as the host writes it.
struct Row {
    /// x: extinction β₀ [1/m]. yzw: unused.
    optics: vec4<f32>,
}

/// Ray parameters at which β jumps or kinks, of one row.
const EDGES: u32 = 0u;

/// β at a point, from the camera [1/m].
fn extinction(row: Row, point: vec3<f32>) -> f32 {
    return row.optics.x;
}

/// The mean of β between two points [1/m].
fn mean(row: Row, a: vec3<f32>, b: vec3<f32>) -> f32 {
    return row.optics.x;
}

/// The least β anywhere, and the most [1/m].
fn bounds(row: Row) -> vec2<f32> {
    return row.optics.xx;
}

/// The ray parameter of an edge [m].
fn edge(row: Row, which: u32, origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    return -1.0;
}
