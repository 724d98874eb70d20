//! What fills space: each medium answers β(x), the extinction [1/m], and T(a, b), the optical
//! depth of a segment, in closed form. A scene's fog is the [`Field`], the sum of its terms.

pub mod gaussians;
pub mod homogeneous;
pub mod tree;

use crate::geometry::bundle::Bundle;
use crate::scene::{Fog, Term};
use gaussians::Gaussian;
use glam::DVec3;
use homogeneous::Homogeneous;
use std::sync::OnceLock;
use tree::BlobTree;

/// The extinction of a scene: the sum of its enabled terms, sorted by kind.
#[derive(Debug, Default)]
pub struct Field {
    /// What is the same everywhere.
    pub homogeneous: Homogeneous,
    /// All blobs of all terms, those that weigh nothing left out.
    pub blobs: Vec<Gaussian>,
    picture_tree: OnceLock<BlobTree>,
    exact_tree: OnceLock<BlobTree>,
}

/// Optical depth that a picture's ray may lose to culling: this, or [`RELATIVE_LOSS`] of its own.
pub const PICTURE_LOSS: f64 = 1e-5;
/// See [`PICTURE_LOSS`].
pub const RELATIVE_LOSS: f64 = 1e-4;
/// Optical depth that all blobs left out of an exact sum may have together: below the rounding of
/// its other terms.
const EXACT_LOSS: f64 = 1e-15;

impl Field {
    /// The field of a fog.
    pub fn new(fog: &Fog) -> Self {
        let terms = || fog.terms.iter().filter(|term| term.enabled());
        let homogeneous = terms().filter_map(|term| match term {
            Term::Homogeneous(term) => Some(term),
            Term::Gaussians(_) => None,
        });
        let blobs = terms().flat_map(|term| match term {
            Term::Homogeneous(_) => [].as_slice(),
            Term::Gaussians(term) => term.blobs.as_slice(),
        });
        Self {
            homogeneous: Homogeneous::new(homogeneous),
            blobs: blobs.map(Gaussian::from).filter(|blob| blob.c > 0.0).collect(),
            ..Self::default()
        }
    }

    /// Whether there is nothing at all.
    pub fn is_empty(&self) -> bool {
        self.homogeneous.beta == 0.0 && self.blobs.is_empty()
    }

    /// β(x) [1/m].
    pub fn beta(&self, x: DVec3) -> f64 {
        self.homogeneous.beta + self.blobs.iter().map(|blob| blob.beta(x)).sum::<f64>()
    }

    /// T along a ray from `origin` in the unit `direction` up to `length` [m]; no blob left out.
    pub fn optical_depth(&self, origin: DVec3, direction: DVec3, length: f64) -> f64 {
        let blobs = self.blobs.iter().map(|b| b.optical_depth(origin, direction, length));
        // An empty f64 sum is −0.
        self.homogeneous.optical_depth(length) + blobs.sum::<f64>().max(0.0)
    }

    /// T between two points.
    pub fn depth_between(&self, from: DVec3, to: DVec3) -> f64 {
        let (direction, length) = toward(from, to);
        self.optical_depth(from, direction, length)
    }

    /// The blobs that matter to any ray of a bundle, for pictures.
    pub fn picture_tree(&self) -> &BlobTree {
        let each = PICTURE_LOSS / 10.0 / self.blobs.len().max(1) as f64;
        self.picture_tree.get_or_init(|| BlobTree::new(&self.blobs, each))
    }

    /// Σ of `f` over the blobs that a segment meets, to rounding.
    pub fn near_segment(
        &self,
        origin: DVec3,
        direction: DVec3,
        length: f64,
        mut f: impl FnMut(&Gaussian) -> f64,
    ) -> f64 {
        let bundle = Bundle { origin, axis: direction, radius: 0.0, tan: 0.0, length };
        let mut sum = 0.0;
        self.exact_tree().visit(&bundle, |i| sum += f(&self.blobs[i]));
        sum
    }

    /// Places of the blobs that a segment meets, to rounding.
    pub fn places_near_segment(&self, origin: DVec3, direction: DVec3, length: f64) -> Vec<usize> {
        let bundle = Bundle { origin, axis: direction, radius: 0.0, tan: 0.0, length };
        let mut places = Vec::new();
        self.exact_tree().visit(&bundle, |place| places.push(place));
        places
    }

    /// Bytes that it takes with its trees, near enough.
    pub fn bytes(&self) -> usize {
        /// Bytes of a blob in both trees: two nodes and a place in each.
        const IN_TREES: usize = 136;
        self.blobs.len() * (size_of::<Gaussian>() + IN_TREES)
    }

    /// The blobs that any segment from `apex` to a point between `from` and `to` meets, to rounding.
    pub fn near_triangle(&self, apex: DVec3, from: DVec3, to: DVec3) -> Vec<Gaussian> {
        let ray = |end| (apex, toward(apex, end).0);
        let length = apex.distance(from).max(apex.distance(to));
        let Some(bundle) = Bundle::around(&[ray(from), ray(to)], length) else {
            return self.blobs.clone();
        };
        let mut near = Vec::new();
        self.exact_tree().visit(&bundle, |i| near.push(self.blobs[i]));
        near
    }

    fn exact_tree(&self) -> &BlobTree {
        let each = EXACT_LOSS / self.blobs.len().max(1) as f64;
        self.exact_tree.get_or_init(|| BlobTree::new(&self.blobs, each))
    }
}

/// Unit direction and distance from one point to another; +Z where they coincide.
pub fn toward(from: DVec3, to: DVec3) -> (DVec3, f64) {
    let length = from.distance(to);
    if length > 0.0 { ((to - from) / length, length) } else { (DVec3::Z, 0.0) }
}
