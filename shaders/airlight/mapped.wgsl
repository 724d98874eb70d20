// Airlight by one Gauss rule over a whole ray, in a variable that is smooth wherever the integrand
// k(α) β e^(−T(v,x)−T(x,s)) / d² is.
//
// The variable mixes three maps of the ray: the angle seen from the light, the lumps of fog that
// are seen and lit, and plain distance. Here stand the map and the integrand; the passes say along
// which rays β and both depths are formed, and how many nodes are enough.
//
// Every part of the map is counted from where the ray begins, by differences that keep their
// digits: a light far away is seen under a tiny angle.
//
// Twin: core/src/airlight/mapped.rs.

#define_import_path fogbank::airlight::mapped

#import fogbank::num
#import fogbank::phase
#import fogbank::lamp

/// Places along a ray where the medium is looked at before the nodes are placed.
const PROBES: u32 = 32u;
/// Share of the nodes that the light's map places.
const LIGHT_SHARE: f32 = 0.45;
/// Share of the nodes that lie evenly.
const EVEN_SHARE: f32 = 0.1;
/// Optical depth behind which nothing is seen: e⁻²⁴.
const OPAQUE: f32 = 24.0;
/// A ray from which fog removes less than this share of the light is as good as clear: the smallest
/// rule will do.
const CLEAR: f32 = 1e-6;
/// What rounding leaves of ∫ β e^(−T) dt where there is no fog: ln β has a floor.
const NOTHING: f32 = 1e-20;
/// The least extinction [1/m].
const LEAST_BETA: f32 = 1e-30;
/// Radii from its middle on a ray at which a blob has ended there: exp(−4²) is 1e-7.
const ENDS: f32 = 4.0;

/// What airlight depends on at a place of a ray.
struct Fields {
    /// ln β − T(v, x), β of the group that scatters; behind what is opaque its size does not matter.
    log_seen: f32,
    /// T(x, s)/d, the mean extinction towards the light [1/m].
    mean: f32,
    /// β e^(−T) of the blobs alone [1/m].
    of_blobs: f32,
}

/// From sums over blobs: x is β of the group that scatters, y is T(v, x), z is β of all, w is T(x, s); and
/// what stands in closed form: x is β of the group, y is T(v, x), z is T(x, s)/d; `distance_m` from the
/// light.
fn fields(sums: vec4<f32>, haze: vec3<f32>, distance_m: f32) -> Fields {
    let depth = min(sums.y + haze.y, 2.0 * OPAQUE);
    let log_seen = log(max(sums.x + haze.x, LEAST_BETA)) - depth;
    let of_blobs = sums.z * num::exp_bounded(-sums.y);
    return Fields(log_seen, haze.z + sums.w / max(distance_m, num::LEAST), of_blobs);
}

/// k(α) e^(log − mean · d)/d² at distance `aside` along the ray from its point closest to the
/// light.
fn scattered(g: f32, light: lamp::ToLight, aside: f32, log_seen: f32, mean: f32) -> f32 {
    let squared = aside * aside + light.miss * light.miss;
    let distance_m = sqrt(squared);
    let falling = num::exp_bounded(log_seen - max(mean, 0.0) * distance_m) / squared;
    return falling * phase::phase(g, -aside / distance_m);
}

/// √(k(α) e^(log − mean · d)): how much of the nodes a place deserves but for its distance.
fn weight_of(g: f32, light: lamp::ToLight, aside: f32, at: Fields) -> f32 {
    let distance_m = sqrt(aside * aside + light.miss * light.miss);
    let falling = num::exp_bounded(0.5 * (at.log_seen - max(at.mean, 0.0) * distance_m));
    return falling * sqrt(phase::phase(g, -aside / distance_m));
}

/// The angle at a light that a ray turns through, from where a piece of it begins.
struct Angle {
    /// Distance of the light from the ray's line [m].
    miss: f32,
    /// From the point closest to the light to where the piece begins [m].
    ahead: f32,
}

fn angle_from(light: lamp::ToLight, begin: f32) -> Angle {
    return Angle(light.miss, begin - light.closest);
}

/// x: the angle a `way` behind the beginning [rad]. y: its slope [rad/m].
fn turned(angle: Angle, way: f32) -> vec2<f32> {
    let there = way + angle.ahead;
    let squared = angle.miss * angle.miss;
    return vec2<f32>(
        num::angle(angle.miss * way, angle.ahead * there + squared),
        angle.miss / (there * there + squared),
    );
}

/// How far behind the beginning the ray has turned through an angle [m].
fn way_of(angle: Angle, turn: f32) -> f32 {
    // tan(atan(ahead/miss) + turn) · miss − ahead, without a tangent that could be infinite.
    let rest = max(angle.miss * cos(turn) - angle.ahead * sin(turn), 1e-12 * angle.miss);
    return sin(turn) * (angle.miss * angle.miss + angle.ahead * angle.ahead) / rest;
}

/// Ends of the parts that probes stand in, counted from where a piece of a given length begins,
/// before they are sorted: parts are short where fog lies (from `dense.x` to `dense.y`) or the light
/// is near.
fn probe_end(i: u32, length_m: f32, dense: vec2<f32>, angle: Angle) -> f32 {
    if i == 0u {
        return 0.0;
    }
    if i >= PROBES {
        return length_m;
    }
    let share = f32(i / 4u) / f32(PROBES / 4u);
    if i % 4u == 0u {
        return length_m * share;
    }
    if i % 4u == 1u {
        return clamp(way_of(angle, share * turned(angle, length_m).x), 0.0, length_m);
    }
    let place = f32((i / 4u) * 2u + i % 2u) + 0.5;
    return dense.x + (dense.y - dense.x) * place / f32(PROBES / 2u);
}

/// Fog that lies together on a ray.
struct Lump {
    mass: f32,
    mean: f32,
    variance: f32,
}

fn no_lump() -> Lump {
    return Lump(0.0, 0.0, 0.0);
}

/// Two lumps as one.
fn join(a: Lump, b: Lump) -> Lump {
    let mass = a.mass + b.mass;
    if mass <= 0.0 {
        return a;
    }
    let p = a.mass / mass;
    let q = b.mass / mass;
    let apart = a.mean - b.mean;
    let variance = p * a.variance + q * b.variance + p * q * apart * apart;
    return Lump(mass, p * a.mean + q * b.mean, variance);
}

/// A bump's share of the map: `weight` · erf((x − mean) · scale), counted from x = 0, where the piece
/// begins.
struct Step {
    mean: f32,
    scale: f32,
    weight: f32,
}

/// The map t → q from a piece of a ray to [0, 1].
struct Map {
    begin: f32,
    end: f32,
    /// As the light stands, and as if a narrow phase function had it farther aside.
    angle: Angle,
    wide: Angle,
    /// Weights of both.
    angles: vec2<f32>,
    /// Of the medium, along the angle.
    low: Step,
    high: Step,
    /// Along the ray itself, over the blobs.
    even: Step,
}

/// For a piece of a ray, with its fog in two lumps of which one or both may be empty, and blobs from
/// `dense.x` to `dense.y` if that is not empty.
fn map_of(
    g: f32,
    begin: f32,
    end: f32,
    light: lamp::ToLight,
    low: Lump,
    high: Lump,
    dense: vec2<f32>,
) -> Map {
    let total = max(solid(low) + solid(high), num::LEAST);
    let filled = solid(low) + solid(high) > 0.0;
    let medium = 1.0 - LIGHT_SHARE - EVEN_SHARE;
    let length_m = end - begin;
    var map: Map;
    map.begin = begin;
    map.end = end;
    map.angle = angle_from(light, begin);
    // A narrow phase function prefers points from where the light stands straight ahead.
    map.wide = Angle(light.miss / (1.0 - abs(g)), map.angle.ahead);
    let across = vec2<f32>(turned(map.angle, length_m).x, turned(map.wide, length_m).x);
    let is_dense = dense.x < dense.y;
    // What is not needed elsewhere is the light's.
    let share = LIGHT_SHARE + select(medium, 0.0, filled) + select(EVEN_SHARE, 0.0, is_dense);
    let shares = share * select(vec2<f32>(0.5), vec2<f32>(1.0, 0.0), g == 0.0);
    map.angles = shares / max(across, vec2<f32>(num::LEAST));
    map.low = step_of(low.mean, sqrt(2.0 * low.variance), medium * solid(low) / total, across.x);
    map.high = step_of(high.mean, sqrt(2.0 * high.variance), medium * solid(high) / total, across.x);
    let middle = 0.5 * (dense.x + dense.y) - begin;
    let half = 0.5 * (dense.y - dense.x);
    map.even = step_of(middle, half, select(0.0, EVEN_SHARE, is_dense), length_m);
    return map;
}

/// The mass of a lump that has an extent, else 0.
fn solid(lump: Lump) -> f32 {
    return select(0.0, lump.mass, lump.variance > 0.0);
}

/// For a bump of that middle and width, √2 standard deviations, on a piece from 0 to `end`.
fn step_of(mean: f32, width: f32, share: f32, end: f32) -> Step {
    if share <= 0.0 {
        return Step(0.0, 0.0, 0.0);
    }
    let scale = 1.0 / width;
    let range = num::erf_plain_difference(-mean * scale, (end - mean) * scale);
    return Step(mean, scale, share / max(range, 1e-6));
}

/// q(t) and dq/dt.
fn value(map: Map, t: f32) -> vec2<f32> {
    let way = t - map.begin;
    let turn = turned(map.angle, way);
    let along = vec2<f32>(map.angles.x * turn.x, map.angles.x)
        + step_value(map.low, turn.x)
        + step_value(map.high, turn.x);
    var q = vec2<f32>(along.x, along.y * turn.y) + step_value(map.even, way);
    if map.angles.y > 0.0 {
        q += map.angles.y * turned(map.wide, way);
    }
    return q;
}

fn step_value(step: Step, at: f32) -> vec2<f32> {
    let x = (at - step.mean) * step.scale;
    let since = num::erf_plain_difference(-step.mean * step.scale, x);
    let slope = step.scale * num::TWO_BY_SQRT_PI * num::exp_bounded(-x * x);
    return step.weight * vec2<f32>(since, slope);
}

/// t with q(t) = `q`, and dq/dt there. Newton's steps and the bisections that guard them turn the
/// ray's point by an angle around the light, in which q hardly bends.
fn solve(map: Map, q: f32) -> vec2<f32> {
    let closest = map.begin - map.angle.ahead;
    let miss2 = map.angle.miss * map.angle.miss;
    var low = map.begin - closest;
    var high = map.end - closest;
    var aside = bisector(low, high, miss2);
    var at = value(map, aside + closest);
    for (var i = 0u; i < 64u; i++) {
        // The weight belongs to t as it is; where t lies matters little.
        if abs(at.x - q) <= 1e-5 {
            break;
        }
        if at.x < q {
            low = aside;
        } else {
            high = aside;
        }
        // h tan(atan(aside/h) + turn), the turn that Newton asks for taken for its tangent.
        let along = (q - at.x) / max(at.y, num::LEAST);
        let distance2 = aside * aside + miss2;
        let rest = distance2 - aside * along;
        let next = (aside * distance2 + along * miss2) / max(rest, num::LEAST);
        // Newton's chance is over after a few steps: then the interval surely gets smaller.
        let bisects = (i > 5u && i % 2u == 1u) || rest <= 0.0 || next <= low || next >= high;
        aside = select(next, bisector(low, high, miss2), bisects);
        at = value(map, aside + closest);
    }
    return vec2<f32>(aside + closest, at.y);
}

/// The place on a ray that a light sees halfway between two others, all counted from the point
/// closest to it; by the theorem of the angle's bisector.
fn bisector(low: f32, high: f32, miss2: f32) -> f32 {
    let near = sqrt(low * low + miss2);
    let far = sqrt(high * high + miss2);
    return (low * far + high * near) / (near + far);
}
