//! Pictures on their way back: buffers that the device copies to and the program reads, used again
//! and again.

use super::device::{Buffer, Device, Failure, Texture};
use std::sync::{Mutex, PoisonError};

/// Idle buffers that are kept.
const KEPT: usize = 3;
/// Bytes of a pixel.
const PIXEL: u32 = 16;

/// The idle buffers of one device.
#[derive(Debug, Default)]
pub struct Staging(Mutex<Vec<Buffer>>);

/// A buffer in use.
#[derive(Debug)]
pub struct Stage<'a> {
    home: &'a Staging,
    buffer: Option<Buffer>,
    width: u32,
    height: u32,
}

/// Bytes of a row, as copies want them.
fn pitch(width: u32) -> u32 {
    (width * PIXEL).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT)
}

impl Staging {
    /// A buffer for a picture.
    ///
    /// # Errors
    /// Where there is no memory for it.
    pub fn take(&self, device: &Device, width: u32, height: u32) -> Result<Stage<'_>, Failure> {
        let size = u64::from(pitch(width)) * u64::from(height);
        let mut idle = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let found = idle.iter().position(|buffer| buffer.handle.size() == size);
        let buffer = match found {
            Some(at) => idle.swap_remove(at),
            None => {
                let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
                device.buffer(size, usage)?
            }
        };
        Ok(Stage { home: self, buffer: Some(buffer), width, height })
    }
}

impl Stage<'_> {
    /// Copies a picture here, once the commands run.
    pub fn copy(&self, encoder: &mut wgpu::CommandEncoder, picture: &Texture) {
        let Some(buffer) = &self.buffer else { return };
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(pitch(self.width)),
            rows_per_image: None,
        };
        encoder.copy_texture_to_buffer(
            picture.handle.as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: &buffer.handle, layout },
            picture.handle.size(),
        );
    }

    /// Runs the commands and reads the picture, `[height][width][4]`.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn read(
        mut self,
        device: &Device,
        commands: wgpu::CommandBuffer,
    ) -> Result<Vec<f32>, Failure> {
        let Some(buffer) = self.buffer.take() else { return Err(Failure::Lost) };
        let bytes = device.fetch(commands, &buffer.handle)?;
        let row = (self.width * PIXEL) as usize;
        let mut pixels = Vec::with_capacity(row / 4 * self.height as usize);
        for line in bytes.chunks(pitch(self.width) as usize) {
            let number = |word: &[u8]| word.try_into().map_or(0.0, f32::from_le_bytes);
            pixels.extend(line[..row].chunks_exact(4).map(number));
        }
        drop(bytes);
        buffer.handle.unmap();
        let mut idle = self.home.0.lock().unwrap_or_else(PoisonError::into_inner);
        idle.push(buffer);
        if idle.len() > KEPT {
            idle.remove(0);
        }
        Ok(pixels)
    }
}
