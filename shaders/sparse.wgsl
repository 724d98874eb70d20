// What a draft computes for one pixel in 16 only, carried over to the pixels between by nearness and
// likeness of depth (Fogshop 2007, section 5.4): no halo of background fog stands over the edge of
// what is in front.
//
// A pixel without a neighbour at a like depth is missing: passes with MISSING compute those.
//
// Twin: core/src/cpu/upsample.rs, which also computes the pixels around a lamp's image. Here the
// homogeneous fog, whose airlight peaks there, is not carried over at all.

#define_import_path fogbank::sparse

#import fogbank::num
#import fogbank::view::{View, NOTHING}

/// Pixels from one computed pixel to the next.
const STEP: u32 = 4u;
/// Depths that differ by more than this share do not lend each other their fog.
const LIKE: f32 = 0.1;
/// Below this sum of weights a pixel has no neighbour to borrow from.
const ENOUGH: f32 = 0.25;

/// The four computed pixels around one.
struct Around {
    /// Columns of the left (x) and right (y) ones, lines of the upper (z) and lower (w) ones, in the
    /// low resolution.
    cells: vec4<u32>,
    /// How near each is: upper left, upper right, lower left, lower right.
    near: vec4<f32>,
}

fn size_of(view: View) -> vec2<u32> {
    return (vec2<u32>(view.size) + STEP - 1u) / STEP;
}

/// For a pixel of the full picture.
fn around(view: View, pixel: vec2<u32>) -> Around {
    // Pixel STEP/2 of a cell is computed; those of the border stand for what lies beyond.
    let place = pixel + STEP / 2u;
    let low = max(place / STEP, vec2<u32>(1u)) - 1u;
    let high = min(place / STEP, size_of(view) - 1u);
    let share = vec2<f32>(place % STEP) / f32(STEP);
    let across = vec2<f32>(1.0 - share.x, share.x);
    let near = vec4<f32>(across * (1.0 - share.y), across * share.y);
    return Around(vec4<u32>(low.x, high.x, low.y, high.y), near);
}

/// One of the four in the low resolution.
fn cell(around: Around, i: u32) -> vec2<u32> {
    let column = select(around.cells.x, around.cells.y, i % 2u == 1u);
    return vec2<u32>(column, select(around.cells.z, around.cells.w, i > 1u));
}

/// The pixel of the full picture that stands for a cell.
fn pixel_of(view: View, cell: vec2<u32>) -> vec2<u32> {
    return min(cell * STEP + STEP / 2u, vec2<u32>(view.size) - 1u);
}

/// Place of a cell in the buffers of the low resolution.
fn index_of(view: View, cell: vec2<u32>) -> u32 {
    return cell.y * size_of(view).x + cell.x;
}

/// Weights of the four, from where the rays end. They add up to 1, or to 0 for a missing pixel.
fn weights(
    view: View,
    hits: texture_2d<f32>,
    surfaces: texture_2d<u32>,
    around: Around,
    pixel: vec2<u32>,
) -> vec4<f32> {
    let own_m = end_of(hits, surfaces, pixel);
    var apart = vec4<f32>(0.0);
    for (var i = 0u; i < 4u; i++) {
        apart[i] = abs(end_of(hits, surfaces, pixel_of(view, cell(around, i))) - own_m);
    }
    let like = max(1.0 - apart / max(LIKE * abs(own_m), num::LEAST), vec4<f32>(0.0));
    let weights = around.near * like;
    let sum = dot(weights, vec4<f32>(1.0));
    return select(vec4<f32>(0.0), weights / max(sum, num::LEAST), sum >= ENOUGH);
}

fn is_missing(
    view: View,
    hits: texture_2d<f32>,
    surfaces: texture_2d<u32>,
    pixel: vec2<u32>,
) -> bool {
    return all(weights(view, hits, surfaces, around(view, pixel), pixel) == vec4<f32>(0.0));
}

/// Where a pixel's ray ends, negative where it meets nothing [m].
fn end_of(hits: texture_2d<f32>, surfaces: texture_2d<u32>, pixel: vec2<u32>) -> f32 {
    let length_m = textureLoad(hits, pixel, 0).w;
    return select(length_m, -length_m, textureLoad(surfaces, pixel, 0).x == NOTHING);
}
