//! Where 8-bit levels round up: not at one half in every pixel, but at a threshold that differs
//! from pixel to pixel. A slow gradient then has the right mean everywhere, instead of bands.
//!
//! The thresholds of pixel (x, y) are fract(x/g + y/g²), g the plastic number: Roberts's R2
//! sequence (2018), in which neighbours differ as much as they can, and every small area holds all
//! thresholds evenly. All channels share a threshold, so that greys stay grey.
//!
//! Twin: shaders/passes/tonemap.wgsl.

/// The fractions 1/g and 1/g² of a whole turn of a `u32`, whose overflow is the `fract`.
const STEP_X: u32 = 0xc13f_a9a9;
const STEP_Y: u32 = 0x91e1_0da6;

/// The thresholds of row `y`, from the left, in (0, 1): 256 different ones. None is nearer to 0 or 1
/// than 1/512, so that a value that rounding leaves next to a level becomes that level everywhere.
pub fn thresholds(y: usize) -> impl Iterator<Item = f32> {
    let start = (y as u32).wrapping_mul(STEP_Y);
    (0u32..).map(move |x| {
        let place = x.wrapping_mul(STEP_X).wrapping_add(start);
        ((place >> 24) as f32 + 0.5) / 256.0
    })
}

/// The level of a value in [0, 1].
pub fn level(value: f32, threshold: f32) -> u8 {
    (value * 255.0 + threshold) as u8
}
