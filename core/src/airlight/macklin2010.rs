//! Airlight of a point light in homogeneous fog that takes nothing away (Macklin 2010): L_a = σ_s I ∫ dt/d², σ_s with
//! the isotropic 1/4π in it.
//!
//! The integral is the angle that the ray turns through before the light, divided by the light's distance from it.
//! Ours: that distance is a cross product and the angle one arc tangent, where the published difference of squares
//! and of two arc tangents fail in f32 (erratum 17).

use super::about::{About, Exactness, Takes};
use super::sun2005;
use crate::light::ToLight;
use crate::num::Num;
use std::f64::consts::PI;

/// What is said about it.
pub const ABOUT: About = About {
    source: "Macklin: In-Scattering Demo (2010): the closed form of a point light's airlight where fog takes no light \
        away.",
    takes: Some(Takes {
        name: "macklin2010",
        what: "homogeneous fog",
        term: sun2005::takes,
        several: true,
    }),
    error: Exactness::Words(
        "Exact where fog takes no light away; else too bright, by up to e^T of the optical depth T from the light to the \
        eye.",
    ),
};

/// L_a per unit of ω·I₀ [1/m²] of a point light along a ray up to `length` [m], in fog of extinction
/// `beta` [1/m].
#[inline(always)]
pub fn airlight<N: Num>(beta: N, light: ToLight<N>, length: N) -> N {
    let angle = light.angle(length.lit(0.0), length);
    beta * angle / light.miss * length.lit(0.25 / PI)
}
