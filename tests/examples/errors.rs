//! Prints the errors that the estimators state of themselves, measured now.

use fogbank_core::airlight::Airlight;
use fogbank_core::options::LOSSES;
use fogbank_tests::errors::{measure, measure_loss, stated};

fn main() {
    for airlight in Airlight::ALL.iter().filter(|airlight| stated(**airlight).is_some()) {
        let [median, p95, max] = measure(*airlight).map(rounded_up);
        println!("{airlight:?}: [{median:.1e}, {p95:.1e}, {max:.1e}]");
    }
    for loss in LOSSES {
        for (value, _) in loss.measured {
            let [median, p95, max] = measure_loss(&loss, *value).map(rounded_up);
            println!("{} {value}: [{median:.1e}, {p95:.1e}, {max:.1e}]", loss.name);
        }
    }
}

/// To two digits, with a twentieth to spare.
fn rounded_up(error: f64) -> f64 {
    let size = 10f64.powf((1.05 * error).max(1e-16).log10().floor() - 1.0);
    (1.05 * error / size).ceil() * size
}
