//! A fogmap as a grey image: linear, white is 1, and the first row lies at the smallest z.

use image::{DynamicImage, ImageBuffer, ImageFormat, ImageReader, Limits, Luma};
use std::io::Cursor;

/// A pixel of this is 1.
const WHITE: f64 = 65535.0;

/// The coefficients that an image of 8 or 16 bits says, row by row; it has at most so many rows and columns.
///
/// # Errors
/// What is wrong with it.
pub fn read(bytes: &[u8], most: usize) -> Result<Vec<Vec<f64>>, String> {
    let mut reader = ImageReader::new(Cursor::new(bytes));
    reader.set_format(ImageFormat::Png);
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(most as u32), Some(most as u32));
    reader.limits(limits);
    let image = reader.decode().map_err(|error| error.to_string())?.into_luma16();
    let row = |row: &[u16]| row.iter().map(|grey| f64::from(*grey) / WHITE).collect();
    Ok(image.as_raw().chunks(image.width().max(1) as usize).map(row).collect())
}

/// An image of 16 bits of coefficients, which lie between 0 and 1 and in rows alike.
///
/// # Errors
/// Why it cannot be written.
pub fn write(coefficients: &[Vec<f64>]) -> Result<Vec<u8>, String> {
    let greys = coefficients.iter().flatten();
    let greys: Option<Vec<_>> =
        greys.map(|c| (0.0..=1.0).contains(c).then_some((c * WHITE).round() as u16)).collect();
    let greys = greys.ok_or("an image holds numbers from 0 to 1; scale holds the rest")?;
    let (rows, columns) = (coefficients.len(), coefficients.first().map_or(0, Vec::len));
    let image: Option<ImageBuffer<Luma<u16>, _>> =
        ImageBuffer::from_raw(columns as u32, rows as u32, greys);
    let image = image.ok_or("its rows differ in length")?;
    let mut file = Cursor::new(Vec::new());
    let written = DynamicImage::ImageLuma16(image).write_to(&mut file, ImageFormat::Png);
    written.map(|()| file.into_inner()).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is written is read again, to half a step of 16 bits.
    #[test]
    fn maps_come_back() {
        let map = vec![vec![0.0, 0.25, 1.0], vec![1.0 / 3.0, 1e-6, 0.99999]];
        let back = read(&write(&map).unwrap(), 4).unwrap();
        for (a, b) in map.iter().flatten().zip(back.iter().flatten()) {
            assert!((a - b).abs() <= 0.5 / WHITE + 1e-12, "{a} {b}");
        }
        assert!(read(&write(&map).unwrap(), 2).is_err(), "too large");
        assert!(write(&[vec![1.5]]).is_err() && write(&[vec![0.1], vec![]]).is_err());
        assert!(read(b"no image", 4).is_err());
    }
}
