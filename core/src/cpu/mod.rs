//! The passes on the CPU: pixels in SIMD lanes, tiles spread over all cores.

mod composite;
mod edges;
mod fog;
mod frame;
mod mapped;
mod passes;
mod shade;
mod tiles;
mod trace;
mod traced;
mod triangle;
mod upsample;

use crate::airlight::Method;
use crate::frame::Frame;
use crate::frame::cache::Cache;
use crate::probe::{Prober, RayAnswer, method};
use crate::progress::{Interrupted, Progress};
use crate::request::{ProbeRay, View};
use crate::scene::{CheckedScene, Point};
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
        let field = self.cache.field(scene, progress)?;
        let is_published = method(scene, &field) == Method::Fogshop2007;
        let lights = scene.lights().filter(|_| is_published);
        let from_light = |(_, light): (usize, &Point)| {
            self.cache.exact_to_light(&field, light.position.vector(), progress)
        };
        let from_lights = lights.map(from_light).collect::<Result<Vec<_>, _>>()?;
        progress.start(rays.len(), 1.0);
        let jobs = rays.par_chunks(RAYS_A_JOB).map(|rays| {
            let mut prober = Prober::new(scene, &geometry, &field, &from_lights, progress);
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
