//! A steam locomotive, built about the middle of its track; it drives towards +x.

use super::super::geometry::{MeshBuilder, along, ball, bezier, lathe, rod, spline, tube};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Height of the boiler's axis above the sleepers [m].
const BOILER_Y: f64 = 2.35;
/// Where the chimney's top is [m].
pub const CHIMNEY: DVec3 = DVec3::new(3.85, 4.35, 0.0);
/// The middle of the headlamp's lens [m].
pub const HEADLAMP: DVec3 = DVec3::new(4.98, 3.52, 0.0);

/// The locomotive's parts by what they are made of.
#[derive(Default)]
pub struct Engine {
    /// Black iron.
    pub iron: MeshBuilder,
    /// Painted wheels.
    pub wheels: MeshBuilder,
    /// Polished brass.
    pub brass: MeshBuilder,
    /// Bright steel.
    pub steel: MeshBuilder,
    /// The cab and the running boards, of flat plates.
    pub plates: MeshBuilder,
}

/// The locomotive but for what it runs on.
pub fn engine() -> Engine {
    let mut engine = Engine::default();
    boiler(&mut engine);
    fittings(&mut engine);
    headlamp(&mut engine);
    cab(&mut engine.plates);
    pilot(&mut engine);
    engine
}

/// Adds a part that was turned about +y so that its axis lies along the boiler.
fn lay(built: &mut MeshBuilder, part: &MeshBuilder, y: f64) {
    built.add(part, along(DVec3::new(0.0, y, 0.0), DVec3::X));
}

fn points(list: &[[f64; 2]]) -> Vec<DVec2> {
    list.iter().map(|p| DVec2::from_array(*p)).collect()
}

fn boiler(engine: &mut Engine) {
    let shell = points(&[
        [0.0, -2.7],
        [0.92, -2.7],
        [0.95, -2.66],
        [0.95, -1.3],
        [0.9, -1.26],
        [0.84, -0.9],
        [0.82, -0.5],
        [0.8, 3.3],
        [0.86, 3.32],
        [0.88, 3.36],
        [0.88, 4.5],
        [0.85, 4.56],
        [0.74, 4.58],
        [0.74, 4.62],
        [0.68, 4.66],
        [0.5, 4.72],
        [0.25, 4.755],
        [0.0, 4.765],
    ]);
    lay(&mut engine.iron, &lathe(&shell, 96), BOILER_Y);
    for (x, radius) in [(-1.0, 0.862), (0.1, 0.822), (1.15, 0.817), (2.2, 0.812), (3.2, 0.807)] {
        let band = points(&[
            [radius - 0.02, x - 0.05],
            [radius, x - 0.045],
            [radius + 0.006, x],
            [radius, x + 0.045],
            [radius - 0.02, x + 0.05],
        ]);
        lay(&mut engine.brass, &lathe(&band, 96), BOILER_Y);
    }
    let rivet = ball(0.022, 8);
    let rings = [(3.42, 0.88), (4.42, 0.88), (3.9, 0.88), (-2.58, 0.95), (-1.4, 0.95)];
    for (x, radius) in rings {
        for k in 0..44 {
            let angle = TAU * f64::from(k) / 44.0;
            let out = DVec3::new(0.0, angle.sin(), angle.cos()) * radius;
            engine.iron.add_at(&rivet, DVec3::new(x, BOILER_Y, 0.0) + out);
        }
    }
    smokebox_door(engine);
}

/// Straps, a handwheel and the bolts around the door.
fn smokebox_door(engine: &mut Engine) {
    let rivet = ball(0.026, 8);
    for k in 0..24 {
        let angle = TAU * f64::from(k) / 24.0;
        let out = DVec3::new(0.0, angle.sin(), angle.cos()) * 0.8;
        engine.iron.add_at(&rivet, DVec3::new(4.575, BOILER_Y, 0.0) + out);
    }
    for y in [-0.32_f64, 0.32] {
        let reach = DVec3::new(0.0, 0.0, 0.66);
        let at = DVec3::new(4.735 - 0.1 * y.abs(), BOILER_Y + y, 0.0);
        engine.iron.add_at(&rod(at - reach, at + reach, 0.03, 10), DVec3::ZERO);
    }
    let center = DVec3::new(4.87, BOILER_Y, 0.0);
    let ring: Vec<DVec3> = (0..=40)
        .map(|k| {
            let angle = TAU * f64::from(k) / 40.0;
            center + DVec3::new(0.0, angle.sin(), angle.cos()) * 0.17
        })
        .collect();
    engine.steel.add_at(&tube(&ring, 10, |_, _| 0.018), DVec3::ZERO);
    for k in 0..3 {
        let angle = TAU * f64::from(k) / 6.0;
        let out = DVec3::new(0.0, angle.sin(), angle.cos()) * 0.17;
        engine.steel.add_at(&rod(center - out, center + out, 0.013, 8), DVec3::ZERO);
    }
    engine
        .steel
        .add_at(&rod(center - DVec3::X * 0.12, center + DVec3::X * 0.03, 0.035, 12), DVec3::ZERO);
}

/// Chimney, domes, bell, whistle, safety valves and handrails.
fn fittings(engine: &mut Engine) {
    let chimney = spline(
        &[
            [0.5, 3.12],
            [0.36, 3.22],
            [0.29, 3.36],
            [0.27, 3.6],
            [0.3, 3.95],
            [0.36, 4.2],
            [0.43, 4.26],
            [0.44, 4.33],
            [0.36, 4.35],
            [0.3, 4.2],
            [0.24, 3.6],
            [0.0, 3.5],
        ],
        3,
    );
    engine.iron.add_at(&lathe(&chimney, 48), DVec3::new(CHIMNEY.x, 0.0, 0.0));
    for (x, top, radius) in [(0.7, 4.02, 0.4), (2.45, 3.82, 0.34)] {
        let base = 3.02;
        let dome = spline(
            &[
                [radius * 1.5, base],
                [radius * 1.12, base + 0.1],
                [radius, base + 0.22],
                [radius, top - 0.3],
                [radius * 0.86, top - 0.12],
                [radius * 0.5, top - 0.02],
                [radius * 0.2, top],
                [0.0, top + 0.005],
            ],
            4,
        );
        engine.brass.add_at(&lathe(&dome, 48), DVec3::new(x, 0.0, 0.0));
    }
    let bell = spline(
        &[
            [0.0, 0.26],
            [0.06, 0.25],
            [0.1, 0.18],
            [0.12, 0.06],
            [0.19, 0.0],
            [0.17, 0.0],
            [0.0, 0.1],
        ]
        .map(|[r, y]| [r, 0.26 - y]),
        3,
    );
    let upside_down = along(DVec3::new(1.65, 3.62, 0.0), DVec3::NEG_Y);
    engine.brass.add(&lathe(&bell, 28), upside_down);
    for side in [-1.0_f64, 1.0] {
        let post = [DVec3::new(1.65, 3.1, 0.24 * side), DVec3::new(1.65, 3.62, 0.24 * side)];
        engine.iron.add_at(&rod(post[0], post[1], 0.03, 10), DVec3::ZERO);
        engine.iron.add_at(&rod(post[1], DVec3::new(1.65, 3.6, 0.0), 0.025, 10), DVec3::ZERO);
        let valve = spline(&[[0.1, 3.25], [0.07, 3.4], [0.05, 3.55], [0.07, 3.62], [0.0, 3.66]], 3);
        engine.brass.add_at(&lathe(&valve, 20), DVec3::new(-1.9, 0.0, 0.16 * side));
        handrail(engine, side);
    }
}

fn handrail(engine: &mut Engine, side: f64) {
    let at = |x: f64| DVec3::new(x, BOILER_Y + 0.42, 0.84 * side);
    engine.steel.add_at(&rod(at(-2.6), at(4.4), 0.02, 10), DVec3::ZERO);
    for k in 0..6 {
        let x = -2.3 + 1.3 * f64::from(k);
        let foot = DVec3::new(x, BOILER_Y + 0.38, 0.68 * side);
        engine.brass.add_at(&rod(foot, at(x), 0.016, 8), DVec3::ZERO);
        engine.brass.add_at(&ball(0.035, 10), at(x));
    }
    let pipe = bezier(
        [[1.0, 3.1, 0.35], [1.9, 3.0, 0.75], [2.9, 2.6, 0.98], [3.6, 1.35, 1.12]]
            .map(|[x, y, z]| DVec3::new(x, y, z * side)),
        40,
    );
    engine.iron.add_at(&tube(&pipe, 14, |_, _| 0.075), DVec3::ZERO);
}

fn headlamp(engine: &mut Engine) {
    let housing = points(&[
        [0.0, -0.34],
        [0.14, -0.32],
        [0.22, -0.24],
        [0.25, -0.1],
        [0.26, -0.02],
        [0.28, -0.015],
        [0.28, 0.03],
        [0.24, 0.03],
        [0.22, -0.03],
        [0.0, -0.04],
    ]);
    engine.brass.add(&lathe(&housing, 40), along(HEADLAMP, DVec3::X));
    let foot = HEADLAMP - DVec3::new(0.2, 0.2, 0.0);
    engine.iron.add_at(&rod(foot - DVec3::Y * 0.25, foot, 0.12, 14), DVec3::ZERO);
    let bracket = foot - DVec3::new(0.3, 0.3, 0.0);
    engine.iron.add_at(&rod(bracket, bracket + DVec3::X * 0.45, 0.07, 10), DVec3::ZERO);
}

fn cab(plates: &mut MeshBuilder) {
    for side in [-1.0_f64, 1.0] {
        let mut plate = |x: [f64; 2], y: [f64; 2]| {
            let (a, b) = (1.34 * side, 1.38 * side);
            plates.block(DVec3::new(x[0], y[0], a.min(b)), DVec3::new(x[1], y[1], a.max(b)));
        };
        plate([-4.5, -2.6], [1.3, 2.55]);
        plate([-4.5, -4.3], [2.55, 3.75]);
        plate([-3.6, -3.4], [2.55, 3.5]);
        plate([-2.8, -2.6], [2.55, 3.75]);
        plate([-4.3, -2.8], [3.5, 3.75]);
        let (a, b) = (0.95 * side, 1.4 * side);
        let (low, high) = (a.min(b), a.max(b));
        plates.block(DVec3::new(-2.64, 1.4, low), DVec3::new(-2.6, 3.8, high));
        let (a, b) = (0.86 * side, 1.36 * side);
        plates.beveled_block(
            DVec3::new(-2.7, 1.48, a.min(b)),
            DVec3::new(4.7, 1.56, a.max(b)),
            0.02,
        );
        plates.block(DVec3::new(-4.6, 1.18, a.min(b)), DVec3::new(4.7, 1.48, a.min(b) + 0.04));
    }
    plates.block(DVec3::new(-2.66, 3.1, -0.95), DVec3::new(-2.6, 3.85, 0.95));
    plates.block(DVec3::new(-4.6, 1.2, -1.38), DVec3::new(-2.6, 1.34, 1.38));
    roof(plates);
    plates.block(DVec3::new(-4.6, 0.75, -0.6), DVec3::new(4.5, 1.45, -0.5));
    plates.block(DVec3::new(-4.6, 0.75, 0.5), DVec3::new(4.5, 1.45, 0.6));
    plates.beveled_block(DVec3::new(4.5, 0.95, -1.4), DVec3::new(4.8, 1.5, 1.4), 0.03);
}

/// The cab's roof, a low vault.
fn roof(plates: &mut MeshBuilder) {
    const PIECES: u32 = 14;
    let rib = |k: u32, x: f64, lift: f64| {
        let across = 2.0 * f64::from(k) / f64::from(PIECES) - 1.0;
        DVec3::new(x, 3.72 + 0.38 * (1.0 - across * across) + lift, 1.52 * across)
    };
    for k in 0..PIECES {
        for lift in [0.0, 0.06] {
            plates.face([
                rib(k, -4.8, lift),
                rib(k + 1, -4.8, lift),
                rib(k + 1, -2.3, lift),
                rib(k, -2.3, lift),
            ]);
        }
        for x in [-4.8, -2.3] {
            plates.face([rib(k, x, 0.0), rib(k + 1, x, 0.0), rib(k + 1, x, 0.06), rib(k, x, 0.06)]);
        }
    }
}

/// The cowcatcher and the coupling.
fn pilot(engine: &mut Engine) {
    for k in -6..=6 {
        let z = f64::from(k) / 6.0;
        let high = DVec3::new(4.8, 0.98, z * 1.25);
        let low = DVec3::new(5.75 - 0.75 * z.abs(), 0.2, z * 1.1);
        engine.wheels.add_at(&rod(high, low, 0.045, 8), DVec3::ZERO);
    }
    for side in [-1.0_f64, 1.0] {
        let nose = DVec3::new(5.8, 0.2, 0.0);
        let end = DVec3::new(5.02, 0.2, 1.14 * side);
        engine.wheels.add_at(&rod(nose, end, 0.06, 10), DVec3::ZERO);
        let buffer =
            points(&[[0.0, 0.0], [0.09, 0.0], [0.1, 0.3], [0.24, 0.32], [0.23, 0.36], [0.0, 0.39]]);
        engine.steel.add(&lathe(&buffer, 28), along(DVec3::new(4.8, 1.25, 0.95 * side), DVec3::X));
    }
}
