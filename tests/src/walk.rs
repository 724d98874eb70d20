//! A small path tracer: the light of a lamp in fog that is the same everywhere and scatters evenly into all directions,
//! scattered as often as it may be. What single scattering and its octaves are held against.

use crate::scenes::{Random, probe, scene};
use fogbank_core::request::ProbeRay;
use glam::DVec3;
use serde_json::json;
use std::f64::consts::PI;

/// Angles between the view ray and the way to the lamp at which radiance is compared [degrees].
const ANGLES: [f64; 10] = [6.0, 12.0, 20.0, 32.0, 45.0, 65.0, 90.0, 120.0, 150.0, 175.0];

/// How far models are from the tracer, at an optical distance of the lamp.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// T from the lamp to the eye.
    pub depth: f64,
    /// Root mean square of the errors of single scattering over that of the radiance.
    pub single: f64,
    /// The same of its octaves.
    pub octaves: f64,
    /// Share of the light that was scattered once.
    pub first: f64,
}

/// The unit view ray at an angle from the lamp, which stands along +Z.
fn at(angle: f64) -> DVec3 {
    let (sine, cosine) = angle.to_radians().sin_cos();
    DVec3::new(sine, 0.0, cosine)
}

/// Radiance by the program, of a lamp of 1 W/sr in fog of extinction 1/m.
fn modelled(depth: f64, octaves: u32) -> Vec<f64> {
    let json = json!({
        "lights": [{ "kind": "point", "position": [0, 0, depth], "intensity": [1, 1, 1] }],
        "fog": { "airlight": "reference", "multiple_scattering": { "octaves": octaves },
            "terms": [{ "kind": "homogeneous", "extinction": 1 }] } });
    let ray = |angle: f64| ProbeRay {
        origin: DVec3::ZERO,
        direction: at(angle),
        max_distance_m: Some(400.0),
    };
    let answers = probe(&scene(&json), &ANGLES.map(ray));
    answers.iter().map(|answer| answer.airlight.0[0]).collect()
}

/// Radiance along a view ray of light that was scattered once, and of all.
fn traced(depth: f64, angle: f64, walks: u32, random: &mut Random) -> [f64; 2] {
    let lamp = DVec3::new(0.0, 0.0, depth);
    let (mut first, mut all) = (0.0, 0.0);
    for _ in 0..walks {
        let (mut place, mut direction, mut weight) = (DVec3::ZERO, at(angle), 1.0);
        for step in 0..20_000 {
            let part = Step::new(place, direction, lamp, random);
            // Towards the lamp: the place is chosen evenly in the angle that the lamp sees.
            let seen = weight * part.lit / (4.0 * PI);
            all += seen;
            if step == 0 {
                first += seen;
            }
            place += part.length * direction;
            direction = random.direction();
            let Some((next, kept)) = returned(place, lamp, depth, random) else { break };
            (place, weight) = (next, weight * kept);
        }
    }
    [first, all].map(|sum| sum / f64::from(walks))
}

/// One free way.
struct Step {
    /// How long it is.
    length: f64,
    /// ∫ of the lamp's light on it, of which one place was looked at.
    lit: f64,
}

impl Step {
    fn new(place: DVec3, direction: DVec3, lamp: DVec3, random: &mut Random) -> Self {
        let closest = (lamp - place).dot(direction);
        let miss = (lamp - place).cross(direction).length().max(1e-9);
        let begin = (-closest / miss).atan();
        let turn = 0.5 * PI - begin;
        let angle = begin + turn * random.between(0.0, 1.0);
        let t = closest + miss * angle.tan();
        let distance = miss / angle.cos();
        // dt/d² = dα/miss.
        let lit = turn / miss * (-t - distance).exp();
        Self { length: -random.between(f64::MIN_POSITIVE, 1.0).ln(), lit }
    }
}

/// Where a walk goes on: one that went far away comes back as diffusion has it, or never.
fn returned(place: DVec3, lamp: DVec3, depth: f64, random: &mut Random) -> Option<(DVec3, f64)> {
    let near = 1.5 * depth.max(6.0);
    let distance = place.distance(lamp);
    if distance < 2.0 * near {
        return Some((place, 1.0));
    }
    let comes_back = random.between(0.0, 1.0) * distance < near;
    comes_back.then(|| (lamp + near * random.direction(), 1.0))
}

/// The errors at an optical distance, by so many walks a ray.
pub fn measure(depth: f64, walks: u32) -> Row {
    let mut random = Random(7);
    let truth: Vec<_> =
        ANGLES.iter().map(|angle| traced(depth, *angle, walks, &mut random)).collect();
    let all: Vec<f64> = truth.iter().map(|[_, all]| *all).collect();
    let size = |values: &[f64]| values.iter().map(|v| v * v).sum::<f64>().sqrt();
    let off = |model: &[f64]| {
        let errors: Vec<_> = model.iter().zip(&all).map(|(a, b)| a - b).collect();
        size(&errors) / size(&all)
    };
    let first: Vec<f64> = truth.iter().map(|[first, _]| *first).collect();
    Row {
        depth,
        single: off(&modelled(depth, 0)),
        octaves: off(&modelled(depth, 4)),
        first: first.iter().sum::<f64>() / all.iter().sum::<f64>(),
    }
}
