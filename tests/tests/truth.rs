//! Exact numbers: the public cases and scenes, where they lie beside the project.

use fogbank_core::request::ProbeRequest;
use fogbank_core::scene::read;
use fogbank_core::{Progress, Renderer};
use fogbank_tests::cases::{fog, in_homogeneous, lamp, number, of_kind, segment};
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

#[test]
fn optical_depths_of_gaussians_are_exact() {
    for case in of_kind("F.optical_depth") {
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
    for case in of_kind("S.optical_depth") {
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
    for case in of_kind("F.airlight") {
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
    for case in of_kind("S.airlight") {
        let (inputs, expected) = (&case["inputs"], &case["expected"]);
        let id = case["id"].as_str().unwrap_or_default();
        for (method, tolerance) in [("reference", 1e-4), ("auto", 1e-3), ("sun2005", 1e-3)] {
            if method == "sun2005" && number(&inputs["hg_g"]) != 0.0 {
                continue;
            }
            let (scene, ray) = in_homogeneous(inputs, method);
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
