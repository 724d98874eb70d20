//! Blobs as a few rays cross them: what does not change along the rays is formed once, and serves
//! every rule, head and tail.

use super::control::{Blob, Control, Each, PADDED};
use crate::airlight::ENDS;
use crate::cpu::batch::load3;
use crate::cpu::blobs::DENSE;
use crate::cpu::frame::Context;
use crate::cpu::kernels::splat3;
use crate::media::gaussians::{HALF_SQRT_PI, Line};
use crate::num::{Lanes, Num};
use fearless_simd::{Simd, dispatch};

/// Share of the fog around it from which on a blob stands out.
const OUTSTANDING: f32 = 0.3;

/// One blob before the rays of a row.
#[derive(Clone, Debug)]
struct Crossing {
    /// Scale a [1/m].
    a: f32,
    /// Whether depths need relative accuracy.
    dense: bool,
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
pub struct Crossings {
    blobs: Vec<Crossing>,
    beta: f32,
}

/// What rays meet, row by row.
#[derive(Clone, Debug)]
pub struct Profile {
    /// ln β.
    pub log_beta: Vec<Each>,
    /// T from the start.
    pub depth: Vec<Each>,
}

impl Crossings {
    /// Of view rays; without the blobs of which all rays meet less than the share `least`.
    pub fn on_view(context: &Context, rays: &Control, blobs: &[Blob], least: f32) -> Self {
        let beta = context.field.homogeneous.beta as f32;
        let blobs = dispatch!(context.level, simd => if context.viewpoint.parallel {
            cross::<_, true>(simd, rays, blobs, least)
        } else {
            cross::<_, false>(simd, rays, blobs, least)
        });
        Self { blobs, beta }
    }

    /// Of rays that start where the blobs' places are relative to, without the homogeneous fog.
    pub fn from_origin(context: &Context, rays: &Control, blobs: &[Blob]) -> Self {
        let blobs = dispatch!(context.level, simd => cross::<_, false>(simd, rays, blobs, 0.0));
        Self { blobs, beta: 0.0 }
    }

    /// β and T at ray parameters `t`, ascending from row to row.
    pub fn profile(&self, context: &Context, t: &[Each]) -> Profile {
        let zero = vec![[0.0; PADDED]; t.len()];
        let mut profile = Profile { log_beta: zero.clone(), depth: zero };
        dispatch!(context.level, simd => fill(simd, self, t, &mut profile));
        profile
    }

    /// From where to where blobs are on the rays up to `length`; `None` if none is.
    pub fn span(&self, length: f32) -> Option<(f32, f32)> {
        let (mut from, mut to) = (f32::INFINITY, 0.0f32);
        for blob in &self.blobs {
            (from, to) = (from.min(blob.first), to.max(blob.last));
        }
        let (from, to) = (from.max(0.0), to.min(length));
        (from < to).then_some((from, to))
    }

    /// The smallest radius of the blobs that stand out between two ray parameters [m]; infinite if
    /// none does: a sum of many is smoother than each.
    pub fn finest(&self, from: f32, to: f32) -> f32 {
        let cut = |blob: &&Crossing| blob.first < to && blob.last > from;
        let blobs = self.blobs.iter().filter(cut);
        let all = blobs.map(|blob| blob.most).sum::<f32>() + self.beta * (to - from);
        let stands_out = |blob: &&Crossing| blob.most > OUTSTANDING * all;
        let scales = self.blobs.iter().filter(cut).filter(stands_out).map(|blob| blob.a);
        1.0 / scales.fold(0.0, f32::max)
    }

    /// The most that any ray meets up to `length`.
    pub fn most(&self, length: f32) -> f32 {
        self.beta * length + self.blobs.iter().map(|blob| blob.most).sum::<f32>()
    }
}

#[inline(always)]
fn cross<S: Simd, const PARALLEL: bool>(
    simd: S,
    rays: &Control,
    blobs: &[Blob],
    least: f32,
) -> Vec<Crossing> {
    let mut crossings = Vec::with_capacity(blobs.len());
    for blob in blobs {
        let (a, dense) = (blob.a, blob.k > DENSE);
        let zero = [0.0; PADDED];
        let (mut middle, mut density, mut begins, mut whole) = (zero, zero, zero, zero);
        for at in (0..PADDED).step_by(Lanes::<S>::COUNT) {
            let direction = load3(simd, &rays.direction, at);
            let center = splat3(simd, blob.b);
            let center = if PARALLEL {
                center - load3(simd, &rays.offset, at).scale(Lanes::splat(simd, a))
            } else {
                center
            };
            let miss2 = center.cross(direction).length_squared();
            center.dot(direction).store(&mut middle[at..]);
            ((-miss2).exp() * Lanes::splat(simd, blob.k)).store(&mut density[at..]);
        }
        if bounds(&density).1 < least * blob.k.min(1.0) {
            continue;
        }
        for at in (0..PADDED).step_by(Lanes::<S>::COUNT) {
            let along = Lanes::load(simd, &middle[at..]);
            let start = (-along).erf();
            let behind = if dense {
                Num::erf_difference(-along, along.lit(1e4))
            } else {
                along.lit(1.0) - start
            };
            start.store(&mut begins[at..]);
            (Lanes::load(simd, &density[at..]) * behind).store(&mut whole[at..]);
        }
        let (low, high) = bounds(&middle);
        let (first, last) = ((low - ENDS as f32) / a, (high + ENDS as f32) / a);
        let most = bounds(&whole).1;
        crossings.push(Crossing { a, dense, first, last, middle, density, begins, whole, most });
    }
    crossings
}

/// Sums β and T over blobs. erf and exp are formed only where a blob is; behind it its whole depth
/// is added once, to the first row there, and carried on at the end.
#[inline(always)]
fn fill<S: Simd>(simd: S, crossings: &Crossings, t: &[Each], out: &mut Profile) {
    let mut behind = vec![[0.0f32; PADDED]; t.len() + 1];
    let ends: Vec<(f32, f32)> = t.iter().map(bounds).collect();
    for blob in &crossings.blobs {
        let begin = ends.partition_point(|end| end.1 < blob.first);
        let end = begin + ends[begin..].partition_point(|end| end.0 <= blob.last);
        let a = Lanes::splat(simd, blob.a);
        for at in (0..PADDED).step_by(Lanes::<S>::COUNT) {
            let middle = Lanes::load(simd, &blob.middle[at..]);
            let density = Lanes::load(simd, &blob.density[at..]);
            let begins = Lanes::load(simd, &blob.begins[at..]);
            let core = density * a * a.lit(1.0 / HALF_SQRT_PI);
            for (j, t) in t.iter().enumerate().take(end).skip(begin) {
                let t = Lanes::load(simd, &t[at..]);
                let s = a.mul_add(t, -middle);
                let gathered = if blob.dense {
                    let line = Line { start: -middle, end: s, miss2: s, peak: s };
                    line.between(a * t)
                } else {
                    s.erf() - begins
                };
                add(simd, density * gathered, &mut out.depth[j], at);
                add(simd, core * (-s.squared()).exp(), &mut out.log_beta[j], at);
            }
            add(simd, Lanes::load(simd, &blob.whole[at..]), &mut behind[end], at);
        }
    }
    for at in (0..PADDED).step_by(Lanes::<S>::COUNT) {
        let mut sum = Lanes::splat(simd, 0.0);
        let beta = Lanes::splat(simd, crossings.beta);
        for j in 0..t.len() {
            sum += Lanes::load(simd, &behind[j][at..]);
            let own = Lanes::load(simd, &out.depth[j][at..]) + sum;
            beta.mul_add(Lanes::load(simd, &t[j][at..]), own).store(&mut out.depth[j][at..]);
            let sum = Lanes::load(simd, &out.log_beta[j][at..]) + beta;
            sum.max(beta.lit(1e-30)).ln().store(&mut out.log_beta[j][at..]);
        }
    }
}

#[inline(always)]
fn add<S: Simd>(simd: S, value: Lanes<S>, row: &mut Each, at: usize) {
    (value + Lanes::load(simd, &row[at..])).store(&mut row[at..]);
}

/// The smallest and the largest number of a row.
#[inline(always)]
fn bounds(row: &Each) -> (f32, f32) {
    let (mut low, mut high) = (row[0], row[0]);
    for value in &row[1..] {
        low = if *value < low { *value } else { low };
        high = if *value > high { *value } else { high };
    }
    (low, high)
}
