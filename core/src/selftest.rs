//! What each backend makes of a few small scenes, against the same maths in f64, ray by ray; and of a
//! preset, against the CPU.

use crate::airlight::Method;
use crate::cpu::Cpu;
use crate::frame::Frame;
use crate::frame::samples::CENTER;
use crate::frame::viewpoint::Viewpoint;
use crate::gpu::Gpu;
use crate::media::KINDS;
use crate::presets;
use crate::probe::RayAnswer;
use crate::progress::{Interrupted, Progress};
use crate::request::{Layer, Options, ProbeRay, Quality, Tonemap, View};
use crate::scene::{CheckedScene, read};
use glam::DVec2;
use schemars::JsonSchema;
use serde::Serialize;
use std::cell::Cell;
use std::time::Instant;

const WIDTH: u32 = 48;
const HEIGHT: u32 = 36;
/// What stands for usual scenes.
const PRESETS: [&str; 1] = ["steaming-vessel"];
/// Next to black, a value counts as this share of the largest.
const FLOOR: f64 = 0.01;
/// Pixels that may see another surface than the exact ray does, where it grazes an edge.
const GRAZING: f64 = 0.005;

/// How far one backend is from the f64 maths.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct BackendReport {
    /// `cpu` or `gpu`.
    pub backend: &'static str,
    /// What it runs on.
    pub device: String,
    /// Its pictures, model by model.
    pub models: Vec<ModelReport>,
    /// Its pictures of presets against the CPU's.
    pub presets: Vec<PresetReport>,
}

/// How far a layer of a preset is from the CPU's.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct LayerReport {
    /// The layer.
    pub layer: Layer,
    /// As for models.
    pub largest_difference: f64,
}

/// What a preset takes, and how far its pictures are from the CPU's; its light is scattered as by
/// `fogshop2007`, for which every backend has passes.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct PresetReport {
    /// Its name.
    pub name: &'static str,
    /// Layer by layer.
    pub layers: Vec<LayerReport>,
    /// What the second picture of 800×600 pixels takes [ms].
    pub ms: f64,
}

/// How far pictures by one model are from the f64 maths.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct ModelReport {
    /// The medium, airlight or surface model.
    pub model: &'static str,
    /// The layer that shows it.
    pub layer: Layer,
    /// Largest difference, relative to the value or, next to black, to a hundredth of the picture's
    /// largest; without the half per cent of pixels that differ most, whose rays graze edges.
    pub largest_difference: f64,
    /// What the picture took [ms].
    pub ms: f64,
}

/// A model, the layer that shows it, and a fog that needs it.
struct Trial {
    model: &'static str,
    layer: Layer,
    lights: &'static str,
    fog: String,
}

impl Trial {
    fn new(model: &'static str, layer: Layer, airlight: &str, terms: &str) -> Self {
        let fog = format!(r#"{{"airlight": "{airlight}", "terms": {terms}}}"#);
        Self { model, layer, lights: LAMPS, fog }
    }
}

/// Optical depths in a fog that is still to be given.
fn depths(model: &'static str) -> Trial {
    Trial::new(model, Layer::OpticalDepth, "none", "[]")
}

/// Every medium by its optical depth, and by the light that it scatters; then the models of light.
fn trials() -> Vec<Trial> {
    let media = KINDS.iter().flat_map(|(kind, _, terms)| {
        [(Layer::OpticalDepth, "none"), (Layer::Airlight, "auto")]
            .map(|(layer, airlight)| Trial::new(kind, layer, airlight, terms))
    });
    let even = r#"[{"kind": "homogeneous", "extinction": 0.05}]"#;
    let light = [
        Trial::new("sun2005", Layer::Airlight, "sun2005", even),
        Trial::new("fogshop2007", Layer::Airlight, "fogshop2007", MIXED),
        Trial::new("auto", Layer::Airlight, "auto", MIXED),
        Trial::new("macklin2010", Layer::Airlight, "macklin2010", even),
        Trial::new("macklin2010", Layer::Airlight, "macklin2010", SLABS),
        Trial::new("slab", Layer::OpticalDepth, "none", SLABS),
        Trial {
            fog: format!(r#"{{"noise": {NOISE}, "airlight": "none", "terms": {MIXED}}}"#),
            ..depths("noise")
        },
        Trial::new("attenuated", Layer::Surface, "auto", MIXED),
        Trial { lights: SPOTS, ..Trial::new("spot", Layer::Airlight, "auto", MIXED) },
        Trial { lights: SPOTS, ..Trial::new("spot", Layer::Airlight, "sun2005", even) },
        Trial { lights: SPOTS, ..Trial::new("spot", Layer::Airlight, "fogshop2007", MIXED) },
        Trial { lights: SPOTS, ..Trial::new("spot", Layer::Airlight, "macklin2010", SLABS) },
        Trial { lights: SPOTS, ..Trial::new("spot", Layer::Surface, "auto", MIXED) },
        Trial { lights: SHADED, ..Trial::new("shadows", Layer::Airlight, "auto", MIXED) },
        Trial { lights: SHADED, ..Trial::new("shadows", Layer::Airlight, "sun2005", even) },
        Trial { lights: SHADED, ..Trial::new("shadows", Layer::Surface, "auto", MIXED) },
        Trial { lights: SUN, ..Trial::new("sun", Layer::Airlight, "auto", MIXED) },
        Trial { lights: SUN, ..Trial::new("sun", Layer::Surface, "auto", MIXED) },
        Trial { lights: SKY, ..Trial::new("sky", Layer::Airlight, "auto", MIXED) },
        Trial { lights: SKY, ..Trial::new("sky", Layer::Surface, "auto", MIXED) },
    ];
    media.chain(light).collect()
}

/// Blobs as view rays see slabs.
const SLABS: &str = r#"[{"kind": "homogeneous", "extinction": 0.02},
    {"kind": "gaussians", "draw": "slab", "blobs": [
        {"center": [-1, 0.6, 0], "radius": 1.2, "extinction": 0.5},
        {"center": [1.5, 1, -2], "radius": 0.7, "extinction": 0.9}]}]"#;
/// What bends rays before blobs.
const NOISE: &str = r#"{"strength": 0.7, "scale_m": 4}"#;

const MIXED: &str = r#"[{"kind": "homogeneous", "extinction": 0.02},
    {"kind": "gaussians", "blobs": [
        {"center": [-1, 0.6, 0], "radius": 1.2, "extinction": 0.5},
        {"center": [1.5, 1, -2], "radius": 0.7, "extinction": 0.9}]}]"#;

/// Lights of the stage.
const LAMPS: &str = r#"[
    {"kind": "point", "position": [-0.5, 2.2, 1], "intensity": [40, 34, 24], "shadows": false},
    {"kind": "point", "position": [3, 3, -2], "intensity": [10, 20, 30], "shadows": false}]"#;
/// The same with shadows.
const SHADED: &str = r#"[{"kind": "point", "position": [-0.5, 2.2, 1], "intensity": [40, 34, 24]},
    {"kind": "point", "position": [3, 3, -2], "intensity": [10, 20, 30]}]"#;
/// The stage before a soft cone and a hard one.
const SPOTS: &str = r#"[{"kind": "spot", "position": [2, 3, 1], "direction": [-0.6, -1, 0.2], "inner_angle_deg": 10,
    "outer_angle_deg": 35, "intensity": [30, 20, 10], "shadows": false},
    {"kind": "spot", "position": [-2, 1, -1], "direction": [1, 0.1, 0.3], "inner_angle_deg": 25, "outer_angle_deg": 25,
     "intensity": [5, 10, 20], "shadows": false}]"#;
/// The stage by daylight.
const SUN: &str = r#"[{"kind": "sun", "direction": [0.4, -1, -0.3], "irradiance": [3, 3, 2.8], "shadows": false}]"#;
/// The stage under a sky.
const SKY: &str = r#"[{"kind": "environment", "radiance": {"kind": "gradient"}}]"#;

/// Everything but its lights and its fog.
const STAGE: &str = r#""camera": {"position": [0, 1.7, 8], "target": [0, 1, 0]},
    "surfaces": [
        {"shape": {"kind": "plane"}},
        {"shape": {"kind": "sphere", "center": [1.2, 0.8, 0], "radius": 0.8},
         "material": {"diffuse": [0.7, 0.3, 0.2], "specular": [0.4, 0.4, 0.4], "shininess": 60}},
        {"shape": {"kind": "box", "min": [-3, 0, -3], "max": [-2, 2, -2]}},
        {"shape": {"kind": "mesh", "positions": [[-1, 0, 1], [0, 0, 2], [-1, 1, 2]],
                   "indices": [[0, 1, 2]]}}],
    "far_m": 60"#;

/// The stage in a fog.
#[cfg(test)]
pub(crate) fn scene(fog: &str) -> Option<CheckedScene> {
    lit(LAMPS, fog)
}

/// The same by daylight.
#[cfg(test)]
pub(crate) fn sunlit(fog: &str) -> Option<CheckedScene> {
    lit(SUN, fog)
}

/// The same under a sky alone.
#[cfg(test)]
pub(crate) fn under(sky: &str, fog: &str) -> Option<CheckedScene> {
    lit(&format!(r#"[{{"kind": "environment", "radiance": {sky}}}]"#), fog)
}

/// The stage in a fog, before some lights.
fn lit(lights: &str, fog: &str) -> Option<CheckedScene> {
    let text = format!(r#"{{{STAGE}, "lights": {lights}, "fog": {fog}}}"#);
    read::<crate::scene::Scene>(text.as_bytes()).ok()?.check().ok()
}

/// A small picture whose numbers are wanted.
pub(crate) fn view(layer: Layer) -> View {
    View {
        width: WIDTH,
        height: HEIGHT,
        quality: Quality::Full,
        layer,
        samples: Some(1),
        exposure_ev: 0.0,
        tonemap: Tonemap::Agx,
        for_screen: false,
        is_hasty: false,
        estimator: None,
        options: Options::default(),
    }
}

impl Trial {
    /// What a backend's picture differs by; `None` if the backend leaves the model to another one.
    fn run(
        &self,
        cpu: &Cpu,
        progress: &Progress,
        render: impl Fn(&CheckedScene, &View) -> Result<Option<Frame>, Interrupted>,
    ) -> Result<Option<ModelReport>, Interrupted> {
        let Some(scene) = lit(self.lights, &self.fog) else { return Ok(None) };
        let view = view(self.layer);
        // The first picture builds what is kept, pipelines among it.
        if render(&scene, &view)?.is_none() {
            return Ok(None);
        }
        let begun = Instant::now();
        let Some(frame) = render(&scene, &view)? else { return Ok(None) };
        let ms = begun.elapsed().as_secs_f64() * 1e3;
        let largest_difference =
            difference(&frame.pixels, &exact(cpu, &scene, self.layer, progress)?);
        Ok(Some(ModelReport { model: self.model, layer: self.layer, largest_difference, ms }))
    }
}

/// The largest difference of a picture, but for rays that graze edges.
fn difference(pixels: &[f32], exact: &[f64]) -> f64 {
    let largest = exact.iter().fold(0.0f64, |most, v| most.max(v.abs()));
    let difference = |(a, b): (&f32, &f64)| {
        (f64::from(*a) - b).abs() / b.abs().max(FLOOR * largest).max(f64::MIN_POSITIVE)
    };
    let mut all: Vec<_> = pixels.iter().zip(exact).map(difference).collect();
    all.sort_unstable_by(f64::total_cmp);
    let kept = (all.len() as f64 * (1.0 - GRAZING)) as usize;
    all.get(kept.saturating_sub(1)).copied().unwrap_or(0.0)
}

/// A preset as a backend renders it; `None` leaves a picture to the CPU.
fn preset(
    (name, scene): (&'static str, &CheckedScene),
    cpu: &Cpu,
    progress: &Progress,
    render: impl Fn(&CheckedScene, &View) -> Result<Option<Frame>, Interrupted>,
) -> Result<Option<PresetReport>, Interrupted> {
    let estimator = Some(Method::Fogshop2007);
    let view = |layer, width, height| View { width, height, estimator, ..view(layer) };
    let mut layers = Vec::new();
    for layer in Layer::ALL {
        let view = view(layer, 160, 120);
        let Some(own) = render(scene, &view)? else { continue };
        let cpus = cpu.render(scene, &view, progress)?.pixels;
        let cpus: Vec<_> = cpus.into_iter().map(f64::from).collect();
        let largest_difference = difference(&own.pixels, &cpus);
        layers.push(LayerReport { layer, largest_difference });
    }
    let large = view(Layer::Beauty, 800, 600);
    render(scene, &large)?;
    let begun = Instant::now();
    let shown = render(scene, &large)?;
    let ms = begun.elapsed().as_secs_f64() * 1e3;
    Ok(shown.map(|_| PresetReport { name, layers, ms }))
}

/// All presets that are tried.
fn all_presets(
    cpu: &Cpu,
    progress: &Progress,
    render: impl Fn(&CheckedScene, &View) -> Result<Option<Frame>, Interrupted> + Copy,
) -> Result<Vec<PresetReport>, Interrupted> {
    let tried = presets::all().into_iter().filter(|preset| PRESETS.contains(&preset.name));
    let checked = tried.filter_map(|preset| Some((preset.name, preset.scene.check().ok()?)));
    let reports =
        checked.map(|(name, scene)| preset((name, &scene), cpu, progress, render).transpose());
    reports.flatten().collect()
}

/// The layer's values in f64, along the pixels' rays.
fn exact(
    cpu: &Cpu,
    scene: &CheckedScene,
    layer: Layer,
    progress: &Progress,
) -> Result<Vec<f64>, Interrupted> {
    let viewpoint = Viewpoint::new(&scene.camera, WIDTH as usize, HEIGHT as usize);
    let pixels = (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y)));
    let rays: Vec<_> = pixels
        .map(|(x, y)| {
            let place = DVec2::new(f64::from(x), f64::from(y)) + CENTER;
            let (offset, direction) = viewpoint.ray(place);
            ProbeRay { origin: viewpoint.position + offset, direction, max_distance_m: None }
        })
        .collect();
    let answers = cpu.probe(scene, &rays, progress)?;
    let value = |(ray, answer): (&ProbeRay, &RayAnswer)| match (layer, &answer.hit) {
        (Layer::OpticalDepth, _) => answer.optical_depth.values().to_vec(),
        (Layer::Airlight, _) => answer.airlight.0.to_vec(),
        (_, Some(hit)) => hit.surface_radiance.0.to_vec(),
        (_, None) => scene.behind_all(ray.direction).to_array().to_vec(),
    };
    Ok(rays.iter().zip(&answers).flat_map(value).collect())
}

/// The CPU's report.
pub(crate) fn of_cpu(cpu: &Cpu, progress: &Progress) -> Result<BackendReport, Interrupted> {
    let render = |scene: &CheckedScene, view: &View| cpu.render(scene, view, progress).map(Some);
    let models = models(cpu, progress, render)?;
    // Its name alone: what stands in brackets is no one's business.
    let level = format!("{:?}", fearless_simd::Level::new());
    let device = level.split('(').next().unwrap_or_default().to_owned();
    let presets = all_presets(cpu, progress, render)?;
    Ok(BackendReport { backend: "cpu", device, models, presets })
}

/// A device's report.
pub(crate) fn of_gpu(
    gpu: &Gpu,
    cpu: &Cpu,
    progress: &Progress,
) -> Result<BackendReport, Interrupted> {
    // A device that fails has nothing to show, and is not asked again.
    let has_failed = Cell::new(false);
    let render = |scene: &CheckedScene, view: &View| {
        if has_failed.get() {
            return Ok(None);
        }
        match gpu.render(&cpu.cache, scene, view, progress) {
            Ok(frame) => Ok(frame),
            Err(_) if progress.is_over() => Err(Interrupted),
            Err(failure) => {
                tracing::warn!("{}: {failure}", gpu.name());
                has_failed.set(true);
                Ok(None)
            }
        }
    };
    let models = models(cpu, progress, render)?;
    let presets = all_presets(cpu, progress, render)?;
    let device = gpu.name().to_owned();
    Ok(BackendReport { backend: "gpu", device, models, presets })
}

fn models(
    cpu: &Cpu,
    progress: &Progress,
    render: impl Fn(&CheckedScene, &View) -> Result<Option<Frame>, Interrupted> + Copy,
) -> Result<Vec<ModelReport>, Interrupted> {
    let reports =
        trials().into_iter().filter_map(|trial| trial.run(cpu, progress, render).transpose());
    reports.collect()
}

#[cfg(test)]
mod tests {
    use super::{of_cpu, trials};
    use crate::cpu::Cpu;
    use crate::renderer::Progress;
    use crate::request::Layer;

    /// Every model is tried, and the CPU's lanes are f32: 1e-4 in T, 1e-3 in radiance; what changes faster than a
    /// grid's knots are apart is held to what pictures are.
    #[test]
    fn lanes_are_close_to_f64() {
        let report = of_cpu(&Cpu::default(), &Progress::default()).unwrap();
        assert_eq!(report.models.len(), trials().len());
        for model in report.models {
            let is_rippled = ["functions", "fogmap", "spot", "shadows"].contains(&model.model);
            // Three to six bands of a sky that has a kink at the horizon.
            let is_blurred = model.model == "sky";
            let is_coarse = is_blurred || is_rippled && model.layer == Layer::Airlight;
            let most = if is_coarse { 3e-2 } else { 1e-3 };
            assert!(model.largest_difference < most, "{model:?}");
        }
    }
}
