//! What noise does to a batch of rays: T of blobs before which they are bent, and airlight in proportion.

use super::views::bundle_of_views;
use crate::frame::context::Context;
use crate::geometry::Ray;
use crate::geometry::batch::{Ends, Fogged, get3};
use crate::media::gaussians::Gaussian;
use crate::media::noise::{self, Bend};

/// Bends the rays of a batch.
pub fn bend(context: &Context, bend: &Bend, ends: Ends<'_>, fogged: &mut Fogged) {
    let near = near(context, bend, ends);
    let Ends { rays, hits } = ends;
    for at in 0..rays.count {
        let origin = context.viewpoint.position + get3(&rays.offset, at).as_dvec3();
        let direction = get3(&rays.direction, at).as_dvec3().normalize();
        let (ray, length) = (Ray { origin, direction }, f64::from(hits.length[at]));
        let change = |blob: &&Gaussian| bend.change(&blob.seen_by_eye(origin), &ray, length);
        let change: f64 = near.iter().map(change).sum();
        let straight = f64::from(fogged.depth[at]);
        let bent = (straight + change).max(0.0);
        let share = noise::share(straight, bent) as f32;
        fogged.depth[at] = bent as f32;
        fogged.airlight.iter_mut().for_each(|row| row[at] *= share);
    }
}

/// The blobs that matter to any of the rays, be they bent.
fn near<'a>(context: &'a Context, bend: &Bend, ends: Ends<'_>) -> Vec<&'a Gaussian> {
    let (bundle, _) = bundle_of_views(context, &[ends]);
    let is_near =
        |blob: &&Gaussian| bundle.distance(bundle.place(blob.center)) < bend.reach() / blob.a;
    context.field.blobs().filter(is_near).collect()
}
