//! The passes on the CPU: pixels in SIMD lanes, tiles spread over all cores.

mod composite;
mod corners;
mod edges;
mod fog;
mod frame;
mod grid;
mod lit;
mod mapped;
mod noise;
mod passes;
mod places;
mod rims;
mod shade;
mod shadow;
mod sky;
mod tiles;
mod trace;
mod traced;
mod upsample;
mod views;

use crate::frame::Frame;
use crate::frame::cache::Cache;
use crate::light::Source;
use crate::probe::{Band, Prober, RayAnswer};
use crate::progress::{Interrupted, Progress};
use crate::request::{ProbeRay, View};
use crate::scene::CheckedScene;
use passes::Passes;
use rayon::prelude::*;

/// The CPU backend.
#[derive(Debug, Default)]
pub struct Cpu {
    pub(crate) cache: Cache,
    passes: Passes,
}

impl Cpu {
    /// See [`crate::Renderer::render`].
    pub fn render(
        &self,
        scene: &CheckedScene,
        view: &View,
        progress: &Progress,
    ) -> Result<Frame, Interrupted> {
        frame::render(&self.cache, &self.passes, scene, view, progress)
    }

    /// See [`crate::Renderer::probe`].
    pub fn probe(
        &self,
        scene: &CheckedScene,
        rays: &[ProbeRay],
        progress: &Progress,
    ) -> Result<Vec<RayAnswer>, Interrupted> {
        const RAYS_A_JOB: usize = 64;
        let geometry = self.cache.geometry(scene, progress)?;
        let octaves = scene.fog.octaves().into_iter().map(|octave| {
            let bands = self.cache.bands_of(scene, octave, progress)?;
            let bands = bands.each().iter().map(|field| {
                let from_light =
                    |source: Source| self.cache.exact_to_light(field, source, progress);
                Band::new(scene, octave, field, from_light)
            });
            bands.collect::<Result<Vec<_>, _>>()
        });
        let bands = octaves.collect::<Result<Vec<_>, Interrupted>>()?;
        progress.start(rays.len(), 1.0);
        let jobs = rays.par_chunks(RAYS_A_JOB).map(|rays| {
            let mut prober = Prober::new(scene, &geometry, &bands, progress);
            let answer = |ray| {
                if progress.is_over() {
                    return Err(Interrupted);
                }
                let answer = prober.answer(ray)?;
                progress.advance();
                Ok(answer)
            };
            rays.iter().map(answer).collect::<Result<Vec<_>, _>>()
        });
        Ok(jobs.collect::<Result<Vec<_>, _>>()?.concat())
    }
}
