// What every pixel of a patch does itself: it interpolates the fields between eight rays, and sums
// the rule with its own distance from the light.
//
// The eight rays run through the corners of a square and the middles of its sides. Their shape
// functions span 1, x, y, x², xy, y², x²y, xy², as the twin's coefficients do.
//
// Twin: core/src/cpu/mapped/pixels.rs.

#define_import_path fogbank::mapped::pixels

#import fogbank::num
#import fogbank::lamp
#import fogbank::airlight::mapped

/// Rays that stand for a patch.
const CONTROL: u32 = 8u;
/// Nodes of a tail, and terms of the polynomials along it.
const TAIL: u32 = 4u;

/// Where the rays run in the square [−1, 1]².
const PLACES: array<vec2<f32>, 8> = array<vec2<f32>, 8>(
    vec2<f32>(-1.0, -1.0),
    vec2<f32>(1.0, -1.0),
    vec2<f32>(-1.0, 1.0),
    vec2<f32>(1.0, 1.0),
    vec2<f32>(0.0, -1.0),
    vec2<f32>(0.0, 1.0),
    vec2<f32>(-1.0, 0.0),
    vec2<f32>(1.0, 0.0),
);

/// Where quadratics are compared with what they stand for: neither even nor odd errors vanish here.
const CHECK: vec2<f32> = vec2<f32>(0.55, 0.45);
/// Where a tail's fields are evaluated: Chebyshev's abscissae on [0, 1].
const CHEBYSHEV: vec4<f32> = vec4<f32>(0.038060233, 0.30865828, 0.6913417, 0.96193975);

/// Gauss–Legendre abscissae and weights of a tail.
const GAUSS: array<vec2<f32>, 4> = array<vec2<f32>, 4>(
    vec2<f32>(0.069431844, 0.17392742),
    vec2<f32>(0.33000948, 0.32607258),
    vec2<f32>(0.66999052, 0.32607258),
    vec2<f32>(0.93056816, 0.17392742),
);

/// How much each of the eight rays counts at a place: corners, then sides.
struct Shares {
    corners: vec4<f32>,
    sides: vec4<f32>,
}

fn shares(at: vec2<f32>) -> Shares {
    let x = at.x * vec4<f32>(-1.0, 1.0, -1.0, 1.0);
    let y = at.y * vec4<f32>(-1.0, -1.0, 1.0, 1.0);
    let corners = 0.25 * (1.0 + x) * (1.0 + y) * (x + y - 1.0);
    let square = 1.0 - at * at;
    let sides = 0.5 * vec4<f32>(
        square.x * (1.0 - at.y),
        square.x * (1.0 + at.y),
        square.y * (1.0 - at.x),
        square.y * (1.0 + at.x),
    );
    return Shares(corners, sides);
}

/// A field at a place, from its values on the eight rays.
fn between(share: Shares, corners: vec4<f32>, sides: vec4<f32>) -> f32 {
    return dot(share.corners, corners) + dot(share.sides, sides);
}

/// What lies between the first and the last end of a layer's rays, at one pixel: values of the
/// fields at CHEBYSHEV along it.
struct Tail {
    /// Where it begins [m].
    begin: f32,
    /// Where the share 0 is on the pixel's ray, and what a share of 1 is long there [m].
    chart: vec2<f32>,
    log_seen: vec4<f32>,
    /// The largest that may be: quadratics overshoot.
    most: f32,
    mean: vec4<f32>,
}

/// Coefficients of the cubic through values at CHEBYSHEV.
fn cubic(values: vec4<f32>) -> vec4<f32> {
    return mat4x4<f32>(
        vec4<f32>(1.256835, -7.196458, 12.01283, -6.122935),
        vec4<f32>(-0.3741514, 10.76066, -25.00154, 14.78207),
        vec4<f32>(0.1670447, -5.103805, 19.34468, -14.78207),
        vec4<f32>(-0.04972809, 1.539603, -6.355975, 6.122935),
    ) * values;
}

fn along(terms: vec4<f32>, x: f32) -> f32 {
    return terms.x + x * (terms.y + x * (terms.z + x * terms.w));
}

/// Airlight of a tail per unit of ω·I₀, for a ray that ends at `end_m`.
fn tail_airlight(tail: Tail, g: f32, light: lamp::ToLight, end_m: f32) -> f32 {
    let start = tail.begin - light.closest;
    let end = max(end_m - light.closest, start);
    let turn = clamp(0.0, start, end);
    // Apart at the closest point, either piece spans less than a right angle from the light.
    return piece(tail, g, light, start, turn) + piece(tail, g, light, turn, end);
}

/// A short Gauss rule in the chord between the ends' directions from the light, nearly their angle:
/// 1/d² is almost constant in it.
fn piece(tail: Tail, g: f32, light: lamp::ToLight, start: f32, end: f32) -> f32 {
    if start >= end {
        return 0.0;
    }
    let near = length(vec2<f32>(start, light.miss));
    let far = length(vec2<f32>(end, light.miss));
    let log_terms = cubic(tail.log_seen);
    let mean_terms = cubic(tail.mean);
    let begin = tail.chart.x - light.closest;
    var sum = 0.0;
    for (var i = 0u; i < TAIL; i++) {
        let x = GAUSS[i].x;
        // Shares of the ends in a place of the chord, and what it makes of a step.
        let scale = 1.0 / ((1.0 - x) * far + x * near);
        let aside = ((1.0 - x) * start * far + x * end * near) * scale;
        let width = (end - start) * (near * scale) * (far * scale);
        let at = (aside - begin) / max(tail.chart.y, num::LEAST);
        let log_seen = min(along(log_terms, at), tail.most);
        let value = mapped::scattered(g, light, aside, log_seen, along(mean_terms, at));
        sum += GAUSS[i].y * width * value;
    }
    return sum;
}
