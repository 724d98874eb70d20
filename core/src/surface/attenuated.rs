//! Direct light of a point light, attenuated by exp(−T(s, p)) on its way (first terms of Sun 2005,
//! eqs. 17–18): L_p = e^(−T) I₀/d² (ρ/π cos θ + k_s cosⁿ θ′).
//!
//! θ is the angle between normal and light, θ′ between the mirrored view and the light. The lobe is
//! not normalised. Ours: a light behind the surface gives neither part.

use crate::num::Num;
use crate::vector::V3;

/// What a light contributes per unit of e^(−T)·I₀ [1/m²].
#[derive(Clone, Copy, Debug)]
pub struct Reflection<N> {
    /// Factor of the albedo ρ.
    pub diffuse: N,
    /// Factor of k_s.
    pub specular: N,
}

/// Reflection at a point with the unit `normal` on the eye's side, seen along the unit
/// `direction`, of a light at `light` relative to the point. `floor` is the smallest distance
/// that counts [m].
#[inline(always)]
pub fn reflection<N: Num>(
    normal: V3<N>,
    direction: V3<N>,
    light: V3<N>,
    shininess: N,
    floor: N,
) -> Reflection<N> {
    let (zero, one) = (floor.lit(0.0), floor.lit(1.0));
    let distance2 = light.length_squared().max(floor.squared());
    let to_light = light.scale(one / distance2.sqrt());
    let cosine = normal.dot(to_light);
    let lit = zero.lt(cosine);
    let twice = normal.dot(direction) * floor.lit(2.0);
    let mirrored = direction - normal.scale(twice);
    let lobe = mirrored.dot(to_light);
    let sharp = (shininess * lobe.max(floor.lit(1e-30)).ln()).exp();
    let facing = N::select(zero.lt(lobe), sharp, zero);
    Reflection {
        diffuse: N::select(lit, cosine * floor.lit(std::f64::consts::FRAC_1_PI), zero) / distance2,
        specular: N::select(lit, facing, zero) / distance2,
    }
}
