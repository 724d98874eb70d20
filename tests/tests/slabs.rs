//! Blobs that view rays see as slabs: as much fog as before, and light in closed form.

#![allow(clippy::expect_used, reason = "a test stops where it fails")]

use fogbank_core::request::{Layer, ProbeRay, Quality};
use fogbank_tests::scenes::{pixel_rays, probe, render, scene, view};
use serde_json::{Value, json};

const SIZE: (u32, u32) = (48, 36);

/// Particles in front of a wall, among which the camera does not stand.
fn smoke(draw: &str, airlight: &str) -> Value {
    json!({
        "camera": { "position": [0, 1.5, 8], "target": [0, 1.2, 0] },
        "surfaces": [{ "shape": { "kind": "plane", "point": [0, 0, -6], "normal": [0, 0, 1] } }],
        "lights": [{ "kind": "point", "position": [0.8, 2.2, 0.5], "intensity": [20, 20, 20] }],
        "fog": { "airlight": airlight, "terms": [
            { "kind": "homogeneous", "extinction": 0.01 },
            { "kind": "emitter", "position": [0, 0, 0], "rate_hz": 20, "lifetime_s": 4, "radius": 0.4,
              "extinction": 0.5, "spread_deg": 20, "draw": draw },
            { "kind": "gaussians", "draw": draw, "blobs": [
                { "center": [-1.5, 1, -1], "radius": 1, "extinction": 0.4 } ] } ] },
        "time_s": 3.3, "far_m": 40 })
}

fn pixels(json: &Value, layer: Layer) -> Vec<f64> {
    let frame = render(&scene(json), &view(SIZE.0, SIZE.1, layer, Quality::Full));
    frame.pixels.iter().step_by(frame.channels).copied().map(f64::from).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Rays that end behind the slabs lose as much light as in the Gaussians; those that a wall cuts off among them
/// nearly so, and all together to 2 %.
#[test]
fn slabs_are_as_much_fog() {
    let [smooth, slabs] =
        ["gaussian", "slab"].map(|draw| pixels(&smoke(draw, "none"), Layer::OpticalDepth));
    assert!(
        (mean(&slabs) / mean(&smooth) - 1.0).abs() < 1e-4,
        "{} {}",
        mean(&slabs),
        mean(&smooth)
    );
    let cut = |draw: &str| {
        let mut json = smoke(draw, "none");
        json["surfaces"][0]["shape"]["point"] = json!([0, 0, 0.2]);
        pixels(&json, Layer::OpticalDepth)
    };
    let (smooth, slabs) = (cut("gaussian"), cut("slab"));
    assert!(
        (mean(&slabs) / mean(&smooth) - 1.0).abs() < 0.02,
        "{} {}",
        mean(&slabs),
        mean(&smooth)
    );
    assert!(smooth.iter().zip(&slabs).any(|(a, b)| (a - b).abs() > 0.01 * a), "no slab is drawn");
}

/// A probe sees the slabs that a picture shows, and light reaches them as it reaches Gaussians.
#[test]
fn pixels_and_probes_agree() {
    for (airlight, share) in [("macklin2010", 1e-3), ("auto", 0.02)] {
        let json = smoke("slab", airlight);
        let checked = scene(&json);
        let answers = probe(&checked, &pixel_rays(&checked, SIZE.0, SIZE.1));
        let (depth, light) = (pixels(&json, Layer::OpticalDepth), pixels(&json, Layer::Airlight));
        let most = answers.iter().map(|answer| answer.airlight.0[0]).fold(0.0, f64::max);
        let mut off = Vec::new();
        for ((answer, depth), light) in answers.iter().zip(depth).zip(light) {
            let wanted = answer.optical_depth.channels()[0];
            assert!((depth - wanted).abs() < 1e-4 * wanted + 2e-5, "{depth} {wanted}");
            let wanted = answer.airlight.0[0];
            off.push((light - wanted).abs() / wanted.max(0.01 * most));
        }
        off.sort_by(f64::total_cmp);
        // The grid sees the ends of slabs as edges, and a few rays graze them.
        assert!(off[off.len() * 95 / 100] < share, "{airlight}: {:?}", &off[off.len() - 5..]);
    }
}

/// The closed form of a slab is the integral of its extinction before a lamp: here of one alone, by steps.
#[test]
fn a_slabs_light_is_an_integral() {
    let json = json!({
        "lights": [{ "kind": "point", "position": [0.4, 0.9, 0.1], "intensity": [1, 1, 1] }],
        "fog": { "airlight": "macklin2010", "terms": [{ "kind": "gaussians", "draw": "slab", "blobs": [
            { "center": [0, 0.2, 0], "radius": 0.7, "extinction": 0.3 } ] }] }, "far_m": 20 });
    let checked = scene(&json);
    let ray = ProbeRay {
        origin: glam::DVec3::new(0.1, 0.0, 4.0),
        direction: glam::DVec3::new(0.02, 0.03, -1.0).normalize(),
        max_distance_m: None,
    };
    let light = glam::DVec3::new(0.4, 0.9, 0.1);
    let to = glam::DVec3::new(0.0, 0.2, 0.0) - ray.origin;
    let (at, miss) = (to.dot(ray.direction), to.cross(ray.direction).length() / 0.7);
    let half = 0.7 * 1.5f64.sqrt();
    let depth = 0.3 * 0.7 * std::f64::consts::PI.sqrt() * (-miss * miss).exp();
    const STEPS: usize = 4000;
    let sum: f64 = (0..STEPS)
        .map(|i| {
            let t = at + half * ((2 * i + 1) as f64 / STEPS as f64 - 1.0);
            depth / STEPS as f64 / (ray.origin + t * ray.direction - light).length_squared()
        })
        .sum();
    let wanted = sum / (4.0 * std::f64::consts::PI);
    let answer = &probe(&checked, &[ray])[0];
    assert!(
        (answer.airlight.0[0] / wanted - 1.0).abs() < 1e-6,
        "{} {wanted}",
        answer.airlight.0[0]
    );
    assert!((answer.optical_depth.channels()[0] / depth - 1.0).abs() < 1e-12);
}
