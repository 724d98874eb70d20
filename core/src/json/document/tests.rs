use super::*;
use crate::presets;
use crate::random::Random;
use crate::scene::{Blob, Scene, Shape, Term};
use json_patch::jsonptr::PointerBuf;
use proptest::prelude::*;
use serde_json::{Value, json};

fn patched(scene: &Scene, patch: Value) -> Result<Scene, Vec<crate::json::Problem>> {
    let patch: Patch = serde_json::from_str(&patch.to_string()).unwrap();
    let mut node = Node::kept(scene);
    patch.apply(&mut node).map_err(|problem| vec![problem])?;
    closed(node)
}

fn city() -> Scene {
    presets::all().into_iter().find(|preset| preset.name == "city-353").unwrap().scene
}

/// A scene of every kind of term and of several surfaces and lights, small enough to be looked at as text.
fn small() -> Scene {
    let terms: Vec<Value> = crate::media::KINDS
        .iter()
        .flat_map(|(_, _, terms)| serde_json::from_str::<Vec<Value>>(terms).unwrap())
        .collect();
    let scene = json!({
        "surfaces": [
            {}, {"shape": {"kind": "sphere"}},
            {"shape": {"kind": "mesh", "positions": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "indices": [[0, 1, 2]]}},
            {"shape": {"kind": "heightfield"}, "material": {"diffuse": [0.1, 0.2, 0.3]}},
        ],
        "lights": [{"kind": "point"}, {"kind": "sun"}],
        "fog": {"terms": terms},
    });
    crate::json::read(scene.to_string().as_bytes()).unwrap()
}

/// Another scene, a few random changes away.
fn changed(scene: &Scene, random: &mut Random) -> Scene {
    let mut scene = scene.clone();
    let mut below = |count: usize| random.between(0.0, count as f64) as usize;
    for _ in 0..1 + below(4) {
        match below(8) {
            0 => scene.far_m = 1.0 + below(1000) as f64,
            1 => {
                scene.surfaces.remove(below(scene.surfaces.len()));
                scene.surfaces.push(small().surfaces.remove(2));
            }
            2 => scene.lights.reverse(),
            3 => scene.fog.terms.swap(0, 1),
            4 => scene.fog.albedo.0[1] = 0.5,
            5 => scene.surfaces[1].material.diffuse.0[0] = below(10) as f64 / 10.0,
            _ => {
                for term in &mut scene.fog.terms {
                    match term {
                        Term::Gaussians(gaussians) => {
                            let count = gaussians.blobs.len();
                            gaussians.blobs.insert(below(count + 1), Blob::default());
                            for _ in 0..below(3) {
                                gaussians.blobs.remove(below(count));
                            }
                        }
                        Term::Fogmap(map) => map.coefficients[0][1] = below(100) as f64 / 100.0,
                        Term::Emitter(emitter) => emitter.id = Some(format!("e{}", below(9))),
                        _ => {}
                    }
                }
            }
        }
    }
    scene
}

proptest! {
    /// The difference leads there, by this implementation and by another one; and back.
    #[test]
    fn a_difference_leads_from_one_scene_to_the_other(seed: u64) {
        let before = small();
        let after = changed(&before, &mut Random::new(seed));
        for (from, to) in [(&before, &after), (&after, &before)] {
            let patch = value(&difference(from, to));
            prop_assert_eq!(&patched(from, patch.clone()).unwrap(), to);
            let mut document = value(from);
            let patch: json_patch::Patch = serde_json::from_value(patch).unwrap();
            json_patch::patch(&mut document, &patch).unwrap();
            prop_assert_eq!(document, value(to));
        }
    }

    /// Random operations change a document as another implementation does, and fail where it fails.
    #[test]
    fn operations_are_those_of_the_rfc(seed: u64) {
        let mut random = Random::new(seed);
        let (mut node, mut document) = (Node::kept(&small()), value(&small()));
        for _ in 0..12 {
            let patch = operation(&document, &mut random);
            let other: json_patch::Patch = serde_json::from_value(patch.clone()).unwrap();
            let own: Patch = serde_json::from_str(&patch.to_string()).unwrap();
            let mut trial = node.clone();
            let applied = own.apply(&mut trial).is_ok();
            let mut others = document.clone();
            prop_assert_eq!(applied, json_patch::patch(&mut others, &other).is_ok(), "{}", patch);
            if applied {
                (node, document) = (trial, others);
            }
            prop_assert_eq!(node.clone().into_value(), document.clone(), "{}", patch);
        }
    }

    #[test]
    fn merging_is_that_of_the_rfc(seed: u64) {
        let mut random = Random::new(seed);
        let mut document = value(&small());
        let mut node = Node::kept(&small());
        let mut patch = Value::Null;
        for _ in 0..3 {
            let pointer = pointer(&document, &mut random);
            let change = if random.chance(0.3) { Value::Null } else { json!({"a": [1], "b": null}) };
            json_patch::merge(&mut patch, &around(&pointer, change));
        }
        json_patch::merge(&mut document, &patch);
        node.merge(patch);
        prop_assert_eq!(node.into_value(), document);
    }
}

/// A patch of one operation, most of which can be done.
fn operation(document: &Value, random: &mut Random) -> Value {
    let (path, from) = (pointer(document, random), pointer(document, random));
    let there = document.pointer(&path).cloned().unwrap_or_default();
    let operation = match random.between(0.0, 7.0) as usize {
        0 => json!({"op": "add", "path": path, "value": {"a": 1}}),
        1 => json!({"op": "remove", "path": path}),
        2 => json!({"op": "replace", "path": path, "value": [1, {"b": 2}]}),
        3 => json!({"op": "move", "path": path, "from": from}),
        4 => json!({"op": "copy", "path": path, "from": from}),
        5 => json!({"op": "test", "path": path, "value": there}),
        _ => json!({"op": "test", "path": path, "value": 7}),
    };
    json!([operation])
}

/// A pointer to something, or just beside it.
fn pointer(document: &Value, random: &mut Random) -> String {
    let mut pointer = PointerBuf::new();
    let mut at = document;
    let depth = 1 + random.between(0.0, 6.0) as usize;
    for _ in 0..depth {
        let tokens: Vec<String> = match at {
            Value::Object(members) => members.keys().cloned().chain(["~/new".into()]).collect(),
            Value::Array(items) => {
                (0..=items.len()).map(|i| i.to_string()).chain(["-".into(), "01".into()]).collect()
            }
            _ => break,
        };
        let token = &tokens[random.between(0.0, tokens.len() as f64) as usize];
        pointer.push_back(token.as_str());
        let Some(below) = document.pointer(pointer.as_str()) else { break };
        at = below;
    }
    pointer.to_string()
}

/// An object in which a pointer leads to `value`.
fn around(pointer: &str, value: Value) -> Value {
    let tokens =
        pointer.split('/').skip(1).map(|token| token.replace("~1", "/").replace("~0", "~"));
    tokens.collect::<Vec<_>>().into_iter().rev().fold(value, |value, token| json!({ token: value }))
}

#[test]
fn what_no_pointer_leads_into_stays_the_same_in_memory() {
    let before = city();
    let patch = json!([
        {"op": "remove", "path": "/fog/terms/0/id"},
        {"op": "replace", "path": "/surfaces/0/material/diffuse", "value": [0, 0, 1]},
    ]);
    let after = patched(&before, patch).unwrap();
    let positions = |scene: &Scene| -> Vec<_> {
        let meshes = scene.surfaces.iter().filter_map(|surface| match &surface.shape {
            Shape::Mesh(mesh) => Some(mesh.positions.as_ptr()),
            _ => None,
        });
        meshes.collect()
    };
    assert!(!positions(&before).is_empty());
    assert_eq!(positions(&before), positions(&after));
    assert!(serde_json::to_string(&difference(&before, &after)).unwrap().len() < 300);
}

#[test]
fn a_default_that_was_filled_in_is_part_of_the_difference() {
    let before = Scene::default();
    let after =
        patched(&before, json!([{"op": "add", "path": "/lights/-", "value": {"kind": "point"}}]));
    let after = after.unwrap();
    let patch = value(&difference(&before, &after));
    assert_eq!(patch[0]["path"], "/lights/0");
    assert_eq!(patch[0]["value"], value(&after.lights[0]));
    // What is taken away from it comes back as the default.
    let far = patched(&after, json!([{"op": "remove", "path": "/far_m"}])).unwrap();
    assert_eq!(value(&difference(&after, &far)), json!([]));
}

#[test]
fn what_is_wrong_is_told_with_its_place() {
    let place = |patch| patched(&small(), patch).unwrap_err()[0].pointer.clone();
    let remove = json!({"op": "remove", "path": "/lights/1"});
    assert_eq!(place(json!([remove, remove])), "/1/path");
    assert_eq!(place(json!([{"op": "copy", "from": "/lights/01", "path": "/a"}])), "/0/from");
    assert_eq!(place(json!([{"op": "add", "path": "lights", "value": 1}])), "/0/path");
    assert_eq!(place(json!([{"op": "add", "path": "/~2", "value": 1}])), "/0/path");
    assert_eq!(place(json!([{"op": "test", "path": "/far_m", "value": 1}])), "/0/value");
    let in_scene = json!([{"op": "add", "path": "/fog/terms/0/id", "value": 7}]);
    assert_eq!(place(in_scene), "/fog/terms/0/id");
    let in_list = json!([{"op": "add", "path": "/fog/terms/-", "value": {"kind": "none"}}]);
    assert!(place(in_list).ends_with("/kind"));
    assert_eq!(place(json!([{"op": "replace", "path": "/surfaces", "value": {}}])), "/surfaces");
}

/// Copies of copies double a document with every operation: 10 000 of them must end early, and no
/// recursion may be as deep as a client likes.
#[test]
fn copies_are_bounded() {
    let double = json!({"op": "copy", "from": "", "path": "/a"});
    let problem = patched(&small(), Value::Array(vec![double; 10_000])).unwrap_err().remove(0);
    assert_eq!(problem.code, crate::json::Code::TooMany);
    let wide = json!({"op": "copy", "from": "/surfaces", "path": "/surfaces/0"});
    let wide = Value::Array(vec![wide; 200]);
    assert!(patched(&small(), wide).is_err());
    let long = json!([{"op": "add", "path": "/a".repeat(100_000), "value": 1}]);
    assert!(patched(&small(), long).is_err());
}
