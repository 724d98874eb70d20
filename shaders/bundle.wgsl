// Rays that run close together, bounded by a cone: what a tile of pixels sees, so that blobs which
// none of them meets are left out at once.
//
// Bounds in f32 are widened by its rounding, so that they hold as exact ones do.
//
// Twin: core/src/geometry/bundle.rs.

#define_import_path fogbank::bundle

#import fogbank::num
#import fogbank::view::{View, ray_through}

/// A cone with a blunt tip that holds all its rays: at the distance z along the axis they lie
/// within `radius + z · tangent` of it, for 0 ≤ z ≤ `length_m`.
struct Bundle {
    /// Where the axis starts, from the camera [m].
    origin: vec3<f32>,
    /// Unit vector.
    axis: vec3<f32>,
    /// Radius at the origin [m].
    radius: f32,
    /// Tangent of the half angle.
    tangent: f32,
    /// Where the longest ray ends [m].
    length_m: f32,
}

/// Relative error of coordinates, with room for the few operations on them.
const ROUNDING: f32 = 1e-6;
/// Rays that spread over more than 80° have no cone.
const WIDEST_COSINE: f32 = 0.17;

/// Rays from one point into all directions: a ball, of which every point may be met.
fn all_around(origin: vec3<f32>, length_m: f32) -> Bundle {
    return Bundle(origin, vec3<f32>(0.0, 0.0, 1.0), length_m, 0.0, length_m);
}

/// The view rays of a rectangle of the full picture [px], no longer than `length_m`.
fn of_view(view: View, low: vec2<f32>, high: vec2<f32>, length_m: f32) -> Bundle {
    let middle = ray_through(view, 0.5 * (low + high));
    var apart = vec2<f32>(0.0);
    for (var i = 0u; i < 4u; i++) {
        let right = (i & 1u) == 1u;
        let corner = vec2<f32>(select(low.x, high.x, right), select(low.y, high.y, i > 1u));
        let ray = ray_through(view, corner);
        let chord = vec2<f32>(length(ray.direction - middle.direction),
            length(ray.offset - middle.offset));
        apart = max(apart, chord);
    }
    // By chords, which keep the digits of small angles.
    let half = 0.5 * apart.x + 1e-7;
    let cosine = 1.0 - 2.0 * half * half;
    if cosine < WIDEST_COSINE {
        return all_around(middle.offset, length_m);
    }
    let tangent = 2.0 * half * sqrt(1.0 - half * half) / cosine;
    return Bundle(middle.offset, middle.direction, apart.y * 1.000001, tangent, length_m);
}

/// The segments from a point to all points of a ball around `center`, from the camera.
fn toward_ball(origin: vec3<f32>, center: vec3<f32>, radius: f32) -> Bundle {
    let way = center - origin;
    let distance = length(way);
    // A ball that reaches around the origin: its points lie in all directions.
    if radius >= 0.98 * distance {
        return all_around(origin, distance + radius);
    }
    let sine = radius / distance;
    let tangent = sine / sqrt(1.0 - sine * sine) + 1e-7;
    return Bundle(origin, way / distance, 0.0, tangent, distance + radius);
}

/// Lower bound of the distance from a point to any of the rays [m].
fn distance_to(bundle: Bundle, point: vec3<f32>) -> f32 {
    let way = point - bundle.origin;
    let along = dot(way, bundle.axis);
    let from_axis = length(cross(way, bundle.axis));
    let slack = (abs(along) + from_axis + bundle.radius + length(point)) * ROUNDING;
    let beyond = max(along - bundle.length_m, 0.0);
    let aside = from_axis - bundle.radius - min(along, bundle.length_m) * bundle.tangent;
    // Beyond the end its rim is nearest, before it the side; behind the start the start may be.
    let rim = length(vec2<f32>(max(aside, 0.0), beyond));
    let cosine = inverseSqrt(1.0 + bundle.tangent * bundle.tangent);
    let side = max(aside * cosine, -along - bundle.radius);
    return max(select(side, rim, beyond > 0.0) - slack, 0.0);
}

/// Bounds of where along its ray any ray passes closest to a point [m].
fn closest_approach(bundle: Bundle, point: vec3<f32>) -> vec2<f32> {
    let way = point - bundle.origin;
    let along = dot(way, bundle.axis);
    let aside = length(cross(way, bundle.axis));
    let slack = (abs(along) + aside + bundle.radius + length(point)) * ROUNDING;
    let cosine = inverseSqrt(1.0 + bundle.tangent * bundle.tangent);
    let sine = bundle.tangent * cosine;
    let full = length(vec2<f32>(along, aside));
    // Inside the cone, or inside its mirror image behind the origin, some ray meets the point.
    let reach = along * bundle.tangent;
    let low = select(-full, along * cosine - aside * sine, -reach < aside);
    let high = select(full, along * cosine + aside * sine, reach < aside);
    let room = bundle.radius + slack;
    return vec2<f32>(low - room, high + room);
}
