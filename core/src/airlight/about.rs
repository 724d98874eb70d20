//! What is said about an estimator beside its code: where it comes from, what it takes, and how far it
//! is from the truth, as measured on the test scenes.
//!
//! `cargo run -p fogbank-tests --example errors` measures and prints the errors; the tests measure them
//! again, and fail where one promises more than is kept.

use crate::media::Term;

/// What is said about an estimator.
#[derive(Clone, Copy, Debug)]
pub struct About {
    /// Where it was published, with the equations.
    pub source: &'static str,
    /// What it takes, if that is not every fog.
    pub takes: Option<Takes>,
    /// How far it is from the truth.
    pub error: Exactness,
}

/// The fog that an estimator takes; it scatters isotropically.
#[derive(Clone, Copy, Debug)]
pub struct Takes {
    /// The estimator's name.
    pub name: &'static str,
    /// What, besides no fog at all.
    pub what: &'static str,
    /// Whether it takes a term.
    pub term: fn(&Term) -> bool,
    /// Whether terms may differ in their albedo.
    pub several: bool,
}

/// How far an estimator is from the truth.
#[derive(Clone, Copy, Debug)]
pub enum Exactness {
    /// In words.
    Words(&'static str),
    /// As measured.
    Measured(MeasuredError),
}

/// The relative errors of an estimator, rounded up with a twentieth to spare: other machines round
/// otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredError {
    /// What it was compared with, on what.
    pub against: &'static str,
    /// Median.
    pub median: f64,
    /// 95th percentile.
    pub p95: f64,
    /// The largest.
    pub max: f64,
}

/// What pictures of any fog are compared with.
pub const PICTURES: &str = "the reference, pixel by pixel over the presets and random scenes";

impl Exactness {
    /// Median, 95th percentile and largest relative error.
    pub const fn measured(against: &'static str, [median, p95, max]: [f64; 3]) -> Self {
        Self::Measured(MeasuredError { against, median, p95, max })
    }
}
