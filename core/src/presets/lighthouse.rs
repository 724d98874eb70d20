//! A lighthouse in sea fog: two spots that turn their backs on each other (Macklin 2010).

use super::Preset;
use super::geometry::{MeshBuilder, lathe};
use super::stage::{
    blob, camera, fill, gaussians, glass, glossy, glowing, homogeneous, lamp, matte, mesh, sphere,
    spot, sun,
};
use crate::random::{Random, value_noise};
use crate::scene::{Blob, Fog, Heightfield, Rgb, Scene, Shape, Surface, Vec3};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Where the lamps stand [m].
const LANTERN: DVec3 = DVec3::new(0.0, 25.0, 0.0);
/// The rock: its side, its points along it, and how high it is [m].
const ROCK: f64 = 70.0;
const POINTS: usize = 97;
const SUMMIT: f64 = 6.5;

/// The lighthouse.
pub fn preset() -> Preset {
    Preset {
        name: "lighthouse",
        title: "Lighthouse in sea fog",
        description: "Two narrow spot lamps stand back to back in the lantern of a lighthouse, and sea fog shows their \
            beams. Spot lights as in the in-scattering demo of Macklin 2010.",
        scene: scene(),
    }
}

fn scene() -> Scene {
    let mut random = Random::new(1611);
    let beam = |id: &str, side: f64| {
        let direction = DVec3::new(0.86 * side, -0.045, 0.51 * side);
        spot(id, LANTERN, direction, [2.2, 4.5], [1.1e5, 0.94e5, 0.66e5])
    };
    Scene {
        camera: camera([34.0, 8.5, 47.0], [3.5, 16.0, 0.0], 50.0),
        background: Rgb([0.008, 0.012, 0.022]),
        surfaces: surfaces(),
        lights: vec![
            beam("beam", 1.0),
            beam("beam-behind", -1.0),
            lamp("keeper", DVec3::new(7.2, 9.2, 6.4), [60.0, 36.0, 14.0]),
            fill(sun("moon", [-0.4, -0.7, -0.5], [0.16, 0.22, 0.34])),
        ],
        fog: Fog {
            ambient: Rgb([0.02, 0.027, 0.042]),
            terms: vec![homogeneous("haze", 0.0035), gaussians("banks", banks(&mut random))],
            ..Fog::default()
        },
        far_m: 900.0,
        ..Scene::default()
    }
}

/// Banks of fog over the sea and around the tower.
fn banks(random: &mut Random) -> Vec<Blob> {
    let bank = |_| {
        let (distance, turn) = (random.between(8.0, 90.0), random.angle());
        let center =
            DVec3::new(distance * turn.cos(), random.between(2.0, 26.0), distance * turn.sin());
        blob(center, random.between(7.0, 18.0), random.between(0.04, 0.16))
    };
    (0..48).map(bank).collect()
}

fn surfaces() -> Vec<Surface> {
    let white = glossy([0.62, 0.6, 0.56], 0.04, 18.0);
    let iron = glossy([0.06, 0.06, 0.07], 0.2, 26.0);
    vec![
        mesh("sea", sea().flat(), glossy([0.01, 0.016, 0.022], 0.12, 40.0)),
        rock(),
        mesh("tower", tower().smooth(), white.clone()),
        mesh("bands", bands().smooth(), matte([0.42, 0.07, 0.05])),
        mesh("gallery", gallery().flat(), iron.clone()),
        mesh("roof", roof().smooth(), iron),
        mesh("house", house().flat(), white),
        mesh("house-roof", house_roof().flat(), matte([0.2, 0.1, 0.08])),
        mesh("lit-windows", panes().flat(), glowing([1.6, 0.9, 0.32])),
        glass(sphere("lens", LANTERN, 0.55, glowing([16.0, 13.6, 9.6]))),
    ]
}

fn sea() -> MeshBuilder {
    let mut sea = MeshBuilder::default();
    let corner = |x: f64, z: f64| DVec3::new(900.0 * x, 0.0, 900.0 * z);
    sea.face([corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, -1.0)]);
    sea
}

fn rock() -> Surface {
    let at = |k: usize| ROCK * (k as f64 / (POINTS - 1) as f64 - 0.5);
    let height = |x: f64, z: f64| {
        let rough = value_noise(0.13 * x + 7.0, 0.13 * z + 3.0, 5) - 0.5;
        let fine = value_noise(0.5 * x, 0.5 * z, 9) - 0.5;
        let edge = 1.0 - (x.hypot(1.25 * z) / 25.0).powi(2);
        let top = SUMMIT.min(SUMMIT * 1.7 * edge + 5.0 * rough);
        super::stage::round_to((top + 0.9 * fine).max(-1.5), 100.0)
    };
    let row = |j: usize| (0..POINTS).map(|i| height(at(i), at(j))).collect();
    let heights = (0..POINTS).map(row).collect();
    let origin = Vec3([-ROCK / 2.0, 0.0, -ROCK / 2.0]);
    let shape = Shape::Heightfield(Heightfield { origin, size: [ROCK, ROCK], heights });
    Surface {
        id: Some("rock".into()),
        shape,
        material: matte([0.17, 0.16, 0.15]),
        ..Surface::default()
    }
}

fn turned(profile: &[[f64; 2]], sides: usize) -> MeshBuilder {
    let profile: Vec<_> = profile.iter().map(|point| DVec2::from_array(*point)).collect();
    lathe(&profile, sides)
}

fn tower() -> MeshBuilder {
    turned(
        &[[0.0, 4.0], [4.3, 4.0], [4.1, 6.5], [3.3, 13.0], [2.85, 19.0], [2.7, 22.2], [0.0, 22.2]],
        64,
    )
}

/// Two painted bands, a finger in front of the wall.
fn bands() -> MeshBuilder {
    let mut bands = MeshBuilder::default();
    for [low, high, wide, narrow] in [[9.0, 12.0, 3.86, 3.5], [15.5, 18.0, 3.18, 2.98]] {
        bands.add_at(&turned(&[[wide, low], [narrow, high]], 64), DVec3::ZERO);
    }
    bands
}

/// The floor around the lantern, its rail, and the posts that carry the roof.
fn gallery() -> MeshBuilder {
    let mut gallery = turned(&[[0.0, 22.2], [3.6, 22.2], [3.6, 22.5], [0.0, 22.5]], 32);
    for i in 0..24 {
        let turn = TAU * f64::from(i) / 24.0;
        let foot = DVec3::new(3.45 * turn.cos(), 22.5, 3.45 * turn.sin());
        gallery.block(foot - DVec3::new(0.04, 0.0, 0.04), foot + DVec3::new(0.04, 1.1, 0.04));
    }
    for i in 0..8 {
        // Between the beams, not in them.
        let turn = TAU * (f64::from(i) + 0.18) / 8.0;
        let foot = DVec3::new(2.0 * turn.cos(), 22.5, 2.0 * turn.sin());
        gallery.block(foot - DVec3::new(0.06, 0.0, 0.06), foot + DVec3::new(0.06, 4.4, 0.06));
    }
    gallery
}

fn roof() -> MeshBuilder {
    turned(
        &[
            [0.0, 26.9],
            [2.45, 26.9],
            [2.5, 27.1],
            [1.4, 28.3],
            [0.3, 29.2],
            [0.12, 30.4],
            [0.0, 30.4],
        ],
        40,
    )
}

const HOUSE: [DVec3; 2] = [DVec3::new(3.8, 5.0, 2.2), DVec3::new(10.4, 9.2, 6.2)];

fn house() -> MeshBuilder {
    let mut house = MeshBuilder::default();
    house.block(HOUSE[0], HOUSE[1]);
    house
}

fn house_roof() -> MeshBuilder {
    let mut roof = MeshBuilder::default();
    let over = DVec3::new(0.35, 0.0, 0.35);
    let [min, max] = HOUSE;
    let low = DVec3::new(min.x, max.y, min.z) - over;
    roof.frustum([low, max + over + DVec3::Y * 1.9], DVec3::new(0.6, 0.0, 2.1));
    roof
}

fn panes() -> MeshBuilder {
    let mut panes = MeshBuilder::default();
    let front = HOUSE[1].z + 0.02;
    for x in [5.2, 7.2, 9.0] {
        panes.block(DVec3::new(x - 0.35, 6.6, front - 0.02), DVec3::new(x + 0.35, 7.9, front));
    }
    panes
}
