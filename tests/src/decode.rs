//! Reads what the server encodes, with other people's decoders.

use exr::prelude::{ReadChannels, ReadLayers};
use std::io::Cursor;

/// Numbers of a picture, row by row from the top, channels side by side.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Pixels along a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Numbers a pixel.
    pub channels: usize,
    /// The numbers.
    pub numbers: Vec<f64>,
}

impl Picture {
    /// The numbers of one pixel.
    pub fn pixel(&self, n: usize) -> &[f64] {
        &self.numbers[n * self.channels..][..self.channels]
    }
}

/// An 8-bit picture of a named format: three channels, no alpha.
pub fn screen(bytes: &[u8], format: image::ImageFormat) -> Picture {
    let image = image::load_from_memory_with_format(bytes, format).expect("a picture");
    assert_eq!(image.color(), image::ColorType::Rgb8, "{format:?}");
    let image = image.to_rgb8();
    Picture {
        width: image.width() as usize,
        height: image.height() as usize,
        channels: 3,
        numbers: image.as_raw().iter().map(|byte| f64::from(*byte)).collect(),
    }
}

/// A 16-bit greyscale PNG.
pub fn png16(bytes: &[u8]) -> Picture {
    let image = image::load_from_memory_with_format(bytes, image::ImageFormat::Png);
    let image::DynamicImage::ImageLuma16(image) = image.expect("a picture") else {
        panic!("not a 16-bit greyscale picture");
    };
    Picture {
        width: image.width() as usize,
        height: image.height() as usize,
        channels: 1,
        numbers: image.as_raw().iter().map(|sample| f64::from(*sample)).collect(),
    }
}

/// A little-endian float32 array `[height][width]` or `[height][width][channels]` in C order.
pub fn npy(bytes: &[u8]) -> Picture {
    let file = npyz::NpyFile::new(bytes).expect("an npy file");
    assert_eq!(file.order(), npyz::Order::C);
    assert_eq!(file.dtype().descr(), "'<f4'");
    let shape: Vec<usize> = file.shape().iter().map(|side| *side as usize).collect();
    let numbers = file.into_vec::<f32>().expect("float32").into_iter().map(f64::from).collect();
    let (height, width, channels) = match shape[..] {
        [height, width] => (height, width, 1),
        [height, width, channels] => (height, width, channels),
        _ => panic!("an array of shape {shape:?}"),
    };
    Picture { width, height, channels, numbers }
}

/// A one-part OpenEXR file of 32-bit floats: colours, vectors or single numbers, of any layer.
pub fn exr(bytes: &[u8]) -> Picture {
    let reader = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels();
    let image = reader.first_valid_layer().all_attributes();
    let image = image.from_buffered(Cursor::new(bytes)).expect("an exr file");
    let layer = image.layer_data;
    let (width, height) = (layer.size.x(), layer.size.y());
    let mut channels: Vec<_> = layer.channel_data.list.into_iter().collect();
    // The format sorts them by name, colours backwards.
    let place = |name: String| "RGBXYZ".find(name.chars().last().unwrap_or_default());
    channels.sort_by_key(|channel| place(channel.name.to_string()));
    let planes = channels.iter().map(|channel| match &channel.sample_data {
        exr::prelude::FlatSamples::F32(samples) => samples.clone(),
        _ => panic!("not 32-bit floats"),
    });
    let planes: Vec<Vec<f32>> = planes.collect();
    let pixels = (0..width * height).flat_map(|n| planes.iter().map(move |plane| plane[n]));
    let numbers = pixels.map(f64::from).collect();
    Picture { width, height, channels: planes.len(), numbers }
}
