// What the passes that find surfaces have in common: what they write for a pixel.
//
// Distances are compared by the depth buffer in a form that keeps their relative precision at every
// scale: near/t, greatest first.
//
// Twin: the facing rule in core/src/geometry/hit.rs.

#define_import_path fogbank::surfaces

/// The G-buffer of a pixel.
struct Found {
    @builtin(frag_depth) depth: f32,
    /// xyz: unit normal, on the side that the eye sees. w: distance along the ray [m].
    @location(0) hit: vec4<f32>,
    /// Place among the scene's surfaces.
    @location(1) surface: u32,
}

/// Distances below this are one [m].
const NEAREST: f32 = 1e-6;

/// A vector of unit length. Scaled first: the square of a small triangle's normal would vanish.
fn unit_of(vector: vec3<f32>) -> vec3<f32> {
    let size = max(abs(vector.x), max(abs(vector.y), abs(vector.z)));
    let scaled = vector / max(size, 1e-37);
    return scaled / max(length(scaled), 0.5);
}

/// A hit at a distance along a ray in the unit `direction`, with normals of any length and side: that of the
/// surface as it is lit, and that of its face, whose side tells the other's.
fn found(normal: vec3<f32>, face: vec3<f32>, direction: vec3<f32>, distance_m: f32, surface: u32) -> Found {
    let unit = unit_of(normal);
    let flat = unit_of(face);
    let is_behind = (dot(flat, direction) > 0.0) != (dot(flat, unit) < 0.0);
    let facing = select(unit, -unit, is_behind);
    return Found(NEAREST / max(distance_m, NEAREST), vec4<f32>(facing, distance_m), surface);
}
