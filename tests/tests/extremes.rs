//! Whatever the documented ranges allow is answered by numbers: none of them infinite, no fog that
//! gives light or takes less than none of it.

use fogbank_core::airlight::Method;
use fogbank_core::probe::RayAnswer;
use fogbank_core::request::{Layer, ProbeRequest, Quality, View};
use fogbank_core::scene::{CheckedScene, Rgb, Scene, read};
use fogbank_core::{Progress, Renderer};
use fogbank_tests::extremes;
use fogbank_tests::scenes::*;
use serde_json::{Value, json};

/// Extreme scenes; those that the check refuses (`sun2005` in blobs) do not count.
const SCENES: usize = 400;

fn for_scenes(count: usize, mut test: impl FnMut(&str, &Value, CheckedScene, &[Value])) {
    let mut accepted = 0;
    for seed in 0.. {
        let (json, rays) = extremes::scene(&mut Random(seed));
        let scene: Scene = read(json.to_string().as_bytes()).expect("a scene");
        let Ok(scene) = scene.check() else { continue };
        test(&format!("seed {seed}"), &json, scene, &rays);
        accepted += 1;
        if accepted == count {
            return;
        }
        assert!(seed < 4 * count as u64, "only {accepted} scenes are valid");
    }
}

fn is_light(Rgb(rgb): Rgb) -> bool {
    rgb.into_iter().all(|v| v.is_finite() && v >= 0.0)
}

/// What is wrong with an answer.
fn fault(answer: &RayAnswer) -> Option<&'static str> {
    let hit = answer.hit.as_ref();
    let lengths = |values: [f64; 3]| values.into_iter().all(f64::is_finite);
    let through = answer.transmittance.channels()[0];
    let checks = [
        (
            "optical depth",
            answer.optical_depth.channels()[0].is_finite()
                && answer.optical_depth.channels()[0] >= 0.0,
        ),
        ("transmittance", (0.0..=1.0).contains(&through)),
        ("airlight", is_light(answer.airlight)),
        ("airlight by light", answer.airlight_by_light.iter().all(|v| is_light(*v))),
        ("ambient", is_light(answer.ambient)),
        ("radiance", is_light(answer.radiance)),
        ("surface radiance", hit.is_none_or(|hit| is_light(hit.surface_radiance))),
        ("distance", hit.is_none_or(|hit| hit.distance_m.is_finite() && hit.distance_m >= 0.0)),
        ("hit", hit.is_none_or(|hit| lengths(hit.point.0) && lengths(hit.normal.0))),
    ];
    checks.into_iter().find(|(_, holds)| !holds).map(|(name, _)| name)
}

/// Every number of a probe.
#[test]
fn probes_answer_numbers() {
    let renderer = Renderer::default();
    let mut faults = Vec::new();
    for_scenes(SCENES, |seed, json, _, rays| {
        let body = json!({ "scene": json, "rays": rays }).to_string();
        let request: ProbeRequest = read(body.as_bytes()).expect("a probe");
        let (scene, checked) = request.check().expect("valid rays");
        let answers = renderer.probe(&scene, &checked, &Progress::default()).expect("answers");
        for (i, answer) in answers.iter().enumerate() {
            if let Some(what) = fault(answer) {
                let method = &json["fog"]["airlight"];
                faults.push(format!("{seed}, ray {i}, {method}: {what} of {answer:?}"));
            }
        }
    });
    assert!(
        faults.is_empty(),
        "{} faults:\n{}",
        faults.len(),
        faults[..faults.len().min(20)].join("\n")
    );
}

/// Every number of every layer of a picture in floats, in both qualities, and by ray marching.
#[test]
fn pictures_hold_numbers() {
    let renderer = Renderer::default();
    let mut faults = Vec::new();
    for_scenes(SCENES, |seed, json, scene, _| {
        for layer in Layer::ALL {
            for quality in [Quality::Full, Quality::Draft] {
                let own = View { samples: Some(4), ..view(7, 5, layer, quality) };
                let marched = View { estimator: Some(Method::March(3)), ..own };
                let shows_airlight = matches!(layer, Layer::Beauty | Layer::Airlight);
                for view in [own, marched].into_iter().take(1 + usize::from(shows_airlight)) {
                    let frame = renderer.render(&scene, &view, &Progress::default());
                    let frame = frame.expect("not interrupted");
                    let least = if layer == Layer::Normal { -1.001 } else { 0.0 };
                    let is_good = |v: &f32| v.is_finite() && *v >= least;
                    if let Some(bad) = frame.pixels.iter().find(|v| !is_good(v)) {
                        let method = &json["fog"]["airlight"];
                        let how = view.estimator;
                        faults.push(format!(
                            "{seed}, {layer:?}, {quality:?}, {method} {how:?}: {bad}"
                        ));
                    }
                }
            }
        }
    });
    assert!(
        faults.is_empty(),
        "{} faults:\n{}",
        faults.len(),
        faults[..faults.len().min(60)].join("\n")
    );
}
