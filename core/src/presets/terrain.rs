//! Hills with fog in the valleys.

use super::Preset;
use super::geometry::MeshBuilder;
use super::stage::{
    blob, camera, fill, gaussians, glossy, glowing, homogeneous, lamp, land, matte, mesh, round_to,
    sky, water,
};
use crate::random::{Random, value_noise};
use crate::scene::{Blob, Fog, Rgb, Scene, Surface};
use glam::DVec3;

/// Blobs of fog in the paper's figure.
const BLOBS: usize = 292;
/// Heights along each side of the terrain.
const SIDE: usize = 256;
/// Length of each side [m].
const SIZE: f64 = 1600.0;
/// Level of the river [m].
const WATER: f64 = 6.0;

/// Valley fog among hills, under lamps and under a sky.
pub fn presets() -> [Preset; 2] {
    [
        Preset {
            name: "terrain-292",
            title: "Valley fog",
            description: "Morning fog lies in the valleys of a terrain of 65 536 vertices: 292 blobs, \
                as in the terrain of Fogshop 2007, lit by two lamps far away and one at a chapel. Move the fog \
                between the ridges, or raise it until only the summits stand out.",
            scene: scene(),
        },
        Preset {
            name: "terrain-sky",
            title: "Valley fog at dawn",
            description: "The same hills and the same 292 blobs under the sky of a dawn, which is all their \
                light but for the chapel's lamp: the fog glows towards the rising sun and is blue away from it.",
            scene: under_sky(),
        },
    ]
}

fn under_sky() -> Scene {
    let mut scene = scene();
    scene.lights.retain(|light| light.id() == Some("chapel-lamp"));
    scene.lights.push(sky(dawn));
    scene.background = Rgb::splat(0.0);
    scene.fog.ambient = Rgb::splat(0.0);
    scene
}

/// Radiance of the sky before the sun rises in the north-west; the ground below is dark [W/(m² sr)].
fn dawn(d: DVec3) -> DVec3 {
    let glow = (0.5 + 0.5 * d.dot(DVec3::new(-0.78, 0.12, -0.61).normalize())).powi(9);
    let (zenith, horizon, ground) =
        (DVec3::new(0.1, 0.17, 0.36), DVec3::new(0.3, 0.33, 0.42), DVec3::new(0.04, 0.045, 0.05));
    let even = if d.y > 0.0 {
        horizon.lerp(zenith, d.y.sqrt())
    } else {
        horizon.lerp(ground, (-3.0 * d.y).min(1.0))
    };
    let height = (-6.0 * d.y.abs()).exp();
    even + DVec3::new(2.6, 1.35, 0.55) * glow * (0.25 + 0.75 * height)
}

fn scene() -> Scene {
    let mut random = Random::new(292);
    let chapel = chapel_foot();
    Scene {
        camera: camera([-30.0, 240.0, 790.0], [40.0, 70.0, 0.0], 42.0),
        background: Rgb([0.15, 0.2, 0.32]),
        surfaces: surfaces(&mut random),
        lights: vec![
            lamp("morning", DVec3::new(-2300.0, 900.0, -900.0), [6.4e7, 4.3e7, 2.5e7]),
            fill(lamp("sky", DVec3::new(700.0, 3200.0, 900.0), [0.7e7, 1.0e7, 1.6e7])),
            lamp("chapel-lamp", chapel + DVec3::new(0.0, 9.0, 16.0), [26_000.0, 14_000.0, 5000.0]),
        ],
        fog: Fog {
            ambient: Rgb([0.08, 0.1, 0.14]),
            terms: vec![
                homogeneous("haze", 0.000_18),
                gaussians("valley-fog", valley_fog(&mut random)),
            ],
            ..Fog::default()
        },
        far_m: 3000.0,
        ..Scene::default()
    }
}

/// Where the valley's floor runs [m].
fn valley_x(z: f64) -> f64 {
    130.0 * (z / 210.0).sin() + 60.0 * (z / 97.0 + 1.0).sin()
}

/// Height of the ground [m].
fn height(x: f64, z: f64) -> f64 {
    let from_river = (x - valley_x(z)).abs();
    let valley = 1.0 - (-(from_river / 230.0).powi(2)).exp();
    let mut ridges = 0.0;
    let (mut amplitude, mut frequency) = (1.0, 1.0 / 420.0);
    for octave in 0..6 {
        let noise = value_noise(x * frequency + 31.7, z * frequency + 11.3, 90 + octave);
        // Folding the noise about its middle makes sharp crests.
        ridges += amplitude * (1.0 - (2.0 * noise - 1.0).abs()).powi(2);
        amplitude *= 0.46;
        frequency *= 2.03;
    }
    let detail = 6.0 * value_noise(x / 19.0, z / 19.0, 7);
    2.0 + valley * (25.0 + 140.0 * ridges) + detail * (0.25 + valley)
}

fn surfaces(random: &mut Random) -> Vec<Surface> {
    let (trunks, crowns) = trees(random);
    vec![
        land("hills", SIZE, SIDE, 100.0, height, matte([0.14, 0.155, 0.075])),
        water("river", SIZE, WATER, glossy([0.03, 0.05, 0.06], 0.25, 40.0)),
        mesh("crowns", crowns.flat(), matte([0.07, 0.11, 0.06])),
        mesh("trunks", trunks.flat(), matte([0.12, 0.08, 0.05])),
        mesh("chapel", chapel().flat(), matte([0.5, 0.47, 0.42])),
        mesh("chapel-windows", chapel_windows().flat(), glowing([3.2, 1.9, 0.8])),
    ]
}

/// Conifers on the lower slopes, in groves.
fn trees(random: &mut Random) -> (MeshBuilder, MeshBuilder) {
    const COUNT: usize = 1400;
    let (mut trunks, mut crowns) = (MeshBuilder::default(), MeshBuilder::default());
    let mut planted = 0;
    while planted < COUNT {
        let x = random.between(-0.5, 0.5) * SIZE;
        let z = random.between(-0.5, 0.5) * SIZE;
        let ground = height(x, z);
        let grove = value_noise(x / 90.0, z / 90.0, 44) > 0.5;
        let slope = (height(x + 5.0, z) - ground).abs() + (height(x, z + 5.0) - ground).abs();
        let grows = grove && (WATER + 3.0..150.0).contains(&ground) && slope < 7.0;
        if !grows {
            continue;
        }
        let foot = DVec3::new(x, ground - 0.5, z);
        let tall = random.between(9.0, 19.0);
        trunks.frustum(
            [foot - DVec3::new(0.4, 0.0, 0.4), foot + DVec3::new(0.4, 3.0, 0.4)],
            DVec3::ZERO,
        );
        for (low, high, radius) in [(0.14, 0.62, 0.21), (0.42, 1.0, 0.15)] {
            crowns.cone(foot, [tall * low, tall * high], tall * radius, random.angle(), 7);
        }
        planted += 1;
    }
    (trunks, crowns)
}

fn chapel_foot() -> DVec3 {
    let (z, beside) = (260.0, -62.0);
    let x = valley_x(z) + beside;
    DVec3::new(round_to(x, 10.0), round_to(height(x, z), 10.0), z)
}

fn chapel() -> MeshBuilder {
    let mut chapel = MeshBuilder::default();
    let foot = chapel_foot();
    let at = |x: f64, y: f64, z: f64| foot + DVec3::new(x, y, z);
    chapel.block(at(-5.0, -4.0, -14.0), at(5.0, 7.0, 5.0));
    chapel.frustum([at(-5.6, 7.0, -14.5), at(5.6, 13.0, 5.5)], DVec3::new(5.5, 0.0, 0.6));
    chapel.block(at(-3.0, -4.0, 5.0), at(3.0, 17.0, 11.0));
    chapel.frustum([at(-3.4, 17.0, 4.6), at(3.4, 30.0, 11.4)], DVec3::new(3.35, 0.0, 3.35));
    chapel
}

fn chapel_windows() -> MeshBuilder {
    let mut panes = MeshBuilder::default();
    let foot = chapel_foot();
    let mut pane = |min: [f64; 3], max: [f64; 3]| {
        panes.block(foot + DVec3::from(min), foot + DVec3::from(max));
    };
    for k in 0..4 {
        let z = -12.0 + 4.2 * f64::from(k);
        pane([-5.1, 2.0, z], [5.1, 5.0, z + 1.3]);
    }
    pane([-0.8, 10.5, 10.9], [0.8, 13.5, 11.1]);
    panes
}

/// Blobs where the ground lies lower than around it.
fn valley_fog(random: &mut Random) -> Vec<Blob> {
    let mut blobs = Vec::with_capacity(BLOBS);
    while blobs.len() < BLOBS {
        let x = random.between(-0.5, 0.5) * SIZE;
        let z = random.between(-0.5, 0.44) * SIZE;
        let ground = height(x, z);
        let hollow = surroundings(x, z) - ground;
        if hollow < 22.0 || ground > 95.0 {
            continue;
        }
        let radius = random.between(26.0, 64.0);
        let center = DVec3::new(x, ground + radius * random.between(0.05, 0.3), z);
        blobs.push(blob(center, radius, random.between(0.35, 0.85)));
    }
    blobs
}

/// Mean height on a circle of 130 m [m].
fn surroundings(x: f64, z: f64) -> f64 {
    const PLACES: u32 = 12;
    let sum: f64 = (0..PLACES)
        .map(|k| {
            let angle = std::f64::consts::TAU * f64::from(k) / f64::from(PLACES);
            height(x + 130.0 * angle.cos(), z + 130.0 * angle.sin())
        })
        .sum();
    sum / f64::from(PLACES)
}
