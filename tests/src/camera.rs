//! The ray of a pixel, written down from the documentation alone.

use serde_json::{Value, json};

type Vector = [f64; 3];

fn vector(value: &Value) -> Vector {
    [0, 1, 2].map(|k| value[k].as_f64().expect("a number"))
}

fn sum(a: Vector, b: Vector, times: f64) -> Vector {
    [0, 1, 2].map(|k| a[k] + times * b[k])
}

fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(a: Vector) -> Vector {
    let length = a.iter().map(|x| x * x).sum::<f64>().sqrt();
    a.map(|x| x / length)
}

/// The ray through the centre of every pixel, as `/v1/probe` takes them, top row first.
pub fn rays(camera: &Value, width: usize, height: usize) -> Vec<Value> {
    let position = vector(&camera["position"]);
    let forward = unit(sum(vector(&camera["target"]), position, -1.0));
    let right = unit(cross(forward, vector(&camera["up"])));
    let up = cross(right, forward);
    let projection = &camera["projection"];
    let orthographic = projection["kind"] == "orthographic";
    let half_height = if orthographic {
        projection["height_m"].as_f64().expect("a height") / 2.0
    } else {
        (projection["vertical_fov_deg"].as_f64().expect("an angle").to_radians() / 2.0).tan()
    };
    let pixel = |n: usize| {
        let (i, j) = ((n % width) as f64 + 0.5, (n / width) as f64 + 0.5);
        let across = (2.0 * i - width as f64) / height as f64 * half_height;
        let upwards = (1.0 - 2.0 * j / height as f64) * half_height;
        let in_plane = sum(right.map(|x| x * across), up, upwards);
        if orthographic {
            json!({ "origin": sum(position, in_plane, 1.0), "direction": forward })
        } else {
            json!({ "origin": position, "direction": sum(forward, in_plane, 1.0) })
        }
    };
    (0..width * height).map(pixel).collect()
}
