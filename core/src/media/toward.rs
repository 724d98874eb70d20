//! What changes in a straight line while time goes on.

use crate::json::{Spectrum, Vec3};

/// What lies between two values, in a straight line.
pub trait Toward {
    /// At that share of the way to another.
    #[must_use]
    fn toward(&self, other: &Self, share: f64) -> Self;
}

impl Toward for f64 {
    fn toward(&self, other: &f64, share: f64) -> f64 {
        (1.0 - share) * self + share * other
    }
}

impl Toward for [f64; 3] {
    fn toward(&self, other: &Self, share: f64) -> Self {
        [0, 1, 2].map(|k| self[k].toward(&other[k], share))
    }
}

impl Toward for Vec3 {
    fn toward(&self, other: &Self, share: f64) -> Self {
        Self(self.0.toward(&other.0, share))
    }
}

impl Toward for Spectrum {
    fn toward(&self, other: &Self, share: f64) -> Self {
        match (self, other) {
            (Self::Grey(a), Self::Grey(b)) => Self::Grey(a.toward(b, share)),
            (a, b) => Self::Rgb(a.channels().toward(&b.channels(), share)),
        }
    }
}
