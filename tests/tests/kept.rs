//! What a renderer keeps from frame to frame: it never changes a pixel, and it does not grow.

use fogbank_core::request::{Layer, Quality, View};
use fogbank_core::scene::{CheckedScene, Light};
use fogbank_core::{Progress, Renderer, presets};
use fogbank_tests::scenes::{Random, homogeneous, pixel_rays, scene, surfaces, view};
use serde_json::{Value, json};

/// So many lamps in a fog whose light is looked up in tables, as fine as they may be.
fn lamps(count: usize) -> Value {
    let mut random = Random(7);
    let blobs = random.blobs(60, 3.0, [0.05, 0.15], [1.0, 5.0]);
    json!({ "camera": { "position": [0, 1, 9], "target": [0, 0, 0] }, "far_m": 60,
            "surfaces": surfaces(), "lights": random.lamps(count, 2.0),
            "fog": { "terms": [homogeneous(0.02), blobs] } })
}

fn pixels(renderer: &Renderer, scene: &CheckedScene, view: &View) -> Vec<f32> {
    renderer.render(scene, view, &Progress::default()).unwrap().pixels
}

/// The same frame, whatever the renderer made before: other numbers of lamps, fogs, places, materials
/// and views, to and fro.
#[test]
fn what_is_kept_changes_no_pixel() {
    let kept = Renderer::default();
    let with = |pointer: &str, value: Value| {
        let mut json = lamps(2);
        *json.pointer_mut(pointer).unwrap() = value;
        json
    };
    let with_fog = |member: &str, value: Value| {
        let mut json = lamps(2);
        json["fog"][member] = value;
        json
    };
    let mut published = lamps(2);
    published["fog"]["airlight"] = json!("fogshop2007");
    let scenes = [
        lamps(33),
        lamps(1),
        lamps(2),
        with("/lights/0/position/0", json!(-0.3)),
        with("/lights/1/position/1", json!(0.9)),
        with("/lights/0/intensity/0", json!(3)),
        with("/lights/0", json!({ "kind": "point", "enabled": false })),
        with_fog("albedo", json!([1, 0.5, 0.3])),
        with_fog("phase", json!({ "kind": "henyey_greenstein", "g": 0.6 })),
        with("/fog/terms/1/blobs/3/extinction", json!(30)),
        with("/surfaces/1/material/diffuse/0", json!(0.1)),
        with("/camera/position/0", json!(0.5)),
        with("/far_m", json!(11)),
        published.clone(),
        lamps(1),
        published,
    ];
    let numbers = view(32, 24, Layer::Beauty, Quality::Full);
    let screen = View { for_screen: true, samples: Some(4), ..numbers };
    let draft = View { quality: Quality::Draft, ..screen };
    let views = [
        numbers,
        screen,
        View { exposure_ev: 1.5, ..screen },
        View { layer: Layer::Airlight, ..screen },
        View { samples: Some(1), ..screen },
        draft,
        View { layer: Layer::OpticalDepth, ..draft },
        View { layer: Layer::Surface, for_screen: false, ..draft },
        View { layer: Layer::Transmittance, ..numbers },
    ];
    for (i, json) in scenes.iter().enumerate() {
        let (scene, fresh, progress) = (scene(json), Renderer::default(), Progress::default());
        for view in &views {
            let is_same = pixels(&kept, &scene, view) == pixels(&fresh, &scene, view);
            assert!(is_same, "scene {i} looks otherwise: {view:?}");
        }
        let rays = pixel_rays(&scene, 6, 4);
        let answers = [&kept, &fresh].map(|renderer| renderer.probe(&scene, &rays, &progress));
        assert!(answers[0] == answers[1], "scene {i} is otherwise");
    }
}

/// The passes of a frame that ran, not those whose output was kept.
fn ran(renderer: &Renderer, json: &Value, view: &View) -> Vec<&'static str> {
    let frame = renderer.render(&scene(json), view, &Progress::default()).unwrap();
    frame.timings.iter().filter(|lap| !lap.is_reused).map(|lap| lap.pass).collect()
}

/// A change runs the passes that depend on it and no others: colours and exposure what puts the picture
/// together, fog no tracing, a moved lamp no tracing either, a moved camera nothing around the lamps.
#[test]
fn a_change_runs_what_depends_on_it() {
    for (airlight, quality) in
        [("auto", Quality::Full), ("auto", Quality::Draft), ("fogshop2007", Quality::Full)]
    {
        let renderer = Renderer::default();
        let view =
            View { for_screen: true, samples: Some(4), ..view(64, 48, Layer::Beauty, quality) };
        let mut json = lamps(2);
        json["fog"]["airlight"] = json!(airlight);
        let first = ran(&renderer, &json, &view);
        assert!(first.contains(&"surfaces") && first.contains(&"light_depth"), "{first:?}");
        let alone = ["prepare", "composite"];
        assert_eq!(ran(&renderer, &json, &view), alone, "nothing changed");
        assert_eq!(ran(&renderer, &json, &View { exposure_ev: 1.0, ..view }), alone);
        json["lights"][1]["intensity"] = json!([1, 20, 300]);
        json["fog"]["albedo"] = json!([0.9, 0.5, 0.7]);
        json["fog"]["ambient"] = json!([0.1, 0.2, 0.3]);
        assert_eq!(ran(&renderer, &json, &view), alone, "colours");
        json["fog"]["terms"][0]["extinction"] = json!(0.03);
        let fogged = ran(&renderer, &json, &view);
        assert!(!fogged.contains(&"surfaces") && fogged.len() > 2, "{fogged:?}");
        json["camera"]["position"] = json!([0.2, 1, 9]);
        let moved = ran(&renderer, &json, &view);
        assert!(moved.contains(&"surfaces"), "{moved:?}");
        // The published method's blobs have depths towards the eye, too.
        assert_eq!(moved.contains(&"light_depth"), airlight == "fogshop2007", "{moved:?}");
    }
}

/// Bytes of memory that this process holds.
fn resident() -> u64 {
    let text = std::fs::read_to_string("/proc/self/statm").unwrap();
    let pages: u64 = text.split(' ').nth(1).unwrap().parse().unwrap();
    4096 * pages
}

/// Drags a lamp through a scene; how much memory every so many frames take, after the first ones.
fn drag(name: &str, frames: u32, view: &View) -> Vec<u64> {
    let preset = presets::all().into_iter().find(|preset| preset.name == name).unwrap();
    let renderer = Renderer::default();
    let mut resident_at = Vec::new();
    for i in 0..frames {
        let mut moved = preset.scene.clone();
        let Light::Point(lamp) = &mut moved.lights[0] else { panic!("a lamp") };
        lamp.position.0[0] += 1e-3 * f64::from(i);
        pixels(&renderer, &moved.check().unwrap(), view);
        if i % (frames / 10) == 0 {
            resident_at.push(resident());
        }
    }
    resident_at
}

/// A lamp that is dragged past thousands of places leaves behind no more than is kept around lights.
#[test]
fn a_dragged_lamp_leaves_no_memory_behind() {
    let view = view(16, 16, Layer::Airlight, Quality::Draft);
    let at = drag("steaming-vessel", 2_000, &view);
    let grown = at[9].saturating_sub(at[0]) >> 20;
    // 128 MB of tables, and 32 of what an allocator holds back.
    assert!(grown < 160, "2000 frames leave {grown} MB: {at:?}");
}
