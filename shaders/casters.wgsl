// What surfaces hide of a lamp: whether something stands between a point and it, by the hierarchy over all solids.
//
// Twin: core/src/cpu/shadow.rs.

#define_import_path fogbank::casters

#import fogbank::num
#import fogbank::lamp

/// How many of each there are: planes, nodes, solids. Coordinates are relative to the anchor.
struct Counts {
    /// From the anchor to the camera [m].
    shift: vec3<f32>,
    planes: u32,
    nodes: u32,
}

/// Planes, a row each: unit normal, and normal · point. Nodes, two rows each: smallest corner and the first child or
/// solid, largest corner and how many solids. Solids, three rows each: a triangle's corners, a ball's centre and radius,
/// a box's smallest and largest corner; the last word of the last row tells which. Numbers stand as their bits.
@group(0) @binding(11) var<storage, read> casters: array<vec4<u32>>;
@group(0) @binding(12) var<uniform> counts: Counts;

const TRIANGLE: u32 = 0u;
const BALL: u32 = 1u;
const BOX: u32 = 2u;
/// Levels of the hierarchy, and one.
const WAITING: u32 = 65u;

/// A point is behind a plane from this share of its distance on: some roundings of f32.
const BEHIND: f32 = 4e-6;
/// A light this share of the coordinates beside the plane of a triangle lies in it.
const IN_PLANE: f32 = 1e-6;
/// Ways to lights begin this share of the eye's distance above a surface, along its normal.
const LIFT: f32 = 4e-4;

/// Lamps that have a bit in a pixel's mark.
const MARKED: u32 = 32u;

/// A way to a lamp, relative to the anchor.
struct Way {
    start: vec3<f32>,
    /// Unit vector, and how far it is [m].
    toward: vec3<f32>,
    length_m: f32,
    /// Where the lamp is; not of the sun.
    apex: vec3<f32>,
    is_sun: bool,
    /// Rounding counts up to here [m].
    off: f32,
}

/// Whether something stands between a point, given relative to the camera, and a lamp.
fn hides(light: lamp::Lamp, point: vec3<f32>) -> bool {
    let way = way_of(light, point);
    for (var i = 0u; i < counts.planes; i++) {
        if by_plane(way, bitcast<vec4<f32>>(casters[i])) {
            return true;
        }
    }
    var open: array<u32, 65>;
    var count = min(counts.nodes, 1u);
    let inverse = 1.0 / select(way.toward, vec3<f32>(1e-30), abs(way.toward) < vec3<f32>(1e-30));
    while count > 0u {
        count -= 1u;
        let node = counts.planes + 2u * open[count];
        let low = casters[node];
        let high = casters[node + 1u];
        if !meets(way, inverse, place(low), place(high)) {
            continue;
        }
        let first = low.w;
        let solids = high.w;
        if solids == 0u && count + 2u <= WAITING {
            open[count] = first;
            open[count + 1u] = first + 1u;
            count += 2u;
        }
        for (var i = 0u; i < solids; i++) {
            if by_solid(way, inverse, first + i) {
                return true;
            }
        }
    }
    return false;
}

fn way_of(light: lamp::Lamp, point: vec3<f32>) -> Way {
    let start = point + counts.shift;
    let off = BEHIND * max(max(abs(point.x), abs(point.y)), abs(point.z));
    if lamp::is_sun(light) {
        return Way(start, light.toward, 1e30, start, true, off);
    }
    let apex = light.position + counts.shift;
    let length_m = max(distance(apex, start), num::LEAST);
    return Way(start, (apex - start) / length_m, length_m, apex, false, off);
}

/// Whether the way passes through a box.
fn meets(way: Way, inverse: vec3<f32>, low: vec3<f32>, high: vec3<f32>) -> bool {
    let a = (low - way.start) * inverse;
    let b = (high - way.start) * inverse;
    let near = max(max(min(a.x, b.x), min(a.y, b.y)), min(a.z, b.z));
    let far = min(min(max(a.x, b.x), max(a.y, b.y)), max(a.z, b.z));
    let room = 1e-5 * (abs(near) + abs(far)) + way.off;
    return near <= far + room && far >= -room && near <= way.length_m + room;
}

fn by_plane(way: Way, plane: vec4<f32>) -> bool {
    let height = dot(plane.xyz, way.start) - plane.w;
    let of_light = select(dot(plane.xyz, way.apex) - plane.w, dot(plane.xyz, way.toward), way.is_sun);
    let scale = select(abs(dot(plane.xyz, way.apex)) + abs(plane.w), 1.0, way.is_sun);
    return abs(of_light) > IN_PLANE * scale && -sign(of_light) * height > way.off;
}

fn by_solid(way: Way, inverse: vec3<f32>, which: u32) -> bool {
    let row = counts.planes + 2u * counts.nodes + 3u * which;
    let a = casters[row];
    let b = casters[row + 1u];
    let c = casters[row + 2u];
    switch c.w {
        case TRIANGLE: { return by_triangle(way, place(a), place(b), place(c)); }
        case BALL: { return by_ball(way, bitcast<vec4<f32>>(a)); }
        case BOX: { return by_box(way, inverse, place(a), place(b)); }
        default: { return false; }
    }
}

/// The place of a row.
fn place(row: vec4<u32>) -> vec3<f32> {
    return bitcast<vec3<f32>>(row.xyz);
}

fn by_triangle(way: Way, a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> bool {
    let across = cross(b - a, c - a);
    let face = across / max(length(across), 1e-30);
    let height = select(dot(way.apex - a, face), dot(way.toward, face), way.is_sun);
    let scale = select(abs(way.apex) + abs(a), abs(way.toward), way.is_sun);
    // A lamp in the plane of a triangle is not hidden by it.
    if abs(height) <= IN_PLANE * dot(scale, abs(face)) {
        return false;
    }
    let side = sign(height);
    if -side * dot(way.start - a, face) <= way.off {
        return false;
    }
    // As it is seen from the light, the triangle lies on one side of all three.
    let most = max(max(side * edge(way, a, b), side * edge(way, b, c)), side * edge(way, c, a));
    return most <= 0.0;
}

/// On which side of the plane through an edge and the lamp the start of a way is.
fn edge(way: Way, a: vec3<f32>, b: vec3<f32>) -> f32 {
    if way.is_sun {
        return dot(cross(b - a, way.toward), way.start - a);
    }
    return dot(cross(a - way.apex, b - way.apex), way.start - way.apex);
}

fn by_ball(way: Way, ball: vec4<f32>) -> bool {
    let to = ball.xyz - way.start;
    let along = dot(to, way.toward);
    let aside = cross(to, way.toward);
    let square = ball.w * ball.w - dot(aside, aside);
    if square <= 0.0 {
        return false;
    }
    let half = sqrt(square);
    return is_on(way, along - half) || is_on(way, along + half);
}

fn by_box(way: Way, inverse: vec3<f32>, low: vec3<f32>, high: vec3<f32>) -> bool {
    let a = (low - way.start) * inverse;
    let b = (high - way.start) * inverse;
    let near = max(max(min(a.x, b.x), min(a.y, b.y)), min(a.z, b.z));
    let far = min(min(max(a.x, b.x), max(a.y, b.y)), max(a.z, b.z));
    return near < far && (is_on(way, near) || is_on(way, far));
}

/// Whether a place lies on a way, a little off its ends.
fn is_on(way: Way, t: f32) -> bool {
    return t > way.off && t < way.length_m - way.off;
}
