//! The airlight integral itself (Fogshop 2, Sun 3), by adaptive quadrature in f64: closed-form T on
//! both legs, no closed form of airlight. Slow; what every other method is measured against.
//!
//! With t = t_s + h sinh u the factor dt/d² is du/d: a light close to the ray costs no accuracy, and
//! the integrand stays smooth. The phase function has cos α = −tanh u there: it turns from ahead to
//! back within a few units of u, however sharp it is. Panels are first halved until none is long
//! against the lumps that it crosses, so that no lump is overlooked, nor against that turn, then
//! where the Gauss–Kronrod pair differs most. [`ABOUT`] states its error.

use super::about::{About, Exactness};
use super::path::Path;
use crate::geometry::Ray;
use crate::light::Source;
use crate::media::Field;
use crate::phase::PhaseFunction;
use crate::quadrature;

/// What is said about it.
pub const ABOUT: About = About {
    source: "The single-scattering integral itself, by adaptive quadrature in f64.",
    takes: None,
    error: Exactness::measured(
        "a quadrature of another kind, along random rays",
        [3.5e-16, 1.1e-14, 2.9e-13],
    ),
};

/// L_a per unit of ω·I₀ [1/m²] of a light in fog whose terms all scatter alike, along a ray up to
/// `length` [m].
pub fn airlight(field: &Field, phase: PhaseFunction, light: Source, ray: Ray, length: f64) -> f64 {
    airlight_along(&Path::new(field, 0, light, ray, length), phase)
}

/// The same of the path's light.
pub(crate) fn airlight_along(path: &Path, phase: PhaseFunction) -> f64 {
    if path.is_clear() {
        return 0.0;
    }
    let of_part = |ends: [f64; 2]| {
        let mut panels = panels(path, ends);
        if !phase.is_isotropic() {
            panels = within_turns(&panels);
        }
        quadrature::adaptive(&panels, path.slack() * 1e-7, |u| integrand(path, phase, u))
    };
    path.lit(0.0, path.length).map(of_part).sum()
}

/// β k(α) e^(−T(v,x)−T(x,s)) / d, the integrand over u.
fn integrand(path: &Path, phase: PhaseFunction, u: f64) -> f64 {
    let (value, arrival) = path.scattered(phase, path.to_light.rolled(u));
    arrival.falloff(value) * arrival.distance
}

/// Ends of panels in u on a part of the ray, each short against the lumps that it crosses.
fn panels(path: &Path, [from, to]: [f64; 2]) -> Vec<f64> {
    // No panel reaches over an edge of the fog, where the integrand jumps, nor over the light.
    let mut open = path.sections(from, to);
    open.push(path.to_light.closest);
    open.retain(|t| from < *t && *t <= to);
    open.sort_unstable_by(|a, b| b.total_cmp(a));
    let mut ends = vec![from];
    while let Some(&end) = open.last() {
        let start = ends[ends.len() - 1];
        if end - start > path.resolution(start, end) && ends.len() < 4096 {
            open.push(0.5 * (start + end));
        } else {
            ends.push(end);
            open.pop();
        }
    }
    ends.iter().map(|t| path.to_light.unrolled(*t)).collect()
}

/// The same ends and as many between them that the cosine does not turn within one panel unseen.
fn within_turns(ends: &[f64]) -> Vec<f64> {
    /// tanh u and its powers are analytic up to π/2 from the real line.
    const TURN: f64 = 2.0;
    let halved = ends.windows(2).flat_map(|pair| {
        let parts = ((pair[1] - pair[0]) / TURN).ceil().max(1.0);
        let width = (pair[1] - pair[0]) / parts;
        (0..parts as u32).map(move |i| pair[0] + f64::from(i) * width)
    });
    halved.chain(ends.last().copied()).collect()
}
