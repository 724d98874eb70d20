//! Tubes along curves.

use super::MeshBuilder;
use glam::{DAffine3, DQuat, DVec3};
use std::f64::consts::TAU;

/// A tube through the points of `path` whose radius [m] at each place of the path and angle [rad]
/// is `radius`; its ends are closed flat.
pub fn tube(path: &[DVec3], segments: usize, radius: impl Fn(usize, f64) -> f64) -> MeshBuilder {
    let mut built = MeshBuilder::default();
    let mut tangent = direction(path, 0);
    let mut side = tangent.any_orthonormal_vector();
    let mut rings: Vec<Vec<u32>> = Vec::with_capacity(path.len());
    for (k, center) in path.iter().enumerate() {
        let turned = direction(path, k);
        // Parallel transport: the ring follows the bend and never twists.
        side = DQuat::from_rotation_arc(tangent, turned) * side;
        tangent = turned;
        let across = tangent.cross(side);
        let ring = (0..segments).map(|s| {
            let angle = TAU * s as f64 / segments as f64;
            let out = side * angle.cos() + across * angle.sin();
            built.vertex(*center + out * radius(k, angle))
        });
        rings.push(ring.collect());
    }
    for pair in rings.windows(2) {
        for s in 0..segments {
            let next = (s + 1) % segments;
            built.quad([pair[0][s], pair[0][next], pair[1][next], pair[1][s]]);
        }
    }
    if let (Some(first), Some(last)) = (rings.first(), rings.last()) {
        for s in 1..segments - 1 {
            built.triangle([first[0], first[s + 1], first[s]]);
            built.triangle([last[0], last[s], last[s + 1]]);
        }
    }
    built
}

/// A round rod from `a` to `b`.
pub fn rod(a: DVec3, b: DVec3, radius: f64, segments: usize) -> MeshBuilder {
    tube(&[a, b], segments, |_, _| radius)
}

/// Points along the cubic Bézier curve of four control points, both ends included.
pub fn bezier([a, b, c, d]: [DVec3; 4], pieces: usize) -> Vec<DVec3> {
    (0..=pieces)
        .map(|k| {
            let t = k as f64 / pieces as f64;
            let s = 1.0 - t;
            a * (s * s * s) + b * (3.0 * s * s * t) + c * (3.0 * s * t * t) + d * (t * t * t)
        })
        .collect()
}

/// Turns what stands upright at the origin to point along `direction` from `foot`.
pub fn along(foot: DVec3, direction: DVec3) -> DAffine3 {
    let turn = DQuat::from_rotation_arc(DVec3::Y, direction.normalize_or(DVec3::Y));
    DAffine3::from_rotation_translation(turn, foot)
}

fn direction(path: &[DVec3], k: usize) -> DVec3 {
    let before = path[k.saturating_sub(1)];
    let after = path[(k + 1).min(path.len() - 1)];
    (after - before).normalize_or(DVec3::Y)
}
