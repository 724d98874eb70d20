//! A steam locomotive in its own smoke (the vehicle of Fogshop 2007).

mod engine;
mod gear;
mod plume;

use super::Preset;
use super::geometry::{Facade, MeshBuilder, along, lathe};
use super::stage::{camera, glass, glossy, glowing, lamp, matte, mesh};
use crate::random::Random;
use crate::scene::{Environment, Fog, Light, Radiance, Rgb, Scene, Surface};
use crate::sky::GradientSky;
use engine::HEADLAMP;
use gear::{HALF_GAUGE, RAIL_TOP};
use glam::{DVec2, DVec3};

/// The locomotive, by night and by day.
pub fn presets() -> [Preset; 2] {
    [
        Preset {
            name: "vehicle-1223",
            title: "Locomotive in smoke",
            description: "A steam locomotive of more than 40 000 triangles waits at night in its smoke \
                and steam; its headlamp lights them from inside. 1 223 particles, as many as blobs around \
                the vehicle of Fogshop 2007, and two lamps.",
            scene: scene(),
        },
        Preset {
            name: "vehicle-sky",
            title: "Locomotive on a winter morning",
            description: "The same locomotive in the same 1 223 particles by day: a bright overcast sky lights \
                them from all around.",
            scene: under_sky(),
        },
    ]
}

fn under_sky() -> Scene {
    let mut scene = scene();
    scene.lights = vec![Light::Environment(Environment {
        id: Some("sky".into()),
        radiance: Radiance::GradientSky(GradientSky {
            zenith: Rgb([0.62, 0.66, 0.72]),
            horizon: Rgb([0.4, 0.43, 0.48]),
            ground: Rgb([0.1, 0.095, 0.09]),
        }),
        ..Environment::default()
    })];
    scene.background = Rgb::splat(0.0);
    scene.fog.ambient = Rgb::splat(0.0);
    scene
}

fn scene() -> Scene {
    let mut random = Random::new(1223);
    Scene {
        camera: camera([10.2, 1.9, 7.6], [1.35, 2.55, -0.1], 42.0),
        background: Rgb([0.006, 0.009, 0.017]),
        surfaces: surfaces(&mut random),
        lights: vec![
            lamp("headlamp", HEADLAMP + DVec3::X * 0.14, [15.0, 11.5, 6.5]),
            lamp("yard-lamp", DVec3::new(4.5, 9.0, 9.5), [190.0, 215.0, 280.0]),
        ],
        fog: Fog { ambient: Rgb([0.008, 0.01, 0.015]), terms: plume::terms(), ..Fog::default() },
        far_m: 90.0,
        ..Scene::default()
    }
}

fn surfaces(random: &mut Random) -> Vec<Surface> {
    let mut engine = engine::engine();
    gear::running_gear(&mut engine);
    let (wall, dark, lit) = shed();
    let lens = lathe(
        &[[0.0, -0.03], [0.2, -0.03], [0.2, 0.0], [0.12, 0.03], [0.0, 0.04]].map(DVec2::from_array),
        32,
    );
    let mut lens_mesh = MeshBuilder::default();
    lens_mesh.add(&lens, along(HEADLAMP, DVec3::X));
    vec![
        mesh("iron", engine.iron.smooth(), glossy([0.06, 0.062, 0.07], 0.3, 26.0)),
        mesh("wheels", engine.wheels.smooth(), glossy([0.3, 0.045, 0.03], 0.14, 22.0)),
        mesh("brass", engine.brass.smooth(), glossy([0.42, 0.27, 0.09], 0.42, 34.0)),
        mesh("steel", engine.steel.smooth(), glossy([0.32, 0.33, 0.35], 0.4, 30.0)),
        mesh("plates", engine.plates.flat(), glossy([0.05, 0.11, 0.075], 0.1, 18.0)),
        glass(mesh("lens", lens_mesh.smooth(), glowing([8.0, 6.2, 3.6]))),
        mesh("rails", rails().flat(), glossy([0.22, 0.2, 0.19], 0.3, 24.0)),
        mesh("sleepers", sleepers(random).flat(), matte([0.16, 0.11, 0.08])),
        mesh("ballast", ballast(random).flat(), matte([0.22, 0.21, 0.2])),
        mesh("ground", ground().flat(), matte([0.11, 0.1, 0.09])),
        mesh("shed", wall.flat(), matte([0.26, 0.16, 0.12])),
        mesh("dark-windows", dark.flat(), glossy([0.03, 0.035, 0.045], 0.25, 50.0)),
        mesh("lit-windows", lit.flat(), glowing([0.55, 0.33, 0.13])),
    ]
}

fn rails() -> MeshBuilder {
    let mut rails = MeshBuilder::default();
    for side in [-1.0, 1.0] {
        let z = HALF_GAUGE * side;
        for (low, high, half) in [(0.0, 0.03, 0.09), (0.03, 0.11, 0.02), (0.11, RAIL_TOP, 0.045)] {
            rails.block(DVec3::new(-30.0, low, z - half), DVec3::new(30.0, high, z + half));
        }
    }
    rails
}

fn sleepers(random: &mut Random) -> MeshBuilder {
    let mut sleepers = MeshBuilder::default();
    for k in -46..46 {
        let x = f64::from(k) * 0.65 + random.between(-0.03, 0.03);
        let end = 1.35 + random.between(-0.05, 0.05);
        sleepers.beveled_block(
            DVec3::new(x - 0.13, -0.16, -end),
            DVec3::new(x + 0.13, 0.0, end),
            0.015,
        );
    }
    sleepers
}

fn ground() -> MeshBuilder {
    let mut ground = MeshBuilder::default();
    ground.block(DVec3::new(-60.0, -0.5, -30.0), DVec3::new(60.0, -0.12, 40.0));
    ground
}

/// Loose stones around the track.
fn ballast(random: &mut Random) -> MeshBuilder {
    let mut stones = MeshBuilder::default();
    for _ in 0..3400 {
        let x = random.between(-14.0, 11.0);
        let z = random.bell() * 1.6;
        let size = random.between(0.03, 0.085);
        let center = DVec3::new(x, -0.1, z);
        let half = DVec3::new(size * random.between(0.7, 1.3), 0.0, size);
        let top = DVec3::Y * size * random.between(0.5, 1.1);
        stones.frustum([center - half - DVec3::Y * 0.05, center + half + top], half * 0.35);
    }
    stones
}

/// The engine shed behind the track.
fn shed() -> (MeshBuilder, MeshBuilder, MeshBuilder) {
    let (mut wall, mut dark, mut lit) =
        (MeshBuilder::default(), MeshBuilder::default(), MeshBuilder::default());
    let facade = Facade {
        corner: DVec3::new(-33.0, -0.12, -6.5),
        right: DVec3::X,
        width: 48.0,
        height: 6.4,
        columns: 16,
        rows: 1,
        opening: [0.5, 0.6],
        recess: 0.25,
    };
    for (k, pane) in facade.build(&mut wall).into_iter().enumerate() {
        let glass = if k % 5 == 3 { &mut lit } else { &mut dark };
        glass.face(pane);
        let (low, high) = (pane[0], pane[2]);
        for bar in 1..4 {
            let x = low.x + (high.x - low.x) * f64::from(bar) / 4.0;
            let min = DVec3::new(x - 0.03, low.y, low.z);
            wall.block(min, DVec3::new(x + 0.03, high.y, low.z + 0.06));
            let y = low.y + (high.y - low.y) * f64::from(bar) / 4.0;
            let min = DVec3::new(low.x, y - 0.03, low.z);
            wall.block(min, DVec3::new(high.x, y + 0.03, low.z + 0.06));
        }
    }
    for k in 0..=16 {
        let x = facade.corner.x + 3.0 * f64::from(k);
        wall.beveled_block(DVec3::new(x - 0.3, -0.12, -6.6), DVec3::new(x + 0.3, 6.4, -6.25), 0.05);
    }
    wall.block(DVec3::new(-33.0, 6.2, -6.6), DVec3::new(15.0, 6.7, -6.0));
    wall.face([
        DVec3::new(-33.4, 6.7, -5.8),
        DVec3::new(15.4, 6.7, -5.8),
        DVec3::new(15.4, 9.4, -11.0),
        DVec3::new(-33.4, 9.4, -11.0),
    ]);
    (wall, dark, lit)
}
