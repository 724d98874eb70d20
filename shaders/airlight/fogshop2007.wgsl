// Airlight of a point light in one Gaussian of a sum, as published (Fogshop 2007, eqs. 8–13),
// isotropic.
//
// Each blob's share is its line integral times the integrand at the projection of its centre onto
// the ray (eqs. 10–11). There the blob itself is attenuated along light → projection → eye (eq.
// 12), all others along light → centre → eye (eq. 13), whose exponent the host gives for each blob
// and light. Errata applied as in the twin; the homogeneous share is sun2005 times C_sv (eqs.
// 15–17).
//
// Twins: core/src/airlight/fogshop2007.rs, and Sum in core/src/cpu/kernels.rs.

#define_import_path fogbank::airlight::fogshop2007

#import fogbank::num
#import fogbank::lamp
#import fogbank::beam
#import fogbank::media::gaussians

/// Line integrals of one ray through one blob.
struct Crossing {
    /// T_i(v, p).
    depth: f32,
    /// T_i(v, b_i^r).
    before: f32,
    /// a · (b_i^r − centre).
    aside: vec3<f32>,
    /// Squared distance of b_i^r from the centre in units of the radius.
    aside_squared: f32,
}

/// No distance from a light counts as less [m]: its inverse square must not overflow.
const LEAST_DISTANCE: f32 = 1e-6;

/// Follows a ray through a blob.
fn crossing(seen: gaussians::Seen, direction: vec3<f32>, length_m: f32) -> Crossing {
    let line = gaussians::line_of(seen, direction, length_m);
    let density = seen.k * line.peak;
    let at = clamp(-line.start, 0.0, line.end - line.start);
    let shift = at + line.start;
    let whole = gaussians::between(line.start, line.end, seen.a * length_m);
    let first = num::erf_difference(min(line.start, 0.0), min(line.end, 0.0));
    let aside_squared = line.miss_squared + shift * shift;
    return Crossing(density * whole, density * first, direction * at - seen.b, aside_squared);
}

/// L_i per unit of ω·I₀/(4π) [1/m²] (eq. 11). `lit` holds a · (centre − light), and the exponent of
/// f¹ with the blob's own two depths taken out again; a cone lights as much of a
/// blob as of its centre on the ray.
fn scattered(cross: Crossing, seen: gaussians::Seen, lit: vec4<f32>, light: lamp::Lamp) -> f32 {
    // The way from the light to b_i^r: as a sum of vectors it keeps a small distance's digits.
    let way = lit.xyz + cross.aside;
    let distance = max(length(way), seen.a * floor_of(light));
    // Its ends, counted from its point closest to the centre.
    let end = dot(cross.aside, way) / distance;
    let start = end - distance;
    let miss_squared = max(cross.aside_squared - end * end, 0.0);
    let depth = seen.k * num::exp_bounded(-miss_squared) * num::erf_difference(start, end);
    let falloff = seen.a / distance;
    let share = falloff * falloff * beam::weight(light, way / distance);
    return cross.depth * num::exp_bounded(lit.w - depth - cross.before) * share;
}

/// The smallest distance that counts between a light and a ray [m].
fn floor_of(light: lamp::Lamp) -> f32 {
    return max(light.distance_m * lamp::MISS_FLOOR, LEAST_DISTANCE);
}
