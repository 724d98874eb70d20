//! What the machine could do: multiplications and additions in registers alone, on all threads.

use fearless_simd::{Level, Simd, SimdBase, dispatch};
use fogbank_core::num::{Lanes, Num};
use rayon::prelude::*;
use std::fmt;
use std::hint::black_box;
use std::time::Instant;

/// Independent sums that keep every unit busy.
const CHAINS: usize = 10;
const STEPS: usize = 1 << 20;
/// Of so many runs the quickest counts: other programs only ever slow one down.
const TRIES: usize = 5;

/// The machine.
pub struct Machine {
    threads: usize,
    level: Level,
    /// Peak of all threads [GFLOP/s].
    pub peak: f64,
}

impl Machine {
    pub fn measure() -> Self {
        let (threads, level) = (rayon::current_num_threads(), Level::new());
        let flop = dispatch!(level, simd => lanes(simd)) * 2 * CHAINS * STEPS * threads;
        let run = |_| {
            let since = Instant::now();
            (0..threads).into_par_iter().with_max_len(1).for_each(|_| {
                black_box(dispatch!(level, simd => chains(simd, black_box(0.5))));
            });
            since.elapsed().as_secs_f64()
        };
        let best = (0..TRIES).map(run).fold(f64::INFINITY, f64::min);
        Self { threads, level, peak: flop as f64 / best * 1e-9 }
    }
}

impl fmt::Display for Machine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { threads, level, peak } = self;
        let level = format!("{level:?}");
        let level = level.split('(').next().unwrap_or_default();
        write!(f, "{threads} threads with {level}, {peak:.0} GFLOP/s at most")
    }
}

#[inline(always)]
fn lanes<S: Simd>(_: S) -> usize {
    Lanes::<S>::COUNT
}

#[inline(always)]
fn chains<S: Simd>(simd: S, seed: f32) -> f32 {
    let factor = Lanes::splat(simd, 0.999_9);
    let mut sums = [Lanes::splat(simd, seed); CHAINS];
    for _ in 0..STEPS {
        for sum in &mut sums {
            *sum = sum.mul_add(factor, factor);
        }
    }
    sums.iter().map(|sum| sum.0.as_slice()[0]).sum()
}
