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
    /// ln β − T(v, x); behind what is opaque its size does not matter.
    log_seen: f32,
    /// T(x, s)/d, the mean extinction towards the light [1/m].
    mean: f32,
}

/// From sums over blobs: x is β, y is T(v, x), z is T(x, s); at the ray parameter `t`, in
/// homogeneous fog of extinction `beta`, `distance_m` from the light.
fn fields(sums: vec3<f32>, beta: f32, t: f32, distance_m: f32) -> Fields {
    let depth = min(sums.y + beta * t, 2.0 * OPAQUE);
    let log_seen = log(max(sums.x + beta, LEAST_BETA)) - depth;
    return Fields(log_seen, beta + sums.z / max(distance_m, num::LEAST));
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

/// Ends of the parts that probes stand in the middle of, before they are sorted: parts are short
/// where fog lies (from `dense.x` to `dense.y`) or the light is near.
fn probe_end(i: u32, begin: f32, end: f32, dense: vec2<f32>, light: lamp::ToLight) -> f32 {
    if i == 0u {
        return begin;
    }
    if i >= PROBES {
        return end;
    }
    let share = f32(i / 4u) / f32(PROBES / 4u);
    if i % 4u == 0u {
        return begin + (end - begin) * share;
    }
    if i % 4u == 1u {
        return clamp(seen_under(begin, end, share, light), begin, end);
    }
    let low = clamp(dense.x, begin, end);
    let high = clamp(dense.y, begin, end);
    let place = f32((i / 4u) * 2u + i % 2u) + 0.5;
    return low + (high - low) * place / f32(PROBES / 2u);
}

/// Where a share of the angle under which the light sees a piece of a ray is passed.
fn seen_under(begin: f32, end: f32, share: f32, light: lamp::ToLight) -> f32 {
    let first = (begin - light.closest) / light.miss;
    let turn = share * num::angle_across(first, (end - begin) / light.miss);
    // tan(atan(first) + turn) − first, without a tangent that could be infinite.
    let rest = max(cos(turn) - first * sin(turn), 1e-12);
    return begin + light.miss * (1.0 + first * first) * sin(turn) / rest;
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

/// A lump's share of the map: `weight` · erf((t − mean) · scale).
struct Step {
    mean: f32,
    scale: f32,
    weight: f32,
}

/// The map t → q from a piece of a ray to [0, 1].
struct Map {
    begin: f32,
    end: f32,
    /// Ray parameter closest to the light [m].
    closest: f32,
    /// Distances of the light, as it is and as a narrow phase function widens it [m].
    miss: vec2<f32>,
    /// Weights of the angles seen from there.
    angles: vec2<f32>,
    even: f32,
    low: Step,
    high: Step,
}

/// For a piece of a ray, with its fog in two lumps of which one or both may be empty.
fn map_of(g: f32, begin: f32, end: f32, light: lamp::ToLight, low: Lump, high: Lump) -> Map {
    let total = max(solid(low) + solid(high), num::LEAST);
    let filled = solid(low) + solid(high) > 0.0;
    let medium = 1.0 - LIGHT_SHARE - EVEN_SHARE;
    var map: Map;
    map.begin = begin;
    map.end = end;
    map.closest = light.closest;
    // A narrow phase function prefers points from where the light stands straight ahead.
    map.miss = light.miss / vec2<f32>(1.0, 1.0 - abs(g));
    let shares = select(vec2<f32>(0.5), vec2<f32>(1.0, 0.0), g == 0.0) * LIGHT_SHARE;
    let first = (begin - light.closest) / map.miss;
    let across = (end - begin) / map.miss;
    map.angles = shares / max(
        vec2<f32>(num::angle_across(first.x, across.x), num::angle_across(first.y, across.y)),
        vec2<f32>(num::LEAST),
    );
    map.even = select(EVEN_SHARE + medium, EVEN_SHARE, filled) / (end - begin);
    map.low = step_of(low, medium * solid(low) / total, begin, end);
    map.high = step_of(high, medium * solid(high) / total, begin, end);
    return map;
}

/// The mass of a lump that has an extent, else 0.
fn solid(lump: Lump) -> f32 {
    return select(0.0, lump.mass, lump.variance > 0.0);
}

fn step_of(lump: Lump, share: f32, begin: f32, end: f32) -> Step {
    if share <= 0.0 {
        return Step(begin, 0.0, 0.0);
    }
    let scale = inverseSqrt(2.0 * lump.variance);
    let low = (begin - lump.mean) * scale;
    let range = num::erf_plain_difference(low, (end - lump.mean) * scale);
    return Step(lump.mean, scale, share / max(range, 1e-6));
}

/// q(t) and dq/dt.
fn value(map: Map, t: f32) -> vec2<f32> {
    let way = t - map.begin;
    let first = (map.begin - map.closest) / map.miss;
    let across = way / map.miss;
    let there = first + across;
    var q = map.even * way + map.angles.x * num::angle_across(first.x, across.x);
    let slopes = map.angles / (map.miss * (1.0 + there * there));
    if map.angles.y > 0.0 {
        q += map.angles.y * num::angle_across(first.y, across.y);
    }
    let low = step_value(map.low, map.begin, t);
    let high = step_value(map.high, map.begin, t);
    return vec2<f32>(q, map.even + slopes.x + slopes.y) + low + high;
}

fn step_value(step: Step, begin: f32, t: f32) -> vec2<f32> {
    let x = (t - step.mean) * step.scale;
    let since = num::erf_plain_difference((begin - step.mean) * step.scale, x);
    let slope = step.scale * num::TWO_BY_SQRT_PI * num::exp_bounded(-x * x);
    return step.weight * vec2<f32>(since, slope);
}

/// t with q(t) = `q`, and dq/dt there; bisection guards Newton's steps.
fn solve(map: Map, q: f32) -> vec2<f32> {
    var low = map.begin;
    var high = map.end;
    var t = low + q * (high - low);
    var at = value(map, t);
    for (var i = 0u; i < 48u; i++) {
        if at.x < q {
            low = t;
        } else {
            high = t;
        }
        let newton = t - (at.x - q) / at.y;
        let next = select(0.5 * (low + high), newton, low < newton && newton < high);
        // The weight belongs to t as it is; where t lies matters little.
        if abs(next - t) * at.y <= 1e-5 {
            break;
        }
        t = next;
        at = value(map, t);
    }
    return vec2<f32>(t, at.y);
}
