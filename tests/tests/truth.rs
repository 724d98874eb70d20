//! Exact numbers: the public cases and scenes, where they lie beside the project.

use fogbank_core::request::ProbeRequest;
use fogbank_core::scene::read;
use fogbank_core::{Progress, Renderer};
use serde_json::{Value, json};

/// `|a − b| ≤ tolerance · |b|`, below 1e-12 absolutely.
fn close(what: &str, a: f64, b: f64, tolerance: f64) {
    let allowed = tolerance * b.abs().max(1e-12);
    assert!((a - b).abs() <= allowed, "{what}: {a} instead of {b}, off by {:.2e}", a / b - 1.0);
}

fn probe(scene: &Value, rays: &[Value]) -> Vec<fogbank_core::probe::RayAnswer> {
    let body = json!({ "scene": scene, "rays": rays }).to_string();
    let request: ProbeRequest = read(body.as_bytes()).expect("a probe request");
    let (scene, rays) = request.check().expect("a valid probe");
    Renderer::default().probe(&scene, &rays, &Progress::default()).expect("not interrupted")
}

fn cases(kind: &str) -> Vec<Value> {
    let Some(file) = fogbank_tests::truth("public_cases.json") else { return Vec::new() };
    let cases = file["cases"].as_array().expect("cases");
    let cases: Vec<_> = cases.iter().filter(|case| case["kind"] == kind).cloned().collect();
    assert!(!cases.is_empty(), "no case of kind {kind}");
    cases
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::INFINITY)
}

fn vector(value: &Value) -> [f64; 3] {
    [0, 1, 2].map(|i| number(&value[i]))
}

/// The phase function of a case: Henyey–Greenstein, g = 0 included.
fn phase(inputs: &Value) -> Value {
    json!({ "kind": "henyey_greenstein", "g": inputs["hg_g"].as_f64().unwrap_or(0.0) })
}

fn fog(inputs: &Value, airlight: &str) -> Value {
    let blob = |g: &Value| json!({ "center": g["b"], "radius": 1.0 / number(&g["a"]), "extinction": g["c"] });
    let blobs: Vec<_> = inputs["gaussians"].as_array().into_iter().flatten().map(blob).collect();
    json!({ "airlight": airlight, "phase": phase(inputs), "terms": [
        { "kind": "homogeneous", "extinction": inputs["beta0"] },
        { "kind": "gaussians", "blobs": blobs },
    ] })
}

fn segment(from: &Value, to: &Value) -> Value {
    let (a, b) = (vector(from), vector(to));
    let direction = [0, 1, 2].map(|i| b[i] - a[i]);
    let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
    json!({ "origin": a, "direction": direction, "max_distance_m": length })
}

fn lamp(position: &Value, intensity: &Value) -> Value {
    json!([{ "kind": "point", "position": position, "intensity": [intensity, intensity, intensity] }])
}

#[test]
fn optical_depths_of_gaussians_are_exact() {
    for case in cases("F.optical_depth") {
        let inputs = &case["inputs"];
        let scene = json!({ "fog": fog(inputs, "none") });
        let answer = &probe(&scene, &[segment(&inputs["origin"], &inputs["target"])])[0];
        let id = case["id"].as_str().unwrap_or_default();
        close(id, answer.optical_depth, number(&case["expected"]["T"]), 1e-9);
        close(id, answer.transmittance, number(&case["expected"]["transmittance"]), 1e-9);
    }
}

#[test]
fn optical_depths_of_homogeneous_fog_are_exact() {
    for case in cases("S.optical_depth") {
        let inputs = &case["inputs"];
        let term = json!({ "kind": "homogeneous", "extinction": inputs["beta"] });
        let ray =
            json!({ "origin": [0, 0, 0], "direction": [1, 2, 3], "max_distance_m": inputs["D"] });
        let answer = &probe(&json!({ "fog": { "terms": [term] } }), &[ray])[0];
        let id = case["id"].as_str().unwrap_or_default();
        close(id, answer.optical_depth, number(&case["expected"]["T"]), 1e-9);
    }
}

#[test]
fn airlight_in_gaussians_is_as_exact_as_its_method() {
    for case in cases("F.airlight") {
        let (inputs, expected) = (&case["inputs"], &case["expected"]);
        let id = case["id"].as_str().unwrap_or_default();
        let ray = segment(&inputs["v"], &inputs["p"]);
        let airlight = |method: &str| {
            let lights = lamp(&inputs["s"], &inputs["I0"]);
            let scene = json!({ "lights": lights, "fog": fog(inputs, method) });
            probe(&scene, std::slice::from_ref(&ray))[0].airlight.0[0]
        };
        let exact = airlight("reference");
        assert!(exact.is_finite(), "{id}");
        if expected["divergent"] == false {
            close(id, exact, number(&expected["La"]), 1e-4);
        }
        // The published method is isotropic.
        if number(&inputs["hg_g"]) != 0.0 {
            continue;
        }
        let published = airlight("fogshop2007");
        assert!(published.is_finite(), "{id}");
        if expected["divergent"] == true {
            continue;
        }
        let paper = &expected["fogshop_paper"];
        if paper["divergent"] == false {
            close(id, published, number(&paper["La"]), 2e-3);
        }
    }
}

#[test]
fn airlight_in_homogeneous_fog_is_exact() {
    for case in cases("S.airlight") {
        let (inputs, expected) = (&case["inputs"], &case["expected"]);
        let id = case["id"].as_str().unwrap_or_default();
        let (gamma, distance) = (number(&inputs["gamma"]), number(&inputs["Dsv"]));
        let position = json!([distance * gamma.sin(), 0.0, distance * gamma.cos()]);
        let beta = number(&inputs["beta"]);
        // Behind an optical depth of 60 nothing is left to see.
        let length = number(&inputs["Dvp"]).min(60.0 / beta);
        for (method, tolerance) in [("reference", 1e-4), ("auto", 1e-3), ("sun2005", 1e-3)] {
            if method == "sun2005" && number(&inputs["hg_g"]) != 0.0 {
                continue;
            }
            let term = json!({ "kind": "homogeneous", "extinction": beta });
            let scene = json!({
                "lights": lamp(&position, &inputs["I0"]),
                "fog": { "airlight": method, "phase": phase(inputs), "terms": [term] },
            });
            let ray =
                json!({ "origin": [0, 0, 0], "direction": [0, 0, 1], "max_distance_m": length });
            let airlight = probe(&scene, &[ray])[0].airlight.0[0];
            assert!(airlight.is_finite(), "{id}");
            if expected["divergent"] == false {
                close(&format!("{id} {method}"), airlight, number(&expected["La"]), tolerance);
            }
        }
    }
}

#[test]
fn reference_meets_every_ray_of_the_scenes() {
    let Some(file) = fogbank_tests::truth("scenes.json") else { return };
    for entry in file["scenes"].as_array().expect("scenes") {
        let mut scene = entry["scene"].clone();
        scene["fog"]["airlight"] = json!("reference");
        let rays = entry["rays"].as_array().expect("rays");
        let origin = &scene["camera"]["position"];
        let asked = |ray: &Value| {
            json!({ "origin": origin, "direction": ray["direction"],
                    "max_distance_m": ray["max_distance_m"] })
        };
        let asked: Vec<_> = rays.iter().map(asked).collect();
        for (answer, ray) in probe(&scene, &asked).iter().zip(rays) {
            close(&entry["name"].to_string(), answer.airlight.0[0], number(&ray["airlight"]), 1e-4);
        }
    }
}
