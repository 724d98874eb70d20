//! What a layer shows, and its way back: as numbers, or for a screen.

use crate::gpu::compose::{Pass, of_layer, of_tonemap};
use crate::gpu::device::{Failure, Texture};
use crate::gpu::frame::{Picture, Recorder, all, attachment, clearing, cover, texture};
use crate::gpu::pipelines::{LIGHT, SCREEN};
use crate::gpu::timer::Times;
use crate::request::Layer;

impl Recorder<'_> {
    /// Adds what the layer shows of one sample.
    pub fn composite(&mut self, is_first: bool) -> Result<(), Failure> {
        let targets = &self.targets;
        let fog = |has: bool, name: &'static [&'static str]| if has { name } else { &[] };
        let edges: &[&str] = match (&targets.edges, is_first) {
            (None, _) => &[],
            (Some(_), true) => &["MARK_EDGES"],
            (Some(_), false) => &["AT_EDGES"],
        };
        let defines = [
            of_layer(self.context.view.layer),
            fog(targets.computed.is_some(), &["FOG_BUFFER"]),
            fog(targets.low.is_some(), &["FOG_LOW"]),
            edges,
        ];
        let pipeline = self.pipeline(Pass::Composite, &defines)?;
        let mut entries = vec![
            all(0, &self.view),
            texture(1, &targets.hits),
            texture(2, &targets.radiance),
            texture(3, &targets.fog),
            texture(6, &targets.surfaces),
        ];
        entries.extend(targets.computed.as_ref().map(|buffer| all(4, buffer)));
        entries.extend(targets.low.as_ref().map(|buffer| all(5, buffer)));
        entries.extend(targets.edges.as_ref().map(|marks| texture(7, marks)));
        let bind = pipeline.bind(&self.gpu.device, &entries);
        let marks = targets.edges.as_ref().filter(|_| is_first);
        let mut attachments = vec![attachment(&targets.sums, clearing(is_first))];
        attachments.extend(marks.map(|marks| attachment(marks, clearing(true))));
        let (times, drawn) = (self.timer.render("composite"), (&*pipeline, &bind));
        cover(&mut self.encoder, times, &attachments, drawn);
        Ok(())
    }

    /// The picture, and what the passes took.
    pub fn show(mut self) -> Result<(Picture, Times), Failure> {
        let (gpu, is_for_screen) = (self.gpu, self.is_for_screen());
        let device = &gpu.device;
        let picture = self.tonemap()?;
        let copy = gpu.staging.copy(device, &mut self.encoder, &picture)?;
        self.timer.resolve(&mut self.encoder);
        let submission = device.submit(self.encoder.finish())?;
        let grid = self.context.grid;
        let count = grid.width * grid.height;
        let shown = if is_for_screen {
            let mut bytes = Vec::with_capacity(3 * count);
            let push = |row: &[u8]| row.chunks_exact(4).for_each(|rgba| bytes.extend(&rgba[..3]));
            copy.rows(device, &submission, push)?;
            Picture::Screen(bytes)
        } else {
            let channels = self.context.view.layer.channels(1);
            let mut values = Vec::with_capacity(channels * count);
            let number = |word: &[u8]| word.try_into().map_or(0.0, f32::from_le_bytes);
            copy.rows(device, &submission, |row| {
                for texel in row.chunks_exact(16) {
                    values.extend(texel.chunks_exact(4).take(channels).map(number));
                }
            })?;
            Picture::Linear(values)
        };
        Ok((shown, self.timer.read(device, &submission)))
    }

    /// The mean of the samples, brought onto a screen if it is for one.
    fn tonemap(&mut self) -> Result<Texture, Failure> {
        let is_screen = self.is_for_screen();
        let view = &self.context.view;
        let defines = if is_screen { of_tonemap(view.tonemap) } else { &[] };
        let pipeline = self.pipeline(Pass::Tonemap, &[defines])?;
        let format = if is_screen { SCREEN } else { LIGHT };
        let picture = self.gpu.device.target(view.width, view.height, format)?;
        let entries = [all(0, &self.view), texture(1, &self.targets.sums)];
        let bind = pipeline.bind(&self.gpu.device, &entries);
        let (times, drawn) = (self.timer.render("tonemap"), (&*pipeline, &bind));
        cover(&mut self.encoder, times, &[attachment(&picture, clearing(true))], drawn);
        Ok(picture)
    }

    /// Whether radiance is wanted as a screen shows it; other layers' colour maps are not the device's.
    fn is_for_screen(&self) -> bool {
        let view = &self.context.view;
        let is_radiance = matches!(view.layer, Layer::Beauty | Layer::Airlight | Layer::Surface);
        // Bands of colour and octaves are put together before they are brought onto a screen.
        view.for_screen && is_radiance && self.is_whole
    }
}
