//! A street at night with three identical lamps, in thin and in thick fog (Sun 2005, fig. 8).

mod buildings;
mod ground;
mod lamp_post;

use super::Preset;
use super::geometry::{MeshBuilder, lathe, rod, spline};
use super::stage::{camera, glass, glossy, glowing, homogeneous, lamp, matte, mesh, sphere};
use crate::random::Random;
use crate::scene::{Fog, Light, Rgb, Scene, Surface};
use buildings::{COLONNADE_X, COLUMN_STEP};
use glam::DVec3;
use ground::{FAR_Z, KERB};
use lamp_post::{GLOBE_HEIGHT, GLOBE_RADIUS, upright};

pub use lamp_post::vase;

/// Feet of the three lamps.
const LAMPS: [DVec3; 3] =
    [DVec3::new(3.1, KERB, 0.6), DVec3::new(3.1, KERB, -9.4), DVec3::new(3.1, KERB, -25.4)];
const LAMP_INTENSITY: [f64; 3] = [70.0, 49.0, 25.0];

/// The street in thin and in thick fog.
pub fn presets() -> [Preset; 2] {
    let surfaces = surfaces();
    [thin(surfaces.clone()), thick(surfaces)]
}

fn thin(surfaces: Vec<Surface>) -> Preset {
    Preset {
        name: "street-thin",
        title: "Street lamps in thin fog",
        description: "Three identical lamps at different distances, with a soft halo each: the \
            night street of Sun 2005, fig. 8, at a visibility of 250 m. Four point lamps and more \
            than 60 000 triangles.",
        scene: street(surfaces, 0.012),
    }
}

fn thick(surfaces: Vec<Surface>) -> Preset {
    Preset {
        name: "street-thick",
        title: "Street lamps in thick fog",
        description: "The same street and the same lamps at a visibility of 60 m: the halos grow \
            together, the highlights spread, and the far end sinks into the fog (Sun 2005, fig. 8).",
        scene: street(surfaces, 0.05),
    }
}

fn street(surfaces: Vec<Surface>, extinction: f64) -> Scene {
    Scene {
        camera: camera([-0.7, 1.65, 9.0], [0.05, 2.45, -10.0], 46.0),
        background: Rgb([0.004, 0.006, 0.012]),
        surfaces,
        lights: lights(),
        fog: Fog {
            ambient: Rgb([0.004, 0.0055, 0.009]),
            terms: vec![homogeneous("fog", extinction)],
            ..Fog::default()
        },
        far_m: 90.0,
        ..Scene::default()
    }
}

fn lights() -> Vec<Light> {
    let names = ["near-lamp", "middle-lamp", "far-lamp"];
    let mut lights: Vec<Light> = names
        .into_iter()
        .zip(LAMPS)
        .map(|(name, foot)| lamp(name, globe_center(foot), LAMP_INTENSITY))
        .collect();
    lights.push(lamp("gallery-lantern", LANTERN, [34.0, 17.0, 6.0]));
    lights
}

/// The lantern that hangs in the colonnade.
const LANTERN: DVec3 = DVec3::new(-6.9, 3.1, -4.0);

fn globe_center(foot: DVec3) -> DVec3 {
    foot + DVec3::Y * GLOBE_HEIGHT
}

fn surfaces() -> Vec<Surface> {
    let mut random = Random::new(2005);
    let houses = buildings::houses(&mut random);
    let iron = glossy([0.05, 0.055, 0.06], 0.12, 24.0);
    let mut list = vec![
        mesh("road-bed", ground::bed().flat(), matte([0.05, 0.05, 0.055])),
        mesh(
            "cobbles",
            ground::cobbles(&mut random).flat(),
            glossy([0.15, 0.145, 0.14], 0.12, 20.0),
        ),
        mesh(
            "pavements",
            ground::pavements(&mut random).flat(),
            glossy([0.3, 0.28, 0.26], 0.03, 10.0),
        ),
        mesh("columns", buildings::columns().smooth(), glossy([0.46, 0.43, 0.38], 0.05, 14.0)),
        mesh("gallery", buildings::gallery().flat(), matte([0.3, 0.27, 0.23])),
        mesh("houses", houses.walls.flat(), matte([0.27, 0.2, 0.155])),
        mesh("dark-windows", houses.dark.flat(), glossy([0.03, 0.035, 0.045], 0.25, 60.0)),
        mesh("lit-windows", houses.lit.flat(), glowing([0.75, 0.42, 0.14])),
        mesh("tower", buildings::tower().flat(), matte([0.3, 0.28, 0.26])),
        mesh("clock", clock().smooth(), glowing([1.5, 1.2, 0.75])),
        mesh("lamp-posts", lamp_posts().smooth(), iron.clone()),
        mesh("lantern", lantern().smooth(), iron),
        mesh("vases", vases().smooth(), glossy([0.32, 0.15, 0.09], 0.3, 36.0)),
        mesh("pedestals", pedestals().flat(), matte([0.42, 0.39, 0.34])),
    ];
    for (name, foot) in ["near-globe", "middle-globe", "far-globe"].into_iter().zip(LAMPS) {
        list.push(glass(sphere(name, globe_center(foot), GLOBE_RADIUS, glowing([9.0, 7.0, 4.4]))));
    }
    list.push(glass(sphere("lantern-flame", LANTERN, 0.07, glowing([7.0, 3.6, 1.2]))));
    list
}

fn lamp_posts() -> MeshBuilder {
    let post = lamp_post::lamp_post();
    let mut posts = MeshBuilder::default();
    for foot in LAMPS {
        posts.add_at(&post, foot);
    }
    posts
}

fn clock() -> MeshBuilder {
    let center = DVec3::new(0.0, 12.6, FAR_Z + 0.18);
    rod(center, center + DVec3::Z * 0.12, 1.15, 40)
}

/// A roof and four bars around the flame, on a chain.
fn lantern() -> MeshBuilder {
    let mut lantern = MeshBuilder::default();
    let roof = spline(&[[0.2, 0.2], [0.21, 0.23], [0.12, 0.3], [0.05, 0.36], [0.0, 0.42]], 3);
    lantern.add_at(&lathe(&roof, 16), LANTERN);
    let foot = spline(&[[0.0, -0.2], [0.12, -0.19], [0.14, -0.16], [0.0, -0.14]], 2);
    lantern.add_at(&lathe(&foot, 16), LANTERN);
    for (x, z) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
        let low = LANTERN + DVec3::new(0.085 * x, -0.16, 0.085 * z);
        let high = LANTERN + DVec3::new(0.135 * x, 0.22, 0.135 * z);
        lantern.add_at(&rod(low, high, 0.009, 6), DVec3::ZERO);
    }
    let chain = rod(LANTERN + DVec3::Y * 0.4, LANTERN + DVec3::Y * 1.4, 0.012, 6);
    lantern.add_at(&chain, DVec3::ZERO);
    lantern
}

/// Feet of the pedestals: on the left pavement, midway between columns.
fn pedestal_feet() -> impl Iterator<Item = DVec3> {
    (0..4).map(|k| {
        let z = 7.2 - COLUMN_STEP * (1.5 + 2.0 * f64::from(k)) + 0.4;
        DVec3::new(COLONNADE_X + 1.35, KERB, z)
    })
}

fn vases() -> MeshBuilder {
    let vase = vase();
    let mut vases = MeshBuilder::default();
    for (k, foot) in pedestal_feet().enumerate() {
        vases.add(&vase, upright(foot + DVec3::Y * 0.78, 0.13 * k as f64));
    }
    vases
}

fn pedestals() -> MeshBuilder {
    let mut one = MeshBuilder::default();
    for (low, high, half) in [(0.0, 0.12, 0.32), (0.12, 0.68, 0.26), (0.68, 0.78, 0.31)] {
        one.beveled_block(DVec3::new(-half, low, -half), DVec3::new(half, high, half), 0.015);
    }
    let mut all = MeshBuilder::default();
    for foot in pedestal_feet() {
        all.add_at(&one, foot);
    }
    all
}
