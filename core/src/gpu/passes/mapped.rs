//! Airlight by the mapped rule, lamp by lamp, in patches of the picture that get smaller: the device
//! itself lists those of the next size, and dispatches by that list.

use crate::gpu::buffers::Table;
use crate::gpu::compose::Pass;
use crate::gpu::device::{Buffer, Failure};
use crate::gpu::frame::{Recorder, TILE, all, texture, tiles};
use crate::gpu::pipelines::Kind;
use wgpu::BufferUsages;

/// Pixels along the sides of patches.
const SIDES: [u32; 5] = [TILE, 8, 4, 2, 1];
/// Workgroups of a row of a dispatch.
const ACROSS: u32 = 1 << 15;
/// A list of patches, and of workgroups that take them.
const LIST: BufferUsages = BufferUsages::STORAGE.union(BufferUsages::INDIRECT);

/// What waits for patches of one size.
struct Waiting<'a> {
    side: u32,
    /// A bit a pixel, tile by tile.
    left: &'a Buffer,
    /// Patches of that size, and of the next.
    lists: [&'a Buffer; 2],
}

impl Recorder<'_> {
    /// Airlight by the mapped rule.
    pub fn mapped(&mut self) -> Result<(), Failure> {
        let (columns, rows) = tiles(self.context.grid);
        let device = &self.gpu.device;
        let all_left = vec![u8::MAX; 32 * (columns * rows) as usize];
        let whole = all_patches(columns, rows);
        for lamp in 0..self.context.lamps.len() as u32 {
            let table = &self.context.lamps[lamp as usize].table;
            let table = self.gpu.tables.get(table, || Table::of(device, table))?;
            let left = device.filled(&all_left, BufferUsages::STORAGE)?;
            let mut now = device.filled(&whole, LIST)?;
            for side in SIDES {
                let next = device.buffer(bytes(columns * rows * quarters(side)), LIST)?;
                let waiting = Waiting { side, left: &left, lists: [&now, &next] };
                self.patches(lamp, Option::as_ref(&table), &waiting)?;
                self.kept.push(std::mem::replace(&mut now, next));
            }
            self.kept.extend([now, left]);
        }
        Ok(())
    }

    fn patches(
        &mut self,
        lamp: u32,
        table: Option<&Table>,
        waiting: &Waiting,
    ) -> Result<(), Failure> {
        let Some(fogged) = &self.targets.computed else { return Ok(()) };
        let defines: &[&str] = if table.is_some() { &["LIGHT_TABLE"] } else { &[] };
        let pipeline = self.pipeline(Pass::Mapped, &[defines])?;
        let span = self.span([lamp, lamp + 1, waiting.side, 0])?;
        let lists = self.lists;
        let [now, next] = waiting.lists;
        let mut entries = vec![
            all(0, &self.view),
            texture(1, &self.targets.hits),
            all(2, &lists.blobs),
            all(3, fogged),
            all(4, &span),
            all(5, &lists.lamps),
            all(6, &lists.rules),
            all(7, waiting.left),
            all(8, &lists.tolerance),
            all(11, now),
            all(12, next),
        ];
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
        self.kept.push(span);
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

/// Bytes of a list of so many patches: a multiple of its first row.
fn bytes(patches: u32) -> u64 {
    16 + (4 * u64::from(patches)).next_multiple_of(16)
}

/// Patches of half the side, in a tile.
fn quarters(side: u32) -> u32 {
    4 * (TILE / side) * (TILE / side)
}
