//! T(v, b) and T(s, b) for all blobs at once (Fogshop 5.1): centres are sorted by their direction
//! from the start of the paths, and neighbours share one list of the blobs in their way. Where
//! blobs are local the work grows with n log n, not n².

use super::{blobs, depth_to_center};
use crate::geometry::Ray;
use crate::geometry::batch::{Rays, SIZE};
use crate::geometry::bundle::Bundle;
use crate::media::{Field, Medium as _, Purpose};
use crate::progress::{Interrupted, Job};
use glam::{DVec2, DVec3, Vec2Swizzles as _};
use rayon::prelude::*;

/// Centres that share a list: few enough to lie close together.
const GROUP: usize = 64;

/// Half depth from which a blob's own part must be exact; 2e-6 of it is 2e-4.
const DENSE: f64 = 100.0;

/// Optical depth of all blobs from the start of each path to each blob's centre.
///
/// # Errors
/// [`Interrupted`] when the job's progress says so.
pub fn depths(
    job: &Job,
    field: &Field,
    start: impl Fn(DVec3) -> DVec3 + Sync,
) -> Result<Vec<f64>, Interrupted> {
    let blobs = blobs(field);
    let path = |i: &usize| {
        let from = start(blobs[*i].center);
        let (ray, length) = Ray::between(from, blobs[*i].center);
        (from, ray.direction, length)
    };
    let mut order: Vec<usize> = (0..blobs.len()).collect();
    order.sort_by_cached_key(|i| curve_key(path(i).1, path(i).0));
    let groups = order.par_chunks(GROUP).map(|group| {
        job.progress.check()?;
        let paths: Vec<_> = group.iter().map(path).collect();
        let mut depths = group_depths(job, field, &paths);
        for (i, depth) in group.iter().zip(&mut depths) {
            // A dense blob's own part is taken out again in f64 (Fogshop 12): f32 would leave 2e-6 of it.
            if blobs[*i].half_depth() > DENSE {
                job.progress.check()?;
                let center = blobs[*i].center;
                *depth = depth_to_center(field, start(center), center);
            }
        }
        Ok(depths)
    });
    let groups = groups.collect::<Result<Vec<_>, Interrupted>>()?;
    job.progress.check()?;
    let mut depths = vec![0.0; blobs.len()];
    for (i, depth) in order.into_iter().zip(groups.into_iter().flatten()) {
        depths[i] = depth;
    }
    Ok(depths)
}

fn group_depths(job: &Job, field: &Field, paths: &[(DVec3, DVec3, f64)]) -> Vec<f64> {
    let rays: Vec<_> = paths.iter().map(|p| (p.0, p.1)).collect();
    let longest = paths.iter().map(|p| p.2).fold(0.0, f64::max);
    let shortest = paths.iter().map(|p| p.2).fold(f64::INFINITY, f64::min);
    let Some(bundle) = Bundle::around(&rays, longest) else {
        return match paths {
            [path] => vec![depth_to_center(field, path.0, path.0 + path.2 * path.1)],
            _ => {
                let (a, b) = paths.split_at(paths.len() / 2);
                [group_depths(job, field, a), group_depths(job, field, b)].concat()
            }
        };
    };
    let gaussians = &field.only().gaussians;
    let search = field.search_for(gaussians, bundle, shortest, Purpose::Depth);
    let list = gaussians.near(job.level, &search);
    let mut batch = Rays::empty();
    let mut length = [0.0; SIZE];
    for (at, (from, direction, distance)) in paths.iter().enumerate() {
        batch.set_ray(at, (*from - bundle.origin, *direction));
        length[at] = *distance as f32;
    }
    batch.count = paths.len();
    let mut depth = [0.0; SIZE];
    list.add_depth(job, &batch, true, &length, &mut depth);
    depth[..paths.len()].iter().map(|d| f64::from(*d)).collect()
}

/// Place of a direction on a space-filling curve over the octahedral map of directions; paths in
/// parallel directions are told apart by where they start.
fn curve_key(direction: DVec3, start: DVec3) -> (u32, u64) {
    let on = direction / (direction.x.abs() + direction.y.abs() + direction.z.abs());
    let flat = DVec2::new(on.x, on.y);
    let folded = if on.z >= 0.0 {
        flat
    } else {
        (1.0 - flat.yx().abs()) * DVec2::new(flat.x.signum(), flat.y.signum())
    };
    let cell = |v: f64| ((v * 0.5 + 0.5) * 65535.0) as u32;
    let key = spread(cell(folded.x)) | spread(cell(folded.y)) << 1;
    (key, start.length_squared().to_bits())
}

/// Moves the low 16 bits to the even places.
fn spread(v: u32) -> u32 {
    let v = (v | v << 8) & 0x00ff_00ff;
    let v = (v | v << 4) & 0x0f0f_0f0f;
    let v = (v | v << 2) & 0x3333_3333;
    (v | v << 1) & 0x5555_5555
}
