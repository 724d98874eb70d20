//! Comparing estimators: the numbers are those of the pictures that the server itself renders.

use fogbank_tests::decode::{self, Picture};
use fogbank_tests::http::Answer;
use fogbank_tests::server::Server;
use serde_json::{Value, json};

const SIZE: (u32, u32) = (40, 30);

fn scene() -> Value {
    json!({
        "camera": { "position": [0, 1.7, 8], "target": [0, 1, 0] },
        "surfaces": [{ "shape": { "kind": "plane" } }],
        "lights": [{ "kind": "point", "position": [-0.5, 2.2, 1], "intensity": [40, 34, 24] }],
        "fog": { "terms": [
            { "kind": "homogeneous", "extinction": 0.03 },
            { "kind": "gaussians", "blobs": [{ "center": [-1, 0.6, 0], "radius": 1.2, "extinction": 0.5 }] },
        ] },
    })
}

fn body(scene: &Value, a: Value, b: Value) -> Value {
    json!({ "scene": scene, "width": SIZE.0, "height": SIZE.1, "a": a, "b": b })
}

fn named(airlight: &str) -> Value {
    json!({ "airlight": airlight })
}

fn march(steps: u32) -> Value {
    json!({ "airlight": "march", "steps": steps })
}

fn compare(server: &Server, a: Value, b: Value) -> Value {
    server.post("/v1/compare", &body(&scene(), a, b)).expect_success().json()
}

fn number(comparison: &Value, name: &str) -> f64 {
    comparison[name].as_f64().unwrap_or_else(|| panic!("no {name} in {comparison}"))
}

/// The airlight layer as one picture of it, by the scene's own estimator.
fn rendered(server: &Server, airlight: &str, accept: &str) -> Answer {
    let mut scene = scene();
    scene["fog"]["airlight"] = airlight.into();
    let body = json!({ "scene": scene, "width": SIZE.0, "height": SIZE.1, "layer": "airlight", "samples": 1 });
    server.post_for("/v1/render", &body, accept).expect_success()
}

fn luminances(picture: &Picture) -> Vec<f64> {
    let pixels = picture.numbers.chunks(3);
    pixels.map(|rgb| 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn close(what: &str, a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-9 * b.abs().max(1e-9), "{what}: {a} instead of {b}");
}

#[test]
fn the_numbers_are_those_of_two_pictures() {
    let server = Server::start();
    let found = compare(&server, named("fogshop2007"), named("reference"));
    let [a, b] = ["fogshop2007", "reference"].map(|airlight| {
        luminances(&decode::npy(&rendered(&server, airlight, "application/x-npy").body))
    });
    let floor = 1e-3 * mean(&b);
    let signed: Vec<_> = a.iter().zip(&b).map(|(a, b)| (a - b) / b.max(floor)).collect();
    let mut sizes: Vec<_> = signed.iter().map(|error| error.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let at = |q: f64| {
        let place = q * (sizes.len() - 1) as f64;
        let (low, high) = (sizes[place.floor() as usize], sizes[place.ceil() as usize]);
        low + place.fract() * (high - low)
    };
    close("bias", number(&found, "bias"), mean(&signed));
    close("median", number(&found, "median"), at(0.5));
    close("p95", number(&found, "p95"), at(0.95));
    close("max", number(&found, "max"), at(1.0));
    close("mean_b", number(&found, "mean_b"), mean(&b));
    // Fogshop's approximation is off by percents, not by nothing and not by everything.
    assert!((0.003..0.5).contains(&number(&found, "median")), "{found}");
    for time in ["a_ms", "b_ms"] {
        assert!(number(&found, time) > 0.0, "{found}");
    }
}

#[test]
fn flip_is_that_of_two_pictures() {
    let server = Server::start();
    let found = compare(&server, named("none"), named("reference"));
    let [a, b] = ["none", "reference"].map(|airlight| {
        let png = rendered(&server, airlight, "image/png").body;
        let picture = decode::screen(&png, image::ImageFormat::Png);
        let bytes: Vec<_> = picture.numbers.iter().map(|byte| *byte as u8).collect();
        nv_flip::FlipImageRgb8::with_data(SIZE.0, SIZE.1, &bytes)
    });
    let map = nv_flip::flip(b, a, fogbank_core::image::flip::PIXELS_PER_DEGREE as f32);
    let expected = f64::from(nv_flip::FlipPool::from_image(&map).mean());
    let flip = number(&found, "flip");
    assert!((flip - expected).abs() < 1e-4, "{flip} instead of {expected}");
    assert!(expected > 0.01, "{expected}");
    assert_eq!(number(&compare(&server, named("auto"), named("auto")), "flip"), 0.0);
}

#[test]
fn auto_against_reference_is_asked_where_nothing_is() {
    let server = Server::start();
    let whole = json!({ "scene": scene(), "width": 8, "height": 6 });
    let found = server.post("/v1/compare", &whole).expect_success().json();
    assert_eq!((&found["a"], &found["b"]), (&named("auto"), &named("reference")));
}

#[test]
fn a_side_against_itself_has_no_error_and_none_is_all_dark() {
    let server = Server::start();
    for side in [named("auto"), named("reference"), march(9)] {
        let found = compare(&server, side.clone(), side);
        for name in ["bias", "median", "p95", "max", "flip"] {
            assert_eq!(number(&found, name), 0.0, "{name} in {found}");
        }
    }
    let dark = compare(&server, named("none"), named("reference"));
    close("bias", number(&dark, "bias"), -1.0);
    let bright = compare(&server, named("reference"), named("none"));
    assert!(number(&bright, "max").is_finite() && number(&bright, "bias") > 1.0, "{bright}");
}

/// Numbers stay numbers where light is beyond measure: a lamp of the largest intensity in the eye, in
/// the densest fog and the thinnest.
#[test]
fn the_brightest_lamps_have_numbers_too() {
    let server = Server::start();
    for extinction in [1e6, 1.0, 1e-300] {
        let mut scene = scene();
        scene["lights"] =
            json!([{ "kind": "point", "position": [0, 1.7, 8], "intensity": [1e12, 1e12, 1e12] }]);
        scene["fog"] = json!({ "terms": [{ "kind": "homogeneous", "extinction": extinction }],
            "phase": { "kind": "henyey_greenstein", "g": 0.99 } });
        for (a, b) in [(march(3), "reference"), (named("none"), "reference"), (march(3), "none")] {
            let answer = server.post("/v1/compare", &body(&scene, a, named(b))).expect_success();
            for name in ["bias", "median", "p95", "max", "flip", "mean_b"] {
                assert!(number(&answer.json(), name).is_finite());
            }
        }
    }
}

#[test]
fn marching_gets_better_with_its_steps() {
    let server = Server::start();
    let medians: Vec<_> = [4, 64, 1024]
        .map(|steps| number(&compare(&server, march(steps), named("reference")), "median"))
        .to_vec();
    assert!(medians[0] > 3.0 * medians[1] && medians[1] > 3.0 * medians[2], "{medians:?}");
    assert!(medians[2] < 1e-3, "{medians:?}");
}

#[test]
fn the_errors_come_as_an_image_with_the_numbers_in_a_header() {
    let server = Server::start();
    let body = body(&scene(), march(6), named("reference"));
    let numbers = server.post("/v1/compare", &body).expect_success();
    assert_eq!(numbers.expect_header("content-type"), "application/json");
    assert!(numbers.expect_header("server-timing").starts_with("queue;dur="));
    let numbers = numbers.json();
    let mut floats = Vec::new();
    for media_type in ["application/x-npy", "image/x-exr", "image/png", "image/webp", "image/jpeg"]
    {
        let answer = server.post_for("/v1/compare", &body, media_type).expect_success();
        assert_eq!(answer.expect_header("content-type"), media_type);
        for name in ["etag", "server-timing", "fog-backend", "fog-quality"] {
            answer.expect_header(name);
        }
        let header: Value = serde_json::from_str(answer.expect_header("fog-comparison")).unwrap();
        for member in ["a", "b", "bias", "median", "p95", "max", "flip", "mean_b"] {
            assert_eq!(header[member], numbers[member], "{member}");
        }
        match media_type {
            "application/x-npy" => floats.push(decode::npy(&answer.body)),
            "image/x-exr" => floats.push(decode::exr(&answer.body)),
            "image/png" => {
                let picture = decode::screen(&answer.body, image::ImageFormat::Png);
                assert_eq!((picture.width, picture.height), (SIZE.0 as usize, SIZE.1 as usize));
                brighter_where_wrong(&picture, &floats[0]);
            }
            _ => {}
        }
    }
    assert_eq!(floats[0], floats[1]);
    assert_eq!((floats[0].width, floats[0].height, floats[0].channels), (40, 30, 1));
    let most = floats[0].numbers.iter().copied().fold(0.0, f64::max);
    // The image holds float32.
    assert!((most / number(&numbers, "max") - 1.0).abs() < 1e-6, "{most}");
}

/// A pixel with ten times the error of another is brighter; the map ends at 1e-4 and 1.
fn brighter_where_wrong(picture: &Picture, errors: &Picture) {
    let luminances = luminances(picture);
    let clamped = |i: usize| errors.numbers[i].clamp(1e-4, 1.0);
    let mut compared = 0;
    for i in 0..luminances.len() {
        for j in 0..luminances.len() {
            if clamped(i) > 10.0 * clamped(j) {
                compared += 1;
                assert!(luminances[i] > luminances[j], "{i} and {j}");
            }
        }
    }
    assert!(compared > 100, "{compared}");
}

#[test]
fn what_cannot_be_compared_is_refused_at_its_place() {
    let server = Server::start();
    let glowing = {
        let mut scene = scene();
        scene["fog"]["phase"] = json!({ "kind": "henyey_greenstein", "g": 0.8 });
        scene
    };
    let auto = || named("auto");
    for (scene, a, b, pointer) in [
        (scene(), named("march"), auto(), "/a/steps"),
        (scene(), auto(), named("march"), "/b/steps"),
        (scene(), march(0), auto(), "/a/steps"),
        (scene(), auto(), march(4097), "/b/steps"),
        (scene(), json!({ "airlight": "auto", "steps": 4 }), auto(), "/a/steps"),
        (scene(), named("sun2005"), auto(), "/a/airlight"),
        (scene(), auto(), named("sun2005"), "/b/airlight"),
        (glowing.clone(), named("fogshop2007"), auto(), "/a/airlight"),
        (scene(), named("fog"), auto(), "/a/airlight"),
        (scene(), json!({}), auto(), "/a"),
        (scene(), json!({ "airlight": "auto", "samples": 4 }), auto(), "/a/samples"),
    ] {
        let answer = server.post("/v1/compare", &body(&scene, a.clone(), b.clone()));
        let problem = answer.expect_problem(422);
        assert_eq!(problem["errors"][0]["pointer"], pointer, "{a} {b}: {problem}");
    }
    let answer = server.post("/v1/compare", &body(&glowing, march(5), named("reference")));
    assert!(number(&answer.expect_success().json(), "max") > 0.0);
    let whole = body(&scene(), auto(), auto());
    server.post_for("/v1/compare", &whole, "text/html").expect_problem(406);
    server.expect_healthy();
}
