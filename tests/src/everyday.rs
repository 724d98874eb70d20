//! Random scenes of the kind that a newcomer types: some haze, a few blobs, a lamp or three, under an
//! open sky whose rays are up to 1 000 km long.

use crate::scenes::{Random, homogeneous, pixel_rays, probe, render, scene, view};
use crate::trials::{Errors, Use, luminance, luminance_at, quantiles, signed_errors};
use fogbank_core::probe::RayAnswer;
use fogbank_core::request::{Layer, Quality, View};
use fogbank_core::scene::CheckedScene;
use serde_json::{Value, json};

/// What is darker than this share of the mean counts as that bright.
const DARK: f64 = 1e-2;

/// How many scenes there are.
pub const SCENES: u64 = 48;

/// A scene by its number, the same in every run.
pub fn everyday(number: u64) -> Value {
    let mut random = Random(1000 + number);
    let mut surfaces = Vec::new();
    if !number.is_multiple_of(3) {
        surfaces.push(json!({ "shape": { "kind": "plane" } }));
    }
    if number.is_multiple_of(2) {
        let center = [random.between(-2.0, 2.0), 0.8, random.between(-4.0, 2.0)];
        surfaces.push(json!({ "shape": { "kind": "sphere", "center": center, "radius": 0.8 } }));
    }
    let phase = match number % 8 {
        3 => json!({ "kind": "henyey_greenstein", "g": 0.7 }),
        6 => json!({ "kind": "henyey_greenstein", "g": -0.4 }),
        _ => json!({ "kind": "isotropic" }),
    };
    let lamps: Vec<_> = (0..1 + number % 3).map(|_| lamp(&mut random)).collect();
    let haze = match number % 4 {
        0 => random.between(0.0, 0.1),
        1 if number % 12 == 1 => 0.0,
        _ => random.decades(1e-5, 0.1),
    };
    let blobs: Vec<_> = (0..1 + random.bits() % 5).map(|_| blob(&mut random)).collect();
    let position = [random.between(-3.0, 3.0), random.between(0.5, 3.0), random.between(5.0, 12.0)];
    let target = [random.between(-1.0, 1.0), random.between(0.3, 2.5), 0.0];
    json!({
        "camera": { "position": position, "target": target },
        "surfaces": surfaces,
        "lights": lamps,
        "fog": {
            "phase": phase,
            "terms": [homogeneous(haze), { "kind": "gaussians", "blobs": blobs }],
        },
        "far_m": random.decades(1e2, 1e6),
    })
}

fn lamp(random: &mut Random) -> Value {
    let position = [random.between(-4.0, 4.0), random.between(0.5, 5.0), random.between(-6.0, 4.0)];
    let intensity = [0; 3].map(|_| random.between(5.0, 60.0));
    json!({ "kind": "point", "position": position, "intensity": intensity, "shadows": false })
}

fn blob(random: &mut Random) -> Value {
    let center = [random.between(-4.0, 4.0), random.between(0.0, 3.0), random.between(-8.0, 3.0)];
    let (radius, extinction) = (random.between(0.4, 2.5), random.decades(0.03, 1.0));
    json!({ "center": center, "radius": radius, "extinction": extinction })
}

/// What a picture is off by, pixel by pixel.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// Relative errors.
    pub errors: Errors,
    /// The largest jump of the error between neighbours: what shows as a step.
    pub step: f64,
}

/// Every pixel of a scene's picture against the same rays, probed in f64. What is darker than a hundredth
/// of the mean counts as that bright: nobody sees more of it beside the rest.
#[derive(Debug)]
pub struct Exact {
    json: Value,
    scene: CheckedScene,
    width: u32,
    height: u32,
    luminance: Vec<f64>,
    /// Where the rays end [m].
    lengths: Vec<f64>,
}

impl Exact {
    /// Probes every pixel of a picture 4:3.
    pub fn new(json: &Value, height: u32) -> Self {
        let (scene, width) = (scene(json), height * 4 / 3);
        let rays = pixel_rays(&scene, width, height);
        let answers = probe(&scene, &rays);
        let luminance = answers.iter().map(|answer| luminance(answer.airlight.0)).collect();
        let length =
            |answer: &RayAnswer| answer.hit.as_ref().map_or(scene.far_m, |hit| hit.distance_m);
        let lengths = answers.iter().map(length).collect();
        Self { json: json.clone(), scene, width, height, luminance, lengths }
    }

    /// What the probes themselves are off by at some pixels, against the integral.
    pub fn of_probes(&self, count: usize) -> Errors {
        let mut json = self.json.clone();
        json["fog"]["airlight"] = "reference".into();
        let mut random = Random(7);
        let rays = pixel_rays(&self.scene, self.width, self.height);
        let some: Vec<_> = (0..count).map(|_| random.bits() as usize % rays.len()).collect();
        let asked: Vec<_> = some.iter().map(|at| rays[*at]).collect();
        let exact = probe(&scene(&json), &asked);
        let error = |(at, answer): (&usize, &RayAnswer)| {
            let exact = luminance(answer.airlight.0);
            (self.luminance[*at] - exact).abs() / exact.max(DARK * self.mean())
        };
        quantiles(some.iter().zip(&exact).map(error).collect())
    }

    fn mean(&self) -> f64 {
        let mean = self.luminance.iter().sum::<f64>() / self.luminance.len() as f64;
        mean.max(f64::MIN_POSITIVE)
    }

    /// What a picture for some use is off by.
    pub fn measure(&self, wanted: Use) -> Seen {
        let errors = self.signed_errors(wanted);
        Seen {
            step: self.step(&errors),
            errors: quantiles(errors.iter().map(|e| e.abs()).collect()),
        }
    }

    /// Pixels beside which a neighbour sees twice as far, or half, and those next to them.
    pub fn at_silhouettes(&self) -> Vec<usize> {
        let width = self.width as usize;
        let jumps = |a: usize, b: usize| {
            let (a, b) = (self.lengths[a], self.lengths[b]);
            a.max(b) > 2.0 * a.min(b)
        };
        let is_edge = |at: usize| {
            let (x, last) = (at % width, self.lengths.len());
            x > 0 && jumps(at, at - 1)
                || x + 1 < width && jumps(at, at + 1)
                || at >= width && jumps(at, at - width)
                || at + width < last && jumps(at, at + width)
        };
        let near = |at: &usize| {
            let (x, y) = (at % width, at / width);
            let lines = y.saturating_sub(1)..=(y + 1).min(self.height as usize - 1);
            let columns = || x.saturating_sub(1)..=(x + 1).min(width - 1);
            lines.flat_map(|y| columns().map(move |x| y * width + x)).any(is_edge)
        };
        (0..self.lengths.len()).filter(near).collect()
    }

    /// By how much each pixel of a picture for some use is too bright.
    pub fn signed_errors(&self, wanted: Use) -> Vec<f64> {
        let quality = if wanted == Use::Draft { Quality::Draft } else { Quality::Full };
        let view = view(self.width, self.height, Layer::Airlight, quality);
        let frame = render(&self.scene, &View { for_screen: wanted != Use::Numbers, ..view });
        let values = (0..self.luminance.len()).map(|at| luminance_at(&frame, at));
        signed_errors(values, &self.luminance, DARK)
    }

    fn step(&self, errors: &[f64]) -> f64 {
        let width = self.width as usize;
        let across = errors.chunks(width).flat_map(|row| row.windows(2)).map(|w| w[1] - w[0]);
        let down = errors.iter().zip(&errors[width..]).map(|(a, b)| b - a);
        across.chain(down).fold(0.0, |most, step| most.max(step.abs()))
    }
}
