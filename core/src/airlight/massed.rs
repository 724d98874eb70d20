//! Airlight along a ray where β changes faster than any rule of nodes would tell: waves, cells with edges.
//!
//! Between two places the light that fog removes is known whatever β does, e^(−T(a)) − e^(−T(b)), and the rest of
//! the integrand is smooth: T to the light, the phase function, and 1/d², whose own integral is an angle. So the
//! ray is cut where the map of [`mapped`](super::mapped) has even steps, and each part scatters what it removes.

use super::path::Path;
use crate::phase::PhaseFunction;

/// Parts of a section. What they miss falls with the square of their number: 1e-5 of smooth fog.
const PARTS: u32 = 1024;
/// Under a sky, whose light is known to no more than 1e-3.
const PARTS_UNDER_SKY: u32 = 128;

/// Finest lengths of a fog that the largest rule still tells on a section: some 120 of its waves.
const TOLD: f64 = 800.0;

/// Whether the fog changes too often between two ray parameters for a rule.
pub fn is_needed(path: &Path, from: f64, to: f64) -> bool {
    path.is_rippled() && to - from > TOLD * path.finest_m(from, to)
}

/// L_a per unit of ω·I₀ [1/m²] of a section, given where even shares of its map lie.
pub fn airlight(
    path: &Path,
    phase: PhaseFunction,
    [from, to]: [f64; 2],
    at: impl Fn(f64) -> f64,
) -> f64 {
    let parts = if path.slack() > 1.0 { PARTS_UNDER_SKY } else { PARTS };
    let place = |i: u32| match i {
        0 => from,
        i if i == parts => to,
        _ => at(f64::from(i) / f64::from(parts)).clamp(from, to),
    };
    let mut before = Place::new(path, from);
    let mut sum = 0.0;
    for i in 1..=parts {
        let next = Place::new(path, place(i));
        sum += part(path, phase, &before, &next);
        before = next;
    }
    sum
}

/// A place of the ray: T of all and of the group that scatters.
struct Place {
    t: f64,
    depth: f64,
    own: f64,
}

impl Place {
    fn new(path: &Path, t: f64) -> Self {
        let depth = path.depth(t);
        Self { t, depth, own: if path.is_alone() { depth } else { path.own_depth(t) } }
    }
}

/// What a part scatters: its mean extinction, as it is seen, times the glow of the light on the way.
fn part(path: &Path, phase: PhaseFunction, a: &Place, b: &Place) -> f64 {
    let length = b.t - a.t;
    if length <= 0.0 {
        return 0.0;
    }
    let turn = b.depth - a.depth;
    let seen = if turn.abs() > 1e-9 { -(-turn).exp_m1() / turn } else { 1.0 - 0.5 * turn };
    let mass = (b.own - a.own) * (-a.depth).exp() * seen;
    let (light, middle) = (&path.to_light, 0.5 * (a.t + b.t));
    let glow = light.angle(a.t, b.t) / light.miss * phase.value(light.at(middle).cos);
    mass / length * glow * path.weight(middle) * (-path.shade(middle)).exp()
}
