//! A countryside in daylight with the three kinds of fog of Biri and Michelin 2002, figs. 6 to 8.

use super::Preset;
use super::stage::{camera, fill, functions, glossy, land, matte, sun, veil, water, wave};
use super::village::Village;
use crate::media::functions::{
    Equipotential, Member, Monomial, Monomials, Object, Periods, PointObject, Polynomial,
};
use crate::random::{Random, value_noise};
use crate::scene::{Camera, Light, Rgb, Scene, Surface, Term, Vec3};
use glam::DVec3;
use std::f64::consts::PI;

/// Length of each side of the land [m].
const SIZE: f64 = 900.0;
/// Heights along each side: with the village about 21 200 triangles, as in the paper.
const SIDE: usize = 91;
/// Level of the brook [m].
const WATER: f64 = 1.5;
/// Where the house stands: x and z [m].
const HOUSE: [f64; 2] = [8.0, 20.0];
/// Where the church stands.
const CHURCH: [f64; 2] = [70.0, -150.0];
/// The four trees beside the house: where, and how high [m].
const TREES: [[f64; 3]; 4] =
    [[-24.0, 34.0, 15.0], [40.0, 28.0, 18.0], [24.0, -10.0, 16.0], [-32.0, -8.0, 17.0]];

/// Conifers on the slope before the eye that sees the layers: where, and how high [m].
const NEAR: [[f64; 3]; 6] = [
    [98.0, 346.0, 21.0],
    [104.0, 338.0, 15.0],
    [112.0, 330.0, 18.0],
    [158.0, 330.0, 17.0],
    [150.0, 322.0, 12.0],
    [90.0, 318.0, 14.0],
];

/// Layers, waves, and fog around trees.
pub fn presets() -> [Preset; 3] {
    let surfaces = surfaces();
    [layers(surfaces.clone()), waves(surfaces.clone()), trees(surfaces)]
}

fn layers(surfaces: Vec<Surface>) -> Preset {
    let view = camera([124.0, 83.0, 382.0], [24.0, 60.0, 0.0], 46.0);
    Preset {
        name: "valley-layers",
        title: "Layers of mist",
        description: "A church and hilltops rise from layers of mist in the morning sun: a constant \
            and the cosines of Biri and Michelin 2002, fig. 6, over a countryside of about 21 200 \
            triangles.",
        scene: countryside(view, surfaces, layers_of_mist()),
    }
}

fn waves(surfaces: Vec<Surface>) -> Preset {
    let view = camera([8.0, 17.0, 82.0], [8.0, 11.5, 20.0], 44.0);
    Preset {
        name: "valley-waves",
        title: "Waves of mist",
        description: "Two waves of mist stand left and right of a house and leave its middle clear: \
            the sum of two polynomials of Biri and Michelin 2002, fig. 7.",
        scene: countryside(view, surfaces, waves_of_mist()),
    }
}

fn trees(surfaces: Vec<Surface>) -> Preset {
    let view = camera([-44.0, 22.0, 96.0], [6.0, 12.0, 10.0], 42.0);
    Preset {
        name: "valley-trees",
        title: "Mist around trees",
        description: "Mist gathers around four trees in thin fog: equipotentials of four points, as \
            in Biri and Michelin 2002, fig. 8. Move a point, and the mist follows.",
        scene: countryside(view, surfaces, mist_around_trees()),
    }
}

fn countryside(camera: Camera, surfaces: Vec<Surface>, term: Term) -> Scene {
    Scene {
        camera,
        background: Rgb([0.07, 0.18, 0.46]),
        surfaces,
        lights: daylight(),
        fog: veil([1.05, 1.05, 1.05], term),
        far_m: 900.0,
        ..Scene::default()
    }
}

/// The sun, low from the left, and the sky, which fills the shades.
fn daylight() -> Vec<Light> {
    vec![
        sun("sun", [0.8, -0.5, -0.25], [10.0, 7.0, 3.8]),
        fill(sun("sky", [-0.42, -0.8, -0.42], [0.45, 0.65, 1.0])),
    ]
}

/// Fig. 6 in the paper's own numbers; its unit is 400 m here: one layer lies in the valley, the next
/// hides the sky, and between them the hills stand in clear air.
fn layers_of_mist() -> Term {
    const UNIT_M: f64 = 400.0;
    let member =
        |amplitude: f64, [x, y, z]: [f64; 3]| wave(amplitude, [x, y, z].map(|k| k * PI / UNIT_M));
    let members = vec![
        member(1.0, [0.0; 3]),
        member(0.5, [0.0, 5.0, 0.0]),
        member(0.2, [0.7, 7.0, 0.0]),
        member(0.2, [-0.25, 5.0, 0.0]),
        // cos(πx) cos(πz/2)/10 is the half sum of two waves.
        member(0.05, [1.0, 0.0, 0.5]),
        member(0.05, [1.0, 0.0, -0.5]),
    ];
    functions("layers", 0.0022, members)
}

/// Fig. 7: c − u + u⁴ along x and along z, the same at both borders of a period, u = 0 and 1. The paper's c is 0.8; with
/// 0.48 next to nothing is left between the waves, where u is 0.63.
fn waves_of_mist() -> Term {
    let along = |axis: usize, period: f64| {
        let mut period_m = [None; 3];
        period_m[axis] = Some(period);
        let monomial = |power: u8, coefficient: f64| {
            let mut powers = [0; 3];
            powers[axis] = power;
            Monomial { powers, coefficient }
        };
        let monomials = Monomials(vec![monomial(0, 0.48), monomial(1, -1.0), monomial(4, 1.0)]);
        Member::Polynomial(Polynomial {
            monomials,
            period_m: Periods(period_m),
            ..Polynomial::default()
        })
    };
    functions("waves", 0.04, vec![along(0, 50.0), along(2, 200.0)])
}

/// Fig. 8: a constant, and a point in the crown of each tree.
fn mist_around_trees() -> Term {
    let mut members = vec![wave(0.0003, [0.0; 3])];
    members.extend(TREES.map(|[x, z, tall]| {
        let position = Vec3([x, round(height(x, z) + 0.5 * tall), z]);
        Member::Equipotential(Equipotential {
            object: Object::PointObject(PointObject { position }),
            strength: 0.3,
            c: 1.0,
            // A fifth as dense 4.5 m away from the middle, where the crown ends.
            d: 0.2,
            ..Equipotential::default()
        })
    }));
    functions("mist", 1.0, members)
}

fn round(x: f64) -> f64 {
    super::stage::round_to(x, 10.0)
}

/// Where the brook runs [m].
fn brook_x(z: f64) -> f64 {
    -75.0 + 40.0 * (z / 95.0).sin() + 18.0 * (z / 43.0 + 0.7).sin()
}

/// Height of the ground [m]: flat where a house stands.
fn height(x: f64, z: f64) -> f64 {
    let mut ground = open_ground(x, z);
    for ([px, pz], level, reach) in [(HOUSE, 7.0, 34.0), (CHURCH, 60.0, 30.0)] {
        let away = (x - px).hypot(z - pz) / reach;
        let flat = (-away.powi(4)).exp();
        ground += (level - ground) * flat;
    }
    ground
}

/// Height of the ground without what people did to it [m].
fn open_ground(x: f64, z: f64) -> f64 {
    let from_brook = (x - brook_x(z)).abs();
    let bed = 1.0 - (-(from_brook / 14.0).powi(2)).exp();
    let slope = 1.0 - (-(from_brook / 230.0).powi(2)).exp();
    let (mut hills, mut amplitude, mut frequency) = (0.0, 1.0, 1.0 / 190.0);
    for octave in 0..4 {
        hills += amplitude * value_noise(x * frequency + 5.3, z * frequency + 8.1, 60 + octave);
        amplitude *= 0.42;
        frequency *= 2.1;
    }
    // The farther from the eye the higher, so that hills close the view.
    let back = ((100.0 - z) / 500.0).clamp(0.0, 1.0);
    5.0 * bed + slope * (4.0 + 80.0 * hills + 45.0 * back)
}

fn surfaces() -> Vec<Surface> {
    let mut village = Village::default();
    let on = |[x, z]: [f64; 2]| DVec3::new(x, round(height(x, z)), z);
    village.house(on(HOUSE), 16.0);
    // Before the house, beside its door.
    for (k, x) in [-9.2, -5.4, -2.0, 2.0, 5.0, 8.9].into_iter().enumerate() {
        let out = 6.6 + 0.5 * (k % 2) as f64;
        village.bush(
            on([HOUSE[0] + x, HOUSE[1] + out]),
            1.1 + 0.12 * (k % 3) as f64,
            20 + k as u64,
        );
    }
    village.church(on(CHURCH));
    for (k, [x, z, tall]) in TREES.into_iter().enumerate() {
        village.tree(on([x, z]), tall, k as u64);
    }
    for [x, z, tall] in NEAR {
        village.conifer(on([x, z]), tall, x, 4);
    }
    let mut random = Random::new(2002);
    let stands_free = |foot: DVec3| {
        let far = |[x, z]: [f64; 2]| (foot.x - x).hypot(foot.z - z) > 50.0;
        far(HOUSE) && far(CHURCH) && foot.y > 8.0 && foot.z < 250.0
    };
    village.grove(92, SIZE, &mut random, height, stands_free);
    let mut list = vec![
        land("land", SIZE, SIDE, 10.0, height, matte([0.05, 0.066, 0.02])),
        water("brook", SIZE, WATER, glossy([0.05, 0.08, 0.1], 0.3, 40.0)),
    ];
    list.extend(village.surfaces());
    list
}
