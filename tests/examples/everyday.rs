//! Prints the errors of `auto` on everyday scenes under an open sky, every pixel of them, as a table
//! in Markdown: `cargo run --release -p fogbank-tests --example everyday`.

use fogbank_tests::everyday::{Exact, SCENES, everyday};
use fogbank_tests::trials::{Errors, Use};

fn main() {
    println!("| scene | `far_m` | haze | probes | float | step | 8-bit | step | draft | step |");
    println!("|---|---|---|---|---|---|---|---|---|---|");
    for number in 0..SCENES {
        let json = everyday(number);
        let exact = Exact::new(&json, 120);
        let cells = [Use::Numbers, Use::Screen, Use::Draft].map(|wanted| {
            let seen = exact.measure(wanted);
            format!("{} | {:.2}", words(seen.errors), 100.0 * seen.step)
        });
        let haze = json["fog"]["terms"][0]["extinction"].as_f64().unwrap_or_default();
        let far = json["far_m"].as_f64().unwrap_or_default();
        let probes = words(exact.of_probes(100));
        println!("| {number} | {far:.0} | {haze:.0e} | {probes} | {} |", cells.join(" | "));
    }
}

fn words(errors: Errors) -> String {
    errors.map(|error| format!("{:.2}", 100.0 * error)).join(" / ")
}
