//! Clients that mean harm: health is told all the while, memory stays bounded, and when the attack is
//! over, or its time is, the server works as before.

use fogbank_tests::http::{Answer, Request, connect, connect_from, finish};
use fogbank_tests::server::{Server, command};
use serde_json::{Value, json};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// More than one client may have and than all may have, fewer than a process may have open.
const SOCKETS: usize = 600;

/// Whoever watches the server gives up after about so long; measured are milliseconds.
const WATCH_TIME: Duration = Duration::from_secs(5);

/// A client that is waited for in vain is left after 20 s at the latest.
const RECOVERY_TIME: Duration = Duration::from_secs(120);

/// The server at rest takes 100 MB, and answers and frames on their way are bounded to 512 MiB each.
const MEMORY_BYTES: usize = 1500 << 20;

/// One attack at a time: they are measured, and each takes many sockets.
fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

fn quick() -> Value {
    json!({ "scene": {}, "width": 8, "height": 8 })
}

/// Asks for health again and again until it is told to stop; how long each answer took.
fn watch(server: &Server, over: &AtomicBool) -> Vec<Duration> {
    let mut times = Vec::new();
    while !over.load(Ordering::Relaxed) {
        let began = Instant::now();
        server.get("/healthz").expect_success();
        times.push(began.elapsed());
        std::thread::sleep(Duration::from_millis(5));
    }
    times
}

/// Lets an attack begin, and keeps what it holds for `hold`, while health is watched. Answers what
/// it holds.
fn attack<T: Send>(
    what: &str,
    server: &Server,
    hold: Duration,
    begin: impl FnOnce() -> T + Send,
) -> T {
    let over = AtomicBool::new(false);
    let (held, mut times) = std::thread::scope(|scope| {
        let watch = scope.spawn(|| watch(server, &over));
        let held = begin();
        std::thread::sleep(hold);
        over.store(true, Ordering::Relaxed);
        (held, watch.join().expect("health is told"))
    });
    times.sort();
    let (p99, longest) = (times[times.len() * 99 / 100], times[times.len() - 1]);
    let memory = server.peak_memory_bytes();
    let (count, memory_mb) = (times.len(), memory / 1_000_000);
    println!(
        "{what}: healthz {count} times, p99 {p99:.1?}, longest {longest:.1?}; peak {memory_mb} MB"
    );
    assert!(longest < WATCH_TIME, "{what}: {longest:?}");
    assert!(memory < MEMORY_BYTES, "{what}: {memory} bytes");
    held
}

/// Opens many connections and sends the same on each; none of them reads.
fn send_on_many(server: &Server, bytes: &[u8]) -> Vec<TcpStream> {
    let begin = |_| {
        let mut stream = connect(&server.address);
        // The server may have closed it already.
        let _ = stream.write_all(bytes);
        stream
    };
    (0..SOCKETS).map(begin).collect()
}

/// What another client is answered meanwhile.
fn from_elsewhere(server: &Server, request: &Request) -> Answer {
    let mut stream = connect_from([127, 0, 0, 2], &server.address);
    stream.write_all(&request.bytes()).unwrap();
    finish(stream)
}

/// The attackers' own address gets work done again, whether or not they go.
fn expect_recovery(server: &Server) {
    let end = Instant::now() + RECOVERY_TIME;
    loop {
        let answer = server.post("/v1/render", &quick());
        if answer.status == 200 {
            return;
        }
        answer.expect_problem(503);
        assert!(Instant::now() < end, "still {}", answer.text());
        std::thread::sleep(Duration::from_millis(50));
    }
}

#[test]
fn answers_that_nobody_reads_lock_nobody_out() {
    let _alone = alone();
    let server = Server::start();
    let request = Request::new("GET", "/v1/presets").bytes();
    let held = attack("unread presets", &server, Duration::from_secs(3), || {
        send_on_many(&server, &request)
    });
    let render = Request::post("/v1/render", quick().to_string());
    from_elsewhere(&server, &render).expect_success();
    expect_recovery(&server);
    drop(held);
    server.expect_healthy();
}

#[test]
fn large_pictures_that_nobody_reads_are_bounded() {
    let _alone = alone();
    let server = Server::with(&["--queue", "64", "--deadline-s", "120"]);
    let body = json!({ "scene": {}, "width": 8192, "height": 1024 }).to_string();
    let request = Request::post("/v1/render", body).header("accept", "application/x-npy").bytes();
    let mut held = attack("unread pictures", &server, Duration::from_secs(3), || {
        let begin = |_| {
            let mut stream = connect(&server.address);
            stream.write_all(&request).unwrap();
            stream
        };
        (0..40).map(begin).collect::<Vec<_>>()
    });
    // Small answers are not refused meanwhile.
    server.post("/v1/render", &quick()).expect_success();
    // Most are refused at once, before anything is rendered for them.
    let mut refused = 0;
    for stream in &mut held {
        stream.set_read_timeout(Some(Duration::from_millis(10))).unwrap();
        let mut line = [0; 12];
        let read = stream.read_exact(&mut line);
        refused += usize::from(read.is_ok() && &line == b"HTTP/1.1 503");
    }
    assert!((30..40).contains(&refused), "{refused} are refused");
    let end = Instant::now() + RECOVERY_TIME;
    while server.post_for("/v1/render", &quick_large(), "application/x-npy").status != 200 {
        assert!(Instant::now() < end, "large pictures are still refused");
        std::thread::sleep(Duration::from_millis(100));
    }
    server.expect_healthy();
}

/// Too large to be made while the room for answers is taken.
fn quick_large() -> Value {
    json!({ "scene": {}, "width": 8192, "height": 1024, "layer": "normal" })
}

#[test]
fn half_sent_bodies_lock_nobody_out() {
    let _alone = alone();
    let server = Server::start();
    let head = "POST /v1/render HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/json\r\n";
    let head = format!("{head}content-length: {}\r\n\r\n", 32 << 20);
    let half = [head.as_bytes(), &vec![b' '; 31 << 20]].concat();
    let held = attack("half-sent bodies", &server, Duration::from_secs(1), || {
        let begin = |_| {
            let mut stream = connect(&server.address);
            let _ = stream.write_all(&half);
            stream
        };
        let held: Vec<_> = (0..8).map(begin).collect();
        server.post("/v1/render", &quick()).expect_success();
        held
    });
    let mut large = quick().to_string().into_bytes();
    large.resize(1 << 20, b' ');
    from_elsewhere(&server, &Request::post("/v1/render", large)).expect_success();
    for stream in held {
        let status = finish(stream).status;
        assert!([408, 503].contains(&status), "{status}");
    }
    server.expect_healthy();
}

#[test]
fn announced_bodies_lock_nobody_out() {
    let _alone = alone();
    let server = Server::start();
    let head = "POST /v1/render HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/json\r\n";
    let head = format!("{head}content-length: {}\r\n\r\n", 1 << 20);
    let held = attack("announced bodies", &server, Duration::from_secs(3), || {
        send_on_many(&server, head.as_bytes())
    });
    let render = Request::post("/v1/render", quick().to_string());
    from_elsewhere(&server, &render).expect_success();
    expect_recovery(&server);
    drop(held);
    server.expect_healthy();
}

#[test]
fn clients_that_say_nothing_lock_nobody_out() {
    let _alone = alone();
    let server = Server::start();
    let held = attack("silence", &server, Duration::from_secs(3), || send_on_many(&server, b""));
    let render = Request::post("/v1/render", quick().to_string());
    from_elsewhere(&server, &render).expect_success();
    expect_recovery(&server);
    drop(held);
    server.expect_healthy();
}

#[test]
fn a_flood_of_long_jobs_stops_no_short_one() {
    let _alone = alone();
    let server = Server::start();
    let blob = |i: i32| json!({ "center": [i % 7 - 3, i % 3, i % 5 - 2], "extinction": 0.5 });
    let blobs: Vec<_> = (0..200).map(blob).collect();
    let fog =
        json!({ "airlight": "reference", "terms": [{ "kind": "gaussians", "blobs": blobs }] });
    let scene = json!({ "lights": [{ "kind": "point" }], "fog": fog });
    let body = json!({ "scene": scene, "width": 1280, "height": 1024 }).to_string();
    let long = Request::post("/v1/render", body).bytes();
    let held = attack("long jobs", &server, Duration::from_secs(3), || {
        let held = send_on_many(&server, &long);
        from_elsewhere(&server, &Request::post("/v1/render", quick().to_string())).expect_success();
        held
    });
    drop(held);
    expect_recovery(&server);
    server.expect_healthy();
}

/// A server that logs every request to a pipe.
fn logging_to(pipe: std::io::PipeWriter) -> Server {
    let mut command = command(&[]);
    command.env("FOGBANK_LOG", "info").stderr(pipe);
    Server::spawn(command, &[])
}

#[test]
fn a_log_that_cannot_be_written_costs_no_request() {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let server = logging_to(writer);
    for _ in 0..3 {
        server.expect_healthy();
    }
    server.terminate();
    assert_eq!(server.exit_code(), Some(0));
}

#[test]
fn a_log_that_nobody_reads_costs_no_request() {
    let (_reader, writer) = std::io::pipe().unwrap();
    let server = logging_to(writer);
    // Each is a line as long as the pipe.
    let long = format!("/{}", "x".repeat(60_000));
    for _ in 0..8 {
        server.get(&long).expect_problem(404);
    }
    server.expect_healthy();
    server.terminate();
    assert_eq!(server.exit_code(), Some(0));
}
