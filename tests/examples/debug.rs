#![allow(missing_docs)]
use fogbank_core::request::{Layer, Quality};
use fogbank_tests::scenes::*;
use serde_json::json;
fn main() {
    let mut random = Random(13);
    let eye = glam::DVec3::new(0.0, 0.0, 2e-3);
    let _ = (&mut random, eye);
    let s = json!({ "camera": {"position": [0.0,0.0,1.0], "target": [0,0,0]},
        "lights": [{"kind":"point","position":[0.3,0.2,0.1],"intensity":[1,1,1]}],
        "fog": {"terms": [{"kind":"gaussians","blobs":[{"center":[0.0,0.0,0.0],"radius":1e-4,"extinction":1e4}]}]}, "far_m": 200});
    let sc = scene(&s);
    let f = render(&sc, &view(3, 3, Layer::Airlight, Quality::Full));
    let p = probe(&sc, &pixel_rays(&sc, 3, 3));
    println!("{} {}", f.pixels[12], p[4].airlight.0[0]);
}
