//! Lamps and drifting particles in a thin haze (Macklin 2010).

use super::Preset;
use super::geometry::{MeshBuilder, ball, lathe, spline};
use super::stage::{
    camera, emitter, glass, glossy, glowing, homogeneous, lamp, matte, mesh, round_to, sphere,
};
use crate::media::emitter::Emitter;
use crate::scene::{Fog, Rgb, Scene, Surface, Vec3};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Particles that are alive at a time.
const PARTICLES: f64 = 96.0;
/// The bowl's rim [m].
const BOWL: DVec3 = DVec3::new(0.0, 1.22, 0.0);
/// Columns around the bowl, and how far away they stand [m].
const COLUMNS: u32 = 12;
const RING: f64 = 4.6;
/// The three orbs: where they float, and their colours.
const ORBS: [(&str, DVec3, [f64; 3]); 3] = [
    ("ember", DVec3::new(0.0, 1.62, 0.0), [22.0, 11.0, 3.4]),
    ("azure", DVec3::new(-2.5, 2.5, -0.9), [2.0, 5.6, 12.0]),
    ("rose", DVec3::new(2.3, 1.5, 1.1), [8.5, 2.0, 5.0]),
];

/// The lamps.
pub fn preset() -> Preset {
    Preset {
        name: "in-scatter",
        title: "Lamps in haze and smoke",
        description: "Three coloured lamps glow in a thin haze, and smoke drifts past them from a \
            bowl: point lights and particles, as in the in-scattering demo of Macklin 2010.",
        scene: scene(),
    }
}

fn scene() -> Scene {
    Scene {
        camera: camera([0.9, 2.3, 8.4], [0.0, 2.1, 0.0], 44.0),
        background: Rgb([0.002, 0.003, 0.006]),
        surfaces: surfaces(),
        lights: ORBS.map(|(id, at, intensity)| lamp(id, at, intensity)).into(),
        fog: Fog {
            ambient: Rgb([0.004, 0.005, 0.008]),
            terms: vec![homogeneous("haze", 0.03), emitter("smoke", smoke())],
            ..Fog::default()
        },
        far_m: 60.0,
        ..Scene::default()
    }
}

/// Smoke that rises from the bowl, slower and slower, and is drawn aside past the azure lamp.
fn smoke() -> Emitter {
    const LIFETIME_S: f64 = 8.0;
    Emitter {
        position: Vec3(BOWL.to_array()),
        rate_hz: PARTICLES / LIFETIME_S,
        velocity: [0.1, 0.62, 0.0],
        spread_deg: 16.0,
        acceleration: [-0.06, -0.02, 0.0],
        lifetime_s: LIFETIME_S,
        radius: 0.2,
        growth: 3.6,
        extinction: 1.2.into(),
        seed: 2010,
        ..Emitter::default()
    }
}

fn surfaces() -> Vec<Surface> {
    let mut list = vec![
        mesh("floor", floor().flat(), glossy([0.16, 0.15, 0.14], 0.1, 24.0)),
        mesh("columns", columns().flat(), matte([0.5, 0.48, 0.44])),
        mesh("bowl", bowl().smooth(), glossy([0.3, 0.2, 0.1], 0.3, 30.0)),
    ];
    for (id, at, intensity) in ORBS {
        // So bright that it stays an orb on the screen, in its lamp's colour.
        let glow = intensity.map(|power| round_to(1.2 * power, 10.0));
        list.push(glass(sphere(id, at, 0.07, glowing(glow))));
    }
    list
}

/// Flagstones in rings.
fn floor() -> MeshBuilder {
    let mut floor = MeshBuilder::default();
    floor.block(DVec3::new(-30.0, -0.5, -30.0), DVec3::new(30.0, -0.03, 30.0));
    for i in -7..7 {
        for j in -9..6 {
            let min = DVec3::new(f64::from(i) + 0.012, -0.1, f64::from(j) + 0.012);
            floor.frustum([min, min + DVec3::new(0.976, 0.1, 0.976)], DVec3::new(0.02, 0.0, 0.02));
        }
    }
    floor
}

/// Columns around the bowl, but for where one looks in.
fn columns() -> MeshBuilder {
    let profile: Vec<DVec2> = [
        [0.0, 0.0],
        [0.46, 0.0],
        [0.46, 0.16],
        [0.36, 0.26],
        [0.3, 0.34],
        [0.28, 2.0],
        [0.25, 4.1],
        [0.3, 4.2],
        [0.42, 4.34],
        [0.46, 4.36],
        [0.46, 4.6],
        [0.0, 4.6],
    ]
    .map(DVec2::from_array)
    .into();
    // As many sides as a Doric column has flutes.
    let column = lathe(&profile, 20);
    let mut columns = MeshBuilder::default();
    for k in 0..COLUMNS {
        let angle = TAU * (f64::from(k) + 0.5) / f64::from(COLUMNS);
        let foot = DVec3::new(angle.sin(), 0.0, angle.cos()) * RING;
        if foot.z < 3.0 {
            columns.add_at(&column, foot);
        }
    }
    columns
}

fn bowl() -> MeshBuilder {
    let profile = spline(
        &[
            [0.5, 0.0],
            [0.46, 0.1],
            [0.16, 0.2],
            [0.12, 0.6],
            [0.2, 0.8],
            [0.62, 1.0],
            [0.74, BOWL.y],
            [0.66, BOWL.y],
            [0.4, 1.02],
            [0.0, 0.95],
        ],
        3,
    );
    let mut bowl = lathe(&profile, 40);
    for k in 0..12 {
        let angle = TAU * f64::from(k) / 12.0;
        bowl.add_at(
            &ball(0.05, 10),
            DVec3::new(0.72 * angle.cos(), BOWL.y - 0.08, 0.72 * angle.sin()),
        );
    }
    bowl
}
