//! Prints the table of `core/src/airlight/errors.rs`, measured now.

use fogbank_core::airlight::errors::MEASURED;
use fogbank_tests::errors::measure;

fn main() {
    for stated in MEASURED {
        let [median, p95, max] = measure(stated.airlight).map(rounded_up);
        println!("{:?}: [{median:.1e}, {p95:.1e}, {max:.1e}]", stated.airlight);
    }
}

/// To two digits, with a twentieth to spare.
fn rounded_up(error: f64) -> f64 {
    let size = 10f64.powf((1.05 * error).max(1e-16).log10().floor() - 1.0);
    (1.05 * error / size).ceil() * size
}
