//! Radiance and other layers brought onto a screen: exposure, tone map, sRGB; colour maps for
//! layers that are no colours. Gradients are dithered, normals are not: they are read as numbers.

use super::dither::{level, thresholds};
use crate::frame::Frame;
use crate::num::{Lanes, Num};
use crate::request::{Layer, Tonemap, View};
use crate::vector::V3;
use fearless_simd::{Level, Simd, dispatch};
use rayon::prelude::*;
use std::borrow::Cow;

/// Pixels that are mapped in one go, at least.
const CHUNK: usize = 2048;

/// The frame as 8-bit RGB.
pub fn bytes<'a>(frame: &'a Frame, view: &View) -> Cow<'a, [u8]> {
    frame.shown.as_ref().map_or_else(|| mapped(frame, view).into(), |shown| shown.into())
}

fn mapped(frame: &Frame, view: &View) -> Vec<u8> {
    let map = ScalarMap::new(frame);
    let machine = Level::new();
    rows(frame.width, frame.channels, &frame.pixels, |y, pixels, out| match frame.layer {
        Layer::Beauty | Layer::Airlight | Layer::Surface => {
            dispatch!(machine, simd => radiance(simd, pixels, view, y, out));
        }
        Layer::Normal => {
            for (byte, value) in out.iter_mut().zip(pixels) {
                *byte = level(0.5 * value + 0.5, 0.5);
            }
        }
        Layer::OpticalDepth | Layer::Transmittance if frame.channels == 3 => {
            shares(pixels, y, out, |value| map.position(value));
        }
        Layer::OpticalDepth | Layer::Transmittance | Layer::Depth => {
            colours(pixels, y, out, |value| map.position(value));
        }
    })
}

/// Relative errors as 8-bit RGB, by their logarithm: 1e-4 and less is darkest, 1 and more brightest.
pub fn errors(pixels: &[f32], width: usize) -> Vec<u8> {
    const DECADES: f32 = 4.0;
    rows(width, 1, pixels, |y, pixels, out| {
        colours(pixels, y, out, |error| 1.0 + error.log10() / DECADES);
    })
}

/// 8-bit RGB, row by row: `show` takes the number of a row, its values and its bytes.
fn rows(
    width: usize,
    channels: usize,
    pixels: &[f32],
    show: impl Fn(usize, &[f32], &mut [u8]) + Sync,
) -> Vec<u8> {
    let width = width.max(1);
    let mut bytes = vec![0; pixels.len() / channels * 3];
    let rows = bytes.par_chunks_mut(width * 3).zip(pixels.par_chunks(width * channels));
    let rows = rows.enumerate().with_min_len(CHUNK.div_ceil(width));
    rows.for_each(|(y, (out, pixels))| show(y, pixels, out));
    bytes
}

#[inline(always)]
fn radiance<S: Simd>(simd: S, pixels: &[f32], view: &View, y: usize, out: &mut [u8]) {
    let exposure = Lanes::splat(simd, view.exposure_ev.exp2() as f32);
    let lanes = Lanes::<S>::COUNT;
    let mut thresholds = thresholds(y);
    for (pixels, out) in pixels.chunks(3 * lanes).zip(out.chunks_mut(3 * lanes)) {
        let mut rows = [[0.0f32; 16]; 3];
        for (i, rgb) in pixels.chunks_exact(3).enumerate() {
            (0..3).for_each(|k| rows[k][i] = rgb[k]);
        }
        let [r, g, b] = &rows;
        let exposed = V3::new(Lanes::load(simd, r), Lanes::load(simd, g), Lanes::load(simd, b))
            .scale(exposure);
        let shown = on_screen(exposed, view.tonemap);
        shown.x.store(&mut rows[0]);
        shown.y.store(&mut rows[1]);
        shown.z.store(&mut rows[2]);
        for ((i, rgb), threshold) in out.chunks_exact_mut(3).enumerate().zip(&mut thresholds) {
            (0..3).for_each(|k| rgb[k] = level(rows[k][i], threshold));
        }
    }
}

/// Scalars of a row as colours, by their place on the map.
fn colours(pixels: &[f32], y: usize, out: &mut [u8], position: impl Fn(f32) -> f32) {
    for ((rgb, value), threshold) in out.chunks_exact_mut(3).zip(pixels).zip(thresholds(y)) {
        rgb.copy_from_slice(&colour(position(*value), threshold));
    }
}

/// Shares of a row, channel by channel, as the colours that they are.
fn shares(pixels: &[f32], y: usize, out: &mut [u8], share: impl Fn(f32) -> f32) {
    for ((rgb, values), threshold) in
        out.chunks_exact_mut(3).zip(pixels.chunks_exact(3)).zip(thresholds(y))
    {
        for (byte, value) in rgb.iter_mut().zip(values) {
            *byte = level(srgb(f64::from(share(*value))) as f32, threshold);
        }
    }
}

/// Exposed linear radiance to display values in [0, 1].
#[inline(always)]
fn on_screen<N: Num>(rgb: V3<N>, tonemap: Tonemap) -> V3<N> {
    match tonemap {
        Tonemap::Agx => agx(rgb),
        Tonemap::Reinhard => V3::new(reinhard(rgb.x), reinhard(rgb.y), reinhard(rgb.z)),
        Tonemap::None => V3::new(srgb(rgb.x), srgb(rgb.y), srgb(rgb.z)),
    }
}

#[inline(always)]
fn reinhard<N: Num>(v: N) -> N {
    srgb(v / (v + v.lit(1.0)))
}

/// The sRGB transfer function, clamped (IEC 61966-2-1).
#[inline(always)]
fn srgb<N: Num>(linear: N) -> N {
    let v = unit(linear);
    let curved = (v.max(v.lit(1e-9)).ln() * v.lit(1.0 / 2.4)).exp() * v.lit(1.055) - v.lit(0.055);
    N::select(v.lt(v.lit(0.003_130_8)), v * v.lit(12.92), curved)
}

/// AgX (Troy Sobotka): primaries drawn inwards, a logarithmic range of 16.5 stops around middle
/// grey, a sigmoid as a fitted polynomial, primaries drawn out again. The result is
/// display-encoded. Ours: the brightest light is white, where the fit leaves it a third of a level
/// darker.
#[inline(always)]
fn agx<N: Num>(rgb: V3<N>) -> V3<N> {
    const INSET: [[f64; 3]; 3] = [
        [0.842_479_062_253_094, 0.078_433_6, 0.079_223_745_147_764_3],
        [0.042_328_242_261_012_3, 0.878_468_636_469_772, 0.079_166_127_460_543_1],
        [0.042_375_654_905_705_1, 0.078_433_6, 0.879_142_973_793_104],
    ];
    const OUTSET: [[f64; 3]; 3] = [
        [1.196_879_005_120_17, -0.098_020_881_140_136_8, -0.099_029_744_079_720_5],
        [-0.052_896_851_757_456_2, 1.151_903_129_904_17, -0.098_961_176_844_843_3],
        [-0.052_971_635_514_443_8, -0.098_043_450_117_124_1, 1.151_073_672_641_16],
    ];
    /// What the fit makes of the brightest light, in its darkest channel.
    const WHITE: f64 = 0.9984;
    let inner = apply(INSET, rgb);
    let shown = apply(OUTSET, V3::new(curve(inner.x), curve(inner.y), curve(inner.z)))
        .scale(rgb.x.lit(1.0 / WHITE));
    V3::new(unit(shown.x), unit(shown.y), unit(shown.z))
}

/// Clamped to [0, 1].
#[inline(always)]
fn unit<N: Num>(v: N) -> N {
    v.max(v.lit(0.0)).min(v.lit(1.0))
}

/// AgX's logarithmic range and sigmoid.
#[inline(always)]
fn curve<N: Num>(v: N) -> N {
    const LOWEST_EV: f64 = -12.473_93;
    const HIGHEST_EV: f64 = 4.026_069;
    let ev = v.max(v.lit(1e-10)).ln() * v.lit(std::f64::consts::LOG2_E);
    let place = (ev - v.lit(LOWEST_EV)) * v.lit(1.0 / (HIGHEST_EV - LOWEST_EV));
    sigmoid(unit(place))
}

#[inline(always)]
fn sigmoid<N: Num>(x: N) -> N {
    const FIT: [f64; 7] = [-0.002_32, 0.119_1, 0.429_8, -6.868, 31.96, -40.14, 15.5];
    let mut sum = x.lit(FIT[6]);
    for c in FIT[..6].iter().rev() {
        sum = sum.mul_add(x, x.lit(*c));
    }
    sum
}

#[inline(always)]
fn apply<N: Num>(m: [[f64; 3]; 3], v: V3<N>) -> V3<N> {
    V3::new(row(m[0], v), row(m[1], v), row(m[2], v))
}

#[inline(always)]
fn row<N: Num>([x, y, z]: [f64; 3], v: V3<N>) -> N {
    v.x * v.x.lit(x) + v.y * v.x.lit(y) + v.z * v.x.lit(z)
}

/// The nearest and the farthest depth of a frame, between which its colours lie [m]; none of other layers.
pub fn depth_range(frame: &Frame) -> Option<[f32; 2]> {
    let range = || {
        let map = ScalarMap::new(frame);
        [map.least, map.most]
    };
    (frame.layer == Layer::Depth).then(range)
}

/// Where a scalar lies on the colour map.
struct ScalarMap {
    layer: Layer,
    least: f32,
    most: f32,
}

impl ScalarMap {
    fn new(frame: &Frame) -> Self {
        let range = |start, f: fn(f32, f32) -> f32| frame.pixels.iter().copied().fold(start, f);
        let least = range(f32::INFINITY, f32::min).max(1e-6);
        let most = range(0.0, f32::max);
        Self { layer: frame.layer, least, most }
    }

    /// 0 to 1: depths in the logarithm between the frame's nearest and farthest, optical depths as
    /// what they take away.
    fn position(&self, value: f32) -> f32 {
        match self.layer {
            Layer::Transmittance => value,
            Layer::Depth => {
                let span = (self.most / self.least).max(1.0 + 1e-6).ln();
                (value.max(self.least) / self.least).ln() / span
            }
            _ => -(-value).exp_m1(),
        }
    }
}

/// A dark-to-bright map of even lightness steps (blue, green, yellow).
fn colour(position: f32, threshold: f32) -> [u8; 3] {
    const STOPS: [[f32; 3]; 6] = [
        [13.0, 8.0, 40.0],
        [52.0, 52.0, 122.0],
        [38.0, 108.0, 142.0],
        [36.0, 161.0, 126.0],
        [140.0, 206.0, 70.0],
        [250.0, 234.0, 130.0],
    ];
    let place = position.clamp(0.0, 1.0) * (STOPS.len() - 1) as f32;
    let low = (place as usize).min(STOPS.len() - 2);
    let share = place - low as f32;
    [0, 1, 2].map(|k| {
        let between = STOPS[low][k] + share * (STOPS[low + 1][k] - STOPS[low][k]);
        (between + threshold) as u8
    })
}
