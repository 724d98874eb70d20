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
    /// xyz: unit normal, towards the eye. w: distance along the ray [m].
    @location(0) hit: vec4<f32>,
    /// Place among the scene's surfaces.
    @location(1) surface: u32,
}

/// Distances below this are one [m].
const NEAREST: f32 = 1e-6;

/// A hit at a distance along a ray in the unit `direction`, with a normal of any length and side.
fn found(normal: vec3<f32>, direction: vec3<f32>, distance_m: f32, surface: u32) -> Found {
    // Scaled first: the square of a small triangle's normal would vanish.
    let size = max(abs(normal.x), max(abs(normal.y), abs(normal.z)));
    let scaled = normal / max(size, 1e-37);
    let unit = scaled / max(length(scaled), 0.5);
    let facing = select(unit, -unit, dot(unit, direction) > 0.0);
    return Found(NEAREST / max(distance_m, NEAREST), vec4<f32>(facing, distance_m), surface);
}
