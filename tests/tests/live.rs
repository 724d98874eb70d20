//! The live preview over its socket.

use fogbank_tests::http;
use fogbank_tests::live::{Heard, Viewer, open, open_at};
use fogbank_tests::server::Server;
use fogbank_tests::soak::rounds;
use serde_json::{Value, json};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

fn room() -> Value {
    json!({
        "surfaces": [{ "shape": { "kind": "plane" } }],
        "lights": [{ "id": "lamp", "kind": "point", "position": [0, 2.5, 2], "intensity": [40, 34, 24] }],
        "fog": { "terms": [{ "id": "smoke", "kind": "gaussians", "blobs": [{ "center": [1, 1, 0] }] }] },
    })
}

fn stored() -> Server {
    let server = Server::start();
    assert_eq!(server.put("/v1/scenes/room", &room()).status, 201);
    server
}

fn paint(x: f64) -> Value {
    json!({ "op": "paint_stroke", "points": [[x, 0.5, 0]], "radius": 0.4, "extinction": 0.5 })
}

const EYE: [f64; 3] = [0.0, 1.7, 8.0];
const SIZE: [u32; 2] = [160, 120];

fn frame_of(tier: &'static str, seq: u64) -> impl FnMut(&Heard) -> Option<(Value, Vec<u8>)> {
    move |heard| match heard {
        Heard::Frame(header, picture) if header["tier"] == tier && header["seq"] == seq => {
            Some((header.clone(), picture.clone()))
        }
        _ => None,
    }
}

#[test]
fn a_view_is_answered_with_a_draft_and_at_rest_with_a_full_frame() {
    let server = stored();
    let (mut viewer, hello) = Viewer::of(&server.address, "room");
    assert_eq!((hello["id"].as_str(), &hello["revision"]), (Some("room"), &json!(1)));
    assert_eq!(hello["scene"], server.get("/v1/scenes/room").json()["scene"]);
    let seq = viewer.look(EYE, SIZE);
    let (draft, _) = viewer.hear_until(frame_of("draft", seq));
    assert!(draft["scale"].as_f64().is_some_and(|scale| (0.5..=1.0).contains(&scale)), "{draft}");
    assert!(draft["timing_ms"]["encode"].as_f64().is_some_and(|ms| ms > 0.0), "{draft}");
    let (full, picture) = viewer.hear_until(frame_of("full", seq));
    assert_eq!(
        (&full["width"], &full["height"], &full["scale"]),
        (&json!(160), &json!(120), &json!(1.0))
    );
    // It is the picture that a request gets of the same view.
    let request = json!({ "scene": hello["scene"], "width": 160, "height": 120 });
    let mut request = request;
    request["scene"]["camera"] = json!({ "position": EYE, "target": [0, 1, 0] });
    let asked = server.post_for("/v1/render", &request, full["content_type"].as_str().unwrap());
    assert_eq!(asked.expect_success().body, picture);
    // Nothing more comes while nothing moves.
    assert!(viewer.hear_for(Duration::from_millis(500)).is_none());
}

#[test]
fn edits_of_one_reach_all_and_no_frame_is_older_than_what_was_told() {
    let server = stored();
    let (mut one, _) = Viewer::of(&server.address, "room");
    let (mut other, mut scene) = Viewer::of(&server.address, "room");
    other.hear_until(|heard| heard.of_type("viewers").filter(|v| v["count"] == 2).cloned());
    other.look(EYE, SIZE);
    for i in 0..10 {
        one.edit(&paint(f64::from(i)));
    }
    let mut told = 1;
    let mut document = scene["scene"].take();
    other.hear_until(|heard| {
        if let Some(change) = heard.of_type("scene") {
            told = change["revision"].as_u64().unwrap();
            let patch: json_patch::Patch = serde_json::from_value(change["patch"].clone()).unwrap();
            json_patch::patch(&mut document, &patch).unwrap();
        }
        if let Heard::Frame(header, _) = heard {
            assert_eq!(header["revision"], told, "a frame shows what was told");
            return (told == 11).then_some(());
        }
        None
    });
    // What was patched is what the server has.
    assert_eq!(document, server.get("/v1/scenes/room").json()["scene"]);
    // What somebody changes by a request is told as well.
    server.post("/v1/scenes/room/undo", &json!({})).expect_success();
    one.hear_until(|heard| heard.of_type("scene").filter(|s| s["revision"] == 12).cloned());
}

#[test]
fn at_most_two_frames_are_unacknowledged_and_the_latest_view_wins() {
    let server = stored();
    let (mut viewer, _) = Viewer::of(&server.address, "room");
    let mut frames = Vec::new();
    let mut last = 0;
    for i in 0..40 {
        last = viewer.look([f64::from(i) / 10.0, 1.7, 8.0], SIZE);
        while let Some(heard) = viewer.hear_for(Duration::from_millis(10)) {
            if let Heard::Frame(header, _) = heard {
                frames.push(header);
            }
        }
    }
    assert_eq!(frames.len(), 2, "{frames:?}");
    // Once it acknowledges, what comes is the view that it wants now, and none in between.
    viewer.acknowledge(&frames[1]);
    let next = viewer.hear_until(|heard| match heard {
        Heard::Frame(header, _) => Some(header.clone()),
        _ => None,
    });
    assert_eq!(next["seq"], last);
}

#[test]
fn what_is_wrong_is_said_and_the_socket_goes_on() {
    let server = stored();
    let (mut viewer, _) = Viewer::of(&server.address, "room");
    let mut problem_of = |message: &Value| {
        viewer.say(message);
        viewer.hear_until(|heard| heard.of_type("error").cloned())
    };
    let status = |error: &Value| error["problem"]["status"].as_u64();
    let pointer = |error: &Value| error["problem"]["errors"][0]["pointer"].clone();
    let none = problem_of(&json!({ "type": "wave", "seq": 7 }));
    assert_eq!(
        (status(&none), pointer(&none), &none["seq"]),
        (Some(422), json!("/type"), &json!(7))
    );
    let small = json!({ "type": "view", "seq": 8, "camera": {}, "width": 0, "height": 1 });
    assert_eq!(pointer(&problem_of(&small)), "/width");
    let edit = json!({ "type": "edit", "seq": 9, "edit": { "op": "erase", "points": [[0, 0, 0]], "radius": -1 } });
    let edit = problem_of(&edit);
    assert_eq!((pointer(&edit), &edit["seq"]), (json!("/edit/radius"), &json!(9)));
    let stale = json!({ "type": "edit", "seq": 10, "base_revision": 9,
        "edit": { "op": "delete", "term": "smoke", "blobs": [0] } });
    assert_eq!(status(&problem_of(&stale)), Some(409));
    viewer.send(vec![1, 2, 3]);
    viewer.hear_until(|heard| heard.of_type("error").cloned());
    let seq = viewer.look(EYE, SIZE);
    viewer.hear_until(frame_of("draft", seq));
    // A scene that is taken away says good-bye.
    server.send(&http::Request::new("DELETE", "/v1/scenes/room")).expect_success();
    loop {
        if let Heard::Closed(code) = viewer.hear() {
            assert_eq!(code, Some(4404));
            break;
        }
    }
}

#[test]
fn only_the_servers_own_pages_may_open_a_socket() {
    let server = stored();
    let protocol = ("sec-websocket-protocol", "fogbank.v1");
    let status =
        |headers: &[(&str, &str)]| open(&server.address, "room", headers).map(|_| ()).unwrap_err();
    assert_eq!(status(&[protocol, ("origin", "http://evil.example")]), 403);
    assert_eq!(status(&[protocol, ("sec-fetch-site", "cross-site")]), 403);
    assert_eq!(status(&[]), 400);
    assert_eq!(open(&server.address, "none", &[protocol]).map(|_| ()).unwrap_err(), 404);
    assert!(open(&server.address, "room", &[protocol, ("origin", "http://localhost")]).is_ok());
    server.get("/v1/scenes/room/live").expect_problem(400);
}

#[test]
fn a_server_that_stops_says_so() {
    let server = stored();
    let (mut viewer, _) = Viewer::of(&server.address, "room");
    viewer.look(EYE, SIZE);
    server.terminate();
    loop {
        if let Heard::Closed(code) = viewer.hear() {
            assert_eq!(code, Some(1001));
            break;
        }
    }
    assert_eq!(server.exit_code(), Some(0));
}

/// Viewers who never read hold two frames each at most, and do not hold up the others.
#[test]
fn whoever_does_not_read_holds_nobody_up() {
    let server = stored();
    let mut deaf: Vec<_> = (0..8).map(|_| Viewer::of(&server.address, "room").0).collect();
    deaf.iter_mut().for_each(|viewer| {
        viewer.look(EYE, [800, 600]);
    });
    let (mut viewer, _) = Viewer::of(&server.address, "room");
    for i in 0..20 {
        let seq = viewer.look([f64::from(i), 1.7, 8.0], SIZE);
        viewer.hear_until(frame_of("draft", seq));
        viewer.edit(&paint(f64::from(i)));
    }
    drop(deaf);
    server.expect_healthy();
}

/// Sixteen viewers drag at 30 Hz for a minute: none is disconnected, and each is shown the last revision in the end.
#[test]
fn sixteen_viewers_drag_at_a_time() {
    let server = stored();
    let time = Duration::from_secs_f64(60.0 * rounds(1000) as f64 / 1000.0);
    std::thread::scope(|scope| {
        for number in 0..16 {
            let server = &server;
            scope.spawn(move || {
                let (mut viewer, _) = Viewer::of(&server.address, "room");
                let (began, mut turn, mut shown) = (Instant::now(), 0, 0);
                while began.elapsed() < time {
                    turn += 1;
                    viewer.look([f64::from(turn) / 30.0, 1.7, 8.0], SIZE);
                    if turn % 8 == number % 8 {
                        viewer.edit(&paint(f64::from(turn % 5)));
                    }
                    let next = began + Duration::from_millis(33 * turn as u64);
                    while let Some(left) = next.checked_duration_since(Instant::now()) {
                        match viewer.hear_for(left.max(Duration::from_millis(1))) {
                            Some(Heard::Frame(header, _)) => {
                                viewer.acknowledge(&header);
                                shown += 1;
                            }
                            Some(Heard::Text(text)) => assert_ne!(text["type"], "error", "{text}"),
                            Some(Heard::Closed(code)) => panic!("closed: {code:?}"),
                            None => {}
                        }
                    }
                }
                assert!(shown > 0);
                let seq = viewer.look(EYE, SIZE);
                viewer.hear_until(frame_of("full", seq));
            });
        }
    });
    let revision = server.get("/v1/scenes/room").json()["revision"].clone();
    let (_, hello) = Viewer::of(&server.address, "room");
    assert_eq!(hello["revision"], revision);
    server.expect_healthy();
}

#[test]
fn who_has_the_scene_is_not_told_it_again_and_a_preset_is_only_looked_at() {
    let server = stored();
    let protocol = [("sec-websocket-protocol", "fogbank.v1")];
    let hello = |rest: &str| {
        let path = format!("/v1/scenes/{rest}");
        let mut viewer = open_at(&server.address, &path, &protocol).unwrap();
        let hello = viewer.hear();
        (hello.of_type("hello").unwrap().clone(), viewer)
    };
    let at = |revision: u64| format!("room/live?revision={revision}");
    assert_eq!(hello(&at(1)).0, json!({ "type": "hello", "id": "room", "revision": 1 }));
    assert_eq!(hello(&at(7)).0["scene"], hello("room/live").0["scene"]);
    let (preset, mut viewer) = hello("in-scatter/live");
    assert_eq!(preset["revision"], 0);
    let seq = viewer.look(EYE, SIZE);
    viewer.hear_until(frame_of("draft", seq));
    let seq = viewer.edit(&paint(0.0));
    let refused = viewer.hear_until(|heard| heard.of_type("error").cloned());
    assert_eq!((&refused["seq"], &refused["problem"]["status"]), (&json!(seq), &json!(409)));
}

#[test]
fn what_was_stopped_is_not_drawn() {
    let mut scene = room();
    scene["fog"]["airlight"] = json!("reference");
    let server = Server::start();
    assert_eq!(server.put("/v1/scenes/room", &scene).status, 201);
    let (mut viewer, _) = Viewer::of(&server.address, "room");
    viewer.say(&json!({
        "type": "view", "seq": 1, "camera": { "position": EYE, "target": [0, 1, 0] },
        "width": 2000, "height": 1500, "job": "slow",
    }));
    let end = Instant::now() + Duration::from_secs(30);
    while server.get("/v1/progress/slow").status != 200 {
        assert!(Instant::now() < end, "the job never came");
    }
    viewer.say(&json!({ "type": "stop" }));
    while server.get("/v1/progress/slow").status != 404 {
        assert!(Instant::now() < end, "the job goes on");
    }
    while let Some(heard) = viewer.hear_for(Duration::from_millis(500)) {
        assert!(matches!(heard, Heard::Text(_)), "{heard:?}");
    }
}

/// Asks for a socket and reads what the answer begins with; the stream is open as long as it is kept.
fn knock(address: &str) -> (TcpStream, Option<u16>) {
    let mut stream = http::connect(address);
    stream.set_read_timeout(Some(Duration::from_secs(30))).unwrap();
    let request = "GET /v1/scenes/room/live HTTP/1.1\r\nhost: localhost\r\nconnection: upgrade\r\nupgrade: websocket\r\n\
        sec-websocket-version: 13\r\nsec-websocket-key: dGhlIHNhbXBsZSBub25jZQ==\r\nsec-websocket-protocol: fogbank.v1\r\n\r\n";
    // Whoever is turned away at the door may find it shut while it still speaks.
    let mut head = [0; 12];
    let read = stream.write_all(request.as_bytes()).and_then(|()| stream.read_exact(&mut head));
    let status = std::str::from_utf8(&head[9..]).ok().and_then(|text| text.parse().ok());
    (stream, read.ok().and(status))
}

#[test]
fn as_many_as_come_at_once_are_let_in_or_told_that_they_are_too_many() {
    let server = stored();
    let began = Instant::now();
    let all: Vec<_> = (0..rounds(1000)).map(|_| knock(&server.address)).collect();
    assert!(began.elapsed() < Duration::from_secs(10 * 60), "they hang");
    let count = |wanted: &[Option<u16>]| all.iter().filter(|(_, got)| wanted.contains(got)).count();
    let (let_in, refused) = (count(&[Some(101)]), count(&[Some(429), Some(503)]));
    assert!(let_in >= all.len().min(32), "{let_in} of {} are let in", all.len());
    assert_eq!(
        let_in + refused,
        all.len(),
        "{:?}",
        all.iter().map(|(_, got)| got).collect::<Vec<_>>()
    );
    // Whoever watches the process is let in whatever comes.
    assert_eq!(server.get("/healthz").status, 200);
    drop(all);
    // There is room again.
    let end = Instant::now() + Duration::from_secs(30);
    while knock(&server.address).1 != Some(101) {
        assert!(Instant::now() < end, "nobody is let in any more");
    }
    server.expect_healthy();
}

#[test]
fn memory_does_not_grow_with_edits() {
    /// What the allocator and the history of small changes may take besides.
    const SLACK: usize = 48 << 20;
    let server = stored();
    let (mut viewer, _) = Viewer::of(&server.address, "room");
    viewer.look(EYE, SIZE);
    let mut edit = |turn: usize| {
        let value = json!([40.0 + turn as f64, 34.0, 24.0]);
        let patch = json!([{ "op": "replace", "path": "/lights/0/intensity", "value": value }]);
        viewer.edit(&json!({ "op": "patch", "patch": patch }));
        viewer.hear_until(|heard| heard.of_type("scene").map(|_| ()));
    };
    let turns = rounds(10_000);
    (0..turns / 5).for_each(&mut edit);
    let before = server.peak_memory_bytes();
    (turns / 5..turns).for_each(&mut edit);
    // The system counts to a few pages.
    let grown = server.peak_memory_bytes().saturating_sub(before);
    assert!(grown < SLACK, "{grown} bytes more");
}
