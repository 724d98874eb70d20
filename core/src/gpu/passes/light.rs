//! What lies between lights and surfaces, and the light that surfaces send on.

use crate::frame::viewpoint::Grid;
use crate::gpu::compose::Pass;
use crate::gpu::device::{Buffer, Failure};
use crate::gpu::frame::{Recorder, Resolution, all, attachment, clearing, cover, texture};
use std::ops::Range;
use wgpu::BufferUsages;

/// Bytes of the depths from lights to pixels that stand at a time.
const DEPTH_BYTES: u64 = 128 << 20;

/// Depths from a few lamps to surfaces, lamps outside.
struct Depths {
    resolution: Resolution,
    values: Buffer,
}

impl Recorder<'_> {
    /// Light from the surfaces: of skies, and of lamps.
    pub fn surface_radiance(&mut self) -> Result<(), Failure> {
        self.lamps()?;
        self.skies()
    }

    /// A few lamps at a time.
    fn lamps(&mut self) -> Result<(), Failure> {
        self.mark_lit()?;
        let lamps = self.context.direct().len() as u32;
        let is_clear = self.context.is_clear;
        if is_clear || self.context.field.lumps() == 0 || lamps == 0 || self.has_tables() {
            return self.reflect(&[], 0..lamps);
        }
        let pixels = (self.context.grid.width * self.context.grid.height) as u64;
        let most = ((DEPTH_BYTES / (4 * pixels)).max(1) as u32).min(lamps);
        let depths = |resolution| {
            let Grid { width, height } = self.view_of(resolution).1;
            let bytes = 4 * (width * height) as u64 * u64::from(most);
            let values = self.gpu.device.buffer(bytes, BufferUsages::STORAGE)?;
            Ok(Depths { resolution, values })
        };
        let depths =
            self.resolutions().into_iter().map(depths).collect::<Result<Vec<_>, Failure>>()?;
        for first in (0..lamps).step_by(most as usize) {
            let end = (first + most).min(lamps);
            for (depths, lamp) in depths.iter().flat_map(|d| (first..end).map(move |l| (d, l))) {
                self.light_depth(depths, lamp, lamp - first)?;
            }
            self.reflect(&depths, first..end)?;
        }
        self.kept.extend(depths.into_iter().map(|depths| depths.values));
        Ok(())
    }

    /// Which lamps the surfaces see, where anything hides one.
    fn mark_lit(&mut self) -> Result<(), Failure> {
        let Some((casters, counts)) = &self.lists.casters else { return Ok(()) };
        let Some(marks) = &self.targets.marks else { return Ok(()) };
        let pipeline = self.pipeline(Pass::Lit, &[])?;
        let entries = [
            all(0, &self.view),
            texture(1, &self.targets.hits),
            texture(2, &self.targets.surfaces),
            all(3, &self.lists.lamps),
            all(11, &casters.rows),
            all(12, counts),
        ];
        let bind = pipeline.bind(&self.gpu.device, &entries);
        let (times, drawn) = (self.timer.render("surface_radiance"), (&*pipeline, &bind));
        cover(&mut self.encoder, times, &[attachment(marks, clearing(true))], drawn);
        Ok(())
    }

    /// What lies between one lamp and the surfaces.
    fn light_depth(&mut self, depths: &Depths, lamp: u32, place: u32) -> Result<(), Failure> {
        let pipeline = self.pipeline(Pass::LightDepth, &[depths.resolution.defines()])?;
        for blobs in self.spans() {
            let span = self.span(blobs, [lamp, place])?;
            let (lists, targets) = (self.lists, &self.targets);
            let (view, grid) = self.view_of(depths.resolution);
            let entries = [
                all(0, view),
                texture(1, &targets.hits),
                all(2, &lists.blobs),
                all(3, &depths.values),
                all(4, &span),
                all(5, &lists.lamps),
                texture(6, &targets.surfaces),
            ];
            let entries: Vec<_> = entries.into_iter().chain(lists.haze()).collect();
            let bind = pipeline.bind(&self.gpu.device, &entries);
            self.dispatch("light_depth", &pipeline, &bind, grid);
            self.kept.push(span);
        }
        Ok(())
    }

    /// Whether all lamps have tables that the eye may be shown.
    fn has_tables(&self) -> bool {
        let lamps = self.context.direct();
        self.lists.on_grid.is_some() && lamps.iter().all(|lamp| lamp.table.is_some())
    }

    /// Those of skies, and what stands behind everything.
    fn skies(&mut self) -> Result<(), Failure> {
        let lists = self.lists;
        let Some((tables, backdrops)) = &lists.skies else { return Ok(()) };
        let pipeline = self.pipeline(Pass::Skies, &[])?;
        let targets = &self.targets;
        let lists = [
            all(0, &self.view),
            texture(1, &targets.hits),
            texture(2, &targets.surfaces),
            all(4, &lists.materials),
        ];
        let skies = tables.entries().into_iter().chain(backdrops.entries());
        let entries: Vec<_> = lists.into_iter().chain(skies).collect();
        let bind = pipeline.bind(&self.gpu.device, &entries);
        let (times, drawn) = (self.timer.render("surface_radiance"), (&*pipeline, &bind));
        cover(&mut self.encoder, times, &[attachment(&targets.radiance, clearing(false))], drawn);
        Ok(())
    }

    fn reflect(&mut self, depths: &[Depths], lamps: Range<u32>) -> Result<(), Failure> {
        let defines: &[&str] = match depths.len() {
            0 if self.context.is_clear => &["CLEAR"],
            0 if self.has_tables() => &["TABLES"],
            0 => &[],
            1 => &["BLOBS"],
            _ => &["BLOBS", "LOW"],
        };
        let shadows: &[&str] = if self.lists.casters.is_some() { &["SHADOWS"] } else { &[] };
        let pipeline = self.pipeline(Pass::Surface, &[defines, shadows])?;
        let span = self.span(lamps.clone(), [0; 2])?;
        let (lists, targets) = (self.lists, &self.targets);
        let mut entries = vec![
            all(0, &self.view),
            texture(1, &targets.hits),
            texture(2, &targets.surfaces),
            all(3, &lists.lamps),
            all(4, &lists.materials),
            all(5, &span),
        ];
        entries.extend(lists.haze());
        entries.extend(lists.on_grid.iter().flat_map(|own| own.tables.entries(8)));
        if let Some((casters, counts)) = &lists.casters {
            entries.extend([all(11, &casters.rows), all(12, counts)]);
            entries.extend(targets.marks.as_ref().map(|marks| texture(9, marks)));
        }
        entries.extend(depths.iter().map(|Depths { resolution, values }| {
            all(if *resolution == Resolution::Low { 7 } else { 6 }, values)
        }));
        let bind = pipeline.bind(&self.gpu.device, &entries);
        let (times, drawn) = (self.timer.render("surface_radiance"), (&*pipeline, &bind));
        cover(
            &mut self.encoder,
            times,
            &[attachment(&targets.radiance, clearing(lamps.start == 0))],
            drawn,
        );
        self.kept.push(span);
        Ok(())
    }
}
