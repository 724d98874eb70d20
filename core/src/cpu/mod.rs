//! The passes on the CPU: pixels in SIMD lanes, tiles spread over all cores.

pub mod batch;
pub mod blobs;
pub(crate) mod cache;
mod centers;
mod composite;
mod cone;
pub(crate) mod edges;
mod fog;
pub(crate) mod frame;
pub mod kernels;
pub(crate) mod mapped;
mod shade;
mod trace;
mod triangle;
mod upsample;
pub(crate) mod viewpoint;

use crate::probe::{Prober, RayAnswer};
use crate::renderer::{Frame, Interrupted, Progress};
use crate::request::{ProbeRay, View};
use crate::scene::CheckedScene;
use cache::Cache;
use rayon::prelude::*;

/// The CPU backend.
#[derive(Debug, Default)]
pub struct Cpu {
    pub(crate) cache: Cache,
}

impl Cpu {
    /// See [`crate::Renderer::render`].
    pub fn render(
        &self,
        scene: &CheckedScene,
        view: &View,
        progress: &Progress,
    ) -> Result<Frame, Interrupted> {
        frame::render(&self.cache, scene, view, progress)
    }

    /// See [`crate::Renderer::probe`].
    pub fn probe(
        &self,
        scene: &CheckedScene,
        rays: &[ProbeRay],
        progress: &Progress,
    ) -> Result<Vec<RayAnswer>, Interrupted> {
        const RAYS_A_JOB: usize = 64;
        let (geometry, field) = (self.cache.geometry(scene), self.cache.field(scene));
        progress.start(rays.len(), 1.0);
        let jobs = rays.par_chunks(RAYS_A_JOB).map(|rays| {
            let mut prober = Prober::new(scene, &geometry, &field);
            let answer = |ray| {
                if progress.is_over() {
                    return Err(Interrupted);
                }
                let answer = prober.answer(ray);
                progress.advance();
                Ok(answer)
            };
            rays.iter().map(answer).collect::<Result<Vec<_>, _>>()
        });
        Ok(jobs.collect::<Result<Vec<_>, _>>()?.concat())
    }
}
