//! What is wrong is refused where it is wrong, and the server goes on.

use fogbank_tests::http::{Answer, Request, connect, exchange, finish};
use fogbank_tests::mutation;
use fogbank_tests::server::Server;
use serde_json::{Value, json};
use std::io::Write;

const POSTS: [&str; 4] = ["/v1/render", "/v1/optical-depth", "/v1/probe", "/v1/compare"];

fn probe(scene: Value) -> Value {
    json!({ "scene": scene, "rays": [] })
}

fn first_pointer(problem: &Value) -> &str {
    problem["errors"][0]["pointer"].as_str().unwrap_or("no pointer")
}

/// Why an answer is not what a case expects.
fn objection(case: &mutation::Case, answer: &Answer) -> Option<String> {
    let is_problem = answer.header("content-type") == Some("application/problem+json");
    if case.is_wrong {
        let refused = answer.status == 422 && is_problem;
        let good = refused && first_pointer(&answer.json()) == case.pointer;
        return (!good).then(|| format!("{} {}", answer.status, answer.text()));
    }
    // A good value may still not fit its neighbours, but then that is what the answer says.
    if answer.status == 200 {
        return None;
    }
    let problem = answer.expect_problem(422);
    let mut errors = problem["errors"].as_array().into_iter().flatten();
    let here = errors.find(|error| error["pointer"] == case.pointer.as_str());
    let words = here.and_then(|error| error["detail"].as_str()).unwrap_or_default();
    let of_the_value = ["between", "expected", "out of range", "characters"];
    of_the_value.iter().any(|word| words.contains(word)).then(|| problem.to_string())
}

#[test]
fn every_field_refuses_what_its_schema_refuses_and_takes_its_ends() {
    let server = Server::start();
    let document = server.get("/v1/openapi.json").json();
    for path in POSTS {
        let (cases, fewest) = (mutation::cases(&document, path), 900);
        assert!(cases.len() > fewest, "{} cases for {path}", cases.len());
        let mut objections = Vec::new();
        for case in &cases {
            for body in [&case.body, &case.kind_last] {
                let answer = server.send(&Request::post(path, body.as_str()));
                let objection = objection(case, &answer);
                objections.extend(objection.map(|why| format!("{} {body}\n  {why}", case.pointer)));
            }
        }
        let shown: Vec<_> = objections.iter().take(40).map(String::as_str).collect();
        assert!(objections.is_empty(), "{path}: {}\n{}", objections.len(), shown.join("\n"));
    }
    server.expect_healthy();
}

#[test]
fn what_does_not_fit_together_is_refused_at_its_place() {
    let server = Server::start();
    let surface = |shape: Value| json!({ "surfaces": [{ "shape": shape }] });
    let mesh = |indices: Value| {
        let positions = [[0, 0, 0], [1, 0, 0], [0, 1, 0]];
        surface(json!({ "kind": "mesh", "positions": positions, "indices": indices }))
    };
    let terms = |terms: Value| json!({ "fog": { "terms": terms } });
    let airlight =
        |airlight: &str, term: Value| json!({ "fog": { "airlight": airlight, "terms": [term] } });
    let glowing = |airlight: &str| {
        json!({ "fog": { "airlight": airlight, "terms": [{ "kind": "homogeneous" }],
            "phase": { "kind": "henyey_greenstein" } } })
    };
    let two = |list: &str, thing: Value| json!({ list: [thing, {}, thing] });
    let lamp = json!({ "kind": "point", "id": "a" });
    let cases = [
        (json!({ "camera": { "position": [1, 2, 3], "target": [1, 2, 3] } }), "/camera/target"),
        (
            json!({ "camera": { "position": [0, 0, 0], "target": [0, 5, 0], "up": [0, 2, 0] } }),
            "/camera/up",
        ),
        (
            json!({ "camera": { "position": [0, 0, 0], "target": [0, -5, 0], "up": [0, 2, 0] } }),
            "/camera/up",
        ),
        (json!({ "camera": { "up": [0, 0, 0] } }), "/camera/up"),
        (surface(json!({ "kind": "plane", "normal": [0, 0, 0] })), "/surfaces/0/shape/normal"),
        (
            surface(json!({ "kind": "box", "min": [0, 0, 0], "max": [1, 0, 1] })),
            "/surfaces/0/shape/max/1",
        ),
        (
            surface(json!({ "kind": "box", "min": [0, 0, 2], "max": [1, 1, 1] })),
            "/surfaces/0/shape/max/2",
        ),
        (mesh(json!([[0, 1, 2], [0, 1, 3]])), "/surfaces/0/shape/indices/1/2"),
        (mesh(json!([[4294967295u32, 1, 2]])), "/surfaces/0/shape/indices/0/0"),
        (
            surface(json!({ "kind": "mesh", "positions": [[0, 0, 0]], "normals": [] })),
            "/surfaces/0/shape/normals",
        ),
        (
            surface(json!({ "kind": "mesh", "positions": [[0, 0, 0]], "normals": [[0, 0, 0]] })),
            "/surfaces/0/shape/normals/0",
        ),
        (
            surface(json!({ "kind": "heightfield", "heights": [[0, 0], [0, 0, 0]] })),
            "/surfaces/0/shape/heights/1",
        ),
        (surface(json!({ "kind": "heightfield", "heights": [] })), "/surfaces/0/shape/heights"),
        (
            surface(json!({ "kind": "heightfield", "heights": [[0, 0]] })),
            "/surfaces/0/shape/heights",
        ),
        (
            surface(json!({ "kind": "heightfield", "heights": [[0], [0]] })),
            "/surfaces/0/shape/heights/0",
        ),
        (terms(json!([{}, { "kind": "homogeneous" }])), "/fog/terms/0"),
        (
            terms(json!([{ "kind": "homogeneous", "extinction": 1, "visibility_m": 1 }])),
            "/fog/terms/0/visibility_m",
        ),
        (airlight("sun2005", json!({ "kind": "gaussians", "blobs": [{}] })), "/fog/airlight"),
        (glowing("sun2005"), "/fog/airlight"),
        (glowing("fogshop2007"), "/fog/airlight"),
        (two("surfaces", json!({ "id": "a" })), "/surfaces/2/id"),
        (json!({ "lights": [lamp, { "kind": "point" }, lamp] }), "/lights/2/id"),
        (
            terms(
                json!([{ "kind": "gaussians", "id": "a" }, { "kind": "homogeneous", "id": "a" }]),
            ),
            "/fog/terms/1/id",
        ),
    ];
    for (scene, pointer) in cases {
        let problem = server.post("/v1/probe", &probe(scene.clone())).expect_problem(422);
        assert_eq!(first_pointer(&problem), format!("/scene{pointer}"), "{scene}\n{problem}");
    }
    let no_direction = json!({ "origin": [0, 0, 0], "direction": [0, 0, 0] });
    let body = json!({ "scene": {}, "rays": [{ "origin": [0, 0, 0], "direction": [0, 0, 1] }, no_direction] });
    let problem = server.post("/v1/probe", &body).expect_problem(422);
    assert_eq!(first_pointer(&problem), "/rays/1/direction");
    server.expect_healthy();
}

#[test]
fn every_error_of_a_request_is_told_at_once() {
    let server = Server::start();
    let scene = json!({ "far_m": 0, "time_s": 1e10, "camera": { "projection": { "kind": "orthographic", "height_m": 0 } } });
    let body = json!({ "scene": scene, "width": 0, "height": 1, "samples": 17 });
    let problem = server.post("/v1/render", &body).expect_problem(422);
    let errors = problem["errors"].as_array().unwrap();
    let pointers: Vec<_> = errors.iter().map(|error| error["pointer"].as_str().unwrap()).collect();
    let height = "/scene/camera/projection/height_m";
    assert_eq!(pointers, ["/width", "/samples", height, "/scene/time_s", "/scene/far_m"]);
    assert!(errors.iter().all(|error| error["code"] == "out_of_range"), "{problem}");
    let blob = json!({ "radius": "large", "extinction": -1 });
    let scene = json!({ "far_m": null, "fog": { "terms": [{ "kind": "gaussians", "blobs": [blob] }, { "kind": "smoke" }] } });
    let body = json!({ "scene": scene, "width": 0, "heigth": 1 });
    let problem = server.post("/v1/render", &body).expect_problem(422);
    let errors = problem["errors"].as_array().unwrap().iter();
    let mut found: Vec<_> =
        errors.map(|e| [&e["pointer"], &e["code"]].map(|v| v.as_str().unwrap())).collect();
    found.sort_unstable();
    let expected = [
        ["", "missing"],
        ["/heigth", "unknown_key"],
        ["/scene/far_m", "wrong_type"],
        ["/scene/fog/terms/0/blobs/0/extinction", "out_of_range"],
        ["/scene/fog/terms/0/blobs/0/radius", "wrong_type"],
        ["/scene/fog/terms/1/kind", "unknown_word"],
        ["/width", "out_of_range"],
    ];
    assert_eq!(found, expected);
}

#[test]
fn one_more_than_the_limit_is_refused_and_the_limit_is_not() {
    let server = Server::start();
    let limits = server.get("/v1/limits").json();
    let count = |name: &str| limits["counts"][name].as_u64().unwrap() as usize;
    let many = |n: usize, thing: Value| Value::from(vec![thing; n]);
    let mesh = |positions: usize, indices: usize| {
        json!({ "shape": { "kind": "mesh", "positions": many(positions, json!([0, 0, 0])),
                           "indices": many(indices, json!([0, 0, 0])) } })
    };
    let gaussians = |blobs: usize| json!({ "kind": "gaussians", "blobs": many(blobs, json!({})) });
    let fog = |terms: Value| probe(json!({ "fog": { "terms": terms } }));
    let surfaces = |surfaces: Value| probe(json!({ "surfaces": surfaces }));
    let side = (count("triangles") as f64 / 2.0).sqrt() as usize + 2;
    let heights = many(side, many(side, json!(0)));
    let field = json!({ "shape": { "kind": "heightfield", "heights": heights } });
    let ray = json!({ "origin": [0, 0, 0], "direction": [0, 0, 1], "max_distance_m": 0 });
    let (most_blobs, most_vertices) = (count("blobs"), count("vertices"));
    let most_triangles = count("triangles");
    assert!(most_blobs >= 200_000);
    let lamp = json!({ "kind": "point" });
    let lit_rays = |rays: usize| {
        let scene = json!({ "lights": many(64, lamp.clone()) });
        json!({ "scene": scene, "rays": many(rays, ray.clone()) })
    };
    let term = json!({ "kind": "homogeneous", "extinction": 0 });
    let invalid = [
        (surfaces(many(count("surfaces") + 1, json!({}))), "/scene/surfaces"),
        (surfaces(json!([mesh(1, most_triangles + 1)])), "/scene/surfaces/0/shape/indices"),
        (surfaces(json!([mesh(1, 1), mesh(1, most_triangles)])), "/scene/surfaces/1/shape/indices"),
        (surfaces(json!([mesh(most_vertices + 1, 0)])), "/scene/surfaces/0/shape/positions"),
        (surfaces(json!([field])), "/scene/surfaces/0/shape/heights"),
        (probe(json!({ "lights": many(count("lights") + 1, lamp.clone()) })), "/scene/lights"),
        (fog(many(count("terms") + 1, term.clone())), "/scene/fog/terms"),
        (fog(json!([gaussians(most_blobs + 1)])), "/scene/fog/terms/0/blobs"),
        (fog(json!([gaussians(1), gaussians(most_blobs)])), "/scene/fog/terms/1/blobs"),
        (json!({ "scene": {}, "rays": many(count("rays") + 1, ray.clone()) }), "/rays"),
        (lit_rays(limits["ray_lights"].as_u64().unwrap() as usize / 64 + 1), "/rays"),
    ];
    for (body, pointer) in invalid {
        let problem = server.post("/v1/probe", &body).expect_problem(422);
        assert_eq!(first_pointer(&problem), pointer, "{problem}");
        assert!(problem["detail"].as_str().unwrap().contains("limit"), "{problem}");
    }
    let valid = [
        surfaces(many(count("surfaces"), json!({}))),
        surfaces(json!([mesh(1, 1), mesh(1, most_triangles - 1)])),
        probe(json!({ "lights": many(count("lights"), lamp) })),
        fog(many(count("terms"), term)),
        fog(json!([gaussians(1), gaussians(most_blobs - 1)])),
        json!({ "scene": {}, "rays": many(count("rays"), ray) }),
    ];
    for body in valid {
        server.post("/v1/probe", &body).expect_success();
    }
    server.expect_healthy();
}

#[test]
fn a_picture_of_too_many_pixels_is_refused_before_memory_is_taken() {
    let server = Server::start();
    let limits = server.get("/v1/limits").json();
    let side = limits["counts"]["picture_side"].as_u64().unwrap();
    let pixels = limits["counts"]["picture_pixels"].as_u64().unwrap();
    let most = limits["counts"]["compare_pixels"].as_u64().unwrap();
    let body = json!({ "scene": {}, "width": 2048, "height": most / 2048 + 1 });
    let problem = server.post("/v1/compare", &body).expect_problem(422);
    assert_eq!(first_pointer(&problem), "/height");
    for path in ["/v1/render", "/v1/optical-depth", "/v1/compare"] {
        for (width, height, pointer) in [
            (65_536, 32_768, "/width"),
            (u64::from(u32::MAX), u64::from(u32::MAX), "/width"),
            (side, side + 1, "/height"),
            (side, pixels / side + 1, "/height"),
        ] {
            let body = json!({ "scene": {}, "width": width, "height": height });
            let problem = server.post(path, &body).expect_problem(422);
            assert_eq!(first_pointer(&problem), pointer, "{width}×{height}");
        }
    }
    server.expect_healthy();
}

#[test]
fn what_is_not_json_is_a_400() {
    let server = Server::start();
    let deep = |open: &str, close: &str| open.repeat(100_000) + &close.repeat(100_000);
    let term = |json: &str| format!(r#"{{"scene": {{"fog": {{"terms": [{json}]}}}}}}"#);
    let bodies = [
        String::new(),
        " ".into(),
        "fog".into(),
        "{".into(),
        r#"{"scene": {}"#.into(),
        r#"{"scene": {},}"#.into(),
        r#"{'scene': {}}"#.into(),
        r#"{"scene": {"far_m": NaN}}"#.into(),
        r#"{"scene": {"far_m": Infinity}}"#.into(),
        r#"{"scene": {"far_m": 01}}"#.into(),
        r#"{"scene": {"far_m": +1}}"#.into(),
        r#"{"scene": {"far_m": .5}}"#.into(),
        term(r#"{"blobs": [{}, {},], "kind": "gaussians"}"#),
        term(&deep(r#"{"a":"#, "}")),
    ];
    for path in POSTS {
        for body in &bodies {
            let answer = server.send(&Request::post(path, body.as_str()));
            assert_eq!(answer.status, 400, "{path} {:.80} {}", body, answer.text());
            let problem = answer.expect_problem(400);
            assert_eq!(problem["errors"], json!([]));
        }
        let text = br#"{"scene": {"surfaces": [{"id": ""#.as_slice();
        let not_utf8 = [text, &[0xff, 0xfe], br#""}]}}"#].concat();
        server.send(&Request::post(path, not_utf8)).expect_problem(400);
        let whole = r#"{"scene": {}, "width": 1, "height": 1}"#;
        let whole = if path == "/v1/probe" { r#"{"scene": {}, "rays": []}"# } else { whole };
        server.send(&Request::post(path, whole)).expect_success();
        server.send(&Request::post(path, format!("{whole} {{}}"))).expect_problem(400);
    }
    server.expect_healthy();
}

#[test]
fn what_is_json_is_a_422_with_its_place_whatever_is_in_it() {
    let server = Server::start();
    let deep = |open: &str, close: &str| open.repeat(100_000) + "0" + &close.repeat(100_000);
    let term = |json: &str| format!(r#"{{"scene": {{"fog": {{"terms": [{json}]}}}}, "rays": []}}"#);
    let at = "/scene/fog/terms/0";
    for (body, pointer) in [
        (deep("[", "]"), String::new()),
        (deep(r#"{"scene":"#, "}"), "/scene/scene".into()),
        (deep(r#"{"a":"#, "}"), "/a".into()),
        (
            term(&format!(r#"{{"blobs": {}, "kind": "gaussians"}}"#, deep("[", "]"))),
            format!("{at}/blobs/0"),
        ),
        (term(r#"{"id": "\ud800", "kind": "homogeneous"}"#), format!("{at}/id")),
        (term(r#"{"kind": "homogeneous", "id": "\ud800"}"#), format!("{at}/id")),
        (
            term(r#"{"kind": "gaussians", "blobs": [{"radius": 1e400}]}"#),
            format!("{at}/blobs/0/radius"),
        ),
    ] {
        let problem = server.send(&Request::post("/v1/probe", body.as_str())).expect_problem(422);
        assert_eq!(first_pointer(&problem), pointer, "{body:.100}\n{problem}");
    }
    server.expect_healthy();
}

#[test]
fn a_refusal_is_short_and_costs_little_however_large_the_request() {
    let server = Server::start();
    let limit = server.get("/v1/limits").json()["body_bytes"].as_u64().unwrap() as usize;
    let fill = |head: &str, unit: &str, tail: &str| {
        format!("{head}{}{tail}", unit.repeat((limit - head.len() - tail.len()) / unit.len()))
    };
    let blobs = format!(r#"{{"kind": "gaussians", "blobs": [{}{{}}]}},"#, "{},".repeat(199_999));
    let before = server.peak_memory_bytes();
    for body in [
        fill(
            r#"{"scene": {"fog": {"terms": [{"blobs": ["#,
            r#"{"a":{}},"#,
            r#"{}], "kind": "gaussians"}]}}}"#,
        ),
        fill(r#"{"scene": {"fog": {"terms": [{"#, r#""":{},"#, r#""kind": "gaussians"}]}}}"#),
        fill(r#"{"scene": {"fog": {"terms": ["#, &blobs, "{}]}}}"),
        fill(r#"{""#, "key", r#"": 1}"#),
        fill(r#"{"scene": {"lights": [{"kind": ""#, "kind", r#""}]}}"#),
    ] {
        let answer = server.send(&Request::post("/v1/probe", body.as_str()));
        let problem = answer.expect_problem(422);
        assert!(answer.body.len() < 16 << 10, "{} bytes for {body:.60}", answer.body.len());
        let errors = problem["errors"].as_array().unwrap();
        assert!(errors.len() <= 33);
        assert_eq!(errors.len() == 33, errors.last().unwrap()["code"] == "more", "{problem}");
    }
    // A body may have been held twice while it came, and is read at 8 times its size at most.
    let taken = server.peak_memory_bytes() - before;
    assert!(taken <= 10 * limit, "{} MB", taken >> 20);
    server.expect_healthy();
}

#[test]
fn a_member_that_comes_twice_is_refused() {
    let server = Server::start();
    let scene = |json: &str| format!(r#"{{"scene": {json}, "rays": []}}"#);
    let term = |json: &str| scene(&format!(r#"{{"fog": {{"terms": [{json}]}}}}"#));
    for body in [
        r#"{"scene": {}, "rays": [], "scene": {}}"#.into(),
        scene(r#"{"far_m": 1, "far_m": 2}"#),
        term(r#"{"kind": "homogeneous", "extinction": 1, "extinction": 2}"#),
        term(r#"{"extinction": 1, "extinction": 2, "kind": "homogeneous"}"#),
        term(r#"{"extinction": 1, "kind": "homogeneous", "extinction": 2}"#),
        term(r#"{"kind": "homogeneous", "kind": "homogeneous"}"#),
    ] {
        let answer = server.send(&Request::post("/v1/probe", body.as_str()));
        assert_eq!(answer.status, 422, "{body} {}", answer.text());
        answer.expect_problem(422);
    }
}

#[test]
fn a_body_past_the_limit_is_a_413_by_its_length_alone_and_while_it_streams() {
    let server = Server::start();
    let limit = server.get("/v1/limits").json()["body_bytes"].as_u64().unwrap() as usize;
    assert!(limit >= 32_000_000);
    for path in POSTS {
        let head = format!(
            "POST {path} HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/json\r\n"
        );
        for length in [limit as u64 + 1, 1 << 40, u64::MAX / 2] {
            let announced = format!("{head}content-length: {length}\r\n\r\n");
            exchange(&server.address, announced.as_bytes()).expect_problem(413);
        }
        let mut stream = connect(&server.address);
        stream.write_all(format!("{head}transfer-encoding: chunked\r\n\r\n").as_bytes()).unwrap();
        let chunk = [b"100000\r\n".as_slice(), &[b' '; 1 << 20], b"\r\n"].concat();
        for _ in 0..limit / (1 << 20) + 8 {
            // It may answer and close at any time once the limit is passed.
            if stream.write_all(&chunk).is_err() {
                break;
            }
        }
        finish(stream).expect_problem(413);
        let request = r#"{"scene": {}, "width": 1, "height": 1, "rays": []}"#;
        let padded = request.to_owned() + &" ".repeat(limit - request.len());
        // One unknown member, but as large as a body may be.
        let status = server.send(&Request::post(path, padded)).status;
        assert_eq!(status, 422, "{path}");
        let much = vec![b' '; limit + 1];
        server.send(&Request::post(path, much)).expect_problem(413);
    }
    server.expect_healthy();
}

#[test]
fn a_body_in_chunks_is_read_like_any_other() {
    let server = Server::start();
    let head = "POST /v1/probe HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/json\r\nconnection: close\r\ntransfer-encoding: chunked\r\n\r\n";
    let body = "10\r\n{\"scene\": {}, \"r\r\n9\r\nays\": []}\r\n0\r\n\r\n";
    let answer = exchange(&server.address, format!("{head}{body}").as_bytes()).expect_success();
    assert_eq!(answer.json(), json!({ "rays": [] }));
}

#[test]
fn other_media_types_are_a_415() {
    let server = Server::start();
    let body = json!({ "scene": {}, "width": 1, "height": 1 }).to_string();
    for (name, value) in [
        ("content-type", "text/plain"),
        ("content-type", "application/x-www-form-urlencoded"),
        ("content-type", "multipart/form-data; boundary=x"),
        ("content-encoding", "gzip"),
    ] {
        let request = Request::new("POST", "/v1/render").header(name, value);
        server.send(&request).expect_problem(415);
    }
    // A browser posts JSON without a type for any page that asks it to.
    let untyped = "POST /v1/render HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n";
    let untyped = format!("{untyped}content-length: {}\r\n\r\n{body}", body.len());
    exchange(&server.address, untyped.as_bytes()).expect_problem(415);
    for value in ["application/json", "Application/JSON; charset=utf-8"] {
        let request = Request::post("/v1/render", body.as_str()).header("content-type", value);
        server.send(&request).expect_success();
    }
}

#[test]
fn other_methods_are_a_405_and_other_paths_a_404() {
    let server = Server::start();
    let document = server.get("/v1/openapi.json").json();
    for (path, operations) in document["paths"].as_object().unwrap() {
        for method in ["GET", "POST", "PUT", "PATCH", "DELETE"] {
            if operations[method.to_lowercase()].is_object() {
                continue;
            }
            let answer = server.send(&Request::new(method, path));
            answer.expect_problem(405);
            assert!(!answer.expect_header("allow").contains(method), "{method} {path}");
        }
    }
    for path in ["/v1", "/v1/", "/v1/renders", "/v1/render/", "/x.html", "/../Cargo.toml", "/%00"] {
        server.get(path).expect_problem(404);
        server.post(path, &json!({})).expect_problem(404);
    }
    server.post("/index.html", &json!({})).expect_problem(405);
}

#[test]
fn what_is_not_http_is_answered_with_a_problem_too() {
    let server = Server::start();
    let long = "x".repeat(1 << 20);
    for (bytes, status) in [
        ("fog\r\n\r\n".to_owned(), 400),
        ("GET / HTTP/9.9\r\n\r\n".to_owned(), 400),
        ("GET / HTTP/1.1\r\nbad header\r\n\r\n".to_owned(), 400),
        ("POST /v1/probe HTTP/1.1\r\nhost: x\r\ncontent-length: -1\r\n\r\n".to_owned(), 400),
        ("POST /v1/probe HTTP/1.1\r\nhost: x\r\ncontent-length: fog\r\n\r\n".to_owned(), 400),
        (format!("GET /{} HTTP/1.1\r\nhost: x\r\n\r\n", &long[..70_000]), 414),
        (format!("GET / HTTP/1.1\r\nhost: x\r\nx: {long}\r\n\r\n"), 431),
    ] {
        let answer = exchange(&server.address, bytes.as_bytes());
        assert_eq!(answer.status, status, "{:.60} {}", bytes, answer.text());
        answer.expect_problem(status);
    }
    server.expect_healthy();
}

#[test]
fn other_names_are_a_421_and_pages_of_other_sites_a_403() {
    let server = Server::with(&["--allow-host", "fog.example", "--allow-host", "haze.example"]);
    let get = |host: &str| server.send(&Request::new("GET", "/v1/limits").header("host", host));
    let own = server.address.as_str();
    for host in [own, "localhost:1", "10.0.0.1", "[::1]:80", "fog.example", "HAZE.example:443"] {
        get(host).expect_success();
    }
    for host in ["evil.example", "127.0.0.1.evil.example", "localhost.evil.example", ""] {
        let problem = get(host).expect_problem(421);
        assert!(problem["detail"].as_str().unwrap().contains("--allow-host"), "{problem}");
    }
    let body = json!({ "scene": {}, "width": 1, "height": 1 }).to_string();
    let post = |name: &str, value: &str| {
        let request = Request::post("/v1/render", body.as_str()).header("host", own);
        server.send(&request.header(name, value))
    };
    for (name, value) in [
        ("sec-fetch-site", "cross-site"),
        ("sec-fetch-site", "same-site"),
        ("origin", "http://evil.example"),
        ("origin", "http://localhost:1"),
        ("origin", "null"),
    ] {
        post(name, value).expect_problem(403);
    }
    // It needs no body, so that nothing else would stop it.
    let selftest = Request::new("POST", "/v1/selftest").header("origin", "http://evil.example");
    server.send(&selftest).expect_problem(403);
    let origin = format!("http://{own}");
    for (name, value) in [("sec-fetch-site", "same-origin"), ("origin", origin.as_str())] {
        post(name, value).expect_success();
    }
    let policy = server.get("/");
    assert!(policy.expect_header("content-security-policy").contains("frame-ancestors 'none'"));
}
