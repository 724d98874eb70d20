//! Fog of a coloured extinction, and terms that scatter in ways of their own.

use fogbank_core::Renderer;
use fogbank_core::media::{Field, Moment};
use fogbank_core::phase::PhaseFunction;
use fogbank_core::request::{Layer, Quality, View};
use fogbank_core::scene::{Scene, Term, read};
use fogbank_tests::quadrature::integrate;
use fogbank_tests::scenes::{pixel_rays, probe, render, scene, surfaces, view};
use fogbank_tests::trials::smoke;
use glam::DVec3;
use serde_json::{Value, json};

/// A scene of the trials, by its name.
fn trial(name: &str) -> Value {
    smoke().into_iter().find(|trial| trial.name == name).expect("a trial").scene
}

/// The same fog as one channel meets it: every extinction that is a row becomes its number there.
fn in_channel(json: &Value, channel: usize) -> Value {
    match json {
        Value::Object(members) => {
            let member = |(key, value): (&String, &Value)| match value {
                Value::Array(row) if key == "extinction" => (key.clone(), row[channel].clone()),
                _ => (key.clone(), in_channel(value, channel)),
            };
            members.iter().map(member).collect()
        }
        Value::Array(items) => items.iter().map(|item| in_channel(item, channel)).collect(),
        leaf => leaf.clone(),
    }
}

/// Channels are independent: what a coloured fog does in one of them is what the grey fog of that
/// channel's extinction does, to the last bit, whatever the estimator.
#[test]
fn a_coloured_fog_is_a_grey_one_in_each_channel() {
    let coloured = trial("coloured-smoke");
    let mut alike = coloured.clone();
    for term in alike["fog"]["terms"].as_array_mut().unwrap() {
        term.as_object_mut().unwrap().retain(|key, _| key != "albedo" && key != "phase");
    }
    alike["fog"]["airlight"] = json!("fogshop2007");
    let haze = json!({ "kind": "homogeneous", "extinction": [0.02, 0.05, 0.1] });
    let mut even = coloured.clone();
    even["fog"] = json!({ "terms": [haze], "airlight": "sun2005" });
    for json in [coloured, alike, even] {
        let grey = [0, 1, 2].map(|channel| scene(&in_channel(&json, channel)));
        let json = scene(&json);
        for layer in [
            Layer::Airlight,
            Layer::Surface,
            Layer::Beauty,
            Layer::OpticalDepth,
            Layer::Transmittance,
        ] {
            for quality in [Quality::Full, Quality::Draft] {
                let view =
                    View { for_screen: quality == Quality::Draft, ..view(48, 36, layer, quality) };
                let frame = render(&json, &view);
                assert_eq!(frame.channels, 3, "{layer:?}");
                for (channel, grey) in grey.iter().enumerate() {
                    let grey = render(grey, &view);
                    let place = if grey.channels == 3 { channel } else { 0 };
                    let own = grey.pixels.iter().skip(place).step_by(grey.channels);
                    let of_coloured = frame.pixels.iter().skip(channel).step_by(3);
                    assert!(own.eq(of_coloured), "{layer:?}, {quality:?}, channel {channel}");
                }
            }
        }
        let rays = pixel_rays(&json, 4, 3);
        for (i, answer) in probe(&json, &rays).iter().enumerate() {
            for (channel, grey) in grey.iter().enumerate() {
                let grey = &probe(grey, &rays)[i];
                assert_eq!(
                    answer.optical_depth.channels()[channel],
                    grey.optical_depth.channels()[0]
                );
                assert_eq!(
                    answer.transmittance.channels()[channel],
                    grey.transmittance.channels()[0]
                );
                assert_eq!(answer.airlight.0[channel], grey.airlight.0[channel]);
                assert_eq!(answer.radiance.0[channel], grey.radiance.0[channel]);
            }
        }
    }
}

/// Of equal numbers a row is one number, and so are the answers.
#[test]
fn three_equal_extinctions_are_one() {
    let fog = |extinction: Value| {
        let terms = json!([{ "kind": "homogeneous", "extinction": extinction }]);
        scene(
            &json!({ "surfaces": surfaces(), "lights": [{ "kind": "point" }], "fog": { "terms": terms } }),
        )
    };
    let (row, number) = (fog(json!([0.1, 0.1, 0.1])), fog(json!(0.1)));
    let view = view(16, 12, Layer::OpticalDepth, Quality::Full);
    let (row, number) = (render(&row, &view), render(&number, &view));
    assert_eq!((row.channels, &row.pixels), (1, &number.pixels));
}

/// What a term says of itself that the fog says as well changes nothing but the order of sums.
#[test]
fn who_says_how_a_term_scatters_does_not_matter() {
    let mut own = trial("smoke");
    for term in own["fog"]["terms"].as_array_mut().unwrap() {
        term.as_object_mut().unwrap().retain(|key, _| key != "albedo" && key != "phase");
    }
    own["fog"]["albedo"] = json!([0.9, 0.7, 0.5]);
    own["fog"]["phase"] = json!({ "kind": "henyey_greenstein", "g": 0.4 });
    let plain = own.clone();
    own["fog"]["terms"][1]["albedo"] = plain["fog"]["albedo"].clone();
    own["fog"]["terms"][2]["phase"] = plain["fog"]["phase"].clone();
    let (own, plain) = (scene(&own), scene(&plain));
    // Each group has a rule of its own, and each rule is off by up to 3e-4 of its share.
    for (layer, allowed) in
        [(Layer::Airlight, 1e-3), (Layer::OpticalDepth, 1e-5), (Layer::Surface, 1e-5)]
    {
        let view = view(48, 36, layer, Quality::Full);
        let (own, plain) = (render(&own, &view).pixels, render(&plain, &view).pixels);
        let most = plain.iter().fold(0.0f32, |most, value| most.max(*value));
        for (a, b) in own.iter().zip(&plain) {
            assert!((a - b).abs() <= allowed * (b + 1e-2 * most), "{layer:?}: {a} {b}");
        }
    }
}

/// L_a = Σ ω ∫ β p(α) I/d² e^(−T) dt over the groups, β of each and T of all, by a quadrature of another
/// kind over the angle at the lamp.
#[test]
fn each_group_scatters_by_its_own_albedo_and_phase() {
    let mut json = trial("smoke");
    json["fog"]["airlight"] = json!("reference");
    let parsed: Scene = read(json.to_string().as_bytes()).unwrap();
    let (terms, checked) = (&parsed.fog.terms, scene(&json));
    let whole = Field::new(terms, 0, &Moment::default());
    let phases = [0.0, 0.6, 0.0].map(|g| PhaseFunction { g });
    let albedos = [[1.0; 3], [0.9, 0.3, 0.2], [0.2, 0.4, 0.9]];
    let alone = |term: &Term| Field::new(std::slice::from_ref(term), 0, &Moment::default());
    let rays = pixel_rays(&checked, 3, 2);
    for (ray, answer) in rays.iter().zip(probe(&checked, &rays)) {
        let length = answer.hit.as_ref().map_or(checked.far_m, |hit| hit.distance_m);
        let mut expected = DVec3::ZERO;
        for (_, lit) in checked.lamps() {
            let at = lit.source.place();
            let to = at - ray.origin;
            let (closest, miss) = (to.dot(ray.direction), to.cross(ray.direction).length());
            for ((term, phase), albedo) in terms.iter().zip(phases).zip(albedos) {
                let own = alone(term);
                let glow = |angle: f64| {
                    let x = ray.origin + (closest + miss * angle.tan()) * ray.direction;
                    let depth = whole.depth_between(ray.origin, x) + whole.depth_between(at, x);
                    let cos = (x - at).normalize().dot(-ray.direction);
                    own.beta(x) * phase.value(cos) * (-depth).exp() / miss
                };
                let angle = |t: f64| ((t - closest) / miss).atan();
                let sum = integrate(angle(0.0), angle(length), &glow);
                expected += sum * lit.strength * DVec3::from(albedo);
            }
        }
        for (a, b) in answer.airlight.0.iter().zip(expected.to_array()) {
            // What the reference leaves open: 1e-7 a panel.
            assert!((a - b).abs() <= 1e-6 * b, "{a} instead of {b}");
        }
    }
}

/// Soot takes light away and gives none: with it, the airlight is that of the rest, dimmed.
#[test]
fn what_scatters_nothing_only_dims() {
    let mut json = trial("smoke");
    json["fog"]["terms"][1]["albedo"] = json!([0, 0, 0]);
    let sooty = scene(&json);
    json["fog"]["terms"][1]["enabled"] = json!(false);
    let clean = scene(&json);
    let mut dark = 0;
    let rays = pixel_rays(&sooty, 8, 6);
    for (sooty, clean) in probe(&sooty, &rays).iter().zip(probe(&clean, &rays)) {
        assert!(sooty.optical_depth.channels()[0] >= clean.optical_depth.channels()[0]);
        for (a, b) in sooty.airlight.0.iter().zip(clean.airlight.0) {
            assert!(*a <= b * 1.000_1, "soot shines: {a} instead of {b}");
            dark += usize::from(*a < 0.95 * b);
        }
    }
    assert!(dark > 10, "it casts no shadow: {dark}");
    json["fog"]["terms"] =
        json!([{ "kind": "homogeneous", "extinction": 0.1, "albedo": [0, 0, 0] }]);
    let view = view(16, 12, Layer::Airlight, Quality::Full);
    assert!(render(&scene(&json), &view).pixels.iter().all(|value| *value == 0.0));
}

/// Sun's closed form takes terms of several albedos, each of which scatters its share.
#[test]
fn even_fog_of_several_albedos_is_sun_s() {
    let layer = |extinction: f64, albedo: [f64; 3]| json!({ "kind": "homogeneous", "extinction": extinction, "albedo": albedo });
    let mut json = trial("smoke");
    json["fog"] = json!({ "terms": [layer(0.05, [1.0, 0.5, 0.2]), layer(0.1, [0.3, 0.6, 0.9])] });
    let view = view(32, 24, Layer::Airlight, Quality::Full);
    let auto = render(&scene(&json), &view).pixels;
    json["fog"]["airlight"] = json!("reference");
    let reference = render(&scene(&json), &view).pixels;
    for (a, b) in auto.iter().zip(&reference) {
        // Sun's rule is exact to 7e-5.
        assert!((a - b).abs() <= 1e-4 * b, "{a} instead of {b}");
    }
}

/// The published methods say what they do not take.
#[test]
fn who_cannot_scatter_so_says_it() {
    let problems = |json: &Value| {
        let scene: Scene = read(json.to_string().as_bytes()).unwrap();
        let problems = scene.check().expect_err("refused");
        problems.into_iter().map(|problem| (problem.pointer, problem.detail)).collect::<Vec<_>>()
    };
    let mut json = trial("smoke");
    for (airlight, word) in [("fogshop2007", "isotropically"), ("sun2005", "isotropically")] {
        json["fog"]["airlight"] = json!(airlight);
        let [(pointer, detail)] = &problems(&json)[..] else { panic!("one problem") };
        assert!(pointer == "/fog/airlight" && detail.contains(word), "{pointer}: {detail}");
    }
    json["fog"]["terms"][1]["phase"] = json!(null);
    json["fog"]["airlight"] = json!("fogshop2007");
    let [(_, detail)] = &problems(&json)[..] else { panic!("one problem") };
    assert!(detail.contains("albedo"), "{detail}");
    json["fog"]["airlight"] = json!("auto");
    json["fog"]["terms"][1]["albedo"] = json!([0.5, 1.5, 2]);
    json["fog"]["terms"][1]["phase"] = json!({ "kind": "henyey_greenstein", "g": 1 });
    json["fog"]["terms"][0]["extinction"] = json!([0.1, -1, 2e6]);
    let pointers: Vec<_> = problems(&json).into_iter().map(|(pointer, _)| pointer).collect();
    let terms = ["0/extinction/1", "0/extinction/2", "1/albedo/1", "1/albedo/2", "1/phase/g"];
    assert_eq!(pointers, terms.map(|at| format!("/fog/terms/{at}")));
}

/// A change of what the fog scatters keeps the picture's light; so does one of a term's only where it
/// says so itself.
#[test]
fn the_fog_s_albedo_recomputes_nothing() {
    let renderer = Renderer::default();
    let mut json = trial("coloured-smoke");
    let view =
        View { for_screen: true, samples: Some(4), ..view(48, 36, Layer::Beauty, Quality::Full) };
    let ran = |json: &Value| {
        let frame = renderer.render(&scene(json), &view, &Default::default()).unwrap();
        let laps = frame.timings.iter().filter(|lap| !lap.is_reused);
        laps.map(|lap| lap.pass).collect::<Vec<_>>()
    };
    assert!(ran(&json).len() > 2);
    json["fog"]["albedo"] = json!([0.7, 0.8, 0.9]);
    assert_eq!(ran(&json), ["prepare", "composite"]);
}
