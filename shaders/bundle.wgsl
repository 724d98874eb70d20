// Rays that run close together, bounded by a cone: what a tile of pixels sees, so that blobs which
// none of them meets are left out at once. And the wedge between such a cone and a light.
//
// Bounds in f32 are widened by its rounding, so that they hold as exact ones do.
//
// Twins: core/src/geometry/bundle.rs, core/src/cpu/cone.rs, bundle in core/src/cpu/fog.rs.

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

/// All segments between a light and the rays of a bundle from one ray parameter to another: a
/// triangle that widens away from the light.
struct Wedge {
    /// Where the axis begins, from the camera [m]. The corners are relative to that, not to the
    /// light: it may be far away.
    origin: vec3<f32>,
    /// Where the axis ends, and the light [m].
    end: vec3<f32>,
    light: vec3<f32>,
    /// Distance of rays from the axis at its begin and end [m].
    spread: vec2<f32>,
    /// Cosine of the angle at which the wedge widens along the triangle, 0 if that has no bound.
    cosine: f32,
    /// What rounding may change, by the distance of a point.
    rounding: f32,
}

/// Sine of the angle between axis and light below which a triangle is none.
const FLAT: f32 = 1e-3;

/// From a light and what a bundle sees between two ray parameters [m].
fn wedge(light: vec3<f32>, bundle: Bundle, begin_m: f32, end_m: f32) -> Wedge {
    let origin = bundle.origin + begin_m * bundle.axis;
    let end = (end_m - begin_m) * bundle.axis;
    let way = light - origin;
    let spread = bundle.radius + vec2<f32>(begin_m, end_m) * bundle.tangent;
    // The spread is linear over the triangle, 0 at the light; `rise` is its slope there, squared.
    let height = length(cross(bundle.axis, way));
    let across = (spread.y - spread.x) * way + spread.x * end;
    let rise = length(across) / max(height * (end_m - begin_m), num::LEAST);
    let sine = height / max(length(way), num::LEAST);
    let cosine = select(sqrt(max(1.0 - rise * rise, 0.0)), 0.0, rise > 1.0 || sine < FLAT);
    return Wedge(origin, end, way, spread, cosine, ROUNDING * (1.0 + 1.0 / max(sine, FLAT)));
}

/// Lower bound of the distance from a point to any of the segments [m].
fn distance_to_wedge(wedge: Wedge, point: vec3<f32>) -> f32 {
    let way = point - wedge.origin;
    let weights = nearest_of_triangle(way, wedge.end, wedge.light);
    let nearest = weights.x * wedge.end + weights.y * wedge.light;
    let spread = dot(vec2<f32>(1.0 - weights.x - weights.y, weights.x), wedge.spread);
    let slack = wedge.rounding * (length(way) + length(point));
    return max(length(way - nearest) * wedge.cosine - spread - slack, 0.0);
}

/// The point u·a + v·b nearest to `p` of the triangle with corners 0, a and b.
fn nearest_of_triangle(p: vec3<f32>, a: vec3<f32>, b: vec3<f32>) -> vec2<f32> {
    let normal = cross(a, b);
    let area2 = max(dot(normal, normal), 1e-30);
    let inside = vec2<f32>(dot(cross(p, b), normal), dot(cross(a, p), normal)) / area2;
    if inside.x >= 0.0 && inside.y >= 0.0 && inside.x + inside.y <= 1.0 {
        return inside;
    }
    let on_a = vec2<f32>(nearest_of_segment(p, a), 0.0);
    let on_b = vec2<f32>(0.0, nearest_of_segment(p, b));
    let share = nearest_of_segment(p - a, b - a);
    let between = vec2<f32>(1.0 - share, share);
    let distances = vec3<f32>(
        distance(p, on_a.x * a),
        distance(p, on_b.y * b),
        distance(p, between.x * a + between.y * b),
    );
    if distances.z <= min(distances.x, distances.y) {
        return between;
    }
    return select(on_b, on_a, distances.x <= distances.y);
}

/// The share of `to` that is nearest to `p`.
fn nearest_of_segment(p: vec3<f32>, to: vec3<f32>) -> f32 {
    return clamp(dot(p, to) / max(dot(to, to), 1e-30), 0.0, 1.0);
}
