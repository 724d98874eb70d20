//! Airlight by the mapped rule, lamp by lamp and group by group, in patches of the picture that get smaller: the device
//! itself lists those of the next size, and dispatches by that list.

use crate::frame::context::Scatter;
use crate::gpu::buffers::Table;
use crate::gpu::compose::Pass;
use crate::gpu::device::{Buffer, Failure};
use crate::gpu::frame::{Recorder, TILE, all, texture, tiles};
use crate::gpu::layout::{self, Task};
use crate::gpu::pipelines::Kind;
use crate::kept::Same;
use wgpu::{BufferUsages, CommandEncoder};

/// Pixels along the sides of patches.
const SIDES: [u32; 5] = [TILE, 8, 4, 2, 1];
/// Workgroups of a row of a dispatch.
const ACROSS: u32 = 1 << 15;
/// Bytes of a list's head: workgroups across, down and deep, and how many patches there are.
const HEAD: u64 = 16;
/// A list of patches, by which they are dispatched.
const LIST: BufferUsages =
    BufferUsages::STORAGE.union(BufferUsages::INDIRECT).union(BufferUsages::COPY_DST);

/// What waits for patches of which size.
struct Waiting {
    /// A bit a pixel, tile by tile: 1 where it has its airlight.
    settled: Buffer,
    /// Patches of every size, and behind the smallest none.
    lists: Vec<Buffer>,
}

impl Waiting {
    fn new(frame: &Recorder) -> Result<Self, Failure> {
        let (columns, rows) = tiles(frame.context.grid);
        let device = &frame.gpu.device;
        let bits = 32 * u64::from(columns * rows);
        let settled = device.buffer(bits, BufferUsages::STORAGE | BufferUsages::COPY_DST)?;
        let mut lists = vec![device.filled(&all_patches(columns, rows), LIST)?];
        for side in &SIDES[1..] {
            let patches = columns * rows * (TILE / side) * (TILE / side);
            lists.push(device.buffer(bytes(patches), LIST)?);
        }
        lists.push(device.buffer(bytes(1), LIST)?);
        Ok(Self { settled, lists })
    }

    /// All pixels wait in the largest patches.
    fn begin(&self, encoder: &mut CommandEncoder) {
        encoder.clear_buffer(&self.settled.handle, 0, None);
        for list in &self.lists[1..] {
            encoder.clear_buffer(&list.handle, 0, Some(HEAD));
        }
    }
}

impl Recorder<'_> {
    /// Airlight by the mapped rule.
    pub fn mapped(&mut self) -> Result<(), Failure> {
        let waiting = Waiting::new(self)?;
        for (scatter, of) in self.context.scatters.iter().enumerate() {
            let table = &self.context.lamps[of.lamp].table;
            let table = match table.as_ref() {
                Some(values) => {
                    let make = || Table::new(&self.gpu.device, values);
                    Some(self.gpu.tables.get(&Same::new(table), self.context.job.progress, make)?)
                }
                None => None,
            };
            waiting.begin(&mut self.encoder);
            for size in 0..SIDES.len() {
                self.patches(scatter, table.as_deref(), &waiting, size)?;
            }
            // Lamp by lamp, so that no wait is for all of them.
            self.submit()?;
        }
        self.kept.push(waiting.settled);
        self.kept.extend(waiting.lists);
        Ok(())
    }

    fn patches(
        &mut self,
        scatter: usize,
        table: Option<&Table>,
        waiting: &Waiting,
        size: usize,
    ) -> Result<(), Failure> {
        let Some(fogged) = &self.targets.computed else { return Ok(()) };
        let defines: &[&str] = if table.is_some() { &["LIGHT_TABLE"] } else { &[] };
        let pipeline = self.pipeline(Pass::Mapped, &[defines])?;
        let Scatter { group, phase, .. } = self.context.scatters[scatter];
        let (side, group, g) = (SIDES[size], group as u32, phase.g as f32);
        let task = layout::one(&Task { scatter: scatter as u32, side, group, g });
        let task = self.gpu.device.filled(&task, BufferUsages::UNIFORM)?;
        let lists = self.lists;
        let (now, next) = (&waiting.lists[size], &waiting.lists[size + 1]);
        let mut entries = vec![
            all(0, &self.view),
            texture(1, &self.targets.hits),
            all(2, &lists.blobs),
            all(3, fogged),
            all(4, &task),
            all(5, &lists.lamps),
            all(6, &lists.rules),
            all(7, &waiting.settled),
            all(8, &lists.tolerance),
            all(11, now),
            all(12, next),
            all(13, &lists.scatters),
        ];
        entries.extend(lists.haze());
        if let Some(table) = table {
            entries.extend([all(9, &table.extent), all(10, &table.means)]);
        }
        let bind = pipeline.bind(&self.gpu.device, &entries);
        let mut pass = self.encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: None,
            timestamp_writes: self.timer.compute("airlight"),
        });
        if let Kind::Compute(pipeline) = &pipeline.kind {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &bind, &[]);
            pass.dispatch_workgroups_indirect(&now.handle, 0);
        }
        drop(pass);
        self.kept.push(task);
        Ok(())
    }
}

/// All tiles of a picture, as a list of patches.
fn all_patches(columns: u32, rows: u32) -> Vec<u8> {
    let count = columns * rows;
    let head = [count.min(ACROSS), count.div_ceil(ACROSS), 1, count];
    let places = (0..rows).flat_map(|y| (0..columns).map(move |x| x | (y << 16)));
    let mut list: Vec<_> = head.into_iter().chain(places).flat_map(u32::to_le_bytes).collect();
    list.resize(bytes(count) as usize, 0);
    list
}

/// Bytes of a list of so many patches: a multiple of its head.
fn bytes(patches: u32) -> u64 {
    HEAD + (4 * u64::from(patches)).next_multiple_of(HEAD)
}
