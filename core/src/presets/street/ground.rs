//! Cobbles, kerbs and paving slabs.

use super::super::geometry::MeshBuilder;
use crate::random::Random;
use glam::DVec3;

/// Half the width of the road [m].
pub const ROAD_HALF: f64 = 2.6;
/// Height of the pavements above the gutter [m].
pub const KERB: f64 = 0.14;
/// The street runs along z from here, behind the camera …
pub const NEAR_Z: f64 = 11.0;
/// … to here [m].
pub const FAR_Z: f64 = -46.0;

/// Rows of worn stones over a cambered road; their length grows with the distance from the camera,
/// where single stones could not be seen.
pub fn cobbles(random: &mut Random) -> MeshBuilder {
    const COLUMNS: usize = 15;
    let width = 2.0 * ROAD_HALF / COLUMNS as f64;
    let mut stones = MeshBuilder::default();
    let (mut z, mut row) = (NEAR_Z, 0);
    while z > FAR_Z {
        let length = (0.2 + 0.004 * (NEAR_Z - z)) * random.between(0.9, 1.1);
        let shift = if row % 2 == 0 { 0.0 } else { width / 2.0 };
        for column in 0..=COLUMNS {
            let edge = -ROAD_HALF + column as f64 * width - shift;
            let (x, right) = (edge.max(-ROAD_HALF), (edge + width).min(ROAD_HALF));
            if right - x < 0.04 {
                continue;
            }
            let top = camber((x + right) / 2.0) + random.between(-0.006, 0.006);
            let min = DVec3::new(x + 0.006, -0.05, z - length + 0.006);
            let max = DVec3::new(right - 0.006, top, z - 0.006);
            stone(&mut stones, [min, max], 0.022, random);
        }
        z -= length;
        row += 1;
    }
    stones
}

/// Height of the road's crown above its gutters [m].
fn camber(x: f64) -> f64 {
    0.07 * (1.0 - (x / ROAD_HALF).powi(2)).max(0.0)
}

/// What shows in the joints between the stones.
pub fn bed() -> MeshBuilder {
    const STRIPS: i32 = 12;
    let mut bed = MeshBuilder::default();
    let (near, far) = (NEAR_Z, FAR_Z - 8.0);
    for side in [-1.0_f64, 1.0] {
        let x = [side * ROAD_HALF, side * 9.0];
        let low = DVec3::new(x[0].min(x[1]), -0.4, far);
        bed.block(low, DVec3::new(x[0].max(x[1]), KERB - 0.04, near));
    }
    for strip in 0..STRIPS {
        let at = |k: i32, z: f64| {
            let x = ROAD_HALF * (2.0 * f64::from(k) / f64::from(STRIPS) - 1.0);
            DVec3::new(x, camber(x) - 0.028, z)
        };
        bed.face([at(strip, near), at(strip + 1, near), at(strip + 1, far), at(strip, far)]);
    }
    bed
}

/// A stone without its underside, its top a little tilted.
fn stone(stones: &mut MeshBuilder, [min, max]: [DVec3; 2], bevel: f64, random: &mut Random) {
    const TILT: f64 = 0.004;
    let ring = |inset: f64| {
        let (x0, x1) = (min.x + inset, max.x - inset);
        let (z0, z1) = (min.z + inset, max.z - inset);
        [(x0, z0), (x0, z1), (x1, z1), (x1, z0)]
    };
    let shoulder = max.y - bevel;
    let low = ring(0.0).map(|(x, z)| stones.vertex(DVec3::new(x, shoulder - 0.012, z)));
    let high = ring(bevel)
        .map(|(x, z)| stones.vertex(DVec3::new(x, max.y + random.between(-TILT, TILT), z)));
    for k in 0..4 {
        let next = (k + 1) % 4;
        stones.quad([low[k], low[next], high[next], high[k]]);
    }
    stones.quad(high);
}

/// Kerbstones and slabs on both sides of the road.
pub fn pavements(random: &mut Random) -> MeshBuilder {
    let mut stones = MeshBuilder::default();
    for side in [-1.0_f64, 1.0] {
        let mut strip = |inner: f64, outer: f64, length: f64, top: f64| {
            let (a, b) = (side * inner, side * outer);
            let (x0, x1) = (a.min(b), a.max(b));
            let mut z = NEAR_Z;
            while z > FAR_Z {
                let step = length * random.between(0.85, 1.15);
                let min = DVec3::new(x0 + 0.004, -0.05, z - step + 0.004);
                let top = top + random.between(-0.003, 0.003);
                stone(&mut stones, [min, DVec3::new(x1 - 0.004, top, z - 0.004)], 0.012, random);
                z -= step;
            }
        };
        strip(ROAD_HALF, ROAD_HALF + 0.26, 1.0, KERB + 0.01);
        for k in 0..3 {
            let inner = ROAD_HALF + 0.26 + 0.72 * f64::from(k);
            strip(inner, inner + 0.72, 0.9, KERB);
        }
    }
    stones
}
