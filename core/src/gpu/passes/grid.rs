//! Airlight on a grid of rays, in cells of the picture that get smaller: the device itself lists those of the next
//! size, and dispatches by that list.

use crate::frame::tolerance::Fineness;
use crate::gpu::buffers::OnGrid;
use crate::gpu::compose::Pass;
use crate::gpu::device::{Buffer, Failure};
use crate::gpu::frame::{Recorder, all, texture};
use crate::gpu::layout::{self, Task};
use crate::media::Legs;
use wgpu::{BufferUsages, CommandEncoder};

/// Pixels along the side of a block, which shares its knots.
const BLOCK: usize = 64;
/// Bytes of what a block knows (`Block` in `shaders/grid/block.wgsl`).
pub const BLOCK_BYTES: u64 = 16 + 4 * 56;
/// Pixels along the sides of the largest and the smallest cells. Quarters of the smallest have a ray a pixel: four
/// instead of nine.
const SIDES: [u32; 2] = [32, 4];
/// Workgroups of a row of a dispatch.
const ACROSS: u32 = 1 << 15;
/// Bytes of a list's head: workgroups across, down and deep, and how many cells there are.
const HEAD: u64 = 16;
/// A list of cells, by which they are dispatched.
const LIST: BufferUsages =
    BufferUsages::STORAGE.union(BufferUsages::INDIRECT).union(BufferUsages::COPY_DST);

/// What the cells of all sizes share.
struct Blocks {
    /// The knots of every block.
    knots: Buffer,
    /// The blobs near every block, a bit each.
    near: Buffer,
    fineness: Buffer,
    /// The name by which the pass knows that the fog has edges.
    defines: &'static [&'static str],
}

/// The cells of one size.
struct Size {
    side: u32,
    /// Whether each of their pixels has a ray of its own.
    is_alone: bool,
    list: Buffer,
}

impl Recorder<'_> {
    /// Airlight, and T of the blobs.
    pub fn grid(&mut self, is_first: bool) -> Result<(), Failure> {
        let Some(on_grid) = &self.lists.on_grid else { return Ok(()) };
        let sizes = self.sizes(&on_grid.fineness)?;
        begin(&sizes, &mut self.encoder);
        let blocks = self.blocks(on_grid)?;
        self.place_knots(&blocks)?;
        for pair in sizes.windows(2) {
            self.cells(&blocks, [&pair[0], &pair[1]], is_first)?;
            // Size by size, so that no wait is for all of them.
            self.submit()?;
        }
        self.kept.extend(sizes.into_iter().map(|size| size.list));
        self.kept.extend([blocks.knots, blocks.near, blocks.fineness]);
        Ok(())
    }

    /// Cells of every size, each waiting in a list; behind the last none.
    fn sizes(&self, fineness: &Fineness) -> Result<Vec<Size>, Failure> {
        let (device, grid) = (&self.gpu.device, self.context.grid);
        let most = fineness.side as u32;
        let mut side = SIDES[0].min(most).max(SIDES[1]);
        let tiles =
            |side: u32| [grid.width, grid.height].map(|pixels| (pixels as u32).div_ceil(side));
        let list = device.filled(&all_cells(tiles(side)), LIST)?;
        let mut sizes = vec![Size { side, is_alone: false, list }];
        let empty = |side, is_alone| -> Result<Size, Failure> {
            let [columns, rows] = tiles(side);
            Ok(Size { side, is_alone, list: device.buffer(bytes(columns * rows), LIST)? })
        };
        while side > SIDES[1] {
            side /= 2;
            sizes.push(empty(side, false)?);
        }
        sizes.push(empty(side / 2, true)?);
        sizes.push(Size { side, is_alone: true, list: device.buffer(bytes(1), LIST)? });
        Ok(sizes)
    }

    fn blocks(&self, OnGrid { fineness, .. }: &OnGrid) -> Result<Blocks, Failure> {
        let (device, context) = (&self.gpu.device, self.context);
        let [columns, rows] = self.blocks_across().map(u64::from);
        let words = (context.field.lumps() as u64).div_ceil(32).max(1);
        let groups = context.field.groups().len() as u32;
        let fineness = layout::Fineness {
            near: fineness.near,
            glow: fineness.glow,
            hidden: fineness.hidden,
            wide: fineness.wide,
            rough: fineness.rough,
            unseen: fineness.unseen,
            knots: fineness.knots as u32,
            groups,
        };
        let has_edges = context.field.smooth(context.viewpoint.position, Legs::OfEyes).has_edges();
        Ok(Blocks {
            knots: device.buffer(columns * rows * BLOCK_BYTES, BufferUsages::STORAGE)?,
            near: device.buffer(columns * rows * 4 * words, BufferUsages::STORAGE)?,
            fineness: device.filled(&layout::one(&fineness), BufferUsages::UNIFORM)?,
            defines: if has_edges { &["EDGES"] } else { &[] },
        })
    }

    fn blocks_across(&self) -> [u32; 2] {
        let grid = self.context.grid;
        [grid.width, grid.height].map(|pixels| pixels.div_ceil(BLOCK) as u32)
    }

    /// Where the rays of every block are tabulated.
    fn place_knots(&mut self, blocks: &Blocks) -> Result<(), Failure> {
        let pipeline = self.pipeline(Pass::Knots, &[])?;
        let mut entries = vec![
            all(0, &self.view),
            texture(1, &self.targets.hits),
            all(2, &self.lists.blobs),
            all(5, &self.lists.lamps),
            all(8, &blocks.fineness),
            all(14, &blocks.knots),
            all(15, &blocks.near),
        ];
        entries.extend(self.lists.haze());
        let bind = pipeline.bind(&self.gpu.device, &entries);
        let [columns, rows] = self.blocks_across();
        self.compute("airlight", &pipeline, &bind, |pass| {
            pass.dispatch_workgroups(columns, rows, 1);
        });
        Ok(())
    }

    /// The cells of one size; what they do not serve waits in the next.
    fn cells(
        &mut self,
        blocks: &Blocks,
        [now, next]: [&Size; 2],
        is_first: bool,
    ) -> Result<(), Failure> {
        let Some(fogged) = &self.targets.computed else { return Ok(()) };
        let pipeline = self.pipeline(Pass::Grid, &[blocks.defines])?;
        // Further samples count where the first one found edges.
        let edges = self.targets.edges.as_ref().filter(|_| !is_first);
        let task = Task {
            side: now.side,
            alone: u32::from(now.is_alone),
            at_edges: u32::from(edges.is_some()),
        };
        let task = layout::one(&task);
        let task = self.gpu.device.filled(&task, BufferUsages::UNIFORM)?;
        let mut entries = vec![
            all(0, &self.view),
            texture(1, &self.targets.hits),
            all(2, &self.lists.blobs),
            all(3, fogged),
            all(4, &task),
            all(5, &self.lists.lamps),
            all(6, &self.lists.scatters),
            all(8, &blocks.fineness),
            texture(9, edges.unwrap_or(&self.targets.surfaces)),
            all(11, &now.list),
            all(12, &next.list),
            all(14, &blocks.knots),
            all(15, &blocks.near),
        ];
        entries.extend(self.lists.haze());
        entries.extend(self.lists.on_grid.iter().flat_map(|own| {
            let lists = [all(17, &own.phases)].into_iter().chain(own.rows.entries());
            own.tables.entries(7).into_iter().chain(lists).chain(own.skies.entries())
        }));
        let bind = pipeline.bind(&self.gpu.device, &entries);
        self.compute("airlight", &pipeline, &bind, |pass| {
            pass.dispatch_workgroups_indirect(&now.list.handle, 0);
        });
        self.kept.push(task);
        Ok(())
    }
}

/// All pixels wait in the largest cells.
fn begin(sizes: &[Size], encoder: &mut CommandEncoder) {
    for size in &sizes[1..] {
        encoder.clear_buffer(&size.list.handle, 0, Some(HEAD));
    }
}

/// All squares of a picture, as a list of cells.
fn all_cells([columns, rows]: [u32; 2]) -> Vec<u8> {
    let count = columns * rows;
    let head = [count.min(ACROSS), count.div_ceil(ACROSS), 1, count];
    let places = (0..rows).flat_map(|y| (0..columns).map(move |x| x | (y << 16)));
    let mut list: Vec<_> = head.into_iter().chain(places).flat_map(u32::to_le_bytes).collect();
    list.resize(bytes(count) as usize, 0);
    list
}

/// Bytes of a list of so many cells: a multiple of its head.
fn bytes(cells: u32) -> u64 {
    HEAD + (4 * u64::from(cells)).next_multiple_of(HEAD)
}
