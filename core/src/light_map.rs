//! The optical depth between a light and what it first meets, in all directions: a cube of pictures around a lamp, a square
//! across the sun's way.

use crate::cpu::Cpu;
use crate::frame::Frame;
use crate::geometry::{Beyond, Origin};
use crate::light::Light;
use crate::progress::{Interrupted, Progress};
use crate::renderer::Renderer;
use crate::request::{Layer, Options, Quality, Tonemap, View};
use crate::scene::{Camera, CheckedScene, Perspective, Projection, Vec3};
use glam::DVec3;
use rayon::prelude::*;

/// Where the six pictures of a cube look, and what is up in them.
const FACES: [(DVec3, DVec3); 6] = [
    (DVec3::X, DVec3::Y),
    (DVec3::NEG_X, DVec3::Y),
    (DVec3::Y, DVec3::NEG_Z),
    (DVec3::NEG_Y, DVec3::Z),
    (DVec3::Z, DVec3::Y),
    (DVec3::NEG_Z, DVec3::Y),
];

/// What a picture of such a map is.
pub fn view(size: u32) -> View {
    View {
        width: size,
        height: size,
        quality: Quality::Full,
        layer: Layer::OpticalDepth,
        samples: Some(1),
        exposure_ev: 0.0,
        tonemap: Tonemap::None,
        for_screen: false,
        is_hasty: false,
        estimator: None,
        options: Options::default(),
    }
}

/// Pictures that a map of a light has, one below the other; none if its light comes from everywhere.
pub fn pictures(light: &Light) -> u32 {
    match light.lamp(0.0) {
        Some((source, _)) if source.apex().is_some() => 6,
        Some(_) => 1,
        None => 0,
    }
}

/// The map of a light, `size` pixels across; the sky has none, and whoever asks has seen to that.
///
/// # Errors
/// [`Interrupted`] when `progress` says so.
pub fn render(
    renderer: &Renderer,
    scene: &CheckedScene,
    light: usize,
    size: u32,
    progress: &Progress,
) -> Result<Frame, Interrupted> {
    let lamp = scene.lights[light].lamp(scene.fog.light_path_m);
    match lamp.ok_or(Interrupted)?.0.origin() {
        Origin::At(apex) => around(renderer, scene, apex, size, progress),
        Origin::Beyond(beyond) => across(renderer.cpu(), scene, &beyond, size, progress),
    }
}

/// Six pictures, each mirrored: a cube's faces are given as they are seen from outside.
fn around(
    renderer: &Renderer,
    scene: &CheckedScene,
    apex: DVec3,
    size: u32,
    progress: &Progress,
) -> Result<Frame, Interrupted> {
    let mut whole: Option<Frame> = None;
    for (i, (axis, up)) in FACES.into_iter().enumerate() {
        progress.stretch(i as f64 / 6.0, (i + 1) as f64 / 6.0);
        let camera = Camera {
            position: Vec3(apex.to_array()),
            target: Vec3((apex + axis * (1e-6 * apex.length()).max(1.0)).to_array()),
            up: Vec3(up.to_array()),
            projection: Projection::Perspective(Perspective { vertical_fov_deg: 90.0 }),
        };
        let frame = renderer.render(&scene.seen_by(camera), &view(size), progress)?;
        let row = size as usize * frame.channels;
        let mirrored = frame.pixels.chunks(row).flat_map(|line| {
            line.chunks(frame.channels).rev().flatten().copied().collect::<Vec<_>>()
        });
        let pixels: Vec<f32> = mirrored.collect();
        match &mut whole {
            Some(whole) => {
                whole.pixels.extend(pixels);
                whole.height += size as usize;
            }
            None => whole = Some(Frame { pixels, ..frame }),
        }
    }
    whole.ok_or(Interrupted)
}

/// One picture across the way of the sun's light, as wide as all that has an end.
fn across(
    cpu: &Cpu,
    scene: &CheckedScene,
    beyond: &Beyond,
    size: u32,
    progress: &Progress,
) -> Result<Frame, Interrupted> {
    let geometry = cpu.cache.geometry(scene, progress)?;
    let bands = cpu.cache.bands(scene, progress)?;
    let reach = |middle: DVec3| {
        let of_fog = bands.each().iter().map(|field| field.reach(middle)).fold(0.0, f64::max);
        geometry.reach(geometry.anchor - middle).max(of_fog)
    };
    let middle = geometry.anchor;
    let half = reach(middle);
    let forward = -beyond.toward;
    let up = if forward.y.abs() > 0.999 { DVec3::NEG_Z } else { DVec3::Y };
    let right = forward.cross(up).normalize();
    let up = right.cross(forward);
    let channels = bands.each().len();
    let count = size as usize;
    let ray = |pixel: usize| {
        let at = |i: usize| 2.0 * (i as f64 + 0.5) / count as f64 - 1.0;
        let (x, y) = (at(pixel % count), -at(pixel / count));
        let start = middle + half * (x * right + y * up - 2.0 * forward);
        let hit = geometry.first_hit(start, forward, scene.far_m.max(4.0 * half));
        // Where nothing is met, all that lies on the way.
        let end = start + hit.map_or(4.0 * half, |hit| hit.distance) * forward;
        bands.each().iter().map(move |field| field.depth_from(Origin::Beyond(*beyond), end) as f32)
    };
    progress.start(count, 1.0);
    let rows = (0..count).into_par_iter().map(|row| {
        progress.check()?;
        let line: Vec<f32> = (row * count..(row + 1) * count).flat_map(ray).collect();
        progress.advance();
        Ok(line)
    });
    let pixels = rows.collect::<Result<Vec<_>, Interrupted>>()?.concat();
    Ok(Frame {
        width: count,
        height: count,
        channels,
        layer: Layer::OpticalDepth,
        camera: scene.camera.clone(),
        pixels,
        shown: None,
        timings: Vec::new(),
        backend: "cpu",
    })
}
