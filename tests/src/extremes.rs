//! Scenes out of the corners of the documented ranges, and the numbers that they answer.

use crate::scenes::Random;
use serde_json::{Value, json};

impl Random {
    /// One of some things.
    pub fn pick<T: Copy>(&mut self, things: &[T]) -> T {
        things[(self.bits() % things.len() as u64) as usize]
    }

    fn channels(&mut self, values: &[f64]) -> Value {
        json!([self.pick(values), self.pick(values), self.pick(values)])
    }
}

/// Places that things of a scene share, so that they touch: a camera on a floor, a lamp on it, at
/// the camera, at a vertex, in the middle of a blob.
struct Spots {
    size: f64,
    all: Vec<[f64; 3]>,
}

impl Spots {
    fn new(random: &mut Random) -> Self {
        let size = random.pick(&[1e-4, 1e-2, 1.0, 30.0, 1e5, 1e9]);
        let corner = random.pick(&[0.0, 0.0, 0.0, 1.0, -1.0]) * (1e9 - size);
        let point = |random: &mut Random, half: f64| {
            random.point(half).to_array().map(|x| (corner + x).clamp(-1e9, 1e9))
        };
        let mut all: Vec<_> = (0..4).map(|_| point(random, size)).collect();
        all.extend([[corner; 3], [corner, corner, corner + 0.5 * size]]);
        // Almost the same place as another.
        let near = all[0].map(|x| (x + 1e-9 * size).clamp(-1e9, 1e9));
        all.push(near);
        Self { size, all }
    }

    fn pick(&self, random: &mut Random) -> [f64; 3] {
        random.pick(&self.all)
    }
}

/// A scene with everything at its extremes, and rays for probes of it.
pub fn scene(random: &mut Random) -> (Value, Vec<Value>) {
    let spots = Spots::new(random);
    let eye = spots.pick(random);
    let bright = [0.0, 1.0, 1e12];
    let scene = json!({
        "camera": camera(random, &spots, eye),
        "background": random.channels(&bright),
        "surfaces": surfaces(random, &spots),
        "lights": (0..random.pick(&[1, 2, 3])).map(|_| json!({
            "kind": "point", "position": spots.pick(random), "intensity": random.channels(&bright),
        })).collect::<Vec<_>>(),
        "fog": fog(random, &spots),
        "far_m": random.pick(&[1e-3, 1.0, 60.0, 1e4, 1e9]),
    });
    let rays = (0..12).map(|_| ray(random, &spots, eye)).collect();
    (scene, rays)
}

fn camera(random: &mut Random, spots: &Spots, position: [f64; 3]) -> Value {
    let away = random.direction() * spots.size;
    let beyond = [0, 1, 2].map(|k| (position[k] + away[k]).clamp(-1e9, 1e9));
    let other = spots.pick(random);
    let target = if other == position || random.pick(&[true, false]) { beyond } else { other };
    let projection = match random.pick(&[0, 1]) {
        0 => {
            json!({ "kind": "perspective", "vertical_fov_deg": random.pick(&[0.1, 45.0, 179.0]) })
        }
        _ => {
            json!({ "kind": "orthographic", "height_m": random.pick(&[1e-4, 1.0, 1e8]) })
        }
    };
    let up = random.direction().to_array();
    json!({ "position": position, "target": target, "up": up, "projection": projection })
}

fn surfaces(random: &mut Random, spots: &Spots) -> Value {
    let size = spots.size.clamp(1e-4, 1e8);
    let mut surface = || {
        let at = spots.pick(random);
        let shape = match random.pick(&[0, 1, 2, 3]) {
            0 => json!({ "kind": "plane", "point": at, "normal": random.direction().to_array() }),
            1 => {
                json!({ "kind": "sphere", "center": at, "radius": random.pick(&[1e-4, size, 1e8]) })
            }
            2 => {
                let max = at.map(|x| (x + size).min(1e9).max(x.next_up()));
                json!({ "kind": "box", "min": at.map(|x| x.min(1e9f64.next_down())), "max": max })
            }
            _ => {
                let corners = [at, spots.pick(random), spots.pick(random)];
                json!({ "kind": "mesh", "positions": corners, "indices": [[0, 1, 2]] })
            }
        };
        let material = json!({
            "diffuse": random.channels(&[0.0, 1.0]),
            "specular": random.channels(&[0.0, 1.0, 1e12]),
            "shininess": random.pick(&[0.0, 1.0, 1e5]),
            "emission": random.channels(&[0.0, 1e12]),
        });
        json!({ "shape": shape, "material": material })
    };
    (0..3).map(|_| surface()).collect()
}

fn fog(random: &mut Random, spots: &Spots) -> Value {
    let size = spots.size.clamp(1e-4, 1e8);
    let extinctions = [0.0, 1e-9, 1.0 / size, 1.0, 1e6];
    let extinctions = extinctions.map(|beta| beta.min(1e6));
    let mut terms = Vec::new();
    if random.pick(&[true, false]) {
        terms.push(json!({ "kind": "homogeneous", "extinction": random.pick(&extinctions) }));
    }
    let count = random.pick(&[0, 0, 1, 3, 60]);
    if count > 0 {
        let mut blob = || {
            json!({ "center": spots.pick(random), "radius": random.pick(&[1e-4, size, size, 1e8]),
                    "extinction": random.pick(&extinctions) })
        };
        let blobs: Vec<_> = (0..count).map(|_| blob()).collect();
        terms.push(json!({ "kind": "gaussians", "blobs": blobs }));
    }
    let g = random.pick(&[0.0, 0.0, 0.99, -0.99]);
    let phase = if g == 0.0 {
        json!({ "kind": "isotropic" })
    } else {
        json!({ "kind": "henyey_greenstein", "g": g })
    };
    json!({ "terms": terms, "phase": phase, "albedo": random.channels(&[0.0, 1.0]),
            "ambient": random.channels(&[0.0, 1e12]),
            "airlight": random.pick(&["auto", "auto", "none", "sun2005", "fogshop2007", "reference"]) })
}

fn ray(random: &mut Random, spots: &Spots, eye: [f64; 3]) -> Value {
    let from = if random.pick(&[true, false]) { eye } else { spots.pick(random) };
    let to = spots.pick(random);
    let toward = [0, 1, 2].map(|k| to[k] - from[k]);
    let is_short = toward.iter().all(|x| x.abs() < 1e-100);
    let aside = random.direction() * random.pick(&[1e-100, 1.0, 1e9]);
    let direction = if is_short || random.pick(&[true, false, false]) {
        aside.to_array()
    } else {
        toward.map(|x| x.clamp(-1e9, 1e9))
    };
    let mut ray = json!({ "origin": from, "direction": direction });
    let ends = [0.0, 1e-300, 1e-9, spots.size.min(1e9), 1e9];
    if random.pick(&[true, true, false]) {
        ray["max_distance_m"] = json!(random.pick(&ends));
    }
    ray
}
