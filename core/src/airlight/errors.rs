//! How far each estimator is from the truth, as measured on the test scenes: for documentation, and
//! for the tests, which measure again and fail where a row promises more than is kept.
//!
//! `cargo run -p fogbank-tests --example errors` measures and prints the rows.

use super::Airlight;

/// The relative errors of one estimator.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeasuredError {
    /// Which one.
    pub airlight: Airlight,
    /// What it was compared with, on what.
    pub against: &'static str,
    /// Median.
    pub median: f64,
    /// 95th percentile.
    pub p95: f64,
    /// The largest.
    pub max: f64,
}

const PICTURES: &str = "the reference, pixel by pixel over the presets and random scenes";
const HOMOGENEOUS: &str = "the reference, pixel by pixel over scenes of homogeneous fog";
const RULE: &str = "a quadrature of another kind, along random rays";

/// One row an estimator, rounded up with a twentieth to spare: other machines round otherwise.
pub const MEASURED: [MeasuredError; 4] = [
    row(Airlight::Sun2005, HOMOGENEOUS, [1.8e-7, 4.4e-7, 1.1e-5]),
    row(Airlight::Fogshop2007, PICTURES, [0.036, 0.53, 1.4]),
    row(Airlight::Reference, RULE, [3.5e-16, 1.1e-14, 2.9e-13]),
    row(Airlight::Auto, PICTURES, [1.7e-6, 1.1e-4, 1.7e-2]),
];

const fn row(
    airlight: Airlight,
    against: &'static str,
    [median, p95, max]: [f64; 3],
) -> MeasuredError {
    MeasuredError { airlight, against, median, p95, max }
}

/// The row of an estimator, if it has one.
pub fn measured(airlight: Airlight) -> Option<&'static MeasuredError> {
    MEASURED.iter().find(|row| row.airlight == airlight)
}
