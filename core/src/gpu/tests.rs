//! The shaders against the CPU's text of the same maths, on whatever Vulkan adapter there is: in CI a
//! driver in software.

mod lights;

use super::device::Stage;
use super::{Failure, Gpu, Wanted};
use crate::cpu::Cpu;
use crate::image::{display, flip};
use crate::media::KINDS;
use crate::presets::{self, Preset};
use crate::renderer::{Backend, Frame, Progress, Renderer};
use crate::request::{Layer, Quality, Tonemap, View};
use crate::scene::{Airlight, CheckedScene, Scene, read};
use crate::selftest;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use wgpu::BufferUsages;

fn gpu() -> Gpu {
    Gpu::open(Wanted::Any).expect("a Vulkan adapter, be it lavapipe")
}

fn renderer() -> Renderer {
    Renderer::open(Backend::Gpu).expect("a Vulkan adapter, be it lavapipe")
}

fn view(layer: Layer, airlight: Airlight) -> View {
    let estimator = Some(airlight.into());
    View { width: 160, height: 120, estimator, ..selftest::view(layer) }
}

fn both(gpu: &Gpu, scene: &CheckedScene, view: &View) -> [Frame; 2] {
    let cpu = Cpu::default();
    let shown = gpu.render(&cpu.cache, scene, view, &Progress::default());
    let shown = shown.expect("a frame").expect("a pass for it");
    [shown, cpu.render(scene, view, &Progress::default()).expect("not interrupted")]
}

/// Values that differ by more than a share of themselves, or of a hundredth of the largest.
fn differing(frames: &[Frame; 2], share: f32) -> usize {
    let [a, b] = frames.each_ref().map(|frame| &frame.pixels);
    let largest = b.iter().fold(0.0f32, |most, v| most.max(v.abs()));
    let differs = |(a, b): &(&f32, &f32)| {
        let off = (*a - *b).abs() / b.abs().max(0.01 * largest);
        off.is_nan() || off > share
    };
    a.iter().zip(b).filter(differs).count()
}

/// The presets that an airlight takes on a device; what it publishes of skies is the CPU's.
fn taken(airlight: Airlight) -> impl Iterator<Item = (&'static str, CheckedScene)> {
    let takes = move |preset: &Preset| {
        let is_under_sky = preset.scene.lights.iter().any(|light| light.sky().is_some());
        let is_published = airlight != Airlight::Auto && is_under_sky;
        preset.scene.fog.refusal(airlight).is_none() && !is_published
    };
    let taken = presets::all().into_iter().filter(takes);
    taken.map(|preset| (preset.name, preset.scene.check().expect("a preset")))
}

fn check(layer: Layer, airlight: Airlight, share: f32) {
    let gpu = gpu();
    for (name, scene) in taken(airlight) {
        let view = view(layer, airlight);
        let frames = both(&gpu, &scene, &view);
        assert_eq!((frames[0].backend, frames[1].backend), ("gpu", "cpu"));
        let off = differing(&frames, share);
        let all = frames[1].pixels.len();
        // A ray that grazes an edge may see either side of it; and the published method lights a blob as its centre on the
        // ray is, so that one at the rim of a shadow is lit or not.
        let one_in = if airlight == Airlight::Fogshop2007 { 30 } else { 500 };
        assert!(one_in * off <= all, "{name} {layer:?}: {off} of {all} differ");
    }
}

#[test]
fn first_hits_are_the_cpus() {
    check(Layer::Depth, Airlight::None, 1e-4);
    check(Layer::Normal, Airlight::None, 1e-3);
}

#[test]
fn optical_depths_are_the_cpus() {
    check(Layer::OpticalDepth, Airlight::None, 1e-3);
}

#[test]
fn surfaces_are_the_cpus() {
    check(Layer::Surface, Airlight::None, 1e-3);
}

/// What two grids of drafts may differ by where one backend quarters a cell and the other does not: as much as
/// drafts may be off.
const BOTH: f32 = 0.05;

/// A small picture; of `auto` airlight, which is the CPU's as numbers, a draft.
fn shown_by_grid(layer: Layer, airlight: Airlight) -> View {
    let is_on_grid = matches!((layer, airlight), (Layer::Airlight | Layer::Beauty, Airlight::Auto));
    let quality = if is_on_grid { Quality::Draft } else { Quality::Full };
    View { width: 64, height: 48, quality, ..view(layer, airlight) }
}

/// The same knots and tables, each in its own arithmetic, in cells of their own.
#[test]
fn the_grid_is_the_cpus() {
    let gpu = gpu();
    for name in ["steaming-vessel", "terrain-292", "city-353", "lighthouse"] {
        let preset = presets::all().into_iter().find(|preset| preset.name == name);
        let scene = preset.expect("a preset").scene.check().expect("a valid preset");
        for layer in [Layer::Airlight, Layer::Beauty] {
            let view = View { width: 160, height: 120, ..shown_by_grid(layer, Airlight::Auto) };
            let frames = both(&gpu, &scene, &view);
            assert_eq!((frames[0].backend, frames[1].backend), ("gpu", "cpu"));
            let off = differing(&frames, BOTH);
            // At the rims of thin shafts rounding decides between two slices.
            assert!(100 * off <= frames[1].pixels.len(), "{name} {layer:?}: {off}");
        }
    }
}

/// Every medium of the list, in the test scene that needs all that it can do: T along views and towards
/// lamps, and the light that it scatters.
#[test]
fn every_medium_is_the_cpus() {
    let gpu = gpu();
    for (kind, _, terms) in KINDS {
        for (layer, share) in
            [(Layer::OpticalDepth, 1e-4), (Layer::Surface, 1e-3), (Layer::Airlight, BOTH)]
        {
            let scene = selftest::scene(&format!(r#"{{"terms": {terms}}}"#)).expect("a scene");
            let frames = both(&gpu, &scene, &shown_by_grid(layer, Airlight::Auto));
            assert_eq!((frames[0].backend, frames[1].backend), ("gpu", "cpu"));
            let off = differing(&frames, share);
            assert!(100 * off <= frames[1].pixels.len(), "{kind} {layer:?}: {off}");
        }
    }
}

/// The sun through every medium, and through so many blobs that they stand in a table: the light that it scatters,
/// and what reaches surfaces.
#[test]
fn the_sun_is_the_cpus() {
    let gpu = gpu();
    let blob = |i: usize| {
        let at = [i % 5, i / 5].map(|k| 1.3 * k as f64 - 2.5);
        format!(
            r#"{{"center": [{}, {}, {}], "radius": 0.8, "extinction": 0.3}}"#,
            at[0],
            0.2 * i as f64,
            at[1]
        )
    };
    let blobs: Vec<_> = (0..20).map(blob).collect();
    let many = format!(r#"[{{"kind": "gaussians", "blobs": [{}]}}]"#, blobs.join(","));
    for terms in KINDS.iter().map(|(_, _, terms)| *terms).chain([many.as_str()]) {
        for (layer, share) in [(Layer::Surface, 1e-3), (Layer::Airlight, BOTH)] {
            let fog = format!(r#"{{"terms": {terms}, "light_path_m": 9}}"#);
            let scene = selftest::sunlit(&fog).expect("a scene");
            let frames = both(&gpu, &scene, &shown_by_grid(layer, Airlight::Auto));
            assert_eq!((frames[0].backend, frames[1].backend), ("gpu", "cpu"));
            let off = differing(&frames, share);
            assert!(100 * off <= frames[1].pixels.len(), "{terms} {layer:?}: {off}");
        }
    }
}

/// Terms that scatter in ways of their own, in fog of a coloured extinction: on the grid, as published,
/// and by Sun's closed form.
#[test]
fn coloured_smoke_is_the_cpus() {
    const BLOB: &str =
        r#""blobs": [{"center": [-1, 0.6, 0], "radius": 1.2, "extinction": [0.2, 0.5, 1]}]"#;
    const OTHER: &str = r#""blobs": [{"center": [1.5, 1, -2], "radius": 0.7, "extinction": 0.9}]"#;
    let smoke = format!(
        r#"{{"terms": [{{"kind": "homogeneous", "extinction": [0.01, 0.02, 0.04]}},
            {{"kind": "gaussians", "albedo": [0.9, 0.3, 0.2],
              "phase": {{"kind": "henyey_greenstein", "g": 0.6}}, {BLOB}}},
            {{"kind": "gaussians", "albedo": [0.2, 0.4, 0.9], {OTHER}}}]}}"#
    );
    let alike = format!(
        r#"{{"terms": [{{"kind": "gaussians", {BLOB}}}, {{"kind": "homogeneous", "extinction": 0.02}}]}}"#
    );
    let even = r#"{"terms": [{"kind": "homogeneous", "extinction": 0.05, "albedo": [1, 0.5, 0.2]},
        {"kind": "homogeneous", "extinction": [0.1, 0.05, 0.02], "albedo": [0.3, 0.6, 0.9]}]}"#;
    let gpu = gpu();
    let fogs = [
        (smoke.as_str(), Airlight::Auto, BOTH),
        (alike.as_str(), Airlight::Fogshop2007, 1e-3),
        (even, Airlight::Sun2005, 1e-3),
    ];
    for (fog, airlight, share) in fogs {
        let scene = selftest::scene(fog).expect("a scene");
        for (layer, share) in [
            (Layer::OpticalDepth, 1e-4),
            (Layer::Transmittance, 1e-4),
            (Layer::Surface, 1e-3),
            (Layer::Airlight, share),
            (Layer::Beauty, share),
        ] {
            let view = shown_by_grid(layer, airlight);
            let frames = both(&gpu, &scene, &view);
            assert_eq!(frames.each_ref().map(|frame| frame.channels), [3, 3]);
            let off = differing(&frames, share);
            // In drafts the device carries depths from lamps to surfaces over, too.
            let few = if view.quality == Quality::Draft { 50 } else { 100 };
            assert!(few * off <= frames[1].pixels.len(), "{airlight:?} {layer:?}: {off}");
        }
    }
}

/// Rays that noise bends, and blobs that view rays see as slabs: T, the light that the grid and Macklin's closed form
/// make of them.
#[test]
fn noise_and_slabs_are_the_cpus() {
    let blobs = r#""blobs": [{"center": [-1, 0.6, 0], "radius": 1.2, "extinction": 0.5},
        {"center": [1.5, 1, -2], "radius": 0.7, "extinction": 1.4},
        {"center": [0.3, 1.4, 6], "radius": 0.5, "extinction": 0.4}]"#;
    let even = r#"{"kind": "homogeneous", "extinction": 0.02}"#;
    let noise = r#""noise": {"strength": 0.8, "scale_m": 3, "seed": 9}"#;
    let bent = format!(r#"{{{noise}, "terms": [{even}, {{"kind": "gaussians", {blobs}}}]}}"#);
    let slabs =
        format!(r#"{{"terms": [{even}, {{"kind": "gaussians", "draw": "slab", {blobs}}}]}}"#);
    let both_of_them =
        format!(r#"{{{noise}, "terms": [{{"kind": "gaussians", "draw": "slab", {blobs}}}]}}"#);
    let gpu = gpu();
    let fogs = [
        (&bent, Airlight::Auto, BOTH),
        (&bent, Airlight::Fogshop2007, 2e-3),
        (&slabs, Airlight::Auto, BOTH),
        (&slabs, Airlight::Macklin2010, 1e-3),
        (&both_of_them, Airlight::Macklin2010, 2e-3),
    ];
    for (fog, airlight, share) in fogs {
        let scene = selftest::scene(fog).expect("a scene");
        for (layer, share) in
            [(Layer::OpticalDepth, 1e-4), (Layer::Airlight, share), (Layer::Beauty, share)]
        {
            let view = shown_by_grid(layer, airlight);
            let frames = both(&gpu, &scene, &view);
            assert_eq!((frames[0].backend, frames[1].backend), ("gpu", "cpu"));
            let off = differing(&frames, share);
            assert!(50 * off <= frames[1].pixels.len(), "{fog} {airlight:?} {layer:?}: {off}");
        }
    }
}

/// While nothing moves a device uploads no list again, and a picture of what was kept is the same to the
/// last bit.
#[test]
fn lists_are_kept_while_nothing_moves() {
    let (gpu, cpu) = (gpu(), Cpu::default());
    let scene = |red: f64| {
        let text = format!(
            r#"{{"lights": [{{"kind": "point", "intensity": [{red}, 2, 3]}}], "fog": {{"airlight": "fogshop2007",
                "terms": [{{"kind": "gaussians", "blobs": [{{"center": [0, 1, -3]}}]}}]}}}}"#
        );
        let scene: Scene = read(text.as_bytes()).expect("a scene");
        scene.check().expect("a valid scene")
    };
    let view = View { estimator: None, ..view(Layer::Beauty, Airlight::Auto) };
    let shown = |gpu: &Gpu, red: f64| {
        let frame = gpu.render(&cpu.cache, &scene(red), &view, &Progress::default());
        frame.expect("a frame").expect("a pass for it").pixels
    };
    let first = shown(&gpu, 1.0);
    let bytes = gpu.bytes();
    let brighter = shown(&gpu, 9.0);
    assert_eq!(gpu.bytes(), bytes, "something was made again");
    assert!(brighter != first && shown(&gpu, 1.0) == first);
    assert!(shown(&self::gpu(), 9.0) == brighter);
}

/// How far apart two frames look on a screen: the mean of FLIP.
fn flip(a: &Frame, b: &Frame, view: &View) -> f64 {
    let [a, b] = [a, b].map(|frame| display::bytes(frame, view).into_owned());
    let mean = flip::mean(&b, &a, view.width as usize, &Progress::default());
    mean.expect("not interrupted")
}

/// Blobs are added up in another order, and the device brings radiance onto the screen itself: the
/// eye sees no difference.
#[test]
fn pictures_look_like_the_cpus() {
    let gpu = gpu();
    for (airlight, tonemap) in [
        (Airlight::Fogshop2007, Tonemap::Agx),
        (Airlight::Auto, Tonemap::Agx),
        (Airlight::None, Tonemap::Reinhard),
        (Airlight::None, Tonemap::None),
    ] {
        // Other tone maps are the same whatever there is to see.
        let few = if tonemap == Tonemap::Agx { usize::MAX } else { 2 };
        for (name, scene) in taken(airlight).take(few) {
            // What has a veil alone is drawn so.
            let airlight =
                if scene.fog.airlight == Airlight::None { Airlight::None } else { airlight };
            let view = View { samples: Some(4), tonemap, ..view(Layer::Beauty, airlight) };
            let view = View { for_screen: true, ..view };
            let [a, b] = both(&gpu, &scene, &view);
            assert!(a.shown.is_some() && b.shown.is_none(), "who brings a picture onto the screen");
            let mean = flip(&a, &b, &view);
            assert!(mean < 0.01, "{name}: {mean}");
        }
    }
}

/// In a draft the device borrows a neighbour's fog where the CPU computes a pixel itself, behind
/// what is narrower than the low resolution; and computes what the CPU borrows in homogeneous fog.
/// Neither is farther from the full picture than the other, by more than the eye sees.
#[test]
fn drafts_are_as_good_as_the_cpus() {
    let gpu = gpu();
    let cpu = Cpu::default();
    for (name, scene) in taken(Airlight::Fogshop2007) {
        let full = View { for_screen: true, ..view(Layer::Beauty, Airlight::Fogshop2007) };
        let draft = View { quality: Quality::Draft, ..full };
        let truth = cpu.render(&scene, &full, &Progress::default()).expect("not interrupted");
        let [own, cpus] = both(&gpu, &scene, &draft).map(|frame| flip(&frame, &truth, &full));
        assert!(own < cpus + 0.006, "{name}: {own}, the CPU's {cpus}");
    }
}

/// Whatever a driver does to a device, the next frame is there, and memory comes back.
#[test]
fn a_lost_device_is_replaced_and_then_given_up() {
    let scene = presets::all().remove(2).scene.check().expect("a preset");
    let view = view(Layer::OpticalDepth, Airlight::None);
    let renderer = renderer();
    let frame = || renderer.render(&scene, &view, &Progress::default()).expect("not interrupted");
    let first = frame();
    assert_eq!(first.backend, "gpu");
    for _ in 0..3 {
        renderer.gpu().expect("a device").destroy();
        let next = frame();
        assert_eq!((next.backend, &next.pixels), ("gpu", &first.pixels));
    }
    assert_eq!(renderer.backend(), "gpu");
    renderer.gpu().expect("a device").destroy();
    assert_eq!(frame().backend, "cpu");
    assert_eq!(renderer.backend(), "cpu");
    assert!(renderer.fallback().load(Ordering::Relaxed));
}

/// Wherever in a frame a device ends, and between two of them, the frame is made on the next one; and
/// what the lost one held is free.
#[test]
fn a_device_may_end_at_any_stage() {
    let scene = presets::all().remove(2).scene.check().expect("a preset");
    let views = [Layer::Beauty, Layer::OpticalDepth].map(|layer| View {
        width: 64,
        height: 48,
        ..view(layer, Airlight::Fogshop2007)
    });
    let render = |renderer: &Renderer, view: &View| {
        let frame = renderer.render(&scene, view, &Progress::default()).expect("not interrupted");
        assert_eq!(frame.backend, "gpu");
        frame.pixels
    };
    let right = views.map(|view| render(&renderer(), &view));
    let stages = [Stage::Pipeline, Stage::Upload, Stage::Dispatch, Stage::Map].map(Some);
    let mut resident = Vec::new();
    for stage in stages.into_iter().chain([None]) {
        resident.push(resident_mb());
        let renderer = renderer();
        let mut bytes = Vec::new();
        for round in 0..20 {
            renderer.forgive();
            let lost = renderer.gpu().expect("a device");
            match stage {
                Some(_) => *lost.device.doom.lock().expect("no panic") = stage,
                None => lost.destroy(),
            }
            // The fresh device of the round before has no pipelines for this layer.
            let pixels = render(&renderer, &views[round % 2]);
            assert!(pixels == right[round % 2], "{stage:?}, round {round}");
            let now = renderer.gpu().expect("a device");
            assert!(!Arc::ptr_eq(&lost, &now), "{stage:?}: the device was not lost");
            bytes.push(now.bytes());
        }
        assert!(bytes.iter().skip(2).zip(&bytes).all(|(a, b)| a == b), "{stage:?}: {bytes:?}");
    }
    // A driver in software keeps some megabytes of every device.
    let grown = resident_mb().saturating_sub(resident[1]);
    assert!(grown < 80 * 20, "{grown} MB are left of 80 devices");
}

/// Memory of this process.
fn resident_mb() -> usize {
    let pages = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    let pages = pages.split(' ').nth(1).and_then(|number| number.parse::<usize>().ok());
    pages.unwrap_or_default() * 4096 / 1_000_000
}

/// Every pipeline that a frame may need is one that the device takes.
#[test]
fn the_device_warms_up() {
    gpu().warm_up().expect("all pipelines");
}

/// Threads share a device; whoever waits gets its own picture.
#[test]
fn threads_share_a_device() {
    let scene = presets::all().remove(2).scene.check().expect("a preset");
    let renderer = renderer();
    let device = renderer.gpu().expect("a device");
    let layers = [Layer::Depth, Layer::OpticalDepth, Layer::Surface, Layer::Normal];
    let render = |layer| {
        let view = view(layer, Airlight::None);
        let frame = renderer.render(&scene, &view, &Progress::default()).expect("not interrupted");
        assert_eq!(frame.backend, "gpu");
        frame.pixels
    };
    let alone = layers.map(render);
    std::thread::scope(|scope| {
        for (layer, alone) in layers.into_iter().zip(&alone) {
            scope.spawn(move || assert!((0..10).all(|_| render(layer) == *alone), "{layer:?}"));
        }
    });
    let now = renderer.gpu().expect("a device");
    assert!(Arc::ptr_eq(&device, &now), "a device that nothing ails was replaced");
}

/// Frames leave nothing on the device but what is kept on purpose.
#[test]
fn memory_is_flat() {
    let gpu = gpu();
    let scene = presets::all().remove(2).scene.check().expect("a preset");
    let view = view(Layer::Beauty, Airlight::Fogshop2007);
    let cpu = Cpu::default();
    let frame = || {
        gpu.render(&cpu.cache, &scene, &view, &Progress::default()).expect("a frame");
        gpu.bytes()
    };
    let after_one = frame();
    assert!((0..20).all(|_| frame() == after_one));
}

/// What does not fit is refused before it is made, and the CPU takes it.
#[test]
fn a_picture_too_large_for_the_device_is_the_cpus() {
    let renderer = renderer();
    let scene = read::<Scene>(b"{}").expect("a scene").check().expect("a valid scene");
    let view = View { width: 1 << 17, height: 1, ..view(Layer::Depth, Airlight::None) };
    let frame = renderer.render(&scene, &view, &Progress::default()).expect("not interrupted");
    assert_eq!((frame.backend, renderer.backend()), ("cpu", "gpu"));
    // Drivers promise more than there is: what passes our own count never reaches them.
    let gpu = renderer.gpu().expect("a device");
    let before = gpu.bytes();
    let size = 1 << 30;
    let usage = BufferUsages::COPY_DST;
    let held = [(); 2].map(|()| gpu.device.buffer(size - before / 2, usage));
    assert!(held.iter().all(Result::is_ok));
    assert_eq!(gpu.device.buffer(1 << 20, usage).err(), Some(Failure::Memory(1 << 20)));
    drop(held);
    assert_eq!(gpu.bytes(), before);
}

#[test]
fn published_airlight_is_the_cpus() {
    check(Layer::Airlight, Airlight::Fogshop2007, 1e-3);
    check(Layer::Beauty, Airlight::Fogshop2007, 1e-3);
}
