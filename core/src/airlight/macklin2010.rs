//! Airlight of a point light in homogeneous fog that takes nothing away (Macklin 2010): L_a = σ_s I ∫ dt/d², σ_s with
//! the isotropic 1/4π in it.
//!
//! The integral is the angle that the ray turns through before the light, divided by the light's distance from it.
//! Ours: that distance is a cross product and the angle one arc tangent, where the published difference of squares
//! and of two arc tangents fail in f32 (erratum 17).
//!
//! Particles are slabs, along each of which fog is the same: the same closed form between a slab's ends.

use super::about::{About, Exactness, Takes};
use super::sun2005;
use crate::geometry::Ray;
use crate::light::{Crossed, ToLight};
use crate::media::gaussians::{Draw, draw_of};
use crate::media::{Field, Term};
use crate::num::Num;
use std::f64::consts::PI;

/// What is said about it.
pub const ABOUT: About = About {
    source: "Macklin: In-Scattering Demo (2010): the closed form of a point light's airlight where fog takes no light \
        away.",
    takes: Some(Takes {
        name: "macklin2010",
        what: "homogeneous fog, gaussians as slabs and emitters as slabs",
        term: takes,
        several: true,
    }),
    error: Exactness::Words(
        "Exact where fog takes no light away; else too bright, by up to e^T of the optical depth T from the light to the \
        eye.",
    ),
};

/// Whether it takes a term.
fn takes(term: &Term) -> bool {
    sun2005::takes(term) || draw_of(term) == Some(Draw::Slab)
}

/// L_a per unit of ω·I₀ [1/m²] of a lamp that may shine into a cone, between two ray parameters [m], in fog of
/// extinction `beta` [1/m]: what a ray or a slab of fog scatters.
#[inline(always)]
pub fn within<N: Num>(
    beta: N,
    light: ToLight<N>,
    cone: Option<&Crossed<N>>,
    [from, to]: [N; 2],
) -> N {
    let turn = match cone {
        Some(cone) => cone.turn([light.angle_at(from), light.angle_at(to)]),
        None => light.angle(from, to),
    };
    beta * turn / light.miss * to.lit(0.25 / PI)
}

/// That of all blobs of a group as slabs, in f64; `within` is what light comes between two ray parameters.
pub fn of_slabs(
    field: &Field,
    group: usize,
    ray: &Ray,
    length_m: f64,
    within: impl Fn(f64, [f64; 2]) -> f64,
) -> f64 {
    let blobs = &field.groups()[group].gaussians;
    let of_blob = |place: usize| {
        let slab = blobs.all()[place].seen_by_eye(ray.origin).slab(ray.direction.into(), length_m);
        within(slab.beta, slab.ends)
    };
    blobs.on_ray(ray, length_m).into_iter().map(of_blob).fold(0.0, |a, b| a + b)
}
