//! A sky as a picture: equirectangular, its middle column −Z, right of it +X, its top +Y.

use super::parts::{Fineness, Part};
use crate::json::limits::{COUNTS, INTENSITY};
use glam::DVec3;
use image::{ImageFormat, ImageReader, Limits};
use std::f64::consts::{PI, TAU};
use std::io::Cursor;
use std::sync::{Arc, Mutex, PoisonError};

/// Parts of a picture, each with its solid angle.
type Parts = Arc<Vec<(Part, f64)>>;

/// A picture of all directions.
#[derive(Debug)]
pub struct RadianceMap {
    width: usize,
    pixels: Vec<[f32; 3]>,
    /// Its sums over parts, by how fine they are.
    parts: Mutex<Vec<(Fineness, Parts)>>,
}

impl Default for RadianceMap {
    fn default() -> Self {
        Self { width: 1, pixels: vec![[0.0; 3]], parts: Mutex::default() }
    }
}

impl Clone for RadianceMap {
    fn clone(&self) -> Self {
        Self { width: self.width, pixels: self.pixels.clone(), parts: Mutex::default() }
    }
}

impl PartialEq for RadianceMap {
    fn eq(&self, other: &Self) -> bool {
        (self.width, &self.pixels) == (other.width, &other.pixels)
    }
}

impl RadianceMap {
    /// Reads an EXR or HDR file; negative radiance counts as none.
    ///
    /// # Errors
    /// What is wrong with it: no such format, more pixels than a sky may have (told by its head, before any memory
    /// is taken for them), or one that is no radiance.
    pub fn read(bytes: &[u8]) -> Result<Self, String> {
        let reader = || {
            let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format();
            reader.map_err(|error| error.to_string())
        };
        if !matches!(reader()?.format(), Some(ImageFormat::OpenExr | ImageFormat::Hdr)) {
            return Err("it is neither an EXR nor an HDR image".into());
        }
        let (width, height) = reader()?.into_dimensions().map_err(|error| error.to_string())?;
        let [width, height] = [width as usize, height as usize];
        let most = COUNTS.sky_pixels;
        if width == 0 || height == 0 {
            return Err("it has no pixels".into());
        }
        if width.saturating_mul(height) > most {
            return Err(format!("it has {width}×{height} pixels; a sky has at most {most}"));
        }
        let mut reader = reader()?;
        let mut limits = Limits::default();
        // Four floats a pixel, and as much again while it is decoded.
        limits.max_alloc = Some(most as u64 * 48);
        reader.limits(limits);
        let image = reader.decode().map_err(|error| error.to_string())?.into_rgb32f();
        let pixels: Vec<_> = image.as_raw().chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect();
        Self::new(width, pixels)
    }

    /// Of rows of pixels, the top one first.
    ///
    /// # Errors
    /// Which pixel is no radiance, or that there are none, or no whole rows.
    pub fn new(width: usize, mut pixels: Vec<[f32; 3]>) -> Result<Self, String> {
        if width == 0 || pixels.is_empty() || !pixels.len().is_multiple_of(width) {
            return Err(format!("{} pixels are no rows of {width}", pixels.len()));
        }
        for (i, value) in pixels.iter_mut().enumerate() {
            if value.iter().any(|v| !v.is_finite() || f64::from(*v) > INTENSITY.max) {
                let (x, y) = (i % width, i / width);
                return Err(format!(
                    "pixel ({x}, {y}) is {value:?}; radiance is at most {}",
                    INTENSITY.max
                ));
            }
            *value = value.map(|v| v.max(0.0));
        }
        Ok(Self { width, pixels, parts: Mutex::default() })
    }

    /// Pixels of a row, and all of them.
    pub(super) fn rows(&self) -> (usize, &[[f32; 3]]) {
        (self.width, &self.pixels)
    }

    fn height(&self) -> usize {
        self.pixels.len() / self.width
    }

    /// What it shows in a direction, straight between pixels.
    pub fn toward(&self, d: DVec3) -> DVec3 {
        let (width, height) = (self.width as f64, self.height() as f64);
        let x = (0.5 + d.x.atan2(-d.z) / TAU) * width - 0.5;
        let y = (d.y.clamp(-1.0, 1.0).acos() / PI * height - 0.5).clamp(0.0, height - 1.0);
        let (left, top) = (x.floor(), y.floor());
        let (right_share, low_share) = (x - left, y - top);
        let columns = [left, left + 1.0].map(|c| c.rem_euclid(width) as usize % self.width);
        let rows = [top as usize, (top as usize + 1).min(self.height() - 1)];
        let pixel = |row: usize, column: usize| -> DVec3 {
            DVec3::from(self.pixels[row * self.width + column].map(f64::from))
        };
        let [upper, lower] =
            rows.map(|row| pixel(row, columns[0]).lerp(pixel(row, columns[1]), right_share));
        upper.lerp(lower, low_share)
    }

    /// Its parts: squares of pixels, each with all of its light, from where most of that comes, and its solid angle.
    pub(super) fn parts(&self, fineness: Fineness) -> Parts {
        let mut known = self.parts.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, parts)) = known.iter().find(|(own, _)| *own == fineness) {
            return Arc::clone(parts);
        }
        let parts = Arc::new(self.summed_up(fineness));
        known.push((fineness, Arc::clone(&parts)));
        parts
    }

    fn summed_up(&self, fineness: Fineness) -> Vec<(Part, f64)> {
        // Squares, where a product of Gauss's would take fewer: a picture is not smooth.
        let (rows, columns) = (3 * fineness.elevations, 6 * fineness.elevations);
        let (rows, columns) = (rows.min(self.height()), columns.min(self.width));
        let mut sums = vec![(DVec3::ZERO, DVec3::ZERO, 0.0); rows * columns];
        let (width, height) = (self.width as f64, self.height() as f64);
        for (y, row) in self.pixels.chunks_exact(self.width).enumerate() {
            let [top, bottom] = [y, y + 1].map(|y| (PI * y as f64 / height).cos());
            let (cos, solid) = (0.5 * (top + bottom), (top - bottom) * TAU / width);
            let sin = (1.0 - cos * cos).sqrt();
            for (x, pixel) in row.iter().enumerate() {
                let azimuth = ((x as f64 + 0.5) / width - 0.5) * TAU;
                let toward = DVec3::new(sin * azimuth.sin(), cos, -sin * azimuth.cos());
                let light = DVec3::from(pixel.map(f64::from)) * solid;
                let (sum, middle, whole) =
                    &mut sums[y * rows / self.height() * columns + x * columns / self.width];
                *sum += light;
                *whole += solid;
                // Darkness has a direction, too.
                *middle += toward * (light.element_sum() + f64::MIN_POSITIVE);
            }
        }
        let part = |(weight, middle, solid): (DVec3, DVec3, f64)| {
            (Part { toward: middle.normalize_or(DVec3::Y), weight }, solid)
        };
        sums.into_iter().map(part).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture of one colour is a sky of one; its parts are the whole sphere, in its orientation.
    #[test]
    fn pictures_are_turned_as_the_format_says() {
        let even = RadianceMap::new(64, vec![[1.0, 2.0, 0.5]; 64 * 32]).unwrap();
        let sum: DVec3 = even.parts(Fineness::FAST).iter().map(|(part, _)| part.weight).sum();
        assert!(sum.distance(DVec3::new(1.0, 2.0, 0.5) * 4.0 * PI) < 1e-5, "{sum}");
        assert_eq!(even.toward(DVec3::X), DVec3::new(1.0, 2.0, 0.5));
        // A spot a little right of the middle and above it: mostly −Z, some +X and +Y.
        let mut pixels = vec![[0.0; 3]; 64 * 32];
        pixels[12 * 64 + 36] = [1.0; 3];
        let spot = RadianceMap::new(64, pixels).unwrap();
        let parts = spot.parts(Fineness::FAST);
        let lit: Vec<_> = parts.iter().filter(|(part, _)| part.weight.x > 0.0).collect();
        assert_eq!(lit.len(), 1);
        let d = lit[0].0.toward;
        assert!(d.z < -0.7 && 0.2 < d.x && d.x < 0.6 && 0.2 < d.y && d.y < 0.5, "{d}");
        assert!(spot.toward(d).x > 0.9);
    }

    #[test]
    fn what_is_no_radiance_is_refused() {
        let wrong = |value: f32| RadianceMap::new(2, vec![[0.0; 3], [0.0, value, 0.0]]);
        assert!(wrong(f32::INFINITY).unwrap_err().contains("pixel (1, 0)"));
        assert!(wrong(f32::NAN).is_err() && wrong(2e12).is_err());
        assert_eq!(wrong(-1.0).unwrap().toward(DVec3::X), DVec3::ZERO);
        assert!(RadianceMap::read(b"no image").unwrap_err().contains("neither"));
        let empty = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 0 +X 8\n";
        assert!(RadianceMap::read(empty).is_err() && RadianceMap::new(2, vec![]).is_err());
        // A head that declares more than any memory holds.
        let head = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 65535 +X 65535\n";
        assert!(RadianceMap::read(head).unwrap_err().contains("65535×65535"));
    }
}
