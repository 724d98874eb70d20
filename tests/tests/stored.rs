//! Scenes that live on the server: every route of them, and what is promised of what was acknowledged.

use fogbank_tests::decode;
use fogbank_tests::directory::Directory;
use fogbank_tests::http::{Answer, Request};
use fogbank_tests::server::{Server, command};
use fogbank_tests::soak::rounds;
use serde_json::{Value, json};
use std::sync::atomic::{AtomicBool, Ordering};

const MERGE: &str = "application/merge-patch+json";
const PATCH: &str = "application/json-patch+json";

fn room() -> Value {
    json!({
        "surfaces": [{ "shape": { "kind": "plane" } }, { "id": "ball", "shape": { "kind": "sphere" } }],
        "lights": [{ "kind": "point", "position": [0, 2.5, 2], "intensity": [40, 34, 24] }],
        "fog": { "terms": [
            { "kind": "homogeneous", "extinction": 0.03 },
            { "id": "smoke", "kind": "gaussians", "blobs": [{ "center": [1, 1, 0] }, { "center": [2, 1, 0] }] },
        ] },
    })
}

fn stored() -> Server {
    let server = Server::start();
    assert_eq!(server.put("/v1/scenes/room", &room()).status, 201);
    server
}

fn paint(x: f64) -> Value {
    json!({ "op": "paint_stroke", "points": [[x, 0.5, 0], [x + 1.0, 0.5, 0]], "radius": 0.4, "extinction": 0.5 })
}

fn edits(list: &[Value]) -> Value {
    json!({ "edits": list })
}

fn revision(answer: &Answer) -> u64 {
    let revision = answer.json()["revision"].as_u64().expect("a revision");
    assert_eq!(answer.expect_header("etag"), format!("\"{revision}\""));
    revision
}

fn scene_of(server: &Server) -> Value {
    server.get("/v1/scenes/room").expect_success().json()["scene"].clone()
}

#[test]
fn a_scene_is_put_read_changed_and_taken_away() {
    let server = Server::start();
    let made = server.put("/v1/scenes/room", &room());
    assert_eq!((made.status, revision(&made)), (201, 1));
    let read = server.get("/v1/scenes/room").expect_success();
    assert_eq!(read.expect_header("etag"), "\"1\"");
    let scene = &read.json()["scene"];
    // What had no id has one.
    assert_eq!(scene["surfaces"][0]["id"], "surface-1");
    assert_eq!(scene["lights"][0]["id"], "light-1");
    assert_eq!(scene["fog"]["terms"][0]["id"], "term-1");
    assert_eq!(scene["fog"]["terms"][1]["id"], "smoke");
    let known = Request::new("GET", "/v1/scenes/room").header("if-none-match", "\"1\"");
    assert_eq!(server.send(&known).status, 304);
    // Put again, it is another revision, and listed.
    let again = server.put("/v1/scenes/room", &room()).expect_success();
    assert_eq!(revision(&again), 2);
    let list = server.get("/v1/scenes").expect_success().json();
    assert_eq!(list["scenes"][0]["id"], "room");
    assert_eq!(list["scenes"][0]["revision"], 2);
    let gone = server.send(&Request::new("DELETE", "/v1/scenes/room")).expect_success();
    assert_eq!(gone.json()["revision"], 2);
    server.get("/v1/scenes/room").expect_problem(404);
    assert_eq!(server.get("/v1/scenes").json(), json!({ "scenes": [] }));
    // It comes again with a larger revision: no tag is ever used twice.
    assert!(revision(&server.put("/v1/scenes/room", &room())) > 2);
}

#[test]
fn patches_of_both_kinds_answer_what_they_changed() {
    let server = stored();
    let merge = json!({ "far_m": 50, "fog": { "ambient": [0.1, 0.1, 0.1] } });
    let merged = server.send_as("PATCH", "/v1/scenes/room", MERGE, &merge).expect_success();
    assert_eq!(revision(&merged), 2);
    assert_eq!(merged.json()["patch"].as_array().map(Vec::len), Some(2));
    assert_eq!(scene_of(&server)["far_m"], 50.0);
    let add = json!([{ "op": "add", "path": "/lights/-", "value": { "kind": "point" } }]);
    let patched = server.send_as("PATCH", "/v1/scenes/room", PATCH, &add).expect_success();
    // Defaults and an id were filled in: the answer says so.
    let value = &patched.json()["patch"][0]["value"];
    assert_eq!((value["id"].as_str(), &value["enabled"]), (Some("light-2"), &json!(true)));
    assert_eq!(value, &scene_of(&server)["lights"][1]);
}

#[test]
fn edits_are_applied_undone_and_done_again() {
    let server = stored();
    let before = scene_of(&server);
    let edited =
        server.post("/v1/scenes/room/edits", &edits(&[paint(0.0), paint(3.0)])).expect_success();
    assert_eq!(revision(&edited), 2);
    let after = scene_of(&server);
    assert!(after["fog"]["terms"][1]["blobs"].as_array().map_or(0, Vec::len) > 6);
    let undone = server.post("/v1/scenes/room/undo", &json!({})).expect_success();
    assert_eq!((revision(&undone), scene_of(&server)), (3, before.clone()));
    server.post("/v1/scenes/room/undo", &json!({})).expect_problem(409);
    let redone = server.post("/v1/scenes/room/redo", &json!({})).expect_success();
    assert_eq!((revision(&redone), scene_of(&server)), (4, after));
    server.post("/v1/scenes/room/redo", &json!({})).expect_problem(409);
    // A stroke is undone as a whole, however many calls it took.
    for i in 0..3 {
        let mut stroke = paint(f64::from(i));
        stroke["stroke"] = "s".into();
        server.post("/v1/scenes/room/edits", &edits(&[stroke])).expect_success();
    }
    server.post("/v1/scenes/room/undo", &json!({})).expect_success();
    server.post("/v1/scenes/room/undo", &json!({})).expect_success();
    assert_eq!(scene_of(&server), before);
    let history = server.get("/v1/scenes/room/history?limit=4").expect_success().json();
    let kinds: Vec<_> =
        history["revisions"].as_array().unwrap().iter().map(|r| r["kind"].clone()).collect();
    assert_eq!(kinds, ["undo", "undo", "edit", "edit"]);
    assert_eq!(history["revisions"][2]["stroke"], "s");
    assert_eq!((&history["can_undo"], &history["can_redo"]), (&json!(false), &json!(true)));
    let older = server.get("/v1/scenes/room/history?before=3").expect_success().json();
    assert_eq!(older["revisions"].as_array().map(Vec::len), Some(2));
    assert_eq!(older["revisions"][1]["kind"], "create");
}

#[test]
fn what_an_edit_adds_has_an_id() {
    let server = Server::start();
    server.put("/v1/scenes/room", &json!({}));
    let emitter = json!({ "op": "emitter_add", "emitter": { "kind": "emitter" } });
    server.post("/v1/scenes/room/edits", &edits(&[paint(0.0), emitter])).expect_success();
    let scene = scene_of(&server);
    assert_eq!(scene["fog"]["terms"][0]["id"], "term-1");
    assert_eq!(scene["fog"]["terms"][1]["id"], "term-2");
}

#[test]
fn edits_that_name_blobs_need_the_revision_that_they_are_of() {
    let server = stored();
    let delete = json!({ "op": "delete", "term": "smoke", "blobs": [0] });
    let problem = server
        .post("/v1/scenes/room/edits", &edits(std::slice::from_ref(&delete)))
        .expect_problem(422);
    assert_eq!(problem["errors"][0]["pointer"], "/base_revision");
    let of = |revision: u64| json!({ "edits": [delete], "base_revision": revision });
    server.post("/v1/scenes/room/edits", &of(7)).expect_problem(409);
    server.post("/v1/scenes/room/edits", &of(1)).expect_success();
    server.post("/v1/scenes/room/edits", &of(1)).expect_problem(409);
    assert_eq!(scene_of(&server)["fog"]["terms"][1]["blobs"].as_array().map(Vec::len), Some(1));
}

#[test]
fn what_cannot_be_done_is_refused_with_its_place() {
    let server = stored();
    server.get("/v1/scenes/none").expect_problem(404);
    server.get("/v1/scenes/Room").expect_problem(404);
    server.put("/v1/scenes/ROOM", &room()).expect_problem(404);
    server.post("/v1/scenes/none/edits", &edits(&[paint(0.0)])).expect_problem(404);
    server.post("/v1/scenes/none/undo", &json!({})).expect_problem(404);
    server.get("/v1/scenes/none/history").expect_problem(404);
    server.get("/v1/scenes/none/frame").expect_problem(404);
    let pointer = |answer: Answer| answer.expect_problem(422)["errors"][0]["pointer"].clone();
    assert_eq!(pointer(server.put("/v1/scenes/room", &json!({ "far_m": -1 }))), "/far_m");
    let patch = |value| server.send_as("PATCH", "/v1/scenes/room", PATCH, &value);
    assert_eq!(pointer(patch(json!([{ "op": "remove", "path": "/none" }]))), "/0/path");
    assert_eq!(pointer(patch(json!([{ "op": "vanish", "path": "" }]))), "/0/op");
    assert_eq!(
        pointer(patch(json!([{ "op": "replace", "path": "/far_m", "value": -1 }]))),
        "/scene/far_m"
    );
    let merge = |value| server.send_as("PATCH", "/v1/scenes/room", MERGE, &value);
    assert_eq!(pointer(merge(json!({ "fog": { "none": 1 } }))), "/scene/fog/none");
    let other = server.send_as("PATCH", "/v1/scenes/room", "application/json", &json!({}));
    other.expect_problem(415);
    assert!(other.expect_header("accept-patch").contains(PATCH));
    let edit = |value| server.post("/v1/scenes/room/edits", &value);
    assert_eq!(pointer(edit(json!({ "edits": [] }))), "/edits");
    assert_eq!(pointer(edit(json!({ "edits": [{ "op": "fly" }] }))), "/edits/0/op");
    let mut wide = paint(0.0);
    wide["radius"] = json!(0);
    assert_eq!(pointer(edit(edits(&[paint(0.0), wide]))), "/edits/1/radius");
    assert_eq!(pointer(server.get("/v1/scenes/room/frame?width=0")), "/width");
    assert_eq!(pointer(server.get("/v1/scenes/room/frame?fog=thick")), "/fog");
    assert_eq!(pointer(server.get("/v1/scenes/room/history?limit=0")), "/limit");
    let select = server.post("/v1/scenes/room/select", &json!({ "rectangle": [0.5, 0, 0.2, 1] }));
    assert_eq!(pointer(select), "/rectangle");
    let send = |name: &str, value: &str| {
        let put = Request::with("PUT", "/v1/scenes/room", "application/json", room().to_string());
        server.send(&put.header(name, value))
    };
    send("if-match", "\"7\"").expect_problem(412);
    send("if-none-match", "*").expect_problem(412);
    send("if-match", "seven").expect_problem(412);
    send("idempotency-key", "").expect_problem(400);
    let absent = Request::with("PUT", "/v1/scenes/new", "application/json", "{}");
    server.send(&absent.header("if-match", "*")).expect_problem(412);
    // None of this changed anything.
    assert_eq!(server.get("/v1/scenes/room").json()["revision"], 1);
    server.expect_healthy();
}

#[test]
fn pictures_and_numbers_are_those_of_the_same_scene_that_is_sent() {
    let server = stored();
    let size = json!({ "width": 40, "height": 30, "exposure_ev": 1, "tonemap": "reinhard" });
    let with_scene = |mut body: Value| {
        body["scene"] = room();
        body
    };
    let path = "/v1/scenes/room/frame?width=40&height=30&exposure_ev=1&tonemap=reinhard";
    for (accept, draft) in [("image/png", false), ("application/x-npy", false), ("image/png", true)]
    {
        let (mut body, mut path) = (with_scene(size.clone()), path.to_owned());
        if draft {
            body["quality"] = "draft".into();
            path += "&quality=draft";
        }
        let sent = server.post_for("/v1/render", &body, accept).expect_success();
        let kept =
            server.send(&Request::new("GET", &path).header("accept", accept)).expect_success();
        assert_eq!(sent.body, kept.body);
        assert_eq!(kept.expect_header("content-type"), accept);
        assert_eq!(kept.expect_header("fog-revision"), "1");
    }
    let map = json!({ "width": 40, "height": 30 });
    let sent = server.post("/v1/optical-depth", &with_scene(map)).expect_success();
    let kept = server.get("/v1/scenes/room/optical-depth?width=40&height=30").expect_success();
    assert_eq!(sent.body, kept.body);
    let rays = json!({ "rays": [{ "origin": [0, 1, 8], "direction": [0, 0, -1] }] });
    let sent = server.post("/v1/probe", &with_scene(rays.clone())).expect_success().json();
    let mut kept = server.post("/v1/scenes/room/probe", &rays).expect_success().json();
    // Only that a surface has an id now differs.
    assert_eq!(kept["rays"][0]["hit"]["surface"], "ball");
    kept["rays"][0]["hit"]["surface"] = sent["rays"][0]["hit"]["surface"].clone();
    assert_eq!(sent, kept);
    let all = server
        .post("/v1/scenes/room/select", &json!({ "rectangle": [0, 0, 1, 1] }))
        .expect_success();
    assert_eq!(all.json()["blobs"], json!([{ "term": "smoke", "blobs": [0, 1] }]));
    assert_eq!(all.json()["lights"], json!(["light-1"]));
}

#[test]
fn a_picture_that_the_client_has_is_not_made_again() {
    let server = stored();
    let path = "/v1/scenes/room/frame?width=40&height=30";
    let get = |tag: &str| server.send(&Request::new("GET", path).header("if-none-match", tag));
    let first = get("\"none\"").expect_success();
    let tag = first.expect_header("etag").to_owned();
    assert_eq!(get(&tag).status, 304);
    let other = server.get("/v1/scenes/room/frame?width=41&height=30").expect_success();
    assert_ne!(other.expect_header("etag"), tag);
    let npy = Request::new("GET", path).header("accept", "application/x-npy");
    assert_ne!(server.send(&npy).expect_header("etag"), tag);
    // What is kept of surfaces is kept of the pictures that were made last.
    get("\"none\"").expect_success();
    server.post("/v1/scenes/room/edits", &edits(&[paint(0.0)])).expect_success();
    let edited = get(&tag).expect_success();
    assert_ne!(edited.body, first.body);
    // An edit of the fog traces no surface anew.
    assert!(edited.expect_header("server-timing").contains("surfaces;desc=reused"), "{edited:?}");
}

#[test]
fn an_emitter_is_the_same_at_a_time_however_that_was_reached() {
    let server = Server::start();
    let chimney = json!({ "fog": { "terms": [{ "kind": "emitter", "id": "c" }] },
        "lights": [{ "kind": "point" }] });
    server.put("/v1/scenes/room", &chimney);
    let at = |time: f64| {
        let path = format!("/v1/scenes/room/frame?width=32&height=24&time_s={time}");
        server
            .send(&Request::new("GET", &path).header("accept", "application/x-npy"))
            .expect_success()
            .body
    };
    let once = at(7.3);
    let forwards: Vec<_> = [0.0, 2.0, 7.3].into_iter().map(at).collect();
    let backwards: Vec<_> = [20.0, 9.0, 7.3].into_iter().map(at).collect();
    assert_eq!((&once, &once), (&forwards[2], &backwards[2]));
    assert_ne!(once, forwards[1]);
}

/// Of eight writers that expect the same revision one wins, a thousand times.
#[test]
fn of_eight_writers_with_one_if_match_one_wins() {
    let server = stored();
    for round in 1..=rounds(1000) as u64 {
        let tag = format!("\"{round}\"");
        let write = |i: u64| {
            let merge = json!({ "far_m": round * 10 + i + 1 }).to_string();
            let patch = Request::with("PATCH", "/v1/scenes/room", MERGE, merge);
            server.send(&patch.header("if-match", &tag)).status
        };
        let statuses: Vec<u16> = std::thread::scope(|scope| {
            let all: Vec<_> = (0..8).map(|i| scope.spawn(move || write(i))).collect();
            all.into_iter().map(|thread| thread.join().expect("it answers")).collect()
        });
        assert_eq!(statuses.iter().filter(|status| **status == 200).count(), 1, "{statuses:?}");
        assert_eq!(statuses.iter().filter(|status| **status == 412).count(), 7, "{statuses:?}");
    }
}

/// What was acknowledged is there after the server was killed at any moment, and nothing of another edit is half.
#[test]
fn a_killed_server_has_all_that_it_acknowledged() {
    let directory = Directory::new();
    let arguments = ["--data-dir", directory.text()];
    let mut known = [0u64; 3];
    for round in 0..rounds(100) {
        let server = Server::with(&arguments);
        let is_over = AtomicBool::new(false);
        if round == 0 {
            for i in 0..known.len() {
                assert_eq!(server.put(&format!("/v1/scenes/s{i}"), &room()).status, 201);
            }
        }
        std::thread::scope(|scope| {
            for (i, count) in known.iter_mut().enumerate() {
                let (server, is_over) = (&server, &is_over);
                scope.spawn(move || {
                    while !is_over.load(Ordering::Relaxed) {
                        // Two members that must never differ.
                        let next = *count + 1;
                        let merge =
                            json!({ "far_m": next, "fog": { "light_path_m": next } }).to_string();
                        let path = format!("/v1/scenes/s{i}");
                        let request = Request::with("PATCH", &path, MERGE, merge);
                        let Ok(answer) = request.try_send(&server.address) else { return };
                        if answer.status == 200 {
                            *count = next;
                        }
                    }
                });
            }
            std::thread::sleep(std::time::Duration::from_millis(40 + 37 * round as u64 % 200));
            server.kill();
            is_over.store(true, Ordering::Relaxed);
        });
        drop(server);
        let server = Server::with(&arguments);
        for (i, count) in known.iter_mut().enumerate() {
            let read = server.get(&format!("/v1/scenes/s{i}")).expect_success().json();
            let number = |value: &Value| value.as_f64().expect("a number") as u64;
            let (far, path) = (&read["scene"]["far_m"], &read["scene"]["fog"]["light_path_m"]);
            if *count > 0 || number(path) != 100 {
                assert_eq!(number(far), number(path));
                // An edit whose answer was cut off may be there.
                assert!(number(far) == *count || number(far) == *count + 1, "{far} {count}");
                *count = number(far);
            }
        }
    }
    assert!(known.iter().sum::<u64>() > 0);
}

/// Also across a restart.
#[test]
fn a_repeated_request_paints_once() {
    let directory = Directory::new();
    let arguments = ["--data-dir", directory.text()];
    let paint = edits(&[paint(0.0)]).to_string();
    let once = |server: &Server, body: &str| {
        let request =
            Request::post("/v1/scenes/room/edits", body).header("idempotency-key", "a stroke");
        server.send(&request)
    };
    let server = Server::with(&arguments);
    server.put("/v1/scenes/room", &room());
    let first = once(&server, &paint).expect_success();
    let scene = scene_of(&server);
    let again = once(&server, &paint).expect_success();
    assert_eq!((first.json(), scene_of(&server)), (again.json(), scene.clone()));
    once(
        &server,
        &edits(&[json!({ "op": "erase", "points": [[0, 0, 0]], "radius": 1 })]).to_string(),
    )
    .expect_problem(422);
    drop(server);
    let server = Server::with(&arguments);
    let after = once(&server, &paint).expect_success();
    assert_eq!((first.json(), scene_of(&server)), (after.json(), scene));
}

#[test]
fn two_servers_do_not_share_a_directory() {
    let directory = Directory::new();
    let first = Server::with(&["--data-dir", directory.text()]);
    let mut second = command(&["serve", "--listen", "127.0.0.1:0", "--data-dir", directory.text()]);
    let output = second.output().expect("it runs");
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && text.contains("another process"), "{text}");
    first.expect_healthy();
}

/// Where nothing more fits on the disk, writes are refused as such, reads go on, and nothing is half written. The
/// system's limit of a file's size stands for the disk.
#[test]
fn a_full_disk_refuses_writes_and_goes_on_reading() {
    let directory = Directory::new();
    // In blocks of 512 bytes: room for the database and a little more.
    let mut shell = std::process::Command::new("sh");
    shell.args(["-c", "trap '' XFSZ; ulimit -f 6000; exec \"$0\" \"$@\""]);
    shell.arg(fogbank_tests::server::program()).env("FOGBANK_LOG", "off");
    let server = Server::spawn(shell, &["--data-dir", directory.text()]);
    let blobs = |count: u32| {
        let blob = |i: u32| json!({ "center": [f64::from(i) / 7.0, 1.0, 1.0 / 3.0] });
        json!({ "fog": { "terms": [{ "kind": "gaussians", "blobs": (0..count).map(blob).collect::<Vec<_>>() }] } })
    };
    let mut count = 0;
    let full = loop {
        let answer = server.put(&format!("/v1/scenes/s{count}"), &blobs(2000));
        if answer.status != 201 {
            break answer;
        }
        count += 1;
        assert!(count < 100, "the limit does nothing");
    };
    full.expect_problem(507);
    assert!(count > 0);
    for i in 0..count {
        let read = server.get(&format!("/v1/scenes/s{i}")).expect_success();
        assert_eq!(
            read.json()["scene"]["fog"]["terms"][0]["blobs"].as_array().map(Vec::len),
            Some(2000)
        );
    }
    server.get(&format!("/v1/scenes/s{count}")).expect_problem(404);
    server.get("/v1/scenes/s0/frame?width=8&height=8").expect_success();
    // With room again, it goes on.
    drop(server);
    let server = Server::with(&["--data-dir", directory.text()]);
    assert_eq!(server.put("/v1/scenes/more", &blobs(2000)).status, 201);
    let list = server.get("/v1/scenes").expect_success().json();
    assert_eq!(list["scenes"].as_array().map(Vec::len), Some(count + 1));
}

/// The README's tool of a pipeline, as it stands there.
#[test]
fn the_pipeline_of_the_readme_runs() {
    let server = Server::start();
    let readme = include_str!("../../README.md");
    let (_, rest) = readme.split_once("```python\n").expect("a script");
    let (script, _) = rest.split_once("```").expect("its end");
    let script = script.replace("http://127.0.0.1:8080", &format!("http://{}", server.address));
    let directory = Directory::new();
    let mut python = std::process::Command::new("python3");
    let output =
        python.args(["-c", &script]).current_dir(directory.path()).output().expect("Python");
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(text.starts_with("revision 2 with "), "{text}");
    let read = |name: &str| std::fs::read(directory.path().join(name)).expect("a file");
    let beauty = decode::exr(&read("beauty.exr"));
    let depth = decode::npy(&read("depth.npy"));
    assert_eq!((beauty.width, beauty.height, beauty.channels), (320, 240, 3));
    assert_eq!((depth.width, depth.height, depth.channels), (320, 240, 1));
}

#[test]
fn presets_are_scenes_that_stay_as_they_are() {
    let server = Server::start();
    let listed = server.get("/v1/presets?scenes=false").expect_success().json();
    let whole = server.get("/v1/presets").expect_success().json();
    for (brief, preset) in
        listed["presets"].as_array().unwrap().iter().zip(whole["presets"].as_array().unwrap())
    {
        assert_eq!(brief["scene"], Value::Null);
        for member in ["name", "title", "description"] {
            assert_eq!(brief[member], preset[member]);
        }
    }
    let read = server.get("/v1/scenes/in-scatter").expect_success();
    assert_eq!((read.json()["revision"].as_u64(), read.expect_header("etag")), (Some(0), "\"0\""));
    assert_eq!(server.get("/v1/scenes").json()["scenes"], json!([]));
    server.get("/v1/scenes/in-scatter/frame?width=32&height=24").expect_success();
    for answer in [
        server.post("/v1/scenes/in-scatter/edits", &edits(&[paint(0.0)])),
        server.send_as("PATCH", "/v1/scenes/in-scatter", MERGE, &json!({ "far_m": 10 })),
        server.post("/v1/scenes/in-scatter/undo", &json!({})),
    ] {
        assert_eq!(answer.status, 409);
        assert!(answer.json()["detail"].as_str().unwrap().contains("?from="), "{}", answer.json());
    }
    // Whoever stores a scene of that name has it, until it is deleted.
    assert_eq!(revision(&server.put("/v1/scenes/in-scatter", &room())), 1);
    assert_eq!(server.get("/v1/scenes/in-scatter").json()["scene"]["lights"][0]["id"], "light-1");
    assert_eq!(server.send(&Request::new("DELETE", "/v1/scenes/in-scatter")).status, 200);
    assert_eq!(server.get("/v1/scenes/in-scatter").json(), read.json());
}

#[test]
fn a_scene_or_a_preset_is_copied_without_being_sent() {
    let server = stored();
    let copy = |from: &str, to: &str| {
        let request = Request::new("PUT", &format!("/v1/scenes/{to}?from={from}"));
        server.send(&request.header("if-none-match", "*"))
    };
    let made = copy("in-scatter", "mine");
    assert_eq!((made.status, revision(&made)), (201, 1));
    let preset = server.get("/v1/scenes/in-scatter").json();
    assert_eq!(server.get("/v1/scenes/mine").json()["scene"], preset["scene"]);
    assert_eq!(copy("room", "mine").status, 412);
    assert_eq!(copy("room", "other").status, 201);
    assert_eq!(server.get("/v1/scenes/other").json()["scene"], scene_of(&server));
    // A copy goes its own way.
    server.post("/v1/scenes/other/edits", &edits(&[paint(0.0)])).expect_success();
    assert_ne!(server.get("/v1/scenes/other").json()["scene"], scene_of(&server));
    assert_eq!(copy("nothing", "more").status, 404);
    assert_eq!(copy("No%20id", "more").status, 404);
    assert_eq!(copy("other", "2024").status, 201);
    assert_eq!(copy("2024", "more").status, 201);
    assert_eq!(server.send(&Request::new("PUT", "/v1/scenes/x?of=room")).status, 422);
}

#[test]
fn a_stored_scene_is_seen_from_elsewhere_and_compared() {
    let server = stored();
    let camera = json!({ "position": [3, 1.5, 4], "target": [0, 1, 0] });
    let address = |rest: &str| {
        let camera = camera.to_string().replace('"', "%22").replace(' ', "");
        format!("/v1/scenes/room/{rest}?width=40&height=30&time_s=1&camera={camera}")
    };
    let mut scene = scene_of(&server);
    scene["camera"] = camera.clone();
    scene["time_s"] = json!(1);
    let sent = json!({ "scene": scene, "width": 40, "height": 30 });
    let asked = server.send(&Request::new("GET", &address("frame")).header("accept", "image/png"));
    assert_eq!(asked.expect_success().body, server.post("/v1/render", &sent).expect_success().body);
    let map = Request::new("GET", &address("optical-depth")).header("accept", "application/x-npy");
    let other = server.post_for("/v1/optical-depth", &sent, "application/x-npy");
    assert_eq!(server.send(&map).expect_success().body, other.expect_success().body);
    let depth = server.send(&Request::new("GET", &format!("{}&layer=depth", address("frame"))));
    let range = depth.expect_success().expect_header("fog-depth-range").to_owned();
    let ends: Vec<f64> = range.split(' ').map(|end| end.parse().unwrap()).collect();
    assert!(0.0 < ends[0] && ends[0] < ends[1], "{range}");
    let compared = json!({ "width": 40, "height": 30, "camera": camera, "time_s": 1 });
    let compared = server.post("/v1/scenes/room/compare", &compared).expect_success().json();
    let expected = server.post("/v1/compare", &sent).expect_success().json();
    for number in ["bias", "median", "p95", "max", "mean_b"] {
        assert_eq!(compared[number], expected[number], "{number}");
    }
    let wrong = server.get("/v1/scenes/room/frame?camera={%22position%22:[1,2]}");
    assert_eq!(
        (wrong.status, &wrong.json()["errors"][0]["pointer"]),
        (422, &json!("/camera/position"))
    );
}

#[test]
fn a_drag_of_patches_and_an_eraser_are_one_step_of_undo() {
    let server = stored();
    let before = scene_of(&server);
    for x in 1..=3 {
        let patch = json!([{ "op": "replace", "path": "/lights/0/position", "value": [x, 2, 2] }]);
        let drag = json!({ "op": "patch", "patch": patch, "stroke": "drag" });
        server.post("/v1/scenes/room/edits", &edits(&[drag])).expect_success();
    }
    assert_eq!(scene_of(&server)["lights"][0]["position"], json!([3.0, 2.0, 2.0]));
    for x in 1..=2 {
        let erase = json!({ "op": "erase", "points": [[x, 1, 0]], "radius": 0.3, "stroke": "rub" });
        server.post("/v1/scenes/room/edits", &edits(&[erase])).expect_success();
    }
    assert_eq!(scene_of(&server)["fog"]["terms"][1]["blobs"], json!([]));
    let undo = || server.post("/v1/scenes/room/undo", &json!({})).expect_success().json();
    undo();
    assert_eq!(scene_of(&server)["fog"], before["fog"]);
    undo();
    assert_eq!(scene_of(&server), before);
}

#[test]
fn a_repeated_delete_is_answered_like_the_first() {
    let server = stored();
    let delete = |key: &str| {
        let request = Request::new("DELETE", "/v1/scenes/room").header("idempotency-key", key);
        server.send(&request)
    };
    let first = delete("once").expect_success().json();
    assert_eq!(first["revision"], 1);
    assert_eq!(delete("once").expect_success().json(), first);
    assert_eq!(delete("twice").status, 404);
    // A scene that comes again is not what that request meant.
    assert_eq!(server.put("/v1/scenes/room", &room()).status, 201);
    assert_eq!(delete("once").expect_success().json(), first);
    assert_eq!(server.get("/v1/scenes/room").status, 200);
    delete("twice").expect_success();
    assert_eq!(server.get("/v1/scenes/room").status, 404);
}
