//! Fog along view rays, as far as every medium adds its share on its own.

use crate::airlight::Method;
use crate::gpu::buffers::Noise;
use crate::gpu::compose::Pass;
use crate::gpu::device::Failure;
use crate::gpu::frame::{Recorder, Resolution, all, attachment, clearing, cover, texture};

impl Recorder<'_> {
    /// What stands in closed form; clears the fog's target.
    pub fn haze(&mut self) -> Result<(), Failure> {
        let is_lit = self.context.shows_airlight() && !self.context.scatters.is_empty();
        let defines: &[&str] = match self.context.method {
            Method::Sun2005 | Method::Fogshop2007 if is_lit => &["AIRLIGHT_SUN2005"],
            Method::Macklin2010 if is_lit => &["AIRLIGHT_MACKLIN2010"],
            _ => &[],
        };
        let rows = self.lists.rows.clone().filter(|_| !defines.is_empty());
        let shadows: &[&str] = if rows.is_some() { &["SHADOWS"] } else { &[] };
        let pipeline = self.pipeline(Pass::Haze, &[defines, shadows])?;
        let targets = &self.targets;
        let mut entries = vec![
            all(0, &self.view),
            texture(1, &targets.hits),
            all(2, &self.lists.lamps),
            all(3, &self.lists.scatters),
        ];
        entries.extend(self.lists.haze());
        entries.extend(rows.iter().flat_map(|rows| rows.entries()));
        let bind = pipeline.bind(&self.gpu.device, &entries);
        let (times, drawn) = (self.timer.render("haze"), (&*pipeline, &bind));
        cover(&mut self.encoder, times, &[attachment(&targets.fog, clearing(true))], drawn);
        Ok(())
    }

    /// The blobs.
    pub fn blobs(&mut self) -> Result<(), Failure> {
        if self.context.field.lumps() == 0 {
            return Ok(());
        }
        let defines: &[&str] = match self.context.method {
            _ if !self.context.shows_airlight() => &[],
            Method::Fogshop2007 => &["AIRLIGHT_FOGSHOP2007"],
            Method::Macklin2010 => &["AIRLIGHT_MACKLIN2010"],
            _ => &[],
        };
        self.blob_tiles(defines)
    }

    fn blob_tiles(&mut self, defines: &[&'static str]) -> Result<(), Failure> {
        if let Some(low) = &self.targets.low {
            self.encoder.clear_buffer(&low.handle, 0, None);
        }
        let rows = self.lists.rows.clone().filter(|_| !defines.is_empty());
        let shadows: &[&str] = if rows.is_some() { &["SHADOWS"] } else { &[] };
        for resolution in self.resolutions() {
            let defines = [defines, shadows, resolution.defines()];
            let pipeline = self.pipeline(Pass::BlobTiles, &defines)?;
            for blobs in self.spans() {
                let span = self.span(blobs, [0; 2])?;
                let (lists, targets) = (self.lists, &self.targets);
                let (view, grid) = self.view_of(resolution);
                let is_low = resolution == Resolution::Low;
                let fogged = if is_low { &targets.low } else { &targets.computed };
                let Some(fogged) = fogged else { continue };
                let entries = [
                    all(0, view),
                    texture(1, &targets.hits),
                    all(2, &lists.blobs),
                    all(3, fogged),
                    all(4, &span),
                    all(5, &lists.lamps),
                    all(6, lists.lit()),
                    texture(7, &targets.surfaces),
                    all(8, &lists.scatters),
                ];
                let rows = rows.iter().flat_map(|rows| rows.entries());
                let entries: Vec<_> = entries.into_iter().chain(rows).collect();
                let bind = pipeline.bind(&self.gpu.device, &entries);
                self.dispatch("blobs", &pipeline, &bind, grid);
                self.kept.push(span);
            }
        }
        Ok(())
    }

    /// Bends view rays before blobs, where there is noise.
    pub fn bend(&mut self) -> Result<(), Failure> {
        let Some(fogged) = &self.targets.computed else { return Ok(()) };
        let Some(Noise { bend, gradients }) = &self.lists.noise else { return Ok(()) };
        let pipeline = self.pipeline(Pass::Bend, &[])?;
        let entries = [
            all(0, &self.view),
            texture(1, &self.targets.hits),
            all(2, &self.lists.blobs),
            all(3, fogged),
            texture(4, &self.targets.fog),
            all(5, bend),
            all(6, gradients),
        ];
        let bind = pipeline.bind(&self.gpu.device, &entries);
        self.dispatch("noise", &pipeline, &bind, self.context.grid);
        Ok(())
    }
}
