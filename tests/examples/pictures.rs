//! Prints how long whole 8-bit pictures of 800×600 take, as a table in Markdown: the presets, and the
//! slowest of the everyday scenes: `cargo run --release -p fogbank-tests --example pictures`.

use fogbank_core::image::Format;
use fogbank_core::presets;
use fogbank_core::request::{Layer, Quality, View};
use fogbank_core::{Progress, Renderer};
use fogbank_tests::everyday::{SCENES, everyday};
use fogbank_tests::scenes::{scene, view};
use serde_json::{Value, json};
use std::time::Instant;

/// Of so many frames the quickest counts: other programs only ever slow one down.
const TRIES: usize = 4;

fn main() {
    println!(
        "| scene | lamps | blobs | fogshop2007, full | auto, full | fogshop2007, draft | auto, draft |"
    );
    println!("|---|---|---|---|---|---|---|");
    for preset in presets::all().into_iter().filter(|p| !p.name.starts_with("street")) {
        row(preset.name, &json!(preset.scene));
    }
    let slowest = (0..SCENES).map(|n| (n, milliseconds(&everyday(n), "auto", Quality::Full, 1)));
    if let Some((number, _)) = slowest.max_by(|a, b| a.1.total_cmp(&b.1)) {
        row(&format!("everyday {number}"), &everyday(number));
    }
}

fn row(name: &str, json: &Value) {
    let length = |list: &Value| list.as_array().map_or(0, Vec::len);
    let terms = json["fog"]["terms"].as_array().into_iter().flatten();
    let (lamps, blobs) =
        (scene(json).lights().count(), terms.map(|t| length(&t["blobs"])).sum::<usize>());
    let cells = [Quality::Full, Quality::Draft].map(|quality| {
        let each = ["fogshop2007", "auto"].map(|how| milliseconds(json, how, quality, TRIES));
        each.map(|time| format!("{time:.0}")).join(" | ")
    });
    println!("| {name} | {lamps} | {blobs} | {} |", cells.join(" | "));
}

/// The quickest of some frames, whose camera moves a little.
fn milliseconds(json: &Value, airlight: &str, quality: Quality, tries: usize) -> f64 {
    let renderer = Renderer::default();
    let asked = View { samples: None, ..view(800, 600, Layer::Beauty, quality) };
    let view = asked.for_format(Format::Png);
    let mut json = json.clone();
    json["fog"]["airlight"] = airlight.into();
    let mut best = f64::INFINITY;
    let x = json["camera"]["position"][0].as_f64().unwrap_or_default();
    // The first frame fills what is kept.
    for step in 0..=tries {
        json["camera"]["position"][0] = json!(1e-3f64.mul_add(step as f64, x));
        let (scene, began) = (scene(&json), Instant::now());
        let frame = renderer.render(&scene, &view, &Progress::default());
        if step > 0 && frame.is_ok() {
            best = best.min(1e3 * began.elapsed().as_secs_f64());
        }
    }
    best
}
