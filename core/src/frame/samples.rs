//! Where pixels are sampled, and how samples count.

use crate::request::{Layer, View};
use glam::DVec2;

/// Where a pixel is sampled that needs no more: its centre.
pub const CENTER: DVec2 = DVec2::splat(0.5);

/// Whether samples are weighed by their radiance.
pub fn weighs(view: &View) -> bool {
    view.for_screen && view.layer == Layer::Beauty
}

/// Evenly spread places in a pixel: the additive recurrence of the plastic number.
pub fn shifts(count: usize) -> Vec<DVec2> {
    const PLASTIC: f64 = 1.324_717_957_244_746;
    let step = DVec2::new(1.0 / PLASTIC, 1.0 / (PLASTIC * PLASTIC));
    (0..count).map(|i| (0.5 + step * i as f64).fract()).collect()
}
