//! Surfaces of revolution about the y axis.

use super::MeshBuilder;
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// A surface of revolution about the y axis: `profile` holds (radius, height) [m], and the outside
/// lies to the right of its way (bottom to top for a vase).
pub fn lathe(profile: &[DVec2], segments: usize) -> MeshBuilder {
    lathe_with(profile, segments, |_, _| 1.0)
}

/// As [`lathe`], the radius multiplied by a function of the angle [rad] and the place in the
/// profile: flutes, lobes, scales.
pub fn lathe_with(
    profile: &[DVec2],
    segments: usize,
    factor: impl Fn(f64, usize) -> f64,
) -> MeshBuilder {
    const POLE: f64 = 1e-6;
    let mut built = MeshBuilder::default();
    let rings: Vec<Vec<u32>> = profile
        .iter()
        .enumerate()
        .map(|(k, p)| match p.x < POLE {
            true => vec![built.vertex(DVec3::new(0.0, p.y, 0.0))],
            false => (0..segments)
                .map(|s| {
                    let angle = TAU * s as f64 / segments as f64;
                    let radius = p.x * factor(angle, k);
                    built.vertex(DVec3::new(radius * angle.cos(), p.y, radius * angle.sin()))
                })
                .collect(),
        })
        .collect();
    for pair in rings.windows(2) {
        join(&mut built, &pair[0], &pair[1]);
    }
    built
}

/// Closes the strip between two rings; one of them may be a pole.
fn join(built: &mut MeshBuilder, low: &[u32], high: &[u32]) {
    let segments = low.len().max(high.len());
    for s in 0..segments {
        let next = (s + 1) % segments;
        match (low.len(), high.len()) {
            (1, 1) => {}
            (1, _) => built.triangle([low[0], high[s], high[next]]),
            (_, 1) => built.triangle([low[s], high[0], low[next]]),
            _ => built.quad([low[s], high[s], high[next], low[next]]),
        }
    }
}

/// A smooth curve through all points (Catmull-Rom), each span cut into `cuts` pieces.
pub fn spline(points: &[[f64; 2]], cuts: usize) -> Vec<DVec2> {
    let last = points.len() - 1;
    let at = |k: isize| DVec2::from_array(points[k.clamp(0, last as isize) as usize]);
    let mut curve = Vec::with_capacity(last * cuts + 1);
    for span in 0..last as isize {
        let [p0, p1, p2, p3] = [at(span - 1), at(span), at(span + 1), at(span + 2)];
        for cut in 0..cuts {
            let t = cut as f64 / cuts as f64;
            let linear = (p2 - p0) * t;
            let square = (p0 * 2.0 - p1 * 5.0 + p2 * 4.0 - p3) * (t * t);
            let cube = (p1 * 3.0 - p0 - p2 * 3.0 + p3) * (t * t * t);
            curve.push((p1 * 2.0 + linear + square + cube) * 0.5);
        }
    }
    curve.push(at(last as isize));
    for point in &mut curve {
        // The curve may swing past the axis next to a pole.
        point.x = point.x.max(0.0);
    }
    curve
}

/// A ball about the origin.
pub fn ball(radius: f64, segments: usize) -> MeshBuilder {
    let rings = segments / 2;
    let profile: Vec<DVec2> = (0..=rings)
        .map(|k| {
            let latitude = PI * k as f64 / rings as f64 - FRAC_PI_2;
            DVec2::new(latitude.cos(), latitude.sin()) * radius
        })
        .collect();
    lathe(&profile, segments)
}
