//! Fog that is the same everywhere: β(x) = β₀, T(a, b) = β₀ |a − b| (Sun 2005, eq. 3).

use crate::scene;

/// The sum of all homogeneous terms.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Homogeneous {
    /// Extinction β₀ [1/m].
    pub beta: f64,
}

impl Homogeneous {
    /// Adds up the terms.
    pub fn new<'a>(terms: impl Iterator<Item = &'a scene::Homogeneous>) -> Self {
        // An empty f64 sum is −0, and what is divided by that is minus infinity.
        Self { beta: terms.map(scene::Homogeneous::extinction_per_m).fold(0.0, |a, b| a + b) }
    }

    /// T along a path of that length [m].
    pub fn optical_depth(&self, length: f64) -> f64 {
        self.beta * length
    }
}
