// First hits of triangles, rasterised: what covers a pixel is found by the rasteriser, where its
// ray meets the triangle is computed from the triangle's plane.
//
// For targets of the full picture (step 1). Triangles are read from storage, three vertices each,
// relative to an anchor in their midst.
//
// Twins: meet_triangle in core/src/geometry/hit.rs, core/src/cpu/triangle.rs.

#import fogbank::view
#import fogbank::surfaces

/// A triangle, relative to the anchor.
struct Triangle {
    /// Its corners [m].
    a: vec3<f32>,
    /// Its place among the scene's surfaces.
    surface: u32,
    b: vec3<f32>,
    /// The place of its corner normals, or FLAT.
    normals: u32,
    c: vec3<f32>,
}

/// Unit normals at a triangle's corners.
struct Smooth {
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
}

struct Anchor {
    /// The anchor, from the camera [m].
    shift: vec3<f32>,
}

struct Corner {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) triangle: u32,
}

/// Marks a triangle without corner normals.
const FLAT: u32 = 0xffffffffu;

@group(0) @binding(0) var<uniform> frame: view::View;
@group(0) @binding(1) var<uniform> anchor: Anchor;
@group(0) @binding(2) var<storage, read> triangles: array<Triangle>;
@group(0) @binding(3) var<storage, read> smooth_normals: array<Smooth>;

@vertex
fn project(@builtin(vertex_index) index: u32) -> Corner {
    let triangle = triangles[index / 3u];
    var point = triangle.a;
    switch index % 3u {
        case 1u: { point = triangle.b; }
        case 2u: { point = triangle.c; }
        default: {}
    }
    let at = view::picture_place(frame, point + anchor.shift);
    if view::is_parallel(frame) {
        return Corner(vec4<f32>(view::target_place(frame, at.xy, 1.0), 0.5, 1.0), index / 3u);
    }
    let place = view::target_place(frame, at.xy, at.z);
    return Corner(vec4<f32>(place, frame.cut_off_m, at.z), index / 3u);
}

@fragment
fn meet(corner: Corner) -> surfaces::Found {
    let triangle = triangles[corner.triangle];
    let ray = view::ray_of(frame, vec2<u32>(corner.clip.xy));
    let shift = anchor.shift - ray.offset;
    let sides = mat3x3<f32>(
        triangle.c - triangle.b,
        triangle.a - triangle.c,
        triangle.b - triangle.a,
    );
    let corners = mat3x3<f32>(
        triangle.a + shift,
        triangle.b + shift,
        triangle.c + shift,
    );
    let face = cross(sides[2], -sides[1]);
    let distance_m = distance_to(corners, face, ray.direction);
    if !(distance_m > 0.0 && distance_m < frame.far_m) {
        discard;
    }
    var normal = face;
    let place = triangle.normals;
    if place != FLAT {
        normal = smooth_normal(smooth_normals[place], corners, sides, ray.direction);
    }
    return surfaces::found(normal, face, ray.direction, distance_m, triangle.surface);
}

/// Where the ray meets the triangle's plane, kept between its nearest and farthest corner: along an
/// edge the rasteriser also covers rays that pass it by a hair.
fn distance_to(corners: mat3x3<f32>, face: vec3<f32>, direction: vec3<f32>) -> f32 {
    let forward = frame.forward;
    let depths = vec3<f32>(
        dot(corners[0], forward),
        dot(corners[1], forward),
        dot(corners[2], forward),
    );
    let per_depth = 1.0 / max(dot(direction, forward), 1e-6);
    let nearest = min(depths.x, min(depths.y, depths.z)) * per_depth;
    let farthest = max(depths.x, max(depths.y, depths.z)) * per_depth;
    let slope = dot(direction, face);
    let safe = select(slope, select(1e-37, -1e-37, slope < 0.0), abs(slope) < 1e-37);
    return clamp(dot(corners[0], face) / safe, nearest, farthest);
}

/// The corner normals' mean at the hit, weighed by edge functions: volumes of the direction with
/// the sides.
fn smooth_normal(
    normals: Smooth,
    corners: mat3x3<f32>,
    sides: mat3x3<f32>,
    direction: vec3<f32>,
) -> vec3<f32> {
    let volumes = vec3<f32>(
        dot(direction, cross(corners[1], sides[0])),
        dot(direction, cross(corners[2], sides[1])),
        dot(direction, cross(corners[0], sides[2])),
    );
    let sum = volumes.x + volumes.y + volumes.z;
    let weights = max(volumes * sign(sum), vec3<f32>(0.0));
    let total = max(weights.x + weights.y + weights.z, 1e-37);
    return (weights.x * normals.a + weights.y * normals.b + weights.z * normals.c) / total;
}
