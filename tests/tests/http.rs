//! Every endpoint from outside: what it answers, in every form.

use fogbank_tests::decode::Picture;
use fogbank_tests::http::Answer;
use fogbank_tests::selftest::allowed;
use fogbank_tests::server::Server;
use fogbank_tests::{camera, decode};
use image::ImageFormat;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

const LAYERS: [(&str, usize); 7] = [
    ("beauty", 3),
    ("airlight", 3),
    ("surface", 3),
    ("optical_depth", 1),
    ("transmittance", 1),
    ("depth", 1),
    ("normal", 3),
];

const FORMATS: [&str; 5] =
    ["image/png", "image/jpeg", "image/webp", "image/x-exr", "application/x-npy"];

/// One of everything, moved by `offset` along x.
fn scene(offset: f64) -> Value {
    let at = |x: f64, y: f64, z: f64| json!([x + offset, y, z]);
    let mesh = json!({ "kind": "mesh", "indices": [[0, 1, 2], [0, 2, 3]],
        "positions": [at(-3.0, 0.0, -1.0), at(-2.0, 0.0, -1.0), at(-2.0, 2.0, -1.5), at(-3.0, 2.0, -1.5)] });
    let field = json!({ "kind": "heightfield", "origin": at(-4.0, 0.1, 1.0), "size": [3, 2],
        "heights": [[0, 0.2, 0.1], [0.3, 0.5, 0.2], [0.1, 0.2, 0]] });
    let shapes = [
        json!({ "kind": "plane", "point": at(0.0, 0.0, 0.0) }),
        json!({ "kind": "sphere", "center": at(0.3, 1.0, 0.0), "radius": 1 }),
        json!({ "kind": "box", "min": at(1.6, 0.0, -1.0), "max": at(2.6, 1.5, 0.5) }),
        mesh,
        field,
    ];
    let material = json!({ "diffuse": [0.6, 0.4, 0.3], "specular": [0.2, 0.2, 0.2], "shininess": 8,
        "emission": [0.01, 0, 0.02] });
    let surface = |shape: &Value| json!({ "shape": shape, "material": material });
    let surfaces: Vec<_> = shapes.iter().map(surface).collect();
    json!({
        "camera": {
            "position": at(0.4, 2.2, 7.0), "target": at(0.0, 1.0, 0.0), "up": [0.1, 1, 0],
            "projection": { "kind": "perspective", "vertical_fov_deg": 50 },
        },
        "background": [0.1, 0.2, 0.3],
        "surfaces": surfaces,
        "lights": [
            { "id": "warm", "kind": "point", "position": at(2.0, 3.0, 2.0), "intensity": [60, 50, 30], "shadows": false },
            { "kind": "point", "position": at(-2.5, 2.0, 1.0), "intensity": [10, 20, 40], "shadows": false },
        ],
        "fog": {
            "albedo": [0.9, 0.8, 0.7],
            "ambient": [0.02, 0.03, 0.04],
            "terms": [
                { "kind": "homogeneous", "extinction": 0.03 },
                { "kind": "gaussians", "blobs": [
                    { "center": at(-1.0, 1.0, 2.0), "radius": 1.2, "extinction": 0.3 },
                    { "center": at(1.5, 0.5, 1.0), "radius": 0.8, "extinction": 0.5 },
                ] },
            ],
        },
        "far_m": 60,
    })
}

fn request(layer: &str) -> Value {
    json!({ "scene": scene(0.0), "width": 24, "height": 16, "layer": layer })
}

fn decoded(answer: &Answer) -> Picture {
    match answer.expect_header("content-type") {
        "image/png" => decode::screen(&answer.body, ImageFormat::Png),
        "image/jpeg" => decode::screen(&answer.body, ImageFormat::Jpeg),
        "image/webp" => decode::screen(&answer.body, ImageFormat::WebP),
        "image/x-exr" => decode::exr(&answer.body),
        "application/x-npy" => decode::npy(&answer.body),
        other => panic!("{other}"),
    }
}

#[test]
fn every_layer_comes_in_every_format() {
    let server = Server::start();
    for (layer, channels) in LAYERS {
        let mut floats: Option<Picture> = None;
        for format in FORMATS {
            let answer = server.post_for("/v1/render", &request(layer), format).expect_success();
            assert_eq!(answer.expect_header("content-type"), format);
            let picture = decoded(&answer);
            let is_float = ["image/x-exr", "application/x-npy"].contains(&format);
            let expected = if is_float { channels } else { 3 };
            let shape = (picture.width, picture.height, picture.channels);
            assert_eq!(shape, (24, 16, expected), "{layer} as {format}");
            let [least, most] = [f64::min, f64::max]
                .map(|pick| picture.numbers.iter().copied().reduce(pick).unwrap());
            assert!(least < most, "{layer} as {format} is flat");
            if is_float {
                let other = floats.get_or_insert(picture.clone());
                assert_eq!(*other, picture, "{layer} differs between float formats");
            }
        }
    }
}

#[test]
fn a_picture_says_how_it_was_made() {
    let server = Server::start();
    for quality in ["full", "draft"] {
        for format in FORMATS {
            let mut body = request("beauty");
            body["quality"] = quality.into();
            let answer = server.post_for("/v1/render", &body, format).expect_success();
            assert_eq!(answer.expect_header("fog-backend"), "cpu");
            assert_eq!(answer.expect_header("fog-quality"), quality);
            let tag = answer.expect_header("etag");
            assert!(tag.starts_with('"') && tag.ends_with('"') && tag.len() > 16, "{tag}");
            let passes: Vec<_> = answer.expect_header("server-timing").split(", ").collect();
            let read = |pass: &&str| {
                let (name, took_ms) = pass.split_once(";dur=").expect("a name and a time");
                let name = name.trim_end_matches(";desc=reused");
                let took_ms: f64 = took_ms.parse().expect("a number");
                assert!(took_ms >= 0.0);
                name.to_owned()
            };
            let names: Vec<_> = passes.iter().map(read).collect();
            assert_eq!(names.first().map(String::as_str), Some("queue"));
            assert_eq!(names.last().map(String::as_str), Some("encode"));
            assert!(names.len() >= 4, "{names:?}");
        }
    }
}

#[test]
fn the_same_request_has_the_same_bytes_and_another_has_others() {
    let (one, other) = (Server::start(), Server::start());
    for (layer, _) in LAYERS {
        for format in FORMATS {
            let body = request(layer);
            let first = one.post_for("/v1/render", &body, format).expect_success();
            let mut different = body.clone();
            different["scene"]["camera"]["position"] = json!([1, 3, 6]);
            let between = one.post_for("/v1/render", &different, format).expect_success();
            assert_ne!(first.header("etag"), between.header("etag"), "{layer} {format}");
            for server in [&one, &other] {
                let again = server.post_for("/v1/render", &body, format).expect_success();
                assert_eq!(first.body, again.body, "{layer} as {format}");
                assert_eq!(first.header("etag"), again.header("etag"));
            }
        }
    }
}

#[test]
fn accept_chooses_the_format() {
    let server = Server::start();
    for (accept, expected) in [
        ("*/*", "image/png"),
        ("image/*", "image/png"),
        ("application/*", "application/x-npy"),
        ("image/png;q=0.1, image/webp;q=0.2", "image/webp"),
        ("text/html, image/jpeg;q=0.5", "image/jpeg"),
        ("image/png;q=0, image/*", "image/jpeg"),
        ("IMAGE/X-EXR", "image/x-exr"),
    ] {
        let answer = server.post_for("/v1/render", &request("beauty"), accept).expect_success();
        assert_eq!(answer.expect_header("content-type"), expected, "{accept}");
    }
    let answer = server.post("/v1/render", &request("beauty")).expect_success();
    assert_eq!(answer.expect_header("content-type"), "image/png");
    for accept in ["text/html", "image/gif", "*/*;q=0", "application/json"] {
        let answer = server.post_for("/v1/render", &request("beauty"), accept);
        let problem = answer.expect_problem(406);
        assert!(problem["detail"].as_str().unwrap().contains("image/webp"), "{problem}");
        server.post_for("/v1/optical-depth", &request("beauty"), accept).expect_problem(406);
    }
}

#[test]
fn an_optical_depth_map_is_the_layer_in_three_formats() {
    let server = Server::start();
    let body = json!({ "scene": scene(0.0), "width": 24, "height": 16 });
    let answer = server.post("/v1/optical-depth", &body).expect_success();
    assert_eq!(answer.expect_header("content-type"), "application/x-npy");
    let map = decode::npy(&answer.body);
    let layer = server.post_for("/v1/render", &request("optical_depth"), "application/x-npy");
    assert_eq!(map, decode::npy(&layer.expect_success().body));
    let exr = server.post_for("/v1/optical-depth", &body, "image/x-exr").expect_success();
    assert_eq!(map, decode::exr(&exr.body));
    let png = server.post_for("/v1/optical-depth", &body, "image/png").expect_success();
    let scale: f64 = png.expect_header("fog-optical-depth-scale").parse().unwrap();
    let png = decode::png16(&png.body);
    assert_eq!((png.width, png.height), (map.width, map.height));
    assert_eq!(png.numbers.iter().copied().reduce(f64::max), Some(65535.0));
    for (sample, depth) in png.numbers.iter().zip(&map.numbers) {
        let error = (sample / 65535.0 * scale - depth).abs();
        // Half a step, and the rounding of the scale to f32.
        assert!(error <= scale * (0.5 / 65535.0 + 1e-6), "{sample} of {scale} for {depth}");
    }
    let clear = json!({ "scene": {}, "width": 3, "height": 2 });
    let png = server.post_for("/v1/optical-depth", &clear, "image/png").expect_success();
    let scale: f64 = png.expect_header("fog-optical-depth-scale").parse().unwrap();
    assert!(scale.is_finite());
    assert!(decode::png16(&png.body).numbers.iter().all(|sample| *sample == 0.0));
}

/// Compares one layer with what the probe of each pixel's ray says.
fn agree(what: &str, picture: &Picture, probed: &[Vec<f64>]) {
    // Differences count against the number itself, and for dark pixels against the brightest.
    let most = probed.iter().flatten().fold(0.0, |most: f64, number| most.max(number.abs()));
    for (n, expected) in probed.iter().enumerate() {
        for (a, b) in picture.pixel(n).iter().zip(expected) {
            let allowed = 1e-3 * b.abs().max(0.01 * most);
            let (i, j) = (n % picture.width, n / picture.width);
            assert!((a - b).abs() <= allowed, "{what} at ({i}, {j}): {a} instead of {b}");
        }
    }
}

fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(items) => items.iter().flat_map(numbers).collect(),
        number => vec![number.as_f64().expect("a number")],
    }
}

fn probed(layer: &str, answer: &Value, scene: &Value) -> Vec<f64> {
    let hit = &answer["hit"];
    match layer {
        "beauty" => numbers(&answer["radiance"]),
        "depth" if hit.is_null() => numbers(&scene["far_m"]),
        "depth" => numbers(&hit["distance_m"]),
        "surface" if hit.is_null() => numbers(&scene["background"]),
        "surface" => numbers(&hit["surface_radiance"]),
        "normal" if hit.is_null() => vec![0.0; 3],
        "normal" => numbers(&hit["normal"]),
        _ => numbers(&answer[layer]),
    }
}

fn pictures_agree_with_probes(offset: f64, orthographic: bool) {
    const SIZE: (usize, usize) = (24, 16);
    let server = Server::start();
    for (airlight, g) in [
        ("auto", 0.0),
        ("auto", 0.7),
        ("none", 0.0),
        ("sun2005", 0.0),
        ("fogshop2007", 0.0),
        ("reference", 0.0),
        ("reference", -0.4),
    ] {
        let mut scene = scene(offset);
        scene["fog"]["airlight"] = airlight.into();
        scene["fog"]["phase"] = json!({ "kind": "henyey_greenstein", "g": g });
        if airlight == "sun2005" {
            scene["fog"]["terms"].as_array_mut().unwrap().truncate(1);
        }
        if orthographic {
            scene["camera"]["projection"] = json!({ "kind": "orthographic", "height_m": 7 });
        }
        let rays = camera::rays(&scene["camera"], SIZE.0, SIZE.1);
        let answers = server.post("/v1/probe", &json!({ "scene": scene, "rays": rays }));
        let answers = answers.expect_success().json();
        let answers = answers["rays"].as_array().unwrap();
        let is_hit = |answer: &&Value| !answer["hit"].is_null();
        let hits = answers.iter().filter(is_hit).count();
        assert!(hits > 100 && hits < answers.len(), "{hits} of {} hit", answers.len());
        for (layer, _) in LAYERS {
            let body = json!({ "scene": scene, "width": SIZE.0, "height": SIZE.1, "layer": layer });
            let picture = server.post_for("/v1/render", &body, "application/x-npy");
            let picture = decode::npy(&picture.expect_success().body);
            let expected: Vec<_> =
                answers.iter().map(|answer| probed(layer, answer, &scene)).collect();
            let what = format!("{layer} {airlight} orthographic {orthographic} at {offset}");
            agree(&what, &picture, &expected);
        }
    }
}

#[test]
fn a_perspective_picture_agrees_with_the_probe_of_each_pixel() {
    pictures_agree_with_probes(0.0, false);
}

#[test]
fn an_orthographic_picture_agrees_with_the_probe_of_each_pixel() {
    pictures_agree_with_probes(0.0, true);
}

#[test]
fn far_from_the_origin_pictures_and_probes_agree_as_well() {
    pictures_agree_with_probes(1e5, false);
    pictures_agree_with_probes(1e5, true);
}

#[test]
fn a_probe_ends_where_it_is_told() {
    let server = Server::start();
    let scene = json!({
        "surfaces": [{ "id": "wall", "shape": { "kind": "plane", "point": [0, 0, 50], "normal": [0, 0, 1] } }],
        "fog": { "terms": [{ "kind": "homogeneous", "extinction": 0.1 }] },
        "far_m": 20,
    });
    let ray = |direction: Value, end: Value| json!({ "origin": [0, 0, 0], "direction": direction, "max_distance_m": end });
    let rays = [
        (ray(json!([0, 0, 3]), Value::Null), 2.0, false),
        (ray(json!([0, 0, 3]), json!(30)), 3.0, false),
        (ray(json!([0, 0, 3]), json!(300)), 5.0, true),
        (ray(json!([0, 0, -1]), json!(300)), 30.0, false),
        (ray(json!([0, 0, 1]), json!(0)), 0.0, false),
    ];
    let body = json!({ "scene": scene, "rays": rays.iter().map(|ray| &ray.0).collect::<Vec<_>>() });
    let answer = server.post("/v1/probe", &body).expect_success().json();
    for ((_, optical_depth, is_hit), found) in rays.iter().zip(answer["rays"].as_array().unwrap()) {
        let depth = found["optical_depth"].as_f64().unwrap();
        assert!((depth - optical_depth).abs() < 1e-9, "{depth} instead of {optical_depth}");
        assert_eq!(found["hit"]["surface"], if *is_hit { json!("wall") } else { Value::Null });
        assert_eq!(found["airlight_by_light"], json!([]));
    }
}

#[test]
fn every_model_is_described() {
    let server = Server::start();
    let models = server.get("/v1/models").expect_success().json();
    let models = models["models"].as_array().unwrap().clone();
    let named = |kind: &str| -> Vec<String> {
        let of_kind = models.iter().filter(|model| model["kind"] == kind);
        of_kind.map(|model| model["name"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(named("medium"), ["homogeneous", "gaussians", "functions", "fogmap", "emitter"]);
    assert_eq!(
        named("airlight"),
        ["auto", "none", "sun2005", "fogshop2007", "macklin2010", "reference"]
    );
    assert_eq!(named("surface_lighting"), ["auto", "clear", "attenuated"]);
    for model in &models {
        for member in ["source", "summary", "measured_error"] {
            assert!(model[member].as_str().is_some_and(|text| text.len() > 10), "{model}");
        }
        assert!(model["schema"].is_object() && model["supports"]["media"].is_array(), "{model}");
    }
}

#[test]
fn presets_have_the_counts_of_the_papers_and_render() {
    let server = Server::start();
    let presets = server.get("/v1/presets").expect_success().json();
    let presets = presets["presets"].as_array().unwrap().clone();
    let expected = [
        ("street-thin", 0, 4),
        ("street-thick", 0, 4),
        ("steaming-vessel", 34, 3),
        ("terrain-292", 292, 3),
        ("terrain-sky", 292, 2),
        ("city-353", 353, 4),
        ("city-sky", 353, 1),
        ("vehicle-1223", 1223, 2),
        ("vehicle-sky", 1223, 1),
        ("room-3008", 3008, 1),
        ("valley-layers", 0, 2),
        ("valley-waves", 0, 2),
        ("valley-trees", 0, 2),
        ("gorge-wind", 0, 2),
        ("fogmap-steps", 0, 2),
        ("fogmap-slopes", 0, 2),
        ("fogmap-smooth", 0, 2),
        ("in-scatter", 96, 3),
        ("nave-shafts", 60, 4),
        ("lighthouse", 48, 4),
    ];
    assert_eq!(presets.len(), expected.len());
    let length = |value: &Value| value.as_array().map_or(0, Vec::len);
    // Of an emitter, the particles alive at a time.
    let blobs_of = |term: &Value| match (term["rate_hz"].as_f64(), term["lifetime_s"].as_f64()) {
        (Some(rate), Some(lifetime)) => (rate * lifetime).ceil() as usize,
        _ => length(&term["blobs"]),
    };
    for (preset, (name, blobs, lights)) in presets.iter().zip(expected) {
        assert_eq!(preset["name"], name);
        assert!(preset["title"].is_string() && preset["description"].is_string());
        let scene = &preset["scene"];
        let terms = scene["fog"]["terms"].as_array().unwrap();
        assert_eq!(terms.iter().map(blobs_of).sum::<usize>(), blobs, "{name}");
        assert_eq!(length(&scene["lights"]), lights, "{name}");
        let surfaces = scene["surfaces"].as_array().unwrap();
        let triangles: usize = surfaces.iter().map(|s| length(&s["shape"]["indices"])).sum();
        assert!(!name.starts_with("street") || triangles >= 60_000, "{name}: {triangles}");
        let body = json!({ "scene": scene, "width": 32, "height": 18 });
        let picture = decoded(&server.post("/v1/render", &body).expect_success());
        let different = picture.numbers.iter().any(|number| *number != picture.numbers[0]);
        assert!(different, "{name} is flat");
    }
}

#[test]
fn limits_are_those_of_the_documentation() {
    let server = Server::with(&["--queue", "3", "--deadline-s", "7"]);
    let limits = server.get("/v1/limits").expect_success().json();
    assert_eq!(limits["queue"], 3);
    assert_eq!(limits["deadline_s"], 7.0);
    assert_eq!(limits["reference_deadline_s"], 300.0);
    let document = server.get("/v1/openapi.json").expect_success().json();
    let schemas = &document["components"]["schemas"];
    let blob = &schemas["Blob"]["properties"];
    for (range, schema) in [
        ("coordinate", &schemas["Vec3"]["items"]),
        ("intensity", &schemas["Rgb"]["items"]),
        ("fraction", &schemas["Albedo"]["items"]),
        ("radius", &blob["radius"]),
        ("extinction", &blob["extinction"]["anyOf"][0]),
        ("extinction", &blob["extinction"]["anyOf"][1]["items"]),
        ("far", &schemas["Scene"]["properties"]["far_m"]),
        ("anisotropy", &schemas["HenyeyGreensteinPhase"]["properties"]["g"]),
        ("time", &schemas["Scene"]["properties"]["time_s"]),
        ("exposure", &schemas["RenderRequest"]["properties"]["exposure_ev"]),
        ("distance", &schemas["RayRequest"]["properties"]["max_distance_m"]),
    ] {
        assert_eq!(limits["ranges"][range]["min"], schema["minimum"], "{range}");
        assert_eq!(limits["ranges"][range]["max"], schema["maximum"], "{range}");
    }
}

/// The GPU's pictures are those of the probe as well, and the self-test says how near they come.
#[test]
fn a_gpu_answers_like_the_cpu() {
    let server = Server::with(&["--backend", "gpu"]);
    let scene = json!({ "surfaces": [{}], "lights": [{ "kind": "point", "position": [0, 3, 0] }],
        "fog": { "terms": [{ "kind": "homogeneous", "extinction": 0.1 }] } });
    let body = json!({ "scene": scene, "width": 16, "height": 16 });
    let answer = server.post("/v1/render", &body).expect_success();
    assert_eq!(answer.expect_header("fog-backend"), "gpu");
    assert_eq!(server.get("/readyz").json()["status"], "ok");
    let report = server.post("/v1/selftest", &json!({})).json();
    let backends = report["backends"].as_array().unwrap();
    assert_eq!([&backends[0]["backend"], &backends[1]["backend"]], ["cpu", "gpu"]);
    for model in backends.iter().flat_map(|backend| backend["models"].as_array().unwrap()) {
        assert!(model["largest_difference"].as_f64().unwrap() < allowed(model), "{model}");
    }
}

#[test]
fn the_process_says_that_it_is_well() {
    let server = Server::start();
    for path in ["/healthz", "/readyz"] {
        assert_eq!(server.get(path).expect_success().json(), json!({ "status": "ok" }));
    }
}

/// All files below a folder.
fn files_in(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let below = |path: PathBuf| if path.is_dir() { files_in(&path) } else { vec![path] };
    entries.flat_map(below).collect()
}

#[test]
fn the_page_is_served_whole() {
    let server = Server::start();
    let page = server.get("/").expect_success();
    assert_eq!(page.expect_header("content-type"), "text/html; charset=utf-8");
    assert_eq!(page.body, server.get("/index.html").expect_success().body);
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../web"));
    let mut count = 0;
    for path in files_in(folder) {
        let name = path.strip_prefix(folder).unwrap().to_str().unwrap();
        let answer = server.get(&format!("/{name}")).expect_success();
        assert_eq!(answer.body, std::fs::read(&path).unwrap(), "{name}");
        if name.ends_with("SUMS") {
            continue;
        }
        let content_type = answer.expect_header("content-type");
        assert_ne!(content_type, "application/octet-stream", "{name}");
        assert_eq!(answer.expect_header("x-content-type-options"), "nosniff");
        assert!(answer.expect_header("content-security-policy").contains("'self'"));
        assert!(answer.header("etag").is_some());
        count += 1;
    }
    assert!(count > 10);
}

#[test]
fn the_document_is_the_one_that_was_agreed_on() {
    let server = Server::start();
    insta::assert_json_snapshot!("openapi", server.get("/v1/openapi.json").expect_success().json());
}

#[test]
fn every_documented_path_is_there_and_nothing_else() {
    let server = Server::start();
    let document = server.get("/v1/openapi.json").expect_success().json();
    let paths = document["paths"].as_object().unwrap();
    let names: Vec<_> = paths.keys().map(String::as_str).collect();
    let expected = [
        "/healthz",
        "/readyz",
        "/v1/compare",
        "/v1/limits",
        "/v1/models",
        "/v1/openapi.json",
        "/v1/optical-depth",
        "/v1/presets",
        "/v1/probe",
        "/v1/progress/{job}",
        "/v1/render",
        "/v1/scenes",
        "/v1/scenes/{id}",
        "/v1/scenes/{id}/compare",
        "/v1/scenes/{id}/edits",
        "/v1/scenes/{id}/frame",
        "/v1/scenes/{id}/history",
        "/v1/scenes/{id}/live",
        "/v1/scenes/{id}/optical-depth",
        "/v1/scenes/{id}/probe",
        "/v1/scenes/{id}/redo",
        "/v1/scenes/{id}/select",
        "/v1/scenes/{id}/undo",
        "/v1/selftest",
    ];
    assert_eq!(names, expected);
    for (path, operations) in paths {
        if path.contains('{') {
            let verb = if operations["get"].is_object() { "GET" } else { "POST" };
            server.send_as(verb, path, "application/json", &json!({})).expect_problem(404);
        } else if operations["get"].is_object() {
            server.get(path).expect_success();
        } else if operations["post"]["requestBody"].is_null() {
            server.post(path, &json!({})).expect_success();
        } else {
            server.post(path, &json!({ "scene": {} })).expect_problem(422);
        }
    }
}

/// Numbers as near as another machine's mathematical library computes them.
fn is_like(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Object(a), Value::Object(b)) => {
            a.len() == b.len()
                && a.iter().all(|(key, value)| b.get(key).is_some_and(|b| is_like(value, b)))
        }
        (Value::Array(a), Value::Array(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| is_like(a, b))
        }
        (Value::Number(a), Value::Number(b)) => {
            let [a, b] = [a, b].map(|number| number.as_f64().unwrap());
            (a - b).abs() <= 1e-12 * b.abs()
        }
        (a, b) => a == b,
    }
}

#[test]
fn examples_are_answered_as_the_document_says() {
    let server = Server::start();
    assert_eq!(server.put("/v1/scenes/example", &json!({})).status, 201);
    let document = server.get("/v1/openapi.json").expect_success().json();
    let mut sent = 0;
    for (path, operations) in document["paths"].as_object().unwrap() {
        for (method, operation) in operations.as_object().unwrap() {
            let content = &operation["responses"]["200"]["content"];
            let body = &operation["requestBody"]["content"]["application/json"];
            let examples = &body["examples"];
            assert_eq!(examples.is_object(), !body.is_null(), "{path}");
            let bodies = examples.as_object().into_iter().flat_map(|all| all.values());
            let (verb, place) = (method.to_uppercase(), path.replace("{id}", "example"));
            let send =
                |body: &Value| server.send_as(&verb, &place, "application/json", &body["value"]);
            let mut answers: Vec<_> = bodies.map(send).collect();
            // A path that names something has an answer only while that is there.
            if answers.is_empty() && method == "get" && !path.contains('{') {
                answers.push(server.get(path));
            }
            sent += answers.len();
            for answer in &answers {
                assert_eq!(answer.status, 200, "{path}: {}", answer.text());
                let content_type = answer.expect_header("content-type");
                assert!(!content[content_type].is_null(), "{path}: {content_type}");
            }
            let expected = &content["application/json"]["example"];
            assert!(expected.is_null() || is_like(&answers[0].json(), expected), "{path}");
        }
    }
    assert!(sent > 10);
    let body = json!({ "scene": { "far_m": "far" }, "width": 0 });
    let problem = server.post("/v1/render", &body).expect_problem(422);
    let documented =
        "/components/responses/UnprocessableEntity/content/application~1problem+json/example";
    assert_eq!(Some(&problem), document.pointer(documented));
}

#[test]
fn a_picture_is_documented_as_bytes() {
    let document = Server::start().get("/v1/openapi.json").expect_success().json();
    for path in ["/v1/render", "/v1/optical-depth", "/v1/compare"] {
        let content = &document["paths"][path]["post"]["responses"]["200"]["content"];
        for (media_type, description) in content.as_object().unwrap() {
            let is_bytes = description["schema"] == json!({ "type": "string", "format": "binary" });
            assert_eq!(is_bytes, media_type != "application/json", "{path} {media_type}");
        }
    }
}

#[test]
fn a_scene_may_name_its_schema() {
    let server = Server::start();
    let scene = json!({ "$schema": "https://example.org/scene.schema.json" });
    server.post("/v1/probe", &json!({ "scene": scene, "rays": [] })).expect_success();
    let scene = json!({ "$schema": 1 });
    let problem =
        server.post("/v1/probe", &json!({ "scene": scene, "rays": [] })).expect_problem(422);
    assert_eq!(problem["errors"][0]["pointer"], "/scene/$schema");
    let document = server.get("/v1/openapi.json").json();
    assert!(document["components"]["schemas"]["Scene"]["properties"]["$schema"].is_object());
}
