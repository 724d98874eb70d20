//! 8-bit files, and the 16-bit PNG of optical depths.

use super::{Failure, Raster};
use image::ExtendedColorType;
use image::codecs::webp::WebPEncoder;

const JPEG_QUALITY: u8 = 90;

/// RGB, compressed for speed.
pub fn png(rgb: &[u8], image: &Raster) -> Result<Vec<u8>, Failure> {
    write_png(image, rgb, png::ColorType::Rgb, png::BitDepth::Eight)
}

/// Grey; `scale` becomes white.
pub fn png16(image: &Raster, scale: f64) -> Result<Vec<u8>, Failure> {
    let level = |value: &f32| (f64::from(*value) / scale * 65535.0).round() as u16;
    let bytes: Vec<u8> = image.pixels.iter().flat_map(|v| level(v).to_be_bytes()).collect();
    write_png(image, &bytes, png::ColorType::Grayscale, png::BitDepth::Sixteen)
}

fn write_png(
    image: &Raster,
    bytes: &[u8],
    color: png::ColorType,
    depth: png::BitDepth,
) -> Result<Vec<u8>, Failure> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, image.width as u32, image.height as u32);
    encoder.set_color(color);
    encoder.set_depth(depth);
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(bytes)?;
    writer.finish()?;
    Ok(file)
}

/// RGB, quality 90.
pub fn jpeg(rgb: &[u8], image: &Raster) -> Result<Vec<u8>, Failure> {
    let mut file = Vec::new();
    let (width, height) = (u16::try_from(image.width)?, u16::try_from(image.height)?);
    jpeg_encoder::Encoder::new(&mut file, JPEG_QUALITY).encode(
        rgb,
        width,
        height,
        jpeg_encoder::ColorType::Rgb,
    )?;
    Ok(file)
}

/// RGB, lossless.
pub fn webp(rgb: &[u8], image: &Raster) -> Result<Vec<u8>, Failure> {
    let mut file = Vec::new();
    let (width, height) = (image.width as u32, image.height as u32);
    WebPEncoder::new_lossless(&mut file).encode(rgb, width, height, ExtendedColorType::Rgb8)?;
    Ok(file)
}
