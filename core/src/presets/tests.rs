//! The presets keep the counts of the papers' figures, and are sound scenes.

use super::{Preset, all};
use crate::scene::{Moment, Scene, Shape, Term, read};
use glam::DVec3;
use std::collections::HashSet;

/// Name, blobs (of emitters, particles alive at a time), lights, fewest triangles, fewest vertices.
const COUNTS: [(&str, usize, usize, usize, usize); 20] = [
    ("street-thin", 0, 4, 60_000, 0),
    ("street-thick", 0, 4, 60_000, 0),
    ("steaming-vessel", 34, 3, 40_000, 70_000),
    ("terrain-292", 292, 3, 40_000, 65_000),
    ("terrain-sky", 292, 2, 40_000, 65_000),
    ("city-353", 353, 4, 40_000, 0),
    ("city-sky", 353, 1, 40_000, 0),
    ("vehicle-1223", 1223, 2, 40_000, 44_430),
    ("vehicle-sky", 1223, 1, 40_000, 44_430),
    ("room-3008", 3008, 1, 0, 8901),
    ("valley-layers", 0, 2, 21_000, 0),
    ("valley-waves", 0, 2, 21_000, 0),
    ("valley-trees", 0, 2, 21_000, 0),
    ("gorge-wind", 0, 2, 250_000, 0),
    ("fogmap-steps", 0, 2, 27_000, 0),
    ("fogmap-slopes", 0, 2, 27_000, 0),
    ("fogmap-smooth", 0, 2, 27_000, 0),
    ("in-scatter", 96, 3, 8_000, 0),
    ("nave-shafts", 60, 4, 9_000, 0),
    ("lighthouse", 48, 4, 20_000, 0),
];

fn blobs(scene: &Scene) -> usize {
    scene.fog.terms.iter().map(Term::blobs).sum()
}

fn triangles_and_vertices(scene: &Scene) -> (usize, usize) {
    let counts = scene.surfaces.iter().map(|surface| match &surface.shape {
        Shape::Mesh(mesh) => (mesh.indices.len(), mesh.positions.len()),
        Shape::Heightfield(field) => {
            let (rows, columns) = (field.heights.len(), field.heights[0].len());
            (2 * (rows - 1) * (columns - 1), rows * columns)
        }
        _ => (0, 0),
    });
    counts.fold((0, 0), |sum, one| (sum.0 + one.0, sum.1 + one.1))
}

fn json(preset: &Preset) -> String {
    serde_json::to_string(&preset.scene).unwrap()
}

#[test]
fn every_preset_has_the_counts_of_its_figure() {
    let presets = all();
    let names: Vec<_> = presets.iter().map(|preset| preset.name).collect();
    assert_eq!(names, COUNTS.map(|row| row.0), "the demo scene comes first");
    for (preset, (name, blob_count, lights, triangles, vertices)) in presets.iter().zip(COUNTS) {
        assert_eq!(blobs(&preset.scene), blob_count, "blobs of {name}");
        assert_eq!(preset.scene.lights.len(), lights, "lights of {name}");
        let (has_triangles, has_vertices) = triangles_and_vertices(&preset.scene);
        assert!(has_triangles >= triangles, "{name} has {has_triangles} triangles");
        assert!(has_vertices >= vertices, "{name} has {has_vertices} vertices");
    }
}

/// What is counted is there: at 0 s all of it, at any time up to one particle an emitter.
#[test]
fn as_many_particles_live_as_are_counted() {
    for preset in all() {
        for term in &preset.scene.fog.terms {
            let Term::Emitter(emitter) = term else { continue };
            let alive = |time_s: f64| emitter.alive(&Moment { time_s, ..Moment::default() }).len();
            assert_eq!(alive(0.0), term.blobs(), "{:?} of {}", emitter.id, preset.name);
            assert!(alive(12.34).abs_diff(term.blobs()) <= 1, "{:?}", emitter.id);
        }
    }
}

#[test]
fn names_and_titles_are_unique_and_told() {
    let presets = all();
    let names: HashSet<_> = presets.iter().map(|preset| preset.name).collect();
    let titles: HashSet<_> = presets.iter().map(|preset| preset.title).collect();
    assert_eq!((names.len(), titles.len()), (presets.len(), presets.len()));
    assert!(presets.iter().all(|preset| preset.description.len() > 40));
}

#[test]
fn every_preset_is_a_valid_scene() {
    for preset in all() {
        let name = preset.name;
        assert!(preset.scene.surfaces.iter().all(|surface| surface.id.is_some()), "{name}");
        assert!(preset.scene.lights.iter().all(|light| light.id().is_some()), "{name}");
        assert!(preset.scene.fog.terms.iter().all(|term| term.common().id.is_some()), "{name}");
        assert_eq!(preset.scene.check().err(), None, "{name}");
    }
}

#[test]
fn json_returns_the_same_scene_and_stays_small() {
    for preset in all() {
        let text = json(&preset);
        assert!(text.len() < 8_000_000, "{} takes {} bytes", preset.name, text.len());
        let again: Scene = read(text.as_bytes()).unwrap();
        assert!(again == preset.scene, "{} changes on its way through JSON", preset.name);
    }
}

#[test]
fn the_same_seeds_make_the_same_scenes() {
    for (first, second) in all().iter().zip(all().iter()) {
        assert!(first.scene == second.scene, "{} differs from itself", first.name);
    }
}

#[test]
fn normals_are_unit_and_agree_with_the_winding() {
    for preset in all() {
        for surface in &preset.scene.surfaces {
            let Shape::Mesh(mesh) = &surface.shape else { continue };
            let Some(normals) = &mesh.normals else { continue };
            assert!(normals.iter().all(|n| (n.vector().length() - 1.0).abs() < 2e-3));
            let against = mesh.indices.iter().filter(|triangle| {
                let corners = triangle.map(|k| mesh.positions[k as usize].vector());
                let against = |k: &u32, face: DVec3| face.dot(normals[*k as usize].vector()) < 0.0;
                broad_face(corners).is_some_and(|face| triangle.iter().any(|k| against(k, face)))
            });
            assert_eq!(against.count(), 0, "{:?} of {}", surface.id, preset.name);
        }
    }
}

/// The area normal of a triangle that is more than 2 mm wide: rounding positions to millimetres
/// may turn a narrower one.
fn broad_face([a, b, c]: [DVec3; 3]) -> Option<DVec3> {
    let face = (b - a).cross(c - a);
    let longest = (b - a).length().max((c - a).length()).max((c - b).length());
    (face.length() > 2e-3 * longest).then_some(face)
}
