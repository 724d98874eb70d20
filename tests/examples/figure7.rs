//! Draws the picture of `docs/failures.jpg`, after Fig. 7 of Fogshop 2007: scenes on which the
//! published airlight fails, by that method, by `auto` and by `reference`.
//! `cargo run --release -p fogbank-tests --example figure7 -- docs/failures.jpg`

use fogbank_core::image::{Format, encode};
use fogbank_core::request::{Layer, Quality, View};
use fogbank_core::scene::Airlight;
use fogbank_tests::scenes::{render, scene, view};
use image::RgbImage;
use serde_json::{Value, json};
use std::f64::consts::TAU;

const WIDTH: u32 = 240;
const HEIGHT: u32 = 180;

fn main() {
    let out = std::env::args().nth(1).unwrap_or_else(|| "failures.jpg".into());
    let methods = [Airlight::Fogshop2007, Airlight::Auto, Airlight::Reference];
    let mut sheet = RgbImage::new(3 * WIDTH, 2 * HEIGHT);
    for (row, (json, exposure_ev)) in
        [(row_of_blobs(), 2.5), (pierced_tube(), 5.0)].iter().enumerate()
    {
        for (column, airlight) in methods.into_iter().enumerate() {
            let picture = picture(json, airlight, *exposure_ev);
            let (x, y) = (column as u32 * WIDTH, row as u32 * HEIGHT);
            image::imageops::replace(&mut sheet, &picture, x.into(), y.into());
        }
    }
    sheet.save(out).expect("a writable picture");
}

fn picture(json: &Value, airlight: Airlight, exposure_ev: f64) -> RgbImage {
    let estimator = Some(airlight.into());
    let view = view(WIDTH, HEIGHT, Layer::Beauty, Quality::Full);
    let view = View { estimator, for_screen: true, exposure_ev, ..view };
    let png = encode(&render(&scene(json), &view), &view, Format::Png).expect("a picture");
    image::load_from_memory(&png).expect("a picture").to_rgb8()
}

/// A lamp so close to a row of blobs that its light changes faster along a ray than the fog does.
fn row_of_blobs() -> Value {
    let blob = |x: f64| json!({ "center": [x, 0, 0], "radius": 0.5, "extinction": 0.5 });
    fog(json!([0.05, 0.15, 0.1]), [0.0, 0.3, 5.0], 0.02, [-1.5, -0.5, 0.5, 1.5].map(blob).to_vec())
}

/// A lamp in a dense tube with a hole, through which a shaft of light leaves.
fn pierced_tube() -> Value {
    let ring = (0..14).flat_map(|i| (-5..=5).map(move |j| (i, j)));
    let wall = ring.filter(|place| *place != (0, 0)).map(|(i, j)| {
        let (sin, cos) = (TAU * f64::from(i) / 14.0).sin_cos();
        let center = [1.2 * cos, 0.4 * f64::from(j), 1.2 * sin];
        json!({ "center": center, "radius": 0.385, "extinction": 3 })
    });
    fog(json!([0, 0, 0]), [1.0, 0.5, 9.0], 0.05, wall.collect())
}

fn fog(lamp: Value, eye: [f64; 3], extinction: f64, blobs: Vec<Value>) -> Value {
    json!({
        "camera": { "position": eye, "target": [eye[0], 0, 0] },
        "lights": [{ "kind": "point", "position": lamp, "intensity": [1, 1, 1] }],
        "fog": { "terms": [{ "kind": "homogeneous", "extinction": extinction },
                           { "kind": "gaussians", "blobs": blobs }] },
        "far_m": 2.0 * eye[2],
    })
}
