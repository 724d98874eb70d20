//! Skies and octaves of light on both backends.

use super::{BOTH, both, differing, gpu, shown_by_grid};
use crate::request::{Layer, Quality, View};
use crate::scene::{Airlight, CheckedScene, Light, Radiance, Scene};
use crate::selftest;
use crate::sky::{ImageSky, RadianceMap};

const BLOBS: &str = r#"[{"kind": "gaussians", "blobs": [
    {"center": [-1, 0.6, 0], "radius": 1.2, "extinction": 0.5},
    {"center": [1.5, 1, -2], "radius": 0.7, "extinction": 1.4}]}]"#;

/// The stage of the self-test under skies of every kind, the last one a picture.
fn skies(fog: &str) -> Vec<CheckedScene> {
    let kinds = [
        r#"{"kind": "uniform", "rgb": [0.5, 0.7, 0.9]}"#,
        r#"{"kind": "gradient", "zenith": [0.2, 0.4, 0.9], "horizon": [2, 1.8, 1.5], "ground": [0.2, 0.1, 0]}"#,
        r#"{"kind": "spherical_harmonics",
            "coefficients": [[2, 2, 2], [0.3, 0.5, 0.9], [0.4, 0.2, 0], [-0.6, 0, 0.1]]}"#,
    ];
    let mut scenes: Vec<_> =
        kinds.iter().map(|sky| selftest::under(sky, fog).expect("a scene")).collect();
    let pixel = |i: usize| [0.1 * (i % 8) as f32, 1.0, 0.3 * (i / 8) as f32];
    let map = RadianceMap::new(8, (0..32).map(pixel).collect()).expect("a picture");
    let mut image = ImageSky::default();
    image.show(map);
    let mut scene = Scene::clone(&scenes[0]);
    for light in &mut scene.lights {
        if let Light::Environment(environment) = light {
            environment.radiance = Radiance::ImageSky(image.clone());
        }
    }
    scenes.push(scene.check().expect("a valid scene"));
    scenes
}

/// Over fog that scatters evenly and forwards: what the fog scatters, what surfaces get, through the fog and as in
/// clear air, and what stands behind.
#[test]
fn skies_are_the_cpus() {
    let gpu = gpu();
    let forward = r#"{"light_path_m": 9, "surface_lighting": "clear",
        "terms": [{"kind": "homogeneous", "extinction": 0.2,
            "vertical": {"kind": "exponential", "falloff_per_m": 0.5}}],
        "phase": {"kind": "henyey_greenstein", "g": 0.6}}"#;
    // Its airlight stands in closed form, of which drafts of the CPU compute some pixels only.
    let even = r#"{"light_path_m": 9, "terms": [{"kind": "homogeneous", "extinction": 0.05}]}"#;
    let blobs = format!(r#"{{"light_path_m": 9, "terms": {BLOBS}}}"#);
    let fogs = [(blobs.as_str(), Quality::Draft), (forward, Quality::Draft), (even, Quality::Full)];
    for (fog, quality) in fogs {
        for (kind, scene) in skies(fog).iter().enumerate() {
            for (layer, share) in [(Layer::Surface, 1e-3), (Layer::Airlight, BOTH)] {
                let view = View { quality, ..shown_by_grid(layer, Airlight::Auto) };
                let frames = both(&gpu, scene, &view);
                assert_eq!((frames[0].backend, frames[1].backend), ("gpu", "cpu"));
                let off = differing(&frames, share);
                assert!(100 * off <= frames[1].pixels.len(), "{kind} {fog} {layer:?}: {off}");
                assert!(frames[0].pixels.iter().any(|value| *value > 0.01), "{kind} {layer:?}");
            }
        }
    }
}

/// In grey fog and in coloured; they are put together behind the device.
#[test]
fn octaves_are_the_cpus() {
    let gpu = gpu();
    for extinction in ["0.5", "[0.2, 0.5, 1]"] {
        let scene = |octaves: usize| {
            let text = format!(
                r#"{{"multiple_scattering": {{"octaves": {octaves}}}, "terms": [{{"kind": "gaussians",
                    "blobs": [{{"center": [-1, 0.6, 0], "radius": 1.2, "extinction": {extinction}}}]}}]}}"#
            );
            selftest::scene(&text).expect("a scene")
        };
        for layer in [Layer::Airlight, Layer::Beauty] {
            let view = shown_by_grid(layer, Airlight::Auto);
            let frames = both(&gpu, &scene(2), &view);
            assert_eq!((frames[0].backend, frames[1].backend), ("gpu", "cpu"));
            let off = differing(&frames, BOTH);
            assert!(50 * off <= frames[1].pixels.len(), "{extinction} {layer:?}: {off}");
            let [single, _] = both(&gpu, &scene(0), &view);
            let all = frames[0].pixels.iter().sum::<f32>();
            assert!(all > 1.05 * single.pixels.iter().sum::<f32>(), "{extinction} {layer:?}");
        }
    }
}
