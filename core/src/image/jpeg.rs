//! JPEG, coded in strips on all cores. Each strip is a file of its own first; behind a restart marker its scan goes on
//! where that of the strip before ends, for there a decoder begins anew (ITU-T T.81, E.1.4).

use super::{Failure, Raster};
use jpeg_encoder::{ColorType, Encoder};
use rayon::prelude::*;

/// Of a picture at rest, and of one in motion, which is gone before anybody sees the difference.
const QUALITY: [u8; 2] = [90, 80];
/// Lines of a strip: whole blocks of either quality, and no more of them across than a restart counts.
const LINES: usize = 32;
/// Pixels along the side of a block, whose colour a draft halves.
const BLOCK: [usize; 2] = [8, 16];

const RESTART: u8 = 0xd0;
const FRAME: u8 = 0xc0;
const SCAN: u8 = 0xda;
const END: [u8; 2] = [0xff, 0xd9];

/// RGB; a draft is coded more coarsely.
pub fn jpeg(rgb: &[u8], image: &Raster, is_draft: bool) -> Result<Vec<u8>, Failure> {
    let height = u16::try_from(image.height)?;
    let strips = rgb.par_chunks(LINES * 3 * image.width).with_max_len(1);
    let strips = strips.map(|strip| strip_file(strip, image.width, is_draft));
    let strips: Vec<_> = strips.collect::<Result<_, Failure>>()?;
    let mut file = Vec::with_capacity(strips.iter().map(Vec::len).sum());
    for (i, strip) in strips.iter().enumerate() {
        let scan = scan_of(strip)?;
        if i == 0 {
            file.extend_from_slice(&strip[..scan]);
            set_height(&mut file, height)?;
        } else {
            file.extend([0xff, RESTART + ((i - 1) % 8) as u8]);
        }
        file.extend_from_slice(&strip[scan..strip.len() - END.len()]);
    }
    file.extend(END);
    Ok(file)
}

fn strip_file(rgb: &[u8], width: usize, is_draft: bool) -> Result<Vec<u8>, Failure> {
    let side = BLOCK[usize::from(is_draft)];
    let mut file = Vec::new();
    let mut encoder = Encoder::new(&mut file, QUALITY[usize::from(is_draft)]);
    encoder.set_restart_interval(u16::try_from(width.div_ceil(side) * (LINES / side))?);
    let lines = rgb.len() / (3 * width);
    encoder.encode(rgb, u16::try_from(width)?, u16::try_from(lines)?, ColorType::Rgb)?;
    Ok(file)
}

/// The segments before the scan: the code of each, and where it ends.
fn segments(file: &[u8]) -> impl Iterator<Item = (u8, usize)> {
    let mut at = 2;
    std::iter::from_fn(move || {
        let &[_, code, high, low] = file.get(at..at + 4)? else { return None };
        at += 2 + usize::from(u16::from_be_bytes([high, low]));
        Some((code, at))
    })
}

/// Where the coded blocks begin.
fn scan_of(file: &[u8]) -> Result<usize, Failure> {
    let scan = segments(file).find(|(code, _)| *code == SCAN);
    scan.map(|(_, end)| end).ok_or_else(|| "no scan".into())
}

/// Writes how many lines the picture has into its header.
fn set_height(file: &mut [u8], height: u16) -> Result<(), Failure> {
    /// From the lines to the end of the segment: two bytes, the columns, how many components, and three
    /// bytes for each of three.
    const FROM_END: usize = 14;
    let end = segments(file).find(|(code, _)| *code == FRAME).map(|(_, end)| end);
    let at = end.ok_or("no frame header")? - FROM_END;
    file[at..at + 2].copy_from_slice(&height.to_be_bytes());
    Ok(())
}
