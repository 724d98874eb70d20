//! A nave in the morning: the sun comes through high windows into hazy air.

use super::Preset;
use super::geometry::{MeshBuilder, lathe};
use super::stage::{
    blob, camera, fill, gaussians, glass, glossy, glowing, homogeneous, lamp, matte, mesh, sphere,
    sun,
};
use crate::random::Random;
use crate::scene::{Blob, Fog, Rgb, Scene, Surface};
use glam::{DVec2, DVec3};

/// The nave spans ± this along x, this along y, and z from its door to its apse [m].
const HALF_WIDTH: f64 = 5.5;
const HEIGHT: f64 = 15.0;
const DOOR: f64 = 10.0;
const APSE: f64 = -40.0;
/// Distance from window to window, their half width, sill and top [m].
const BAY: f64 = 5.0;
const WINDOW: f64 = 0.7;
const SILL: f64 = 6.5;
const TOP: f64 = 12.0;
/// Bays.
const BAYS: i32 = 10;
/// Where the lamp of the apse hangs [m].
const LAMP: DVec3 = DVec3::new(0.0, 4.2, -34.0);

/// The nave.
pub fn preset() -> Preset {
    Preset {
        name: "nave-shafts",
        title: "Shafts of sun in a nave",
        description: "The morning sun falls through ten high windows, and the haze shows its way: every window throws a \
            shaft of light, every mullion a shadow in it.",
        scene: scene(),
    }
}

fn scene() -> Scene {
    let mut random = Random::new(1163);
    Scene {
        camera: camera([-3.2, 2.7, 9.2], [0.9, 4.6, -12.0], 56.0),
        background: Rgb([0.55, 0.7, 0.95]),
        surfaces: surfaces(),
        lights: vec![
            sun("sun", [-0.78, -0.86, -0.22], [44.0, 34.5, 22.5]),
            lamp("apse-lamp", LAMP, [26.0, 15.0, 6.0]),
            // What floor and walls throw back of the sun.
            fill(lamp("bounce-near", DVec3::new(-3.4, 1.2, -2.0), [34.0, 26.0, 18.0])),
            fill(lamp("bounce-far", DVec3::new(-3.4, 2.0, -22.0), [50.0, 39.0, 27.0])),
        ],
        fog: Fog {
            ambient: Rgb([0.02, 0.024, 0.032]),
            terms: vec![homogeneous("haze", 0.008), gaussians("incense", incense(&mut random))],
            light_path_m: 12.0,
            ..Fog::default()
        },
        far_m: 120.0,
        ..Scene::default()
    }
}

/// Drifts of smoke above the benches.
fn incense(random: &mut Random) -> Vec<Blob> {
    let drift = |_| {
        let center = DVec3::new(
            random.between(-4.0, 3.0),
            random.between(1.0, 6.0),
            random.between(-32.0, 0.0),
        );
        blob(center, random.between(0.9, 2.4), random.between(0.01, 0.05))
    };
    (0..60).map(drift).collect()
}

fn surfaces() -> Vec<Surface> {
    let stone = matte([0.46, 0.42, 0.36]);
    vec![
        mesh("floor", floor().flat(), glossy([0.3, 0.26, 0.22], 0.05, 30.0)),
        mesh("windows", windows().flat(), stone.clone()),
        mesh("walls", walls().flat(), stone),
        mesh("columns", columns().smooth(), matte([0.5, 0.46, 0.4])),
        mesh("benches", benches().flat(), glossy([0.2, 0.11, 0.06], 0.06, 20.0)),
        mesh("altar", altar().flat(), matte([0.55, 0.52, 0.46])),
        glass(sphere("flame", LAMP, 0.12, glowing([14.0, 8.0, 3.0]))),
    ]
}

fn floor() -> MeshBuilder {
    let mut floor = MeshBuilder::default();
    let half = HALF_WIDTH + 1.0;
    floor.block(DVec3::new(-half, -0.5, APSE), DVec3::new(half, -0.02, DOOR));
    for i in -6..6 {
        for j in -40..10 {
            let min = DVec3::new(f64::from(i), -0.1, f64::from(j));
            let max = min + DVec3::new(0.985, 0.1, 0.985);
            floor.frustum([min, max], DVec3::new(0.008, 0.0, 0.008));
        }
    }
    floor
}

/// The middle of a bay along z [m].
fn bay(i: i32) -> f64 {
    DOOR - BAY * (f64::from(i) + 0.5)
}

/// The wall towards the sun: piers between windows, each with a mullion and two cross bars.
fn windows() -> MeshBuilder {
    let mut wall = MeshBuilder::default();
    let (inner, outer) = (HALF_WIDTH, HALF_WIDTH + 0.7);
    let mut block = |y: [f64; 2], z: [f64; 2], x: [f64; 2]| {
        wall.block(DVec3::new(x[0], y[0], z[0]), DVec3::new(x[1], y[1], z[1]));
    };
    block([0.0, SILL], [APSE, DOOR], [inner, outer]);
    block([TOP, HEIGHT], [APSE, DOOR], [inner, outer]);
    let pane = [inner + 0.25, inner + 0.35];
    for i in 0..BAYS {
        let z = bay(i);
        block([SILL, TOP], [z + WINDOW, z + BAY - WINDOW], [inner, outer]);
        block([SILL, TOP], [z - 0.05, z + 0.05], pane);
        for y in [SILL + 2.0, SILL + 4.0] {
            block([y - 0.04, y + 0.04], [z - WINDOW, z + WINDOW], pane);
        }
    }
    let last = bay(BAYS - 1);
    block([SILL, TOP], [APSE, last - WINDOW], [inner, outer]);
    wall
}

/// All other walls, the roof with its beams, and a string course.
fn walls() -> MeshBuilder {
    let mut walls = MeshBuilder::default();
    let half = HALF_WIDTH + 0.7;
    let mut block = |min: [f64; 3], max: [f64; 3]| walls.block(min.into(), max.into());
    block([-half, 0.0, APSE], [-HALF_WIDTH, HEIGHT, DOOR]);
    block([-half, 0.0, APSE - 0.7], [half, HEIGHT, APSE]);
    block([-half, 0.0, DOOR], [half, HEIGHT, DOOR + 0.7]);
    block([-half, HEIGHT, APSE], [half, HEIGHT + 0.5, DOOR]);
    block([-HALF_WIDTH, SILL - 0.6, APSE], [-HALF_WIDTH + 0.15, SILL - 0.35, DOOR]);
    block([HALF_WIDTH - 0.15, SILL - 0.6, APSE], [HALF_WIDTH, SILL - 0.35, DOOR]);
    for i in 0..=BAYS {
        let z = DOOR - BAY * f64::from(i);
        block([-HALF_WIDTH, HEIGHT - 0.9, z - 0.3], [HALF_WIDTH, HEIGHT, z + 0.3]);
    }
    walls
}

/// Half columns before the piers, from the floor to the beams.
fn columns() -> MeshBuilder {
    let profile = [
        [0.0, 0.0],
        [0.62, 0.0],
        [0.62, 0.35],
        [0.5, 0.5],
        [0.42, 0.7],
        [0.4, 11.6],
        [0.46, 11.75],
        [0.42, 11.9],
        [0.6, 12.6],
        [0.66, 13.0],
        [0.66, 14.1],
        [0.0, 14.1],
    ];
    let column = lathe(&profile.map(DVec2::from_array), 28);
    let mut columns = MeshBuilder::default();
    for i in 1..BAYS {
        let z = DOOR - BAY * f64::from(i);
        for side in [-1.0, 1.0] {
            columns.add_at(&column, DVec3::new(side * (HALF_WIDTH - 0.2), 0.0, z));
        }
    }
    columns
}

fn benches() -> MeshBuilder {
    let mut benches = MeshBuilder::default();
    for i in 0..22 {
        let z = 3.0 - 1.3 * f64::from(i);
        for [from, to] in [[-4.3, -0.9], [0.9, 4.3]] {
            let mut part = |y: [f64; 2], z: [f64; 2]| {
                benches.block(DVec3::new(from, y[0], z[0]), DVec3::new(to, y[1], z[1]));
            };
            part([0.4, 0.46], [z - 0.22, z + 0.2]);
            part([0.46, 0.92], [z + 0.16, z + 0.2]);
            part([0.0, 0.4], [z - 0.03, z + 0.03]);
        }
    }
    benches
}

fn altar() -> MeshBuilder {
    let mut altar = MeshBuilder::default();
    let mut block = |min: [f64; 3], max: [f64; 3]| altar.block(min.into(), max.into());
    block([-4.0, 0.0, -38.5], [4.0, 0.2, -31.0]);
    block([-3.0, 0.2, -38.0], [3.0, 0.4, -32.0]);
    block([-1.4, 0.4, -36.0], [1.4, 1.4, -34.8]);
    block([-1.6, 1.4, -36.1], [1.6, 1.5, -34.7]);
    altar
}
