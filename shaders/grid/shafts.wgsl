// Which parts of a view ray a lamp reaches, by rows of heights: a slice through the eye and the lamp is a row over X,
// and a ray sees light where it is above.
//
// Twins: core/src/frame/shafts.rs, which draws the rows, and core/src/cpu/lit.rs.

#define_import_path fogbank::grid::shafts

#import fogbank::num
#import fogbank::lamp
#import fogbank::beam

/// The rows of a lamp.
struct Shaft {
    /// A point of the line that all slices share, from the camera [m].
    origin: vec3<f32>,
    /// Where the eye and the lamp are: BOTH, EYE, LAMP or NEITHER at a place.
    ends: u32,
    /// Unit vector along that line, to the lamp, or to the eye; where both are far away, along which heights are
    /// measured.
    axis: vec3<f32>,
    /// Distance of the lamp [m], or what stands for it.
    far: f32,
    /// Unit vectors across.
    right: vec3<f32>,
    /// The middle of the range of slices.
    middle: f32,
    up: vec3<f32>,
    /// The first slice, from the middle, and how many there are in one unit.
    first: f32,
    density: f32,
    /// Where X begins, and how many parts of a row there are in one unit.
    begin: f32,
    scale: f32,
    /// Slices, parts of a row and its first number; no slices where nothing is hidden.
    slices: u32,
    bins: u32,
    place: u32,
}

/// A ray before the rows of a lamp.
struct Seen {
    /// The first number of the row before it and of that behind, and how far it is between them.
    near: u32,
    far: u32,
    part: f32,
    /// Its height.
    height: f32,
    /// Where it starts in X and how it grows, or the sine of its angle to the line.
    start: f32,
    rate: f32,
    /// The last part of which its row tells something.
    known: u32,
}

@group(0) @binding(18) var<storage, read> shafts: array<Shaft>;
/// Heights at the ends of all parts, row by row, lamp by lamp.
@group(0) @binding(19) var<storage, read> heights: array<f32>;

const BOTH: u32 = 0u;
const EYE: u32 = 1u;
const LAMP: u32 = 2u;
const NEITHER: u32 = 3u;
/// Numbers of a row behind its parts.
const ROOM: u32 = 32u;
/// Heights of neighbouring rows that differ by less than this share belong to one surface.
const ONE_SURFACE: f32 = 0.3;
/// Along a row they do if they differ by no more than so many times what those before or behind do.
const STEADY: f32 = 3.0;
/// Parts before the end of a ray that are as lit as the one before.
const AT_END: u32 = 2u;
/// A shorter part of a row is as good as a place.
const SHORT: f32 = 1e-3;

/// Whether a lamp may be hidden.
fn is_shaded(which: u32) -> bool {
    return shafts[which].slices > 0u;
}

/// A ray from `start` in the unit `direction` before a lamp.
fn look(which: u32, start: vec3<f32>, direction: vec3<f32>) -> Seen {
    let shaft = shafts[which];
    var slice = 0.0;
    var seen: Seen;
    if shaft.slices == 0u {
        return seen;
    }
    if shaft.ends == NEITHER {
        slice = dot(start, shaft.right) - shaft.middle;
        seen.height = dot(start, shaft.axis);
        seen.start = dot(start, shaft.up);
        seen.rate = dot(direction, shaft.up);
    } else {
        let way = select(direction, start - shaft.origin, shaft.ends == LAMP);
        let across = vec2<f32>(dot(way, shaft.right), dot(way, shaft.up));
        let aside = max(length(across), num::LEAST);
        slice = turned(angle_of(across) - shaft.middle);
        seen.height = select(dot(direction, shaft.axis), 1.0, shaft.ends == LAMP) / aside;
        seen.rate = aside;
    }
    let at = clamp((slice - shaft.first) * shaft.density, 0.0, f32(shaft.slices - 1u));
    let first = min(u32(at), shaft.slices - 2u);
    let width = shaft.bins + ROOM;
    seen.near = shaft.place + first * width;
    seen.far = seen.near + width;
    seen.part = at - f32(first);
    return seen;
}

/// From −π to π.
fn angle_of(across: vec2<f32>) -> f32 {
    let size = num::angle(abs(across.y), across.x);
    return select(size, -size, across.y < 0.0);
}

fn turned(angle: f32) -> f32 {
    let turn = 2.0 * num::PI;
    return angle - turn * round(angle / turn);
}

/// The place in its row of a ray parameter, of which the angle at the lamp is known, and that of the ray's start.
fn place_of(which: u32, seen: Seen, first: f32, angle: f32, t: f32) -> f32 {
    let shaft = shafts[which];
    var value = angle;
    switch shaft.ends {
        case BOTH: { value = angle - first; }
        case EYE: { value = num::angle(t * seen.rate, shaft.far); }
        case NEITHER: { value = seen.start + t * seen.rate - shaft.begin; }
        default: {}
    }
    return clamp(value * shaft.scale, 0.0, f32(shaft.bins));
}

/// Up to where a ray's row tells something that begins and ends at some places of it.
fn known_to(which: u32, ends: vec2<f32>) -> u32 {
    let last = shafts[which].bins - 1u;
    return max(max(min(u32(ends.y), last), AT_END) - AT_END, min(u32(ends.x), last));
}

/// A ray that ends at a ray parameter, before a lamp.
fn look_to(
    which: u32,
    light: lamp::ToLight,
    start: vec3<f32>,
    direction: vec3<f32>,
    end: f32,
) -> Seen {
    var seen = look(which, start, direction);
    let ends = vec2<f32>(place_at(which, seen, light, 0.0), place_at(which, seen, light, end));
    seen.known = known_to(which, ends);
    return seen;
}

/// The place in its row of a ray parameter.
fn place_at(which: u32, seen: Seen, light: lamp::ToLight, t: f32) -> f32 {
    return place_of(which, seen, beam::angle_at(light, 0.0), beam::angle_at(light, t), t);
}

/// Share that is lit between two ray parameters.
fn share_between(which: u32, seen: Seen, light: lamp::ToLight, ends: vec2<f32>) -> f32 {
    let near = place_at(which, seen, light, ends.x);
    return share(which, seen, near, place_at(which, seen, light, ends.y));
}

/// Share that is lit between two places of a ray's row.
fn share(which: u32, seen: Seen, from_place: f32, to_place: f32) -> f32 {
    let last = f32(shafts[which].bins);
    let begin = min(from_place, last - SHORT);
    let end = max(to_place, begin + SHORT);
    let final_bin = min(u32(end), shafts[which].bins - 1u);
    var sum = 0.0;
    for (var bin = u32(begin); bin <= final_bin; bin++) {
        let width = max(min(end, f32(bin) + 1.0) - max(begin, f32(bin)), 0.0);
        sum += width * lit_of(seen, min(bin, seen.known));
    }
    return clamp(sum / (end - begin), 0.0, 1.0);
}

/// How much of a part of its row a ray sees lit.
fn lit_of(seen: Seen, bin: u32) -> f32 {
    // The first number of a row stands twice.
    let left = between(seen, bin + 1u);
    let right = between(seen, bin + 2u);
    let place = seen.near + bin;
    let row = vec4<f32>(heights[place], heights[place + 1u], heights[place + 2u], heights[place + 3u]);
    let step = abs(row.yzw - row.xyz);
    let is_steady = step.y < STEADY * max(step.x, step.z) + 1e-3 * (abs(row.z) + 1.0);
    if !is_steady || left.y + right.y > 0.0 {
        return 0.5 * (left.z + right.z);
    }
    // Within one surface the edge is where a line passes the ray's height.
    let p = seen.height - left.x;
    let q = seen.height - right.x;
    return (max(p, 0.0) + max(q, 0.0)) / max(abs(p) + abs(q), num::LEAST);
}

/// x: the height between both rows at a place. y: 0 if they belong to one surface. z: share that is lit.
fn between(seen: Seen, at: u32) -> vec3<f32> {
    let a = heights[seen.near + at];
    let b = heights[seen.far + at];
    let own = a + (b - a) * seen.part;
    let apart = abs(b - a);
    if apart < (abs(a) + 1.0) * ONE_SURFACE {
        return vec3<f32>(own, 0.0, select(1.0, 0.0, seen.height < own));
    }
    let first = select(1.0 - seen.part, 0.0, seen.height < a);
    let second = select(seen.part, 0.0, seen.height < b);
    return vec3<f32>(own, 1.0, first + second);
}
