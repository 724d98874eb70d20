// Airlight of a point light in homogeneous fog (Sun et al. 2005, eqs. 10–12), isotropic.
//
// The difference of F in eq. 11 is evaluated as the one integral that it is. With t counted from
// the ray's point closest to the light, h the light's distance from the ray, d(t) its distance from
// the point and w = t + d,
//
//     L_a = β I₀/(2π) e^(−β d₀) ∫ e^(−β(w − w₀)) / (h² + w²) dw,   w from w₀ to w₁,
//
// has no singular factor. Then w = w₀ + c·s/(1 − s), c² = h² + w₀², makes the rational part smooth,
// and 1 − s = ρ² gathers the nodes of a ten-point Gauss rule where a thin fog's exponential ends.
//
// Twin: core/src/airlight/sun2005.rs, which states the errors.

#define_import_path fogbank::airlight::sun2005

#import fogbank::num
#import fogbank::lamp
#import fogbank::beam

/// Abscissae and weights of the Gauss–Legendre rule on [0, 1].
const GAUSS: array<vec2<f32>, 10> = array<vec2<f32>, 10>(
    vec2<f32>(0.013046736, 0.033335672),
    vec2<f32>(0.067468317, 0.074725675),
    vec2<f32>(0.160295216, 0.109543181),
    vec2<f32>(0.283302303, 0.13463336),
    vec2<f32>(0.42556283, 0.147762112),
    vec2<f32>(0.57443717, 0.147762112),
    vec2<f32>(0.716697697, 0.13463336),
    vec2<f32>(0.839704784, 0.109543181),
    vec2<f32>(0.932531683, 0.074725675),
    vec2<f32>(0.986953264, 0.033335672),
);

/// Optical depth behind which the integrand no longer counts: e⁻¹⁸ is 1.5e-8.
const CUT: f32 = 18.0;

/// L_a per unit of ω·I₀ [1/m²] of a light between two parameters of a ray from `start` in the unit `direction` [m], in fog
/// of extinction `beta` [1/m].
fn within(
    beta: f32,
    light: lamp::Lamp,
    start: vec3<f32>,
    direction: vec3<f32>,
    ends: vec2<f32>,
) -> f32 {
    let before = lamp::beside(light, start, direction);
    if lamp::is_beam(light) {
        return of_beam(beta, light, beam::beside(light, start, direction), before, ends);
    }
    if lamp::is_sun(light) {
        // What is removed of it on the way to the eye.
        let removed = num::absorptance(beta * (ends.y - ends.x))
            * num::exp_bounded(-beta * (light.path_m + ends.x));
        return removed / (4.0 * num::PI * before.miss) / before.miss;
    }
    return between(beta, before, ends);
}

/// The same of a lamp that shines into a cone.
fn of_beam(
    beta: f32,
    light: lamp::Lamp,
    cone: beam::Crossed,
    before: lamp::ToLight,
    reach: vec2<f32>,
) -> f32 {
    let ends = vec2<f32>(beam::angle_at(before, reach.x), beam::angle_at(before, reach.y));
    let inner = beam::full_between(cone, ends);
    var sum = 0.0;
    if inner.x < inner.y {
        let begin = clamp(beam::t_at(before, inner.x), reach.x, reach.y);
        let end = clamp(beam::t_at(before, inner.y), begin, reach.y);
        sum = between(beta, before, vec2<f32>(begin, end));
    }
    let scale = beta / (4.0 * num::PI * before.miss);
    for (var i = 0u; i < beam::SOFT; i++) {
        let node = beam::soft(light, cone, ends, i);
        let t = clamp(beam::t_at(before, node.x), reach.x, reach.y);
        let aside = t - before.closest;
        let way = t + sqrt(aside * aside + before.miss * before.miss);
        sum += scale * node.y * num::exp_bounded(-beta * way);
    }
    return sum;
}

/// Airlight between two parameters of a ray.
fn between(beta: f32, there: lamp::ToLight, ends: vec2<f32>) -> f32 {
    let before = lamp::ToLight(there.closest - ends.x, there.miss, there.tilt);
    let length_m = ends.y - ends.x;
    let h2 = before.miss * before.miss;
    let t = vec2<f32>(-before.closest, length_m - before.closest);
    let d = sqrt(h2 + t * t);
    let w = vec2<f32>(path(t.x, d.x, h2), path(t.y, d.y, h2));

    let whole = length_m * (w.x + w.y) / (d.x + d.y);
    let width = min(whole, CUT / max(beta, 1e-30));
    let c = sqrt(h2 + w.x * w.x);
    let share = 1.0 / (width + c);
    let rho_range = width * share / (1.0 + sqrt(c * share));

    let bend = 2.0 * (1.0 - w.x / c);
    var sum = 0.0;
    for (var i = 0u; i < 10u; i++) {
        let y = rho_range * GAUSS[i].x;
        let rho = 1.0 - y;
        let rho2 = rho * rho;
        let s = y * (rho + 1.0);
        let q = 1.0 - s * rho2 * bend;
        // One division serves both s/ρ² and ρ/q.
        let inverse = 1.0 / (rho2 * q);
        let faded = num::exp_bounded(-beta * c * s * q * inverse);
        sum += 2.0 * GAUSS[i].y * faded * rho * rho2 * inverse;
    }
    let scale = beta * num::exp_bounded(-beta * (d.x + ends.x)) / (2.0 * num::PI);
    return scale * sum * rho_range / c;
}

/// w = t + d, without cancellation before the closest point.
fn path(t: f32, d: f32, h2: f32) -> f32 {
    return select(t + d, h2 / max(d - t, d), t < 0.0);
}
