//! Blobs around the rays of a patch, and as a few rays cross them: what does not change along the rays
//! is formed once, and serves every rule, head and tail.

use super::draw::{HALF_SLAB, gathered, gathered_between};
use super::list::{BlobList, DENSE, Packed};
use super::{ENDS, HALF_SQRT_PI, Line};
use crate::geometry::batch::load3;
use crate::geometry::control::{Control, Each, PADDED};
use crate::media::{Lumps, OnRays, PatchCone, Patched};
use crate::num::{Lanes, Num};
use crate::vector::V3;
use fearless_simd::{Level, Simd, dispatch};
use glam::Vec3;
use std::hash::{DefaultHasher, Hash};

/// Blobs of which half a patch's diagonal covers less than this share of the radius are seen.
const COARSE: f32 = 0.4;
/// Radii from its centre at which a blob has ended aside of a ray: exp(−4.3²) is 1e-8. Where there is
/// nothing but the tails of blobs, they are what is seen.
const FAR: f32 = 4.3;

/// A blob relative to the camera.
#[derive(Clone, Copy, Debug)]
struct PatchBlob {
    /// a · (centre − camera).
    b: [f32; 3],
    /// Scale a [1/m].
    a: f32,
    /// Half depth.
    k: f32,
    is_slab: bool,
}

impl PatchBlob {
    /// Whether some ray of a patch meets it; then it is added to `lumps`.
    fn weigh(&self, cone: &PatchCone, lumps: &mut Lumps) -> bool {
        let PatchCone { offset, axis, spread, width, .. } = *cone;
        let b = Vec3::from(self.b) - offset * self.a;
        let half = 1.01 * (b.length() * spread + width * self.a);
        let aside = b.cross(axis).length();
        let miss = (aside - half).max(0.0);
        if miss >= FAR {
            return false;
        }
        let middle = b.dot(axis);
        lumps.depth += 2.0 * self.k * (-aside * aside).exp();
        lumps.begin = lumps.begin.min((middle - half - ENDS as f32) / self.a);
        // A ray that runs straight at it passes its middle as far away as it is.
        let last = b.length().min(middle + half);
        lumps.end = lumps.end.max((last + ENDS as f32) / self.a);
        if half > COARSE {
            let half = half.min(4.0);
            // The third derivative of a Gaussian, met over half a patch.
            let missed = 0.25 * self.k * half * half * half * (-miss * miss).exp();
            lumps.hidden_squared += missed * missed;
        }
        true
    }
}

/// The blobs that some ray of a patch meets.
#[derive(Clone, Debug)]
pub struct PatchBlobs(Vec<PatchBlob>);

impl PatchBlobs {
    /// All blobs of a list.
    pub fn new(list: &BlobList) -> Self {
        let blob = |Packed { b, a, k, is_slab, .. }| PatchBlob { b, a, k, is_slab };
        Self(list.each().map(blob).collect())
    }
}

impl Patched for PatchBlobs {
    fn terms(&self) -> usize {
        self.0.len()
    }

    fn tell(&self, hasher: &mut DefaultHasher) -> bool {
        for PatchBlob { b: [x, y, z], a, k, is_slab } in &self.0 {
            [x, y, z, a, k].map(|number| number.to_bits()).hash(hasher);
            is_slab.hash(hasher);
        }
        true
    }

    fn weigh(&self, cone: &PatchCone, lumps: &mut Lumps) {
        self.0.iter().for_each(|blob| {
            blob.weigh(cone, lumps);
        });
    }

    fn within(&self, cone: &PatchCone, lumps: &mut Lumps) -> Box<dyn Patched> {
        let meets = |blob: &&PatchBlob| blob.weigh(cone, lumps);
        Box::new(Self(self.0.iter().filter(meets).copied().collect()))
    }

    fn on_rays(&self, level: Level, rays: &Control, parallel: bool, least: f32) -> Box<dyn OnRays> {
        let blobs = dispatch!(level, simd => if parallel {
            cross::<_, true>(simd, rays, &self.0, least)
        } else {
            cross::<_, false>(simd, rays, &self.0, least)
        });
        Box::new(BlobsOnRays(blobs))
    }
}

/// One blob before the rays of a row.
#[derive(Clone, Debug)]
struct BlobOnRays {
    /// Scale a [1/m].
    a: f32,
    /// Whether depths need relative accuracy.
    dense: bool,
    is_slab: bool,
    /// From where to where it is on any of the rays [m].
    first: f32,
    last: f32,
    /// a · ray parameter of its closest point.
    middle: Each,
    /// Half its depth along the line.
    density: Each,
    /// erf where the ray starts.
    begins: Each,
    /// Its depth behind it.
    whole: Each,
    /// The largest of those.
    most: f32,
}

/// The blobs that rays cross.
#[derive(Clone, Debug)]
struct BlobsOnRays(Vec<BlobOnRays>);

impl BlobsOnRays {
    /// Those that some ray meets between two ray parameters [m].
    fn between(&self, from: f32, to: f32) -> impl Iterator<Item = &BlobOnRays> {
        self.0.iter().filter(move |blob| blob.first < to && blob.last > from)
    }
}

impl OnRays for BlobsOnRays {
    fn is_smooth(&self) -> bool {
        false
    }

    fn add(&self, level: Level, t: &[Each], beta: &mut [Each], depth: &mut [Each]) {
        dispatch!(level, simd => add_fields(simd, &self.0, t, beta, depth));
    }

    fn most(&self, from: f32, to: f32) -> f32 {
        self.between(from, to).map(|blob| blob.most).sum()
    }

    fn span(&self) -> Option<(f32, f32)> {
        let spans = self.0.iter().map(|blob| (blob.first, blob.last));
        spans.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    fn finest(&self, from: f32, to: f32, least: f32) -> f32 {
        let stands_out = |blob: &&BlobOnRays| blob.most > least;
        let scales = self.between(from, to).filter(stands_out).map(|blob| blob.a);
        1.0 / scales.fold(0.0, f32::max)
    }
}

#[inline(always)]
fn cross<S: Simd, const PARALLEL: bool>(
    simd: S,
    rays: &Control,
    blobs: &[PatchBlob],
    least: f32,
) -> Vec<BlobOnRays> {
    let mut crossings = Vec::with_capacity(blobs.len());
    for blob in blobs {
        let (a, is_slab) = (blob.a, blob.is_slab);
        let dense = blob.k > DENSE && !is_slab;
        let zero = [0.0; PADDED];
        let (mut middle, mut density, mut begins, mut whole) = (zero, zero, zero, zero);
        for at in (0..PADDED).step_by(Lanes::<S>::COUNT) {
            let direction = load3(simd, &rays.direction, at);
            let center = V3::splat(simd, blob.b);
            let center = if PARALLEL {
                center - load3(simd, &rays.offset, at).scale(Lanes::splat(simd, a))
            } else {
                center
            };
            let miss2 = center.cross(direction).length_squared();
            center.dot(direction).store(&mut middle[at..]);
            (miss2.bell() * Lanes::splat(simd, blob.k)).store(&mut density[at..]);
        }
        if Lanes::extremes(simd, &density)[1] < least * blob.k.min(1.0) {
            continue;
        }
        for at in (0..PADDED).step_by(Lanes::<S>::COUNT) {
            let along = Lanes::load(simd, &middle[at..]);
            let start = if is_slab { gathered(-along) } else { (-along).erf() };
            let behind = if dense {
                Num::erf_difference(-along, along.lit(1e4))
            } else {
                along.lit(1.0) - start
            };
            start.store(&mut begins[at..]);
            (Lanes::load(simd, &density[at..]) * behind).store(&mut whole[at..]);
        }
        let [low, high] = Lanes::extremes(simd, &middle);
        let reach = if is_slab { HALF_SLAB } else { ENDS } as f32;
        let (first, last) = ((low - reach) / a, (high + reach) / a);
        let most = Lanes::extremes(simd, &whole)[1];
        crossings.push(BlobOnRays {
            a,
            dense,
            is_slab,
            first,
            last,
            middle,
            density,
            begins,
            whole,
            most,
        });
    }
    crossings
}

/// Sums β, if there are rows for it, and T over blobs. erf and exp are formed only where a blob is; behind it its whole depth
/// is added once, to the first row there, and carried on at the end.
#[inline(always)]
fn add_fields<S: Simd>(
    simd: S,
    blobs: &[BlobOnRays],
    t: &[Each],
    beta: &mut [Each],
    depth: &mut [Each],
) {
    let mut behind = vec![[0.0f32; PADDED]; t.len() + 1];
    let mut ends = Vec::with_capacity(t.len());
    for t in t {
        ends.push(Lanes::extremes(simd, t));
    }
    for blob in blobs {
        let begin = ends.partition_point(|end| end[1] < blob.first);
        let end = begin + ends[begin..].partition_point(|end| end[0] <= blob.last);
        let a = Lanes::splat(simd, blob.a);
        for at in (0..PADDED).step_by(Lanes::<S>::COUNT) {
            let middle = Lanes::load(simd, &blob.middle[at..]);
            let density = Lanes::load(simd, &blob.density[at..]);
            let begins = Lanes::load(simd, &blob.begins[at..]);
            let core = density * a * a.lit(1.0 / HALF_SQRT_PI);
            let (flat, half) = (density * a * a.lit(1.0 / HALF_SLAB), a.lit(HALF_SLAB));
            for (j, t) in t.iter().enumerate().take(end).skip(begin) {
                let t = Lanes::load(simd, &t[at..]);
                let s = a.mul_add(t, -middle);
                let gathered = if blob.is_slab {
                    gathered_between([-middle, s], a * t)
                } else if blob.dense {
                    let line = Line { start: -middle, end: s, miss2: s, peak: s };
                    line.between(a * t)
                } else {
                    s.erf() - begins
                };
                add(simd, density * gathered, &mut depth[j], at);
                if let Some(beta) = beta.get_mut(j) {
                    let own = if blob.is_slab {
                        Lanes::select(s.abs().lt(half), flat, a.lit(0.0))
                    } else {
                        core * s.squared().bell()
                    };
                    add(simd, own, beta, at);
                }
            }
            add(simd, Lanes::load(simd, &blob.whole[at..]), &mut behind[end], at);
        }
    }
    for at in (0..PADDED).step_by(Lanes::<S>::COUNT) {
        let mut sum = Lanes::splat(simd, 0.0);
        for (behind, depth) in behind.iter().zip(depth.iter_mut()) {
            sum += Lanes::load(simd, &behind[at..]);
            add(simd, sum, depth, at);
        }
    }
}

#[inline(always)]
fn add<S: Simd>(simd: S, value: Lanes<S>, row: &mut Each, at: usize) {
    (value + Lanes::load(simd, &row[at..])).store(&mut row[at..]);
}
