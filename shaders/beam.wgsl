// A cone of light, and how much of it a ray passes: by v = 1 − cos ψ of the angle ψ from the axis, and along a ray by
// the angle at the light from the direction that is opposite to the ray's.
//
// Twin: core/src/light/beam.rs.

#define_import_path fogbank::beam

#import fogbank::num
#import fogbank::lamp

/// How a ray passes a cone.
struct Crossed {
    /// v where the ray is nearest to the axis, and how it grows beside.
    level: f32,
    swing: f32,
    /// The angle of that place.
    middle: f32,
    /// How far on both sides of it the ray is within the outer and the inner angle.
    outer: f32,
    inner: f32,
}

/// No vector is shorter that is divided by its length.
const LEAST_ACROSS: f32 = 1e-12;
/// Least difference of both edges that counts.
const LEAST_STEP: f32 = 1e-30;
/// Abscissae on [−1, 1] and weights of the Gauss–Legendre rule between both angles.
const RULE: array<vec2<f32>, 5> = array<vec2<f32>, 5>(
    vec2<f32>(0.0, 0.28444445),
    vec2<f32>(0.5384693, 0.23931434),
    vec2<f32>(-0.5384693, 0.23931434),
    vec2<f32>(0.9061798, 0.11846344),
    vec2<f32>(-0.9061798, 0.11846344),
);
/// Places that are looked at between both angles.
const SOFT: u32 = 10u;

/// Share of a lamp's light that goes in the unit `direction`.
fn weight(light: lamp::Lamp, direction: vec3<f32>) -> f32 {
    if !lamp::is_beam(light) {
        return 1.0;
    }
    let apart = direction - light.axis;
    return at(light, 0.5 * dot(apart, apart));
}

/// The same of v.
fn at(light: lamp::Lamp, versine: f32) -> f32 {
    let x = clamp((light.outer - versine) / max(light.outer - light.inner, LEAST_STEP), 0.0, 1.0);
    return x * x * (3.0 - 2.0 * x);
}

/// How a ray from `start` in the unit `direction` passes the cone of a light.
fn beside(light: lamp::Lamp, start: vec3<f32>, direction: vec3<f32>) -> Crossed {
    let toward = light.position - start;
    let way = dot(toward, direction) * direction - toward;
    // What rounding leaves of the way of a ray through the light tells nothing.
    if length(way) < max(length(toward) * lamp::MISS_FLOOR, lamp::LEAST_MISS) {
        return through(light, direction);
    }
    let aside = way / max(length(way), LEAST_ACROSS);
    let a = dot(light.axis, aside);
    let b = -dot(light.axis, direction);
    let across = dot(light.axis, cross(aside, direction));
    let square = across * across;
    let level = square / (1.0 + sqrt(max(1.0 - square, 0.0)));
    let turn = num::angle(abs(a), b);
    let behind = select(-turn, 2.0 * num::PI - turn, b < 0.0);
    let swing = 2.0 * (1.0 - level);
    return Crossed(
        level,
        swing,
        select(turn, behind, a < 0.0),
        half_of(light.outer, level, swing),
        half_of(light.inner, level, swing),
    );
}

/// The same of a ray through the light, which lies in the cone behind it, before it, or not at all.
fn through(light: lamp::Lamp, direction: vec3<f32>) -> Crossed {
    let is_behind = dot(light.axis, direction) < 0.0;
    let apart = light.axis - select(direction, -direction, is_behind);
    let level = 0.5 * dot(apart, apart);
    return Crossed(
        level,
        0.0,
        select(num::PI, 0.0, is_behind),
        select(0.0, num::HALF_PI, level < light.outer),
        select(0.0, num::HALF_PI, level < light.inner),
    );
}

/// How far beside the place nearest to the axis v reaches an edge.
fn half_of(edge: f32, level: f32, swing: f32) -> f32 {
    let share = clamp((edge - level) / max(swing, 1e-12), 0.0, 1.0);
    return 2.0 * num::angle(sqrt(share), sqrt(1.0 - share));
}

/// As much of some angles as is within the cone; it begins where it ends if nothing is.
fn narrowed(cone: Crossed, ends: vec2<f32>) -> vec2<f32> {
    let begin = max(cone.middle - cone.outer, ends.x);
    return vec2<f32>(begin, max(min(cone.middle + cone.outer, ends.y), begin));
}

/// The part of some angles where the light is full.
fn full_between(cone: Crossed, ends: vec2<f32>) -> vec2<f32> {
    let begin = max(cone.middle - cone.inner, ends.x);
    return vec2<f32>(begin, max(min(cone.middle + cone.inner, ends.y), begin));
}

/// Where to look between both angles, and how much that place counts of the integral over some angles.
fn soft(light: lamp::Lamp, cone: Crossed, ends: vec2<f32>, which: u32) -> vec2<f32> {
    let is_first = which < 5u;
    let near = cone.middle + select(cone.inner, -cone.outer, is_first);
    let far = cone.middle + select(cone.outer, -cone.inner, is_first);
    let begin = max(near, ends.x);
    let end = min(far, ends.y);
    let width = max(end - begin, 0.0);
    var rule = RULE;
    let node = rule[which % 5u];
    let angle = 0.5 * (begin + end) + 0.5 * width * node.x;
    let half = num::sin_turns((angle - cone.middle) / (4.0 * num::PI));
    return vec2<f32>(angle, at(light, cone.level + cone.swing * half * half) * width * node.y);
}

/// ∫ of the weight between two angles.
fn turn(light: lamp::Lamp, cone: Crossed, ends: vec2<f32>) -> f32 {
    let inner = full_between(cone, ends);
    var sum = inner.y - inner.x;
    for (var i = 0u; i < SOFT; i++) {
        sum += soft(light, cone, ends, i).y;
    }
    return sum;
}

/// The angle at the light at a ray parameter.
fn angle_at(light: lamp::ToLight, t: f32) -> f32 {
    return num::angle(light.miss, light.closest - t);
}

/// The ray parameter at such an angle [m].
fn t_at(light: lamp::ToLight, angle: f32) -> f32 {
    let turns = angle / (2.0 * num::PI);
    let sine = max(num::sin_turns(turns), 1e-12);
    return light.closest - light.miss * num::sin_turns(turns + 0.25) / sine;
}
