//! The shaders against exact numbers, ray by ray: at every angle and distance of a light, through thin
//! and dense blobs, and along the public cases, where they lie beside the project.

use fogbank_core::request::{Layer, ProbeRequest, RenderRequest, View};
use fogbank_core::scene::{CheckedScene, read};
use fogbank_core::{Backend, Progress, Renderer};
use fogbank_tests::camera::rays;
use fogbank_tests::cases::{
    expected, in_homogeneous, lamp, number, of_kind, phase, segment, terms, vector,
};
use serde_json::{Value, json};

/// What pictures may be off by, and why. The numbers are those of f32, of its fits of erf, and of a
/// picture's rules.
const LIMITS: [(&str, f64); 7] = [
    ("homogeneous", 1e-6),
    // Pictures leave out blobs that together weigh 1e-5 of optical depth.
    ("gaussians", 1e-4),
    ("sun2005", 1e-3),
    ("fogshop2007", 1e-3),
    // What drafts are held to; and by how much more than the CPU's they may be off.
    ("auto", 5e-2),
    ("auto, half", 1e-2),
    ("auto, most", 5e-2),
];
/// Optical depths count relative to this at least.
const LEAST_DEPTH: f64 = 0.1;
/// Airlight counts relative to this share of the brightest in its row at least.
const FAINT: f64 = 1e-3;

/// The largest errors, by model.
#[derive(Default)]
struct Largest(Vec<(&'static str, f64, String)>);

impl Largest {
    fn add(&mut self, model: &'static str, error: f64, what: impl FnOnce() -> String) {
        match self.0.iter_mut().find(|(known, ..)| *known == model) {
            Some(entry) if error > entry.1 => *entry = (model, error, what()),
            Some(_) => assert!(!error.is_nan(), "{model}: {}", what()),
            None => self.0.push((model, error, what())),
        }
    }

    fn check(&self) {
        for (model, error, what) in &self.0 {
            println!("{model}: {error:.1e}, {what}");
            let limit = LIMITS.iter().find(|(known, _)| known == model).expect("a limit").1;
            assert!(*error <= limit, "{model}: {error:.2e} at {what}");
        }
    }
}

fn renderer() -> Renderer {
    Renderer::open(Backend::Gpu).expect("a Vulkan adapter, be it lavapipe")
}

fn checked(scene: &Value, (width, height): (u32, u32), layer: Layer) -> (CheckedScene, View) {
    // As numbers `auto` is the CPU's, but for drafts.
    let is_on_grid = layer == Layer::Airlight && scene["fog"]["airlight"] == "auto";
    let quality = if is_on_grid { "draft" } else { "full" };
    let body = json!({
        "scene": scene, "width": width, "height": height, "layer": layer, "quality": quality,
    });
    let request: RenderRequest = read(body.to_string().as_bytes()).expect("a render request");
    request.check().unwrap_or_else(|problems| panic!("{scene}: {problems:?}"))
}

fn picture(renderer: &Renderer, scene: &Value, size: (u32, u32), layer: Layer) -> Vec<f64> {
    let (scene, view) = checked(scene, size, layer);
    let frame = renderer.render(&scene, &view, &Progress::default()).expect("not interrupted");
    assert_eq!(frame.backend, "gpu");
    frame.pixels.iter().step_by(layer.channels(1)).map(|value| f64::from(*value)).collect()
}

/// The value of a picture of one pixel that looks along a ray.
fn pixel(renderer: &Renderer, scene: &Value, ray: &Value, layer: Layer) -> f64 {
    let (origin, direction) = (vector(&ray["origin"]), vector(&ray["direction"]));
    let target = [0, 1, 2].map(|k| origin[k] + direction[k]);
    let mut scene = scene.clone();
    scene["camera"] = json!({ "position": origin, "target": target, "up": [0.3, 1, 0.2] });
    scene["far_m"] = ray["max_distance_m"].clone();
    picture(renderer, &scene, (1, 1), layer)[0]
}

/// The airlight along rays in f64, by the scene's own method.
fn exact(scene: &Value, rays: &[Value]) -> Vec<(f64, f64)> {
    let body = json!({ "scene": scene, "rays": rays }).to_string();
    let request: ProbeRequest = read(body.as_bytes()).expect("a probe request");
    let (scene, rays) = request.check().expect("a valid probe");
    let answers = Renderer::default().probe(&scene, &rays, &Progress::default());
    let answers = answers.expect("not interrupted");
    answers
        .iter()
        .map(|answer| (answer.optical_depth.channels()[0], answer.airlight.0[0]))
        .collect()
}

fn off(value: f64, exact: f64, least: f64) -> f64 {
    (value - exact).abs() / exact.max(least)
}

#[test]
fn pixels_are_the_public_cases() {
    let renderer = renderer();
    let mut largest = Largest::default();
    for case in of_kind("F.optical_depth") {
        let inputs = &case["inputs"];
        let scene = json!({ "fog": { "airlight": "none", "terms": terms(inputs) } });
        let ray = segment(&inputs["origin"], &inputs["target"]);
        let depth = pixel(&renderer, &scene, &ray, Layer::OpticalDepth);
        let error = off(depth, number(&case["expected"]["T"]), LEAST_DEPTH);
        largest.add("gaussians", error, || case["id"].to_string());
    }
    for case in of_kind("F.airlight") {
        let inputs = &case["inputs"];
        let ray = segment(&inputs["v"], &inputs["p"]);
        for method in ["fogshop2007", "auto"] {
            if method == "fogshop2007" && number(&inputs["hg_g"]) != 0.0 {
                continue;
            }
            let lights = lamp(&inputs["s"], &inputs["I0"]);
            let fog = json!({ "airlight": method, "phase": phase(inputs), "terms": terms(inputs) });
            let scene = json!({ "lights": lights, "fog": fog });
            // The published method is not exact, but it is what it is.
            let truth = exact(&scene, std::slice::from_ref(&ray))[0].1;
            let value = pixel(&renderer, &scene, &ray, Layer::Airlight);
            largest.add(method, off(value, truth, 1e-9), || case["id"].to_string());
        }
    }
    for case in of_kind("S.airlight") {
        let inputs = &case["inputs"];
        let Some(truth) = expected(&case["expected"], "La") else { continue };
        // A narrow phase function is the mapped rule's.
        let method = if number(&inputs["hg_g"]) == 0.0 { "sun2005" } else { "auto" };
        let (scene, ray) = in_homogeneous(inputs, method);
        let value = pixel(&renderer, &scene, &ray, Layer::Airlight);
        largest.add(method, off(value, truth, 1e-9), || case["id"].to_string());
    }
    largest.check();
}

/// Rays from 59° left to 59° right; the middle one looks straight ahead.
const ROW: (u32, u32) = (65, 1);

fn camera() -> Value {
    json!({ "position": [0, 0, 0], "target": [0, 0, 1], "up": [0, 1, 0],
            "projection": { "kind": "perspective", "vertical_fov_deg": 2.94 } })
}

/// The middle one of a row's errors, and the worst but for one in twenty.
fn middle_and_worst(row: &[f64], exact: &[(f64, f64)], least: f64) -> [f64; 2] {
    let each = row.iter().zip(exact);
    let mut errors: Vec<_> = each.map(|(value, (_, exact))| off(*value, *exact, least)).collect();
    errors.sort_unstable_by(f64::total_cmp);
    [errors[errors.len() / 2], errors[errors.len() * 19 / 20]]
}

/// Compares a row of pixels with their rays. A draft's grid is as far from them as the CPU's.
fn compare(
    renderer: &Renderer,
    scene: &Value,
    model: &'static str,
    what: &str,
    largest: &mut Largest,
) {
    let rays = rays(&scene["camera"], ROW.0 as usize, 1);
    let exact = exact(scene, &rays);
    let depths = picture(renderer, scene, ROW, Layer::OpticalDepth);
    let airlight = picture(renderer, scene, ROW, Layer::Airlight);
    let most = exact.iter().fold(1e-30f64, |most, (_, airlight)| most.max(*airlight));
    let has_blobs = scene["fog"]["terms"].as_array().is_some_and(|terms| terms.len() > 1);
    let medium = if has_blobs { "gaussians" } else { "homogeneous" };
    for (i, (depth, light)) in exact.iter().enumerate() {
        let place = || format!("{what}, ray {i}");
        largest.add(medium, off(depths[i], *depth, LEAST_DEPTH), place);
        if model != "auto" {
            largest.add(model, off(airlight[i], *light, FAINT * most), place);
        }
    }
    if model == "auto" {
        let (scene, view) = checked(scene, ROW, Layer::Airlight);
        let cpus = Renderer::default().render(&scene, &view, &Progress::default());
        let cpus: Vec<_> = cpus.expect("not interrupted").pixels;
        let cpus: Vec<_> = cpus.iter().step_by(3).map(|value| f64::from(*value)).collect();
        let [own, cpus] = [airlight, cpus].map(|row| middle_and_worst(&row, &exact, FAINT * most));
        largest.add("auto, half", (own[0] - cpus[0]).max(0.0), || what.to_owned());
        largest.add("auto, most", (own[1] - cpus[1]).max(0.0), || what.to_owned());
    }
}

#[test]
fn fog_is_exact_at_every_angle_and_distance() {
    let renderer = renderer();
    let mut largest = Largest::default();
    for (beta, far) in [(1e-3, 1e4), (0.05, 100.0), (1.0, 20.0), (30.0, 5.0)] {
        for distance in [1e-2, 1.0, 30.0, 1e3, 1e5] {
            for degrees in [0.0f64, 1.0, 60.0, 120.0, 180.0] {
                let angle = degrees.to_radians();
                let place = json!([distance * angle.sin(), 0.0, distance * angle.cos()]);
                let term = json!({ "kind": "homogeneous", "extinction": beta });
                let scene = json!({
                    "camera": camera(), "lights": lamp(&place, &json!(1.0)), "far_m": far,
                    "fog": { "airlight": "sun2005", "terms": [term] },
                });
                let what = format!("β {beta}, {distance} m at {degrees}°");
                compare(&renderer, &scene, "sun2005", &what, &mut largest);
            }
        }
    }
    largest.check();
}

/// Blobs of every density and size, in front, around and behind, before a lamp among them.
#[test]
fn blobs_are_exact_from_thin_to_opaque() {
    let renderer = renderer();
    let mut largest = Largest::default();
    for (extinction, radius) in [(1e-3, 3.0), (0.3, 0.5), (2.0, 1.0), (40.0, 0.2), (1e3, 0.01)] {
        for depth in [-1.0, 0.0, 4.0, 300.0] {
            for (method, model) in [("fogshop2007", "fogshop2007"), ("auto", "auto")] {
                let blobs =
                    [[0.1, 0.05, depth], [-2.0, 0.0, depth + 1.0], [1.5, 0.02, depth + 3.0]];
                let blobs = blobs.map(|center| {
                    json!({ "center": center, "radius": radius, "extinction": extinction })
                });
                let terms = json!([
                    { "kind": "homogeneous", "extinction": 0.01 },
                    { "kind": "gaussians", "blobs": blobs },
                ]);
                let lights = lamp(&json!([0.7, 1.0, depth + 1.0]), &json!(1.0));
                let scene = json!({
                    "camera": camera(), "lights": lights, "far_m": 400,
                    "fog": { "airlight": method, "terms": terms },
                });
                let what = format!("{extinction}/m, radius {radius} m, {depth} m ahead");
                compare(&renderer, &scene, model, &what, &mut largest);
            }
        }
    }
    largest.check();
}
