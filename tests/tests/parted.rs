//! Cones, shadows and shafts: `auto` against the integral, and what light does at a wall.

#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test stops where it fails")]

use fogbank_core::probe::RayAnswer;
use fogbank_core::request::{Layer, ProbeRay, Quality, View};
use fogbank_tests::parted::parted;
use fogbank_tests::scenes::{pixel_rays, probe, render, scene, view};
use fogbank_tests::trials::{Use, stays_within};
use glam::DVec3;
use serde_json::{Value, json};
use std::f64::consts::PI;

/// Numbers and pictures are within half a per cent at the median and 4 % at the 95th percentile, drafts within 3 %.
#[test]
fn light_that_reaches_parts_of_the_fog_is_right() {
    for trial in parted() {
        for (wanted, height, [median, p95]) in [
            (Use::Numbers, 180, [0.005, 0.04]),
            (Use::Screen, 180, [0.005, 0.04]),
            (Use::Draft, 180, [0.03, 0.2]),
        ] {
            // A few rows of a picture see a whole street: where they meet its corners they are off.
            let p95 = if trial.name == "city" { 3.0 * p95 } else { p95 };
            stays_within(&trial, wanted, (height, 40), [median, p95]);
        }
    }
}

/// Along single rays `auto` is as near to the integral as it is without shadows.
#[test]
fn probes_through_cones_and_shadows_are_right() {
    for trial in parted() {
        let [auto, exact] = ["auto", "reference"].map(|airlight| {
            let mut json = trial.scene.clone();
            json["fog"]["airlight"] = airlight.into();
            scene(&json)
        });
        let rays = pixel_rays(&exact, 12, 9);
        let mean = |answers: &[RayAnswer]| {
            answers.iter().map(|answer| answer.airlight.0[0]).sum::<f64>() / answers.len() as f64
        };
        let (auto, exact) = (probe(&auto, &rays), probe(&exact, &rays));
        let least = 1e-3 * mean(&exact);
        for (a, b) in auto.iter().zip(&exact) {
            let (a, b) = (a.airlight.0[0], b.airlight.0[0]);
            assert!((a - b).abs() <= 5e-3 * b.max(least), "{}: {a} instead of {b}", trial.name);
        }
    }
}

fn walled(shadows: bool) -> Value {
    json!({
        "camera": { "position": [0, 1.5, 10], "target": [0, 1.5, 0] },
        "surfaces": [{ "shape": { "kind": "box", "min": [-0.1, -20, -4], "max": [0.1, 20, 20] } }],
        "lights": [{ "kind": "point", "position": [4, 1.5, 0], "intensity": [100, 100, 100], "shadows": shadows }],
        "fog": { "terms": [{ "kind": "homogeneous", "extinction": 0.05 }] },
        "far_m": 14 })
}

/// The eye in the wall sees the lit side as without shadows and the dark side dark, to 2 % of what it would be.
#[test]
fn a_wall_hides_what_is_behind_and_nothing_beside() {
    let mut lit = walled(true);
    lit["camera"]["position"] = json!([0.3, 1.5, 10]);
    lit["camera"]["target"] = json!([3, 1.5, 0]);
    let mut dark = walled(true);
    dark["camera"]["position"] = json!([-0.3, 1.5, 10]);
    dark["camera"]["target"] = json!([-4, 1.5, 4]);
    for (scene_json, is_lit) in [(lit, true), (dark, false)] {
        let mut open = scene_json.clone();
        open["lights"][0]["shadows"] = json!(false);
        for quality in [Quality::Full, Quality::Draft] {
            let view = View { for_screen: true, ..view(160, 120, Layer::Airlight, quality) };
            let (shaded, open) = (render(&scene(&scene_json), &view), render(&scene(&open), &view));
            for (a, b) in shaded.pixels.iter().zip(&open.pixels) {
                if is_lit {
                    // A draft is off by as much in either way.
                    let most = if quality == Quality::Full { 0.02 } else { 0.1 };
                    assert!(
                        (a - b).abs() <= most * b,
                        "{quality:?}: {a} beside a wall, {b} without"
                    );
                } else {
                    assert!(*a <= 0.02 * b, "{quality:?}: {a} behind a wall, {b} without");
                }
            }
        }
    }
}

/// The glow of a lamp is that of the fog around it, however far the fog goes on.
#[test]
fn a_lamp_glows_the_same_in_fog_of_any_extent() {
    let glow = |half: f64| {
        let slab = json!({ "kind": "homogeneous", "extinction": 0.1,
            "vertical": { "kind": "slab", "min_m": 1.0 - half, "max_m": 1.0 + half } });
        let json = json!({ "camera": { "position": [0, 1, 1.5], "target": [0, 1, 0] },
            "surfaces": [{ "shape": { "kind": "box", "min": [-9, -9, -2], "max": [9, 9, -1.5] } }],
            "lights": [{ "kind": "point", "position": [0.3, 1.2, 0], "intensity": [10, 10, 10] }],
            "fog": { "terms": [slab] } });
        let view = View { for_screen: true, ..view(64, 48, Layer::Airlight, Quality::Full) };
        render(&scene(&json), &view).pixels
    };
    let exact = glow(2.0);
    for half in [50.0, 5000.0] {
        for (a, b) in glow(half).iter().zip(&exact) {
            assert!((a - b).abs() <= 0.01 * b, "{half} m: {a}, but {b} in 2 m");
        }
    }
}

/// The shadow of a ball on the floor is where its cone meets the floor; around it the floor is lit as without.
#[test]
fn a_ball_throws_its_shadow_on_the_floor() {
    let json = |shadows: bool| {
        json!({ "camera": { "position": [0, 8, 0.01], "target": [0, 0, 0], "up": [0, 0, -1] },
            "surfaces": [{ "shape": { "kind": "plane" } },
                { "shape": { "kind": "sphere", "center": [1, 1, 0], "radius": 0.4 } }],
            "lights": [{ "kind": "point", "position": [0, 3, 0], "intensity": [50, 50, 50], "shadows": shadows }] })
    };
    let view = view(160, 120, Layer::Surface, Quality::Full);
    let (shaded, open) = (render(&scene(&json(true)), &view), render(&scene(&json(false)), &view));
    let rays = pixel_rays(&scene(&json(true)), 160, 120);
    let (apex, center) = (DVec3::new(0.0, 3.0, 0.0), DVec3::new(1.0, 1.0, 0.0));
    let mut dark = 0;
    for (at, ray) in rays.iter().enumerate() {
        let (a, b) = (shaded.pixels[3 * at], open.pixels[3 * at]);
        let t = -ray.origin.y / ray.direction.y;
        let point = ray.origin + t * ray.direction;
        let to_ball = center - ray.origin;
        let misses_ball = to_ball.cross(ray.direction).length() > 0.45;
        let way = (point - apex).normalize();
        let miss = (center - apex).cross(way).length();
        if !misses_ball || (miss - 0.4).abs() < 0.03 {
            continue;
        }
        if miss < 0.4 {
            dark += 1;
            assert!(a < 1e-30, "{point} is in the shadow, but has {a}");
        } else {
            assert_eq!(a, b, "{point} is not");
        }
    }
    assert!(dark > 100, "{dark}");
}

/// A picture's surfaces are lit as probes say, by all kinds of lights behind all kinds of shapes.
#[test]
fn pictures_and_probes_agree_on_shadows() {
    // The city's blobs are looked up in tables, with errors of their own.
    for trial in parted().into_iter().filter(|trial| trial.name != "city") {
        let checked = scene(&trial.scene);
        let view = view(60, 45, Layer::Surface, Quality::Full);
        let frame = render(&checked, &view);
        let answers = probe(&checked, &pixel_rays(&checked, 60, 45));
        let mut off = 0;
        for (at, answer) in answers.iter().enumerate() {
            let wanted = answer.hit.as_ref().map_or(0.0, |hit| hit.surface_radiance.0[0]);
            let found = f64::from(frame.pixels[3 * at]);
            off += u32::from((found - wanted).abs() > 1e-3 * wanted.max(1e-3));
        }
        // Rays that graze an edge may see either side of it.
        assert!(off <= 15, "{}: {off} of {} pixels", trial.name, answers.len());
    }
}

/// A lamp nearer to a floor than the points are above it that ways of light begin at still lights that floor.
#[test]
fn a_lamp_just_above_a_floor_lights_it() {
    let lit = |shadows: bool| {
        let json = json!({
            "camera": { "position": [0, 3, 8], "target": [0, 0, 0] },
            "surfaces": [
                { "shape": { "kind": "plane" } },
                { "shape": { "kind": "sphere", "center": [3, 1, 0], "radius": 0.5 } }
            ],
            "lights": [{ "kind": "point", "position": [0, 0.002, 0], "intensity": [9, 9, 9], "shadows": shadows }],
        });
        let frame = render(&scene(&json), &view(60, 45, Layer::Surface, Quality::Full));
        frame.pixels.iter().map(|value| f64::from(*value)).sum::<f64>()
    };
    // But for what the ball hides.
    let share = lit(true) / lit(false);
    assert!(share > 0.9, "{share}");
}

/// Where a light stands on a corner or within a wall, and for cones as narrow as they get, answers are numbers, and what
/// is enclosed stays dark.
#[test]
fn odd_places_of_lights_answer_numbers() {
    let wall = json!({ "shape": { "kind": "box", "min": [-1, 0, -1], "max": [1, 2, 1] } });
    let mesh = json!({ "shape": { "kind": "mesh", "positions": [[-1, 0, -2], [1, 0, -2], [0, 2, -2]], "indices": [[0, 1, 2]] } });
    let light = |kind: &str, at: [f64; 3], angle: f64| {
        let mut light = json!({ "kind": kind, "position": at, "intensity": [10, 10, 10] });
        if kind == "spot" {
            light["direction"] = json!([0.1, -0.2, 1]);
            light["inner_angle_deg"] = angle.into();
            light["outer_angle_deg"] = angle.into();
        }
        light
    };
    let enclosed = light("point", [0.2, 1.0, 0.1], 0.0);
    let lights = [
        enclosed.clone(),
        light("point", [1.0, 2.0, 1.0], 0.0),
        light("point", [0.0, 2.0, -2.0], 0.0),
        light("point", [0.0, 1.0, 5.0], 0.0),
        light("spot", [0.0, 1.0, -5.0], 1e-3),
        light("spot", [0.0, 1.0, -5.0], 0.0),
        light("spot", [0.0, 1.0, -5.0], 89.0),
    ];
    for light in lights {
        let is_enclosed = light == enclosed;
        for airlight in ["auto", "reference", "sun2005", "macklin2010", "fogshop2007"] {
            let json = json!({ "camera": { "position": [0, 1, 5], "target": [0, 1, 0] },
                "surfaces": [wall, mesh], "lights": [light], "far_m": 50,
                "fog": { "airlight": airlight, "terms": [{ "kind": "homogeneous", "extinction": 0.1 }] } });
            let checked = scene(&json);
            for quality in [Quality::Full, Quality::Draft] {
                let frame = render(
                    &checked,
                    &View { for_screen: true, ..view(32, 24, Layer::Beauty, quality) },
                );
                assert!(frame.pixels.iter().all(|v| v.is_finite() && *v >= 0.0), "{json}");
                assert!(!is_enclosed || frame.pixels.iter().all(|v| *v < 1e-4), "{json}");
            }
            let ray = ProbeRay {
                origin: DVec3::new(0.0, 1.0, 5.0),
                direction: DVec3::NEG_Z,
                max_distance_m: None,
            };
            assert!(probe(&checked, &[ray])[0].radiance.0.iter().all(|v| v.is_finite()), "{json}");
        }
    }
}

/// A spot lights a surface by the smoothstep of its cosine.
#[test]
fn a_cone_lights_a_floor_by_its_weight() {
    let json = json!({ "surfaces": [{ "shape": { "kind": "plane" } }],
        "lights": [{ "kind": "spot", "position": [0, 2, 0], "direction": [0, -1, 0], "inner_angle_deg": 20,
            "outer_angle_deg": 40, "intensity": [30, 30, 30] }] });
    for angle in [0.0f64, 19.9, 25.0, 30.0, 39.0, 41.0] {
        let x = 2.0 * angle.to_radians().tan();
        let ray = ProbeRay {
            origin: DVec3::new(x, 1.0, 0.0),
            direction: DVec3::NEG_Y,
            max_distance_m: None,
        };
        let hit = probe(&scene(&json), &[ray])[0].hit.clone().expect("the floor");
        let (low, high) = (40.0f64.to_radians().cos(), 20.0f64.to_radians().cos());
        let cosine = angle.to_radians().cos();
        let share = ((cosine - low) / (high - low)).clamp(0.0, 1.0);
        let weight = share * share * (3.0 - 2.0 * share);
        let wanted = weight * 0.5 / PI * cosine * 30.0 * (cosine / 2.0).powi(2);
        assert!((hit.surface_radiance.0[0] - wanted).abs() <= 1e-9, "{angle}: {hit:?} {wanted}");
    }
}

/// A plane between eye and light hides all of the light, in pictures as along rays: a wall, and the ground of a low sun.
#[test]
fn a_plane_hides_what_is_beyond_it() {
    let wall = json!({ "shape": { "kind": "plane", "point": [0, 0, -1], "normal": [0, 0.1, 1] } });
    let ground = json!({ "shape": { "kind": "plane" } });
    let lamp = json!({ "kind": "point", "position": [0.5, 1, -3], "intensity": [50, 50, 50] });
    let low_sun = json!({ "kind": "sun", "direction": [0.3, 0.2, 1], "irradiance": [5, 5, 5] });
    for (surface, light) in [(wall, lamp), (ground, low_sun)] {
        for projection in
            [json!({ "kind": "perspective" }), json!({ "kind": "orthographic", "height_m": 1.5 })]
        {
            for airlight in ["auto", "sun2005", "macklin2010", "fogshop2007", "reference"] {
                let json = json!({ "camera": { "position": [0, 1, 5], "target": [0, 0.9, 0], "projection": projection },
                    "surfaces": [surface], "lights": [light], "far_m": 50,
                    "fog": { "airlight": airlight, "terms": [{ "kind": "homogeneous", "extinction": 0.1 }] } });
                let view =
                    View { for_screen: true, ..view(24, 16, Layer::Airlight, Quality::Full) };
                let most = render(&scene(&json), &view).pixels.into_iter().fold(0.0, f32::max);
                assert!(most < 1e-4, "{most}: {json}");
            }
        }
    }
}

/// An eye in a spot's lamp sees its light where it looks into the cone, and none beside it.
#[test]
fn a_ray_through_a_spot_has_the_weight_of_its_direction() {
    let airlight = |airlight: &str, direction: DVec3| {
        let json = json!({ "lights": [{ "kind": "spot", "position": [0, 0, 0], "direction": [0, -1, 0],
                "inner_angle_deg": 30, "outer_angle_deg": 30, "intensity": [1, 1, 1] }],
            "fog": { "airlight": airlight, "terms": [{ "kind": "homogeneous", "extinction": 0.1 }] } });
        let ray = ProbeRay { origin: DVec3::ZERO, direction, max_distance_m: Some(5.0) };
        probe(&scene(&json), &[ray])[0].airlight.0[0]
    };
    for method in ["auto", "sun2005", "macklin2010", "reference"] {
        for degrees in [0.0f64, 20.0, 40.0, 90.0, 135.0, 180.0] {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            let found = airlight(method, DVec3::new(sine, -cosine, 0.0));
            // Within the micrometre that a ray keeps from a lamp it passes all directions.
            assert_eq!(found > 1e-9, degrees < 30.0, "{method} at {degrees}: {found}");
            assert!(found.is_finite());
        }
    }
}

/// Octaves add single scattering of thinner fog, whatever their factors: with factors of 1 each is the fog itself.
#[test]
fn octaves_add_single_scattering_of_thinner_fog() {
    let json = |octaves: u32, factor: f64, extinction: f64| {
        json!({ "camera": { "position": [0, 0, 6], "target": [0, 0, 0] },
            "lights": [{ "kind": "point", "position": [1, 1, 0], "intensity": [9, 8, 7] }], "far_m": 20,
            "fog": { "phase": { "kind": "henyey_greenstein", "g": 0.4 },
                "multiple_scattering": { "octaves": octaves, "attenuation": factor, "contribution": factor, "phase": 1 },
                "terms": [{ "kind": "homogeneous", "extinction": [extinction, 2.0 * extinction, extinction] },
                    { "kind": "gaussians", "blobs": [{ "radius": 2, "extinction": extinction }] }] } })
    };
    let view = View { for_screen: true, ..view(24, 18, Layer::Airlight, Quality::Full) };
    let picture = |json: Value| render(&scene(&json), &view).pixels;
    let (once, thrice) = (picture(json(0, 1.0, 0.2)), picture(json(2, 1.0, 0.2)));
    let (halves, thin) = (picture(json(1, 0.5, 0.2)), picture(json(0, 1.0, 0.1)));
    for i in 0..once.len() {
        assert!((thrice[i] - 3.0 * once[i]).abs() <= 1e-4 * thrice[i], "{} {}", thrice[i], once[i]);
        let sum = once[i] + thin[i];
        assert!((halves[i] - sum).abs() <= 1e-2 * sum, "{} {sum}", halves[i]);
    }
    let rays = pixel_rays(&scene(&json(2, 0.5, 0.2)), 24, 18);
    let probes = probe(&scene(&json(2, 0.5, 0.2)), &rays);
    for (pixel, answer) in picture(json(2, 0.5, 0.2)).chunks(3).zip(&probes) {
        for (found, wanted) in pixel.iter().zip(answer.airlight.0) {
            assert!((f64::from(*found) - wanted).abs() <= 0.02 * wanted, "{found} {wanted}");
        }
    }
}

/// Numbers after a picture for the eye are what they are without it: rims are softened for the eye alone.
#[test]
fn a_softened_picture_leaves_numbers_as_they_are() {
    let trial = parted().remove(3);
    let checked = scene(&trial.scene);
    let numbers = view(80, 60, Layer::Surface, Quality::Full);
    let eye = View { for_screen: true, ..numbers };
    let renderer = fogbank_core::Renderer::default();
    let picture = |view: &View| {
        renderer.render(&checked, view, &fogbank_core::Progress::default()).unwrap().pixels
    };
    let (shown, after) = (picture(&eye), picture(&numbers));
    assert_eq!(after, render(&checked, &numbers).pixels);
    assert_ne!(shown, after, "nothing is softened");
}
