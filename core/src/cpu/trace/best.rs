//! Rays and what each has met so far.

use super::linear::LinearLanes;
use crate::geometry::batch::{Rays, Row, SIZE};
use crate::num::{Lanes, Num};
use crate::vector::V3;
use fearless_simd::{Select, Simd, SimdBase, SimdMask};
use std::hint::black_box;

/// A batch of rays and their nearest hits so far.
pub struct Sample<'r> {
    /// The rays.
    pub rays: &'r Rays,
    /// Their nearest hits.
    pub best: Best,
}

/// Nearest hits so far.
pub struct Best {
    /// Ways along the rays [m].
    pub length: Row,
    /// Barycentric weights of the first corner.
    pub u: Row,
    /// Of the second.
    pub v: Row,
    /// Their ids.
    pub id: [u32; SIZE],
}

impl Best {
    /// Keeps a triangle where it is in front, and tells whether it is anywhere.
    #[inline(always)]
    pub fn meet<S: Simd>(
        &mut self,
        simd: S,
        at: usize,
        [u, v, w]: &[LinearLanes<S>; 3],
        numerator: &LinearLanes<S>,
        ray: V3<Lanes<S>>,
        id: u32,
    ) -> bool {
        let (u, v, w) = (u.at(ray), v.at(ray), w.at(ray));
        let inside = u.min(v).min(w).0.simd_ge(0.0) | u.max(v).max(w).0.simd_le(0.0);
        if !inside.any_true() {
            return false;
        }
        let sum = u + v + w;
        let distance = numerator.at(ray) / sum;
        let front = inside & Lanes::lt(u.lit(0.0), distance);
        self.keep(simd, at, front, distance, (u / sum, v / sum), id)
    }

    /// Keeps what was met where it is nearer, and tells whether it is anywhere.
    #[inline(always)]
    pub fn keep<S: Simd>(
        &mut self,
        simd: S,
        at: usize,
        met: S::mask32s,
        distance: Lanes<S>,
        (u, v): (Lanes<S>, Lanes<S>),
        id: u32,
    ) -> bool {
        let length = Lanes::load(simd, &self.length[at..]);
        let nearer = met & distance.lt(length);
        if !nearer.any_true() {
            return false;
        }
        write(simd, &mut self.length, at, nearer, distance);
        write(simd, &mut self.u, at, nearer, u);
        write(simd, &mut self.v, at, nearer, v);
        let ids = &mut self.id[at..at + Lanes::<S>::COUNT];
        let chosen = nearer.select(S::u32s::splat(simd, id), S::u32s::from_slice(simd, ids));
        black_box(chosen).store_slice(ids);
        true
    }

    /// The longest way of a register of rays.
    #[inline(always)]
    pub fn farthest<S: Simd>(&self, simd: S, at: usize) -> f32 {
        Lanes::load(simd, &self.length[at..]).largest()
    }
}

#[inline(always)]
fn write<S: Simd>(simd: S, row: &mut Row, at: usize, mask: S::mask32s, value: Lanes<S>) {
    let old = Lanes::load(simd, &row[at..]);
    // By way of memory, because a store under a mask, which the compiler would make of it, takes some
    // processors twenty times as long.
    black_box(Lanes::select(mask, value, old)).store(&mut row[at..]);
}
