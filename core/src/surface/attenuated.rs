//! Direct light, attenuated by exp(−T(s, p)) on its way (first terms of Sun 2005,
//! eqs. 17–18): L_p = e^(−T) I₀/d² (ρ/π cos θ + k_s cosⁿ θ′).
//!
//! θ is the angle between normal and light, θ′ between the mirrored view and the light. The lobe is
//! not normalised. Ours: a light behind the surface gives neither part.

use crate::light::Toward;
use crate::num::Num;
use crate::vector::V3;

/// What a light contributes at a point with the unit `normal` on the eye's side, as a factor of the
/// albedo ρ, per unit of e^(−T) and of its strength [1/m²].
#[inline(always)]
pub fn diffuse<N: Num>(normal: V3<N>, light: &Toward<N>) -> N {
    let cosine = normal.dot(light.direction);
    let zero = cosine.lit(0.0);
    let share = zero.lit(std::f64::consts::FRAC_1_PI);
    light.falloff(N::select(zero.lt(cosine), cosine * share, zero))
}

/// The same as a factor of k_s, seen along the unit `direction`.
#[inline(always)]
pub fn specular<N: Num>(normal: V3<N>, direction: V3<N>, light: &Toward<N>, shininess: N) -> N {
    let zero = shininess.lit(0.0);
    let lit = zero.lt(normal.dot(light.direction));
    let twice = normal.dot(direction) * zero.lit(2.0);
    let mirrored = direction - normal.scale(twice);
    let lobe = mirrored.dot(light.direction);
    let sharp = (shininess * lobe.max(zero.lit(1e-30)).ln()).exp();
    let facing = N::select(zero.lt(lobe), sharp, zero);
    light.falloff(N::select(lit, facing, zero))
}
