//! Time and error of every airlight estimator, scene by scene, in one run: the published method,
//! `auto` at rest and in motion, and ray marching; 30 to 100 000 blobs, one lamp and four.
//!
//! `cargo bench -p fogbank-tests --bench airlight`; add `-- 'city|room'` to measure some scenes alone.
//!
//! A picture is 800×600 of the layer `airlight`, first hits and light tables known: what a moving
//! camera costs. Marching is timed along the rays that errors are measured on, and scaled to the picture. Errors are those of
//! the luminance, relative, against the integral itself along some of the picture's rays.

#![allow(missing_docs, clippy::print_stdout, clippy::unwrap_used, reason = "a benchmark")]

use criterion::{BenchmarkGroup, Criterion, measurement::WallTime};
use fogbank_core::airlight::march;
use fogbank_core::geometry::Ray;
use fogbank_core::media::Field;
use fogbank_core::request::{Layer, ProbeRay, Quality, View};
use fogbank_core::scene::{Airlight, CheckedScene};
use fogbank_core::{Progress, Renderer, presets};
use fogbank_tests::scenes::{Random, pixel_rays, probe, scene, view};
use fogbank_tests::trials::{Errors, luminance, quantiles};
use serde_json::{Value, json};
use std::time::{Duration, Instant};

const SIZE: (u32, u32) = (800, 600);
const STEPS: [u32; 3] = [16, 64, 256];
/// What takes longer is timed by the better of two runs.
const SLOW: Duration = Duration::from_secs(1);

fn main() {
    let mut criterion = Criterion::default()
        .configure_from_args()
        .without_plots()
        .warm_up_time(Duration::from_millis(100))
        .measurement_time(Duration::from_millis(800))
        .sample_size(10);
    let only = std::env::args().skip(1).find(|word| !word.starts_with('-'));
    let wanted = |name: &str| {
        only.as_ref().is_none_or(|only| only.split('|').any(|part| name.contains(part)))
    };
    println!(
        "scene, lamps, blobs: ms (median / p95 error in %) of fogshop2007, auto, auto in a draft, march {STEPS:?}"
    );
    for (name, json) in scenes() {
        if !wanted(&name) {
            continue;
        }
        let case = Case::new(&name, &json);
        let mut group = criterion.benchmark_group(&case.name);
        let times = case.measure(&mut group);
        group.finish();
        case.report(&times);
    }
}

/// A scene with exact values along some rays of its picture.
struct Case {
    name: String,
    scene: CheckedScene,
    blobs: usize,
    /// Which pixels.
    pixels: Vec<usize>,
    rays: Vec<ProbeRay>,
    /// Where they end [m].
    ends: Vec<f64>,
    truth: Vec<f64>,
}

impl Case {
    fn new(name: &str, json: &Value) -> Self {
        let mut exact = json.clone();
        exact["fog"]["airlight"] = "reference".into();
        let exact = scene(&exact);
        let blobs = Field::new(&exact.fog.terms, 0).lumps();
        let (width, height) = SIZE;
        let all = pixel_rays(&exact, width, height);
        let mut random = Random(5);
        let count = if blobs > 10_000 { 8 } else { 64 };
        let pixels: Vec<_> = (0..count).map(|_| random.bits() as usize % all.len()).collect();
        let rays: Vec<_> = pixels.iter().map(|at| all[*at]).collect();
        let answers = probe(&exact, &rays);
        let end = |hit: Option<f64>| hit.unwrap_or(exact.far_m);
        let ends = answers.iter().map(|ray| end(ray.hit.as_ref().map(|hit| hit.distance_m)));
        Self {
            name: name.into(),
            blobs,
            pixels,
            ends: ends.collect(),
            truth: answers.iter().map(|ray| luminance(ray.airlight.0)).collect(),
            rays,
            scene: scene(json),
        }
    }

    /// Milliseconds of each of [`PICTURES`].
    fn measure(&self, group: &mut BenchmarkGroup<'_, WallTime>) -> Vec<f64> {
        let measure = |(name, airlight, quality)| {
            let renderer = Renderer::default();
            let view = picture(airlight, quality);
            let render = || {
                let begun = Instant::now();
                renderer.render(&self.scene, &view, &Progress::default()).unwrap();
                begun.elapsed()
            };
            // The first one forms what is kept.
            render();
            let once = render();
            if once > SLOW {
                return once.min(render()).as_secs_f64() * 1e3;
            }
            group.bench_function(name, |b| b.iter(render));
            self.milliseconds(name)
        };
        PICTURES.map(measure).into()
    }

    fn report(&self, times: &[f64]) {
        let mut cells = Vec::new();
        for ((_, airlight, quality), time) in PICTURES.into_iter().zip(times) {
            let view = picture(airlight, quality);
            let frame = Renderer::default().render(&self.scene, &view, &Progress::default());
            let pixels = frame.unwrap().pixels;
            let rgb = |at: &usize| [0, 1, 2].map(|k| f64::from(pixels[3 * at + k]));
            let values: Vec<_> = self.pixels.iter().map(|at| luminance(rgb(at))).collect();
            cells.push((*time, self.errors(&values)));
        }
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let scale = f64::from(SIZE.0 * SIZE.1) / (self.rays.len() * threads) as f64;
        for steps in STEPS {
            let begun = Instant::now();
            let values = self.marched(steps);
            let time = begun.elapsed().as_secs_f64() * 1e3 * scale;
            cells.push((time, self.errors(&values)));
        }
        let words = cells.iter().map(|(time, [median, p95, _])| {
            format!("{time:.0} ({:.2} / {:.2})", 100.0 * median, 100.0 * p95)
        });
        let words = words.collect::<Vec<_>>().join(" | ");
        let lamps = self.scene.lights().count();
        let ratio = cells[1].0 / cells[0].0;
        println!(
            "| {} | {lamps} | {} | {words} | auto / fogshop2007 {ratio:.2} |",
            self.name, self.blobs
        );
    }

    /// Radiance along the rays by marching.
    fn marched(&self, steps: u32) -> Vec<f64> {
        let field = Field::new(&self.scene.fog.terms, 0);
        let phase = self.scene.fog.phase.function();
        let albedo = self.scene.fog.albedo.vector();
        let along = |(ray, end): (&ProbeRay, &f64)| {
            let lamps = self.scene.lights().map(|(_, lamp)| {
                let light = lamp.source();
                let ProbeRay { origin, direction, .. } = *ray;
                march::airlight(&field, phase, light, Ray { origin, direction }, *end, steps)
                    * lamp.strength()
                    * albedo
            });
            luminance(lamps.sum::<glam::DVec3>().to_array())
        };
        self.rays.iter().zip(&self.ends).map(along).collect()
    }

    fn errors(&self, values: &[f64]) -> Errors {
        let floor = 1e-3 * self.truth.iter().sum::<f64>() / self.truth.len() as f64;
        let error = |(a, b): (&f64, &f64)| (a - b).abs() / b.max(floor).max(f64::MIN_POSITIVE);
        quantiles(values.iter().zip(&self.truth).map(error).collect())
    }

    /// Median of a finished measurement.
    fn milliseconds(&self, name: &str) -> f64 {
        let root = std::env::var("CARGO_TARGET_DIR").unwrap_or("../target".into());
        let path = format!("{root}/criterion/{}/{name}/new/estimates.json", self.name);
        let json: Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
        json["median"]["point_estimate"].as_f64().unwrap() * 1e-6
    }
}

const PICTURES: [(&str, Airlight, Quality); 3] = [
    ("fogshop2007", Airlight::Fogshop2007, Quality::Full),
    ("auto", Airlight::Auto, Quality::Full),
    ("auto_draft", Airlight::Auto, Quality::Draft),
];

fn picture(airlight: Airlight, quality: Quality) -> View {
    let estimator = Some(airlight.into());
    View { estimator, for_screen: true, ..view(SIZE.0, SIZE.1, Layer::Airlight, quality) }
}

fn scenes() -> Vec<(String, Value)> {
    let preset = |preset: presets::Preset| {
        (preset.name.to_owned(), serde_json::to_value(preset.scene).unwrap())
    };
    let fogs = presets::all().into_iter().filter(|preset| !preset.name.starts_with("street"));
    let counts = [30, 300, 1_000, 3_000, 10_000, 30_000, 100_000];
    let clouds = counts.into_iter().flat_map(|count| {
        [1, 4].map(|lamps| (format!("cloud-{count}-{lamps}"), cloud(count, lamps)))
    });
    fogs.map(preset).chain(clouds).collect()
}

/// A bank of fog, of optical depth 2 or so however many blobs it is made of, lamps in and above it.
fn cloud(count: usize, lamps: usize) -> Value {
    let mut random = Random(count as u64);
    // Each blob overlaps with as many others.
    let radius = 3.0 / (count as f64).cbrt();
    let blobs = random.blobs(count, 4.0, [0.8 * radius, 1.25 * radius], [0.02, 0.08]);
    let place = [[2.0, 3.0, 1.0], [-3.0, 5.0, 2.0], [4.0, 1.0, -3.0], [-1.0, -2.0, 6.0]];
    let lamp = |at: &[f64; 3]| json!({ "kind": "point", "position": at, "intensity": [9, 8, 7] });
    json!({ "camera": { "position": [0, 1, 12], "target": [0, 0, 0] },
        "lights": place.iter().take(lamps).map(lamp).collect::<Vec<_>>(),
        "fog": { "terms": [{ "kind": "homogeneous", "extinction": 0.01 }, blobs] },
        "far_m": 40 })
}
