//! Pictures on their way back: a ring of buffers that the device copies to and the program reads, so
//! that no frame waits until another one's copy is read.

use super::device::{Buffer, Device, Failure, Texture};
use std::sync::{Mutex, PoisonError};
use wgpu::{BufferUsages, SubmissionIndex};

/// Idle buffers that are kept.
const KEPT: usize = 3;

/// The idle buffers of one device.
#[derive(Debug, Default)]
pub struct Staging(Mutex<Vec<Buffer>>);

/// A picture's place in a buffer.
#[derive(Debug)]
pub struct Copy<'a> {
    home: &'a Staging,
    buffer: Buffer,
    /// Bytes of a row, and how far it is to the next one: what devices copy is aligned.
    row: usize,
    pitch: u32,
}

impl Staging {
    /// Records the copy of a picture.
    ///
    /// # Errors
    /// Where there is no memory for it.
    pub fn copy(
        &self,
        device: &Device,
        encoder: &mut wgpu::CommandEncoder,
        picture: &Texture,
    ) -> Result<Copy<'_>, Failure> {
        let size = picture.handle.size();
        let texel = picture.handle.format().block_copy_size(None).unwrap_or(16);
        let row = size.width * texel;
        let pitch = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = self.take(device, u64::from(pitch) * u64::from(size.height))?;
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(pitch),
            rows_per_image: None,
        };
        encoder.copy_texture_to_buffer(
            picture.handle.as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: &buffer.handle, layout },
            size,
        );
        Ok(Copy { home: self, buffer, row: row as usize, pitch })
    }

    /// Lets go of all that is idle.
    pub fn clear(&self) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clear();
    }

    fn take(&self, device: &Device, size: u64) -> Result<Buffer, Failure> {
        let mut idle = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match idle.iter().position(|buffer| buffer.handle.size() == size) {
            Some(at) => Ok(idle.swap_remove(at)),
            None => device.buffer(size, BufferUsages::MAP_READ | BufferUsages::COPY_DST),
        }
    }

    fn give_back(&self, buffer: Buffer) {
        let mut idle = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        idle.push(buffer);
        if idle.len() > KEPT {
            idle.remove(0);
        }
    }
}

impl Copy<'_> {
    /// Waits for the submission that copies, and shows each row.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn rows(
        self,
        device: &Device,
        submission: &SubmissionIndex,
        show: impl FnMut(&[u8]),
    ) -> Result<(), Failure> {
        let bytes = device.read(submission, &self.buffer.handle)?;
        bytes.chunks_exact(self.pitch as usize).map(|row| &row[..self.row]).for_each(show);
        drop(bytes);
        self.buffer.handle.unmap();
        self.home.give_back(self.buffer);
        Ok(())
    }
}
