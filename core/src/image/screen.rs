//! Lossless 8-bit files, and the 16-bit PNG of optical depths.

use super::{Failure, Raster};
use image::ExtendedColorType;
use image::codecs::webp::WebPEncoder;

/// RGB, compressed for speed, and marked as sRGB: by the chunk of that name, and for readers that
/// don't know it by the gamma and primaries that stand for it (PNG, third edition, 11.3.2.5).
pub fn png(rgb: &[u8], image: &Raster) -> Result<Vec<u8>, Failure> {
    let number = png::ScaledFloat::from_scaled;
    let point = |x, y| (number(x), number(y));
    write_png(image, rgb, |info| {
        info.set_color(png::ColorType::Rgb);
        info.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        info.set_source_gamma(number(45_455));
        info.set_source_chromaticities(png::SourceChromaticities {
            white: point(31_270, 32_900),
            red: point(64_000, 33_000),
            green: point(30_000, 60_000),
            blue: point(15_000, 6_000),
        });
    })
}

/// Grey, or a number a channel; `scale` becomes white. Without a colour space, for these are no colours: nobody shall
/// convert them.
pub fn png16(image: &Raster, scale: f64) -> Result<Vec<u8>, Failure> {
    let level = |value: &f32| (f64::from(*value) / scale * 65535.0).round() as u16;
    let bytes: Vec<u8> = image.pixels.iter().flat_map(|v| level(v).to_be_bytes()).collect();
    write_png(image, &bytes, |info| {
        let is_coloured = image.channels == 3;
        info.set_color(if is_coloured { png::ColorType::Rgb } else { png::ColorType::Grayscale });
        info.set_depth(png::BitDepth::Sixteen);
    })
}

fn write_png(
    image: &Raster,
    bytes: &[u8],
    describe: impl FnOnce(&mut png::Encoder<&mut Vec<u8>>),
) -> Result<Vec<u8>, Failure> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, image.width as u32, image.height as u32);
    describe(&mut encoder);
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(bytes)?;
    writer.finish()?;
    Ok(file)
}

/// RGB, lossless.
pub fn webp(rgb: &[u8], image: &Raster) -> Result<Vec<u8>, Failure> {
    let mut file = Vec::new();
    let (width, height) = (image.width as u32, image.height as u32);
    WebPEncoder::new_lossless(&mut file).encode(rgb, width, height, ExtendedColorType::Rgb8)?;
    Ok(file)
}
