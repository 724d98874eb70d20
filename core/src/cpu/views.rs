//! What bounds batches of view rays, and the fog near them.

use crate::frame::context::Context;
use crate::geometry::batch::{Ends, Rays, get3, load3};
use crate::geometry::bundle::Bundle;
use crate::media::{Near, Purpose, Sum};
use crate::num::{Lanes, Num};
use crate::vector::V3;
use fearless_simd::{Simd, dispatch};
use glam::Vec3;

/// What matters of the fog to some batches of view rays.
pub fn near_views(context: &Context, block: &[Ends<'_>], purpose: Purpose) -> Sum<dyn Near> {
    let (bundle, shortest) = bundle_of_views(context, block);
    context.field.near(context.job.level, bundle, shortest, purpose)
}

/// Bounds some batches of view rays; and the shortest of them.
pub fn bundle_of_views(context: &Context, block: &[Ends<'_>]) -> (Bundle, f64) {
    let position = context.viewpoint.position;
    let [shortest, longest] = lengths(context, block).map(f64::from);
    // Rays that spread too far for any bound: a picture of a few pixels under a wide angle.
    match bundle(context, block, longest) {
        Some(bundle) => (bundle, shortest),
        None => (Bundle::all_around(position, longest), 0.0),
    }
}

/// The shortest and the longest of some batches of view rays [m].
pub fn lengths(context: &Context, block: &[Ends<'_>]) -> [f32; 2] {
    block.iter().fold([f32::INFINITY, 0.0], |[shortest, longest], Ends { rays, hits }| {
        let own = &hits.length[..rays.count];
        let [least, most] = dispatch!(context.job.level, simd => Lanes::extremes(simd, own));
        [shortest.min(least), longest.max(most)]
    })
}

/// Bounds view rays around the camera: in f32, by chords, which keep the digits of small angles.
fn bundle(context: &Context, block: &[Ends<'_>], longest: f64) -> Option<Bundle> {
    let places = || block.iter().flat_map(|ends| (0..ends.rays.count).map(|at| (ends.rays, at)));
    let direction = |(rays, at): (&Rays, usize)| get3(&rays.direction, at);
    let axis = places().map(direction).sum::<Vec3>().normalize();
    let (mut chord2, mut radius2) = (0.0f32, 0.0f32);
    for Ends { rays, .. } in block {
        let [chord, radius] = dispatch!(context.job.level, simd => spread(simd, rays, axis));
        (chord2, radius2) = (chord2.max(chord), radius2.max(radius));
    }
    let half = 0.5 * f64::from(chord2).sqrt() + 1e-7;
    let cos = 1.0 - 2.0 * half * half;
    if cos < 0.17 {
        return None;
    }
    let tan = (1.0 - cos * cos).sqrt() / cos;
    let radius = f64::from(radius2).sqrt() * 1.000_001;
    let axis = axis.as_dvec3().normalize();
    let origin = context.viewpoint.position;
    Some(Bundle { origin, axis, radius, tan, length: longest + radius })
}

/// The largest squares of the distance of rays' directions from an axis, and of where they start. What fills a
/// batch up repeats its last ray.
#[inline(always)]
fn spread<S: Simd>(simd: S, rays: &Rays, axis: Vec3) -> [f32; 2] {
    let axis = V3::splat(simd, axis.to_array());
    let (mut chord2, mut radius2) = (Lanes::splat(simd, 0.0), Lanes::splat(simd, 0.0));
    for at in (0..rays.count).step_by(Lanes::<S>::COUNT) {
        let off = load3(simd, &rays.direction, at) - axis;
        let start = load3(simd, &rays.offset, at);
        chord2 = chord2.max(off.plain_dot(off));
        radius2 = radius2.max(start.plain_dot(start));
    }
    [chord2.largest(), radius2.largest()]
}
