//! More work than the server can do: it refuses, gives up and forgets, and then goes on.

use fogbank_tests::http::{Request, connect, connect_from, finish};
use fogbank_tests::server::Server;
use serde_json::{Value, json};
use std::io::Write;
use std::net::{Shutdown, TcpStream};
use std::time::{Duration, Instant};

/// Minutes of work for one processor, in the lane for long jobs.
fn slow() -> Value {
    let blob = |i: i32| json!({ "center": [i % 7 - 3, i % 3, i % 5 - 2], "radius": 0.7, "extinction": 0.5 });
    let blobs: Vec<_> = (0..200).map(blob).collect();
    let lamp = |i: i32| json!({ "kind": "point", "position": [i - 2, 3, 1] });
    let lights: Vec<_> = (0..4).map(lamp).collect();
    let fog =
        json!({ "airlight": "reference", "terms": [{ "kind": "gaussians", "blobs": blobs }] });
    json!({ "scene": { "lights": lights, "fog": fog }, "width": 1280, "height": 1024 })
}

fn quick() -> Value {
    json!({ "scene": {}, "width": 8, "height": 8 })
}

/// As little work, but in the lane for long jobs.
fn long() -> Value {
    json!({ "scene": { "fog": { "airlight": "reference" } }, "width": 8, "height": 8 })
}

/// Sends a request and does not wait for its answer.
fn begin(server: &Server, body: &Value) -> TcpStream {
    begin_at(server, "/v1/render", body)
}

fn begin_at(server: &Server, path: &str, body: &Value) -> TcpStream {
    let mut stream = connect(&server.address);
    stream.write_all(&Request::post(path, body.to_string()).bytes()).unwrap();
    stream
}

/// Sends slow requests until so many of them are answered; those that are not, and those that are.
fn begin_all(server: &Server, count: usize, answered: usize) -> (Vec<TcpStream>, Vec<TcpStream>) {
    let end = Instant::now() + Duration::from_secs(120);
    let mut taken: Vec<_> = (0..count).map(|_| begin(server, &slow())).collect();
    let mut done = Vec::new();
    while done.len() < answered {
        assert!(Instant::now() < end, "only {} are answered", done.len());
        for i in (0..taken.len()).rev() {
            taken[i].set_read_timeout(Some(Duration::from_millis(20))).unwrap();
            if taken[i].peek(&mut [0]).is_ok_and(|bytes| bytes > 0) {
                done.push(taken.remove(i));
            }
        }
    }
    (taken, done)
}

/// Asks again and again until the answer has this status; there is no other sign that a request
/// has taken its place, or has given it back.
fn until_status(server: &Server, status: u16, body: &Value) {
    let end = Instant::now() + Duration::from_secs(120);
    loop {
        let answer = server.post("/v1/render", body);
        if answer.status == status {
            return;
        }
        assert!(Instant::now() < end, "still {} {}", answer.status, answer.text());
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn a_full_queue_answers_503_until_who_waited_leaves() {
    let server = Server::with(&["--queue", "2"]);
    // One renders, one waits, and one place is left to other clients.
    let (taken, refused) = begin_all(&server, 4, 2);
    for stream in refused {
        finish(stream).expect_problem(503);
    }
    let mut waiting = connect_from([127, 0, 0, 2], &server.address);
    waiting.write_all(&Request::post("/v1/render", slow().to_string()).bytes()).unwrap();
    let refused = server.post("/v1/render", &long());
    let problem = refused.expect_problem(503);
    assert_eq!(problem["errors"], json!([]));
    let seconds: u32 = refused.expect_header("retry-after").parse().unwrap();
    assert!(seconds >= 1);
    server.post("/v1/compare", &quick()).expect_problem(503);
    server.get("/healthz").expect_success();
    server.get("/readyz").expect_success();
    server.get("/v1/presets").expect_success();
    for stream in taken.into_iter().chain([waiting]) {
        stream.shutdown(Shutdown::Both).unwrap();
    }
    until_status(&server, 200, &long());
    server.expect_healthy();
}

#[test]
fn short_jobs_do_not_wait_for_long_ones() {
    let server = Server::with(&["--deadline-s", "60"]);
    let mut comparison = slow();
    (comparison["width"], comparison["height"]) = (json!(320), json!(256));
    let streams: Vec<_> = (0..3).map(|_| begin_at(&server, "/v1/compare", &comparison)).collect();
    for _ in 0..5 {
        server.post("/v1/render", &quick()).expect_success();
        let ray = json!({ "origin": [0, 0, 9], "direction": [0, 0, -1] });
        server.post("/v1/probe", &json!({ "scene": {}, "rays": [ray] })).expect_success();
    }
    for stream in &streams {
        stream.set_nonblocking(true).unwrap();
        assert!(stream.peek(&mut [0]).is_err(), "the long job was done first");
    }
}

#[test]
fn past_the_deadline_is_a_504_and_each_airlight_has_its_own() {
    let server = Server::with(&["--deadline-s", "60", "--reference-deadline-s", "0.2"]);
    server.post("/v1/render", &slow()).expect_problem(504);
    server.post("/v1/render", &quick()).expect_success();
    let mut many = slow();
    many["rays"] = vec![json!({ "origin": [0, 0, 9], "direction": [0, 0, -1] }); 60_000].into();
    for member in ["width", "height"] {
        many.as_object_mut().unwrap().remove(member);
    }
    server.post("/v1/probe", &many).expect_problem(504);
    server.post("/v1/compare", &slow()).expect_problem(504);
    server.expect_healthy();
    let server = Server::with(&["--deadline-s", "0.001", "--reference-deadline-s", "60"]);
    let mut large = quick();
    (large["width"], large["height"]) = (json!(4096), json!(2048));
    large["scene"]["surfaces"] = json!([{}]);
    server.post("/v1/render", &large).expect_problem(504);
    let mut reference = quick();
    reference["scene"]["fog"]["airlight"] = json!("reference");
    server.post("/v1/render", &reference).expect_success();
    // A comparison with the reference has the reference's time, and one without has not.
    server.post("/v1/compare", &quick()).expect_success();
    let mut quickly = large;
    (quickly["width"], quickly["height"]) = (json!(1024), json!(2048));
    (quickly["a"], quickly["b"]) = (json!({ "airlight": "none" }), json!({ "airlight": "auto" }));
    server.post("/v1/compare", &quickly).expect_problem(504);
}

#[test]
fn who_leaves_is_forgotten() {
    let server = Server::with(&["--queue", "16"]);
    for _ in 0..3 {
        let paths = ["/v1/render", "/v1/compare"].into_iter().cycle().take(12);
        let streams: Vec<_> = paths.map(|path| begin_at(&server, path, &slow())).collect();
        for stream in streams {
            stream.shutdown(Shutdown::Both).unwrap();
        }
        // It would take hours if they were still rendered.
        until_status(&server, 200, &long());
    }
    server.expect_healthy();
}

/// About a second of work in the lane for short jobs.
fn some_work() -> Value {
    let mut work = slow();
    work["scene"]["fog"]["airlight"] = json!("auto");
    (work["width"], work["height"]) = (json!(1600), json!(1200));
    work
}

#[test]
fn who_was_accepted_is_answered_before_the_server_ends() {
    let server = Server::with(&["--queue", "16", "--drain-s", "240", "--deadline-s", "240"]);
    let streams: Vec<_> = (0..8).map(|_| begin(&server, &some_work())).collect();
    // It connects later, so that the others are connected when it is answered.
    server.get("/healthz").expect_success();
    server.terminate();
    for stream in streams {
        finish(stream).expect_success();
    }
    assert_eq!(server.exit_code(), Some(0));
}

#[test]
fn what_is_not_done_in_time_is_answered_when_the_server_ends() {
    let server = Server::with(&["--drain-s", "0.3"]);
    let streams: Vec<_> = (0..3).map(|_| begin(&server, &slow())).collect();
    server.get("/healthz").expect_success();
    server.terminate();
    for stream in streams {
        finish(stream).expect_problem(503);
    }
    assert!(TcpStream::connect(&server.address).is_err());
    assert_eq!(server.exit_code(), Some(0));
}
