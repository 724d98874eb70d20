//! How far a slow job is: told while it waits and runs, and forgotten when it ends.

use fogbank_tests::http::{Request, connect};
use fogbank_tests::server::Server;
use serde_json::{Value, json};
use std::io::Write;
use std::net::{Shutdown, TcpStream};
use std::time::{Duration, Instant};

const PATIENCE: Duration = Duration::from_secs(120);

/// Minutes of work, in steps that take a fraction of a second.
fn slow(airlight: &str) -> Value {
    let blob = |i: i32| json!({ "center": [i % 7 - 3, i % 3, i % 5 - 2], "radius": 0.7, "extinction": 0.5 });
    let blobs: Vec<_> = (0..6).map(blob).collect();
    let fog = json!({ "airlight": airlight, "terms": [{ "kind": "gaussians", "blobs": blobs }] });
    let scene = json!({ "lights": [{ "kind": "point" }], "fog": fog });
    json!({ "scene": scene, "width": 1280, "height": 1024 })
}

/// Sends a request with an id and does not wait for its answer.
fn begin(server: &Server, path: &str, job: &str, body: &Value) -> TcpStream {
    let request = Request::post(path, body.to_string()).header("fog-job", job);
    let mut stream = connect(&server.address);
    stream.write_all(&request.bytes()).unwrap();
    stream
}

/// Asks again and again until the progress is what is wanted; what was seen on the way.
fn until(server: &Server, job: &str, wanted: impl Fn(&[Value]) -> bool) -> Vec<Value> {
    let end = Instant::now() + PATIENCE;
    let mut seen = Vec::new();
    while !wanted(&seen) {
        assert!(Instant::now() < end, "{job}: {seen:?}");
        let answer = server.get(&format!("/v1/progress/{job}"));
        // Its body may still be on its way.
        if answer.status == 200 && seen.last() != Some(&answer.json()) {
            seen.push(answer.json());
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    seen
}

fn until_forgotten(server: &Server, job: &str) {
    let end = Instant::now() + PATIENCE;
    while server.get(&format!("/v1/progress/{job}")).status != 404 {
        assert!(Instant::now() < end, "{job} is still known");
        std::thread::sleep(Duration::from_millis(20));
    }
}

fn fraction(seen: &Value) -> f64 {
    seen["fraction"].as_f64().unwrap()
}

/// A full picture, a draft, which has two slow passes, and a comparison, which has two frames.
#[test]
fn the_progress_of_the_reference_moves_and_never_falls() {
    let server = Server::start();
    let mut draft = slow("reference");
    draft["quality"] = "draft".into();
    let jobs = [
        ("full", "/v1/render", slow("reference")),
        ("draft", "/v1/render", draft),
        ("compare", "/v1/compare", slow("auto")),
    ];
    for (job, path, body) in jobs {
        let stream = begin(&server, path, job, &body);
        let seen = until(&server, job, |seen| seen.len() >= 4);
        let fractions: Vec<_> = seen.iter().map(fraction).collect();
        assert!(fractions.is_sorted(), "{job}: {fractions:?}");
        assert!(fractions[3] < 1.0, "{job}: {fractions:?}");
        assert_eq!(seen[3]["state"], "running", "{job}");
        stream.shutdown(Shutdown::Both).unwrap();
        until_forgotten(&server, job);
    }
    server.expect_healthy();
}

#[test]
fn who_waits_is_told_so_and_who_leaves_is_forgotten() {
    let server = Server::start();
    let first = begin(&server, "/v1/render", "first", &slow("reference"));
    until(&server, "first", |seen| seen.iter().any(|seen| seen["state"] == "running"));
    let second = begin(&server, "/v1/render", "second", &slow("reference"));
    let seen = until(&server, "second", |seen| !seen.is_empty());
    assert_eq!(seen[0], json!({ "state": "waiting", "fraction": 0.0 }));
    second.shutdown(Shutdown::Both).unwrap();
    until_forgotten(&server, "second");
    assert_eq!(server.get("/v1/progress/first").status, 200);
    first.shutdown(Shutdown::Both).unwrap();
    until_forgotten(&server, "first");
    server.expect_healthy();
}

#[test]
fn only_jobs_on_their_way_are_known() {
    let server = Server::start();
    for job in ["nobody", "%20", "%ff", "a%2Fb"] {
        server.get(&format!("/v1/progress/{job}")).expect_problem(404);
    }
    let quick = json!({ "scene": {}, "width": 8, "height": 8 });
    let named = |job: &str| Request::post("/v1/render", quick.to_string()).header("fog-job", job);
    server.send(&named("done")).expect_success();
    server.get("/v1/progress/done").expect_problem(404);
    // The same id serves again when its job has ended.
    server.send(&named("done")).expect_success();
}

#[test]
fn an_id_is_checked_and_serves_one_job_at_a_time() {
    let server = Server::start();
    let quick = json!({ "scene": {}, "width": 8, "height": 8 });
    let long = "a".repeat(65);
    for path in ["/v1/render", "/v1/compare", "/v1/optical-depth"] {
        for job in ["", "a b", "a/b", long.as_str()] {
            let request = Request::post(path, quick.to_string()).header("fog-job", job);
            server.send(&request).expect_problem(400);
        }
    }
    let first = begin(&server, "/v1/render", "one", &slow("reference"));
    until(&server, "one", |seen| !seen.is_empty());
    let request = Request::post("/v1/render", quick.to_string()).header("fog-job", "one");
    server.send(&request).expect_problem(409);
    assert_eq!(server.get("/v1/progress/one").status, 200);
    first.shutdown(Shutdown::Both).unwrap();
    until_forgotten(&server, "one");
}
