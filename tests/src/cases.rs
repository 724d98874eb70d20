//! The exact cases of `tests/truth` as scenes and rays.

#![allow(clippy::expect_used, clippy::panic, reason = "a test without its numbers has failed")]

use serde_json::{Value, json};
use std::sync::LazyLock;

static CASES: LazyLock<Vec<Value>> = LazyLock::new(|| rows(include_str!("../truth/cases.json")));
static SCENES: LazyLock<Vec<Value>> = LazyLock::new(|| rows(include_str!("../truth/scenes.json")));

fn rows(text: &str) -> Vec<Value> {
    serde_json::from_str(text).expect("a list")
}

/// All cases.
pub fn all() -> &'static [Value] {
    &CASES
}

/// The scenes with exact airlight along rays.
pub fn scenes() -> &'static [Value] {
    &SCENES
}

/// The cases of a kind, of which there must be some.
pub fn of_kind(kind: &str) -> Vec<Value> {
    let cases: Vec<_> = all().iter().filter(|case| case["kind"] == kind).cloned().collect();
    assert!(!cases.is_empty(), "no case of kind {kind}");
    cases
}

/// A number that must be there.
#[track_caller]
pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// The same, or what a case calls infinite.
#[track_caller]
pub fn length(value: &Value) -> f64 {
    if value == "infinite" { f64::INFINITY } else { number(value) }
}

/// What a case expects under that name; `None` only where the case says that it diverges.
#[track_caller]
pub fn expected(results: &Value, name: &str) -> Option<f64> {
    let diverges = results["divergent"].as_bool().unwrap_or_else(|| panic!("divergent? {results}"));
    (!diverges).then(|| number(&results[name]))
}

/// Three numbers.
#[track_caller]
pub fn vector(value: &Value) -> [f64; 3] {
    [number(&value[0]), number(&value[1]), number(&value[2])]
}

/// The phase function of a case: Henyey–Greenstein, g = 0 included.
pub fn phase(inputs: &Value) -> Value {
    json!({ "kind": "henyey_greenstein", "g": number(&inputs["hg_g"]) })
}

/// The Gaussians of a case and its homogeneous part.
pub fn terms(inputs: &Value) -> Value {
    let blob = |g: &Value| json!({ "center": g["b"], "radius": 1.0 / number(&g["a"]), "extinction": g["c"] });
    let blobs: Vec<_> =
        inputs["gaussians"].as_array().expect("Gaussians").iter().map(blob).collect();
    json!([
        { "kind": "homogeneous", "extinction": number(&inputs["beta0"]) },
        { "kind": "gaussians", "blobs": blobs },
    ])
}

/// The map of a case.
pub fn fogmap(inputs: &Value) -> Value {
    json!({ "kind": "fogmap", "degree": inputs["degree"], "origin": inputs["grid_origin_xz"],
            "cell_m": inputs["cell"], "scale": 1.0, "coefficients": inputs["coef"] })
}

/// The members of a term of functions, as a case says them.
pub fn members(kind: &str, inputs: &Value) -> Value {
    let list = |key: &str| inputs[key].as_array().expect("a list").clone();
    match kind {
        "B.cosine" => list("terms").iter().map(wave).collect(),
        "B.polynomial" => list("polys").iter().map(|poly| polynomial(inputs, poly)).collect(),
        _ => json!([equipotential(inputs)]),
    }
}

fn wave(term: &Value) -> Value {
    json!({ "kind": "cosine", "amplitude": term["c"], "wave_vector": term["k"],
            "phase_rad": term["phi"] })
}

/// Of one variable; half its period is a case's C.
fn polynomial(inputs: &Value, poly: &Value) -> Value {
    let axis = ["x", "y", "z"].iter().position(|name| poly["axis"] == *name).expect("an axis");
    let monomial = |(i, c): (usize, &Value)| {
        let mut powers = [0; 3];
        powers[axis] = i;
        json!({ "powers": powers, "coefficient": number(&poly["c"]) * number(c) })
    };
    let coefficients = poly["coef"].as_array().expect("coefficients").iter().enumerate();
    let mut period = [Value::Null, Value::Null, Value::Null];
    period[axis] = json!(2.0 * number(&inputs["C"]));
    json!({ "kind": "polynomial", "monomials": coefficients.map(monomial).collect::<Vec<_>>(),
            "period_m": period, "repeat": inputs["periodic"] })
}

fn equipotential(inputs: &Value) -> Value {
    let given = &inputs["object"];
    let object = match given["type"].as_str().expect("a type") {
        "point" => json!({ "kind": "point", "position": given["pos"] }),
        "line" => json!({ "kind": "line", "position": given["pos"], "direction": given["dir"] }),
        _ => json!({ "kind": "sphere", "center": given["pos"], "radius": given["radius"] }),
    };
    json!({ "kind": "equipotential", "object": object, "strength": 1.0, "c": inputs["c"],
            "d": inputs["d"] })
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
    let intensity = number(intensity);
    json!([{ "kind": "point", "position": vector(position), "intensity": [intensity, intensity, intensity] }])
}

/// The scene and the ray of a case of airlight in homogeneous fog.
pub fn in_homogeneous(inputs: &Value, airlight: &str) -> (Value, Value) {
    let (gamma, distance) = (number(&inputs["gamma"]), number(&inputs["Dsv"]));
    let position = json!([distance * gamma.sin(), 0.0, distance * gamma.cos()]);
    let beta = number(&inputs["beta"]);
    // Behind an optical depth of 60 nothing is left to see.
    let length = length(&inputs["Dvp"]).min(60.0 / beta);
    let scene = json!({
        "lights": lamp(&position, &inputs["I0"]),
        "fog": { "airlight": airlight, "phase": phase(inputs),
                 "terms": [{ "kind": "homogeneous", "extinction": beta }] },
    });
    (scene, json!({ "origin": [0, 0, 0], "direction": [0, 0, 1], "max_distance_m": length }))
}

/// The scene and the ray of a case of light in air so thin that it takes nothing away: there only
/// the product of extinction and intensity counts, and a case's scattering coefficient is per
/// solid angle.
pub fn in_thin_air(inputs: &Value, airlight: &str) -> (Value, Value) {
    const THIN: f64 = 1e-9;
    let scattered = number(&inputs["I"]) * number(&inputs["sigma_s"]);
    let intensity = json!(scattered * 4.0 * std::f64::consts::PI / THIN);
    let mut light = lamp(&inputs["light"], &intensity);
    if let Some(spot) = inputs.get("spot") {
        let outer = number(&spot["half_outer"]).to_degrees();
        // A hard cone has one angle.
        let inner = spot["half_inner"].as_f64().map_or(outer, f64::to_degrees);
        light[0]["kind"] = "spot".into();
        light[0]["direction"] = spot["axis"].clone();
        light[0]["outer_angle_deg"] = outer.into();
        light[0]["inner_angle_deg"] = inner.into();
    }
    let scene = json!({
        "lights": light,
        "fog": { "airlight": airlight,
                 "terms": [{ "kind": "homogeneous", "extinction": THIN }] },
    });
    let ray = json!({ "origin": inputs["origin"], "direction": inputs["dir"],
                      "max_distance_m": number(&inputs["dist"]) });
    (scene, ray)
}

/// The scene and the ray of a case of a lit surface, seen along its normal: its mirrored view is
/// the normal, too.
pub fn on_a_surface(inputs: &Value) -> (Value, Value) {
    let (angle, distance) = (number(&inputs["theta_s"]), number(&inputs["Dsp"]));
    let position = json!([distance * angle.sin(), distance * angle.cos(), 0.0]);
    let (n, k) = (number(&inputs["n"]), number(&inputs["k"]));
    let material = if n == 1.0 {
        let albedo = k * std::f64::consts::PI;
        json!({ "diffuse": [albedo, albedo, albedo] })
    } else {
        json!({ "diffuse": [0, 0, 0], "specular": [k, k, k], "shininess": n })
    };
    let scene = json!({
        "surfaces": [{ "shape": { "kind": "plane" }, "material": material }],
        "lights": lamp(&position, &inputs["I0"]),
        "fog": { "terms": [{ "kind": "homogeneous", "extinction": number(&inputs["beta"]) }] },
    });
    (scene, json!({ "origin": [0, 3, 0], "direction": [0, -1, 0] }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[should_panic = "null is no number"]
    fn an_absent_number_fails() {
        number(&json!({})["La"]);
    }

    #[test]
    #[should_panic = "null is no number"]
    fn an_absent_length_fails() {
        length(&Value::Null);
    }

    #[test]
    #[should_panic = "null is no number"]
    fn an_absent_result_fails() {
        expected(&json!({ "La": null, "divergent": false }), "La");
    }

    #[test]
    #[should_panic = "divergent?"]
    fn a_result_that_may_diverge_says_whether_it_does() {
        expected(&json!({ "La": 1.0 }), "La");
    }

    #[test]
    fn what_diverges_has_no_result() {
        assert_eq!(expected(&json!({ "La": null, "divergent": true }), "La"), None);
        assert_eq!(length(&json!("infinite")), f64::INFINITY);
    }
}
