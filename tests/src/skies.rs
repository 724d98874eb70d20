//! Scenes under skies.

use crate::scenes::{Random, homogeneous};
use crate::trials::Trial;
use serde_json::{Value, json};

/// All of them.
pub fn skies() -> Vec<Trial> {
    vec![
        trial("even", "an even sky over even fog", even(), homogeneous(0.02).into_fog()),
        trial("cloud", "an even sky around a cloud", even(), cloud().into_fog()),
        trial("patches", "a blue sky over patchy fog", blue(), smoke(1, 12).into_fog()),
        trial("many", "the same over many patches", blue(), smoke(2, 150).into_fog()),
        trial("haze", "patches in haze", blue(), vec![blobs(3, 12), homogeneous(0.01)].into_fog()),
        trial(
            "glow",
            "a bright side of the sky, forward scattering",
            dawn(),
            forward(smoke(4, 12), 0.6),
        ),
        trial("dense", "dense smoke before a bright side", dawn(), thick().into_fog()),
        trial(
            "slab",
            "a layer of ground fog",
            blue(),
            layer(json!({ "kind": "slab", "min_m": 0, "max_m": 4 })),
        ),
        trial(
            "thinning",
            "fog that thins out upwards",
            blue(),
            layer(json!({ "kind": "exponential", "base_m": 0.5, "falloff_per_m": 0.5 })),
        ),
        trial("map", "a map of fog", blue(), map().into_fog()),
        trial("waves", "waves of fog", blue(), near_end(waves())),
        trial("groups", "coloured smoke in white haze", blue(), groups()),
    ]
}

fn trial(name: &str, title: &str, radiance: Value, fog: Value) -> Trial {
    let ball = json!({ "shape": { "kind": "sphere", "center": [0, 1, 0], "radius": 1 } });
    let scene = json!({
        "camera": { "position": [0, 1.7, 9], "target": [0, 1.5, 0] },
        "surfaces": [{ "shape": { "kind": "plane" } }, ball],
        "lights": [{ "kind": "environment", "radiance": radiance }],
        "fog": fog, "far_m": 80
    });
    Trial::new(name, title, scene)
}

/// What can be a scene's fog.
trait IntoFog {
    fn into_fog(self) -> Value;
}

impl IntoFog for Value {
    fn into_fog(self) -> Value {
        vec![self].into_fog()
    }
}

impl IntoFog for Vec<Value> {
    fn into_fog(self) -> Value {
        json!({ "terms": self })
    }
}

fn even() -> Value {
    json!({ "kind": "uniform", "rgb": [0.3, 0.4, 0.5] })
}

fn blue() -> Value {
    json!({ "kind": "gradient", "zenith": [0.2, 0.4, 0.9], "horizon": [0.9, 0.9, 0.9], "ground": [0.15, 0.12, 0.1] })
}

/// Bright towards −z, dark behind.
fn dawn() -> Value {
    json!({ "kind": "spherical_harmonics", "coefficients": [
        [4, 4.5, 5.5], [0.5, 0.6, 0.9], [-3, -2.4, -1.5], [0.4, 0.3, 0.1],
        [0, 0, 0], [-0.3, -0.2, -0.1], [1.2, 0.8, 0.4], [0.2, 0.1, 0], [0.1, 0, 0]] })
}

fn blobs(seed: u64, count: usize) -> Value {
    Random(seed).blobs(count, 5.0, [0.8, 2.0], [0.05, 0.5])
}

fn smoke(seed: u64, count: usize) -> Value {
    blobs(seed, count)
}

fn cloud() -> Value {
    json!({ "kind": "gaussians", "blobs": [{ "center": [0, 1.5, 0], "radius": 3, "extinction": 0.4 }] })
}

fn thick() -> Value {
    Random(7).blobs(6, 4.0, [1.0, 2.0], [0.5, 3.0])
}

fn forward(term: Value, g: f64) -> Value {
    json!({ "terms": [term], "phase": { "kind": "henyey_greenstein", "g": g } })
}

fn layer(vertical: Value) -> Value {
    json!({ "terms": [{ "kind": "homogeneous", "extinction": 0.12, "vertical": vertical }] })
}

fn map() -> Value {
    let mut random = Random(5);
    let row = |random: &mut Random| (0..14).map(|_| random.between(0.0, 1.0)).collect::<Vec<_>>();
    let rows: Vec<_> = (0..14).map(|_| row(&mut random)).collect();
    json!({ "kind": "fogmap", "degree": 2, "origin": [-10, -10], "cell_m": 1.5, "scale": 0.3, "coefficients": rows,
        "vertical": { "kind": "exponential", "base_m": 0.5, "falloff_per_m": 0.6 } })
}

fn waves() -> Value {
    json!({ "kind": "functions", "scale": 0.1, "members": [
        { "kind": "cosine", "amplitude": 1, "wave_vector": [0, 0, 0] },
        { "kind": "cosine", "amplitude": 0.6, "wave_vector": [0.5, 0.3, 0.4] }] })
}

/// Fog without an end: what is left of the sky comes through some metres.
fn near_end(term: Value) -> Value {
    json!({ "terms": [term], "light_path_m": 15 })
}

fn groups() -> Value {
    let mut smoke = blobs(9, 8);
    smoke["albedo"] = json!([0.9, 0.5, 0.2]);
    smoke["phase"] = json!({ "kind": "henyey_greenstein", "g": 0.4 });
    let mut haze = homogeneous(0.02);
    haze["extinction"] = json!([0.01, 0.02, 0.03]);
    json!({ "terms": [smoke, haze] })
}
