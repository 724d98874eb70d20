// Direct light of a point light, attenuated by exp(−T(s, p)) on its way (first terms of Sun 2005,
// eqs. 17–18): L_p = e^(−T) I₀/d² (ρ/π cos θ + k_s cosⁿ θ′), θ between normal and light, θ′ between
// the mirrored view and the light. A light behind the surface gives neither part.
//
// Twin: core/src/surface/attenuated.rs.

#define_import_path fogbank::surface::attenuated

#import fogbank::num

/// A material as the host writes it.
struct Material {
    /// Diffuse albedo ρ, rgb.
    diffuse: vec3<f32>,
    /// Exponent n of the lobe.
    shininess: f32,
    /// Strength of the lobe k_s, rgb.
    specular: vec3<f32>,
    /// Radiance sent out by itself, rgb [W/(m² sr)].
    emission: vec3<f32>,
}

/// What a light contributes per unit of e^(−T)·I₀ [1/m²].
struct Reflection {
    /// Factor of the albedo.
    diffuse: f32,
    /// Factor of k_s.
    specular: f32,
}

/// No distance from a light counts as less [m]: its inverse square must not overflow.
const LEAST_DISTANCE: f32 = 1e-6;

/// Reflection at a point with the unit `normal` on the eye's side, seen along the unit `direction`,
/// of a light at `light` relative to the point. `floor_m` is the smallest distance that counts.
fn reflection(
    normal: vec3<f32>,
    direction: vec3<f32>,
    light: vec3<f32>,
    shininess: f32,
    floor_m: f32,
) -> Reflection {
    let distance = max(length(light), max(floor_m, LEAST_DISTANCE));
    let toward = light / distance;
    let cosine = dot(normal, toward);
    if cosine <= 0.0 {
        return Reflection(0.0, 0.0);
    }
    let mirrored = direction - 2.0 * dot(normal, direction) * normal;
    let falloff = 1.0 / (distance * distance);
    return Reflection(cosine / num::PI * falloff, lobe(mirrored, toward, shininess) * falloff);
}

/// cosⁿ θ′, 0 from a right angle on.
fn lobe(mirrored: vec3<f32>, toward: vec3<f32>, shininess: f32) -> f32 {
    let cosine = dot(mirrored, toward);
    if cosine <= 0.0 {
        return 0.0;
    }
    return num::exp_bounded(shininess * log_cosine(cosine, mirrored - toward));
}

/// ln cos θ′. A sharp lobe lives near 0, where the logarithm of a rounded cosine has no digits
/// left: there 1 − cos θ′ is formed from the chord between the two unit vectors.
fn log_cosine(cosine: f32, chord: vec3<f32>) -> f32 {
    let x = 0.5 * dot(chord, chord);
    let high = 1.0 / 4.0 + x * (1.0 / 5.0 + x / 6.0);
    let series = 1.0 + x * (1.0 / 2.0 + x * (1.0 / 3.0 + x * high));
    return select(log(max(cosine, 1e-30)), -x * series, x < 0.05);
}
