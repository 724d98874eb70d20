// The camera as rays: pixel (i, j) looks through its centre, row 0 at the top. Everything is
// relative to the camera, so that f32 suffices wherever the scene lies.
//
// Twins: core/src/cpu/viewpoint.rs, and what every pass reads of core/src/cpu/frame.rs (Context).

#define_import_path fogbank::view

/// The camera, the picture and the fog's own numbers.
struct View {
    /// xyz: unit view direction. w: where a ray that meets nothing ends [m].
    forward: vec4<f32>,
    /// xyz: from the middle of the picture to its right edge: per metre of depth under perspective,
    /// else in metres. w: where a pixel is sampled, across; ½ is its centre.
    right: vec4<f32>,
    /// xyz: from the middle of the picture to its upper edge, likewise. w: where a pixel is
    /// sampled, down.
    up: vec4<f32>,
    /// Pixels of the full picture across (x) and down (y), of the targets across (z) and down (w).
    size: vec4<f32>,
    /// rgb: radiance of the veil. w: unused.
    ambient: vec4<f32>,
    /// x: mean cosine g of the phase function. y: depth at which triangles are cut off in front
    /// [m]. z: exposure by which samples of a pixel are weighed, 0 if all count the same. w:
    /// exposure of a picture for a screen.
    optics: vec4<f32>,
    /// x: 1 if all rays are parallel. y: pixels of the full picture from one pixel of the targets
    /// to the next, 4 in a draft's low resolution, else 1. z: blobs. w: lamps.
    counts: vec4<u32>,
}

/// A part of a list that one pass or one dispatch works on.
struct Span {
    /// x: the first. y: one past the last. zw: as the pass says.
    range: vec4<u32>,
}

/// A view ray.
struct Ray {
    /// Where it starts [m]; zero under perspective.
    offset: vec3<f32>,
    /// Unit vector.
    direction: vec3<f32>,
}

/// Marks a pixel that sees no surface.
const NOTHING: u32 = 0xffffffffu;

fn is_parallel(view: View) -> bool {
    return view.counts.x == 1u;
}

/// Whether a pixel of the targets exists.
fn is_inside(view: View, pixel: vec2<u32>) -> bool {
    return all(pixel < vec2<u32>(view.size.zw));
}

/// Place of a pixel of the targets in their buffers.
fn index_of(view: View, pixel: vec2<u32>) -> u32 {
    return pixel.y * u32(view.size.z) + pixel.x;
}

/// The pixel of the full picture that a pixel of the targets stands for.
fn pixel_of(view: View, pixel: vec2<u32>) -> vec2<u32> {
    let step = view.counts.y;
    // Beyond the right and the lower edge of a low resolution the last pixel is repeated.
    return min(pixel * step + step / 2u, vec2<u32>(view.size.xy) - 1u);
}

/// Where a pixel of the targets is sampled, in pixels from the full picture's upper left corner.
fn sample_of(view: View, pixel: vec2<u32>) -> vec2<f32> {
    return vec2<f32>(pixel_of(view, pixel)) + vec2<f32>(view.right.w, view.up.w);
}

/// The ray through a place of the full picture [px].
fn ray_through(view: View, place: vec2<f32>) -> Ray {
    let at = 2.0 * place / view.size.xy - 1.0;
    let aside = at.x * view.right.xyz - at.y * view.up.xyz;
    if is_parallel(view) {
        return Ray(aside, view.forward.xyz);
    }
    return Ray(vec3<f32>(0.0), normalize(view.forward.xyz + aside));
}

/// The ray of a pixel of the targets.
fn ray_of(view: View, pixel: vec2<u32>) -> Ray {
    return ray_through(view, sample_of(view, pixel));
}

/// Coordinates of a point in the picture, before the division by depth: −1 to 1, y up; and its
/// depth [m].
fn picture_place(view: View, point: vec3<f32>) -> vec3<f32> {
    let x = dot(point, view.right.xyz) / dot(view.right.xyz, view.right.xyz);
    let y = dot(point, view.up.xyz) / dot(view.up.xyz, view.up.xyz);
    return vec3<f32>(x, y, dot(point, view.forward.xyz));
}

/// Clip coordinates, before the division by `depth`, for targets whose pixels are sampled elsewhere
/// than in their centres.
fn target_place(view: View, at: vec2<f32>, depth: f32) -> vec2<f32> {
    // In pixels of the targets: (full − first sample)/step + ½.
    let step = f32(view.counts.y);
    let first = vec2<f32>(view.right.w, view.up.w) + f32(view.counts.y / 2u);
    let extent = step * view.size.zw;
    let bias = (view.size.xy + step - 2.0 * first) / extent - 1.0;
    return at * (view.size.xy / extent) + vec2<f32>(bias.x, -bias.y) * depth;
}

/// Corner of a triangle that covers the whole target, from the index of its vertex.
fn covering_corner(index: u32) -> vec4<f32> {
    let at = vec2<f32>(f32(index & 1u), f32(index >> 1u));
    return vec4<f32>(4.0 * at - 1.0, 0.5, 1.0);
}
