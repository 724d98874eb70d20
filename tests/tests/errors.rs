//! The stated errors of the estimators are those that are measured.

use fogbank_core::options::LOSSES;
use fogbank_core::scene::Airlight;
use fogbank_tests::errors::{measure, measure_loss, stated};

fn check(airlight: Airlight) {
    let stated = stated(airlight).expect("numbers");
    let measured = measure(airlight);
    // Rounding, of f32 in pictures and of f64 along rays: every machine does it in its own way.
    let rounding = if airlight == Airlight::Reference { 1e-12 } else { 1e-6 };
    for (stated, measured) in stated.into_iter().zip(measured) {
        // No better than measured; and no old row either, after an estimator got better.
        assert!(measured <= stated.max(rounding), "{airlight:?}: stated {stated}, but {measured}");
        assert!(
            stated <= 1.5 * measured.max(rounding),
            "{airlight:?}: stated {stated}, but {measured}"
        );
    }
}

#[test]
fn sun2005_is_as_exact_as_stated() {
    check(Airlight::Sun2005);
}

#[test]
fn fogshop2007_is_as_exact_as_stated() {
    check(Airlight::Fogshop2007);
}

#[test]
fn reference_is_as_exact_as_stated() {
    check(Airlight::Reference);
}

#[test]
fn auto_is_as_exact_as_stated() {
    check(Airlight::Auto);
}

/// What pictures lose for speed is what is stated.
#[test]
fn options_lose_as_much_as_stated() {
    for loss in LOSSES {
        for (value, stated) in loss.measured {
            for (stated, measured) in stated.iter().zip(measure_loss(&loss, *value)) {
                let what = format!("{} {value}: stated {stated}, but {measured}", loss.name);
                assert!(
                    measured <= stated.max(1e-6) && *stated <= 1.5 * measured.max(1e-6),
                    "{what}"
                );
            }
        }
    }
}
