//! Which blobs matter to a bundle of rays, and their depth along each.
//!
//! A list holds the fewest blobs such that those left out together weigh less than
//! [`PICTURE_LOSS`] on any ray of the bundle, or [`RELATIVE_LOSS`] of what any ray gathers.

use super::{Blobs, Gaussian, HALF_SQRT_PI, Seen};
use crate::geometry::batch::{Rays, Row, Rows, SIZE, get3, load3};
use crate::geometry::bundle::Bundle;
use crate::geometry::cone::{Cone, ROUNDING};
use crate::media::{Legs, PICTURE_LOSS, Purpose, RELATIVE_LOSS, Search};
use crate::num::{Lanes, Num};
use crate::progress::Progress;
use crate::vector::V3;
use fearless_simd::{Level, Simd, SimdBase, dispatch};
use glam::DVec3;

/// Units of its radius from a blob's centre at which erf is 1 to the last bit of f32 lanes.
const WHOLE: f64 = 3.75;

/// Half depth from which on the tails of erf are formed with care: below it the plain difference is
/// off by less than 1e-6 of optical depth.
pub const DENSE: f32 = 0.25;

/// Half depth from which on a blob is opaque.
const OPAQUE: f32 = 8.0;

/// A blob that weighs less on every ray of a bundle is no candidate.
const NEGLIGIBLE: f32 = 1e-11;

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
    /// Whether it is a slab.
    pub is_slab: bool,
}

/// The blobs that matter to a bundle of rays.
#[derive(Debug, Default)]
pub struct BlobList {
    /// Those that some ray may start or end in.
    pub cut: Vec<Packed>,
    /// The dense ones among those, of which the faintest tail still counts.
    pub dense: Vec<Packed>,
    /// Slabs that some ray may start or end in.
    pub slabs: Vec<Packed>,
    /// Opaque ones, kept in f64: exponents of that size have no digits to lose.
    pub opaque: Vec<(usize, Seen<f64>)>,
    /// Those that all rays pass from end to end.
    pub whole: Vec<Packed>,
}

/// Blobs that a batch of rays sums up within a few hundredths of a second, lit by a few lights; and
/// how many of them an opaque one counts as, which is summed up in f64 and ray by ray.
const BLOBS_A_LOOK: usize = 1 << 14;
const OPAQUE_COST: usize = 128;

/// A blob with an upper bound of its depth on any ray of a bundle.
struct Candidate {
    place: u32,
    most: f32,
    whole: bool,
}

/// Bounds are sorted by their binary exponent: as good as a sorted list for the smallest of them.
const CLASSES: usize = 64;

impl BlobList {
    /// Those that matter to what is looked for.
    pub fn new(level: Level, blobs: &Blobs, search: &Search) -> Self {
        let Search { ref bundle, shortest_m, purpose, legs, mut sure } = *search;
        let mut near = Vec::new();
        blobs.picture_tree().visit(bundle, |place| near.push(place as u32));
        let mut weighed = Vec::with_capacity(near.len());
        for places in near.chunks(SIZE) {
            let group = Group::gather(blobs.all(), bundle.origin, places);
            let (bounds, least) = dispatch!(level, simd => group.weigh(simd, bundle, shortest_m));
            sure += f64::from(least);
            weighed.extend(places.iter().zip(bounds).filter_map(candidate));
        }
        let loss = match purpose {
            Purpose::Depth | Purpose::Sight | Purpose::Shade => {
                PICTURE_LOSS.max(RELATIVE_LOSS * sure)
            }
            Purpose::Airlight => PICTURE_LOSS,
            Purpose::Nodes => {
                let all: f64 = weighed.iter().map(|c| f64::from(c.most)).sum();
                PICTURE_LOSS.min(1e-4 * all).max(RELATIVE_LOSS * sure)
            }
        };
        let opaque = if purpose == Purpose::Shade { f32::INFINITY } else { OPAQUE };
        Self::keep(blobs.all(), (bundle.origin, legs), &weighed, [loss, opaque.into()])
    }

    /// All of them, as kernels read them.
    pub fn each(&self) -> impl Iterator<Item = Packed> {
        let lists = [&self.cut, &self.dense, &self.slabs, &self.whole];
        let opaque = self.opaque.iter().map(|(place, seen)| Packed {
            b: [seen.b.x as f32, seen.b.y as f32, seen.b.z as f32],
            a: seen.a as f32,
            k: seen.k as f32,
            place: *place as u32,
            is_slab: seen.is_slab,
        });
        lists.into_iter().flatten().copied().chain(opaque)
    }

    /// Has all blobs summed up; in parts where they are so many that the job may end meanwhile. The parts
    /// do not depend on how many lights they are summed up for, so neither do the sums.
    pub fn in_parts(&self, progress: &Progress, mut sum: impl FnMut(&Self)) {
        let most = BLOBS_A_LOOK;
        let lanes = self.cut.len() + self.dense.len() + self.slabs.len() + self.whole.len();
        if lanes + OPAQUE_COST * self.opaque.len() <= most {
            return sum(self);
        }
        let cut = self.cut.chunks(most).map(|cut| Self { cut: cut.to_vec(), ..Self::default() });
        let dense =
            self.dense.chunks(most).map(|dense| Self { dense: dense.to_vec(), ..Self::default() });
        let slabs =
            self.slabs.chunks(most).map(|slabs| Self { slabs: slabs.to_vec(), ..Self::default() });
        let whole =
            self.whole.chunks(most).map(|whole| Self { whole: whole.to_vec(), ..Self::default() });
        let opaque = self.opaque.chunks(most / OPAQUE_COST);
        let opaque = opaque.map(|opaque| Self { opaque: opaque.to_vec(), ..Self::default() });
        let parts = cut.chain(dense).chain(slabs).chain(whole).chain(opaque);
        parts.take_while(|_| !progress.is_over()).for_each(|part| sum(&part));
    }

    /// All but the candidates that together stay within `loss`; those of a larger half depth than `opaque` for f64.
    fn keep(
        blobs: &[Gaussian],
        (origin, legs): (DVec3, Legs),
        candidates: &[Candidate],
        [loss, opaque]: [f64; 2],
    ) -> Self {
        let threshold = threshold(candidates, loss);
        let mut list = Self::default();
        for candidate in candidates.iter().filter(|c| class(c.most, loss) >= threshold) {
            let place = candidate.place as usize;
            let blob = &blobs[place];
            let by_eye = legs == Legs::OfEyes;
            let packed = pack(blob, candidate.place, origin, by_eye);
            if f64::from(packed.k) > opaque {
                let seen = if by_eye { blob.seen_by_eye(origin) } else { blob.seen_from(origin) };
                list.opaque.push((place, seen));
                continue;
            }
            let part = if candidate.whole {
                &mut list.whole
            } else if packed.is_slab {
                &mut list.slabs
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

/// Blobs whose bounds are formed at once, one a lane.
struct Group {
    /// Centres relative to the bundle's origin [m].
    to: Rows,
    /// Scales a [1/m].
    a: Row,
    /// Extinctions at the centres [1/m].
    c: Row,
    count: usize,
}

impl Group {
    fn gather(blobs: &[Gaussian], origin: DVec3, places: &[u32]) -> Self {
        let (mut to, mut a, mut c) = ([[0.0; SIZE]; 3], [1.0; SIZE], [0.0; SIZE]);
        for (at, place) in places.iter().enumerate() {
            let blob = &blobs[*place as usize];
            let center = (blob.center - origin).as_vec3();
            [to[0][at], to[1][at], to[2][at]] = center.to_array();
            (a[at], c[at]) = (blob.a as f32, blob.c as f32);
        }
        Self { to, a, c, count: places.len() }
    }

    /// The most that each blob weighs on any ray, negative where all rays pass it from end to end;
    /// and the least that all of them together weigh on every ray.
    #[inline(always)]
    fn weigh<S: Simd>(&self, simd: S, bundle: &Bundle, shortest: f64) -> (Row, f32) {
        let one = Lanes::splat(simd, 1.0);
        let cone = Cone::new(one, bundle);
        let (shortest, whole_from) = (one.lit(shortest), one.lit(WHOLE));
        let mut bounds = [0.0; SIZE];
        let mut sure = one.lit(0.0);
        for at in (0..self.count).step_by(Lanes::<S>::COUNT) {
            let to = load3(simd, &self.to, at);
            let a = Lanes::load(simd, &self.a[at..]);
            let depth = Lanes::load(simd, &self.c[at..]) * one.lit(2.0 * HALF_SQRT_PI) / a;
            let place = cone.place(to);
            // erfc(x) ≤ exp(−x²): the distance to the segment bounds also what ends before the blob.
            let most = depth * (-(cone.distance(&place) * a).squared()).exp();
            let (low, high) = cone.closest_approach(&place);
            let margin = low.min(shortest - shortest * one.lit(ROUNDING) - high);
            let cut = (margin * a).lt(whole_from);
            let least = depth * (-(cone.farthest_miss(&place) * a).squared()).exp();
            sure += Lanes::select(cut, one.lit(0.0), least);
            Lanes::select(cut, most, -most).store(&mut bounds[at..]);
        }
        (bounds, sure.0.as_slice().iter().sum())
    }
}

fn candidate((place, bound): (&u32, f32)) -> Option<Candidate> {
    let most = bound.abs();
    (most >= NEGLIGIBLE).then_some(Candidate { place: *place, most, whole: bound < 0.0 })
}

fn pack(blob: &Gaussian, place: u32, origin: DVec3, by_eye: bool) -> Packed {
    let b = ((blob.center - origin) * blob.a).as_vec3().to_array();
    let (a, k) = (blob.a as f32, blob.half_depth() as f32);
    Packed { b, a, k, place, is_slab: by_eye && blob.is_slab }
}

/// The binary order of a bound relative to the allowed loss, from 0 up.
fn class(most: f32, loss: f64) -> usize {
    const EXPONENT_OF_1: usize = 127;
    let exponent = ((most / loss as f32).to_bits() >> 23) as usize;
    (exponent + CLASSES / 2).saturating_sub(EXPONENT_OF_1).min(CLASSES - 1)
}

/// The lowest class that must be kept: all below it together stay within `loss`.
fn threshold(candidates: &[Candidate], loss: f64) -> usize {
    let mut sums = [0.0; CLASSES];
    for candidate in candidates {
        sums[class(candidate.most, loss)] += f64::from(candidate.most);
    }
    let mut dropped = 0.0;
    let fits = |sum: &&f64| {
        dropped += **sum;
        dropped <= loss
    };
    sums.iter().take_while(fits).count()
}

impl Packed {
    /// The blob relative to rays that start at `offset`.
    #[inline(always)]
    pub fn seen<S: Simd, const PARALLEL: bool>(
        &self,
        simd: S,
        offset: V3<Lanes<S>>,
    ) -> Seen<Lanes<S>> {
        let (a, b) = (Lanes::splat(simd, self.a), V3::splat(simd, self.b));
        let b = if PARALLEL { b - offset.scale(a) } else { b };
        Seen { b, a, k: Lanes::splat(simd, self.k), is_slab: self.is_slab }
    }
}

/// Adds the blobs' depth along every ray. Rays start at the list's origin, or at offsets from it
/// if `PARALLEL`.
#[inline(always)]
pub fn add_depth<S: Simd, const PARALLEL: bool>(
    simd: S,
    list: &BlobList,
    rays: &Rays,
    length: &Row,
    depth: &mut Row,
) {
    for at in (0..rays.count.min(SIZE)).step_by(Lanes::<S>::COUNT) {
        let direction = load3(simd, &rays.direction, at);
        let offset = load3(simd, &rays.offset, at);
        let length = Lanes::load(simd, &length[at..]);
        let mut sum = Lanes::load(simd, &depth[at..]);
        for blob in &list.cut {
            sum += blob.seen::<S, PARALLEL>(simd, offset).plain_depth(direction, length);
        }
        for blob in list.dense.iter().chain(&list.slabs) {
            sum += blob.seen::<S, PARALLEL>(simd, offset).optical_depth(direction, length);
        }
        for blob in &list.whole {
            sum += blob.seen::<S, PARALLEL>(simd, offset).whole_depth(direction);
        }
        not_negative(sum).store(&mut depth[at..]);
    }
    for (_, blob) in &list.opaque {
        for (at, depth) in depth[..rays.count].iter_mut().enumerate() {
            let ray = ExactRay::new(rays, length, at);
            *depth += ray.blob(blob).optical_depth(ray.direction, ray.length) as f32;
        }
    }
}

/// A sum of optical depths: the difference of two f32 erf may fall below 0 by rounding, fog never.
#[inline(always)]
pub fn not_negative<S: Simd>(depth: Lanes<S>) -> Lanes<S> {
    depth.max(depth.lit(0.0))
}

/// One ray of a batch in f64.
pub struct ExactRay {
    /// Where it starts, relative to the list's origin [m].
    pub offset: V3<f64>,
    /// Unit direction.
    pub direction: V3<f64>,
    /// Where it ends [m].
    pub length: f64,
}

impl ExactRay {
    /// The one at a place of its batch.
    pub fn new(rays: &Rays, length: &Row, at: usize) -> Self {
        let direction = get3(&rays.direction, at).as_dvec3().normalize();
        let offset = get3(&rays.offset, at).as_dvec3();
        let length = f64::from(length[at]);
        Self { offset: offset.into(), direction: direction.into(), length }
    }

    /// The blob relative to the ray's start.
    pub fn blob(&self, blob: &Seen<f64>) -> Seen<f64> {
        Seen { b: blob.b - self.offset.scale(blob.a), ..*blob }
    }
}
