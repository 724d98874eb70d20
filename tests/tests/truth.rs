//! Exact numbers: the cases and scenes of `tests/truth`.

use fogbank_core::num::Num;
use fogbank_core::request::ProbeRequest;
use fogbank_core::scene::read;
use fogbank_core::{Progress, Renderer};
use fogbank_tests::cases::*;
use fogbank_tests::fields::variants;
use serde_json::{Value, json};
use std::collections::BTreeSet;

/// Kinds of cases that are compared here.
const COMPARED: [&str; 14] = [
    "B.cosine",
    "B.equipotential",
    "B.polynomial",
    "F.airlight",
    "F.erf_cheb",
    "F.optical_depth",
    "M.point",
    "M.spot",
    "S.airlight",
    "S.optical_depth",
    "S.surface",
    "W.haar_mu",
    "W.optical_depth",
    "W.two_scale",
];

/// Kinds that nothing in a scene asks for yet: the union of the schema and the variant that will.
const AWAITED: [(&str, &str, &str); 4] = [
    ("F.npsf_sh", "SurfaceLighting", "psf"),
    ("F.tbar", "SurfaceLighting", "psf"),
    ("S.G", "SurfaceLighting", "sun2005"),
    ("S.NPSF", "SurfaceLighting", "psf"),
];

/// Kinds of what the program has no equal of. The difference of two F is one integral here.
const FOREIGN: [&str; 1] = ["S.F"];

/// `|a − b| ≤ tolerance · |b|`, below 1e-12 absolutely; and both are numbers.
#[track_caller]
fn close(what: &str, a: f64, b: f64, tolerance: f64) {
    let allowed = tolerance * b.abs().max(1e-12);
    let is_close = a.is_finite() && b.is_finite() && (a - b).abs() <= allowed;
    assert!(is_close, "{what}: {a} instead of {b}, off by {:.2e}", a / b - 1.0);
}

/// Of a grey fog, to what f64 keeps of a sum.
#[track_caller]
fn close_depth(what: &str, answer: &fogbank_core::probe::RayAnswer, expected: &Value) {
    let [depth, through] = [answer.optical_depth, answer.transmittance].map(|v| v.channels()[0]);
    close(what, depth, number(&expected["T"]), 1e-9);
    close(what, through, number(&expected["transmittance"]), 1e-9);
}

fn id(case: &Value) -> &str {
    case["id"].as_str().expect("an id")
}

fn probe(scene: &Value, rays: &[Value]) -> Vec<fogbank_core::probe::RayAnswer> {
    let body = json!({ "scene": scene, "rays": rays }).to_string();
    let request: ProbeRequest = read(body.as_bytes()).expect("a probe request");
    let (scene, rays) = request.check().expect("a valid probe");
    let answers = Renderer::default().probe(&scene, &rays, &Progress::default());
    let answers = answers.expect("not interrupted");
    assert_eq!(answers.len(), rays.len());
    answers
}

fn airlight((scene, ray): (Value, Value)) -> f64 {
    let airlight = probe(&scene, &[ray])[0].airlight.0[0];
    assert!(airlight.is_finite(), "{airlight}");
    airlight
}

/// No case stands here unread: each kind is compared, or waits for what is not there yet.
#[test]
fn every_kind_is_compared_or_awaited() {
    let kinds: BTreeSet<_> = all().iter().filter_map(|case| case["kind"].as_str()).collect();
    let awaited = AWAITED.map(|(kind, _, _)| kind);
    let known = COMPARED.into_iter().chain(awaited).chain(FOREIGN);
    assert_eq!(kinds, known.collect());
    for (kind, union, variant) in AWAITED {
        let there = variants(union);
        assert!(!there.is_empty() && !there.iter().any(|v| v == variant), "{kind} is due");
    }
    assert_eq!((all().len(), scenes().len()), (71, 11));
}

#[test]
#[should_panic = "instead of inf"]
fn an_infinite_expectation_is_not_met() {
    close("case", 1.0, f64::INFINITY, 1e-9);
}

#[test]
fn optical_depths_of_gaussians_are_exact() {
    for case in of_kind("F.optical_depth") {
        let (inputs, expected) = (&case["inputs"], &case["expected"]);
        let scene = json!({ "fog": { "terms": terms(inputs) } });
        let answer = &probe(&scene, &[segment(&inputs["origin"], &inputs["target"])])[0];
        close_depth(id(&case), answer, expected);
    }
}

#[test]
fn optical_depths_of_homogeneous_fog_are_exact() {
    for case in of_kind("S.optical_depth") {
        let (inputs, expected) = (&case["inputs"], &case["expected"]);
        let term = json!({ "kind": "homogeneous", "extinction": inputs["beta"] });
        let ray =
            json!({ "origin": [0, 0, 0], "direction": [1, 2, 3], "max_distance_m": inputs["D"] });
        let answer = &probe(&json!({ "fog": { "terms": [term] } }), &[ray])[0];
        close_depth(id(&case), answer, expected);
    }
}

/// Waves, polynomials on their period, and fog around objects integrated along the ray.
#[test]
fn optical_depths_of_functions_are_exact() {
    for (kind, depth) in
        [("B.cosine", "T"), ("B.polynomial", "T_unit"), ("B.equipotential", "T_int")]
    {
        for case in of_kind(kind) {
            let inputs = &case["inputs"];
            let term = json!({ "kind": "functions", "members": members(kind, inputs) });
            let scene = json!({ "fog": { "terms": [term] } });
            let answer = &probe(&scene, &[segment(&inputs["O"], &inputs["P"])])[0];
            let found = answer.optical_depth.channels()[0];
            close(id(&case), found, number(&case["expected"][depth]), 1e-9);
        }
    }
}

/// T of a map between two points, as a number that a scene says.
fn through(map: Value, from: &Value, to: &Value) -> f64 {
    let scene = json!({ "fog": { "terms": [map] } });
    probe(&scene, &[segment(from, to)])[0].optical_depth.channels()[0]
}

/// The whole support of the splines counts, and every metre of a slanted way.
#[test]
fn optical_depths_of_fogmaps_are_exact() {
    for case in of_kind("W.optical_depth") {
        let inputs = &case["inputs"];
        let depth = through(fogmap(inputs), &inputs["O"], &inputs["P"]);
        close(id(&case), depth, number(&case["expected"]["T"]), 1e-9);
    }
}

/// A map is the same fog on cells half as large.
#[test]
fn fogmaps_are_refined_by_the_two_scale_relation() {
    for case in of_kind("W.two_scale") {
        let inputs = &case["inputs"];
        let coarse = json!({ "kind": "fogmap", "degree": inputs["degree"], "cell_m": 1.0,
            "origin": [0, 0], "coefficients": inputs["coef"] });
        let mut fine = coarse.clone();
        (fine["cell_m"], fine["coefficients"]) = (json!(0.5), case["expected"]["refined"].clone());
        for (from, to) in [([-1.0, 0.0, 0.3], [5.0, 1.0, 2.1]), ([0.7, 0.0, 3.5], [1.9, 0.2, -1.0])]
        {
            let (from, to) = (json!(from), json!(to));
            let depth = through(fine.clone(), &from, &to);
            close(id(&case), depth, through(coarse.clone(), &from, &to), 1e-9);
        }
    }
}

/// Details count up to their share of a view ray; with all of them the map is what it was.
#[test]
fn fogmaps_drop_details_by_their_level() {
    for case in of_kind("W.haar_mu") {
        let inputs = &case["inputs"];
        for deconstruct in [false, true] {
            let mut map = fogmap(inputs);
            map["levels"] = inputs["levels"].clone();
            map["deconstruct"] = json!(deconstruct);
            for (mu, expected) in [(1.0, "T_full"), (number(&inputs["mu"]), "T_exponent_n_plus_1")]
            {
                map["mu"] = json!(mu);
                let depth = through(map.clone(), &inputs["O"], &inputs["P"]);
                close(id(&case), depth, number(&case["expected"][expected]), 1e-9);
            }
        }
    }
}

#[test]
fn airlight_in_gaussians_is_as_exact_as_its_method() {
    for case in of_kind("F.airlight") {
        let (inputs, results) = (&case["inputs"], &case["expected"]);
        let airlight = |method: &str| {
            let fog = json!({ "airlight": method, "phase": phase(inputs), "terms": terms(inputs) });
            let scene = json!({ "lights": lamp(&inputs["s"], &inputs["I0"]), "fog": fog });
            airlight((scene, segment(&inputs["v"], &inputs["p"])))
        };
        let exact = expected(results, "La");
        for (method, tolerance) in [("reference", 1e-9), ("auto", 1e-3)] {
            let airlight = airlight(method);
            if let Some(exact) = exact {
                close(&format!("{} {method}", id(&case)), airlight, exact, tolerance);
            }
        }
        // The published method is isotropic.
        if number(&inputs["hg_g"]) != 0.0 {
            continue;
        }
        let published = airlight("fogshop2007");
        if let Some(paper) = expected(&results["fogshop_paper"], "La") {
            close(id(&case), published, paper, 2e-3);
        }
    }
}

#[test]
fn airlight_in_homogeneous_fog_is_exact() {
    for case in of_kind("S.airlight") {
        let (inputs, results) = (&case["inputs"], &case["expected"]);
        for (method, tolerance) in [("reference", 1e-9), ("auto", 1e-4), ("sun2005", 1e-4)] {
            if method == "sun2005" && number(&inputs["hg_g"]) != 0.0 {
                continue;
            }
            let airlight = airlight(in_homogeneous(inputs, method));
            if let Some(exact) = expected(results, "La") {
                close(&format!("{} {method}", id(&case)), airlight, exact, tolerance);
            }
        }
    }
}

/// Where nothing is attenuated, airlight is ∫ dt/d², of which Macklin gives the closed form.
#[test]
fn airlight_in_thin_air_is_the_inverse_square_integral() {
    for case in of_kind("M.point") {
        let (inputs, results) = (&case["inputs"], &case["expected"]);
        for (method, tolerance) in [("reference", 1e-6), ("sun2005", 1e-4), ("macklin2010", 1e-9)] {
            let airlight = airlight(in_thin_air(inputs, method));
            if let Some(exact) = expected(results, "Ls") {
                close(&format!("{} {method}", id(&case)), airlight, exact, tolerance);
            }
        }
    }
}

/// The same of a lamp that shines into a cone. Where its light fades a rule of ten places meets a cubic.
#[test]
fn light_of_a_cone_in_thin_air_is_the_weighed_integral() {
    for case in of_kind("M.spot") {
        let (inputs, results) = (&case["inputs"], &case["expected"]);
        let exact = expected(results, "Ls").expect("a number");
        for (method, tolerance) in
            [("reference", 1e-6), ("auto", 1e-4), ("sun2005", 1e-4), ("macklin2010", 1e-5)]
        {
            close(
                &format!("{} {method}", id(&case)),
                airlight(in_thin_air(inputs, method)),
                exact,
                tolerance,
            );
        }
    }
}

/// `attenuated` is the direct part of Sun's surface radiance.
#[test]
fn direct_light_of_surfaces_is_exact() {
    for case in of_kind("S.surface") {
        let (scene, ray) = on_a_surface(&case["inputs"]);
        let hit = probe(&scene, &[ray]).remove(0).hit.expect("a floor");
        let direct = number(&case["expected"]["Lp_direct"]);
        close(id(&case), hit.surface_radiance.0[0], direct, 1e-9);
    }
}

/// The error function itself; the printed polynomial is not used.
#[test]
fn error_functions_are_exact() {
    for case in of_kind("F.erf_cheb") {
        let column = |rows: &Value| rows.as_array().expect("numbers").iter().map(number).collect();
        let points: Vec<f64> = column(&case["inputs"]["x"]);
        let values: Vec<f64> = column(&case["expected"]["erf"]);
        assert_eq!(points.len(), values.len());
        for (x, erf) in points.into_iter().zip(values) {
            close(id(&case), Num::erf(x), erf, 1e-15);
        }
    }
}

#[test]
fn reference_meets_every_ray_of_the_scenes() {
    for entry in scenes() {
        let mut scene = entry["scene"].clone();
        scene["fog"]["airlight"] = json!("reference");
        let rays = entry["rays"].as_array().expect("rays");
        assert!(!rays.is_empty(), "{}", entry["name"]);
        let origin = &scene["camera"]["position"];
        let asked = |ray: &Value| {
            json!({ "origin": origin, "direction": ray["direction"],
                    "max_distance_m": ray["max_distance_m"] })
        };
        let asked: Vec<_> = rays.iter().map(asked).collect();
        for (answer, ray) in probe(&scene, &asked).iter().zip(rays) {
            close(&entry["name"].to_string(), answer.airlight.0[0], number(&ray["airlight"]), 1e-9);
        }
    }
}
