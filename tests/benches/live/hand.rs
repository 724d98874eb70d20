//! One hand on every preset: it orbits, recolours a lamp, thins a blob, and rests.

use super::quantile;
use fogbank_core::presets;
use fogbank_tests::http::Request;
use fogbank_tests::live::{Heard, Viewer};
use fogbank_tests::server::Server;
use serde_json::{Value, json};
use std::time::Instant;

const SIZE: [u32; 2] = [800, 600];
/// Moves of each kind, of which the first few fill what is kept and choose a size.
const MOVES: usize = 50;
const WARM: usize = 10;
/// Full frames.
const RESTS: usize = 5;

/// Frames of one kind of move.
#[derive(Default)]
struct Frames {
    /// From what was said to the whole frame [ms].
    whole: Vec<f64>,
    /// In the queue, in passes, in the encoder, and the rest: the way there and back, and what is not a frame's [ms].
    parts: [Vec<f64>; 4],
    up: Vec<f64>,
    down: Vec<f64>,
    scale: Vec<f64>,
}

impl Frames {
    fn add(&mut self, (header, bytes): (Value, usize), ms: f64, up: usize) {
        let of = |name: &str| header["timing_ms"][name].as_f64().unwrap_or(0.0);
        let timing = header["timing_ms"].as_object();
        let all: f64 = timing.into_iter().flatten().filter_map(|(_, ms)| ms.as_f64()).sum();
        let (queue, encode) = (of("queue"), of("encode"));
        let parts = [queue, all - queue - encode, encode, ms - all];
        self.parts.iter_mut().zip(parts).for_each(|(list, part)| list.push(part));
        self.whole.push(ms);
        self.up.push(up as f64);
        self.down.push(bytes as f64);
        self.scale.push(header["scale"].as_f64().unwrap_or(1.0));
    }

    fn print(mut self, name: &str, what: &str) {
        let mut at = |share: f64| quantile(&mut self.whole, share);
        let (p50, p95) = (at(0.5), at(0.95));
        let parts = self.parts.each_mut().map(|part| format!("{:.1}", quantile(part, 0.5)));
        println!(
            "| {name} | {what} | {p50:.1} | {p95:.1} | {} | {:.2} | {:.0} | {:.0} |",
            parts.join(" / "),
            quantile(&mut self.scale, 0.5),
            quantile(&mut self.up, 0.5),
            quantile(&mut self.down, 0.5) / 1e3
        );
    }
}

pub fn print(wanted: &dyn Fn(&str) -> bool) {
    println!(
        "## One hand, at {}×{}\n\n\
         Milliseconds from what is said to the whole frame. Of the median, what was queue, passes, encoder, and the rest\n\
         (the edit itself with its commit, the socket, the client). `scale` is the size of drafts that the server chose for a budget of 33 ms;\n\
         a draft of 0.50 that is late all the same is coarser as well.\n\
         `request` is what a page without the socket does: it posts the scene with every view.\n\n\
         | preset | what | p50 | p95 | queue / passes / encode / rest | scale | bytes up | kB down |\n\
         |---|---|---|---|---|---|---|---|",
        SIZE[0], SIZE[1]
    );
    let server = Server::start();
    for preset in presets::all().into_iter().filter(|preset| wanted(preset.name)) {
        let scene = json!(preset.scene);
        let path = format!("/v1/scenes/{}", preset.name);
        assert_eq!(server.put(&path, &scene).status, 201);
        let mut hand =
            Hand { viewer: Viewer::of(&server.address, preset.name).0, scene: scene.clone() };
        hand.orbit("draft").print(preset.name, "view → draft");
        if has_lamp(&scene) {
            hand.edits(recolour).print(preset.name, "lamp's colour → draft");
        }
        if let Some(term) = blobs(&scene) {
            hand.edits(|turn| thin(term, turn)).print(preset.name, "blob's extinction → draft");
        }
        hand.rests().print(preset.name, "view → full, after the rest of 120 ms");
        requests(&server, scene).print(preset.name, "request → draft");
    }
}

struct Hand {
    viewer: Viewer,
    scene: Value,
}

impl Hand {
    /// Moves the camera a little, and says so.
    fn look(&mut self, turn: usize) -> usize {
        let mut camera = self.scene["camera"].clone();
        let x = camera["position"][0].as_f64().unwrap_or(0.0);
        camera["position"][0] = json!(x + 1e-3 * turn as f64);
        self.viewer.seq += 1;
        let view = json!({ "type": "view", "seq": self.viewer.seq, "camera": camera, "width": SIZE[0],
            "height": SIZE[1] });
        self.viewer.say(&view);
        view.to_string().len()
    }

    fn frame(&mut self, is_it: impl Fn(&Value) -> bool) -> (Value, usize) {
        self.viewer.hear_until(|heard| match heard {
            Heard::Frame(header, picture) if is_it(header) => {
                Some((header.clone(), picture.len() + header.to_string().len() + 4))
            }
            _ => None,
        })
    }

    fn orbit(&mut self, tier: &str) -> Frames {
        let mut frames = Frames::default();
        for turn in 0..MOVES + WARM {
            let began = Instant::now();
            let up = self.look(turn);
            let seq = self.viewer.seq;
            let frame = self.frame(|header| header["seq"] == seq && header["tier"] == tier);
            if turn >= WARM {
                frames.add(frame, began.elapsed().as_secs_f64() * 1e3, up);
            }
        }
        frames
    }

    fn rests(&mut self) -> Frames {
        let mut frames = Frames::default();
        for turn in 0..RESTS {
            let began = Instant::now();
            let up = self.look(1000 + turn);
            let seq = self.viewer.seq;
            let frame = self.frame(|header| header["seq"] == seq && header["tier"] == "full");
            frames.add(frame, began.elapsed().as_secs_f64() * 1e3, up);
        }
        frames
    }

    fn edits(&mut self, edit: impl Fn(usize) -> Value) -> Frames {
        let mut frames = Frames::default();
        for turn in 0..MOVES + WARM {
            let edit = edit(turn);
            let began = Instant::now();
            self.viewer.edit(&edit);
            let revision = self.viewer.hear_until(|heard| {
                heard.of_type("scene").map(|change| change["revision"].clone())
            });
            let frame = self.frame(|header| header["revision"] == revision);
            if turn >= WARM {
                frames.add(frame, began.elapsed().as_secs_f64() * 1e3, edit.to_string().len() + 35);
            }
        }
        frames
    }
}

fn replace(path: &str, value: &Value) -> Value {
    json!({ "op": "patch", "patch": [{ "op": "replace", "path": path, "value": value }] })
}

fn recolour(turn: usize) -> Value {
    replace("/lights/0/intensity", &json!([30.0 + turn as f64, 30.0, 25.0]))
}

fn has_lamp(scene: &Value) -> bool {
    scene["lights"][0]["kind"] == "point"
}

fn blobs(scene: &Value) -> Option<usize> {
    let terms = scene["fog"]["terms"].as_array()?;
    terms.iter().position(|term| term["kind"] == "gaussians")
}

fn thin(term: usize, turn: usize) -> Value {
    let path = format!("/fog/terms/{term}/blobs/0/extinction");
    replace(&path, &json!(0.01 + 1e-4 * turn as f64))
}

/// The page without a socket.
fn requests(server: &Server, scene: Value) -> Frames {
    let mut frames = Frames::default();
    let mut body =
        json!({ "scene": scene, "width": SIZE[0], "height": SIZE[1], "quality": "draft" });
    for turn in 0..MOVES / 5 {
        let x = body["scene"]["camera"]["position"][0].as_f64().unwrap_or(0.0);
        body["scene"]["camera"]["position"][0] = json!(x + 1e-3 * turn as f64);
        let text = body.to_string();
        let up = text.len();
        let began = Instant::now();
        let request = Request::post("/v1/render", text).header("accept", "image/jpeg");
        let answer = server.send(&request).expect_success();
        let ms = began.elapsed().as_secs_f64() * 1e3;
        let timing = answer.expect_header("server-timing").split(", ").filter_map(|part| {
            let (name, ms) = part.split_once(";dur=").or(part.split_once(";desc=reused;dur="))?;
            Some((name.split(';').next().unwrap_or(name).to_owned(), ms.parse::<f64>().ok()?))
        });
        let timing: serde_json::Map<_, _> = timing.map(|(name, ms)| (name, json!(ms))).collect();
        frames.add((json!({ "timing_ms": timing }), answer.body.len()), ms, up);
    }
    frames
}
