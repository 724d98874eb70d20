//! A steaming ornate vessel (Fogshop 2007, fig. 1).

use super::Preset;
use super::geometry::{MeshBuilder, along, ball, bezier, lathe, lathe_with, spline, tube};
use super::stage::{camera, emitter, glossy, glowing, lamp, matte, mesh, rounded};
use crate::media::emitter::Emitter;
use crate::random::Random;
use crate::scene::{Fog, Rgb, Scene, Surface};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Blobs of steam in the paper's figure: so many particles are alive at a time.
const PARTICLES: f64 = 34.0;

/// The vessel with its plume of steam.
pub fn preset() -> Preset {
    Preset {
        name: "steaming-vessel",
        title: "Steaming vessel",
        description: "Steam rises from a serpent's mouth and glows with the lamp inside it: an \
            emitter of 34 particles, 3 lamps and about 78 000 vertices, the counts of Fogshop 2007, fig. 1.",
        scene: scene(),
    }
}

fn scene() -> Scene {
    let steam_lamp = MOUTH + DVec3::new(0.2, 0.42, 0.05);
    Scene {
        camera: camera([1.1, 2.5, 8.2], [0.6, 2.0, 0.0], 38.0),
        background: Rgb([0.004, 0.006, 0.012]),
        surfaces: surfaces(),
        lights: vec![
            lamp("steam-lamp", steam_lamp, [11.0, 6.4, 2.6]),
            lamp("key", DVec3::new(-3.4, 5.2, 4.6), [74.0, 60.0, 44.0]),
            lamp("rim", DVec3::new(4.6, 4.4, -2.0), [20.0, 32.0, 54.0]),
        ],
        fog: Fog {
            ambient: Rgb([0.075, 0.08, 0.092]),
            terms: vec![emitter("steam", steam())],
            ..Fog::default()
        },
        far_m: 30.0,
        ..Scene::default()
    }
}

/// Where the steam leaves the spout [m].
const MOUTH: DVec3 = DVec3::new(2.16, 2.2, 0.0);
/// Control points of the spout's curve [m].
const SPOUT: [DVec3; 4] = [
    DVec3::new(0.75, 0.72, 0.0),
    DVec3::new(1.75, 0.55, 0.0),
    DVec3::new(1.2, 1.75, 0.0),
    DVec3::new(2.05, 2.08, 0.0),
];

fn surfaces() -> Vec<Surface> {
    vec![
        mesh("vessel", vessel(1.0).smooth(), glossy([0.3, 0.19, 0.1], 0.28, 26.0)),
        mesh("eyes", eyes().smooth(), glowing([2.2, 0.7, 0.12])),
        mesh("pedestal", pedestal().smooth(), glossy([0.3, 0.29, 0.28], 0.06, 12.0)),
        mesh("floor", floor().flat(), glossy([0.15, 0.135, 0.125], 0.05, 14.0)),
        mesh("wall", wall().flat(), matte([0.12, 0.105, 0.1])),
    ]
}

/// The vessel, its foot at the origin and its spout towards +x; 2.5 m high. `detail` scales the
/// number of corners along each direction.
pub fn vessel(detail: f64) -> MeshBuilder {
    let cut = |count: f64| (count * detail).round().max(3.0) as usize;
    let mut vessel = body(cut(192.0), cut(7.0));
    vessel.add_at(&lid(cut(160.0), cut(5.0)), DVec3::ZERO);
    vessel.add_at(&spout(cut(150.0), cut(72.0)), DVec3::ZERO);
    vessel.add_at(&handle(cut(120.0), cut(40.0)), DVec3::ZERO);
    vessel.add_at(&head(detail), DVec3::ZERO);
    let bead = ball(0.034, cut(12.0));
    for k in 0..48 {
        let angle = TAU * f64::from(k) / 48.0;
        vessel.add_at(&bead, DVec3::new(0.735 * angle.cos(), 1.575, 0.735 * angle.sin()));
    }
    vessel
}

fn body(segments: usize, cuts: usize) -> MeshBuilder {
    let profile = spline(
        &[
            [0.0, 0.0],
            [0.52, 0.0],
            [0.57, 0.05],
            [0.5, 0.12],
            [0.36, 0.2],
            [0.34, 0.26],
            [0.42, 0.32],
            [0.68, 0.44],
            [0.94, 0.7],
            [1.04, 1.0],
            [0.97, 1.3],
            [0.78, 1.52],
            [0.7, 1.6],
            [0.6, 1.66],
            [0.6, 1.72],
            [0.66, 1.77],
            [0.6, 1.8],
            [0.5, 1.79],
        ],
        cuts,
    );
    let heights: Vec<f64> = profile.iter().map(|p| p.y).collect();
    lathe_with(&profile, segments, move |angle, k| {
        let y = heights[k];
        let window = |low: f64, high: f64| {
            (((y - low) / 0.12).clamp(0.0, 1.0) * ((high - y) / 0.12).clamp(0.0, 1.0)).sqrt()
        };
        // Twisted gadroons below, upright reeds on the shoulder, a scalloped foot.
        let gadroons = 0.026 * gadroon(18.0 * (angle + 0.55 * y));
        let reeds = 0.018 * (36.0 * angle).cos();
        let scallops = 0.03 * (12.0 * angle).cos();
        1.0 + gadroons * window(0.3, 1.06)
            + reeds * window(1.12, 1.5)
            + scallops * window(-0.2, 0.2)
    })
}

/// A wave with broad crests and narrow valleys.
fn gadroon(phase: f64) -> f64 {
    phase.cos() - 0.25 * (2.0 * phase).cos()
}

fn lid(segments: usize, cuts: usize) -> MeshBuilder {
    let profile = spline(
        &[
            [0.56, 1.78],
            [0.57, 1.83],
            [0.5, 1.88],
            [0.42, 1.98],
            [0.26, 2.07],
            [0.12, 2.12],
            [0.09, 2.16],
            [0.15, 2.2],
            [0.09, 2.24],
            [0.13, 2.3],
            [0.17, 2.37],
            [0.12, 2.45],
            [0.04, 2.5],
            [0.0, 2.52],
        ],
        cuts,
    );
    let heights: Vec<f64> = profile.iter().map(|p| p.y).collect();
    lathe_with(&profile, segments, move |angle, k| {
        let y = heights[k];
        let dome = ((y - 1.9) / 0.08).clamp(0.0, 1.0) * ((2.1 - y) / 0.06).clamp(0.0, 1.0);
        let knob = ((y - 2.26) / 0.05).clamp(0.0, 1.0) * ((2.48 - y) / 0.05).clamp(0.0, 1.0);
        1.0 + 0.05 * dome * (10.0 * angle).cos() + 0.09 * knob * (8.0 * angle + 9.0 * y).cos()
    })
}

/// The serpent's neck with its scales.
fn spout(pieces: usize, segments: usize) -> MeshBuilder {
    let path = bezier(SPOUT, pieces);
    tube(&path, segments, |k, angle| {
        let t = k as f64 / pieces as f64;
        let neck = 0.3 - 0.24 * t.powf(0.7) + 0.11 * ((t - 0.9) / 0.12).clamp(-1.0, 1.0).max(0.0);
        let row = t * 22.0;
        let around = 7.0 * angle / TAU * 2.0;
        let stagger = 0.5 * (row as usize % 2) as f64;
        // Each scale rises towards the mouth and ends in a rounded edge.
        let scale = row.fract() * (1.0 - (2.0 * (around + stagger).fract() - 1.0).powi(2));
        neck * (1.0 + 0.11 * scale * ((0.95 - t) * 8.0).clamp(0.0, 1.0))
    })
}

fn handle(pieces: usize, segments: usize) -> MeshBuilder {
    let mut path = bezier(
        [[-0.7, 1.56], [-1.5, 2.15], [-2.1, 1.1], [-1.25, 0.75]].map(in_plane),
        pieces * 3 / 4,
    );
    let tail =
        bezier([[-1.25, 0.75], [-1.0, 0.65], [-0.95, 0.4], [-1.2, 0.42]].map(in_plane), pieces / 4);
    path.extend(&tail[1..]);
    let count = path.len();
    let mut handle = tube(&path, segments, |k, angle| {
        let t = k as f64 / count as f64;
        let thick =
            0.085 + 0.03 * (TAU * t).cos().abs() - 0.07 * ((t - 0.75) * 4.0).clamp(0.0, 1.0);
        thick * (1.0 + 0.12 * (4.0 * angle + 60.0 * t).cos())
    });
    handle.add_at(&ball(0.06, segments / 2), in_plane([-1.2, 0.42]));
    let stay = bezier(
        [[-1.22, 0.76], [-1.1, 0.82], [-1.05, 0.9], [-0.95, 0.92]].map(in_plane),
        pieces / 8,
    );
    handle.add_at(&tube(&stay, segments / 2, |_, _| 0.055), DVec3::ZERO);
    handle
}

fn in_plane([x, y]: [f64; 2]) -> DVec3 {
    DVec3::new(x, y, 0.0)
}

/// The serpent's open mouth, its horns and its crest.
fn head(detail: f64) -> MeshBuilder {
    let cut = |count: f64| (count * detail).round().max(4.0) as usize;
    let profile = spline(
        &[
            [0.1, -0.12],
            [0.15, -0.05],
            [0.17, 0.04],
            [0.15, 0.12],
            [0.17, 0.18],
            [0.21, 0.22],
            [0.2, 0.235],
            [0.14, 0.19],
            [0.09, 0.08],
            [0.07, -0.05],
            [0.0, -0.06],
        ],
        cut(5.0),
    );
    let lips = lathe_with(&profile, cut(64.0), |angle, k| {
        let edge = (k as f64 / profile.len() as f64 * 3.0 - 0.6).clamp(0.0, 1.0);
        1.0 + 0.1 * edge * (2.0 * angle).cos() + 0.03 * edge * (10.0 * angle).cos()
    });
    let axis = (SPOUT[3] - SPOUT[2]).normalize();
    let mut head = MeshBuilder::default();
    head.add(&lips, along(SPOUT[3] - axis * 0.06, axis));
    for side in [-1.0, 1.0] {
        head.add_at(&horn(side, cut(48.0), cut(24.0)), SPOUT[3]);
    }
    for k in 0..9 {
        let t = 0.2 + 0.085 * f64::from(k);
        head.add_at(&crest_fin(t, cut(10.0)), DVec3::ZERO);
    }
    head
}

fn horn(side: f64, pieces: usize, segments: usize) -> MeshBuilder {
    let path = bezier(
        [[-0.08, 0.1, 0.08], [-0.2, 0.42, 0.16], [-0.5, 0.42, 0.26], [-0.56, 0.2, 0.34]]
            .map(|[x, y, z]| DVec3::new(x, y, side * z)),
        pieces,
    );
    tube(&path, segments, |k, _| {
        let t = k as f64 / pieces as f64;
        0.06 * (1.0 - t).powf(0.7) * (1.0 + 0.1 * (46.0 * t).sin()) + 0.003
    })
}

/// A fin on the outer side of the neck at the place `t` of its curve.
fn crest_fin(t: f64, segments: usize) -> MeshBuilder {
    let k = (t * 100.0) as usize;
    let path = bezier(SPOUT, 100);
    let forward = (path[k + 1] - path[k]).normalize();
    let out = DVec3::new(-forward.y, forward.x, 0.0);
    let foot = path[k] + out * (0.24 - 0.2 * t.powf(0.7) + 0.02);
    let size = 0.18 * (1.15 - 0.7 * t);
    let spine = bezier(
        [
            foot,
            foot + out * size,
            foot + (out - forward * 0.4) * size,
            foot + (out * 1.3 - forward) * size,
        ],
        12,
    );
    tube(&spine, segments, |k, angle| {
        let taper = 1.0 - k as f64 / 12.0;
        size * 0.32 * taper.powf(0.6) * (0.55 + 0.45 * angle.cos().abs()) + 0.002
    })
}

fn eyes() -> MeshBuilder {
    let mut eyes = MeshBuilder::default();
    for side in [-1.0, 1.0] {
        eyes.add_at(&ball(0.036, 16), SPOUT[3] + DVec3::new(0.0, 0.1, 0.125 * side));
    }
    eyes
}

fn pedestal() -> MeshBuilder {
    let profile = spline(
        &[
            [1.3, -0.9],
            [1.32, -0.8],
            [1.2, -0.72],
            [1.02, -0.62],
            [0.98, -0.5],
            [0.98, -0.3],
            [1.06, -0.2],
            [1.16, -0.14],
            [1.18, -0.06],
            [1.16, -0.01],
            [1.1, 0.0],
        ],
        4,
    );
    let mut all = profile;
    all.push(DVec2::ZERO);
    lathe(&all, 72)
}

fn floor() -> MeshBuilder {
    let mut random = Random::new(78_054);
    let mut floor = MeshBuilder::default();
    for i in -12..13 {
        for j in -7..9 {
            let min = DVec3::new(f64::from(i) * 0.9 + 0.01, -1.0, f64::from(j) * 0.9 + 0.01);
            let top = -0.9 + random.between(-0.004, 0.004);
            let max = DVec3::new(min.x + 0.88, top, min.z + 0.88);
            floor.frustum([min, max], DVec3::new(0.02, 0.0, 0.02));
        }
    }
    floor
}

/// A panelled wall behind the vessel.
fn wall() -> MeshBuilder {
    let mut wall = MeshBuilder::default();
    let z = -5.6;
    wall.block(DVec3::new(-15.0, -1.0, z - 0.5), DVec3::new(15.0, 9.0, z));
    for k in -9..=8 {
        let x = f64::from(k) * 1.7 + 0.6;
        wall.beveled_block(
            DVec3::new(x - 0.14, -0.9, z),
            DVec3::new(x + 0.14, 5.2, z + 0.14),
            0.03,
        );
        for (low, high) in [(-0.5, 1.1), (1.5, 4.7)] {
            wall.beveled_block(
                DVec3::new(x + 0.34, low, z - 0.1),
                DVec3::new(x + 1.36, high, z + 0.07),
                0.05,
            );
        }
    }
    for (low, high, out) in
        [(-0.9, -0.65, 0.22), (1.22, 1.36, 0.2), (5.0, 5.2, 0.3), (5.2, 5.5, 0.45)]
    {
        wall.beveled_block(DVec3::new(-15.0, low, z - 0.1), DVec3::new(15.0, high, z + out), 0.03);
    }
    wall
}

/// A plume that leaves the mouth, bends upwards and back over the vessel, and widens.
fn steam() -> Emitter {
    const LIFETIME_S: f64 = 4.0;
    Emitter {
        position: rounded(MOUTH, 1e3),
        rate_hz: PARTICLES / LIFETIME_S,
        velocity: [0.24, 0.42, 0.0],
        spread_deg: 16.0,
        acceleration: [-0.12, 0.06, 0.0],
        lifetime_s: LIFETIME_S,
        radius: 0.13,
        growth: 2.7,
        extinction: 2.2.into(),
        seed: 3,
        ..Emitter::default()
    }
}
