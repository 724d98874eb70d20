//! OpenEXR: one part of scanlines, 32-bit floats, ZIP-compressed in blocks of 16 rows.
//!
//! Ours, not a crate's: equal pictures shall be equal bytes, so the blocks stand in the order of the
//! rows and the attributes in the order in which they are written. After "OpenEXR File Layout"
//! (openexr.com, version 2 of the format).

use super::about::{Attribute, Caption};
use super::{Failure, Raster};
use flate2::Compression;
use flate2::write::ZlibEncoder;
use rayon::prelude::*;
use std::io::Write;

const MAGIC: u32 = 20_000_630;
const VERSION: u32 = 2;
/// Rows that are compressed together, as the compression `ZIP` prescribes.
const BLOCK: usize = 16;
/// Blocks that are in memory uncompressed at a time.
const BATCH: usize = 32;
/// The fastest level: on noise of floats the others gain a few percent for several times the time.
const EFFORT: Compression = Compression::new(1);

/// A file of float32 channels.
pub fn exr(image: &Raster, caption: &Caption) -> Result<Vec<u8>, Failure> {
    // The format wants channels in the order of their names.
    let mut names: Vec<_> = caption.channels.iter().zip(0..image.channels).collect();
    names.sort();
    let (names, order): (Vec<_>, Vec<_>) = names.into_iter().unzip();
    let mut file = [MAGIC.to_le_bytes(), VERSION.to_le_bytes()].concat();
    for attribute in layout(image, &names).iter().chain(&caption.attributes) {
        attribute.write(&mut file);
    }
    file.push(0);
    let table = file.len();
    let row = image.width * image.channels;
    let blocks: Vec<&[f32]> = image.pixels.chunks(BLOCK * row).collect();
    file.resize(table + 8 * blocks.len(), 0);
    for (batch, some) in blocks.chunks(BATCH).enumerate() {
        let packed = some.par_iter().map(|pixels| pack(&planes(pixels, row, &order)));
        let packed: Result<Vec<_>, _> = packed.collect();
        for (i, bytes) in packed?.iter().enumerate() {
            let block = batch * BATCH + i;
            let offset = file.len() as u64;
            file[table + 8 * block..][..8].copy_from_slice(&offset.to_le_bytes());
            file.extend(((block * BLOCK) as i32).to_le_bytes());
            file.extend((bytes.len() as i32).to_le_bytes());
            file.extend(bytes);
        }
    }
    Ok(file)
}

/// What a reader needs to find the pixels.
fn layout(image: &Raster, names: &[&String]) -> Vec<Attribute> {
    const FLOAT: i32 = 2;
    let mut channels = Vec::new();
    for name in names {
        channels.extend(name.as_bytes());
        channels.push(0);
        // Its type, whether it is perceptually linear (no matter for floats), one sample a pixel.
        channels.extend([FLOAT, 0, 1, 1].iter().flat_map(|v: &i32| v.to_le_bytes()));
    }
    channels.push(0);
    let window = [0, 0, image.width as i32 - 1, image.height as i32 - 1];
    vec![
        Attribute("channels", "chlist", channels),
        Attribute("compression", "compression", vec![3]),
        Attribute::words("dataWindow", "box2i", window),
        Attribute::words("displayWindow", "box2i", window),
        Attribute("lineOrder", "lineOrder", vec![0]),
        Attribute::floats("pixelAspectRatio", "float", &[1.0]),
        Attribute::floats("screenWindowCenter", "v2f", &[0.0, 0.0]),
    ]
}

/// Row by row, each channel by itself.
fn planes(pixels: &[f32], row: usize, order: &[usize]) -> Vec<f32> {
    let mut planes = Vec::with_capacity(pixels.len());
    for row in pixels.chunks(row.max(1)) {
        for k in order {
            planes.extend(row.iter().skip(*k).step_by(order.len()));
        }
    }
    planes
}

/// A block's bytes in the file: compressed, or as they are where that saves less than a tenth. The
/// low bits of computed floats are mostly noise, on which compression takes long for nothing; so it
/// is tried on a part: the middle, where the bytes of even places meet those of odd ones.
fn pack(planes: &[f32]) -> std::io::Result<Vec<u8>> {
    let bytes = predicted(planes);
    let part = &bytes[bytes.len() * 7 / 16..bytes.len() * 9 / 16];
    let is_worth = |packed: &[u8], bytes: &[u8]| packed.len() * 10 < bytes.len() * 9;
    if is_worth(&zip(part)?, part) {
        let packed = zip(&bytes)?;
        if is_worth(&packed, &bytes) {
            return Ok(packed);
        }
    }
    Ok(planes.iter().flat_map(|v| v.to_le_bytes()).collect())
}

fn zip(bytes: &[u8]) -> std::io::Result<Vec<u8>> {
    let mut zip = ZlibEncoder::new(Vec::with_capacity(bytes.len() / 2), EFFORT);
    zip.write_all(bytes)?;
    zip.finish()
}

/// Bytes of even places, then those of odd ones, each as its difference from the one before; 128 is
/// none.
fn predicted(planes: &[f32]) -> Vec<u8> {
    let mut bytes = vec![0; 4 * planes.len()];
    let (even, odd) = bytes.split_at_mut(2 * planes.len());
    for ((even, odd), value) in even.chunks_exact_mut(2).zip(odd.chunks_exact_mut(2)).zip(planes) {
        let [a, b, c, d] = value.to_le_bytes();
        even.copy_from_slice(&[a, c]);
        odd.copy_from_slice(&[b, d]);
    }
    // So that the first one is itself.
    let mut last = 128u8;
    for byte in &mut bytes {
        let own = *byte;
        *byte = own.wrapping_sub(last).wrapping_add(128);
        last = own;
    }
    bytes
}
