//! The exact cases that may lie beside the project, as scenes and rays.

use serde_json::{Value, json};

/// The public cases of a kind; none where they are absent.
pub fn of_kind(kind: &str) -> Vec<Value> {
    let Some(file) = crate::truth("public_cases.json") else { return Vec::new() };
    let cases = file["cases"].as_array().expect("cases");
    let cases: Vec<_> = cases.iter().filter(|case| case["kind"] == kind).cloned().collect();
    assert!(!cases.is_empty(), "no case of kind {kind}");
    cases
}

/// A number; without one what has no end.
pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::INFINITY)
}

/// Three numbers.
pub fn vector(value: &Value) -> [f64; 3] {
    [0, 1, 2].map(|i| number(&value[i]))
}

/// The phase function of a case: Henyey–Greenstein, g = 0 included.
pub fn phase(inputs: &Value) -> Value {
    json!({ "kind": "henyey_greenstein", "g": inputs["hg_g"].as_f64().unwrap_or(0.0) })
}

/// The fog of a case with Gaussians.
pub fn fog(inputs: &Value, airlight: &str) -> Value {
    let blob = |g: &Value| json!({ "center": g["b"], "radius": 1.0 / number(&g["a"]), "extinction": g["c"] });
    let blobs: Vec<_> = inputs["gaussians"].as_array().into_iter().flatten().map(blob).collect();
    json!({ "airlight": airlight, "phase": phase(inputs), "terms": [
        { "kind": "homogeneous", "extinction": inputs["beta0"] },
        { "kind": "gaussians", "blobs": blobs },
    ] })
}

/// The ray of a probe from one point to another.
pub fn segment(from: &Value, to: &Value) -> Value {
    let (a, b) = (vector(from), vector(to));
    let direction = [0, 1, 2].map(|i| b[i] - a[i]);
    let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
    json!({ "origin": a, "direction": direction, "max_distance_m": length })
}

/// One white light.
pub fn lamp(position: &Value, intensity: &Value) -> Value {
    json!([{ "kind": "point", "position": position, "intensity": [intensity, intensity, intensity] }])
}

/// The scene and the ray of a case of airlight in homogeneous fog.
pub fn in_homogeneous(inputs: &Value, airlight: &str) -> (Value, Value) {
    let (gamma, distance) = (number(&inputs["gamma"]), number(&inputs["Dsv"]));
    let position = json!([distance * gamma.sin(), 0.0, distance * gamma.cos()]);
    let beta = number(&inputs["beta"]);
    // Behind an optical depth of 60 nothing is left to see.
    let length = number(&inputs["Dvp"]).min(60.0 / beta);
    let term = json!({ "kind": "homogeneous", "extinction": beta });
    let scene = json!({
        "lights": lamp(&position, &inputs["I0"]),
        "fog": { "airlight": airlight, "phase": phase(inputs), "terms": [term] },
    });
    (scene, json!({ "origin": [0, 0, 0], "direction": [0, 0, 1], "max_distance_m": length }))
}
