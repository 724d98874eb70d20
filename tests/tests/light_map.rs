//! Optical depths around a light: `POST /v1/optical-depth` with `light` and `size`.

#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test stops where it fails")]

use fogbank_tests::decode::npy;
use fogbank_tests::http::Request;
use fogbank_tests::scenes::{probe, scene};
use fogbank_tests::server::Server;
use glam::DVec3;
use serde_json::{Value, json};

fn lit() -> Value {
    json!({ "lights": [{ "kind": "point", "id": "lamp", "position": [0.5, 1, -0.3] },
            { "kind": "sun", "direction": [0.2, -1, 0.1] }],
        "surfaces": [{ "shape": { "kind": "plane" } },
            { "shape": { "kind": "sphere", "center": [2, 1, 0], "radius": 0.5 } }],
        "fog": { "terms": [{ "kind": "homogeneous", "extinction": 0.02 },
            { "kind": "gaussians", "blobs": [{ "center": [1, 2, 1], "radius": 1, "extinction": 0.7 }] }] },
        "far_m": 30 })
}

/// Where a pixel of a cube map looks, as graphics interfaces have it.
fn toward(face: usize, s: f64, t: f64) -> DVec3 {
    let all =
        [(1.0, -t, -s), (-1.0, -t, s), (s, 1.0, t), (s, -1.0, -t), (s, -t, 1.0), (-s, -t, -1.0)];
    DVec3::from(all[face])
}

/// Every pixel of the cube is the optical depth that a probe finds from the lamp on.
#[test]
fn a_cube_holds_what_probes_find() {
    const SIZE: usize = 8;
    let server = Server::start();
    let body = json!({ "scene": lit(), "light": "lamp", "size": SIZE });
    let map = npy(&server.post("/v1/optical-depth", &body).expect_success().body);
    assert_eq!((map.height, map.width), (6 * SIZE, SIZE));
    let values = map.numbers;
    let checked = scene(&lit());
    for (place, value) in values.iter().enumerate() {
        let (face, y, x) = (place / (SIZE * SIZE), place / SIZE % SIZE, place % SIZE);
        let at = |i: usize| 2.0 * (i as f64 + 0.5) / SIZE as f64 - 1.0;
        let direction = toward(face, at(x), at(y)).normalize();
        let ray = fogbank_core::request::ProbeRay {
            origin: DVec3::new(0.5, 1.0, -0.3),
            direction,
            max_distance_m: None,
        };
        let wanted = probe(&checked, &[ray])[0].optical_depth.channels()[0];
        assert!((*value - wanted).abs() <= 1e-3 * wanted, "{face} {x} {y}: {value} {wanted}");
    }
}

/// The sun's square is as thick at most as all that its light comes through.
#[test]
fn the_sun_has_one_square() {
    let server = Server::start();
    let body = json!({ "scene": lit(), "light": 1, "size": 16 });
    let map = npy(&server.post("/v1/optical-depth", &body).expect_success().body);
    assert_eq!((map.height, map.width), (16, 16));
    let values = map.numbers;
    let haze = 0.02 * 100.0;
    let most = haze + 0.7 * std::f64::consts::PI.sqrt();
    let largest = values.iter().copied().fold(0.0, f64::max);
    assert!(values.iter().all(|v| *v >= haze * 0.999 && *v <= most));
    assert!(largest > haze + 0.3, "the blob is seen: {largest}");
}

/// What does not go together is refused at its place, and a cube too large before anything is made.
#[test]
fn what_is_no_map_is_refused() {
    let server = Server::start();
    let cases = [
        (json!({ "light": "other", "size": 8 }), "/light"),
        (json!({ "light": 7, "size": 8 }), "/light"),
        (json!({ "light": "lamp" }), "/size"),
        (json!({ "size": 8 }), "/light"),
        (json!({ "light": "lamp", "size": 65535 }), "/size"),
        (json!({ "light": "lamp", "size": 0 }), "/size"),
        (json!({ "light": "lamp", "size": 8, "width": 8 }), "/width"),
        (json!({ "width": 8 }), "/height"),
    ];
    for (mut body, pointer) in cases {
        body["scene"] = lit();
        let answer = server.send(&Request::post("/v1/optical-depth", body.to_string()));
        assert_eq!(answer.status, 422, "{body}");
        let problem: Value = answer.json();
        assert_eq!(problem["errors"][0]["pointer"], pointer, "{problem}");
    }
    server.expect_healthy();
}
