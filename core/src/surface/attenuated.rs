//! Direct light, attenuated by exp(−T(s, p)) on its way (first terms of Sun 2005,
//! eqs. 17–18): L_p = e^(−T) I₀/d² (ρ/π cos θ + k_s cosⁿ θ′).
//!
//! θ is the angle between normal and light, θ′ between the mirrored view and the light. The lobe is
//! not normalised. Ours: a light behind the surface gives neither part.

use crate::light::Toward;
use crate::num::Num;
use crate::vector::V3;

/// What a light contributes per unit of e^(−T) and of its strength [1/m²].
#[derive(Clone, Copy, Debug)]
pub struct Reflection<N> {
    /// Factor of the albedo ρ.
    pub diffuse: N,
    /// Factor of k_s.
    pub specular: N,
}

/// Reflection at a point with the unit `normal` on the eye's side, seen along the unit
/// `direction`, of a light.
#[inline(always)]
pub fn reflection<N: Num>(
    normal: V3<N>,
    direction: V3<N>,
    light: &Toward<N>,
    shininess: N,
) -> Reflection<N> {
    let zero = shininess.lit(0.0);
    let cosine = normal.dot(light.direction);
    let lit = zero.lt(cosine);
    let twice = normal.dot(direction) * zero.lit(2.0);
    let mirrored = direction - normal.scale(twice);
    let lobe = mirrored.dot(light.direction);
    let sharp = (shininess * lobe.max(zero.lit(1e-30)).ln()).exp();
    let facing = N::select(zero.lt(lobe), sharp, zero);
    let share = zero.lit(std::f64::consts::FRAC_1_PI);
    Reflection {
        diffuse: light.falloff(N::select(lit, cosine * share, zero)),
        specular: light.falloff(N::select(lit, facing, zero)),
    }
}
