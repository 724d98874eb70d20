//! Numbers that are short in JSON.

use crate::json::Vec3;
use glam::DVec3;

/// `value` with its components rounded to 1 / `steps`.
pub fn rounded(value: DVec3, steps: f64) -> Vec3 {
    Vec3(value.to_array().map(|x| round_to(x, steps)))
}

/// `value` rounded to 1 / `steps`; never −0.
pub fn round_to(value: f64, steps: f64) -> f64 {
    (value * steps).round() / steps + 0.0
}
