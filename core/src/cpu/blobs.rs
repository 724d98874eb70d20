//! Which blobs matter to a bundle of rays.
//!
//! A list holds the fewest blobs such that those left out together weigh less than
//! [`PICTURE_LOSS`] on any ray of the bundle, or [`RELATIVE_LOSS`] of what any ray gathers.

use crate::geometry::bundle::Bundle;
use crate::media::gaussians::{Gaussian, Seen};
use crate::media::{Field, PICTURE_LOSS, RELATIVE_LOSS};
use glam::DVec3;

/// Units of its radius from a blob's centre at which erf is 1 to the last bit of f32 lanes.
const WHOLE: f64 = 3.75;

/// Half depth from which on the tails of erf are formed with care: below it the plain difference is
/// off by less than 1e-6 of optical depth.
pub const DENSE: f32 = 0.25;

/// What a list is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// Optical depth: what is lost may grow with a ray's own.
    Depth,
    /// Airlight too: it comes from where the ray begins, however thick the fog behind may be.
    Airlight,
}

/// Half depth from which on a blob is opaque.
const OPAQUE: f64 = 8.0;

/// A blob relative to the origin of rays, as a kernel reads it.
#[derive(Clone, Copy, Debug)]
pub struct Packed {
    /// a · (centre − origin).
    pub b: [f32; 3],
    /// Scale a [1/m].
    pub a: f32,
    /// Half depth.
    pub k: f32,
    /// Place in the field.
    pub place: u32,
}

/// The blobs that matter to a bundle of rays.
#[derive(Default)]
pub struct BlobList {
    /// Those that some ray may start or end in.
    pub cut: Vec<Packed>,
    /// The dense ones among those, of which the faintest tail still counts.
    pub dense: Vec<Packed>,
    /// Opaque ones, kept in f64: exponents of that size have no digits to lose.
    pub opaque: Vec<(usize, Seen<f64>)>,
    /// Those that all rays pass from end to end.
    pub whole: Vec<Packed>,
}

/// A blob with bounds of its depth on any ray of a bundle.
struct Candidate {
    place: u32,
    most: f64,
    whole: bool,
}

/// Sorts bounds by their binary exponent: as good as a sorted list for the smallest of them.
const CLASSES: usize = 64;

impl BlobList {
    /// The blobs among `candidates` that matter to the rays of `bundle`, which are at least
    /// `shortest` long [m].
    pub fn new(
        field: &Field,
        bundle: &Bundle,
        shortest: f64,
        purpose: Purpose,
        candidates: impl Iterator<Item = usize>,
    ) -> Self {
        let mut sure = field.homogeneous.beta * shortest;
        let mut weighed = Vec::new();
        for place in candidates {
            let (candidate, least) = weigh(&field.blobs[place], place, bundle, shortest);
            sure += least;
            weighed.extend(candidate);
        }
        let loss = match purpose {
            Purpose::Depth => PICTURE_LOSS.max(RELATIVE_LOSS * sure),
            Purpose::Airlight => PICTURE_LOSS,
        };
        let threshold = threshold(&weighed, loss);
        let mut list = Self::default();
        for candidate in weighed.iter().filter(|c| class(c.most, loss) >= threshold) {
            let place = candidate.place as usize;
            let blob = &field.blobs[place];
            if blob.half_depth() > OPAQUE {
                list.opaque.push((place, blob.seen_from(bundle.origin)));
                continue;
            }
            let packed = pack(blob, candidate.place, bundle.origin);
            let part = if candidate.whole {
                &mut list.whole
            } else if packed.k > DENSE {
                &mut list.dense
            } else {
                &mut list.cut
            };
            part.push(packed);
        }
        list
    }
}

fn pack(blob: &Gaussian, place: u32, origin: DVec3) -> Packed {
    let b = ((blob.center - origin) * blob.a).as_vec3().to_array();
    Packed { b, a: blob.a as f32, k: blob.half_depth() as f32, place }
}

/// Bounds of a blob's depth: the most on any ray, and the least that every ray is sure of.
fn weigh(
    blob: &Gaussian,
    place: usize,
    bundle: &Bundle,
    shortest: f64,
) -> (Option<Candidate>, f64) {
    let at = bundle.place(blob.center);
    let near = bundle.distance(at) * blob.a;
    // erfc(x) ≤ exp(−x²): the distance to the segment bounds also what ends before the blob.
    let most = 2.0 * blob.half_depth() * (-near * near).exp();
    if most < PICTURE_LOSS * 1e-6 {
        return (None, 0.0);
    }
    let (low, high) = bundle.closest_approach(at);
    let whole = low * blob.a >= WHOLE && (shortest - high) * blob.a >= WHOLE;
    let miss = bundle.farthest_miss(at) * blob.a;
    let least = if whole { 2.0 * blob.half_depth() * (-miss * miss).exp() } else { 0.0 };
    (Some(Candidate { place: place as u32, most, whole }), least)
}

/// The binary order of a bound relative to the allowed loss, from 0 up.
fn class(most: f64, loss: f64) -> usize {
    let order = (most / loss).log2() + (CLASSES / 2) as f64;
    order.clamp(0.0, (CLASSES - 1) as f64) as usize
}

/// The lowest class that must be kept: all below it together stay within `loss`.
fn threshold(candidates: &[Candidate], loss: f64) -> usize {
    let mut sums = [0.0; CLASSES];
    for candidate in candidates {
        sums[class(candidate.most, loss)] += candidate.most;
    }
    let mut dropped = 0.0;
    let fits = |sum: &&f64| {
        dropped += **sum;
        dropped <= loss
    };
    sums.iter().take_while(fits).count()
}
