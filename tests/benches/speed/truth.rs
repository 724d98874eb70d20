//! Exact airlight along some of a picture's rays, and how far others are from it.

use fogbank_core::airlight::march;
use fogbank_core::geometry::Ray;
use fogbank_core::media::{Field, Moment};
use fogbank_core::request::{Layer, ProbeRay, Quality, View};
use fogbank_core::scene::CheckedScene;
use fogbank_core::{Progress, Renderer};
use fogbank_tests::scenes::{Random, pixel_rays, probe, scene, view};
use fogbank_tests::trials::{DARK, luminance, luminance_at, quantiles, signed_errors};
use serde_json::Value;
use std::time::Instant;

/// Rays that errors are measured on.
const RAYS: usize = 64;

/// A scene with exact values.
pub struct Truth {
    scene: CheckedScene,
    size: [u32; 2],
    pixels: Vec<usize>,
    rays: Vec<ProbeRay>,
    /// Where they end [m].
    ends: Vec<f64>,
    exact: Vec<f64>,
}

/// Relative errors of the luminance in per cent: median and 95th percentile.
pub struct Errors([f64; 2]);

impl std::fmt::Display for Errors {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [median, p95] = self.0;
        write!(f, "{median:.2} / {p95:.1}")
    }
}

impl Truth {
    pub fn new(json: &Value, size: [u32; 2]) -> Self {
        let mut exact = json.clone();
        exact["fog"]["airlight"] = "reference".into();
        let exact = scene(&exact);
        let all = pixel_rays(&exact, size[0], size[1]);
        let mut random = Random(5);
        let pixels: Vec<_> = (0..RAYS).map(|_| random.bits() as usize % all.len()).collect();
        let rays: Vec<_> = pixels.iter().map(|at| all[*at]).collect();
        let answers = probe(&exact, &rays);
        let end = |hit: Option<f64>| hit.unwrap_or(exact.far_m);
        let ends = answers.iter().map(|ray| end(ray.hit.as_ref().map(|hit| hit.distance_m)));
        let ends = ends.collect();
        let exact = answers.iter().map(|ray| luminance(ray.airlight.0)).collect();
        Self { scene: scene(json), size, pixels, rays, ends, exact }
    }

    /// Of `auto` for the eye.
    pub fn of_pictures(&self, quality: Quality) -> Errors {
        let view = view(self.size[0], self.size[1], Layer::Airlight, quality);
        let view = View { for_screen: true, ..view };
        let frame = Renderer::default().render(&self.scene, &view, &Progress::default());
        let frame = frame.unwrap();
        self.errors(self.pixels.iter().map(|at| luminance_at(&frame, *at)))
    }

    /// Of marching in so many steps, where lamps are all that shines; and what it would take for the whole picture, in
    /// milliseconds.
    pub fn of_marching(&self, steps: u32) -> Option<(f64, Errors)> {
        if self.scene.skies().next().is_some() {
            return None;
        }
        let field = Field::new(&self.scene.fog.terms, 0, &Moment::default());
        let (phase, albedo) = (self.scene.fog.phase.function(), self.scene.fog.albedo.vector());
        let along = |(ray, end): (&ProbeRay, &f64)| {
            let lamps = self.scene.lamps().map(|(_, lamp)| {
                let ProbeRay { origin, direction, .. } = *ray;
                let ray = Ray { origin, direction };
                march::airlight(&field, phase, lamp.source, ray, *end, steps)
                    * lamp.strength
                    * albedo
            });
            luminance(lamps.sum::<glam::DVec3>().to_array())
        };
        let began = Instant::now();
        let values: Vec<_> = self.rays.iter().zip(&self.ends).map(along).collect();
        let took = began.elapsed().as_secs_f64() * 1e3;
        let [width, height] = self.size;
        let share = (RAYS * rayon::current_num_threads()) as f64 / f64::from(width * height);
        Some((took / share, self.errors(values.into_iter())))
    }

    fn errors(&self, values: impl Iterator<Item = f64>) -> Errors {
        let errors = signed_errors(values, &self.exact, DARK);
        let [median, p95, _] = quantiles(errors.into_iter().map(f64::abs).collect());
        Errors([100.0 * median, 100.0 * p95])
    }
}
