// Rectangles of the picture that bound things in space, in clip coordinates.
//
// Twin: Screen in core/src/cpu/triangle.rs.

#define_import_path fogbank::screen

#import fogbank::view::{View, is_parallel, target_place}

/// xy: left and lower edge, zw: right and upper edge; the targets are −1 to 1.
struct Area {
    edges: vec4<f32>,
}

fn whole() -> Area {
    return Area(vec4<f32>(-1.0, -1.0, 1.0, 1.0));
}

fn nowhere() -> Area {
    return Area(vec4<f32>(2.0));
}

/// The rectangle that a ball around `center`, from the camera, appears in.
fn around_ball(view: View, center: vec3<f32>, radius_m: f32) -> Area {
    // Room for rounding, and for samples beside the centres of pixels.
    let radius = radius_m + 1e-5 * (radius_m + length(center));
    let room = 2.0 / view.targets;
    let depth = dot(center, view.forward);
    if depth < -radius {
        return nowhere();
    }
    let across = range(center, view.right, depth, radius, is_parallel(view));
    let down = range(center, view.up, depth, radius, is_parallel(view));
    let low = target_place(view, vec2<f32>(across.x, down.x), 1.0) - room;
    let high = target_place(view, vec2<f32>(across.y, down.y), 1.0) + room;
    return Area(clamp(vec4<f32>(low, high), vec4<f32>(-1.0), vec4<f32>(1.0)));
}

/// Far outside of the picture.
const UNBOUNDED: f32 = 1e3;

/// From where to where a ball appears along one of the picture's axes.
fn range(
    center: vec3<f32>,
    axis: vec3<f32>,
    depth: f32,
    radius: f32,
    parallel: bool,
) -> vec2<f32> {
    let reach = length(axis);
    let aside = dot(center, axis) / reach;
    if parallel {
        return vec2<f32>(aside - radius, aside + radius) / reach;
    }
    // A ball that reaches behind the eye's plane has no end on one side.
    if depth <= radius * 1.001 {
        return vec2<f32>(-UNBOUNDED, UNBOUNDED);
    }
    // Tangents from the eye to the ball's circle in the plane of axis and view direction.
    let power = depth * depth - radius * radius;
    let half = radius * sqrt(max(aside * aside + power, 0.0));
    return (aside * depth + vec2<f32>(-half, half)) / (power * reach);
}

/// Corner of the area for a strip of two triangles, from the index of its vertex.
fn corner(area: Area, index: u32) -> vec4<f32> {
    let right = (index & 1u) == 1u;
    let upper = (index & 2u) == 2u;
    let x = select(area.edges.x, area.edges.z, right);
    let y = select(area.edges.y, area.edges.w, upper);
    return vec4<f32>(x, y, 0.5, 1.0);
}
