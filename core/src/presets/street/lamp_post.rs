//! A cast-iron lamp post, and the stone vases.

use super::super::geometry::{MeshBuilder, ball, bezier, lathe, lathe_with, spline, tube};
use glam::{DAffine3, DVec2, DVec3};
use std::f64::consts::TAU;

/// Height of the middle of the globe above the foot of the post [m].
pub const GLOBE_HEIGHT: f64 = 3.7;
/// Radius of the globe [m].
pub const GLOBE_RADIUS: f64 = 0.17;

/// A post with its foot at the origin, without its globe.
pub fn lamp_post() -> MeshBuilder {
    let foot =
        spline(&[[0.0, 0.0], [0.2, 0.0], [0.21, 0.05], [0.19, 0.1], [0.16, 0.16], [0.15, 0.55]], 4);
    let collar = spline(
        &[[0.15, 0.55], [0.17, 0.6], [0.13, 0.66], [0.075, 0.75], [0.085, 0.8], [0.07, 0.86]],
        4,
    );
    let mut post = lathe(&foot, 24);
    post.add_at(&lathe(&collar, 24), DVec3::ZERO);
    let shaft: Vec<DVec2> = (0..=10)
        .map(|k| DVec2::new(0.07 - 0.0025 * f64::from(k), 0.86 + 0.21 * f64::from(k)))
        .collect();
    post.add_at(
        &lathe_with(&shaft, 40, |angle, _| 1.0 - 0.06 * (10.0 * angle).cos().abs()),
        DVec3::ZERO,
    );
    let head = spline(
        &[
            [0.045, 2.96],
            [0.075, 2.99],
            [0.075, 3.03],
            [0.04, 3.08],
            [0.035, 3.28],
            [0.06, 3.36],
            [0.13, 3.46],
            [0.145, 3.52],
            [0.13, 3.54],
            [0.0, 3.54],
        ],
        4,
    );
    post.add_at(&lathe(&head, 24), DVec3::ZERO);
    post.add_at(&finial(), DVec3::new(0.0, GLOBE_HEIGHT, 0.0));
    for side in [-1.0, 1.0] {
        post.add_at(&ladder_arm(side), DVec3::new(0.0, 3.02, 0.0));
    }
    post
}

/// The cap on the globe.
fn finial() -> MeshBuilder {
    let profile = spline(
        &[
            [0.11, 0.13],
            [0.115, 0.15],
            [0.07, 0.19],
            [0.03, 0.22],
            [0.035, 0.25],
            [0.02, 0.28],
            [0.0, 0.34],
        ],
        3,
    );
    lathe(&profile, 20)
}

/// One scroll of the bar that a ladder leans on.
fn ladder_arm(side: f64) -> MeshBuilder {
    let path = bezier(
        [[0.0, 0.0], [0.16, 0.1], [0.34, 0.05], [0.34, -0.09]]
            .map(|[out, up]| DVec3::new(0.0, up, side * out)),
        14,
    );
    let mut arm = tube(&path, 8, |_, _| 0.016);
    arm.add_at(&ball(0.032, 10), path[path.len() - 1]);
    arm
}

/// A garden vase of height 0.95 m with gadroons around its belly.
pub fn vase() -> MeshBuilder {
    let profile = spline(
        &[
            [0.0, 0.0],
            [0.19, 0.0],
            [0.2, 0.04],
            [0.12, 0.1],
            [0.07, 0.17],
            [0.1, 0.2],
            [0.08, 0.23],
            [0.2, 0.32],
            [0.3, 0.47],
            [0.28, 0.6],
            [0.18, 0.7],
            [0.17, 0.76],
            [0.25, 0.86],
            [0.33, 0.91],
            [0.33, 0.95],
            [0.27, 0.93],
            [0.14, 0.82],
            [0.0, 0.8],
        ],
        2,
    );
    let heights: Vec<f64> = profile.iter().map(|p| p.y).collect();
    lathe_with(&profile, 56, move |angle, k| {
        let belly = ((heights[k] - 0.24) / 0.22).clamp(0.0, 1.0)
            * ((0.62 - heights[k]) / 0.1).clamp(0.0, 1.0);
        1.0 + 0.045 * belly * (14.0 * angle).cos()
    })
}

/// A fluted column of height 4 m with base and capital; its foot stands at the origin.
pub fn column() -> MeshBuilder {
    let base = spline(
        &[
            [0.42, 0.18],
            [0.46, 0.23],
            [0.42, 0.29],
            [0.36, 0.32],
            [0.37, 0.36],
            [0.39, 0.4],
            [0.36, 0.44],
            [0.325, 0.46],
        ],
        2,
    );
    let capital = spline(
        &[
            [0.275, 3.5],
            [0.31, 3.53],
            [0.28, 3.57],
            [0.28, 3.68],
            [0.33, 3.72],
            [0.42, 3.8],
            [0.43, 3.83],
        ],
        2,
    );
    let mut column = lathe(&base, 32);
    column.add_at(&shaft(), DVec3::ZERO);
    column.add_at(&lathe(&capital, 32), DVec3::ZERO);
    for (low, high, half) in [(0.0, 0.18, 0.47), (3.83, 4.0, 0.45)] {
        column.beveled_block(DVec3::new(-half, low, -half), DVec3::new(half, high, half), 0.02);
    }
    column
}

/// The column's shaft with its flutes.
fn shaft() -> MeshBuilder {
    const FLUTES: f64 = 16.0;
    let profile = [0.46, 0.56, 1.6, 2.7, 3.4, 3.5].map(|y| {
        let up = (y - 0.46) / 3.04;
        // Entasis: the taper is a curve, so that the column seems to carry.
        DVec2::new(0.325 - 0.05 * up * up, y)
    });
    lathe_with(&profile, 96, |angle, k| match k {
        0 | 5 => 1.0,
        _ => 1.0 - 0.07 * (0.5 - 0.5 * (FLUTES * angle).cos()).powf(0.6),
    })
}

/// Where a thing that stands upright goes, turned about its axis by `turns` of a full circle.
pub fn upright(foot: DVec3, turns: f64) -> DAffine3 {
    DAffine3::from_translation(foot) * DAffine3::from_rotation_y(TAU * turns)
}
