//! The sun: how thick the fog is that its light came through, what of it the fog scatters, and what surfaces get.

#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test stops where it fails")]

use fogbank_core::geometry::{Beyond, Origin, Ray};
use fogbank_core::light::{Light, Source};
use fogbank_core::phase::PhaseFunction;
use fogbank_core::request::ProbeRay;
use fogbank_core::scene::read;
use fogbank_tests::quadrature::integrate;
use fogbank_tests::scenes::{field, homogeneous, probe, scene};
use glam::DVec3;
use serde_json::{Value, json};
use std::f64::consts::PI;

/// How far fog without an end counts [m].
const PATH_M: f64 = 7.0;
/// Farther than any fog with an end reaches here [m].
const FAR_M: f64 = 1e4;

fn toward(direction: [f64; 3]) -> DVec3 {
    -DVec3::from(direction).normalize()
}

fn layer(vertical: Value) -> Value {
    json!({ "kind": "homogeneous", "extinction": 0.3, "vertical": vertical })
}

fn slab() -> Value {
    layer(json!({ "kind": "slab", "min_m": -1, "max_m": 2 }))
}

fn thinning() -> Value {
    layer(json!({ "kind": "exponential", "base_m": 0.5, "falloff_per_m": 0.8 }))
}

fn map(vertical: Value) -> Value {
    json!({ "kind": "fogmap", "degree": 2, "origin": [-4, -5], "cell_m": 1.5, "scale": 0.4,
        "coefficients": [[0.2, 1, 0, 0.4], [0, 0.7, 0.9, 0.1], [0.5, 0, 0.3, 0.8]],
        "vertical": vertical })
}

fn waves() -> Value {
    json!({ "kind": "functions", "members": [
        { "kind": "cosine", "amplitude": 0.3, "wave_vector": [0, 0, 0] },
        { "kind": "cosine", "amplitude": 0.2, "wave_vector": [1, 0.4, 0.7] }] })
}

fn blobs() -> Value {
    json!({ "kind": "gaussians", "blobs": [
        { "center": [0, 1, 0], "radius": 1.2, "extinction": 0.5 },
        { "center": [2, 3, 1], "radius": 0.7, "extinction": 0.9 }] })
}

/// Every medium with a direction of light, and whether it has an end towards it.
fn ways() -> Vec<(Value, [f64; 3], bool)> {
    let (slanted, down, up, level) =
        ([0.5, -0.6, 0.3], [0.0, -1.0, 0.0], [0.3, 0.5, 0.1], [1.0, 0.0, 0.2]);
    vec![
        (homogeneous(0.2), slanted, false),
        (slab(), slanted, true),
        (slab(), up, true),
        (slab(), level, false),
        (thinning(), slanted, true),
        (thinning(), up, false),
        (thinning(), level, false),
        (waves(), slanted, false),
        (blobs(), slanted, true),
        (blobs(), up, true),
        (map(json!({ "kind": "uniform" })), slanted, true),
        (map(json!({ "kind": "uniform" })), down, false),
        (map(json!({ "kind": "slab", "min_m": 0, "max_m": 2 })), down, true),
        (map(json!({ "kind": "exponential", "base_m": 0, "falloff_per_m": 1.3 })), down, true),
        (map(json!({ "kind": "exponential", "base_m": 0, "falloff_per_m": 1.3 })), slanted, true),
    ]
}

/// Light comes through a term as far as it reaches, or, where it has no end, as far as the scene says; terms add.
#[test]
fn the_sun_comes_through_what_there_is() {
    let points =
        [[0.3, 0.4, -0.2], [-2.0, 1.4, 1.0], [1.0, -3.0, 0.5], [0.5, 6.0, 0.0]].map(DVec3::from);
    for (term, direction, ends) in ways() {
        let (field, both) =
            (field(std::slice::from_ref(&term)), field(&[term.clone(), homogeneous(0.05)]));
        let beyond = Beyond { toward: toward(direction), path_m: PATH_M };
        for point in points {
            let found = field.depth_from(Origin::Beyond(beyond), point);
            let ray = Ray { origin: point, direction: beyond.toward };
            let wanted = field.depth(&ray, if ends { FAR_M } else { PATH_M });
            assert!(
                (found - wanted).abs() <= 1e-9 * wanted + 1e-12,
                "{term} {direction:?}: {found} {wanted}"
            );
            let sum = both.depth_from(Origin::Beyond(beyond), point);
            assert!((sum - found - 0.05 * PATH_M).abs() < 1e-9, "{term}: {sum} {found}");
            let ways = field.ways(Origin::Beyond(beyond), [points[0], point]);
            assert!((ways.depth_to(point) - found).abs() <= 1e-9 * found + 1e-12, "{term}");
        }
    }
}

fn sunlit(terms: &Value, direction: [f64; 3], g: f64) -> Value {
    json!({ "lights": [{ "kind": "sun", "direction": direction, "irradiance": [5, 5, 5] }],
        "fog": { "terms": terms, "light_path_m": PATH_M,
            "phase": { "kind": "henyey_greenstein", "g": g } } })
}

/// The airlight of `auto` and of `reference` is the integral of what the sun sends: its irradiance, dimmed on its way
/// and on the way to the eye, into the angle between its light and the view. `reference` is as exact as it asks
/// to be where corners of cells shade it, `auto` to what it states.
#[test]
fn sunlight_is_scattered_as_the_integral_says() {
    let (from, length) = (DVec3::new(0.2, 0.7, 4.0), 8.0);
    for (term, direction, _) in ways() {
        let terms = json!([term, homogeneous(0.02)]);
        let field = field(terms.as_array().expect("a list"));
        let to = DVec3::new(0.1, -0.05, -1.0).normalize();
        let beyond = Beyond { toward: toward(direction), path_m: PATH_M };
        for g in [0.0, 0.7] {
            let phase = PhaseFunction { g }.value(beyond.toward.dot(to));
            let lit = |t: f64| {
                let x = from + t * to;
                let depth = field.depth(&Ray { origin: from, direction: to }, t);
                let shade = field.depth_from(Origin::Beyond(beyond), x);
                5.0 * phase * field.beta(x) * (-depth - shade).exp()
            };
            let wanted = integrate(0.0, length, &lit);
            for (airlight, allowed) in [("reference", 1e-6), ("auto", 1e-3)] {
                let mut scene_json = sunlit(&terms, direction, g);
                scene_json["fog"]["airlight"] = airlight.into();
                let ray = ProbeRay { origin: from, direction: to, max_distance_m: Some(length) };
                let found = probe(&scene(&scene_json), &[ray])[0].airlight.0[0];
                assert!(
                    (found / wanted - 1.0).abs() < allowed,
                    "{airlight} {term} {g}: {found} {wanted}"
                );
            }
        }
    }
}

/// A matte floor under the sun sends back ρ/π of what it gets, dimmed on its way unless light comes as in clear air.
#[test]
fn a_surface_gets_what_is_left_of_its_irradiance() {
    let direction = [0.5, -1.0, 0.25];
    let cosine = toward(direction).y;
    for (lighting, depth) in [("attenuated", 0.2 * PATH_M), ("clear", 0.0_f64)] {
        let mut json = sunlit(&json!([homogeneous(0.2)]), direction, 0.0);
        json["surfaces"] =
            json!([{ "shape": { "kind": "plane" }, "material": { "diffuse": [0.4, 0.4, 0.4] } }]);
        json["fog"]["surface_lighting"] = lighting.into();
        let down = ProbeRay { origin: DVec3::Y, direction: DVec3::NEG_Y, max_distance_m: None };
        let hit = probe(&scene(&json), &[down])[0].hit.clone().expect("the floor");
        let wanted = 0.4 / PI * cosine * 5.0 * (-depth).exp();
        assert!((hit.surface_radiance.0[0] / wanted - 1.0).abs() < 1e-12, "{lighting}");
    }
}

/// The sun is as strong everywhere: a scene far from the origin sees the same.
#[test]
fn the_sun_is_the_same_everywhere() {
    let light: Light = serde_json::from_value(json!({ "kind": "sun" })).unwrap();
    let Some((Source::Sun(place), _)) = light.lamp(PATH_M) else { unreachable!("a sun") };
    assert!((place.0.toward.length() - 1.0).abs() < 1e-15);
    let at = |x: f64| {
        let json = sunlit(&json!([homogeneous(0.1)]), [0.2, -1.0, 0.1], 0.3);
        let ray = ProbeRay {
            origin: DVec3::new(x, 0.0, -x),
            direction: DVec3::new(1.0, 0.2, 0.1).normalize(),
            max_distance_m: Some(30.0),
        };
        probe(&scene(&json), &[ray])[0].airlight.0[0]
    };
    assert!((at(1e6) / at(0.0) - 1.0).abs() < 1e-9);
}

/// The closed forms meet the integral: Sun's in even fog, Macklin's where fog takes nothing away; the published one is as
/// near in smooth smoke as it is to lamps.
#[test]
fn the_methods_of_the_papers_take_the_sun() {
    let of = |terms: &Value, airlight: &str| {
        let mut json = sunlit(terms, [0.2, -1.0, 0.1], 0.0);
        json["fog"]["phase"] = json!({ "kind": "isotropic" });
        json["fog"]["airlight"] = airlight.into();
        let ray = ProbeRay {
            origin: DVec3::new(0.2, 0.7, 4.0),
            direction: DVec3::new(0.1, -0.05, -1.0).normalize(),
            max_distance_m: Some(9.0),
        };
        probe(&scene(&json), &[ray])[0].airlight.0[0]
    };
    let smoke = json!([homogeneous(0.02), { "kind": "gaussians", "blobs": [
        { "center": [0, 1, 0], "radius": 2.5, "extinction": 0.1 }] }]);
    for (terms, airlight, allowed) in [
        (json!([homogeneous(0.1)]), "sun2005", 1e-9),
        (json!([homogeneous(1e-9)]), "macklin2010", 1e-7),
        // It takes the sun's light through a blob as that to its middle.
        (smoke, "fogshop2007", 0.1),
    ] {
        let (found, wanted) = (of(&terms, airlight), of(&terms, "reference"));
        assert!((found / wanted - 1.0).abs() < allowed, "{airlight}: {found} {wanted}");
    }
}

/// A direction must be one, and a path no less than nothing.
#[test]
fn what_the_sun_cannot_be_is_refused() {
    let problems = |json: Value| {
        let scene: fogbank_core::scene::Scene = read(json.to_string().as_bytes()).unwrap();
        let problems = scene.check().err().unwrap_or_default();
        problems.into_iter().map(|problem| problem.pointer).collect::<Vec<_>>()
    };
    let still = sunlit(&json!([]), [0.0, 0.0, 0.0], 0.0);
    assert_eq!(problems(still), ["/lights/0/direction"]);
    let mut far = sunlit(&json!([]), [0.0, -1.0, 0.0], 0.0);
    far["fog"]["light_path_m"] = json!(-1.0);
    assert_eq!(problems(far), ["/fog/light_path_m"]);
}
