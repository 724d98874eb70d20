//! Ten scenes chosen to break an airlight estimator, and the exact scenes.

use crate::cases;
use crate::scenes::{Random, homogeneous, pixel_rays, probe, render, scene, view};
use fogbank_core::request::{Layer, Quality, View};
use fogbank_core::scene::{CheckedScene, Scene};
use fogbank_core::{Frame, presets};
use glam::DVec3;
use serde_json::{Value, json};

/// A scene with the name under which its errors are listed.
#[derive(Clone, Debug)]
pub struct Trial {
    /// A word for tables.
    pub name: String,
    /// What is hard about it.
    pub title: String,
    /// The scene.
    pub scene: Value,
}

impl Trial {
    pub(crate) fn new(name: &str, title: &str, scene: Value) -> Self {
        Self { name: name.into(), title: title.into(), scene }
    }
}

/// The eleven scenes with exact rays.
pub fn exact() -> Vec<Trial> {
    let trial = |entry: &Value| {
        let text = |key: &str| entry[key].as_str().unwrap_or_default().to_owned();
        Trial { name: text("name"), title: text("title"), scene: entry["scene"].clone() }
    };
    cases::scenes().iter().map(trial).collect()
}

/// Relative errors of some pixels: median, 95th percentile, the largest.
pub type Errors = [f64; 3];

/// What a picture of a trial is off by.
#[derive(Clone, Copy, Debug)]
pub struct Measured {
    /// Over pixels spread over the picture.
    pub everywhere: Errors,
    /// Within a tenth of the picture's height of a lamp's image, if one is in view.
    pub near_lamps: Option<Errors>,
    /// By how much the error jumps from pixel to pixel where tiles meet.
    pub seams: Errors,
}

/// What a picture is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Use {
    /// Its numbers: a float format.
    Numbers,
    /// The eye: 8 bits.
    Screen,
    /// The eye, in motion.
    Draft,
}

/// Pixels along the side of a tile of the renderer.
const TILE: u32 = 16;

impl Trial {
    /// The errors of one estimator's picture, `height` pixels high and 4:3, against `reference`
    /// along the rays of `count` pixels each: |a − b| / max(b, 1e-3 · mean b) of the luminance.
    pub fn measure(&self, airlight: &str, wanted: Use, height: u32, count: usize) -> Measured {
        let with = |airlight: &str| {
            let mut json = self.scene.clone();
            json["fog"]["airlight"] = airlight.into();
            scene(&json)
        };
        let (asked, exact) = (with(airlight), with("reference"));
        let width = height * 4 / 3;
        let quality = if wanted == Use::Draft { Quality::Draft } else { Quality::Full };
        let view = view(width, height, Layer::Airlight, quality);
        let frame = render(&asked, &View { for_screen: wanted != Use::Numbers, ..view });
        let mut random = Random(5);
        let all = (width * height) as usize;
        let even: Vec<_> = (0..count).map(|_| random.bits() as usize % all).collect();
        let near = near_lamps(&exact, width, height, count, &mut random);
        let rays = pixel_rays(&exact, width, height);
        let errors = |pixels: &[usize]| {
            let some: Vec<_> = pixels.iter().map(|at| rays[*at]).collect();
            let truth: Vec<_> =
                probe(&exact, &some).iter().map(|answer| luminance(answer.airlight.0)).collect();
            signed_errors(pixels.iter().map(|at| luminance_at(&frame, *at)), &truth, DARK)
        };
        let measure =
            |pixels: &[usize]| quantiles(errors(pixels).into_iter().map(f64::abs).collect());
        let seams = errors(&at_seams(width, height, count / 2, &mut random));
        Measured {
            everywhere: measure(&even),
            near_lamps: (!near.is_empty()).then(|| measure(&near)),
            seams: quantiles(seams.chunks(2).map(|pair| (pair[0] - pair[1]).abs()).collect()),
        }
    }
}

/// Prints how far a picture by `auto` is off on so many rays, and fails where that is more than a median and a 95th
/// percentile allow.
///
/// # Panics
/// Then.
pub fn stays_within(
    trial: &Trial,
    wanted: Use,
    (height, count): (u32, usize),
    [median, p95]: [f64; 2],
) {
    let [m, p, most] = trial.measure("auto", wanted, height, count).everywhere;
    println!("{:12} {wanted:?}: median {m:.4}, p95 {p:.4}, most {most:.3}", trial.name);
    assert!(m <= median && p <= p95, "{} {wanted:?}: median {m:.4}, p95 {p:.4}", trial.name);
}

/// Pairs of neighbours on either side of a border between tiles.
fn at_seams(width: u32, height: u32, count: usize, random: &mut Random) -> Vec<usize> {
    let mut pairs = Vec::new();
    while pairs.len() < 2 * count {
        let (x, y) = (random.bits() as u32 % width, random.bits() as u32 % height);
        let (x, y, next) = if random.bits().is_multiple_of(2) {
            (x / TILE * TILE, y, 1)
        } else {
            (x, y / TILE * TILE, width)
        };
        let at = y * width + x;
        if (if next == 1 { x } else { y }) > 0 {
            pairs.extend([(at - next) as usize, at as usize]);
        }
    }
    pairs
}

/// What is darker than this share of the mean counts as that bright: nobody sees more of it beside the rest.
pub const DARK: f64 = 1e-3;

/// By how much some values are too bright, relative to exact ones or to `dark` times their mean.
pub fn signed_errors(values: impl Iterator<Item = f64>, exact: &[f64], dark: f64) -> Vec<f64> {
    let floor = dark * exact.iter().sum::<f64>() / exact.len() as f64;
    let error = |(a, b): (f64, &f64)| (a - b) / b.max(floor).max(f64::MIN_POSITIVE);
    values.zip(exact).map(error).collect()
}

/// The luminance of a pixel of a frame of three channels.
pub fn luminance_at(frame: &Frame, at: usize) -> f64 {
    luminance([0, 1, 2].map(|k| f64::from(frame.pixels[3 * at + k])))
}

/// Of linear Rec. 709.
pub fn luminance([r, g, b]: [f64; 3]) -> f64 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// Median, 95th percentile and largest of some errors.
pub fn quantiles(mut errors: Vec<f64>) -> Errors {
    errors.sort_unstable_by(f64::total_cmp);
    let last = errors.len() - 1;
    [0.5, 0.95, 1.0].map(|share| errors[(last as f64 * share) as usize])
}

/// Pixels around the lamps' images, as many at each distance, in the logarithm.
fn near_lamps(
    scene: &CheckedScene,
    width: u32,
    height: u32,
    count: usize,
    random: &mut Random,
) -> Vec<usize> {
    let rays = pixel_rays(scene, width, height);
    let mut near = Vec::new();
    for (_, lit) in scene.lamps() {
        let image = |ray: usize| {
            let to: DVec3 = lit.source.place() - rays[ray].origin;
            to.normalize().dot(rays[ray].direction)
        };
        let closest = (0..rays.len()).max_by(|a, b| image(*a).total_cmp(&image(*b))).unwrap_or(0);
        let (x, y) = ((closest as u32 % width) as f64, (closest as u32 / width) as f64);
        let at_rim =
            x < 1.0 || y < 1.0 || x > f64::from(width) - 2.0 || y > f64::from(height) - 2.0;
        for _ in 0..if at_rim { 0 } else { count } {
            let (radius, angle) = (
                random.decades(0.5, 0.1 * f64::from(height)),
                random.between(0.0, std::f64::consts::TAU),
            );
            let (x, y) = (x + radius * angle.cos() + 0.5, y + radius * angle.sin() + 0.5);
            if x >= 0.0 && y >= 0.0 && x < f64::from(width) && y < f64::from(height) {
                near.push(y as usize * width as usize + x as usize);
            }
        }
    }
    near
}

/// All lists.
pub fn all() -> Vec<Trial> {
    let others = exact().into_iter().chain(hard()).chain(layered()).chain(smoke());
    others.chain(families()).chain(sunlit()).map(unshaded).collect()
}

/// These trials are about fog: nothing hides its light. Of shadows there are others.
fn unshaded(mut trial: Trial) -> Trial {
    for light in trial.scene["lights"].as_array_mut().into_iter().flatten() {
        light["shadows"] = false.into();
    }
    trial
}

/// Scenes of the other lists by daylight: the sun, and in one of them a lamp as well, through every medium.
pub fn sunlit() -> Vec<Trial> {
    const LIT: [(&str, [f64; 3]); 9] = [
        ("two-layers", [0.4, -1.0, -0.3]),
        ("exponential", [0.6, -0.25, 0.5]),
        ("three-lamps", [0.3, -0.8, 0.5]),
        ("hg-forward", [-0.05, -0.35, 1.0]),
        ("coloured-smoke", [-0.6, -0.7, 0.1]),
        ("waves", [0.3, -1.0, 0.2]),
        ("steps", [0.7, -0.4, 0.2]),
        ("map-thinning", [-0.5, -0.6, 0.4]),
        ("all-media", [0.3, -0.7, 0.5]),
    ];
    let others = hard().into_iter().chain(layered()).chain(smoke()).chain(families());
    let lit = |mut trial: Trial| {
        let (_, direction) = LIT.iter().find(|(name, _)| *name == trial.name)?;
        let sun = json!({ "kind": "sun", "direction": direction, "irradiance": [3.0, 2.8, 2.4], "shadows": false });
        let mut lights = vec![sun];
        if trial.name == "three-lamps" {
            lights.extend(trial.scene["lights"].as_array()?.first().cloned());
        }
        trial.scene["lights"] = lights.into();
        trial.scene["fog"]["light_path_m"] = json!(15);
        Some(Trial::new(
            &format!("sun-{}", trial.name),
            &format!("{}, by daylight", trial.title),
            trial.scene,
        ))
    };
    others.filter_map(lit).collect()
}

/// Waves, polynomials, fog around objects and maps of all degrees, alone and in sums, with edges and without.
pub fn families() -> Vec<Trial> {
    let scene = |terms: Value, lamps: &[[f64; 3]], position: [f64; 3]| {
        let lamps: Vec<_> = lamps.iter().map(|at| lamp(*at, [40.0, 34.0, 24.0])).collect();
        json!({
            "camera": camera(position, [0.0, 1.0, 0.0]),
            "surfaces": [{ "shape": { "kind": "plane" } },
                { "shape": { "kind": "sphere", "center": [1.2, 0.8, 0], "radius": 0.8 } }],
            "lights": lamps, "fog": { "terms": terms }, "far_m": 200 })
    };
    let functions = |scale: f64, members: Value| json!({ "kind": "functions", "scale": scale, "members": members });
    let wave = |amplitude: f64, k: [f64; 3]| json!({ "kind": "cosine", "amplitude": amplitude, "wave_vector": k });
    let layers = functions(
        0.1,
        json!([
            wave(1.0, [0.0; 3]),
            wave(0.5, [0.0, 15.7, 0.0]),
            wave(0.2, [2.2, 22.0, 0.0]),
            wave(0.2, [-0.8, 15.7, 0.0]),
            wave(0.1, [3.1, 0.0, 1.6])
        ]),
    );
    let slopes = functions(
        0.2,
        json!([{ "kind": "polynomial", "period_m": [3, null, 4],
        "monomials": [{ "powers": [2, 0, 1], "coefficient": 1 }] }]),
    );
    let boxed = functions(
        0.3,
        json!([{ "kind": "polynomial", "repeat": false, "period_m": [6, 4, 6],
        "monomials": [{ "powers": [0, 0, 0], "coefficient": 0.6 }, { "powers": [1, 1, 0], "coefficient": 1 }] }]),
    );
    let objects = functions(
        1.0,
        json!([
            { "kind": "equipotential", "strength": 0.3, "object": { "kind": "point", "position": [-1.5, 1, 0] } },
            { "kind": "equipotential", "strength": 0.2, "d": 6,
              "object": { "kind": "line", "position": [0, 0.3, -2], "direction": [1, 0, 0.2] } },
            { "kind": "equipotential", "strength": -0.05, "d": 4,
              "object": { "kind": "sphere", "center": [1.2, 0.8, 0], "radius": 1 } },
        ]),
    );
    let map = |degree: u32, scale: Value, vertical: Value| {
        let value = |i: usize, j: usize| ((i * 37 + j * 61) % 11) as f64 / 10.0;
        let rows: Vec<Vec<_>> = (0..12).map(|j| (0..12).map(|i| value(i, j)).collect()).collect();
        json!({ "kind": "fogmap", "degree": degree, "origin": [-8, -9], "cell_m": 1.3,
            "scale": scale, "coefficients": rows, "vertical": vertical })
    };
    let (even, slab) =
        (json!({ "kind": "uniform" }), json!({ "kind": "slab", "min_m": 0, "max_m": 1.4 }));
    let thinning = json!({ "kind": "exponential", "base_m": 0.4, "falloff_per_m": 0.8 });
    let blobs = json!({ "kind": "gaussians", "albedo": [0.9, 0.5, 0.3], "blobs": [
        { "center": [-1, 0.6, 0], "radius": 1.2, "extinction": 0.5 },
        { "center": [1.5, 1, -2], "radius": 0.7, "extinction": 0.9 } ] });
    let (low, high) = ([-0.5, 0.8, 1.0], [-0.5, 2.8, 1.0]);
    let (within, above) = ([0.0, 1.0, 8.0], [0.0, 2.2, 8.0]);
    vec![
        Trial::new(
            "waves",
            "fine waves of fog around a lamp",
            scene(json!([layers]), &[low], within),
        ),
        Trial::new(
            "waves-blobs",
            "the same with two blobs of another colour",
            scene(json!([layers, blobs]), &[high], above),
        ),
        Trial::new(
            "slopes",
            "a polynomial that jumps from period to period",
            scene(json!([slopes, haze(0.01)]), &[low], above),
        ),
        Trial::new(
            "boxed",
            "a polynomial in a box around a lamp",
            scene(json!([boxed]), &[low], above),
        ),
        Trial::new(
            "objects",
            "fog around a point, a line and, taken away, a sphere",
            scene(json!([haze(0.06), objects]), &[high, [2.0, 0.7, -3.0]], above),
        ),
        Trial::new(
            "steps",
            "a map of steps around a lamp",
            scene(json!([map(0, json!(0.2), even.clone())]), &[low], above),
        ),
        Trial::new(
            "map-slab",
            "a map of slopes in a layer below a lamp",
            scene(json!([map(1, json!(0.3), slab)]), &[high], above),
        ),
        Trial::new(
            "map-thinning",
            "a smooth map that thins out, in haze",
            scene(json!([map(2, json!(0.3), thinning), haze(0.01)]), &[low], within),
        ),
        Trial::new(
            "all-media",
            "a map, waves and blobs that scatter in ways of their own",
            scene(
                json!([map(1, json!(0.1), even.clone()), layers, blobs]),
                &[low, [3.0, 3.0, -2.0]],
                above,
            ),
        ),
        Trial::new(
            "coloured-map",
            "a map of another extinction in each channel",
            scene(json!([map(2, json!([0.1, 0.2, 0.4]), even)]), &[high], within),
        ),
    ]
}

/// Fog whose terms scatter in ways of their own: smoke of two colours and two phases between two lamps,
/// grey, and of another extinction in each channel.
pub fn smoke() -> Vec<Trial> {
    let blob = |at: [f64; 3], radius: f64, extinction: Value| json!({ "center": at, "radius": radius, "extinction": extinction });
    let scene = |haze: Value, first: Value| {
        let red = json!({ "kind": "gaussians", "albedo": [0.9, 0.3, 0.2],
            "phase": { "kind": "henyey_greenstein", "g": 0.6 },
            "blobs": [blob([-2.0, 1.0, 0.0], 1.1, first), blob([-1.2, 1.8, -1.0], 0.8, json!(0.6))] });
        let blue = json!({ "kind": "gaussians", "albedo": [0.2, 0.4, 0.9],
            "blobs": [blob([1.6, 1.4, -1.5], 1.2, json!(0.9)), blob([0.4, 0.7, 1.0], 0.6, json!(0.7))] });
        json!({
            "camera": camera([0.0, 1.7, 8.0], [0.0, 1.2, 0.0]),
            "surfaces": [{ "shape": { "kind": "plane" } },
                { "shape": { "kind": "sphere", "center": [1.2, 0.8, 0], "radius": 0.8 } }],
            "lights": [lamp([-0.5, 2.6, 1.0], [40.0, 34.0, 24.0]), lamp([3.0, 3.0, -2.0], [10.0, 20.0, 30.0])],
            "fog": { "terms": [{ "kind": "homogeneous", "extinction": haze }, red, blue] },
            "far_m": 60 })
    };
    vec![
        Trial::new(
            "smoke",
            "smoke of two colours and phases in haze",
            scene(json!(0.02), json!(0.8)),
        ),
        Trial::new(
            "coloured-smoke",
            "the same, of a coloured extinction",
            scene(json!([0.01, 0.02, 0.04]), json!([0.2, 0.5, 1.2])),
        ),
    ]
}

/// Six scenes of fog that changes with height.
pub fn layered() -> Vec<Trial> {
    let layer = |extinction: f64, vertical: Value| json!({ "kind": "homogeneous", "extinction": extinction, "vertical": vertical });
    let slab = |extinction: f64, min: f64, max: f64| {
        layer(extinction, json!({ "kind": "slab", "min_m": min, "max_m": max }))
    };
    let (ground, cloud) = (slab(0.15, 0.0, 1.5), slab(0.05, 3.0, 6.0));
    let thinning = json!({ "kind": "exponential", "base_m": 0.5, "falloff_per_m": 0.6 });
    let thinning = layer(0.1, thinning);
    let blobs = json!({ "kind": "gaussians", "blobs": [
        { "center": [-1, 0.6, 0], "radius": 1.2, "extinction": 0.5 },
        { "center": [1.5, 1, -2], "radius": 0.7, "extinction": 0.9 } ] });
    let scene = |terms: Value, lamps: &[[f64; 3]], position: [f64; 3], far_m: f64| {
        let lamp =
            |at: &[f64; 3]| json!({ "kind": "point", "position": at, "intensity": [40, 34, 24] });
        json!({
            "camera": camera(position, [0.0, 1.0, 0.0]),
            "surfaces": [{ "shape": { "kind": "plane" } },
                { "shape": { "kind": "sphere", "center": [1.2, 0.8, 0], "radius": 0.8 } }],
            "lights": lamps.iter().map(lamp).collect::<Vec<_>>(),
            "fog": { "terms": terms }, "far_m": far_m })
    };
    let (low, high, within) = ([-0.5, 0.8, 1.0], [-0.5, 2.8, 1.0], [0.0, 1.0, 8.0]);
    let above = [0.0, 2.2, 8.0];
    vec![
        Trial::new(
            "slab-lamp-in",
            "ground fog around a lamp, seen from above it",
            scene(json!([ground]), &[low], above, 60.0),
        ),
        Trial::new(
            "slab-camera-in",
            "ground fog under a lamp, seen from within",
            scene(json!([ground]), &[high], within, 60.0),
        ),
        Trial::new(
            "slab-lamp-below",
            "a cloud above a lamp and the camera",
            scene(json!([cloud]), &[low], within, 200.0),
        ),
        Trial::new(
            "exponential",
            "fog that thins out under an open sky",
            scene(json!([thinning]), &[low], above, 10_000.0),
        ),
        Trial::new(
            "two-layers",
            "ground fog, a cloud and haze between two lamps",
            scene(
                json!([ground, cloud, homogeneous(0.01)]),
                &[high, [2.0, 0.7, -3.0]],
                above,
                60.0,
            ),
        ),
        Trial::new(
            "layers-blobs",
            "blobs in ground fog that thins out",
            scene(json!([ground, thinning, blobs]), &[low, [3.0, 4.0, -2.0]], above, 60.0),
        ),
    ]
}

/// The ten scenes.
pub fn hard() -> Vec<Trial> {
    vec![
        two_clouds(),
        thin_sheet(),
        opaque_blob(),
        three_lamps(),
        tiny_blobs(),
        lamp_at_a_wall(),
        glow("forward", 0.8),
        glow("backward", -0.8),
        inside_a_dense_blob(),
        preset("city-353", "a city street at night"),
        preset("room-3008", "3 008 blobs around the camera"),
    ]
}

fn preset(name: &str, title: &str) -> Trial {
    let found = presets::all().into_iter().find(|preset| preset.name == name);
    let scene = found.map_or_else(Scene::default, |preset| preset.scene);
    Trial::new(name, title, serde_json::to_value(scene).unwrap_or_default())
}

fn camera(position: [f64; 3], target: [f64; 3]) -> Value {
    json!({ "position": position, "target": target,
        "projection": { "kind": "perspective", "vertical_fov_deg": 50 } })
}

fn lamp(position: [f64; 3], intensity: [f64; 3]) -> Value {
    json!({ "kind": "point", "position": position, "intensity": intensity, "shadows": false })
}

fn haze(extinction: f64) -> Value {
    json!({ "kind": "homogeneous", "extinction": extinction })
}

fn cloud(random: &mut Random, count: usize, center: [f64; 3], half: f64, look: [f64; 4]) -> Value {
    let [small, large, thin, dense] = look;
    let blobs: Vec<_> = (0..count)
        .map(|_| {
            let offset = random.point(half).to_array();
            let center = [0, 1, 2].map(|i| center[i] + offset[i]);
            json!({ "center": center, "radius": random.decades(small, large),
                "extinction": random.decades(thin, dense) })
        })
        .collect();
    json!({ "kind": "gaussians", "blobs": blobs })
}

fn floor() -> Value {
    json!({ "shape": { "kind": "plane", "point": [0, -1, 0], "normal": [0, 1, 0] } })
}

/// Two small clouds far apart on every ray, the lamp between them.
fn two_clouds() -> Trial {
    let mut random = Random(21);
    let near = cloud(&mut random, 12, [0.0, 0.0, 4.0], 0.5, [0.3, 0.6, 0.2, 0.8]);
    let far = cloud(&mut random, 12, [0.0, 0.0, -12.0], 1.5, [0.5, 1.2, 0.2, 0.8]);
    Trial::new(
        "two-clouds",
        "two clouds with clear air between, the lamp in the gap",
        json!({ "camera": camera([0.0, 0.3, 8.0], [0.0, 0.0, -4.0]),
            "lights": [lamp([0.6, 0.8, -3.0], [10.0, 10.0, 10.0])],
            "fog": { "terms": [near, far] }, "far_m": 60 }),
    )
}

/// A sheet of flat fog, many times thinner than the distance to it.
fn thin_sheet() -> Trial {
    let mut random = Random(22);
    let blobs: Vec<_> = (0..400)
        .map(|i| {
            let (x, z) = (f64::from(i % 20) - 9.5, f64::from(i / 20) - 9.5);
            json!({ "center": [x + random.between(-0.2, 0.2), 0.0, z + random.between(-0.2, 0.2)],
                "radius": 0.6, "extinction": random.between(0.3, 0.6) })
        })
        .collect();
    Trial::new(
        "thin-sheet",
        "a sheet of fog above a floor, seen at a low angle",
        json!({ "camera": camera([0.0, 1.6, 14.0], [0.0, 0.0, 0.0]), "surfaces": [floor()],
            "lights": [lamp([1.0, 1.2, 2.0], [20.0, 18.0, 15.0])],
            "fog": { "terms": [{ "kind": "gaussians", "blobs": blobs }] }, "far_m": 60 }),
    )
}

/// One blob that nothing passes.
fn opaque_blob() -> Trial {
    Trial::new(
        "opaque-blob",
        "one blob of optical depth 35 in thin haze, lit from the side",
        json!({ "camera": camera([0.0, 0.0, 8.0], [0.0, 0.0, 0.0]),
            "lights": [lamp([2.5, 1.5, 1.5], [10.0, 10.0, 10.0])],
            "fog": { "terms": [haze(0.01), { "kind": "gaussians", "blobs": [
                { "center": [0, 0, 0], "radius": 1, "extinction": 20 }] }] }, "far_m": 30 }),
    )
}

/// Three lamps of different colours and distances, all in view.
fn three_lamps() -> Trial {
    let mut random = Random(24);
    Trial::new(
        "three-lamps",
        "three coloured lamps in patchy fog, one inside a blob",
        json!({ "camera": camera([0.0, 1.0, 9.0], [0.0, 0.0, 0.0]), "surfaces": [floor()],
            "lights": [lamp([-2.0, 0.4, 1.0], [10.0, 1.0, 0.5]), lamp([1.5, 1.2, -1.0], [0.5, 8.0, 1.0]),
                lamp([0.4, 0.2, 3.0], [0.4, 1.0, 9.0])],
            "fog": { "terms": [haze(0.02), cloud(&mut random, 60, [0.0, 0.3, 0.0], 3.0, [0.4, 1.2, 0.05, 0.5])] },
            "far_m": 40 }),
    )
}

/// Blobs a few pixels wide.
fn tiny_blobs() -> Trial {
    let mut random = Random(25);
    Trial::new(
        "tiny-blobs",
        "1 000 blobs a few pixels wide in thin haze",
        json!({ "camera": camera([0.0, 0.0, 8.0], [0.0, 0.0, 0.0]),
            "lights": [lamp([1.5, 1.0, 1.0], [10.0, 10.0, 10.0])],
            "fog": { "terms": [haze(0.01), cloud(&mut random, 1000, [0.0; 3], 3.0, [0.03, 0.08, 0.5, 3.0])] },
            "far_m": 30 }),
    )
}

/// A lamp 1 cm from the wall that ends the rays.
fn lamp_at_a_wall() -> Trial {
    let mut random = Random(26);
    Trial::new(
        "lamp-at-wall",
        "a lamp 1 cm from a wall",
        json!({ "camera": camera([0.0, 0.5, 6.0], [0.0, 0.3, 0.0]),
            "surfaces": [{ "shape": { "kind": "plane", "point": [0, 0, -1], "normal": [0, 0, 1] } }, floor()],
            "lights": [lamp([0.5, 0.6, -0.99], [5.0, 4.0, 3.0])],
            "fog": { "terms": [haze(0.05), cloud(&mut random, 20, [0.0, 0.5, 1.0], 2.0, [0.5, 1.5, 0.05, 0.3])] } }),
    )
}

/// Scattering in a narrow cone.
fn glow(name: &str, g: f64) -> Trial {
    let mut random = Random(27);
    Trial::new(
        &format!("hg-{name}"),
        &format!("Henyey–Greenstein scattering, g = {g}, lamp and fog before the camera"),
        json!({ "camera": camera([0.0, 1.0, 9.0], [0.0, 0.5, 0.0]), "surfaces": [floor()],
            "lights": [lamp([0.5, 1.2, -2.0], [10.0, 9.0, 8.0])],
            "fog": { "phase": { "kind": "henyey_greenstein", "g": g },
                "terms": [haze(0.03), cloud(&mut random, 40, [0.0, 0.5, 0.0], 4.0, [0.6, 1.6, 0.05, 0.4])] },
            "far_m": 60 }),
    )
}

/// The camera deep inside a dense blob.
fn inside_a_dense_blob() -> Trial {
    Trial::new(
        "inside-dense",
        "the camera inside a blob of optical depth 11, the lamp outside",
        json!({ "camera": camera([0.3, 0.2, 0.5], [0.0, 0.0, -3.0]),
            "lights": [lamp([0.5, 0.8, -3.0], [50.0, 50.0, 50.0])],
            "fog": { "terms": [haze(0.01), { "kind": "gaussians", "blobs": [
                { "center": [0, 0, 0], "radius": 1.5, "extinction": 4 },
                { "center": [0.5, 0, -3], "radius": 1, "extinction": 0.5 }] }] }, "far_m": 30 }),
    )
}
