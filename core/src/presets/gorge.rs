//! A gorge with a viaduct, through which the wind carries fog (Biri and Michelin 2002, fig. 10).

use super::Preset;
use super::geometry::MeshBuilder;
use super::stage::{camera, fill, functions, glossy, land, matte, mesh, sun, veil, water, wave};
use super::village::Village;
use crate::media::functions::{
    Cosine, CosineMorph, CosineParameters, Member, Monomial, Monomials, Periods, Polynomial,
    WaveVector,
};
use crate::random::{Random, value_noise};
use crate::scene::{Fog, Rgb, Scene, Surface, Velocity, Wind};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Length of each side of the land [m].
const SIZE: f64 = 1500.0;
/// Heights along each side: 2 · 353² = 249 218 triangles, and the rest stands on them.
const SIDE: usize = 354;
/// Level of the river [m].
const WATER: f64 = 2.0;
/// Where the viaduct crosses: from and to x, its z, and its level [m].
const VIADUCT: [f64; 4] = [-210.0, 210.0, 0.0, 84.0];
const ARCHES: u32 = 12;
/// Where the house stands: x and z [m].
const HOUSE: [f64; 2] = [78.0, 196.0];
const HOUSE_LEVEL: f64 = 44.0;

/// The gorge.
pub fn preset() -> Preset {
    Preset {
        name: "gorge-wind",
        title: "Fog in the wind",
        description: "The wind carries banks of fog through a gorge, past a house and under the \
            arches of a viaduct, while their waves swell and ebb: 250 000 triangles, as in Biri and \
            Michelin 2002, fig. 10.",
        scene: scene(),
    }
}

fn scene() -> Scene {
    Scene {
        camera: camera([24.0, 110.0, 340.0], [4.0, 58.0, 0.0], 46.0),
        background: Rgb([0.07, 0.18, 0.46]),
        surfaces: surfaces(),
        lights: vec![
            sun("sun", [-0.75, -0.48, -0.3], [10.0, 7.0, 3.8]),
            fill(sun("sky", [0.4, -0.8, -0.4], [0.45, 0.65, 1.0])),
        ],
        fog: Fog {
            wind: Wind { velocity: Some(Velocity([4.0, 0.0, 9.0])), keys: None },
            ..veil([0.97, 0.97, 0.98], functions("fog", 0.014, members()))
        },
        far_m: 1600.0,
        ..Scene::default()
    }
}

/// A thin haze with waves in it, and banks. What the waves take away is less than the haze.
fn members() -> Vec<Member> {
    let swell = |amplitude: f64| CosineParameters {
        amplitude,
        wave_vector: WaveVector([0.035, 0.026, 0.02]),
        phase_rad: 0.0,
    };
    let CosineParameters { amplitude, wave_vector, phase_rad } = swell(0.012);
    let morph = Some(CosineMorph { to: swell(0.0), period_s: 40.0 });
    vec![
        wave(0.03, [0.0; 3]),
        wave(0.016, [0.0, 0.039, 0.024]),
        Member::Cosine(Cosine { amplitude, wave_vector, phase_rad, morph }),
        Member::Polynomial(banks()),
    ]
}

/// Banks of fog: 64 v³(1 − v)³ along y, 16 u²(1 − u)² along x and z, each of them 1 in the middle of its period
/// and 0 at its borders, slope and all. The next banks upwards are clouds.
fn banks() -> Polynomial {
    let across = [(2, 16.0), (3, -32.0), (4, 16.0)];
    let upwards = [(3, 64.0), (4, -192.0), (5, 192.0), (6, -64.0)];
    let mut monomials = Vec::with_capacity(36);
    for (x, a) in across {
        for (y, b) in upwards {
            for (z, c) in across {
                monomials.push(Monomial { powers: [x, y, z], coefficient: a * b * c });
            }
        }
    }
    Polynomial {
        monomials: Monomials(monomials),
        period_m: Periods([Some(340.0), Some(260.0), Some(420.0)]),
        ..Polynomial::default()
    }
}

/// Where the river runs [m].
fn river_x(z: f64) -> f64 {
    48.0 * (z / 160.0).sin() + 30.0 * (z / 71.0 + 0.6).sin()
}

/// Height of the ground [m]: flat where the house stands.
fn height(x: f64, z: f64) -> f64 {
    let ground = open_ground(x, z);
    let away = (x - HOUSE[0]).hypot(z - HOUSE[1]) / 26.0;
    ground + (HOUSE_LEVEL - ground) * (-away.powi(4)).exp()
}

/// Height of the ground without what people did to it [m].
fn open_ground(x: f64, z: f64) -> f64 {
    let from_river = (x - river_x(z)).abs();
    let bed = 1.0 - (-(from_river / 24.0).powi(2)).exp();
    let walls = 1.0 - (-(from_river / 190.0).powi(2)).exp();
    let (mut ridges, mut amplitude, mut frequency) = (0.0, 1.0, 1.0 / 330.0);
    for octave in 0..6 {
        let noise = value_noise(x * frequency + 3.7, z * frequency + 21.3, 30 + octave);
        // Folding the noise about its middle makes crests, a bit rounded, as the heights cannot show an edge.
        ridges += amplitude * (1.0 - (2.0 * noise - 1.0).hypot(0.12)).powi(2);
        amplitude *= 0.45;
        frequency *= 2.07;
    }
    // The farther from the eye the higher, so that mountains close the view.
    let back = ((100.0 - z) / 850.0).clamp(0.0, 1.0);
    9.0 * bed + walls * (18.0 + (82.0 + 130.0 * back) * ridges)
}

fn surfaces() -> Vec<Surface> {
    let mut village = Village::default();
    village.house(DVec3::new(HOUSE[0], HOUSE_LEVEL, HOUSE[1]), 18.0);
    for (k, [x, z]) in [[54.0, 190.0], [98.0, 176.0], [60.0, 216.0]].into_iter().enumerate() {
        let foot = DVec3::new(x, super::stage::round_to(height(x, z), 10.0), z);
        village.tree(foot, 17.0, 10 + k as u64);
    }
    let mut random = Random::new(250_000);
    let grows = |foot: DVec3| {
        let slope = (height(foot.x + 4.0, foot.z) - height(foot.x - 4.0, foot.z)).abs();
        let from_house = (foot.x - HOUSE[0]).hypot(foot.z - HOUSE[1]);
        let is_near = foot.x.abs() < 360.0 && (-260.0..290.0).contains(&foot.z);
        is_near && (8.0..130.0).contains(&foot.y) && slope < 7.0 && from_house > 34.0
    };
    village.grove(260, SIZE, &mut random, height, grows);
    let mut list = vec![
        land("land", SIZE, SIDE, 10.0, height, matte([0.075, 0.078, 0.04])),
        water("river", SIZE, WATER, glossy([0.04, 0.07, 0.08], 0.3, 40.0)),
        mesh("viaduct", viaduct().flat(), matte([0.5, 0.42, 0.32])),
    ];
    list.extend(village.surfaces());
    list
}

/// Piers, arches between them, and a deck with parapets.
fn viaduct() -> MeshBuilder {
    /// Half the width of the masonry [m].
    const HALF: f64 = 4.2;
    /// Half the thickness of a pier at its top [m].
    const PIER: f64 = 2.6;
    let [from, to, z, level] = VIADUCT;
    let mut built = MeshBuilder::default();
    let at = |x: f64, y: f64, across: f64| DVec3::new(x, y, z + across);
    built.block(at(from - 40.0, level - 1.6, -HALF - 0.5), at(to + 40.0, level, HALF + 0.5));
    for side in [-HALF - 0.5, HALF + 0.1] {
        built.block(at(from - 40.0, level, side), at(to + 40.0, level + 1.3, side + 0.4));
    }
    let pitch = (to - from) / f64::from(ARCHES);
    for k in 0..=ARCHES {
        let x = from + pitch * f64::from(k);
        let foot = height(x, z) - 6.0;
        // Piers grow towards their feet.
        let spread = 0.035 * (level - foot);
        let low = at(x - PIER - spread, foot, -HALF - spread);
        let high = at(x + PIER + spread, level - 1.6, HALF + spread);
        built.frustum([low, high], DVec3::new(spread, 0.0, spread));
        if k < ARCHES {
            arch(
                &mut built,
                [at(x + PIER, level - 1.6, -HALF), at(x + pitch - PIER, level - 1.6, HALF)],
            );
        }
    }
    built
}

/// A round arch under a deck, between the corners of the deck's underside.
fn arch(built: &mut MeshBuilder, [low, high]: [DVec3; 2]) {
    const PIECES: u32 = 16;
    /// Masonry above the crown [m].
    const CROWN: f64 = 1.4;
    let radius = (high.x - low.x) / 2.0;
    let middle = DVec2::new(low.x + radius, low.y - CROWN - radius);
    let point = |k: u32| {
        let angle = PI * (1.0 - f64::from(k) / f64::from(PIECES));
        middle + radius * DVec2::new(angle.cos(), angle.sin())
    };
    for k in 0..PIECES {
        let (a, b) = (point(k), point(k + 1));
        let corner = |p: DVec2, z: f64| DVec3::new(p.x, p.y, z);
        let top = |p: DVec2, z: f64| DVec3::new(p.x, low.y, z);
        built.face([corner(a, high.z), corner(b, high.z), top(b, high.z), top(a, high.z)]);
        built.face([corner(b, low.z), corner(a, low.z), top(a, low.z), top(b, low.z)]);
        built.face([corner(a, low.z), corner(b, low.z), corner(b, high.z), corner(a, high.z)]);
    }
}
