//! Scenes whose lights reach parts of the fog only: cones, shadows, shafts.

use crate::scenes::{Random, homogeneous};
use crate::trials::Trial;
use fogbank_core::presets;
use fogbank_core::scene::Scene;
use serde_json::{Value, json};
use std::f64::consts::TAU;

/// All of them.
pub fn parted() -> Vec<Trial> {
    let light = [soft_cone(), hard_cones(), ball(), fence(), fence_in_smoke(), sun_in_patches()];
    let more =
        [tube(), lit_tube(), sixteen(), four_groups(), headlight(), drawing(), drawing_in_sun()];
    light.into_iter().chain(more).chain([city()]).collect()
}

/// Streets between towers, seen from so far that an edge of a shadow is narrower than what the rows tell apart.
fn city() -> Trial {
    let found = presets::all().into_iter().find(|preset| preset.name == "city-353");
    let scene = found.map_or_else(Scene::default, |preset| preset.scene);
    let scene = serde_json::to_value(scene).unwrap_or_default();
    Trial::new("city", "a city street at night", scene)
}

fn trial(name: &str, title: &str, surfaces: Vec<Value>, lights: Value, fog: Value) -> Trial {
    let surfaces: Vec<_> = [floor()].into_iter().chain(surfaces).collect();
    let camera = json!({ "position": [0, 1.7, 8], "target": [0, 1, 0] });
    let scene = json!({ "camera": camera, "surfaces": surfaces, "lights": lights, "fog": fog, "far_m": 60 });
    Trial::new(name, title, scene)
}

fn floor() -> Value {
    json!({ "shape": { "kind": "plane" } })
}

fn sphere(center: [f64; 3], radius: f64) -> Value {
    json!({ "shape": { "kind": "sphere", "center": center, "radius": radius } })
}

fn cuboid(min: [f64; 3], max: [f64; 3]) -> Value {
    json!({ "shape": { "kind": "box", "min": min, "max": max } })
}

/// Pickets 8 cm wide, so far apart [m].
fn pickets(apart: f64) -> Vec<Value> {
    let count = (6.0 / apart) as u32;
    let picket = |i: u32| {
        let x = apart * f64::from(i) - 3.0;
        cuboid([x - 0.04, 0.0, -1.05], [x + 0.04, 1.6, -0.95])
    };
    (0..=count).map(picket).collect()
}

fn point(position: [f64; 3], intensity: f64) -> Value {
    json!({ "kind": "point", "position": position, "intensity": [intensity, intensity, intensity] })
}

fn spot(position: [f64; 3], direction: [f64; 3], inner: f64, outer: f64) -> Value {
    json!({ "kind": "spot", "position": position, "direction": direction,
        "inner_angle_deg": inner, "outer_angle_deg": outer, "intensity": [100, 100, 100] })
}

fn sun(direction: [f64; 3], irradiance: f64) -> Value {
    json!({ "kind": "sun", "direction": direction, "irradiance": [irradiance, irradiance, irradiance] })
}

fn smoke(seed: u64, count: usize) -> Value {
    json!({ "terms": [homogeneous(0.02), Random(seed).blobs(count, 4.0, [0.4, 1.5], [0.05, 0.6])] })
}

fn mist(extinction: f64) -> Value {
    json!({ "terms": [homogeneous(extinction)], "light_path_m": 5 })
}

fn soft_cone() -> Trial {
    let lights = json!([spot([1.0, 4.0, 0.0], [-0.3, -1.0, 0.0], 10.0, 30.0)]);
    trial("soft-cone", "a lamp with a soft cone in smoke", vec![], lights, smoke(1, 20))
}

fn hard_cones() -> Trial {
    let mut fog = smoke(2, 30);
    fog["phase"] = json!({ "kind": "henyey_greenstein", "g": 0.7 });
    let lights = json!([
        spot([0.0, 2.0, -6.0], [0.0, -0.05, 1.0], 25.0, 25.0),
        spot([3.0, 3.0, 2.0], [-1.0, -1.0, -0.5], 0.0, 50.0)
    ]);
    trial(
        "hard-cones",
        "cones towards the eye and from the side, forward scattering",
        vec![],
        lights,
        fog,
    )
}

fn ball() -> Trial {
    let surfaces = vec![sphere([0.0, 1.5, 0.0], 0.6)];
    trial(
        "ball",
        "a ball before a lamp",
        surfaces,
        json!([point([1.5, 2.5, -2.0], 100.0)]),
        mist(0.08),
    )
}

fn fence() -> Trial {
    let lights = json!([point([0.3, 1.0, -3.0], 100.0)]);
    trial("fence", "a lamp behind a fence", pickets(0.3), lights, mist(0.08))
}

fn fence_in_smoke() -> Trial {
    let lights = json!([point([0.3, 1.0, -3.0], 100.0)]);
    trial("fence-smoke", "the same in smoke", pickets(0.3), lights, smoke(4, 30))
}

fn sun_in_patches() -> Trial {
    let mut surfaces = pickets(0.3);
    surfaces.extend([sphere([1.0, 3.0, 1.0], 0.8), cuboid([-2.0, 2.0, 0.0], [0.0, 2.1, 2.0])]);
    trial(
        "sun-patches",
        "the sun through patchy fog",
        surfaces,
        json!([sun([0.4, -1.0, 0.5], 5.0)]),
        smoke(5, 40),
    )
}

/// A tube along z with a hole in its roof.
fn pipe() -> Value {
    const AROUND: usize = 40;
    let rings = [-6.0, -2.5, -1.5, 3.0];
    let corner = |ring: usize, i: usize| {
        let angle = TAU * i as f64 / AROUND as f64;
        [1.5 * angle.cos(), 1.5 + 1.5 * angle.sin(), rings[ring]]
    };
    let positions: Vec<_> =
        (0..4).flat_map(|ring| (0..AROUND).map(move |i| corner(ring, i))).collect();
    let mut indices = Vec::new();
    for ring in 0..3 {
        for i in (0..AROUND).filter(|i| ring != 1 || !(8..=12).contains(i)) {
            let (a, b) = (ring * AROUND + i, ring * AROUND + (i + 1) % AROUND);
            indices.extend([[a, b, a + AROUND], [b, b + AROUND, a + AROUND]]);
        }
    }
    json!({ "shape": { "kind": "mesh", "positions": positions, "indices": indices } })
}

fn tube() -> Trial {
    let scene = json!({
        "camera": { "position": [0, 1.4, 2.8], "target": [0, 1.5, -2] },
        "surfaces": [pipe()], "lights": [sun([-0.2, -1.0, -0.1], 20.0)],
        "fog": mist(0.3), "far_m": 30 });
    Trial::new("shaft", "a shaft through a hole in a dense tube", scene)
}

fn lit_tube() -> Trial {
    let scene = json!({
        "camera": { "position": [6, 5.5, 6], "target": [0, 1.5, -2] },
        "surfaces": [pipe(), floor()], "lights": [point([0.0, 1.5, -3.5], 50.0)],
        "fog": smoke(6, 30), "far_m": 60 });
    Trial::new("lantern", "a lamp in the same tube, seen from outside", scene)
}

fn sixteen() -> Trial {
    let lamp = |i: u32| {
        let x = 0.55 * f64::from(i) - 4.0;
        point([x, 0.5 + 0.2 * f64::from(i % 5), 0.3 * f64::from(i % 7) - 3.0], 20.0)
    };
    let lights: Vec<_> = (0..16).map(lamp).collect();
    trial("sixteen", "sixteen lamps behind a fence", pickets(0.6), json!(lights), smoke(7, 30))
}

fn four_groups() -> Trial {
    let scattering = |term: Value, g: f64, albedo: f64| {
        let mut term = term;
        term["phase"] = json!({ "kind": "henyey_greenstein", "g": g });
        term["albedo"] = json!([albedo, albedo, albedo]);
        term
    };
    let blobs = |seed: u64| Random(seed).blobs(15, 4.0, [0.4, 1.5], [0.05, 0.4]);
    let terms = json!([
        scattering(homogeneous(0.02), 0.0, 0.9),
        scattering(homogeneous(0.03), 0.6, 0.8),
        scattering(blobs(8), -0.4, 1.0),
        scattering(blobs(9), 0.85, 0.9),
    ]);
    let mut surfaces = pickets(0.6);
    surfaces.push(sphere([0.0, 1.5, 0.0], 0.6));
    let lights = json!([point([1.5, 2.5, -2.0], 100.0), sun([0.4, -1.0, 0.5], 2.0)]);
    trial(
        "four-groups",
        "four groups of phase before a lamp and the sun",
        surfaces,
        lights,
        json!({ "terms": terms }),
    )
}

fn headlight() -> Trial {
    let lights = json!([spot([0.0, 2.0, -4.0], [0.0, -0.2, 1.0], 20.0, 30.0)]);
    trial("headlight", "a cone through a fence", pickets(0.3), lights, smoke(10, 30))
}

fn seen_in_parallel(mut trial: Trial) -> Trial {
    trial.scene["camera"] = json!({ "position": [3, 4, 8], "target": [0, 1, 0],
        "projection": { "kind": "orthographic", "height_m": 7 } });
    trial
}

fn drawing() -> Trial {
    let lights = json!([point([0.3, 1.0, -3.0], 100.0)]);
    seen_in_parallel(trial(
        "drawing",
        "a fence in parallel projection",
        pickets(0.3),
        lights,
        mist(0.08),
    ))
}

fn drawing_in_sun() -> Trial {
    let lights = json!([sun([0.4, -1.0, 0.5], 5.0)]);
    seen_in_parallel(trial("drawing-sun", "the same in the sun", pickets(0.3), lights, mist(0.08)))
}
