//! Many clients at a time.

use super::quantile;
use fogbank_tests::directory::Directory;
use fogbank_tests::http::Request;
use fogbank_tests::server::Server;
use serde_json::{Value, json};
use std::time::{Duration, Instant};

const TIME: Duration = Duration::from_secs(10);
const MIXED: Duration = Duration::from_secs(60);

fn scene() -> Value {
    let blob = |i: u32| json!({ "center": [f64::from(i % 20), 1.0, f64::from(i / 20)], "extinction": 0.05 });
    json!({
        "camera": { "position": [10, 4, 30], "target": [10, 1, 5] },
        "surfaces": [{ "shape": { "kind": "plane" } }],
        "lights": [{ "kind": "point", "position": [10, 4, 8], "intensity": [200, 180, 150] }],
        "fog": { "terms": [{ "kind": "gaussians", "blobs": (0..200).map(blob).collect::<Vec<_>>() }] },
    })
}

/// What some clients came to in a time.
#[derive(Default)]
struct Sum {
    times: Vec<f64>,
    busy: usize,
    other: usize,
}

fn run(
    server: &Server,
    clients: usize,
    time: Duration,
    request: impl Fn(usize, u64) -> Request + Sync,
) -> Sum {
    let began = Instant::now();
    let one = |client: usize| {
        let mut sum = Sum::default();
        let mut turn = 0;
        while began.elapsed() < time {
            turn += 1;
            let request = request(client, turn);
            let since = Instant::now();
            match request.try_send(&server.address).map(|answer| answer.status) {
                Ok(200 | 304) => sum.times.push(since.elapsed().as_secs_f64() * 1e3),
                Ok(429 | 503) => sum.busy += 1,
                _ => sum.other += 1,
            }
        }
        sum
    };
    std::thread::scope(|scope| {
        let all: Vec<_> = (0..clients).map(|client| scope.spawn(move || one(client))).collect();
        let sums = all.into_iter().filter_map(|thread| thread.join().ok());
        sums.fold(Sum::default(), |mut all, mut one| {
            all.times.append(&mut one.times);
            Sum { busy: all.busy + one.busy, other: all.other + one.other, ..all }
        })
    })
}

/// So many clients, what they do, for how long, and a request of theirs.
type Row = (usize, &'static str, Duration, fn(usize, u64) -> Request);

fn edit(client: usize, turn: u64) -> Request {
    let patch = [json!({ "op": "replace", "path": "/fog/terms/0/blobs/7/extinction",
        "value": (turn % 100) as f64 / 1000.0 })];
    let edits = json!({ "edits": [{ "op": "patch", "patch": patch }] });
    Request::post(&format!("/v1/scenes/s{}/edits", client % 4), edits.to_string())
}

fn frame(client: usize, turn: u64) -> Request {
    let path = format!(
        "/v1/scenes/s{}/frame?width=320&height=240&quality=draft&time_s={turn}",
        client % 4
    );
    Request::new("GET", &path).header("accept", "image/jpeg")
}

pub fn print() {
    println!(
        "\n## Many clients\n\n\
         A connection a request. Edits are patches of one blob, of four scenes in a directory on disk; frames are drafts of\n\
         320×240.\n\n\
         | clients | what | a second | p50, ms | p99, ms | busy (429, 503) | failed | peak memory, MB |\n\
         |---|---|---|---|---|---|---|---|"
    );
    let rows: [Row; 3] = [
        (1, "edits", TIME, edit),
        (16, "edits", TIME, edit),
        (64, "edits and frames, half each", MIXED, |client, turn| {
            if client % 2 == 0 { edit(client, turn) } else { frame(client, turn) }
        }),
    ];
    for (clients, what, time, request) in rows {
        let directory = Directory::new();
        let server = Server::with(&["--data-dir", directory.text()]);
        for i in 0..4 {
            assert_eq!(server.put(&format!("/v1/scenes/s{i}"), &scene()).status, 201);
        }
        let mut sum = run(&server, clients, time, request);
        let all = (sum.times.len() + sum.busy + sum.other) as f64;
        println!(
            "| {clients} | {what} | {:.0} | {:.1} | {:.1} | {:.1} % | {} | {:.0} |",
            sum.times.len() as f64 / time.as_secs_f64(),
            quantile(&mut sum.times, 0.5),
            quantile(&mut sum.times, 0.99),
            100.0 * sum.busy as f64 / all,
            sum.other,
            server.peak_memory_bytes() as f64 / 1e6
        );
    }
}
