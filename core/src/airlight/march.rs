//! The airlight integral by fixed-step ray marching, as engines do it: what a comparison shows the
//! price of. Not for scenes.
//!
//! The ray is cut into equal steps, each lit as its middle is. There β and T from the light are the
//! exact closed forms, so that what is off comes from the steps alone; the transmittance to the eye
//! is multiplied up step by step, and a step sees that of its beginning. Its error falls as 1/steps;
//! next to a light, 1/d² between two samples is missed altogether.

use super::path::Path;
use crate::geometry::Ray;
use crate::light::Source;
use crate::media::Field;
use crate::phase::PhaseFunction;

/// L_a per unit of ω·I₀ [1/m²] of a light in fog whose terms all scatter alike, along a ray up to
/// `length` [m].
pub fn airlight(
    field: &Field,
    phase: PhaseFunction,
    light: Source,
    ray: Ray,
    length: f64,
    steps: u32,
) -> f64 {
    airlight_along(&Path::new(field, 0, light, ray, length), phase, steps)
}

/// The same of the path's light.
pub(crate) fn airlight_along(path: &Path, phase: PhaseFunction, steps: u32) -> f64 {
    if path.is_clear() {
        return 0.0;
    }
    let step = path.length / f64::from(steps);
    let (mut sum, mut depth) = (0.0, 0.0f64);
    for i in 0..steps {
        let t = (f64::from(i) + 0.5) * step;
        let (beta, arrival) = (path.extinction(t), path.to_light.at(t));
        let own = if path.is_alone() { beta } else { path.own_extinction(t) };
        let weight = if path.is_lit(t) { path.weight(t) } else { 0.0 };
        let scattered = arrival.falloff(own * phase.value(arrival.cos) * weight);
        sum += scattered * (-depth - path.shade(t)).exp() * step;
        depth += beta * step;
    }
    sum
}
