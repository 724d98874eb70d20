//! `auto` on what a newcomer types: haze, a few blobs, a lamp, and an open sky.

use fogbank_core::presets;
use fogbank_tests::everyday::{Exact, SCENES, Seen, everyday};
use fogbank_tests::trials::Use;
use serde_json::json;

/// Pictures are small, so that every pixel of all scenes can be compared.
const HEIGHT: u32 = 60;

#[test]
fn pictures_under_an_open_sky_have_no_steps() {
    for number in 0..SCENES {
        let exact = Exact::new(&everyday(number), HEIGHT);
        // A step of 1 % is the least that the eye tells from none. For the eye the last thousandth of the blobs' depth in
        // clear air is not looked at closely: there is a step in what is a hundredth as bright as the rest.
        for (wanted, most) in [(Use::Numbers, 0.01), (Use::Screen, 0.15)] {
            let Seen { errors: [median, p95, _], step } = exact.measure(wanted);
            let what =
                format!("scene {number}, {wanted:?}: median {median}, p95 {p95}, step {step}");
            assert!(step <= most && median <= 0.003 && p95 <= 0.03, "{what}");
        }
    }
}

/// What pictures are held against is held against the integral.
#[test]
fn probes_under_an_open_sky_are_right() {
    for number in 0..SCENES {
        let [median, p95, most] = Exact::new(&everyday(number), 24).of_probes(12);
        // The rules that a probe compares differ by 1e-4 at most.
        let what = format!("scene {number}: median {median}, p95 {p95}, most {most}");
        assert!(median <= 1e-4 && most <= 2e-3, "{what}");
    }
}

/// Smoke that is a few pixels wide in a picture smaller than a block of the grid is all there.
#[test]
fn thumbnails_show_the_smoke() {
    let vessel = presets::all().into_iter().find(|preset| preset.name == "steaming-vessel");
    let exact = Exact::new(&json!(vessel.expect("a preset").scene), 17);
    for (wanted, at_half, at_most) in [(Use::Screen, 0.003, 0.03), (Use::Draft, 0.01, 0.05)] {
        let Seen { errors: [median, p95, _], .. } = exact.measure(wanted);
        assert!(median <= at_half && p95 <= at_most, "{wanted:?}: median {median}, p95 {p95}");
    }
}

/// A ball close to the eye before bright fog, a post before a far wall: a pixel on either side of a silhouette has the
/// airlight of its own ray, not a mean with its neighbour's, which may be twenty times as bright.
#[test]
fn silhouettes_have_no_halo() {
    let json = json!({
        "camera": { "position": [0, 1.2, 6], "target": [0, 1.2, 0] },
        "surfaces": [
            { "shape": { "kind": "plane" } },
            { "shape": { "kind": "sphere", "center": [-0.6, 1.3, 3.5], "radius": 0.6 } },
            { "shape": { "kind": "box", "min": [0.5, 0, 3.9], "max": [0.6, 3, 4] } },
            { "shape": { "kind": "box", "min": [-30, 0, -40], "max": [30, 30, -39] } },
        ],
        "lights": [
            { "kind": "point", "position": [-1.5, 2, -2], "intensity": [20, 20, 20], "shadows": false },
            { "kind": "point", "position": [0.9, 1.5, -1], "intensity": [9, 9, 9], "shadows": false },
        ],
        "fog": { "terms": [
            { "kind": "homogeneous", "extinction": 0.02 },
            { "kind": "gaussians", "blobs": [
                { "center": [-0.5, 1.5, -2], "radius": 1.5, "extinction": 0.3 },
                { "center": [1.5, 1, -6], "radius": 2.5, "extinction": 0.2 },
            ] },
        ] },
        "far_m": 500,
    });
    let exact = Exact::new(&json, 150);
    let places = exact.at_silhouettes();
    assert!(places.len() > 500, "{} pixels", places.len());
    // As everywhere: a full picture within 3 %, a draft within 5 % but for a few.
    for (wanted, most, mean) in [(Use::Screen, 0.03, 0.002), (Use::Draft, 0.06, 0.01)] {
        let errors = exact.signed_errors(wanted);
        let at: Vec<_> = places.iter().map(|at| errors[*at]).collect();
        let worst = at.iter().fold(0.0f64, |most, error| most.max(error.abs()));
        let halo = at.iter().sum::<f64>() / at.len() as f64;
        assert!(worst <= most && halo.abs() <= mean, "{wanted:?}: worst {worst}, mean {halo}");
    }
}
