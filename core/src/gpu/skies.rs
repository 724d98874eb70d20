//! Skies, brought to the device: how bright they are, and the tables of what is left of them in the fog.

use super::device::{Buffer, Device, Failure};
use super::layout::{self, Backdrop, Table};
use crate::frame::context::Context;
use crate::frame::skies::Sky;
use crate::frame::sky_table::SkyTable;
use crate::kept::{Kept, Same};
use glam::{DVec3, UVec3, Vec4};
use std::sync::Arc;
use wgpu::{BindingResource, BufferUsages};

/// The numbers of tables that a device keeps.
pub type KeptNumbers = Kept<Vec<Same<Option<SkyTable>>>, Buffer>;

/// The tables of all skies on the device.
#[derive(Debug)]
pub struct SkyTables {
    /// What each covers, as the camera sees it.
    tables: Buffer,
    /// Their planes and what arrives at their places.
    numbers: Arc<Buffer>,
}

impl SkyTables {
    /// For the fog of a frame; one empty table where there is none.
    ///
    /// # Errors
    /// Where there is no memory for them, or the job ends.
    pub fn of_fog(device: &Device, kept: &KeptNumbers, context: &Context) -> Result<Self, Failure> {
        let own = || context.skies.iter().map(|sky| (sky, sky.table.as_ref().as_ref()));
        let key: Vec<_> = context.skies.iter().map(|sky| Same::new(&sky.table)).collect();
        let make = || device.joined(own().filter_map(|(_, table)| table).flat_map(numbers_of));
        let numbers = kept.get(&key, context.job.progress, make)?;
        Ok(Self { tables: tables(device, context, own())?, numbers })
    }

    /// For surfaces that light reaches as in clear air.
    ///
    /// # Errors
    /// Where there is no memory for them.
    pub fn clear(device: &Device, context: &Context) -> Result<Self, Failure> {
        let own = || context.skies.iter().map(|sky| (sky, sky.clear.as_ref()));
        let numbers = own().filter_map(|(_, table)| table).flat_map(numbers_of);
        let numbers = Arc::new(device.joined(numbers)?);
        Ok(Self { tables: tables(device, context, own())?, numbers })
    }

    /// What `fogbank::sky::table` reads, under its numbers.
    pub fn entries(&self) -> [(u32, BindingResource<'_>); 2] {
        [(10, &self.tables), (13, &*self.numbers)]
            .map(|(binding, buffer)| (binding, buffer.handle.as_entire_binding()))
    }
}

fn tables<'a>(
    device: &Device,
    context: &Context,
    skies: impl Iterator<Item = (&'a Sky<'a>, Option<&'a SkyTable>)>,
) -> Result<Buffer, Failure> {
    let mut begin = 0;
    let table = |(sky, table): (&Sky, Option<&SkyTable>)| {
        let (Some(table), Some(summing)) = (table, &sky.summing) else { return Table::default() };
        let own = begin as u32;
        begin += numbers_of(table).map(<[f32]>::len).sum::<usize>();
        let colour = |i: usize| sky.channels.get(i).map_or(DVec3::ZERO, |(_, colour)| *colour);
        Table {
            origin: (table.origin() - context.viewpoint.position).as_vec3(),
            begin: own,
            size: UVec3::from_array(table.knots().each_ref().map(|knots| knots.len() as u32)),
            order: summing.order() as u32,
            colours: std::array::from_fn(|i| colour(i).as_vec3().extend(0.0)),
            channels: summing.channels() as u32,
        }
    };
    device.filled(&layout::list(skies.map(table).collect()), BufferUsages::STORAGE)
}

/// All numbers of a table, list by list.
fn numbers_of(table: &SkyTable) -> impl Iterator<Item = &[f32]> + Clone {
    table.knots().iter().map(Vec::as_slice).chain([table.values()])
}

/// How bright skies are, on the device.
#[derive(Debug)]
pub struct Backdrops {
    list: Buffer,
    colours: Buffer,
}

impl Backdrops {
    /// Of a frame's skies.
    ///
    /// # Errors
    /// Where there is no memory for them.
    pub fn new(device: &Device, context: &Context) -> Result<Self, Failure> {
        let mut colours: Vec<Vec4> = Vec::new();
        let backdrop = |sky: &Sky| {
            let (kind, width, own) = sky.radiance.drawn();
            let begin = colours.len() as u32;
            colours.extend(own.iter().map(|colour| colour.extend(0.0)));
            Backdrop { kind, begin, count: own.len() as u32, width: width as u32 }
        };
        let list = layout::list(context.skies.iter().map(backdrop).collect());
        Ok(Self {
            list: device.filled(&list, BufferUsages::STORAGE)?,
            colours: device.filled(&layout::list(colours), BufferUsages::STORAGE)?,
        })
    }

    /// What `fogbank::sky::backdrop` reads, under its numbers.
    pub fn entries(&self) -> [(u32, BindingResource<'_>); 2] {
        [(3, &self.list), (5, &self.colours)]
            .map(|(binding, buffer)| (binding, buffer.handle.as_entire_binding()))
    }
}
