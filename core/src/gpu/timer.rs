//! What each pass took, from the device's own clock where it has one.

use super::device::{Buffer, Device, Failure};
use std::time::Duration;
use wgpu::{BufferUsages, QuerySet, SubmissionIndex};

/// Passes of one frame that can be timed.
const MOST: u32 = 2048;

/// What passes took, by name.
pub type Times = Vec<(&'static str, Duration)>;

/// Times of the passes of one frame.
#[derive(Debug)]
pub struct Timer {
    clock: Option<Clock>,
    names: Vec<&'static str>,
}

#[derive(Debug)]
struct Clock {
    queries: QuerySet,
    resolved: Buffer,
    staging: Buffer,
}

impl Timer {
    /// For one frame.
    ///
    /// # Errors
    /// Where there is no memory for it.
    pub fn new(device: &Device) -> Result<Self, Failure> {
        let mut timer = Self { clock: None, names: Vec::new() };
        if !device.handle.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            return Ok(timer);
        }
        let descriptor = wgpu::QuerySetDescriptor {
            label: None,
            ty: wgpu::QueryType::Timestamp,
            count: 2 * MOST,
        };
        let size = 16 * u64::from(MOST);
        timer.clock = Some(Clock {
            queries: device.handle.create_query_set(&descriptor),
            resolved: device.buffer(size, BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC)?,
            staging: device.buffer(size, BufferUsages::MAP_READ | BufferUsages::COPY_DST)?,
        });
        Ok(timer)
    }

    /// Times a pass that draws.
    pub fn render(&mut self, name: &'static str) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        let (query_set, begin) = self.next(name)?;
        Some(wgpu::RenderPassTimestampWrites {
            query_set,
            beginning_of_pass_write_index: Some(begin),
            end_of_pass_write_index: Some(begin + 1),
        })
    }

    /// Times a pass that computes.
    pub fn compute(&mut self, name: &'static str) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let (query_set, begin) = self.next(name)?;
        Some(wgpu::ComputePassTimestampWrites {
            query_set,
            beginning_of_pass_write_index: Some(begin),
            end_of_pass_write_index: Some(begin + 1),
        })
    }

    fn next(&mut self, name: &'static str) -> Option<(&QuerySet, u32)> {
        let begin = 2 * self.names.len() as u32;
        if begin >= 2 * MOST {
            return None;
        }
        let clock = self.clock.as_ref()?;
        self.names.push(name);
        Some((&clock.queries, begin))
    }

    /// Gathers the times behind the passes.
    pub fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        let Some(clock) = &self.clock else { return };
        let count = 2 * self.names.len() as u32;
        encoder.resolve_query_set(&clock.queries, 0..count, &clock.resolved.handle, 0);
        let (from, to) = (&clock.resolved.handle, &clock.staging.handle);
        encoder.copy_buffer_to_buffer(from, 0, to, 0, 8 * u64::from(count));
    }

    /// The times, passes of one name together; none where the device does not tell.
    pub fn read(&self, device: &Device, submission: &SubmissionIndex) -> Times {
        let Some(clock) = &self.clock else { return Vec::new() };
        let Ok(bytes) = device.read(submission, &clock.staging.handle) else {
            return Vec::new();
        };
        let stamp = |word: &[u8]| word.try_into().map_or(0, u64::from_le_bytes);
        let stamps: Vec<_> = bytes.chunks_exact(8).map(stamp).collect();
        let period = f64::from(device.queue.get_timestamp_period()) * 1e-9;
        let mut times = Times::new();
        for (name, pair) in self.names.iter().zip(stamps.chunks_exact(2)) {
            let seconds = pair[1].wrapping_sub(pair[0]) as f64 * period;
            let time = Duration::try_from_secs_f64(seconds).unwrap_or_default();
            match times.iter_mut().find(|(known, _)| known == name) {
                Some((_, sum)) => *sum += time,
                None => times.push((name, time)),
            }
        }
        times
    }
}
