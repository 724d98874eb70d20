//! NumPy arrays, float32.

use super::{Failure, Raster};
use npyz::WriterBuilder;

/// `[height][width]` or `[height][width][3]`, little-endian.
pub fn npy(image: &Raster) -> Result<Vec<u8>, Failure> {
    let mut shape = vec![image.height as u64, image.width as u64];
    if image.channels == 3 {
        shape.push(3);
    }
    let mut file = Vec::with_capacity(image.pixels.len() * 4 + 128);
    let mut writer =
        npyz::WriteOptions::new().default_dtype().shape(&shape).writer(&mut file).begin_nd()?;
    writer.extend(image.pixels.iter())?;
    writer.finish()?;
    Ok(file)
}
