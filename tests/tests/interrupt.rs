//! Any job, on the largest scenes that are accepted, ends soon after its time is over: it would hold
//! the only worker otherwise.

use fogbank_core::airlight::Method;
use fogbank_core::compare::{self, CompareRequest};
use fogbank_core::request::{Layer, Quality, View};
use fogbank_core::scene::limits::COUNTS;
use fogbank_core::scene::{
    Airlight, Blob, CheckedScene, Fog, Gaussians, HenyeyGreenstein, Mesh, Phase, Scene, Shape,
    Surface, Term, Vec3, read,
};
use fogbank_core::{Interrupted, Progress, Renderer};
use fogbank_tests::scenes::{Random, pixel_rays, scene, view};
use serde_json::json;
use std::time::{Duration, Instant};

/// When jobs are over: at once, and in the midst of what they do.
const MOMENTS: [u64; 3] = [0, 60, 900];
/// By when they must have ended then. They look every tenth of a second; the rest is for machines that
/// have more to do.
const SOON: Duration = Duration::from_secs(4);

/// Has jobs stopped at several moments, each with a new renderer; whether any did not come to its end.
fn stops<T>(name: &str, job: impl Fn(&Renderer, &Progress) -> Result<T, Interrupted>) -> bool {
    let mut was_stopped = false;
    for moment in MOMENTS {
        let end = Instant::now() + Duration::from_millis(moment);
        was_stopped |= job(&Renderer::default(), &Progress::until(end)).is_err();
        let late = Instant::now().saturating_duration_since(end);
        println!("{name}, over after {moment} ms: {} ms late", late.as_millis());
        assert!(late < SOON, "{name} goes on for {late:?}");
    }
    was_stopped
}

fn fog(airlight: Airlight, blobs: usize, radius: [f64; 2], extinction: f64) -> Fog {
    let mut random = Random(3);
    let mut blob = || Blob {
        center: Vec3(random.point(4.0).to_array()),
        radius: random.decades(radius[0], radius[1]),
        extinction: extinction.into(),
    };
    let blobs = (0..blobs).map(|_| blob()).collect();
    let term = Term::Gaussians(Gaussians { blobs, ..Gaussians::default() });
    Fog { airlight, terms: vec![term], ..Fog::default() }
}

/// Lamps in a fog with a floor.
fn crowded(lamps: usize, fog: Fog) -> CheckedScene {
    let json = json!({
        "camera": { "position": [0, 1, 9], "target": [0, 0, 0] },
        "surfaces": [{ "shape": { "kind": "plane", "point": [0, -2, 0] } }],
        "lights": Random(5).lamps(lamps, 3.0),
    });
    let bare: Scene = read(json.to_string().as_bytes()).unwrap();
    Scene { fog, ..bare }.check().unwrap()
}

/// As many blobs as there may be, all of them everywhere.
fn everywhere(airlight: Airlight, lamps: usize) -> CheckedScene {
    crowded(lamps, fog(airlight, COUNTS.blobs, [2.0, 9.0], 1e-6))
}

/// As many, opaque and small.
fn opaque(airlight: Airlight) -> CheckedScene {
    crowded(COUNTS.lights, fog(airlight, COUNTS.blobs, [0.02, 0.3], 1e4))
}

fn picture(quality: Quality, layer: Layer) -> View {
    view(640, 480, layer, quality)
}

fn for_screen(quality: Quality) -> View {
    View { for_screen: true, samples: Some(16), ..picture(quality, Layer::Beauty) }
}

#[test]
fn pictures_by_the_published_method() {
    for (name, scene) in [
        ("everywhere", everywhere(Airlight::Fogshop2007, COUNTS.lights)),
        ("opaque", opaque(Airlight::Fogshop2007)),
    ] {
        for quality in [Quality::Draft, Quality::Full] {
            let job = |renderer: &Renderer, progress: &Progress| {
                renderer.render(&scene, &for_screen(quality), progress)
            };
            assert!(stops(&format!("published, {name}, {quality:?}"), job));
        }
    }
}

#[test]
fn pictures_by_the_mapped_rule() {
    let few = fog(Airlight::Auto, 40, [2.0, 9.0], 1e-3);
    for (name, scene) in [
        ("everywhere", everywhere(Airlight::Auto, COUNTS.lights)),
        ("opaque", opaque(Airlight::Auto)),
        ("few", crowded(COUNTS.lights, few)),
    ] {
        for view in [for_screen(Quality::Draft), picture(Quality::Full, Layer::Airlight)] {
            let job =
                |renderer: &Renderer, progress: &Progress| renderer.render(&scene, &view, progress);
            stops(&format!("mapped, {name}, {:?}", view.quality), job);
        }
    }
}

#[test]
fn depths_and_surfaces() {
    for (name, scene) in [
        ("everywhere", everywhere(Airlight::None, COUNTS.lights)),
        ("opaque", opaque(Airlight::None)),
    ] {
        for layer in [Layer::OpticalDepth, Layer::Surface] {
            for quality in [Quality::Draft, Quality::Full] {
                let job = |renderer: &Renderer, progress: &Progress| {
                    renderer.render(&scene, &picture(quality, layer), progress)
                };
                assert!(stops(&format!("{layer:?}, {name}, {quality:?}"), job));
            }
        }
    }
}

#[test]
fn single_rays_of_the_reference_and_of_marching() {
    let thick = everywhere(Airlight::Auto, 1);
    for estimator in [Method::Reference, Method::March(4096)] {
        let view =
            View { estimator: Some(estimator), ..view(4, 4, Layer::Airlight, Quality::Full) };
        let job =
            |renderer: &Renderer, progress: &Progress| renderer.render(&thick, &view, progress);
        assert!(stops(&format!("{estimator:?}"), job));
    }
}

#[test]
fn probes() {
    for airlight in [Airlight::Fogshop2007, Airlight::Auto, Airlight::Reference] {
        let scene = everywhere(airlight, COUNTS.lights);
        let rays = pixel_rays(&scene, 8, 8);
        let job =
            |renderer: &Renderer, progress: &Progress| renderer.probe(&scene, &rays, progress);
        assert!(stops(&format!("probe, {airlight:?}"), job));
    }
    let phase = Phase::HenyeyGreenstein(HenyeyGreenstein { g: 0.9 });
    let fog = Fog { phase, ..fog(Airlight::Reference, COUNTS.blobs, [2.0, 9.0], 1.0) };
    let scene = crowded(COUNTS.lights, fog);
    let rays = pixel_rays(&scene, 8, 8);
    assert!(stops("probe, phase", |renderer, progress| renderer.probe(&scene, &rays, progress)));
}

#[test]
fn comparisons() {
    let mut scene =
        serde_json::to_value(&*crowded(8, fog(Airlight::Auto, 3_000, [2.0, 9.0], 1e-3)));
    let request = json!({ "scene": scene.as_mut().unwrap().take(), "width": 320, "height": 240 });
    let request: CompareRequest = read(request.to_string().as_bytes()).unwrap();
    let (scene, pair) = request.check().unwrap();
    assert!(stops("compare", |renderer, progress| compare::run(renderer, &scene, &pair, progress)));
}

#[test]
fn the_self_test() {
    stops("self-test", |renderer, progress| renderer.selftest(progress));
}

/// A mesh of as many triangles as there may be, each within the next, seen by many samples.
#[test]
fn first_hits_and_the_geometry() {
    let corner = |i: usize, j: usize| {
        let (size, turn) = (1.0 + 1e-6 * i as f64, std::f64::consts::TAU * j as f64 / 3.0);
        Vec3([size * turn.cos(), size * turn.sin(), 0.0])
    };
    for (name, count, equal) in [("equal", 20_000, true), ("nested", COUNTS.triangles / 3, false)] {
        let positions = (0..3 * count).map(|i| corner(if equal { 0 } else { i / 3 }, i % 3));
        let indices = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
        let mesh =
            Mesh { positions: positions.collect(), indices: indices.collect(), normals: None };
        let surface = Surface { shape: Shape::Mesh(mesh), ..Surface::default() };
        let bare = scene(&json!({ "camera": { "position": [0, 0, 2], "target": [0, 0, 0] } }));
        let scene = Scene { surfaces: vec![surface], ..Scene::clone(&bare) }.check().unwrap();
        let view = View { samples: Some(16), ..picture(Quality::Full, Layer::Normal) };
        let job =
            |renderer: &Renderer, progress: &Progress| renderer.render(&scene, &view, progress);
        assert!(stops(&format!("{name} triangles"), job));
    }
}

/// What a ray takes by the published method does not grow with the pairs of blobs, where blobs are
/// local: 20 000 of them and 8 lamps took ten minutes a ray.
#[test]
fn a_probe_of_many_local_blobs_comes_to_its_end() {
    let scene = crowded(8, fog(Airlight::Fogshop2007, 20_000, [0.1, 0.2], 0.1));
    let rays = pixel_rays(&scene, 1, 1);
    let progress = Progress::until(Instant::now() + Duration::from_secs(120));
    let answers = Renderer::default().probe(&scene, &rays, &progress).unwrap();
    assert!(
        answers.iter().all(|answer| answer.airlight.0.iter().all(|v| v.is_finite() && *v > 0.0))
    );
}
