//! Prints how far single scattering and its octaves are from light that is scattered as often as it may be.

#![allow(clippy::print_stdout, reason = "it prints")]

use fogbank_tests::walk::measure;

fn main() {
    println!(
        "| T from lamp to eye | scattered once, share | single scattering, RMS | four octaves, RMS |"
    );
    println!("|---|---|---|---|");
    for depth in [0.25, 0.5, 1.0, 2.0, 5.0, 10.0, 25.0] {
        let row = measure(depth, 20_000);
        println!(
            "| {depth} | {:.2} | {:.0} % | {:.0} % |",
            row.first,
            100.0 * row.single,
            100.0 * row.octaves
        );
    }
}
