//! Fog in a mountain valley, drawn as a map of splines (Giroud and Biri 2010, fig. 6): one map of 64×64
//! coefficients, and the three degrees that it may be read with.

use super::Preset;
use super::stage::{camera, fill, glossy, land, matte, round_to, sun, veil, water};
use super::village::Village;
use crate::media::fogmap::Fogmap;
use crate::random::{Random, value_noise};
use crate::scene::{Exponential, Light, Rgb, Scene, Surface, Term, Vertical};
use glam::DVec3;

/// Length of each side of the land and of the map [m].
const SIZE: f64 = 1600.0;
/// Heights along each side.
const SIDE: usize = 113;
/// Coefficients along each side of the map.
const CELLS: usize = 64;
/// Side of a cell [m].
const CELL: f64 = SIZE / CELLS as f64;
/// Level of the lake [m].
const WATER: f64 = 5.0;
/// Where the church stands: x and z, and the level of its ground [m].
const CHURCH: [f64; 3] = [30.0, 250.0, 70.0];

/// Steps, slopes, and smooth fog.
pub fn presets() -> [Preset; 3] {
    let (surfaces, map) = (surfaces(), map());
    let scene = |degree: u8| scene(surfaces.clone(), fog(degree, map.clone()));
    [
        Preset {
            name: "fogmap-steps",
            title: "Fogmap of steps",
            description: "Fog in a mountain valley, from a map of 64×64 coefficients read as steps \
                (degree 0): its cells show, as in Giroud and Biri 2010, fig. 6 B.",
            scene: scene(0),
        },
        Preset {
            name: "fogmap-slopes",
            title: "Fogmap of slopes",
            description: "The same map read as slopes (degree 1), the paper's trade-off between \
                speed and quality: Giroud and Biri 2010, fig. 6 C.",
            scene: scene(1),
        },
        Preset {
            name: "fogmap-smooth",
            title: "Smooth fogmap",
            description: "The same map read as quadratic splines (degree 2): nothing of its cells \
                is left to see, as in Giroud and Biri 2010, fig. 6 D.",
            scene: scene(2),
        },
    ]
}

fn scene(surfaces: Vec<Surface>, fog: Term) -> Scene {
    Scene {
        camera: camera([60.0, 330.0, 700.0], [40.0, 40.0, 200.0], 46.0),
        background: Rgb([0.09, 0.19, 0.42]),
        surfaces,
        lights: daylight(),
        fog: veil([1.0, 1.0, 1.0], fog),
        far_m: 4000.0,
        ..Scene::default()
    }
}

/// The sun, low from the right, and the sky, which fills the shades.
fn daylight() -> Vec<Light> {
    vec![
        sun("sun", [-0.84, -0.5, 0.2], [8.0, 6.0, 3.6]),
        fill(sun("sky", [0.35, -0.85, -0.4], [0.5, 0.75, 1.2])),
    ]
}

fn fog(degree: u8, coefficients: Vec<Vec<f64>>) -> Term {
    // A spline of each degree has its middle over the middle of its cell.
    let origin = -SIZE / 2.0 - CELL * f64::from(degree) / 2.0;
    Term::Fogmap(Fogmap {
        id: Some("valley-fog".into()),
        degree,
        origin: [origin; 2],
        cell_m: CELL,
        scale: 0.04.into(),
        coefficients: coefficients.into(),
        vertical: Vertical::Exponential(Exponential { base_m: 25.0, falloff_per_m: 0.08 }),
        ..Fogmap::default()
    })
}

/// Fog where the ground is low, in banks with gaps between them.
fn map() -> Vec<Vec<f64>> {
    /// On ground that is this high there is none [m].
    const DRY: f64 = 80.0;
    let at = |k: usize| CELL * (k as f64 + 0.5) - SIZE / 2.0;
    let coefficient = |i: usize, j: usize| {
        let (x, z) = (at(i), at(j));
        let low = 1.0 - height(x, z) / DRY;
        // Banks a few cells wide, and wisps of one or two.
        let banks = 0.62 * value_noise(x / 150.0 + 7.0, z / 150.0, 64);
        let wisps = 0.38 * value_noise(x / 60.0, z / 60.0 + 3.0, 65);
        let thick = 0.45 + 2.2 * (banks + wisps - 0.5);
        round_to((2.0 * low).clamp(0.0, 1.0) * thick.clamp(0.0, 1.0), 100.0)
    };
    (0..CELLS).map(|j| (0..CELLS).map(|i| coefficient(i, j)).collect()).collect()
}

/// Where the valley's floor runs [m].
fn valley_x(z: f64) -> f64 {
    40.0 + 120.0 * (z / 260.0 - 0.4).sin() + 45.0 * (z / 103.0).sin()
}

/// Height of the ground [m]: flat where the church stands.
fn height(x: f64, z: f64) -> f64 {
    let ground = open_ground(x, z);
    let away = (x - CHURCH[0]).hypot(z - CHURCH[1]) / 50.0;
    ground + (CHURCH[2] - ground) * (-away.powi(4)).exp()
}

/// Height of the ground without what people did to it [m].
fn open_ground(x: f64, z: f64) -> f64 {
    let from_valley = (x - valley_x(z)).abs();
    let floor = 1.0 - (-(from_valley / 300.0).powi(2)).exp();
    let (mut ridges, mut amplitude, mut frequency) = (0.0, 1.0, 1.0 / 400.0);
    for octave in 0..5 {
        let noise = value_noise(x * frequency + 13.1, z * frequency + 2.9, 110 + octave);
        // Folding the noise about its middle makes crests, a bit rounded, as the heights cannot show an edge.
        ridges += amplitude * (1.0 - (2.0 * noise - 1.0).hypot(0.12)).powi(2);
        amplitude *= 0.46;
        frequency *= 2.05;
    }
    let knolls = 30.0 * value_noise(x / 90.0, z / 90.0, 120).powi(2);
    2.0 + knolls * (1.0 - floor) + floor * (10.0 + 210.0 * ridges)
}

fn surfaces() -> Vec<Surface> {
    let mut village = Village::default();
    village.church(DVec3::new(CHURCH[0], CHURCH[2], CHURCH[1]));
    let mut random = Random::new(64);
    let grows = |foot: DVec3| {
        let slope = (height(foot.x + 5.0, foot.z) - height(foot.x - 5.0, foot.z)).abs();
        let from_church = (foot.x - CHURCH[0]).hypot(foot.z - CHURCH[1]);
        let is_near = foot.x.abs() < 420.0 && foot.z > -100.0;
        is_near && (9.0..150.0).contains(&foot.y) && slope < 9.0 && from_church > 30.0
    };
    village.grove(240, SIZE, &mut random, height, grows);
    let mut list = vec![
        land("mountains", SIZE, SIDE, 10.0, height, matte([0.13, 0.12, 0.085])),
        water("lake", SIZE, WATER, glossy([0.03, 0.07, 0.1], 0.3, 40.0)),
    ];
    list.extend(village.surfaces());
    list
}
