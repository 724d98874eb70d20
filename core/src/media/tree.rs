//! A bounding volume hierarchy over blobs: which of them matter to a bundle of rays.

use super::gaussians::Gaussian;
use crate::geometry::bundle::Bundle;
use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{Boundable, BvhBuildParams};
use std::time::Duration;

/// Blobs by place. Coordinates are kept in f32 relative to `anchor`, boxes rounded outwards.
pub struct BlobTree {
    anchor: DVec3,
    bvh: Bvh2,
}

impl std::fmt::Debug for BlobTree {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "BlobTree({} nodes)", self.bvh.nodes.len())
    }
}

struct Bounds(Aabb);

impl Boundable for Bounds {
    fn aabb(&self) -> Aabb {
        self.0
    }
}

impl BlobTree {
    /// Bounds every blob by the ball outside of which no segment gathers more than `loss`.
    pub fn new(blobs: &[Gaussian], loss: f64) -> Self {
        let count = blobs.len().max(1) as f64;
        let anchor = blobs.iter().map(|b| b.center / count).sum();
        let bounds: Vec<_> = blobs.iter().map(|b| bounds(b, anchor, loss)).collect();
        let params = BvhBuildParams::fast_build();
        let bvh = if bounds.is_empty() {
            Bvh2::default()
        } else {
            build_bvh2(&bounds, params, &mut Duration::default())
        };
        Self { anchor, bvh }
    }

    /// No blob lies farther from a point than this [m]; 0 where there is none.
    pub fn farthest(&self, point: DVec3) -> f64 {
        let Some(root) = self.bvh.nodes.first() else { return 0.0 };
        let (center, half) = (0.5 * (root.aabb.min + root.aabb.max), 0.5 * root.aabb.diagonal());
        point.distance(self.anchor + center.as_dvec3()) + f64::from(half.length())
    }

    /// Calls `visit` with the place of every blob whose ball a ray of the bundle may meet.
    pub fn visit(&self, bundle: &Bundle, mut visit: impl FnMut(usize)) {
        let bundle = Bundle { origin: bundle.origin - self.anchor, ..*bundle };
        let mut stack = vec![0usize];
        while let Some(at) = stack.pop() {
            let Some(node) = self.bvh.nodes.get(at) else { return };
            let center = (0.5 * (node.aabb.min + node.aabb.max)).as_dvec3();
            let radius = f64::from((0.5 * (node.aabb.max - node.aabb.min)).length());
            if bundle.distance(bundle.place(center)) > radius {
                continue;
            }
            let first = node.first_index as usize;
            if node.prim_count == 0 {
                stack.extend([first + 1, first]);
                continue;
            }
            for place in first..first + node.prim_count as usize {
                visit(self.bvh.primitive_indices[place] as usize);
            }
        }
    }
}

fn bounds(blob: &Gaussian, anchor: DVec3, loss: f64) -> Bounds {
    let center = (blob.center - anchor).as_vec3a();
    let reach = blob.reach(loss) as f32;
    // Half a unit in the last place of the centre, and of the sums below.
    let slack = 2e-7 * (center.abs().max_element() + reach);
    let extent = Vec3A::splat(reach + slack);
    Bounds(Aabb { min: center - extent, max: center + extent })
}
