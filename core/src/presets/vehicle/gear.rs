//! Wheels, rods and cylinders.

use super::super::geometry::{MeshBuilder, along, lathe, rod, tube};
use super::engine::Engine;
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Where the driving axles are along the engine [m].
const DRIVERS: [f64; 3] = [-2.0, -0.1, 1.8];
const DRIVER_RADIUS: f64 = 0.84;
/// Where the small leading axles are [m].
const LEADERS: [f64; 2] = [3.1, 4.2];
const LEADER_RADIUS: f64 = 0.46;
/// Top of the rails [m].
pub const RAIL_TOP: f64 = 0.16;
/// Half the distance between the rails [m].
pub const HALF_GAUGE: f64 = 0.78;
/// Where the cranks stand in this moment [rad].
const CRANK_ANGLE: f64 = -0.6;

/// Everything that turns and drives.
pub fn running_gear(engine: &mut Engine) {
    let driver = wheel(DRIVER_RADIUS, 14, true);
    let leader = wheel(LEADER_RADIUS, 10, false);
    for side in [-1.0_f64, 1.0] {
        let hub = |x: f64, radius: f64| DVec3::new(x, RAIL_TOP + radius, HALF_GAUGE * side);
        for x in DRIVERS {
            engine.wheels.add(&driver, along(hub(x, DRIVER_RADIUS), DVec3::Z * side));
        }
        for x in LEADERS {
            engine.wheels.add(&leader, along(hub(x, LEADER_RADIUS), DVec3::Z * side));
        }
        rods(engine, side);
        cylinder(engine, side);
    }
    let axles = DRIVERS.map(|x| (x, DRIVER_RADIUS)).into_iter();
    for (x, radius) in axles.chain(LEADERS.map(|x| (x, LEADER_RADIUS))) {
        let end = DVec3::new(x, RAIL_TOP + radius, HALF_GAUGE);
        engine.steel.add_at(&rod(end * DVec3::new(1.0, 1.0, -1.0), end, 0.08, 16), DVec3::ZERO);
    }
}

/// A spoked wheel about the y axis, its outer face towards +y.
fn wheel(radius: f64, spokes: u32, crank: bool) -> MeshBuilder {
    let rim = radius - 0.12;
    let tyre = [
        [rim, -0.06],
        [radius + 0.035, -0.07],
        [radius + 0.035, -0.045],
        [radius, -0.03],
        [radius - 0.008, 0.06],
        [radius - 0.02, 0.07],
        [radius - 0.06, 0.07],
        [radius - 0.065, 0.055],
        [rim, 0.05],
        [rim, -0.06],
    ];
    let hub = [
        [0.0, -0.1],
        [0.15, -0.1],
        [0.17, -0.08],
        [0.17, 0.09],
        [0.14, 0.12],
        [0.06, 0.125],
        [0.0, 0.125],
    ];
    let ring = |list: &[[f64; 2]], segments: usize| {
        let profile: Vec<DVec2> = list.iter().map(|p| DVec2::from_array(*p)).collect();
        lathe(&profile, segments)
    };
    let mut wheel = ring(&tyre, 64);
    wheel.add_at(&ring(&hub, 32), DVec3::ZERO);
    for k in 0..spokes {
        let angle = TAU * f64::from(k) / f64::from(spokes);
        let out = DVec3::new(angle.cos(), 0.0, angle.sin());
        let path: Vec<DVec3> =
            (0..=4).map(|p| out * (0.15 + (rim - 0.13) * f64::from(p) / 4.0)).collect();
        // Flat spokes that widen towards the hub.
        let spoke =
            tube(&path, 10, |k, a| (0.055 - 0.006 * k as f64) * (0.8 + 0.3 * (2.0 * a).cos()));
        wheel.add_at(&spoke, DVec3::ZERO);
    }
    if crank {
        wheel.add_at(&counterweight(rim), DVec3::ZERO);
    }
    wheel
}

/// The crescent opposite to the crank pin.
fn counterweight(rim: f64) -> MeshBuilder {
    const PIECES: u32 = 16;
    let mut weight = MeshBuilder::default();
    let corner = |k: u32, outer: bool, y: f64| {
        let angle = CRANK_ANGLE + TAU / 2.0 - 0.75 + 1.5 * f64::from(k) / f64::from(PIECES);
        let chord = (rim - 0.26) / (angle - CRANK_ANGLE - TAU / 2.0).cos();
        let radius = if outer { rim + 0.02 } else { chord.min(rim + 0.01) };
        DVec3::new(radius * angle.cos(), y, -radius * angle.sin())
    };
    for k in 0..PIECES {
        for y in [-0.05, 0.07] {
            weight.face([
                corner(k, false, y),
                corner(k, true, y),
                corner(k + 1, true, y),
                corner(k + 1, false, y),
            ]);
        }
        weight.face([
            corner(k, false, -0.05),
            corner(k, false, 0.07),
            corner(k + 1, false, 0.07),
            corner(k + 1, false, -0.05),
        ]);
    }
    weight
}

/// Coupling rod, main rod, crosshead and slide bars of one side.
fn rods(engine: &mut Engine, side: f64) {
    let pin = |x: f64, out: f64| {
        let axle = DVec3::new(x, RAIL_TOP + DRIVER_RADIUS, (HALF_GAUGE + out) * side);
        axle + DVec3::new(CRANK_ANGLE.cos(), CRANK_ANGLE.sin(), 0.0) * 0.32
    };
    for x in DRIVERS {
        engine.steel.add_at(&rod(pin(x, 0.05), pin(x, 0.36), 0.06, 14), DVec3::ZERO);
        let eye = rod(pin(x, 0.17), pin(x, 0.25), 0.13, 20);
        engine.steel.add_at(&eye, DVec3::ZERO);
    }
    bar(&mut engine.steel, pin(DRIVERS[0], 0.21), pin(DRIVERS[2], 0.21), [0.075, 0.03]);
    let crosshead = DVec3::new(2.55, 1.0, 1.12 * side);
    bar(&mut engine.steel, pin(DRIVERS[1], 0.31), crosshead, [0.07, 0.028]);
    let half = DVec3::new(0.16, 0.13, 0.07);
    engine.steel.beveled_block(crosshead - half, crosshead + half, 0.02);
    engine.steel.add_at(&rod(crosshead, DVec3::new(3.3, 1.0, crosshead.z), 0.04, 14), DVec3::ZERO);
    for y in [0.83, 1.17] {
        let low = DVec3::new(2.0, y - 0.025, crosshead.z - 0.05);
        engine.steel.block(low, DVec3::new(3.3, y + 0.025, crosshead.z + 0.05));
    }
}

/// A flat bar from `a` to `b` with half its height and half its thickness [m].
fn bar(built: &mut MeshBuilder, a: DVec3, b: DVec3, [high, thick]: [f64; 2]) {
    let up = (b - a).normalize().cross(DVec3::Z).normalize() * high;
    let out = DVec3::Z * thick;
    let ring = |p: DVec3| [p - up - out, p + up - out, p + up + out, p - up + out];
    let (start, end) = (ring(a).map(|p| built.vertex(p)), ring(b).map(|p| built.vertex(p)));
    for k in 0..4 {
        let next = (k + 1) % 4;
        built.quad([start[k], start[next], end[next], end[k]]);
    }
    built.quad(end);
    built.quad([start[3], start[2], start[1], start[0]]);
}

fn cylinder(engine: &mut Engine, side: f64) {
    let profile = [
        [0.0, 0.0],
        [0.34, 0.0],
        [0.36, 0.03],
        [0.36, 0.1],
        [0.33, 0.12],
        [0.33, 0.85],
        [0.36, 0.87],
        [0.36, 0.94],
        [0.33, 0.97],
        [0.18, 1.0],
        [0.12, 1.06],
        [0.0, 1.07],
    ];
    let profile: Vec<DVec2> = profile.iter().map(|p| DVec2::from_array(*p)).collect();
    let place = DVec3::new(3.2, 1.0, 1.12 * side);
    engine.iron.add(&lathe(&profile, 40), along(place, DVec3::X));
    let (a, b) = (0.86 * side, 1.38 * side);
    let (low, high) = (DVec3::new(3.28, 1.2, a.min(b)), DVec3::new(4.15, 1.5, a.max(b)));
    engine.iron.beveled_block(low, high, 0.04);
}
