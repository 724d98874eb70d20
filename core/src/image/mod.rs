//! A finished frame as a file.

mod display;
mod float;
mod screen;

use crate::renderer::Frame;
use crate::request::{Quality, View};

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
    let refuse = |reason: String| EncodeError { format, reason };
    let bytes = match format {
        Format::Exr => float::exr(frame),
        Format::Npy => float::npy(frame),
        Format::Png => screen::png(&display::bytes(frame, view), frame),
        Format::Jpeg => screen::jpeg(&display::bytes(frame, view), frame),
        Format::WebP => screen::webp(&display::bytes(frame, view), frame),
    };
    bytes.map_err(|error| refuse(error.to_string()))
}

/// A one-channel frame as a 16-bit grey PNG, with the value that white stands for: the pixel
/// value `p` of 0–65535 means `p / 65535 · scale`.
///
/// # Errors
/// What the encoder says.
pub fn encode_png16(frame: &Frame) -> Result<(Vec<u8>, f64), EncodeError> {
    let most = frame.pixels.iter().copied().fold(0.0, f32::max);
    let scale = if most > 0.0 { f64::from(most) } else { 1.0 };
    let refuse = |error: Failure| EncodeError { format: Format::Png, reason: error.to_string() };
    Ok((screen::png16(frame, scale).map_err(refuse)?, scale))
}

/// Whatever an encoder may say.
type Failure = Box<dyn std::error::Error + Send + Sync>;
