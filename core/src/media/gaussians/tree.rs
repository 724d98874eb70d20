//! A bounding volume hierarchy over blobs: which of them matter to a bundle of rays.

use super::Gaussian;
use crate::geometry::bundle::Bundle;
use crate::geometry::hierarchy::{Bounds, Hierarchy};
use crate::progress::Progress;
use glam::{DVec3, Vec3};

/// Blobs by place. Coordinates are kept in f32 relative to `anchor`, boxes rounded outwards.
pub struct BlobTree {
    anchor: DVec3,
    hierarchy: Hierarchy,
}

impl std::fmt::Debug for BlobTree {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "BlobTree({} nodes)", self.hierarchy.nodes.len())
    }
}

impl BlobTree {
    /// Bounds every blob by the ball outside of which no segment gathers more than `loss`.
    pub fn new(blobs: &[Gaussian], loss: f64) -> Self {
        let count = blobs.len().max(1) as f64;
        let anchor = blobs.iter().map(|b| b.center / count).sum();
        let bounds = blobs.iter().map(|b| bounds(b, anchor, loss));
        // Of as many blobs as a scene may have it takes less than half a second: jobs that are over
        // wait for that.
        let hierarchy = Hierarchy::build(bounds, 1.0, &Progress::default()).unwrap_or_default();
        Self { anchor, hierarchy }
    }

    /// No blob lies farther from a point than this [m]; 0 where there is none.
    pub fn farthest(&self, point: DVec3) -> f64 {
        let Some(root) = self.hierarchy.nodes.first() else { return 0.0 };
        let Bounds { min, max } = root.bounds;
        let (center, half) = (0.5 * (min + max), 0.5 * (max - min));
        point.distance(self.anchor + center.as_dvec3()) + f64::from(half.length())
    }

    /// Calls `visit` with the place of every blob whose ball a ray of the bundle may meet.
    pub fn visit(&self, bundle: &Bundle, mut visit: impl FnMut(usize)) {
        let bundle = Bundle { origin: bundle.origin - self.anchor, ..*bundle };
        let mut stack = vec![0usize];
        while let Some(at) = stack.pop() {
            let Some(node) = self.hierarchy.nodes.get(at) else { return };
            let Bounds { min, max } = node.bounds;
            let center = (0.5 * (min + max)).as_dvec3();
            let radius = f64::from((0.5 * (max - min)).length());
            if bundle.distance(bundle.place(center)) > radius {
                continue;
            }
            let first = node.first as usize;
            if node.count == 0 {
                stack.extend([first + 1, first]);
                continue;
            }
            for place in first..first + node.count as usize {
                visit(self.hierarchy.items[place] as usize);
            }
        }
    }
}

fn bounds(blob: &Gaussian, anchor: DVec3, loss: f64) -> Bounds {
    let center = (blob.center - anchor).as_vec3();
    let reach = blob.reach(loss) as f32;
    // Half a unit in the last place of the centre, and of the sums below.
    let slack = 2e-7 * (center.abs().max_element() + reach);
    let extent = Vec3::splat(reach + slack);
    Bounds { min: center - extent, max: center + extent }
}
