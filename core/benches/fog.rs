//! Kernels against the machine's own peak, threads against one, and frames of which only a lamp's colour has changed.
//! All in one run: machines are shared and noisy, so only ratios mean much.
//!
//! `cargo bench -p fogbank-core --bench fog`

#![allow(missing_docs, clippy::print_stdout, clippy::unwrap_used, reason = "a benchmark")]

use criterion::{Criterion, Throughput};
use fearless_simd::{Level, Simd, SimdBase, dispatch};
use fogbank_core::airlight::fogshop2007::{LightRow, Reach, add_airlight};
use fogbank_core::geometry::batch::{Fogged, Rays, SIZE};
use fogbank_core::light::{Source, ToLight, point::Place};
use fogbank_core::media::gaussians::{BlobList, Packed, add_depth};
use fogbank_core::num::{Lanes, Num};
use fogbank_core::presets;
use fogbank_core::request::{Layer, Options, Quality, Tonemap, View};
use fogbank_core::scene::{Light, Scene};
use fogbank_core::vector::V3;
use fogbank_core::{Progress, Renderer};
use std::hint::black_box;
use std::time::Duration;

/// Flops that the comparison counts for one optical-depth pair, whatever the kernel saves.
const FLOP_A_DEPTH_PAIR: f64 = 62.0;
/// The same for one airlight pair with one light: the depth pair, a second line integral (erf
/// twice, exp once), one more exp, and the geometry of the light's path.
const FLOP_AN_AIRLIGHT_PAIR: f64 = 62.0 + 88.0;

/// Nothing hides the light.
struct Everywhere;

impl Reach for Everywhere {
    fn look<S: Simd>(
        &mut self,
        _simd: S,
        _start: V3<Lanes<S>>,
        _direction: V3<Lanes<S>>,
        _light: &ToLight<Lanes<S>>,
        _length: Lanes<S>,
    ) {
    }

    fn at<S: Simd>(&self, _simd: S, _light: &ToLight<Lanes<S>>, t: Lanes<S>) -> Lanes<S> {
        t.lit(1.0)
    }
}

const BLOBS: usize = 256;
/// Independent sums that keep every FMA unit busy.
const CHAINS: usize = 10;
const STEPS: usize = 4096;

fn main() {
    let mut criterion = Criterion::default()
        .configure_from_args()
        .without_plots()
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_millis(1500))
        .sample_size(20);
    kernels(&mut criterion);
    frames(&mut criterion);
    criterion.final_summary();
    report();
}

/// FMAs on registers alone.
#[inline(always)]
fn fma_chains<S: Simd>(simd: S, seed: f32) -> f32 {
    let factor = Lanes::splat(simd, 0.999_9);
    let mut sums = [Lanes::splat(simd, seed); CHAINS];
    for _ in 0..STEPS {
        for sum in &mut sums {
            *sum = sum.mul_add(factor, factor);
        }
    }
    sums.iter().map(|sum| sum.0.as_slice()[0]).sum()
}

/// Rays into a room of fog, and blobs that they cross.
fn scene(whole: bool) -> (Rays, [f32; SIZE], BlobList) {
    let mut rays = Rays::empty();
    rays.count = SIZE;
    let mut length = [0.0; SIZE];
    for (at, length) in length.iter_mut().enumerate() {
        let (x, y) = ((at % 16) as f32 / 16.0 - 0.5, (at / 16) as f32 / 16.0 - 0.5);
        let norm = (x * x + y * y + 1.0).sqrt();
        [rays.direction[0][at], rays.direction[1][at], rays.direction[2][at]] =
            [x / norm, y / norm, 1.0 / norm];
        *length = if whole { 100.0 } else { 8.0 + 0.01 * at as f32 };
    }
    let blob = |i: usize| {
        let turn = i as f32 * 2.4;
        let (radius, depth) = (0.5 + 0.001 * i as f32, 4.0 + 6.0 * (i as f32 / BLOBS as f32));
        let center = [0.8 * turn.cos(), 0.8 * turn.sin(), depth];
        let a = 1.0 / radius;
        Packed { b: center.map(|c| c * a), a, k: 0.02, place: i as u32, is_slab: false }
    };
    let blobs: Vec<_> = (0..BLOBS).map(blob).collect();
    let list = if whole {
        BlobList { whole: blobs, ..BlobList::default() }
    } else {
        BlobList { cut: blobs, ..BlobList::default() }
    };
    (rays, length, list)
}

fn kernels(criterion: &mut Criterion) {
    let level = Level::new();
    let mut group = criterion.benchmark_group("kernel");
    let lanes = dispatch!(level, simd => lanes(simd)) as u64;
    group.throughput(Throughput::Elements(lanes * (CHAINS * STEPS) as u64));
    group.bench_function("fma_peak", |b| {
        b.iter(|| dispatch!(level, simd => fma_chains(simd, black_box(0.5))));
    });
    group.throughput(Throughput::Elements((SIZE * BLOBS) as u64));
    for (name, whole) in [("depth_cut", false), ("depth_whole", true)] {
        let (rays, length, list) = scene(whole);
        group.bench_function(name, |b| b.iter(|| depth(level, &list, &rays, &length)));
    }
    let (rays, length, BlobList { cut, .. }) = scene(false);
    let list = BlobList { dense: cut, ..BlobList::default() };
    group.bench_function("depth_dense", |b| b.iter(|| depth(level, &list, &rays, &length)));
    let (rays, length, list) = scene(false);
    let lit: Vec<_> = list.cut.iter().map(lit).collect();
    group.bench_function("airlight", |b| {
        b.iter(|| {
            let mut fogged = Fogged::clear(1);
            let light = LightRow::<Everywhere> {
                distance: 5.0,
                blobs: &lit,
                source: Source::Point(Place(glam::DVec3::new(0.0, 3.0, 6.0))),
                reach: None,
                exponents: &[],
            };
            dispatch!(level, simd => add_airlight::<_, _, false>(
                simd, &list, &mut [light], &rays, &length, &mut fogged
            ));
            fogged.airlight[0][7]
        });
    });
    threads(&mut group, level);
    group.finish();
}

#[inline(always)]
fn lanes<S: Simd>(_: S) -> usize {
    Lanes::<S>::COUNT
}

fn depth(level: Level, list: &BlobList, rays: &Rays, length: &[f32; SIZE]) -> f32 {
    let mut depth = [0.0; SIZE];
    dispatch!(level, simd => add_depth::<_, false>(simd, list, rays, length, &mut depth));
    depth[7]
}

/// A light 3 m above the first blob.
fn lit(blob: &Packed) -> [f32; 4] {
    [blob.b[0], blob.b[1] - 3.0 * blob.a, blob.b[2] - 6.0 * blob.a, -0.5]
}

/// The depth kernel over many tiles on one thread and on two.
fn threads(
    group: &mut criterion::BenchmarkGroup<'_, criterion::measurement::WallTime>,
    level: Level,
) {
    use rayon::prelude::*;
    const TILES: usize = 64;
    let (rays, length, list) = scene(false);
    group.throughput(Throughput::Elements((TILES * SIZE * BLOBS) as u64));
    for count in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build().unwrap();
        group.bench_function(format!("depth_threads_{count}"), |b| {
            let tile = |_| depth(level, &list, &rays, &length);
            b.iter(|| pool.install(|| (0..TILES).into_par_iter().map(tile).sum::<f32>()));
        });
    }
}

fn view(quality: Quality) -> View {
    View {
        width: 800,
        height: 600,
        quality,
        layer: Layer::Beauty,
        samples: Some(if quality == Quality::Full { 4 } else { 1 }),
        exposure_ev: 0.0,
        tonemap: Tonemap::Agx,
        for_screen: true,
        is_hasty: false,
        estimator: None,
        options: Options::default(),
    }
}

/// Frames of a camera at rest while a lamp's colour changes.
fn frames(criterion: &mut Criterion) {
    let renderer = Renderer::default();
    let mut group = criterion.benchmark_group("frame");
    for preset in presets::all() {
        let scene = preset.scene.check().unwrap();
        for (name, quality) in [("draft", Quality::Draft), ("full", Quality::Full)] {
            let view = view(quality);
            let mut brighter = 0.0;
            let mut recoloured = || {
                brighter += 1e-3;
                let mut scene = Scene::clone(&scene);
                if let Some(Light::Point(lamp)) = scene.lights.first_mut() {
                    lamp.intensity.0[0] += brighter;
                }
                let scene = scene.check().unwrap();
                renderer.render(&scene, &view, &Progress::default()).unwrap()
            };
            group.bench_function(format!("{}_{name}_colour", preset.name), |b| {
                b.iter(&mut recoloured);
            });
        }
    }
    group.finish();
}

/// Median seconds of a finished benchmark, if this run or an earlier one measured it.
fn seconds(group: &str, name: &str) -> Option<f64> {
    let root = std::env::var("CARGO_TARGET_DIR").unwrap_or("../target".into());
    let path = format!("{root}/criterion/{group}/{name}/new/estimates.json");
    let json: serde_json::Value = serde_json::from_slice(&std::fs::read(path).ok()?).ok()?;
    Some(json["median"]["point_estimate"].as_f64()? * 1e-9)
}

fn report() {
    let level = Level::new();
    let lanes = dispatch!(level, simd => lanes(simd)) as f64;
    let Some(peak) = seconds("kernel", "fma_peak") else { return };
    let peak = 2.0 * lanes * (CHAINS * STEPS) as f64 / peak;
    println!(
        "\nSIMD: {level:?}, {lanes} lanes; f32 FMA peak of one thread: {:.1} GFlop/s",
        peak / 1e9
    );
    println!("{:<24}{:>14}{:>22}", "kernel", "G pairs/s", "share of FMA peak");
    let pairs = (SIZE * BLOBS) as f64;
    for (name, flop) in [
        ("depth_cut", FLOP_A_DEPTH_PAIR),
        ("depth_dense", FLOP_A_DEPTH_PAIR),
        ("depth_whole", FLOP_A_DEPTH_PAIR),
        ("airlight", FLOP_AN_AIRLIGHT_PAIR),
    ] {
        let Some(time) = seconds("kernel", name) else { continue };
        let rate = pairs / time;
        println!("{name:<24}{:>14.3}{:>22.2}", rate / 1e9, rate * flop / peak);
    }
    if let (Some(one), Some(two)) =
        (seconds("kernel", "depth_threads_1"), seconds("kernel", "depth_threads_2"))
    {
        println!("speed-up from 1 to 2 threads: {:.2}", one / two);
    }
}
