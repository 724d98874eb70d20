// The camera as rays: pixel (i, j) looks through its centre, row 0 at the top. Everything is
// relative to the camera, so that f32 suffices wherever the scene lies.
//
// Twins: core/src/cpu/viewpoint.rs, and what every pass reads of core/src/cpu/frame.rs (Context).

#define_import_path fogbank::view

/// The camera, the picture and the fog's own numbers.
struct View {
    /// Unit view direction.
    forward: vec3<f32>,
    /// Where a ray that meets nothing ends [m].
    far_m: f32,
    /// From the middle of the picture to its right edge: per metre of depth under perspective, else in
    /// metres.
    right: vec3<f32>,
    /// Where a pixel is sampled, across; ½ is its centre.
    sample_x: f32,
    /// From the middle of the picture to its upper edge, likewise.
    up: vec3<f32>,
    /// Where a pixel is sampled, down.
    sample_y: f32,
    /// Pixels of the full picture, across and down.
    size: vec2<f32>,
    /// Pixels of the targets, across and down.
    targets: vec2<f32>,
    /// Radiance of the veil, rgb.
    ambient: vec3<f32>,
    /// Depth at which triangles are cut off in front [m].
    cut_off_m: f32,
    /// Exposure by which samples of a pixel are weighed; 0 if all count the same.
    weighing: f32,
    /// Exposure of a picture for a screen.
    exposure: f32,
    /// 1 if all rays are parallel.
    parallel: u32,
    /// Pixels of the full picture from one pixel of the targets to the next: 4 in a draft's low
    /// resolution, else 1.
    step: u32,
    /// How many blobs there are.
    blobs: u32,
    /// How many lamps there are for each group of terms that scatters their light.
    scatters: u32,
    /// Optical depth behind which nothing is seen.
    opaque: f32,
    /// 1 if pixels at the rims of shadows are looked at again.
    soft: u32,
}

/// A part of a list that one pass or one dispatch works on.
struct Span {
    first: u32,
    /// One past the last.
    end: u32,
    /// The lamp that it is for, and where that stands among those of the pass; 0 for other parts.
    lamp: u32,
    slot: u32,
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
    return view.parallel == 1u;
}

/// Whether a pixel of the targets exists.
fn is_inside(view: View, pixel: vec2<u32>) -> bool {
    return all(pixel < vec2<u32>(view.targets));
}

/// Place of a pixel of the targets in their buffers.
fn index_of(view: View, pixel: vec2<u32>) -> u32 {
    return pixel.y * u32(view.targets.x) + pixel.x;
}

/// The pixel of the full picture that a pixel of the targets stands for.
fn pixel_of(view: View, pixel: vec2<u32>) -> vec2<u32> {
    let step = view.step;
    // Beyond the right and the lower edge of a low resolution the last pixel is repeated.
    return min(pixel * step + step / 2u, vec2<u32>(view.size) - 1u);
}

/// Where a pixel of the targets is sampled, in pixels from the full picture's upper left corner.
fn sample_of(view: View, pixel: vec2<u32>) -> vec2<f32> {
    return vec2<f32>(pixel_of(view, pixel)) + vec2<f32>(view.sample_x, view.sample_y);
}

/// The ray through a place of the full picture [px].
fn ray_through(view: View, place: vec2<f32>) -> Ray {
    let at = 2.0 * place / view.size - 1.0;
    let aside = at.x * view.right - at.y * view.up;
    if is_parallel(view) {
        return Ray(aside, view.forward);
    }
    return Ray(vec3<f32>(0.0), normalize(view.forward + aside));
}

/// The ray of a pixel of the targets.
fn ray_of(view: View, pixel: vec2<u32>) -> Ray {
    return ray_through(view, sample_of(view, pixel));
}

/// Coordinates of a point in the picture, before the division by depth: −1 to 1, y up; and its
/// depth [m].
fn picture_place(view: View, point: vec3<f32>) -> vec3<f32> {
    let x = dot(point, view.right) / dot(view.right, view.right);
    let y = dot(point, view.up) / dot(view.up, view.up);
    return vec3<f32>(x, y, dot(point, view.forward));
}

/// Clip coordinates, before the division by `depth`, for targets whose pixels are sampled elsewhere
/// than in their centres.
fn target_place(view: View, at: vec2<f32>, depth: f32) -> vec2<f32> {
    // In pixels of the targets: (full − first sample)/step + ½.
    let step = f32(view.step);
    let first = vec2<f32>(view.sample_x, view.sample_y) + f32(view.step / 2u);
    let extent = step * view.targets;
    let bias = (view.size + step - 2.0 * first) / extent - 1.0;
    return at * (view.size / extent) + vec2<f32>(bias.x, -bias.y) * depth;
}

/// Corner of a triangle that covers the whole target, from the index of its vertex.
fn covering_corner(index: u32) -> vec4<f32> {
    let at = vec2<f32>(f32(index & 1u), f32(index >> 1u));
    return vec4<f32>(4.0 * at - 1.0, 0.5, 1.0);
}
