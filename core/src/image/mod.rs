//! A finished frame as a file.

mod about;
pub(crate) mod display;
mod dither;
mod exr;
pub mod flip;
mod jpeg;
pub mod map;
mod npy;
mod screen;

use crate::frame::Frame;
use crate::request::{Quality, View};
use about::Caption;
pub use display::depth_range;
use std::borrow::Cow;

/// The files that a frame can become.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// 8-bit, lossless.
    Png,
    /// 8-bit, lossy, the fastest.
    Jpeg,
    /// 8-bit, lossless.
    WebP,
    /// Float32, scene-linear.
    Exr,
    /// Float32, scene-linear, `[height][width]` or `[height][width][3]`.
    Npy,
}

impl Format {
    /// All formats, the default first.
    pub const ALL: [Self; 5] = [Self::Png, Self::Jpeg, Self::WebP, Self::Exr, Self::Npy];

    /// Its media type.
    pub fn content_type(self) -> &'static str {
        match self {
            Self::Png => "image/png",
            Self::Jpeg => "image/jpeg",
            Self::WebP => "image/webp",
            Self::Exr => "image/x-exr",
            Self::Npy => "application/x-npy",
        }
    }

    /// The endings of its file names.
    pub fn extensions(self) -> &'static [&'static str] {
        match self {
            Self::Png => &["png"],
            Self::Jpeg => &["jpg", "jpeg"],
            Self::WebP => &["webp"],
            Self::Exr => &["exr"],
            Self::Npy => &["npy"],
        }
    }

    /// Whether it holds scene-linear floats.
    pub fn is_float(self) -> bool {
        matches!(self, Self::Exr | Self::Npy)
    }

    /// Samples per pixel along edges when the request names none.
    pub fn default_samples(self, quality: Quality) -> u32 {
        if self.is_float() || quality == Quality::Draft { 1 } else { 4 }
    }
}

impl View {
    /// The view for a file format: its samples where none were asked for.
    pub fn for_format(self, format: Format) -> Self {
        let samples = self.samples.unwrap_or(format.default_samples(self.quality));
        Self { samples: Some(samples), for_screen: !format.is_float(), ..self }
    }
}

/// The encoder refused.
#[derive(Debug, thiserror::Error)]
#[error("the {format:?} encoder failed: {reason}")]
pub struct EncodeError {
    /// Which encoder.
    pub format: Format,
    /// Its words.
    pub reason: String,
}

/// Encodes a frame.
///
/// # Errors
/// What the encoder says.
pub fn encode(frame: &Frame, view: &View, format: Format) -> Result<Vec<u8>, EncodeError> {
    if format.is_float() && frame.shown.is_some() {
        return Err(EncodeError { format, reason: "the frame is for a screen".into() });
    }
    let is_draft = view.quality == Quality::Draft;
    let rgb = || display::bytes(frame, view);
    write(&Raster::from(frame), format, is_draft, rgb, || Caption::of(frame))
}

/// The sizes of relative errors, `[height][width]`, top row first.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorImage {
    /// Pixels along a row.
    pub width: usize,
    /// Rows of pixels.
    pub height: usize,
    /// The errors.
    pub pixels: Vec<f32>,
}

/// Encodes the relative errors of a comparison: as they are in float formats, else colour-mapped by
/// their logarithm, from 1e-4 (darkest) to 1 (brightest).
///
/// # Errors
/// What the encoder says.
pub fn encode_errors(errors: &ErrorImage, format: Format) -> Result<Vec<u8>, EncodeError> {
    let ErrorImage { width, height, ref pixels } = *errors;
    let raster = Raster { width, height, channels: 1, pixels };
    write(&raster, format, false, || display::errors(pixels, width).into(), Caption::of_errors)
}

/// The numbers of an image.
struct Raster<'a> {
    width: usize,
    height: usize,
    channels: usize,
    pixels: &'a [f32],
}

impl<'a> From<&'a Frame> for Raster<'a> {
    fn from(frame: &'a Frame) -> Self {
        let Frame { width, height, channels, ref pixels, .. } = *frame;
        Self { width, height, channels, pixels }
    }
}

/// Writes floats as they are, or what stands for them on a screen.
fn write<'a>(
    image: &Raster,
    format: Format,
    is_draft: bool,
    rgb: impl FnOnce() -> Cow<'a, [u8]>,
    caption: impl FnOnce() -> Caption,
) -> Result<Vec<u8>, EncodeError> {
    let bytes = match format {
        Format::Exr => exr::exr(image, &caption()),
        Format::Npy => npy::npy(image),
        Format::Png => screen::png(&rgb(), image),
        Format::Jpeg => jpeg::jpeg(&rgb(), image, is_draft),
        Format::WebP => screen::webp(&rgb(), image),
    };
    bytes.map_err(|error| EncodeError { format, reason: error.to_string() })
}

/// The frame as 8-bit RGB, as a picture of it shows it.
pub(crate) fn on_screen(frame: &Frame, view: &View) -> Vec<u8> {
    display::bytes(frame, view).into_owned()
}

/// A frame of optical depths as a 16-bit PNG, grey or a number a channel, with the value that white stands for: the pixel
/// value `p` of 0–65535 means `p / 65535 · scale`.
///
/// # Errors
/// What the encoder says.
pub fn encode_png16(frame: &Frame) -> Result<(Vec<u8>, f64), EncodeError> {
    let most = frame.pixels.iter().copied().fold(0.0, f32::max);
    let scale = if most > 0.0 { f64::from(most) } else { 1.0 };
    let refuse = |error: Failure| EncodeError { format: Format::Png, reason: error.to_string() };
    Ok((screen::png16(&Raster::from(frame), scale).map_err(refuse)?, scale))
}

/// Whatever an encoder may say.
type Failure = Box<dyn std::error::Error + Send + Sync>;
