//! Times of pictures whose camera moves.

use fogbank_core::image::{Format, encode};
use fogbank_core::request::{Layer, Quality, View};
use fogbank_core::{Progress, Renderer};
use fogbank_tests::scenes::{scene, view};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// Pictures of one measurement, at least and at most; between them as many as [`LONG`] allows.
const PICTURES: [usize; 2] = [3, 15];
const LONG: Duration = Duration::from_secs(3);

/// What a picture takes, in milliseconds.
pub struct Times {
    /// All of it.
    pub whole: f64,
    /// Pass by pass.
    pub passes: BTreeMap<&'static str, f64>,
}

/// Medians over pictures of a scene.
pub fn measure(json: &Value, [width, height]: [u32; 2], quality: Quality) -> Times {
    let format = if quality == Quality::Draft { Format::Jpeg } else { Format::Png };
    let asked = View { samples: None, ..view(width, height, Layer::Beauty, quality) };
    let view = asked.for_format(format);
    let renderer = Renderer::default();
    let mut json = json.clone();
    let x = json["camera"]["position"][0].as_f64().unwrap();
    let (mut whole, mut passes) = (Vec::new(), BTreeMap::<_, Vec<f64>>::new());
    let began = Instant::now();
    // The first picture fills what is kept.
    for step in 0..=PICTURES[1] {
        json["camera"]["position"][0] = json!(1e-3f64.mul_add(step as f64, x));
        let scene = scene(&json);
        let since = Instant::now();
        let frame = renderer.render(&scene, &view, &Progress::default()).unwrap();
        let rendered = Instant::now();
        encode(&frame, &view, format).unwrap();
        if step == 0 {
            continue;
        }
        whole.push(since.elapsed().as_secs_f64() * 1e3);
        for lap in &frame.timings {
            passes.entry(lap.pass).or_default().push(lap.took.as_secs_f64() * 1e3);
        }
        passes.entry("encode").or_default().push(rendered.elapsed().as_secs_f64() * 1e3);
        if step >= PICTURES[0] && began.elapsed() > LONG {
            break;
        }
    }
    let passes = passes.into_iter().map(|(pass, times)| (pass, median(times))).collect();
    Times { whole: median(whole), passes }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
