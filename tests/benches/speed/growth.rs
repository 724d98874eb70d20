//! How time grows with pixels, blobs and lamps.

use super::clock::measure;
use fogbank_core::presets;
use fogbank_core::request::Quality;
use fogbank_tests::scenes::Random;
use serde_json::{Value, json};

const SIZE: [u32; 2] = [800, 600];

pub fn print() {
    println!(
        "\n## How time grows\n\n\
         Drafts and full pictures, each with the exponent of growth since the line before: 1 is in proportion.\n"
    );
    let city = presets::all().into_iter().find(|preset| preset.name == "city-353").unwrap();
    let city = json!(city.scene);
    let mut table = Table::new("pixels of the city");
    for size in [[400, 300], [800, 600], [1600, 1200], [3840, 2160]] {
        table.row(f64::from(size[0] * size[1]), &format!("{}×{}", size[0], size[1]), &city, size);
    }
    let mut table =
        Table::new("blobs of a bank of fog before 4 lamps, each smaller the more there are");
    for count in [30, 300, 1_000, 3_000, 10_000, 30_000, 100_000] {
        table.row(f64::from(count), &count.to_string(), &cloud(count as usize, 4), SIZE);
    }
    let mut table = Table::new("lamps in and above a bank of 300 blobs");
    for count in [1, 4, 16, 64] {
        table.row(f64::from(count), &count.to_string(), &cloud(300, count as usize), SIZE);
    }
    println!();
}

/// A table whose last line is known: how many, and both times.
struct Table(Option<(f64, [f64; 2])>);

impl Table {
    fn new(title: &str) -> Self {
        println!("\n| {title} | draft | exponent | full | exponent |\n|---|---|---|---|---|");
        Self(None)
    }

    fn row(&mut self, count: f64, name: &str, json: &Value, size: [u32; 2]) {
        let times = [Quality::Draft, Quality::Full].map(|how| measure(json, size, how).whole);
        let exponent = |k: usize| {
            self.0.map_or(String::new(), |(before, earlier)| {
                format!("{:.2}", (times[k] / earlier[k]).ln() / (count / before).ln())
            })
        };
        println!(
            "| {name} | {:.0} | {} | {:.0} | {} |",
            times[0],
            exponent(0),
            times[1],
            exponent(1)
        );
        self.0 = Some((count, times));
    }
}

/// A bank of fog, of optical depth 2 or so however many blobs it is made of, lamps in and above it.
fn cloud(blobs: usize, lamps: usize) -> Value {
    let mut random = Random(blobs as u64);
    // Each blob overlaps with as many others.
    let radius = 3.0 / (blobs as f64).cbrt();
    let blobs = random.blobs(blobs, 4.0, [0.8 * radius, 1.25 * radius], [0.02, 0.08]);
    let first = [[2.0, 3.0, 1.0], [-3.0, 5.0, 2.0], [4.0, 1.0, -3.0], [-1.0, -2.0, 6.0]];
    let mut places = Random(7);
    let more = std::iter::from_fn(|| Some((places.point(6.0)).to_array()));
    let lamp = |at: [f64; 3]| json!({ "kind": "point", "position": at, "intensity": [9, 8, 7] });
    let lamps: Vec<_> = first.into_iter().chain(more).take(lamps).map(lamp).collect();
    json!({ "camera": { "position": [0, 1, 12], "target": [0, 0, 0] }, "lights": lamps,
        "fog": { "terms": [{ "kind": "homogeneous", "extinction": 0.01 }, blobs] },
        "far_m": 40 })
}
