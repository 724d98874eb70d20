//! Surface radiance, fog and veil put together to what a layer shows.

use crate::frame::context::Context;
use crate::geometry::batch::{Fogged, Hits, Row, Rows, SIZE, TILE, load3};
use crate::num::{Lanes, Num};
use crate::request::Layer;
use crate::vector::V3;
use fearless_simd::{Simd, dispatch};
use rayon::prelude::*;

/// The layer's picture, `[height][width][channels]`.
pub fn picture(context: &Context, hits: &[Hits], surface: &[Rows], fogged: &[&Fogged]) -> Vec<f32> {
    let (channels, width) = (context.view.layer.channels(), context.grid.width);
    let (black, clear) = ([[0.0; SIZE]; 3], Fogged::clear());
    let across = width.div_ceil(TILE);
    let mut pixels = vec![0.0; width * context.grid.height * channels];
    pixels.par_chunks_mut(TILE * width * channels).enumerate().for_each(|(band, rows)| {
        for column in 0..across {
            let tile = band * across + column;
            let surface = surface.get(tile).unwrap_or(&black);
            let fogged = fogged.get(tile).copied().unwrap_or(&clear);
            let values = compose(context, &hits[tile], surface, fogged);
            for (y, row) in rows.chunks_mut(width * channels).enumerate() {
                let end = row.len().min((column + 1) * TILE * channels);
                let pixels = row[column * TILE * channels..end].chunks_exact_mut(channels);
                for (at, pixel) in (y * TILE..).zip(pixels) {
                    for (value, row) in pixel.iter_mut().zip(&values) {
                        *value = row[at];
                    }
                }
            }
        }
    });
    pixels
}

/// The layer's values of a batch; unused channels are 0.
pub fn compose(context: &Context, hits: &Hits, surface: &Rows, fogged: &Fogged) -> Rows {
    let one_channel = |row: Row| [row, [0.0; SIZE], [0.0; SIZE]];
    match context.view.layer {
        Layer::Beauty => {
            dispatch!(context.job.level, simd => beauty(simd, context, surface, fogged))
        }
        Layer::Airlight => fogged.airlight,
        Layer::Surface => *surface,
        Layer::Normal => hits.normal,
        Layer::OpticalDepth => one_channel(fogged.depth),
        Layer::Transmittance => one_channel(fogged.depth.map(|depth| (-depth).exp())),
        Layer::Depth => one_channel(hits.length),
    }
}

#[inline(always)]
fn beauty<S: Simd>(simd: S, context: &Context, surface: &Rows, fogged: &Fogged) -> Rows {
    let [r, g, b] = context.ambient;
    let ambient = V3::new(Lanes::splat(simd, r), Lanes::splat(simd, g), Lanes::splat(simd, b));
    let mut values = [[0.0; SIZE]; 3];
    for at in (0..SIZE).step_by(Lanes::<S>::COUNT) {
        let depth = Lanes::load(simd, &fogged.depth[at..]);
        let lost = absorptance(depth);
        // Not 1 − lost, which has no digits left of a bright surface in thick fog.
        let through = (-depth).exp();
        let scattered = load3(simd, &fogged.airlight, at) + ambient.scale(lost);
        let sum = load3(simd, surface, at).scale(through) + scattered;
        sum.x.store(&mut values[0][at..]);
        sum.y.store(&mut values[1][at..]);
        sum.z.store(&mut values[2][at..]);
    }
    values
}

/// 1 − e^−T, which keeps its digits in thin fog.
#[inline(always)]
fn absorptance<S: Simd>(depth: Lanes<S>) -> Lanes<S> {
    /// Up to here the series is exact to 1e-7 of it.
    const THIN: f64 = 0.01;
    let one = depth.lit(1.0);
    let bend = depth.mul_add(depth.lit(1.0 / 6.0), depth.lit(-0.5));
    let series = depth * depth.mul_add(bend, one);
    Lanes::select(depth.lt(depth.lit(THIN)), series, one - (-depth).exp())
}
