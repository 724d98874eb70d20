//! Optical depth of presets' blobs at 800×600 in one run: on the first Vulkan adapter, and on the CPU.
//!
//! `cargo bench -p fogbank-core --bench backends`

#![allow(missing_docs, clippy::print_stdout, clippy::unwrap_used, reason = "a benchmark")]

use criterion::Criterion;
use fogbank_core::gpu::{Gpu, Wanted};
use fogbank_core::request::{Layer, Options, Quality, Tonemap, View};
use fogbank_core::{Progress, Renderer, presets};
use std::time::Duration;

const PRESETS: [&str; 4] = ["steaming-vessel", "city-353", "vehicle-1223", "room-3008"];

fn main() {
    let mut criterion = Criterion::default()
        .configure_from_args()
        .without_plots()
        .warm_up_time(Duration::from_millis(100))
        .measurement_time(Duration::from_millis(800))
        .sample_size(10);
    let open = || Gpu::open(Wanted::Any);
    println!("on {}", open().unwrap().name());
    let backends = [("gpu", Renderer::on(open).unwrap()), ("cpu", Renderer::default())];
    let view = View {
        width: 800,
        height: 600,
        quality: Quality::Full,
        layer: Layer::OpticalDepth,
        samples: Some(1),
        exposure_ev: 0.0,
        tonemap: Tonemap::Agx,
        for_screen: false,
        is_hasty: false,
        estimator: None,
        options: Options::default(),
    };
    for name in PRESETS {
        let preset = presets::all().into_iter().find(|preset| preset.name == name).unwrap();
        let scene = preset.scene.check().unwrap();
        let mut group = criterion.benchmark_group(name);
        for (backend, renderer) in &backends {
            group.bench_function(*backend, |b| {
                b.iter(|| renderer.render(&scene, &view, &Progress::default()).unwrap());
            });
        }
        group.finish();
    }
}
