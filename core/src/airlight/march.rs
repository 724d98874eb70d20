//! The airlight integral by fixed-step ray marching, as engines do it: what a comparison shows the
//! price of. Not for scenes.
//!
//! The ray is cut into equal steps, each lit as its middle is. There β and T from the light are the
//! exact closed forms, so that what is off comes from the steps alone; the transmittance to the eye
//! is multiplied up step by step, and a step sees that of its beginning. Its error falls as 1/steps;
//! next to a light, 1/d² between two samples is missed altogether.

use super::path::Path;
use crate::media::Field;
use crate::phase::Phase;
use glam::DVec3;

/// L_a per unit of ω·I₀ [1/m²] of a light, along a ray in the unit `direction` up to `length` [m].
pub fn airlight(
    field: &Field,
    phase: Phase,
    light: DVec3,
    origin: DVec3,
    direction: DVec3,
    length: f64,
    steps: u32,
) -> f64 {
    airlight_along(&Path::new(field, light, origin, direction, length), phase, steps)
}

/// The same of the path's light.
pub(crate) fn airlight_along(path: &Path, phase: Phase, steps: u32) -> f64 {
    if path.is_clear() {
        return 0.0;
    }
    let step = path.length / f64::from(steps);
    let (mut sum, mut depth) = (0.0, 0.0f64);
    for i in 0..steps {
        let t = (f64::from(i) + 0.5) * step;
        let (beta, lit) = (path.extinction(t), path.lit(t));
        let scattered = beta * phase.value(lit.cos) / (lit.distance * lit.distance);
        sum += scattered * (-depth - lit.depth).exp() * step;
        depth += beta * step;
    }
    sum
}
