//! Scene-linear files: EXR and NPY, float32.

use super::{Failure, Raster};
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, SmallVec,
    WritableImage,
};
use npyz::WriterBuilder;
use std::io::Cursor;

/// Channels R, G, B or Y, ZIP-compressed in blocks of 16 rows.
pub fn exr(image: &Raster) -> Result<Vec<u8>, Failure> {
    let names: &[&str] = if image.channels == 3 { &["R", "G", "B"] } else { &["Y"] };
    let channel = |(k, name): (usize, &&str)| {
        let samples = image.pixels.iter().skip(k).step_by(names.len()).copied();
        AnyChannel::new(*name, FlatSamples::F32(samples.collect()))
    };
    let channels: SmallVec<[_; 4]> = names.iter().enumerate().map(channel).collect();
    let layer = Layer::new(
        (image.width, image.height),
        LayerAttributes::default(),
        Encoding::FAST_LOSSLESS,
        AnyChannels::sort(channels),
    );
    let mut file = Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut file)?;
    Ok(file.into_inner())
}

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
