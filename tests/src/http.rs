//! The plainest HTTP/1.1 client: one request a connection, every byte in the test's hands.

use serde_json::Value;
use socket2::{Domain, Socket, Type};
use std::io::{self, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpStream};
use std::time::Duration;

/// Longer than any answer takes that a test waits for.
const PATIENCE: Duration = Duration::from_secs(300);

/// What a server answered.
#[derive(Clone, Debug)]
pub struct Answer {
    /// Its status.
    pub status: u16,
    /// Its headers, names in lower case.
    pub headers: Vec<(String, String)>,
    /// Its body.
    pub body: Vec<u8>,
}

impl Answer {
    /// A header, by its name in lower case.
    pub fn header(&self, name: &str) -> Option<&str> {
        self.headers.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str())
    }

    /// A header that must be there.
    pub fn expect_header(&self, name: &str) -> &str {
        self.header(name).unwrap_or_else(|| panic!("no header {name} in {:?}", self.headers))
    }

    /// The body as JSON.
    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap_or_else(|e| panic!("{e}: {}", self.text()))
    }

    /// The beginning of the body, to be shown.
    pub fn text(&self) -> String {
        String::from_utf8_lossy(&self.body[..self.body.len().min(600)]).into_owned()
    }

    /// The answer itself, which must be a success.
    #[track_caller]
    pub fn expect_success(self) -> Self {
        assert_eq!(self.status, 200, "{}", self.text());
        self
    }

    /// The problem details of a refusal, which must have this status and every member of RFC 9457.
    #[track_caller]
    pub fn expect_problem(&self, status: u16) -> Value {
        assert_eq!(self.status, status, "{}", self.text());
        assert_eq!(self.header("content-type"), Some("application/problem+json"));
        let problem = self.json();
        assert_eq!(problem["status"], status);
        assert_eq!(problem["type"], "about:blank");
        assert!(problem["title"].as_str().is_some_and(|title| !title.is_empty()), "{problem}");
        assert!(problem["detail"].as_str().is_some_and(|detail| !detail.is_empty()), "{problem}");
        assert!(problem["errors"].is_array(), "{problem}");
        problem
    }

    /// Reads an answer from what came until the connection closed.
    fn read(bytes: &[u8]) -> Self {
        let end = bytes.windows(4).position(|four| four == b"\r\n\r\n");
        let end = end.unwrap_or_else(|| panic!("no answer: {:?}", String::from_utf8_lossy(bytes)));
        let head = std::str::from_utf8(&bytes[..end]).expect("a head of text");
        let mut lines = head.split("\r\n");
        let status = lines.next().and_then(|line| line.split(' ').nth(1)).expect("a status line");
        let headers = lines.filter_map(|line| line.split_once(':'));
        let headers = headers.map(|(key, value)| (key.to_lowercase(), value.trim().to_owned()));
        let status = status.parse().expect("a status");
        let answer = Self { status, headers: headers.collect(), body: bytes[end + 4..].to_vec() };
        let length = answer.header("content-length").map(|text| text.parse::<usize>());
        if let Some(length) = length {
            assert_eq!(Ok(answer.body.len()), length, "the body is cut off");
        }
        answer
    }
}

/// A request to be sent.
#[derive(Clone, Debug)]
pub struct Request {
    method: String,
    path: String,
    headers: Vec<(String, String)>,
    body: Vec<u8>,
}

impl Request {
    /// A request without a body.
    pub fn new(method: &str, path: &str) -> Self {
        Self { method: method.into(), path: path.into(), headers: Vec::new(), body: Vec::new() }
    }

    /// Posts JSON.
    pub fn post(path: &str, body: impl Into<Vec<u8>>) -> Self {
        let post = Self::new("POST", path).header("content-type", "application/json");
        Self { body: body.into(), ..post }
    }

    /// A request with a body of some type.
    pub fn with(method: &str, path: &str, content_type: &str, body: impl Into<Vec<u8>>) -> Self {
        let request = Self::new(method, path).header("content-type", content_type);
        Self { body: body.into(), ..request }
    }

    /// With one more header.
    pub fn header(mut self, name: &str, value: &str) -> Self {
        self.headers.push((name.into(), value.into()));
        self
    }

    /// The bytes of the request.
    pub fn bytes(&self) -> Vec<u8> {
        let mut head = format!("{} {} HTTP/1.1\r\n", self.method, self.path);
        if !self.headers.iter().any(|(name, _)| name == "host") {
            head += "host: localhost\r\n";
        }
        let length = ("content-length".to_owned(), self.body.len().to_string());
        let close = ("connection".to_owned(), "close".to_owned());
        for (name, value) in self.headers.iter().chain([&length, &close]) {
            head += &format!("{name}: {value}\r\n");
        }
        [head.as_bytes(), b"\r\n", &self.body].concat()
    }

    /// Sends it and waits for the answer.
    pub fn send(&self, address: &str) -> Answer {
        exchange(address, &self.bytes())
    }

    /// The same of a server that may be gone.
    ///
    /// # Errors
    /// When no whole answer comes.
    pub fn try_send(&self, address: &str) -> io::Result<Answer> {
        let mut stream = patient(TcpStream::connect(address)?);
        stream.write_all(&self.bytes())?;
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer)?;
        let head = answer.windows(4).position(|four| four == b"\r\n\r\n");
        let head = head.ok_or(io::ErrorKind::UnexpectedEof)?;
        let text = String::from_utf8_lossy(&answer[..head]).to_lowercase();
        let length =
            text.lines().find_map(|line| line.strip_prefix("content-length: ")?.parse().ok());
        if length.is_some_and(|length: usize| answer.len() < head + 4 + length) {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        Ok(Answer::read(&answer))
    }
}

/// Opens a connection.
pub fn connect(address: &str) -> TcpStream {
    patient(TcpStream::connect(address).expect("a listening server"))
}

/// Opens a connection from another address of this machine.
pub fn connect_from(source: [u8; 4], address: &str) -> TcpStream {
    let socket = Socket::new(Domain::IPV4, Type::STREAM, None).expect("a socket");
    socket.bind(&SocketAddr::from((source, 0)).into()).expect("an address of this machine");
    let address: SocketAddr = address.parse().expect("an address");
    socket.connect(&address.into()).expect("a listening server");
    patient(socket.into())
}

fn patient(stream: TcpStream) -> TcpStream {
    stream.set_read_timeout(Some(PATIENCE)).expect("a read timeout");
    stream.set_write_timeout(Some(PATIENCE)).expect("a write timeout");
    stream
}

/// Sends bytes, whatever they are, and reads the answer.
pub fn exchange(address: &str, bytes: &[u8]) -> Answer {
    let mut stream = connect(address);
    // A server may answer and close before it has read everything.
    let _ = stream.write_all(bytes);
    finish(stream)
}

/// Reads the answer of a connection on which everything was sent.
pub fn finish(mut stream: TcpStream) -> Answer {
    let mut answer = Vec::new();
    let read = stream.read_to_end(&mut answer);
    let _ = stream.shutdown(Shutdown::Both);
    if let Err(error) = read {
        let reset = error.kind() == io::ErrorKind::ConnectionReset;
        assert!(reset && !answer.is_empty(), "{error} after {} bytes", answer.len());
    }
    Answer::read(&answer)
}
