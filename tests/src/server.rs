//! A `fogbank` of a test's own: the real program, on a free port, gone when the test ends.

use crate::http::{Answer, Request};
use serde_json::Value;
use std::io::{BufRead, BufReader, Read};
use std::path::PathBuf;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::OnceLock;

/// The program: `FOGBANK_BIN`, or what cargo builds now.
pub fn program() -> PathBuf {
    static PROGRAM: OnceLock<PathBuf> = OnceLock::new();
    PROGRAM
        .get_or_init(|| std::env::var_os("FOGBANK_BIN").map_or_else(build, PathBuf::from))
        .clone()
}

fn build() -> PathBuf {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()));
    // The whole workspace, so that features, and with them the artefacts, are those of the tests.
    cargo.args(["build", "--quiet", "--workspace", "--bin", "fogbank"]).current_dir(root);
    cargo.args(["--message-format", "json-render-diagnostics"]);
    let output = cargo.stderr(Stdio::inherit()).output().expect("cargo runs");
    assert!(output.status.success(), "the program cannot be built");
    let messages = String::from_utf8(output.stdout).expect("text from cargo");
    let messages = messages.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
    let mut programs = messages.filter_map(|message| Some(message["executable"].as_str()?.into()));
    programs.next().expect("cargo names the program")
}

/// The program with arguments, and nothing of it in the environment.
pub fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(program());
    for (name, _) in std::env::vars_os() {
        if name.to_string_lossy().starts_with("FOGBANK_") {
            command.env_remove(name);
        }
    }
    // As on a server, where nobody is logged in: nothing may complain of that on standard error.
    command.env_remove("XDG_RUNTIME_DIR");
    command.env("FOGBANK_LOG", "warn").args(arguments).stdin(Stdio::null());
    command
}

/// A running server.
#[derive(Debug)]
pub struct Server {
    child: Child,
    stdout: BufReader<ChildStdout>,
    /// The first line on its standard output.
    pub line: String,
    /// `127.0.0.1:PORT`.
    pub address: String,
}

impl Server {
    /// Starts one.
    pub fn start() -> Self {
        Self::with(&[])
    }

    /// Starts one with further arguments.
    pub fn with(arguments: &[&str]) -> Self {
        Self::spawn(command(&[]), arguments)
    }

    /// Starts one by a command of one's own, with further arguments.
    pub fn spawn(mut command: Command, arguments: &[&str]) -> Self {
        command.args(["serve", "--listen", "127.0.0.1:0"]).args(arguments);
        let mut child = command.stdout(Stdio::piped()).spawn().expect("the server starts");
        let mut stdout = BufReader::new(child.stdout.take().expect("a pipe"));
        let mut line = String::new();
        stdout.read_line(&mut line).expect("a line of text");
        let address = line.trim_end().strip_prefix("listening on http://").unwrap_or_default();
        assert!(!address.is_empty(), "the first line is {line:?}");
        Self { child, stdout, address: address.to_owned(), line }
    }

    /// Sends a request.
    pub fn send(&self, request: &Request) -> Answer {
        request.send(&self.address)
    }

    /// Gets a path.
    pub fn get(&self, path: &str) -> Answer {
        self.send(&Request::new("GET", path))
    }

    /// Posts JSON.
    pub fn post(&self, path: &str, body: &Value) -> Answer {
        self.send(&Request::post(path, body.to_string()))
    }

    /// Posts JSON and asks for a media type.
    pub fn post_for(&self, path: &str, body: &Value, accept: &str) -> Answer {
        self.send(&Request::post(path, body.to_string()).header("accept", accept))
    }

    /// Whether it still answers and renders.
    #[track_caller]
    pub fn expect_healthy(&self) {
        self.get("/healthz").expect_success();
        self.get("/readyz").expect_success();
        let body = serde_json::json!({ "scene": {}, "width": 2, "height": 2 });
        self.post("/v1/render", &body).expect_success();
    }

    /// Asks it to stop.
    pub fn terminate(&self) {
        let kill = Command::new("kill").arg(self.child.id().to_string()).status();
        assert!(kill.expect("kill runs").success());
    }

    /// Ends it at once, without a chance to do anything more.
    pub fn kill(&self) {
        let kill = Command::new("kill").args(["-9", &self.child.id().to_string()]).status();
        assert!(kill.expect("kill runs").success());
    }

    /// Sends a request with a body of some type.
    pub fn send_as(&self, method: &str, path: &str, content_type: &str, body: &Value) -> Answer {
        self.send(&Request::with(method, path, content_type, body.to_string()))
    }

    /// Puts JSON.
    pub fn put(&self, path: &str, body: &Value) -> Answer {
        self.send_as("PUT", path, "application/json", body)
    }

    /// Waits until it has ended by itself, and answers its exit code.
    pub fn exit_code(mut self) -> Option<i32> {
        self.child.wait().expect("it ends").code()
    }

    /// The most memory that it has had at a time, in bytes, as the system counts it.
    pub fn peak_memory_bytes(&self) -> usize {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.child.id()));
        let status = status.expect("a system that counts");
        let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).expect("a peak");
        let kib = peak.trim().trim_end_matches(" kB").parse::<usize>().expect("a number");
        kib << 10
    }

    /// Stops it and answers what it wrote on standard output after the first line.
    pub fn stop(mut self) -> String {
        self.child.kill().expect("it can be stopped");
        self.child.wait().expect("it ends");
        let mut rest = String::new();
        self.stdout.read_to_string(&mut rest).expect("text");
        rest
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        // It may have been stopped already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
