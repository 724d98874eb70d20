//! Fewer blobs far away, beside what that costs: time, and how far the mean optical depth is off.

use super::maps::measure_with;
use fogbank_core::Frame;
use fogbank_core::request::Options;
use fogbank_tests::scenes::Random;
use serde_json::{Value, json};

const SIZE: [u32; 2] = [800, 600];
const BLOBS: usize = 100_000;

pub fn print() {
    println!(
        "\n## Fewer blobs far away\n\n\
         T of every pixel at {}×{} over a plain of {BLOBS} blobs, of which `lod_error` leaves some out: what the pass takes \
         [ms],\nand by how much the mean optical depth is off.\n\n\
         | lod_error | pass | off |\n|---|---|---|",
        SIZE[0], SIZE[1]
    );
    let plain = plain();
    let (_, all) = measure_with(Options::default(), &plain, SIZE);
    for lod_error in [0.0, 0.005, 0.01, 0.05, 0.2] {
        let (ms, frame) = measure_with(Options { lod_error, ..Options::default() }, &plain, SIZE);
        let off = (mean(&frame) / mean(&all) - 1.0).abs();
        println!("| {lod_error} | {ms:.0} | {:.2} % |", 100.0 * off);
    }
}

/// The mean optical depth of a picture of what comes through.
fn mean(frame: &Frame) -> f64 {
    frame.pixels.iter().map(|through| -f64::from(*through).ln()).sum::<f64>()
        / frame.pixels.len() as f64
}

/// Small blobs over a plain that reaches far away.
fn plain() -> Value {
    let mut random = Random(5);
    let mut blob = || {
        json!({ "center": [random.between(-1500.0, 1500.0), random.between(0.0, 8.0), random.between(-3000.0, 0.0)],
            "radius": random.decades(1.0, 6.0), "extinction": random.decades(0.003, 0.03) })
    };
    let blobs: Vec<_> = (0..BLOBS).map(|_| blob()).collect();
    json!({
        "camera": { "position": [0, 12, 60], "target": [0, 2, -400] },
        "surfaces": [{ "shape": { "kind": "plane" } }],
        "fog": { "airlight": "none", "terms": [{ "kind": "gaussians", "blobs": blobs }] },
        "far_m": 5000 })
}
