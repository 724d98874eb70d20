//! Fogmaps beside the tables of their paper: T along every ray of a picture, by degree, size, levels and μ.

use super::peak::Machine;
use fogbank_core::media::{Field, Moment};
use fogbank_core::request::{Layer, Options, Quality, View};
use fogbank_core::scene::{Fog, read};
use fogbank_core::{Frame, Progress, Renderer};
use fogbank_tests::scenes::{Random, scene, view};
use serde_json::{Value, json};
use std::hint::black_box;
use std::time::Instant;

const SIZE: [u32; 2] = [800, 600];
/// Pictures a second of Giroud and Biri 2010, Table 1: degrees 0 to 2, on a GeForce GTX 280 of 622 GFLOP/s.
const PAPER: [(usize, [f64; 3]); 3] =
    [(16, [199.0, 142.0, 71.0]), (32, [124.0, 83.0, 31.0]), (64, [90.0, 45.0, 15.0])];
const CARD: f64 = 622.0;
/// Side of the map whatever its cells [m].
const SIDE_M: f64 = 64.0;

pub fn print(machine: &Machine) {
    println!(
        "\n## Fogmaps\n\n\
         Optical depths of every pixel at {}×{}, seen from within a map that reaches over the whole view: what the pass takes\n\
         [ms], that a ray and cell [ns], and the ratio to Giroud and Biri's Table 1 as above (a GeForce GTX 280).\n\n\
         | map | degree 0 | ns | ratio | degree 1 | ns | ratio | degree 2 | ns | ratio |\n|---|---|---|---|---|---|---|---|---|---|",
        SIZE[0], SIZE[1]
    );
    for side in [16, 32, 64, 128, 256] {
        let cells = (0..3).map(|degree| {
            let (ms, _) = measure(&stage(map(side, degree, 0, 1.0, true)), SIZE);
            let crossed = mean_crossed(side);
            let ns = ms * 1e6 / f64::from(SIZE[0] * SIZE[1]) / crossed;
            let paper = PAPER.iter().find(|(of, _)| *of == side).map(|(_, rates)| rates[degree]);
            let ratio = paper.map_or("–".into(), |rate| {
                format!("{:.2}", ms * machine.peak / (1e3 / rate * CARD))
            });
            format!("{ms:.1} | {ns:.2} | {ratio}")
        });
        println!("| {side}×{side} | {} |", cells.collect::<Vec<_>>().join(" | "));
    }
    print_decomposition();
    print_levels();
}

/// What it takes to take a changed map of 256×256 apart.
fn print_decomposition() {
    let term = map(256, 1, 5, 0.5, true);
    let fog: Fog = read(json!({ "terms": [term] }).to_string().as_bytes()).unwrap();
    let take_apart = |_| {
        let since = Instant::now();
        black_box(Field::new(&fog.terms, 0, &Moment::default()));
        since.elapsed().as_secs_f64() * 1e3
    };
    let best = (0..9).map(take_apart).fold(f64::INFINITY, f64::min);
    println!("\nA changed linear map of 256×256 is taken apart into five levels in {best:.1} ms.");
}

/// Levels and μ of the linear map of 64×64: time, and what is lost.
fn print_levels() {
    let (_, whole) = measure(&stage(map(64, 1, 0, 1.0, true)), SIZE);
    for deconstruct in [true, false] {
        let how = if deconstruct { "merged" } else { "each by itself" };
        println!(
            "\nLevels of the linear map of 64×64 (Tables 2 and 3), details {how}: ms, and the mean error of e^(−T) in per cent.\n\n\
             | levels | μ = 1 | 0.8 | 0.6 | 0.4 | 0.2 | 0 |\n|---|---|---|---|---|---|---|"
        );
        for levels in 1..=3 {
            let cell = |mu: f64| {
                let (ms, frame) = measure(&stage(map(64, 1, levels, mu, deconstruct)), SIZE);
                let off =
                    frame.pixels.iter().zip(&whole.pixels).map(|(a, b)| f64::from((a - b).abs()));
                let error = off.sum::<f64>() / frame.pixels.len() as f64;
                format!("{ms:.1}, {:.1}", 100.0 * error)
            };
            let cells = [1.0, 0.8, 0.6, 0.4, 0.2, 0.0].map(cell);
            println!("| {levels} | {} |", cells.join(" | "));
        }
    }
}

fn stage(term: Value) -> Value {
    json!({
        "camera": { "position": [0.3, 4, 30], "target": [0.1, 2, 0] },
        "surfaces": [{ "shape": { "kind": "plane" } }],
        "fog": { "airlight": "none", "terms": [term] }, "far_m": 200,
    })
}

fn map(side: usize, degree: usize, levels: u32, mu: f64, deconstruct: bool) -> Value {
    let mut random = Random(3);
    let row = |random: &mut Random| (0..side).map(|_| random.between(0.0, 1.0)).collect::<Vec<_>>();
    let rows: Vec<_> = (0..side).map(|_| row(&mut random)).collect();
    json!({ "kind": "fogmap", "degree": degree, "origin": [-SIDE_M / 2.0, -SIDE_M / 2.0],
        "cell_m": SIDE_M / side as f64, "scale": 0.05, "coefficients": rows, "levels": levels,
        "mu": mu, "deconstruct": deconstruct })
}

/// Sides of cells that a ray of the picture passes, in the mean: what it crosses of the map.
fn mean_crossed(side: usize) -> f64 {
    let json = stage(map(2, 0, 0, 1.0, true));
    let scene = scene(&json);
    let rays = fogbank_tests::scenes::pixel_rays(&scene, 40, 30);
    let crossed = rays.iter().map(|ray| {
        let (o, d) = (ray.origin, ray.direction);
        // To the floor, or to the map's end.
        let floor = if d.y < 0.0 { -o.y / d.y } else { 200.0 };
        let end = |o: f64, d: f64| (SIDE_M / 2.0 * d.signum() - o) / d;
        let length = floor.min(end(o.x, d.x)).min(end(o.z, d.z));
        length * (d.x.abs() + d.z.abs()) * side as f64 / SIDE_M
    });
    crossed.sum::<f64>() / rays.len() as f64 + 1.0
}

/// What the fog's pass takes, the best of some pictures, and one of them.
pub fn measure(json: &Value, size: [u32; 2]) -> (f64, Frame) {
    measure_with(Options::default(), json, size)
}

/// The same of pictures that may lose something.
pub fn measure_with(options: Options, json: &Value, size: [u32; 2]) -> (f64, Frame) {
    let renderer = Renderer::default();
    let asked = view(size[0], size[1], Layer::Transmittance, Quality::Full);
    let asked = View { samples: Some(1), options, ..asked };
    let mut best = f64::INFINITY;
    let mut json = json.clone();
    let since = Instant::now();
    loop {
        json["camera"]["position"][0] =
            json!(json["camera"]["position"][0].as_f64().unwrap() + 1e-4);
        let frame = renderer.render(&scene(&json), &asked, &Progress::default()).unwrap();
        let of_fog = frame.timings.iter().filter(|lap| lap.pass.starts_with("airlight"));
        best = of_fog.map(|lap| lap.took.as_secs_f64() * 1e3).fold(best, f64::min);
        if since.elapsed().as_secs_f64() > 0.5 {
            return (best, frame);
        }
    }
}
