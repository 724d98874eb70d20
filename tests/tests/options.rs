//! What a picture may lose for speed, and that it loses no more.

#![allow(clippy::expect_used, reason = "a test stops where it fails")]

use fogbank_core::Frame;
use fogbank_core::request::{Layer, Options, Quality, View};
use fogbank_tests::scenes::{Random, render, scene, view};
use serde_json::{Value, json};

/// Blobs over a plain that reaches far away.
fn plain() -> Value {
    let mut random = Random(5);
    let mut blob = || {
        json!({ "center": [random.between(-300.0, 300.0), random.between(0.0, 6.0), random.between(-900.0, 0.0)],
            "radius": random.decades(1.0, 6.0), "extinction": random.decades(0.01, 0.1) })
    };
    let blobs: Vec<_> = (0..4000).map(|_| blob()).collect();
    json!({
        "camera": { "position": [0, 9, 60], "target": [0, 2, -200] },
        "surfaces": [{ "shape": { "kind": "plane" } }],
        "lights": [{ "kind": "point", "position": [0, 20, -100], "intensity": [5e4, 5e4, 5e4] }],
        "fog": { "terms": [{ "kind": "gaussians", "blobs": blobs }] },
        "far_m": 2000 })
}

fn picture(json: &Value, layer: Layer, options: Options) -> Frame {
    render(&scene(json), &View { options, ..view(160, 120, layer, Quality::Full) })
}

fn mean(frame: &Frame) -> f64 {
    frame.pixels.iter().copied().map(f64::from).sum::<f64>() / frame.pixels.len() as f64
}

/// The mean optical depth stays within what was allowed, less is drawn, and the same at every time.
#[test]
fn pruning_keeps_the_mean_optical_depth() {
    let json = plain();
    let all = picture(&json, Layer::OpticalDepth, Options::default());
    let mut before = 0.0;
    for lod_error in [0.01, 0.05, 0.2] {
        let options = Options { lod_error, ..Options::default() };
        let pruned = picture(&json, Layer::OpticalDepth, options);
        let off = (mean(&pruned) / mean(&all) - 1.0).abs();
        assert!(off <= lod_error, "{lod_error}: {off}");
        let differing =
            pruned.pixels.iter().zip(&all.pixels).map(|(a, b)| f64::from((a - b).abs()));
        let differing = differing.sum::<f64>();
        assert!(differing > before, "{lod_error} leaves out no more: {differing}");
        before = differing;
        assert_eq!(pruned.pixels, picture(&json, Layer::OpticalDepth, options).pixels);
    }
}

/// A step of the camera makes nothing pop: no pixel of a pruned picture changes by much more than one of the whole.
#[test]
fn nothing_pops_while_the_camera_moves() {
    let json = plain();
    let mut moved = json.clone();
    moved["camera"]["position"] = json!([0, 9, 59.95]);
    moved["camera"]["target"] = json!([0, 2, -200.05]);
    let most = |lod_error: f64| {
        let options = Options { lod_error, ..Options::default() };
        let [a, b] = [&json, &moved].map(|json| picture(json, Layer::Transmittance, options));
        a.pixels.iter().zip(&b.pixels).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
    };
    let (whole, pruned) = (most(0.0), most(0.1));
    assert!(pruned < 3.0 * whole + 0.02, "{pruned}, of all blobs {whole}");
}

/// What lies behind the cut is not seen, and no pixel loses more than that share of what there is.
#[test]
fn a_cut_hides_what_little_is_seen() {
    let json = json!({
        "camera": { "position": [0, 2, 0], "target": [0, 1.5, -10] },
        "surfaces": [{ "shape": { "kind": "plane" }, "material": { "emission": [1, 1, 1] } }],
        "fog": { "ambient": [0.2, 0.2, 0.2], "terms": [{ "kind": "homogeneous", "extinction": 0.1 }] },
        "far_m": 200 });
    let far_cut = 0.05;
    let cut = Options { far_cut, ..Options::default() };
    let [all, cut] =
        [Options::default(), cut].map(|options| picture(&json, Layer::Beauty, options));
    let lost = |(a, b): (&f32, &f32)| f64::from(a - b);
    let lost: Vec<_> = all.pixels.iter().zip(&cut.pixels).map(lost).collect();
    assert!(lost.iter().all(|lost| (-1e-6..far_cut * 1.0 + 1e-6).contains(lost)));
    assert!(lost.iter().any(|lost| *lost > 0.5 * far_cut), "nothing is cut");
}

/// Fog on a coarser grid is the same but for what changes between its pixels, and edges of depth keep theirs.
#[test]
fn a_coarse_grid_of_fog_shows_nearly_the_same() {
    let json = json!({
        "camera": { "position": [0, 1.7, 8], "target": [0, 1, 0] },
        "surfaces": [{ "shape": { "kind": "plane" } },
            { "shape": { "kind": "sphere", "center": [1.2, 0.8, 0], "radius": 0.8 } },
            { "shape": { "kind": "box", "min": [-3, 0, -3], "max": [-2, 2, -2] } }],
        "lights": [{ "kind": "point", "position": [-0.5, 2.2, 1], "intensity": [40, 34, 24] }],
        "fog": { "airlight": "none", "ambient": [0.5, 0.5, 0.5], "terms": [
            { "kind": "functions", "scale": 0.1, "members": [
                { "kind": "cosine", "amplitude": 1, "wave_vector": [0, 0, 0] },
                { "kind": "cosine", "amplitude": 0.9, "wave_vector": [0.8, 1.5, 0.6] } ] }] },
        "far_m": 60 });
    let all = picture(&json, Layer::Transmittance, Options::default());
    let mut before = 0.0;
    for fog_scale in [0.5, 0.25] {
        let options = Options { fog_scale, ..Options::default() };
        let coarse = picture(&json, Layer::Transmittance, options);
        let off = |(a, b): (&f32, &f32)| f64::from((a - b).abs());
        let off: Vec<_> = all.pixels.iter().zip(&coarse.pixels).map(off).collect();
        let mean = off.iter().sum::<f64>() / off.len() as f64;
        // A tenth of the waves is between neighbours of the coarser one.
        assert!(mean > before && mean < 0.004, "{fog_scale}: {mean}");
        assert!(off.iter().all(|off| *off < 0.06), "{fog_scale}");
        before = mean;
    }
}

/// Hills of a dense mesh in a fog of layers, with a wall of two large triangles.
fn hills() -> Value {
    let heights: Vec<Vec<f64>> = (0..80)
        .map(|j| {
            (0..80).map(|i| (0.21 * f64::from(i)).sin() + (0.17 * f64::from(j)).cos()).collect()
        })
        .collect();
    json!({
        "camera": { "position": [0, 4, 22], "target": [0, 1, 0] },
        "surfaces": [
            { "shape": { "kind": "heightfield", "origin": [-20, 0, -20], "size": [40, 40], "heights": heights } },
            { "shape": { "kind": "mesh", "positions": [[-30, -5, -25], [30, -5, -25], [30, 20, -25], [-30, 20, -25]],
                "indices": [[0, 1, 2], [0, 2, 3]] } },
            { "shape": { "kind": "sphere", "center": [3, 3, 5], "radius": 1.5 } } ],
        "fog": { "airlight": "none", "ambient": [0.5, 0.5, 0.5], "terms": [
            { "kind": "homogeneous", "extinction": 0.08,
              "vertical": { "kind": "exponential", "base_m": 0.5, "falloff_per_m": 0.6 } } ] },
        "far_m": 90 })
}

/// Between the corners of a dense mesh what fog lets through is nearly straight; all else, a mesh that is not dense
/// among it, has its own.
#[test]
fn fog_at_corners_shows_nearly_the_same() {
    let json = hills();
    let of = |per_vertex: bool, layer: Layer| {
        picture(&json, layer, Options { per_vertex, ..Options::default() }).pixels
    };
    let (all, corners) = (of(false, Layer::Transmittance), of(true, Layer::Transmittance));
    let off = |(a, b): (&f32, &f32)| (a - b).abs();
    let off: Vec<_> = all.iter().zip(&corners).map(off).collect();
    // A triangle's own error is a part of what its corners may differ by, 0.06.
    assert!(off.iter().all(|off| *off < 0.01), "{:?}", off.iter().fold(0.0f32, |a, b| a.max(*b)));
    let changed = off.iter().filter(|off| **off > 1e-6).count();
    assert!(changed > off.len() / 10, "{changed} of {} are interpolated", off.len());
    let depth = of(false, Layer::Depth);
    let is_sphere = |i: usize| (i % 160) as f32 > 80.0 && depth[i] < 18.0 && (i / 160) < 60;
    let same = (0..off.len()).filter(|i| is_sphere(*i)).all(|i| all[i] == corners[i]);
    assert!(same, "a sphere has no corners");
}

/// Seen side by side, too.
#[test]
fn fog_at_corners_suits_parallel_rays() {
    let mut json = hills();
    json["camera"]["projection"] = json!({ "kind": "orthographic", "height_m": 20 });
    let of = |per_vertex: bool| {
        picture(&json, Layer::Transmittance, Options { per_vertex, ..Options::default() }).pixels
    };
    let (all, corners) = (of(false), of(true));
    assert!(all != corners);
    assert!(all.iter().zip(&corners).all(|(a, b)| (a - b).abs() < 0.01));
}

/// A picture that ends where all is hidden lends its optical depths to none that states them.
#[test]
fn what_states_optical_depth_follows_it_to_its_end() {
    let rows: Vec<Vec<f64>> = vec![vec![1.0; 64]; 64];
    let scene = scene(&json!({
        "camera": { "position": [0, 1, 31], "target": [0, 1, 0] },
        "fog": { "airlight": "none", "ambient": [1, 1, 1], "terms": [{ "kind": "fogmap", "degree": 0,
            "origin": [-32, -32], "cell_m": 1, "scale": 2, "coefficients": rows }] },
        "far_m": 100 }));
    let renderer = fogbank_core::Renderer::default();
    let shown = |layer| {
        let frame =
            renderer.render(&scene, &view(64, 48, layer, Quality::Full), &Default::default());
        frame.expect("not interrupted").pixels
    };
    let _ = shown(Layer::Beauty);
    let depths = shown(Layer::OpticalDepth);
    // 63 m of 2 per metre before the camera, and no less than to the map's side.
    assert!(
        depths.iter().all(|depth| *depth > 100.0),
        "{:?}",
        depths.iter().fold(f32::MAX, |a, b| a.min(*b))
    );
}
