//! The airlight integral by fixed-step ray marching, as engines do it: what a comparison shows the
//! price of. Not for scenes.
//!
//! The ray is cut into equal steps, each lit as its middle is. There β and T from the light are the
//! exact closed forms, so that what is off comes from the steps alone; the transmittance to the eye
//! is multiplied up step by step, and a step sees that of its beginning. Its error falls as 1/steps;
//! next to a light, 1/d² between two samples is missed altogether.

use super::path::Path;
use crate::geometry::Ray;
use crate::media::Field;
use crate::phase::PhaseFunction;
use glam::DVec3;

/// L_a per unit of ω·I₀ [1/m²] of a light, along a ray up to `length` [m].
pub fn airlight(
    field: &Field,
    phase: PhaseFunction,
    light: DVec3,
    ray: Ray,
    length: f64,
    steps: u32,
) -> f64 {
    airlight_along(&Path::new(field, light, ray, length), phase, steps)
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
        let (beta, arrival) = (path.extinction(t), path.arrival(t));
        let scattered = beta * phase.value(arrival.cos) / (arrival.distance * arrival.distance);
        sum += scattered * (-depth - arrival.depth).exp() * step;
        depth += beta * step;
    }
    sum
}
