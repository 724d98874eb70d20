//! Airlight of a point light in homogeneous fog (Sun et al. 2005, eqs. 10–12), isotropic; ours: of cones of light, and of
//! the sun, which is elementary.
//!
//! Eq. 11 is A₀ [F(A₁, v₁) − F(A₁, v₀)] with F(u, v) = ∫₀ᵛ exp(−u tan ξ) dξ. Ours: the difference
//! of F is evaluated as the one integral that it is. Two table look-ups cancel where the light lies
//! beyond the surface or behind the eye (errata 4, 5).
//!
//! With t counted from the ray's point closest to the light, h the light's distance from the ray and
//! d(t) its distance from the point, w = t + d = h tan ξ turns eq. 11 into
//!
//! ```text
//! L_a = β I₀/(2π) e^(−β d₀) ∫ e^(−β(w − w₀)) / (h² + w²) dw,   w from w₀ to w₁,
//! ```
//!
//! which has no singular factor left. Then w = w₀ + c·s/(1 − s), c² = h² + w₀², makes the rational
//! part smooth on [0, 1), and 1 − s = ρ² gathers Gauss nodes where a thin fog's exponential ends.
//! Relative error below 7e-5 for γ from 0 to π, β·distance from 1e-3 to 30 and ends from 0.01 to
//! 1000 times the light's distance.

use super::about::{About, Exactness, Takes};
use crate::geometry::Origin;
use crate::light::{Crossed, Source, ToLight};
use crate::media::vertical::Profile;
use crate::media::{Field, Medium, Term};
use crate::num::Num;

/// Abscissae and weights of the Gauss–Legendre rule on [0, 1].
const GAUSS: [(f64, f64); 10] = [
    (0.013046735741414128, 0.033_335_672_154_344_16),
    (0.067_468_316_655_507_73, 0.074_725_674_575_290_27),
    (0.16029521585048778, 0.10954318125799103),
    (0.283_302_302_935_376_4, 0.13463335965499817),
    (0.425_562_830_509_184_4, 0.14776211235737646),
    (0.574_437_169_490_815_6, 0.14776211235737646),
    (0.716_697_697_064_623_6, 0.13463335965499817),
    (0.839_704_784_149_512_2, 0.10954318125799103),
    (0.932_531_683_344_492_3, 0.074_725_674_575_290_27),
    (0.986_953_264_258_585_9, 0.033_335_672_154_344_16),
];

/// Optical depth behind which the integrand no longer counts: e⁻¹⁸ is 1.5e-8.
const CUT: f64 = 18.0;

/// What is said about it.
pub const ABOUT: About = About {
    source: "Sun, Ramamoorthi, Narasimhan, Nayar: A Practical Analytic Single Scattering Model \
        for Real Time Rendering (SIGGRAPH 2005): airlight of a point light by the function F.",
    takes: Some(Takes { name: "sun2005", what: "homogeneous fog", term: takes, several: true }),
    error: Exactness::measured(
        "the reference, pixel by pixel over scenes of homogeneous fog",
        [1.8e-7, 4.4e-7, 1.1e-5],
    ),
};

/// Extinction of what is the same everywhere in a fog [1/m].
pub fn haze(field: &Field) -> f64 {
    field.groups().iter().filter_map(|media| media.homogeneous.uniform_beta()).sum()
}

/// Share of that, and so of the light that it scatters, which a group of terms has.
pub fn share(field: &Field, group: usize) -> f64 {
    let own = field.groups()[group].homogeneous.uniform_beta().unwrap_or_default();
    let all = haze(field);
    if all > 0.0 { own / all } else { 0.0 }
}

/// Whether it takes a term.
pub fn takes(term: &Term) -> bool {
    matches!(term, Term::Homogeneous(term) if term.vertical.profile() == Profile::Uniform)
}

/// L_a per unit of ω·I₀ [1/m²] of a point light along a ray up to `length` [m], in fog of extinction
/// `beta` [1/m].
#[inline(always)]
pub fn airlight<N: Num>(beta: N, light: ToLight<N>, length: N) -> N {
    let one = length.lit(1.0);
    let ToLight { closest, miss, .. } = light;
    let h2 = miss.squared();
    let (t0, t1) = (-closest, length - closest);
    let (d0, d1) = (h2 + t0.squared(), h2 + t1.squared());
    let (d0, d1) = (d0.sqrt(), d1.sqrt());
    let (w0, w1) = (path(t0, d0, h2), path(t1, d1, h2));

    let whole = length * (w0 + w1) / (d0 + d1);
    let width = whole.min(length.lit(CUT) / beta.max(length.lit(1e-30)));
    let c = (h2 + w0.squared()).sqrt();
    let share = one / (width + c);
    let rho_range = width * share / (one + (c * share).sqrt());

    let bend = (one - w0 / c) * length.lit(2.0);
    let fade = -(beta * c);
    let mut sum = length.lit(0.0);
    for (x, weight) in GAUSS {
        let y = rho_range * length.lit(x);
        let rho = one - y;
        let rho2 = rho.squared();
        let s = y * (rho + one);
        let q = one - s * rho2 * bend;
        // One division serves both s/ρ² and ρ/q.
        let inverse = one / (rho2 * q);
        let value = (fade * s * q * inverse).exp();
        sum = (value * (rho * rho2 * inverse)).mul_add(length.lit(2.0 * weight), sum);
    }
    let scale = beta * length.lit(0.5 * std::f64::consts::FRAC_1_PI);
    scale * (-(beta * d0)).exp() * sum * rho_range / c
}

/// The same of any light, between two ray parameters [m].
#[inline(always)]
pub fn within<N: Num>(
    beta: N,
    source: Source,
    light: ToLight<N>,
    cone: Option<&Crossed<N>>,
    ends: [N; 2],
) -> N {
    match (source.origin(), cone) {
        (Origin::Beyond(beyond), _) => of_sun(beta, beyond.path_m, light, ends),
        (_, Some(cone)) => of_beam(beta, light, cone, ends),
        (_, None) => between(beta, light, ends),
    }
}

/// The same of the sun, whose light came through so much of the fog [m]: what is removed of it on the way to the eye.
#[inline(always)]
fn of_sun<N: Num>(beta: N, path_m: f64, light: ToLight<N>, [from, to]: [N; 2]) -> N {
    let removed = (beta * (to - from)).absorptance();
    let scale = beta.lit(0.25 * std::f64::consts::FRAC_1_PI) / light.miss / light.miss;
    (-(beta * (from + beta.lit(path_m)))).exp() * removed * scale
}

/// The same of a lamp that shines everywhere.
#[inline(always)]
fn between<N: Num>(beta: N, light: ToLight<N>, [from, to]: [N; 2]) -> N {
    let there = ToLight { closest: light.closest - from, ..light };
    (-(beta * from)).exp() * airlight(beta, there, to - from)
}

/// The same of a lamp that shines into a cone: Sun's where its light is full, and a rule
/// over the angle at the lamp where it fades.
#[inline(always)]
fn of_beam<N: Num>(beta: N, light: ToLight<N>, cone: &Crossed<N>, [from, to]: [N; 2]) -> N {
    let ends = [light.angle_at(from), light.angle_at(to)];
    let [full, faint] = cone.full_between(ends);
    let inner = [light.t_at(full).max(from).min(to), light.t_at(faint).max(from).min(to)];
    let [begin, end] = [inner[0], inner[1].max(inner[0])];
    let is_full = full.lt(faint);
    let mut sum = N::select(is_full, between(beta, light, [begin, end]), beta.lit(0.0));
    let scale = beta * beta.lit(0.25 * std::f64::consts::FRAC_1_PI) / light.miss;
    for [angle, weight] in cone.soft(ends) {
        let t = light.t_at(angle).max(from).min(to);
        let way = t + light.at(t).distance;
        sum += scale * weight * (-(beta * way)).exp();
    }
    sum
}

/// w = t + d, without cancellation before the closest point.
#[inline(always)]
fn path<N: Num>(t: N, d: N, h2: N) -> N {
    let before = t.lt(t.lit(0.0));
    N::select(before, h2 / (d - t), t + d)
}

#[cfg(test)]
mod tests {
    use super::airlight;
    use crate::light::ToLight;
    use glam::DVec3;

    fn at(gamma: f64, d_sv: f64, d_vp: f64, beta: f64) -> f64 {
        let light = DVec3::new(d_sv * gamma.sin(), 0.0, d_sv * gamma.cos());
        airlight(beta, ToLight::new(light.into(), DVec3::Z.into()), d_vp)
    }

    /// Erratum 4: towards a light beyond the surface, eq. 11 has an elementary limit.
    #[test]
    fn the_limit_towards_the_light_is_met() {
        let (beta, d_sv, d_vp) = (0.2, 5.0, 3.0);
        let limit = beta / (4.0 * std::f64::consts::PI) * (-beta * d_sv).exp() * d_vp
            / (d_sv * (d_sv - d_vp));
        for gamma in [0.0, 1e-9, 1e-6, 1e-4] {
            let relative = at(gamma, d_sv, d_vp, beta) / limit - 1.0;
            assert!(relative.abs() < 1e-4, "γ = {gamma}: {relative}");
        }
    }

    /// A ray through the light diverges in theory; the answer is finite and larger than beside it.
    #[test]
    fn a_ray_through_the_light_is_finite() {
        let through = at(0.0, 5.0, 9.0, 0.1);
        assert!(through.is_finite() && through > at(1e-3, 5.0, 9.0, 0.1));
    }

    /// Without fog there is no airlight.
    #[test]
    fn no_fog_no_light() {
        assert_eq!(at(0.3, 5.0, 9.0, 0.0), 0.0);
    }
}
