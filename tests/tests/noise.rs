//! Noise: blobs look irregular, alike from all sides, and by the same numbers in pictures and probes.

#![allow(clippy::expect_used, reason = "a test stops where it fails")]

use fogbank_core::request::{Layer, Quality};
use fogbank_tests::scenes::{pixel_rays, probe, render, scene, view};
use serde_json::{Value, json};

const SIZE: (u32, u32) = (64, 48);

fn steam(strength: f64) -> Value {
    json!({
        "camera": { "position": [0, 1, 7], "target": [0, 1, 0] },
        "surfaces": [{ "shape": { "kind": "plane" } }],
        "lights": [{ "kind": "point", "position": [1.5, 2.5, 1], "intensity": [20, 20, 20] }],
        "fog": { "noise": { "strength": strength, "scale_m": 4, "drift": [0.3, 0.1, 0] }, "terms": [
            { "kind": "homogeneous", "extinction": 0.02 },
            { "kind": "gaussians", "blobs": [
                { "center": [-1, 1, 0], "radius": 1, "extinction": 0.8 },
                { "center": [0.3, 1.4, -0.5], "radius": 0.7, "extinction": 1.2 } ] },
            { "kind": "emitter", "position": [1.2, 0, 0], "rate_hz": 4, "lifetime_s": 3, "radius": 0.3 } ] },
        "time_s": 2.5, "far_m": 40 })
}

fn pixels(json: &Value, layer: Layer) -> Vec<f32> {
    let frame = render(&scene(json), &view(SIZE.0, SIZE.1, layer, Quality::Full));
    frame.pixels.iter().step_by(frame.channels).copied().collect()
}

/// T and airlight of a picture are those of its pixels' rays, to what f32 and the picture's rules leave.
#[test]
fn pixels_and_probes_agree() {
    let json = steam(0.8);
    let checked = scene(&json);
    let answers = probe(&checked, &pixel_rays(&checked, SIZE.0, SIZE.1));
    let (depth, light) = (pixels(&json, Layer::OpticalDepth), pixels(&json, Layer::Airlight));
    let most = answers.iter().map(|answer| answer.airlight.0[0]).fold(0.0, f64::max);
    for ((answer, depth), light) in answers.iter().zip(depth).zip(light) {
        let wanted = answer.optical_depth.channels()[0];
        assert!((f64::from(depth) - wanted).abs() < 1e-4 * wanted + 2e-5, "{depth} {wanted}");
        let wanted = answer.airlight.0[0];
        assert!(
            (f64::from(light) - wanted).abs() < 3e-3 * wanted + 1e-3 * most,
            "{light} {wanted}"
        );
    }
}

/// A camera that turns in place sees the same fog along the same ray.
#[test]
fn turning_the_camera_changes_no_ray() {
    let json = steam(0.8);
    let checked = scene(&json);
    let rays = pixel_rays(&checked, SIZE.0, SIZE.1);
    let before = pixels(&json, Layer::OpticalDepth);
    for at in (0..rays.len()).step_by(97) {
        let mut turned = json.clone();
        turned["camera"]["target"] = json!((rays[at].origin + rays[at].direction).to_array());
        turned["camera"]["up"] = json!([0.3, 1, 0.1]);
        let frame = render(&scene(&turned), &view(1, 1, Layer::OpticalDepth, Quality::Full));
        // A direction rounds by 6e-8, which a blob 40 of its radii away turns into 1e-5.
        assert!((frame.pixels[0] - before[at]).abs() < 1e-4 * before[at] + 2e-5, "pixel {at}");
    }
}

/// It shifts fog and adds none: single rays see another T, all together nearly the same; without strength it is
/// nothing.
#[test]
fn noise_moves_fog_and_adds_none() {
    let (even, bent) =
        (pixels(&steam(0.0), Layer::OpticalDepth), pixels(&steam(0.8), Layer::OpticalDepth));
    let moved = even.iter().zip(&bent).filter(|(a, b)| (**a - **b).abs() > 0.05 * **a).count();
    assert!(moved > even.len() / 10, "{moved} of {}", even.len());
    let mean = |pixels: &[f32]| pixels.iter().sum::<f32>() / pixels.len() as f32;
    assert!((mean(&bent) / mean(&even) - 1.0).abs() < 0.05, "{} {}", mean(&bent), mean(&even));
    let mut without = steam(0.0);
    without["fog"]["noise"] = json!({});
    assert_eq!(even, pixels(&without, Layer::OpticalDepth));
}
