//! Fog at the corners of meshes (Biri and Michelin 2002, section 4.3): optical depth is computed once for every corner
//! that is seen, and is linear across triangles. A triangle over whose corners it differs too much is
//! not dense enough: its pixels are computed themselves, as are those of all other surfaces.

use super::fog;
use super::tiles::{Strip, tiles};
use super::traced::Traced;
use super::upsample::subset;
use crate::frame::context::Context;
use crate::frame::samples::CENTER;
use crate::geometry::batch::{Ends, Fogged, Hits, OnTriangles, Rays, SIZE};
use crate::progress::Interrupted;
use crate::shapes::Corners;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// What fog lets through may differ by so much between a triangle's corners: where it rises or falls from side to side
/// a straight line between them is off by less.
const LIKE: f32 = 0.06;
/// No side of a triangle may be longer than this share of the picture's height, as it is seen: fog between corners
/// that stand farther apart is another one.
const DENSE: f32 = 1.0 / 24.0;

/// Of more rays than this it is cheaper to compute a whole batch than to gather them.
const FEW: usize = SIZE / 8;

/// Fog at corners.
pub struct AtCorners<'a> {
    corners: &'a Corners,
    /// Optical depth by corner; of those that are not seen nothing is known.
    depths: Vec<f32>,
}

impl<'a> AtCorners<'a> {
    /// At all corners of the triangles that are seen in a strip.
    ///
    /// # Errors
    /// [`Interrupted`] when the job's progress says so.
    pub fn new(context: &Context<'a>, traced: &Traced, strip: &Strip) -> Result<Self, Interrupted> {
        let corners = context.geometry.corners();
        let seen = seen(context, traced, strip, corners)?;
        let mut depths = vec![0.0; corners.places.len()];
        let batches = seen.par_chunks(SIZE).map(|places| {
            let clear = Fogged::clear(0);
            let is_over = context.job.progress.is_over();
            let fogged = if is_over { clear } else { fog_at(context, corners, places) };
            (places, fogged)
        });
        for (places, fogged) in batches.collect::<Vec<_>>() {
            for (place, depth) in places.iter().zip(fogged.depth) {
                depths[*place as usize] = depth;
            }
        }
        context.job.progress.check()?;
        Ok(Self { corners, depths })
    }

    /// Optical depth along rays.
    pub fn fog(&self, context: &Context, Ends { rays, hits }: Ends<'_>) -> Fogged {
        let mut fogged = Fogged::clear(0);
        let mut missing = Vec::new();
        let height = seen_height(context);
        for at in 0..rays.count {
            let on =
                hits.triangles.as_ref().filter(|on| is_dense(height, self.corners, on, hits, at));
            match on.and_then(|on| self.depth(on, at)) {
                Some(depth) => fogged.depth[at] = depth,
                None => missing.push(at),
            }
        }
        if missing.len() > FEW {
            let exact = fog::batch(context, &[], rays, hits);
            missing.iter().for_each(|at| fogged.depth[*at] = exact.depth[*at]);
        } else if let Some((rays, hits)) = subset(context, rays, hits, &missing) {
            let exact = fog::batch(context, &[], &rays, &hits);
            missing.iter().zip(exact.depth).for_each(|(at, depth)| fogged.depth[*at] = depth);
        }
        fogged
    }

    /// Along one ray, if it ends on a triangle that is dense enough.
    #[inline(always)]
    fn depth(&self, on: &OnTriangles, at: usize) -> Option<f32> {
        let place = on.place[at] as usize;
        let [a, b, c] = self.corners.of.get(place)?.map(|corner| self.depths[corner as usize]);
        let (least, most) = (a.min(b).min(c), a.max(b).max(c));
        // 1/(1 + T) is no less than what T lets through.
        if most - least > LIKE * (1.0 + least) {
            return None;
        }
        let [u, v] = on.shares.each_ref().map(|row| row[at]);
        Some(c + u * (a - c) + v * (b - c))
    }
}

/// The corners of all triangles that are seen.
fn seen(
    context: &Context,
    traced: &Traced,
    strip: &Strip,
    corners: &Corners,
) -> Result<Vec<u32>, Interrupted> {
    let height = seen_height(context);
    let marks: Vec<_> = corners.places.iter().map(|_| AtomicBool::new(false)).collect();
    tiles(context, strip.tiles.clone(), &(), |index| {
        let rays = context.viewpoint.tile(context.grid.tile(index), CENTER);
        for Ends { rays, hits } in traced.batches(index, &rays) {
            let Some(on) = &hits.triangles else { continue };
            let mut last = None;
            for (at, place) in on.place[..rays.count].iter().enumerate() {
                // Neighbours mostly hit the same.
                if last != Some(place) && is_dense(height, corners, on, hits, at) {
                    last = Some(place);
                    let mark = |corner: &u32| &marks[*corner as usize];
                    let of = &corners.of[*place as usize];
                    of.iter().for_each(|corner| mark(corner).store(true, Ordering::Relaxed));
                }
            }
        }
    })?;
    let seen = (0..).zip(&marks).filter(|(_, mark)| mark.load(Ordering::Relaxed));
    Ok(seen.map(|(corner, _)| corner).collect())
}

/// The fog along the rays to some corners.
fn fog_at(context: &Context, corners: &Corners, places: &[u32]) -> Fogged {
    let anchor = context.geometry.anchor - context.viewpoint.position;
    let mut rays = Rays::empty();
    let mut hits = Hits::nothing(context.far_m);
    for place in places {
        let way = anchor + corners.places[*place as usize].as_dvec3();
        let (offset, direction, length) = context.viewpoint.toward(way);
        hits.length[rays.count] = length as f32;
        rays.push_ray((offset, direction));
    }
    rays.pad();
    hits.pad(places.len() - 1);
    fog::batch(context, &[], &rays, &hits)
}

/// How much of the world the picture's height shows: everywhere, and more of it a metre of distance [m].
fn seen_height(context: &Context) -> [f32; 2] {
    let height = 2.0 * context.viewpoint.half_axes().1.length() as f32;
    if context.viewpoint.parallel { [height, 0.0] } else { [0.0, height] }
}

/// Whether a ray ends on a triangle that is seen small.
#[inline(always)]
fn is_dense(
    [everywhere, per_m]: [f32; 2],
    corners: &Corners,
    on: &OnTriangles,
    hits: &Hits,
    at: usize,
) -> bool {
    let longest = corners.longest.get(on.place[at] as usize);
    longest.is_some_and(|longest| *longest <= DENSE * (everywhere + per_m * hits.length[at]))
}
