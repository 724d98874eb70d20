//! A room filled with mist (the box of Fogshop 2007, fig. 6).

use super::Preset;
use super::geometry::{Facade, MeshBuilder, along, bezier, lathe, lathe_with, rod, spline, tube};
use super::stage::{blob, camera, gaussians, glossy, glowing, lamp, matte, mesh};
use super::street::vase;
use super::vessel::vessel;
use crate::random::Random;
use crate::scene::{Blob, Fog, Rgb, Scene, Surface};
use glam::{DAffine3, DVec3};
use std::f64::consts::TAU;

/// Blobs of mist in the paper's figure.
const BLOBS: usize = 3008;
/// The room spans ± this along x and z, and this along y [m].
const HALF_WIDTH: f64 = 3.2;
const HALF_DEPTH: f64 = 2.8;
const HEIGHT: f64 = 3.2;
/// Height of the table [m].
const TABLE: f64 = 0.78;
/// Where the lamp hangs [m].
const LAMP: DVec3 = DVec3::new(0.05, 1.84, 0.0);

/// The room.
pub fn preset() -> Preset {
    Preset {
        name: "room-3008",
        title: "Room full of mist",
        description: "One lamp hangs over a table in a closed room, and 3 008 small blobs fill the \
            air, as in the box of Fogshop 2007, fig. 6: the heaviest fog of the paper.",
        scene: scene(),
    }
}

fn scene() -> Scene {
    let mut random = Random::new(3008);
    Scene {
        camera: camera([2.35, 1.75, 2.6], [-0.2, 1.05, -0.35], 50.0),
        background: Rgb::splat(0.0),
        surfaces: surfaces(&mut random),
        lights: vec![lamp("hanging-lamp", LAMP, [13.0, 9.0, 4.6])],
        fog: Fog {
            ambient: Rgb([0.006, 0.008, 0.013]),
            terms: vec![gaussians("mist", mist(&mut random))],
            ..Fog::default()
        },
        far_m: 12.0,
        ..Scene::default()
    }
}

fn surfaces(random: &mut Random) -> Vec<Surface> {
    let pot = DAffine3::from_translation(DVec3::new(0.02, TABLE + 0.002, 0.05))
        * DAffine3::from_rotation_y(0.5)
        * DAffine3::from_scale(DVec3::splat(0.17));
    let mut vessel_on_table = MeshBuilder::default();
    vessel_on_table.add(&vessel(0.3), pot);
    let (walls, panes) = walls();
    let wood = glossy([0.3, 0.17, 0.085], 0.1, 20.0);
    vec![
        mesh("floor", planks(random).flat(), glossy([0.24, 0.14, 0.075], 0.06, 16.0)),
        mesh("walls", walls.flat(), matte([0.3, 0.32, 0.29])),
        mesh("panelling", panelling().flat(), matte([0.3, 0.2, 0.13])),
        mesh("beams", beams().flat(), matte([0.24, 0.15, 0.09])),
        mesh("window", panes.flat(), glowing([0.035, 0.06, 0.12])),
        mesh("table", table().smooth(), wood.clone()),
        mesh("chairs", chairs().smooth(), wood),
        mesh("vessel", vessel_on_table.smooth(), glossy([0.42, 0.24, 0.12], 0.4, 36.0)),
        mesh("cups", cups().smooth(), glossy([0.55, 0.53, 0.48], 0.25, 40.0)),
        mesh("vases", vases().smooth(), glossy([0.14, 0.24, 0.32], 0.3, 36.0)),
        mesh("lampshade", lampshade().smooth(), glossy([0.08, 0.14, 0.1], 0.2, 24.0)),
    ]
}

fn planks(random: &mut Random) -> MeshBuilder {
    const COUNT: i32 = 32;
    let mut planks = MeshBuilder::default();
    let width = 2.0 * HALF_WIDTH / f64::from(COUNT);
    for i in 0..COUNT {
        let x = -HALF_WIDTH + width * f64::from(i);
        let mut z = -HALF_DEPTH - random.between(0.0, 1.5);
        while z < HALF_DEPTH {
            let next = z + random.between(1.4, 2.4);
            let min = DVec3::new(x + 0.003, -0.05, z.max(-HALF_DEPTH));
            let top = random.between(-0.0015, 0.0015);
            planks.frustum(
                [min, DVec3::new(x + width - 0.003, top, next.min(HALF_DEPTH) - 0.004)],
                DVec3::new(0.004, 0.0, 0.004),
            );
            z = next;
        }
    }
    planks
}

/// Four walls and the ceiling; the window is in the wall at −x.
fn walls() -> (MeshBuilder, MeshBuilder) {
    let (mut walls, mut panes) = (MeshBuilder::default(), MeshBuilder::default());
    let (x, y, z, thick) = (HALF_WIDTH, HEIGHT, HALF_DEPTH, 0.2);
    walls.block(DVec3::new(-x, 0.0, -z - thick), DVec3::new(x, y, -z));
    walls.block(DVec3::new(-x, 0.0, z), DVec3::new(x, y, z + thick));
    walls.block(DVec3::new(x, 0.0, -z), DVec3::new(x + thick, y, z));
    walls.block(DVec3::new(-x, y, -z), DVec3::new(x, y + thick, z));
    walls.block(DVec3::new(-x - 0.3, -0.3, -z), DVec3::new(x, -0.02, z));
    let window = Facade {
        corner: DVec3::new(-x, 0.0, z),
        right: DVec3::NEG_Z,
        width: 2.0 * z,
        height: y,
        columns: 2,
        rows: 1,
        opening: [0.5, 0.5],
        recess: 0.24,
    };
    for pane in window.build(&mut walls) {
        panes.face(pane);
        let (low, high) = (pane[0].min(pane[2]), pane[0].max(pane[2]));
        for k in 1..3 {
            let z = low.z + (high.z - low.z) * f64::from(k) / 3.0;
            walls.block(
                DVec3::new(low.x, low.y, z - 0.02),
                DVec3::new(low.x + 0.05, high.y, z + 0.02),
            );
        }
        let y = low.y + 0.62 * (high.y - low.y);
        walls.block(DVec3::new(low.x, y - 0.02, low.z), DVec3::new(low.x + 0.05, y + 0.02, high.z));
        let sill = DVec3::new(low.x, low.y - 0.05, low.z - 0.08);
        walls.beveled_block(sill, DVec3::new(low.x + 0.36, low.y, high.z + 0.08), 0.015);
    }
    (walls, panes)
}

/// Panels along the foot of the wall at −z and a shelf above them.
fn panelling() -> MeshBuilder {
    let mut panels = MeshBuilder::default();
    let z = -HALF_DEPTH;
    for k in 0..8 {
        let x = -HALF_WIDTH + 0.8 * f64::from(k);
        panels.beveled_block(
            DVec3::new(x + 0.1, 0.2, z - 0.05),
            DVec3::new(x + 0.7, 0.86, z + 0.03),
            0.025,
        );
        panels.beveled_block(
            DVec3::new(x - 0.05, 0.0, z - 0.05),
            DVec3::new(x + 0.05, 1.0, z + 0.035),
            0.01,
        );
    }
    for (low, high, out) in
        [(0.0, 0.12, 0.04), (0.96, 1.02, 0.06), (1.62, 1.66, 0.26), (3.05, 3.2, 0.1)]
    {
        panels.beveled_block(
            DVec3::new(-HALF_WIDTH, low, z - 0.05),
            DVec3::new(HALF_WIDTH, high, z + out),
            0.01,
        );
    }
    for k in 0..5 {
        let x = -2.6 + 1.3 * f64::from(k);
        panels.frustum(
            [DVec3::new(x - 0.03, 1.45, z - 0.05), DVec3::new(x + 0.03, 1.62, z + 0.2)],
            DVec3::ZERO,
        );
    }
    panels
}

fn beams() -> MeshBuilder {
    let mut beams = MeshBuilder::default();
    for k in 0..5 {
        let x = -2.6 + 1.3 * f64::from(k);
        beams.beveled_block(
            DVec3::new(x - 0.09, HEIGHT - 0.2, -HALF_DEPTH),
            DVec3::new(x + 0.09, HEIGHT + 0.1, HALF_DEPTH),
            0.02,
        );
    }
    beams
}

/// A round table on a turned column with three feet.
fn table() -> MeshBuilder {
    let top = spline(
        &[
            [0.0, 0.735],
            [0.6, 0.735],
            [0.76, 0.74],
            [0.79, 0.755],
            [0.785, 0.775],
            [0.77, 0.78],
            [0.4, TABLE],
            [0.0, TABLE],
        ],
        3,
    );
    let column = spline(
        &[
            [0.13, 0.06],
            [0.14, 0.12],
            [0.07, 0.18],
            [0.06, 0.24],
            [0.1, 0.34],
            [0.115, 0.42],
            [0.06, 0.52],
            [0.05, 0.6],
            [0.08, 0.65],
            [0.2, 0.72],
            [0.22, 0.74],
        ],
        4,
    );
    let mut table = lathe(&top, 72);
    table.add_at(&lathe(&column, 36), DVec3::ZERO);
    for k in 0..3 {
        let turn = 0.4 + TAU * f64::from(k) / 3.0;
        table.add(&table_foot(), DAffine3::from_rotation_y(turn));
    }
    table
}

fn table_foot() -> MeshBuilder {
    let path = bezier(
        [[0.08, 0.2], [0.3, 0.22], [0.34, 0.05], [0.55, 0.03]].map(|[x, y]| DVec3::new(x, y, 0.0)),
        16,
    );
    tube(&path, 12, |k, _| 0.045 - 0.001 * k as f64)
}

fn chairs() -> MeshBuilder {
    let chair = chair();
    let mut all = MeshBuilder::default();
    for (x, z, turn) in [(-1.15, 0.35, 1.35), (0.25, -1.2, 0.15), (1.0, 0.95, -2.3)] {
        let at = DAffine3::from_translation(DVec3::new(x, 0.0, z));
        all.add(&chair, at * DAffine3::from_rotation_y(turn));
    }
    all
}

/// A chair that looks towards +z.
fn chair() -> MeshBuilder {
    let mut chair = MeshBuilder::default();
    chair.beveled_block(DVec3::new(-0.22, 0.43, -0.2), DVec3::new(0.22, 0.47, 0.22), 0.015);
    let leg = spline(
        &[
            [0.0, 0.0],
            [0.016, 0.0],
            [0.022, 0.1],
            [0.016, 0.14],
            [0.026, 0.28],
            [0.018, 0.36],
            [0.02, 0.44],
        ],
        3,
    );
    for x in [-0.18, 0.18] {
        for z in [-0.16, 0.18] {
            chair.add_at(&lathe(&leg, 14), DVec3::new(x, 0.0, z));
        }
        let post = [DVec3::new(x, 0.45, -0.18), DVec3::new(x * 1.08, 0.98, -0.27)];
        chair.add_at(&rod(post[0], post[1], 0.019, 12), DVec3::ZERO);
    }
    for (y, z) in [(0.66, -0.215), (0.8, -0.24), (0.94, -0.263)] {
        let end = DVec3::new(0.2, y, z);
        chair.add_at(&rod(end * DVec3::new(-1.0, 1.0, 1.0), end, 0.024, 12), DVec3::ZERO);
    }
    for (a, b) in
        [([-0.18, 0.2, 0.18], [0.18, 0.2, 0.18]), ([-0.18, 0.24, -0.16], [0.18, 0.24, -0.16])]
    {
        chair.add_at(&rod(a.into(), b.into(), 0.011, 10), DVec3::ZERO);
    }
    chair
}

fn cups() -> MeshBuilder {
    let cup = spline(
        &[
            [0.0, 0.0],
            [0.024, 0.0],
            [0.022, 0.008],
            [0.034, 0.025],
            [0.042, 0.05],
            [0.045, 0.062],
            [0.043, 0.063],
            [0.038, 0.045],
            [0.0, 0.02],
        ],
        3,
    );
    let saucer = spline(
        &[[0.0, 0.003], [0.035, 0.0], [0.07, 0.012], [0.073, 0.015], [0.035, 0.006], [0.0, 0.006]],
        3,
    );
    let mut cups = MeshBuilder::default();
    for (x, z) in [(0.42, 0.25), (-0.4, 0.3), (0.2, -0.48), (-0.42, -0.28)] {
        let foot = DVec3::new(x, TABLE + 0.001, z);
        cups.add_at(&lathe(&saucer, 32), foot);
        cups.add_at(&lathe(&cup, 32), foot + DVec3::Y * 0.006);
    }
    cups
}

/// Vases on the shelf.
fn vases() -> MeshBuilder {
    let vase = vase();
    let mut row = MeshBuilder::default();
    for k in 0..4 {
        let x = -2.1 + 1.35 * f64::from(k);
        let size = [0.34, 0.42, 0.3, 0.38][k as usize];
        let place = DAffine3::from_translation(DVec3::new(x, 1.66, -HALF_DEPTH + 0.13));
        row.add(&vase, place * DAffine3::from_scale(DVec3::splat(size)));
    }
    row
}

/// An open shade above the lamp, on its cord.
fn lampshade() -> MeshBuilder {
    let profile = spline(
        &[
            [0.26, 0.0],
            [0.265, 0.005],
            [0.2, 0.08],
            [0.1, 0.15],
            [0.04, 0.2],
            [0.03, 0.26],
            [0.0, 0.27],
        ],
        4,
    );
    let mut shade = MeshBuilder::default();
    let scallops = lathe_with(&profile, 64, |angle, k| {
        1.0 + 0.012 * (16.0 * angle).cos() * (1.0 - k as f64 / profile.len() as f64)
    });
    shade.add(&scallops, along(LAMP + DVec3::Y * 0.03, DVec3::Y));
    let cord = [LAMP + DVec3::Y * 0.29, DVec3::new(LAMP.x, HEIGHT, LAMP.z)];
    shade.add_at(&rod(cord[0], cord[1], 0.008, 8), DVec3::ZERO);
    shade
}

/// Small blobs all over the room, denser near the floor, in slow swirls.
fn mist(random: &mut Random) -> Vec<Blob> {
    let mut blobs = Vec::with_capacity(BLOBS);
    while blobs.len() < BLOBS {
        let x = random.between(-HALF_WIDTH, HALF_WIDTH);
        let y = HEIGHT * random.unit().powf(1.35);
        let z = random.between(-HALF_DEPTH, HALF_DEPTH);
        let swirl = (2.1 * x + 1.3 * (1.7 * z).sin()).sin() * (1.9 * z + 1.1 * y).cos();
        if !random.chance(0.5 + 0.5 * swirl) {
            continue;
        }
        let radius = random.between(0.16, 0.42);
        blobs.push(blob(DVec3::new(x, y, z), radius, 0.016 * random.between(0.5, 1.6)));
    }
    blobs
}
