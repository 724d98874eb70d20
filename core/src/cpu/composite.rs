//! Surface radiance, fog and veil put together to what a layer shows: the lamps' colours, their light and
//! exposure come in here.

use super::edges::{Samples, weight};
use super::passes::{Depths, Fog, Share};
use super::shade;
use super::tiles::Strip;
use super::traced::Traced;
use crate::frame::context::Context;
use crate::frame::samples::CENTER;
use crate::geometry::batch::{Ends, Row, Rows, SIZE, TILE, load3};
use crate::num::{Lanes, Num};
use crate::request::Layer;
use crate::vector::V3;
use fearless_simd::{Simd, dispatch};
use rayon::prelude::*;
use std::sync::Arc;

/// What the passes made of a frame.
pub struct Made<'a> {
    pub traced: &'a Traced,
    pub strip: &'a Strip,
    /// One if the fog is grey; else red, green and blue.
    pub bands: Vec<Band<'a>>,
}

/// What they made in one band of colour.
pub struct Band<'a> {
    pub context: &'a Context<'a>,
    /// What is scattered of each lamp; then what takes light away, where no lamp's own run tells that.
    pub fog: &'a [Option<Arc<Share<Fog>>>],
    /// Depths to surfaces, lamp by lamp.
    pub depths: &'a [Option<Arc<Share<Depths>>>],
    /// The further octaves of its airlight.
    pub octaves: Vec<Self>,
}

/// A strip of the layer's picture, `[height][width][channels]`.
pub fn picture(made: &Made, channels: usize) -> Vec<f32> {
    let grid = made.bands[0].context.grid;
    let (width, first) = (grid.width, made.strip.tiles.start);
    let across = width.div_ceil(TILE);
    let mut pixels = vec![0.0; width * made.strip.lines(grid).len() * channels];
    // One by one: those with edges take several times as long as others.
    let bands = pixels.par_chunks_mut(TILE * width * channels).enumerate().with_max_len(1);
    bands.for_each(|(band, rows)| {
        for column in 0..across {
            let values = tile(made, first + band * across + column);
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

/// The pixels of a tile, those at edges as means of their samples.
fn tile(made: &Made, index: usize) -> Rows {
    let context = made.bands[0].context;
    let rays = context.viewpoint.tile(context.grid.tile(index), CENTER);
    let mut batches = made.traced.batches(index, &rays).enumerate();
    let Some((_, pixels)) = batches.next() else { return [[0.0; SIZE]; 3] };
    let mut values = made.compose(index, 0, pixels);
    let Some(samples) = made.traced.samples.get(index).filter(|samples| !samples.is_empty()) else {
        return values;
    };
    let each = context.view.samples.unwrap_or(1) as usize;
    let mut sums = vec![([0.0f32; 3], 0.0f32); samples.places.len()];
    let mut places = (0..sums.len()).flat_map(|at| std::iter::repeat_n(at, each));
    for (batch, ends) in batches {
        let values = made.compose(index, batch, ends);
        for (at, place) in places.by_ref().take(ends.rays.count).enumerate() {
            let value = values.each_ref().map(|row| row[at]);
            let weight = weight(context, value);
            let (sum, weights) = &mut sums[place];
            *weights += weight;
            (0..3).for_each(|k| sum[k] += weight * value[k]);
        }
    }
    set_edges(&mut values, samples, &sums);
    values
}

fn set_edges(values: &mut Rows, samples: &Samples, sums: &[([f32; 3], f32)]) {
    for (place, (sum, weight)) in samples.places.iter().zip(sums) {
        (0..3).for_each(|k| values[k][*place] = sum[k] / weight);
    }
}

impl Made<'_> {
    /// The layer's values of a batch. A coloured picture is three grey ones, each of
    /// which gives its own channel.
    fn compose(&self, tile: usize, batch: usize, ends: Ends) -> Rows {
        let place = self.strip.place(tile);
        let [red, green, blue] = self.bands.as_slice() else {
            return self.bands[0].compose(place, batch, ends);
        };
        let [red, green, blue] = [red, green, blue].map(|band| band.compose(place, batch, ends));
        [red[0], green[1], blue[2]]
    }
}

impl Band<'_> {
    /// The layer's values of a batch as this band has them; what has one channel has it thrice.
    fn compose(&self, place: usize, batch: usize, ends: Ends) -> Rows {
        let grey = |row: Row| [row; 3];
        let hits = ends.hits;
        match self.context.view.layer {
            Layer::Beauty => {
                let surface = self.surface(place, batch, ends);
                let airlight = self.airlight(place, batch);
                let depth = self.depth(place, batch);
                dispatch!(self.context.job.level, simd => {
                    beauty(simd, self.context, &surface, &airlight, depth)
                })
            }
            Layer::Airlight => self.airlight(place, batch),
            Layer::Surface => self.surface(place, batch, ends),
            Layer::Normal => hits.normal,
            Layer::OpticalDepth => grey(*self.depth(place, batch)),
            Layer::Transmittance => grey(self.depth(place, batch).map(|depth| (-depth).exp())),
            Layer::Depth => grey(hits.length),
        }
    }

    fn surface(&self, place: usize, batch: usize, Ends { rays, hits }: Ends) -> Rows {
        let shares = self.depths.iter().flatten();
        let depths: Vec<_> = shares.map(|share| &share.run[place][batch][share.slot]).collect();
        shade::surface_radiance(self.context, rays, hits, &depths)
    }

    /// Optical depth of the view rays: the first lamp's run forms it on the way, or the last share is it.
    fn depth(&self, place: usize, batch: usize) -> &Row {
        const CLEAR: Row = [0.0; SIZE];
        let told = if self.context.interpolates() { self.fog.first() } else { self.fog.last() };
        told.and_then(Option::as_ref).map_or(&CLEAR, |share| &share.run[place][batch].depth)
    }

    /// The light of all lamps in their colours.
    fn airlight(&self, place: usize, batch: usize) -> Rows {
        let mut sum = [[0.0; SIZE]; 3];
        for octave in [self].into_iter().chain(&self.octaves) {
            octave.add_airlight(place, batch, &mut sum);
        }
        sum
    }

    fn add_airlight(&self, place: usize, batch: usize, sum: &mut Rows) {
        for (scatter, share) in self.context.scatters.iter().zip(self.fog) {
            let Some(share) = share else { continue };
            let Some(row) = share.run[place][batch].airlight.get(share.slot) else { continue };
            let rgb = scatter.colour.as_vec3();
            dispatch!(self.context.job.level, simd => add_coloured(simd, row, rgb.into(), sum));
        }
    }
}

#[inline(always)]
fn add_coloured<S: Simd>(simd: S, row: &Row, rgb: [f32; 3], sum: &mut Rows) {
    for at in (0..SIZE).step_by(Lanes::<S>::COUNT) {
        let value = Lanes::load(simd, &row[at..]);
        for (sum, part) in sum.iter_mut().zip(rgb) {
            let sum = &mut sum[at..];
            value.mul_add(Lanes::splat(simd, part), Lanes::load(simd, sum)).store(sum);
        }
    }
}

#[inline(always)]
fn beauty<S: Simd>(
    simd: S,
    context: &Context,
    surface: &Rows,
    airlight: &Rows,
    depth: &Row,
) -> Rows {
    let opaque = Lanes::splat(simd, context.view.options.opaque());
    let [r, g, b] = context.ambient;
    let ambient = V3::new(Lanes::splat(simd, r), Lanes::splat(simd, g), Lanes::splat(simd, b));
    let mut values = [[0.0; SIZE]; 3];
    for at in (0..SIZE).step_by(Lanes::<S>::COUNT) {
        let depth = Lanes::load(simd, &depth[at..]);
        let lost = depth.absorptance();
        // Not 1 − lost, which has no digits left of a bright surface in thick fog.
        let through = (-depth).exp();
        let zero = depth.lit(0.0);
        let through = Lanes::select(depth.lt(opaque), through, zero);
        let scattered = load3(simd, airlight, at) + ambient.scale(lost);
        let sum = load3(simd, surface, at).scale(through) + scattered;
        sum.x.store(&mut values[0][at..]);
        sum.y.store(&mut values[1][at..]);
        sum.z.store(&mut values[2][at..]);
    }
    values
}
