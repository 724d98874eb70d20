//! How view rays see blobs: as Gaussians, or as slabs (Macklin 2010), which are constant along a chord and cost no
//! error function. T along the whole ray is the same. A slab is as thick as its Gaussian is wide, in standard
//! deviations along the ray, and stands across each ray: a look, not a field, so lights go by the Gaussian.

use crate::num::Num;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How view rays see blobs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Draw {
    /// As they are.
    #[default]
    Gaussian,
    /// Constant along a chord that has the same optical depth (Macklin 2010): a cheap draw, and the one of which
    /// `macklin2010` knows the airlight.
    Slab,
}

/// Half a slab's thickness in radii: √(3/2), with which its variance along the ray, a third of this squared, is the
/// Gaussian's, 1/2.
pub const HALF_SLAB: f64 = 1.224_744_871_391_589;

/// What erf is to a Gaussian: from −1 before a slab to 1 behind it, at a place counted from its middle in radii.
#[inline(always)]
pub fn gathered<N: Num>(place: N) -> N {
    (place * place.lit(1.0 / HALF_SLAB)).max(place.lit(-1.0)).min(place.lit(1.0))
}

/// The same from one place to another, given how far that is: of a way within a slab no difference of places is
/// formed, which would have few digits in a large one.
#[inline(always)]
pub fn gathered_between<N: Num>([from, to]: [N; 2], way: N) -> N {
    let half = way.lit(HALF_SLAB);
    let difference = gathered(to) - gathered(from);
    let within = way * way.lit(1.0 / HALF_SLAB);
    let from_within = N::select((-half).lt(from), within, difference);
    N::select(to.lt(half), from_within, difference)
}

/// A slab before a ray.
#[derive(Clone, Copy, Debug)]
pub struct Slab<N> {
    /// Its extinction [1/m].
    pub beta: N,
    /// Between which ray parameters it stands [m].
    pub ends: [N; 2],
}
