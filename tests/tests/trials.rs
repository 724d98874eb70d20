//! `auto` against the integral itself, on scenes made to break it.

use fogbank_tests::trials::{Errors, Use, all};

fn within(what: &str, errors: Errors, [median, p95]: [f64; 2]) {
    let [m, p, _] = errors;
    assert!(m <= median && p <= p95, "{what}: median {m:.4}, p95 {p:.4}");
}

fn check(wanted: Use) {
    for trial in all() {
        let measured = trial.measure("auto", wanted, 600, 200);
        within(&trial.name, measured.everywhere, [0.003, 0.03]);
        // A screen shows 256 steps: where blobs are a few pixels wide, neighbours differ by more
        // than that anyway.
        let is_fine = wanted == Use::Screen && trial.name == "tiny-blobs";
        let most = if is_fine { 0.05 } else { 0.005 };
        within(&format!("{}, seams", trial.name), measured.seams, [0.002, most]);
        if let Some(near) = measured.near_lamps {
            within(&format!("{}, near a lamp", trial.name), near, [0.01, 0.05]);
        }
    }
}

#[test]
fn numbers_are_right_where_the_published_method_is_not() {
    check(Use::Numbers);
}

#[test]
fn pictures_for_the_eye_are_right_as_well() {
    check(Use::Screen);
}

#[test]
fn drafts_stay_near_the_truth() {
    for trial in all() {
        let measured = trial.measure("auto", Use::Draft, 300, 60);
        assert!(measured.everywhere[0] <= 0.03, "{}: {:?}", trial.name, measured.everywhere);
    }
}
