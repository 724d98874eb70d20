//! Surfaces that are hard to sort: nested ones and equal ones lose nothing, and cost no more than
//! others.

use fogbank_core::request::{Layer, Quality};
use fogbank_core::{Progress, Renderer};
use fogbank_tests::scenes::{render, scene, view};
use serde_json::json;
use std::time::{Duration, Instant};

/// Any number of boxes, one within the other, look like the outermost one.
#[test]
fn only_the_outermost_of_nested_boxes_is_seen() {
    for count in [140, 1_000, 10_000] {
        let nested = |i: u32| {
            let half = 5.0 - 4.0 * f64::from(i) / f64::from(count);
            json!({ "shape": { "kind": "box", "min": [-half, -half, -half], "max": [half, half, half] } })
        };
        // The outermost one stands among the others.
        let mut boxes: Vec<_> = (0..count).map(nested).collect();
        boxes.rotate_left(count as usize / 3);
        let json = json!({
            "camera": { "position": [0, 0, 10], "target": [0, 0, 0],
                        "projection": { "kind": "orthographic", "height_m": 4 } },
            "surfaces": boxes,
        });
        let frame = render(&scene(&json), &view(40, 30, Layer::Depth, Quality::Full));
        let (near, far) =
            frame.pixels.iter().fold((f32::INFINITY, 0.0f32), |(near, far), depth| {
                (near.min(*depth), far.max(*depth))
            });
        assert!((near - 5.0).abs() < 1e-5 && (far - 5.0).abs() < 1e-5, "{count}: {near} to {far}");
    }
}

/// 20 000 triangles in one place are a scene like any other.
#[test]
fn equal_triangles_do_not_take_long() {
    let json = json!({
        "camera": { "position": [0, 0, 3], "target": [0, 0, 0] },
        "surfaces": [{ "shape": { "kind": "mesh", "positions": [[-1, -1, 0], [1, -1, 0], [0, 1, 0]],
                                  "indices": vec![[0, 1, 2]; 20_000] } }],
    });
    let progress = Progress::until(Instant::now() + Duration::from_secs(20));
    let view = view(32, 24, Layer::Depth, Quality::Full);
    let frame = Renderer::default().render(&scene(&json), &view, &progress).unwrap();
    assert!((frame.pixels[12 * 32 + 16] - 3.0).abs() < 1e-2);
}
