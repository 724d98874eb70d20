//! Laws of the edits.

use super::*;
use crate::json::document::{Node, Patch, closed, difference};
use crate::presets;
use crate::random::Random;
use crate::scene::{Blob, Shape, Term, Vec3};
use glam::DVec3;
use proptest::prelude::*;
use serde_json::{Value, json};

fn scene(value: &Value) -> CheckedScene {
    let mut scene = crate::json::read::<Scene>(value.to_string().as_bytes()).unwrap();
    // As a stored scene is: an edit gives an id to what has none.
    scene.name_all();
    scene.check().unwrap()
}

/// A floor, a map, an emitter and some blobs.
fn stage() -> CheckedScene {
    let blob = |i: usize| json!({"center": [i as f64 * 0.7 - 3.0, 1.0 / 3.0, 0.1], "radius": 0.5});
    scene(&json!({
        "surfaces": [{"id": "floor"}, {"shape": {"kind": "sphere", "center": [0, 1, 0]}}],
        "lights": [{"kind": "point"}],
        "fog": {"terms": [
            {"id": "smoke", "kind": "gaussians", "blobs": (0..9).map(blob).collect::<Vec<_>>()},
            {"id": "map", "kind": "fogmap", "degree": 2},
            {"id": "chimney", "kind": "emitter"},
            {"kind": "homogeneous"},
        ]},
    }))
}

struct Hand {
    strokes: Strokes,
    progress: Progress,
}

impl Hand {
    fn new() -> Self {
        Self { strokes: Strokes::default(), progress: Progress::default() }
    }

    fn try_edit(&mut self, scene: &CheckedScene, edits: Value) -> Result<CheckedScene, Refusal> {
        let edits: Vec<Edit> = crate::json::read(edits.to_string().as_bytes()).unwrap();
        let mut checker = Checker::default();
        check(&edits, &mut checker);
        checker.finish(()).map_err(Refusal::Invalid)?;
        let surfaces = |scene: &CheckedScene| {
            Geometry::build(&scene.surfaces, &Progress::default()).map(Arc::new)
        };
        let mut desk =
            Desk { surfaces: &surfaces, strokes: &mut self.strokes, progress: &self.progress };
        apply(scene, &edits, &mut desk)
    }

    fn edit(&mut self, scene: &CheckedScene, edits: Value) -> CheckedScene {
        self.try_edit(scene, edits).unwrap()
    }
}

fn edit(scene: &CheckedScene, edit: Value) -> CheckedScene {
    Hand::new().edit(scene, json!([edit]))
}

fn problem(scene: &CheckedScene, edits: Value) -> (String, Code) {
    match Hand::new().try_edit(scene, edits) {
        Err(Refusal::Invalid(problems)) => (problems[0].pointer.clone(), problems[0].code),
        other => panic!("{other:?}"),
    }
}

fn blobs(scene: &Scene) -> &[Blob] {
    let found = scene.fog.terms.iter().find_map(|term| match term {
        Term::Gaussians(gaussians) => Some(&gaussians.blobs),
        _ => None,
    });
    found.map_or(&[], |blobs| blobs)
}

/// One of every kind of edit, with numbers of a hand.
fn any_edit(random: &mut Random) -> Value {
    let point =
        |r: &mut Random| json!([r.between(-3.0, 3.0), r.between(0.0, 2.0), r.between(-2.0, 2.0)]);
    let points =
        |r: &mut Random| json!([point(r), point(r), {"position": point(r), "pressure": r.unit()}]);
    let seed = (random.unit() * 1e6) as u32;
    match random.between(0.0, 14.0) as u32 {
        0 => {
            json!({"op": "paint_stroke", "points": points(random), "radius": 0.3, "extinction": 0.4,
            "seed": seed})
        }
        1 => json!({"op": "paint_stroke", "points": points(random), "radius": 0.3,
            "extinction": [0.1, 0.2, 0.3], "plane": "surfaces", "term": "smoke", "seed": seed}),
        2 => json!({"op": "paint_stroke", "points": points(random), "radius": 0.7, "extinction": 1,
            "plane": {"point": [0, 1, 0], "normal": [1, 2, 0]}, "spacing": 0.2, "jitter": 0.5}),
        3 => {
            json!({"op": "erase", "points": points(random), "radius": 1, "strength": random.unit()})
        }
        4 => json!({"op": "copy", "term": "smoke", "blobs": [1, 3, 8], "offset": point(random)}),
        5 => json!({"op": "move", "term": 0, "blobs": [7, 0, 7], "offset": point(random)}),
        6 => json!({"op": "delete", "term": "smoke", "blobs": [4, 5, 0]}),
        7 => {
            json!({"op": "emitter_add", "emitter": {"kind": "emitter", "position": point(random)}})
        }
        8 => {
            json!({"op": "emitter_update", "term": "chimney", "changes": {"rate_hz": random.unit()}})
        }
        9 => json!({"op": "emitter_remove", "term": "chimney"}),
        10 => {
            json!({"op": "airbrush", "position": [0, 3, 0], "rate_hz": 20, "duration_s": 0.5, "speed": 2,
            "diffusion_m2_per_s": 0.1, "radius": 0.2, "extinction": 1, "seed": seed})
        }
        11 => {
            json!({"op": "simulate", "term": "smoke", "duration_s": 0.4, "acceleration": [0, -9.81, 0],
            "diffusion_m2_per_s": 0.2, "seed": seed})
        }
        12 => json!({"op": "fogmap_paint", "term": "map", "points": points(random), "radius": 2,
            "delta": random.between(-0.5, 0.5)}),
        _ => json!({"op": "patch", "patch": [
            {"op": "replace", "path": "/lights/0/position", "value": point(random)},
            {"op": "copy", "from": "/surfaces/1", "path": "/surfaces/0"},
            {"op": "add", "path": "/surfaces/0/id", "value": "copy"},
            {"op": "replace", "path": "/surfaces/0/material/emission", "value": [0, random.unit(), 0]},
        ]}),
    }
}

fn patched(scene: &Scene, patch: &Patch) -> Scene {
    let text = serde_json::to_string(patch).unwrap();
    let mut document = Node::kept(scene);
    serde_json::from_str::<Patch>(&text).unwrap().apply(&mut document).unwrap();
    closed(document).unwrap()
}

fn text(scene: &Scene) -> String {
    serde_json::to_string(scene).unwrap()
}

proptest! {
    /// What an edit did is undone and done again by the patches that say what it changed, to the last byte of
    /// the scene's text.
    #[test]
    fn an_edit_is_undone_to_the_last_byte(seed: u64) {
        let mut random = Random::new(seed);
        let before = Hand::new().try_edit(&stage(), json!([any_edit(&mut random)])).unwrap_or(stage());
        let Ok(after) = Hand::new().try_edit(&before, json!([any_edit(&mut random)])) else {
            return Ok(());
        };
        let undone = patched(&after, &difference(&*after, &*before));
        prop_assert_eq!(text(&undone), text(&before));
        prop_assert_eq!(text(&patched(&undone, &difference(&*before, &*after))), text(&after));
    }

    /// A stroke gives the same blobs however its points are split into calls, and however many points say the same
    /// line.
    #[test]
    fn a_stroke_does_not_depend_on_how_it_is_cut(seed: u64) {
        let mut random = Random::new(seed);
        let corner = |r: &mut Random| DVec3::new(r.between(-3.0, 3.0), r.between(0.0, 3.0), r.unit());
        let corners: Vec<_> = (0..4).map(|_| corner(&mut random)).collect();
        let mut fine = vec![corners[0]];
        for pair in corners.windows(2) {
            let cuts = 1 + random.between(0.0, 5.0) as usize;
            fine.extend((1..=cuts).map(|i| pair[0].lerp(pair[1], i as f64 / cuts as f64)));
        }
        let stroke = |points: &[DVec3]| {
            let points: Vec<_> = points.iter().map(|p| p.to_array()).collect();
            json!({"op": "paint_stroke", "points": points, "radius": 0.21, "extinction": 1, "seed": 5,
                "stroke": "s"})
        };
        let whole = edit(&scene(&json!({})), stroke(&corners));
        let mut hand = Hand::new();
        let mut cut = scene(&json!({}));
        let mut rest = fine.as_slice();
        while !rest.is_empty() {
            let (now, later) = rest.split_at(1 + random.between(0.0, rest.len() as f64) as usize);
            cut = hand.edit(&cut, json!([stroke(now)]));
            rest = later;
        }
        // A dab that is due just at a corner may come a rounding later: by the last one they differ then.
        let (whole, cut) = (blobs(&whole), blobs(&cut));
        prop_assert!(whole.len().abs_diff(cut.len()) <= 1);
        for (a, b) in whole.iter().zip(cut) {
            let apart = a.center.vector().distance(b.center.vector());
            // Places are rounded to 1e-4; next to a corner its two sides differ in what is across.
            prop_assert!(apart < 1e-3 || apart < 2.0 * 0.21, "{apart}");
        }
        let near = whole.iter().zip(cut).filter(|(a, b)| {
            a.center.vector().distance(b.center.vector()) < 1e-3
        });
        prop_assert!(near.count() + 4 >= whole.len().min(cut.len()));
    }

    /// Particles never leave a closed room: boxes and meshes seen from inside, at any speed.
    #[test]
    fn the_airbrush_stays_in_a_closed_room(seed: u64) {
        let mut random = Random::new(seed);
        let half = DVec3::new(random.between(0.5, 3.0), random.between(0.5, 3.0), random.between(0.5, 3.0));
        let far = random.between(-1e4, 1e4);
        let center = DVec3::new(far, 0.0, -far);
        let (min, max) = (center - half, center + half);
        let is_mesh = random.chance(0.5);
        let room = if is_mesh { as_mesh(min, max) } else {
            json!({"kind": "box", "min": min.to_array(), "max": max.to_array()})
        };
        let scene = scene(&json!({"surfaces": [{"shape": room}]}));
        let after = edit(&scene, json!({"op": "airbrush", "position": center.to_array(), "rate_hz": 40,
            "duration_s": 1.0, "speed": random.between(0.0, 30.0),
            "diffusion_m2_per_s": random.between(0.0, 3.0), "radius": 0.01, "extinction": 1,
            "seed": (random.unit() * 1e9) as u32}));
        prop_assert_eq!(blobs(&after).len(), 40);
        // The walls are kept in f32, and places are rounded to 1e-5.
        let slack = 1e-3;
        for blob in blobs(&after) {
            let at = blob.center.vector();
            prop_assert!(at.cmpge(min - slack).all() && at.cmple(max + slack).all(), "{at} {min} {max}");
        }
    }
}

fn as_mesh(min: DVec3, max: DVec3) -> Value {
    let corner = |i: u32| {
        let pick = |bit: u32, a: f64, b: f64| if i >> bit & 1 == 0 { a } else { b };
        [pick(0, min.x, max.x), pick(1, min.y, max.y), pick(2, min.z, max.z)]
    };
    let faces =
        [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
    let indices: Vec<_> =
        faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    json!({"kind": "mesh", "positions": (0..8).map(corner).collect::<Vec<_>>(), "indices": indices})
}

/// A ball of triangles, filled from inside and taken away, leaves fog of its shape.
#[test]
fn a_mesh_that_is_filled_with_fog_leaves_its_shape() {
    let (rings, around) = (16, 32);
    let angle = |i: u32, n: u32| f64::from(i) / f64::from(n) * std::f64::consts::TAU;
    let place = |j: u32, i: u32| {
        let (sin, cos) = (0.5 * angle(j, rings)).sin_cos();
        let (s, c) = angle(i % around, around).sin_cos();
        [sin * c, cos + 2.0, sin * s]
    };
    let positions: Vec<_> =
        (0..=rings).flat_map(|j| (0..around).map(move |i| place(j, i))).collect();
    let at = |j: u32, i: u32| j * around + i % around;
    let quads = (0..rings).flat_map(|j| (0..around).map(move |i| (j, i)));
    let indices: Vec<_> = quads
        .flat_map(|(j, i)| {
            [[at(j, i), at(j, i + 1), at(j + 1, i)], [at(j + 1, i), at(j, i + 1), at(j + 1, i + 1)]]
        })
        .collect();
    let ball = json!({"kind": "mesh", "positions": positions, "indices": indices});
    let scene = scene(&json!({"surfaces": [{"shape": ball}]}));
    let spray = json!({"op": "airbrush", "position": [0, 2, 0], "rate_hz": 400, "duration_s": 5, "speed": 0.5,
        "diffusion_m2_per_s": 0.3, "radius": 0.1, "extinction": 2});
    let hide = json!({"op": "patch", "patch": [{"op": "replace", "path": "/surfaces/0/enabled", "value": false}]});
    let after = Hand::new().edit(&scene, json!([spray, hide]));
    let from_middle: Vec<_> = blobs(&after)
        .iter()
        .map(|blob| blob.center.vector().distance(DVec3::new(0.0, 2.0, 0.0)))
        .collect();
    let inside = from_middle.iter().filter(|distance| **distance < 1.0).count();
    assert_eq!(from_middle.len(), 2000);
    assert!(inside * 100 >= 95 * from_middle.len(), "{inside}");
    // And they fill it: a ball's outer half by radius holds seven eighths of it.
    let outer = from_middle.iter().filter(|distance| **distance > 0.5).count();
    assert!(outer > 1500, "{outer}");
}

/// In open air particles that diffuse are √(6 D t) away in the mean square.
#[test]
fn particles_spread_as_diffusion_does() {
    let scene = scene(&json!({"fog": {"terms": [{"kind": "gaussians",
        "blobs": vec![json!({"radius": 0.01}); 4000]}]}}));
    for duration in [0.1, 2.0] {
        let after = edit(
            &scene,
            json!({"op": "simulate", "term": 0, "duration_s": duration,
            "diffusion_m2_per_s": 0.3}),
        );
        let squares = blobs(&after).iter().map(|blob| blob.center.vector().length_squared());
        let mean = squares.sum::<f64>() / 4000.0;
        // Of 4000 samples, three standard deviations are 4 %.
        assert!((mean / (6.0 * 0.3 * duration) - 1.0).abs() < 0.04, "{mean}");
    }
}

#[test]
fn a_stroke_on_surfaces_lies_on_them_as_the_eye_sees_it() {
    // The point hangs before the ball, seen from the camera, and beside it, seen from above.
    let stroke = |eye: Value| {
        let mut stroke = json!({"op": "paint_stroke", "points": [[0, 1.2, 4]], "radius": 0.1, "extinction": 1,
            "plane": "surfaces"});
        if !eye.is_null() {
            stroke["eye"] = eye;
        }
        stroke
    };
    let last = |scene: &CheckedScene| blobs(scene).last().unwrap().center.vector();
    let seen = last(&edit(&stage(), stroke(Value::Null)));
    assert!((seen.distance(DVec3::Y) - 1.0).abs() < 1e-3 && seen.z > 0.0, "{seen}");
    let from_above = last(&edit(&stage(), stroke(json!([0, 100, 4]))));
    assert!(from_above.distance(DVec3::new(0.0, 0.0, 4.0)) < 1e-3, "{from_above}");
    let plane = json!({"op": "paint_stroke", "points": [[3, 5, 1]], "radius": 0.1, "extinction": 1,
        "plane": {"point": [0, 2, 0], "normal": [0, 9, 0]}});
    assert_eq!(last(&edit(&stage(), plane)), DVec3::new(3.0, 2.0, 1.0));
}

#[test]
fn the_brush_keeps_its_distance_and_its_offsets_below_a_radius() {
    let after = edit(
        &scene(&json!({})),
        json!({"op": "paint_stroke",
        "points": [[0, 0, 0], [30, 0, 0]], "radius": 0.5, "extinction": 0.2, "seed": 3}),
    );
    let blobs = blobs(&after);
    assert_eq!(blobs.len(), 81);
    let mut widest = 0.0f64;
    for (i, blob) in blobs.iter().enumerate() {
        let [x, y, z] = blob.center.0;
        // Places are rounded to a thousandth of a radius at most.
        assert!((x - 0.375 * i as f64).abs() < 1e-3, "{x}");
        widest = widest.max(y.hypot(z));
    }
    assert!(widest < 0.5 && widest > 0.4, "{widest}");
}

#[test]
fn the_eraser_thins_and_then_deletes_what_it_covers() {
    let near = |scene: &CheckedScene| -> Vec<f64> {
        let covered = blobs(scene).iter().filter(|blob| blob.center.vector().length() < 1.0);
        covered.map(|blob| blob.extinction.channels()[0]).collect()
    };
    let erase = |strength: f64| json!({"op": "erase", "points": [[0, 0, 0]], "radius": 1, "strength": strength});
    let before = stage();
    let thinned = edit(&before, erase(0.25));
    assert!(near(&before).iter().zip(near(&thinned)).all(|(a, b)| (0.75 * a - b).abs() < 1e-12));
    assert_eq!(blobs(&before).len(), blobs(&thinned).len());
    let mut fading = before.clone();
    for _ in 0..40 {
        fading = edit(&fading, erase(0.25));
    }
    assert!(near(&fading).is_empty());
    assert_eq!(fading.fog, edit(&before, erase(1.0)).fog);
    assert_eq!(blobs(&fading).len() + near(&before).len(), blobs(&before).len());
}

#[test]
fn a_map_is_raised_under_the_brush_and_never_falls_below_zero() {
    let sum = |scene: &CheckedScene| -> f64 {
        let map = scene.fog.terms.iter().find_map(|term| match term {
            Term::Fogmap(map) => Some(map),
            _ => None,
        });
        map.unwrap().coefficients.iter().flatten().sum()
    };
    let paint = |delta: f64| {
        json!({"op": "fogmap_paint", "term": "map", "points": [[0, 9, 0]], "radius": 1.5,
        "delta": delta})
    };
    let before = stage();
    assert!(sum(&edit(&before, paint(0.5))) > sum(&before) + 0.5);
    let emptied = edit(&edit(&before, paint(-100.0)), paint(-100.0));
    assert!(sum(&emptied) < sum(&before) && sum(&emptied) >= 0.0);
    let beside = json!({"op": "fogmap_paint", "term": "map", "points": [[500, 0, 0]], "radius": 1, "delta": 1});
    assert_eq!(edit(&before, beside).fog, before.fog);
}

#[test]
fn an_airbrush_that_goes_on_has_as_many_particles_and_moves_them_all() {
    let spray = |duration: f64| {
        json!([{"op": "airbrush", "position": [0, 5, 0], "rate_hz": 30,
        "duration_s": duration, "speed": 1, "radius": 0.1, "extinction": 1, "stroke": "s"}])
    };
    let mut hand = Hand::new();
    let first = hand.edit(&scene(&json!({})), spray(0.5));
    let second = hand.edit(&first, spray(1.5));
    assert_eq!((blobs(&first).len(), blobs(&second).len()), (15, 60));
    // Without diffusion each particle is as far as it had time for.
    let farthest = |scene: &CheckedScene| {
        let far = blobs(scene).iter().map(|blob| blob.center.vector().distance(DVec3::Y * 5.0));
        far.fold(0.0, f64::max)
    };
    assert!((farthest(&first) - 0.5).abs() < 1e-3 && (farthest(&second) - 2.0).abs() < 1e-3);
    // Another edit in between freezes them.
    let other = hand.edit(&second, json!([{"op": "erase", "points": [[9, 9, 9]], "radius": 0.1}]));
    let third = hand.edit(&other, spray(0.5));
    assert_eq!(blobs(&third)[..60], blobs(&second)[..]);
}

#[test]
fn all_edits_are_made_or_none() {
    let before = stage();
    let paint = json!({"op": "paint_stroke", "points": [[0, 0, 0]], "radius": 1, "extinction": 1});
    let wrong = json!({"op": "delete", "term": "smoke", "blobs": [10]});
    assert_eq!(problem(&before, json!([paint, wrong])), ("/edits/1/blobs".into(), Code::Conflict));
    let none = json!({"op": "delete", "term": "mist", "blobs": []});
    assert_eq!(problem(&before, json!([none])).0, "/edits/0/term");
    let kind = json!({"op": "delete", "term": "map", "blobs": []});
    assert_eq!(problem(&before, json!([kind])).0, "/edits/0/term");
    let empty = json!({"op": "erase", "points": [], "radius": 1});
    assert_eq!(
        problem(&before, json!([paint, empty])),
        ("/edits/1/points".into(), Code::WrongLength)
    );
    let long = json!({"op": "paint_stroke", "points": [[0, 0, 0], [1e9, 0, 0]], "radius": 1e-3, "extinction": 1});
    assert_eq!(problem(&before, json!([long])), ("/edits/0/points".into(), Code::TooMany));
    let slow = json!({"op": "simulate", "term": "smoke", "duration_s": 1e6});
    assert_eq!(problem(&before, json!([slow])).0, "/edits/0/duration_s");
    let update = json!({"op": "emitter_update", "term": "chimney", "changes": {"rate_hz": "fast"}});
    assert_eq!(problem(&before, json!([update])).0, "/edits/0/changes/rate_hz");
    let patch = json!({"op": "patch", "patch": [{"op": "remove", "path": "/nothing"}]});
    assert_eq!(problem(&before, json!([patch])).0, "/edits/0/patch/0/path");
    let invalid =
        json!({"op": "patch", "patch": [{"op": "replace", "path": "/far_m", "value": -1}]});
    assert_eq!(problem(&before, json!([invalid])), ("/scene/far_m".into(), Code::OutOfRange));
    // A fog that is negative somewhere is found although only one of its terms changed.
    let cosine = json!({"op": "patch", "patch": [{"op": "add", "path": "/fog/terms/-", "value":
        {"kind": "functions", "members": [{"kind": "cosine", "amplitude": 0.2, "wave_vector": [1, 0, 0]}]}}]});
    let haze = json!({"op": "patch", "patch": [{"op": "add", "path": "/fog/terms/-", "value":
        {"kind": "homogeneous", "extinction": 0.3, "id": "haze"}}]});
    let thin = json!({"op": "patch", "patch": [{"op": "replace", "path": "/fog/terms/4/extinction", "value": 0.1}]});
    let foggy = Hand::new().edit(&before, json!([haze, cosine]));
    assert_eq!(problem(&foggy, json!([thin])).0, "/scene/fog/terms");
}

/// Of a city, a stroke leaves everything but its own term where it is in memory.
#[test]
fn an_edit_copies_only_what_it_touches() {
    let city = presets::all().into_iter().find(|preset| preset.name == "city-353").unwrap();
    let before = city.scene.check().unwrap();
    let after = edit(
        &before,
        json!({"op": "paint_stroke", "points": [[0, 1, 0], [5, 1, 0]], "radius": 1,
        "extinction": 0.1}),
    );
    let meshes = |scene: &Scene| -> Vec<*const Vec3> {
        let meshes = scene.surfaces.iter().filter_map(|surface| match &surface.shape {
            Shape::Mesh(mesh) => Some(mesh.positions.as_ptr()),
            _ => None,
        });
        meshes.collect()
    };
    assert!(!meshes(&before).is_empty());
    assert_eq!(meshes(&before), meshes(&after));
    let patch = serde_json::to_string(&difference(&*before, &*after)).unwrap();
    assert!(patch.len() < 2000, "{}", patch.len());
}

#[test]
fn a_rectangle_selects_what_is_seen_in_it() {
    let select = |rectangle: [f64; 4]| {
        let request = json!({"rectangle": rectangle, "camera": {"position": [0, 1, 10], "target": [0, 1, 0]}});
        let request: SelectRequest = crate::json::read(request.to_string().as_bytes()).unwrap();
        request.check().unwrap().select(&stage())
    };
    let all = select([0.0, 0.0, 1.0, 1.0]);
    assert_eq!(all.blobs[0].blobs, (0..9).collect::<Vec<_>>());
    assert_eq!(all.lights, [Name::Id("light-1".into())]);
    assert_eq!(all.emitters, [Name::Id("chimney".into())]);
    // The left half of the picture has those left of the camera.
    let left = select([0.0, 0.0, 0.5, 1.0]);
    assert_eq!(left.blobs[0].blobs, [0, 1, 2, 3, 4]);
    assert_eq!(select([0.0, 0.0, 1.0, 0.4]).blobs, []);
}
