//! Measures how far the estimators are from the truth, on fixed scenes: what
//! is said about them.

use crate::quadrature::integrate;
use crate::scenes::{Random, field, homogeneous, view};
use fogbank_core::airlight::about::{Exactness, MeasuredError};
use fogbank_core::airlight::reference;
use fogbank_core::compare::{self, CompareRequest, Side};
use fogbank_core::geometry::Ray;
use fogbank_core::light::{Light, Source, point::Place};
use fogbank_core::media::Field;
use fogbank_core::options::{Loss, Options};
use fogbank_core::phase::PhaseFunction;
use fogbank_core::presets::{self, Preset};
use fogbank_core::request::{Layer, Quality, View};
use fogbank_core::scene::{Airlight, Scene, read};
use fogbank_core::{Progress, Renderer};
use glam::DVec3;
use serde_json::{Value, json};

/// Random scenes beside the presets.
const ROUNDS: u64 = 24;

/// What an estimator states of itself, if it states numbers.
pub fn stated(airlight: Airlight) -> Option<[f64; 3]> {
    match airlight.about().error {
        Exactness::Words(_) => None,
        Exactness::Measured(MeasuredError { median, p95, max, .. }) => Some([median, p95, max]),
    }
}

/// Median, 95th percentile and largest relative error of an estimator.
pub fn measure(airlight: Airlight) -> [f64; 3] {
    let mut errors = match airlight {
        Airlight::Reference => of_the_reference(),
        _ => of_pictures(airlight),
    };
    quantiles(&mut errors)
}

/// The presets of the papers; those that are about light alone add nothing to what is said of fog.
fn about_fog() -> impl Iterator<Item = Preset> {
    const ABOUT_LIGHT: [&str; 5] =
        ["nave-shafts", "lighthouse", "terrain-sky", "city-sky", "vehicle-sky"];
    presets::all().into_iter().filter(|preset| !ABOUT_LIGHT.contains(&preset.name))
}

fn quantiles(errors: &mut [f64]) -> [f64; 3] {
    errors.sort_by(f64::total_cmp);
    let at = |q: f64| errors[(q * (errors.len() - 1) as f64).round() as usize];
    [at(0.5), at(0.95), at(1.0)]
}

/// By how much the transmittance of the presets' pixels is off with an option at a value: median, 95th percentile and
/// largest.
pub fn measure_loss(loss: &Loss, value: f64) -> [f64; 3] {
    let options = match loss.name {
        "fog_scale" => Options { fog_scale: value, ..Options::default() },
        "per_vertex" => Options { per_vertex: value == 1.0, ..Options::default() },
        name => panic!("{name} has no numbers"),
    };
    let renderer = Renderer::default();
    let mut errors = Vec::new();
    for preset in about_fog() {
        let scene = preset.scene.check().expect("a preset");
        let [all, lossy] = [Options::default(), options].map(|options| {
            let view = View { options, ..view(240, 180, Layer::Transmittance, Quality::Full) };
            renderer.render(&scene, &view, &Progress::default()).expect("not interrupted").pixels
        });
        errors.extend(all.iter().zip(lossy).map(|(a, b)| f64::from((a - b).abs())));
    }
    quantiles(&mut errors)
}

/// Every pixel of small pictures of the scenes that it takes, against the reference.
fn of_pictures(airlight: Airlight) -> Vec<f64> {
    let renderer = Renderer::default();
    let takes = |scene: &Scene| scene.fog.refusal(airlight).is_none();
    let errors = scenes().into_iter().filter(takes).flat_map(|scene| {
        let a = Side { airlight: airlight.into(), steps: None };
        let request = CompareRequest { scene, width: 16, height: 12, a, b: Side::reference() };
        let (scene, pair) = request.check().expect("a valid comparison");
        let compared = compare::run(&renderer, &scene, &pair, &Progress::default());
        compared.expect("not interrupted").errors.pixels
    });
    errors.map(f64::from).collect()
}

/// The presets, and random scenes: homogeneous fog, blobs, both, with every other phase function.
fn scenes() -> Vec<Scene> {
    let random = (0..ROUNDS).map(|round| {
        let mut random = Random(round);
        let phase = match round % 6 {
            3 => json!({ "kind": "henyey_greenstein", "g": 0.8 }),
            5 => json!({ "kind": "henyey_greenstein", "g": -0.4 }),
            _ => json!({ "kind": "isotropic" }),
        };
        let scene = json!({
            "camera": { "position": [0, 1, 11], "target": [0, 0, 0] },
            "surfaces": [{ "shape": { "kind": "plane", "point": [0, -3, 0] } }],
            "lights": random.lamps(2, 4.0),
            "fog": { "phase": phase, "terms": terms(&mut random, round) },
            "far_m": 60,
        });
        read(scene.to_string().as_bytes()).expect("a scene")
    });
    // A veil alone has no airlight to measure.
    let has_light = |scene: &Scene| scene.fog.airlight != Airlight::None;
    let presets = about_fog().map(|preset| preset.scene).filter(has_light);
    // Of the methods themselves: what shadows cost is measured on scenes of their own.
    presets.chain(random).map(unshaded).collect()
}

fn unshaded(mut scene: Scene) -> Scene {
    for light in &mut scene.lights {
        match light {
            Light::Point(light) => light.shadows = false,
            Light::Spot(light) => light.shadows = false,
            Light::Sun(light) => light.shadows = false,
            Light::Environment(_) => {}
        }
    }
    scene
}

fn terms(random: &mut Random, round: u64) -> Value {
    let even = homogeneous(random.decades(3e-3, 0.3));
    let few = [1.5, 3.0];
    match round % 3 {
        0 => json!([even]),
        1 => json!([even, random.blobs(12, 4.0, few, [0.01, 0.2])]),
        _ => json!([random.blobs(40, 4.0, [0.4, 1.5], [0.05, 1.0])]),
    }
}

/// Rays through fog of all kinds and phase functions, against a rule in the angle around the lamp.
fn of_the_reference() -> Vec<f64> {
    const RAYS: usize = 20;
    let mut errors = Vec::new();
    for round in 0..ROUNDS {
        let mut random = Random(round);
        let terms = terms(&mut random, round);
        let field = field(terms.as_array().expect("a list"));
        for g in [0.0, 0.5, -0.5, 0.99] {
            let phase = PhaseFunction { g };
            errors.extend((0..RAYS / 4).map(|_| {
                let [from, to, light] = [(); 3].map(|()| random.point(6.0));
                error_of_the_reference(&field, phase, light, from, to)
            }));
        }
    }
    errors
}

fn error_of_the_reference(
    field: &Field,
    phase: PhaseFunction,
    light: DVec3,
    from: DVec3,
    to: DVec3,
) -> f64 {
    let (length, direction) = (from.distance(to), (to - from).normalize());
    let (closest, miss) = ((light - from).dot(direction), (light - from).cross(direction).length());
    let glow = |angle: f64| {
        let x = from + (closest + miss * angle.tan()) * direction;
        let depth = field.depth_between(from, x) + field.depth_between(light, x);
        let cos = (x - light).normalize().dot(-direction);
        field.beta(x) * phase.value(cos) * (-depth).exp() / miss
    };
    let angle = |t: f64| ((t - closest) / miss).atan();
    let sum = integrate(angle(0.0), angle(length), &glow);
    let source = Source::Point(Place(light));
    let exact = reference::airlight(field, phase, source, Ray { origin: from, direction }, length);
    (exact / sum - 1.0).abs()
}
