//! A viewer of a live preview: a client of the socket `fogbank.v1`.

use serde_json::{Value, json};
use std::net::TcpStream;
use std::time::Duration;
use tungstenite::client::IntoClientRequest;
use tungstenite::protocol::CloseFrame;
use tungstenite::{Error, Message, WebSocket};

/// A viewer.
#[derive(Debug)]
pub struct Viewer {
    socket: WebSocket<TcpStream>,
    /// Its number of the last thing that it said.
    pub seq: u64,
}

/// What a viewer hears.
#[derive(Clone, Debug)]
pub enum Heard {
    /// A text.
    Text(Value),
    /// A frame: its header, and its picture.
    Frame(Value, Vec<u8>),
    /// The end.
    Closed(Option<u16>),
}

impl Heard {
    /// The text, if it is one of that type.
    pub fn of_type(&self, kind: &str) -> Option<&Value> {
        match self {
            Self::Text(text) if text["type"] == kind => Some(text),
            _ => None,
        }
    }
}

/// Opens a socket with some headers, and answers the status if there is none.
///
/// # Errors
/// The status of the refusal.
pub fn open(address: &str, id: &str, headers: &[(&str, &str)]) -> Result<Viewer, u16> {
    open_at(address, &format!("/v1/scenes/{id}/live"), headers)
}

/// The same at any path.
///
/// # Errors
/// The status of the refusal.
pub fn open_at(address: &str, path: &str, headers: &[(&str, &str)]) -> Result<Viewer, u16> {
    let url = format!("ws://localhost{path}");
    let mut request = url.into_client_request().expect("an address");
    for (name, value) in headers {
        let name: tungstenite::http::HeaderName = name.parse().expect("a name");
        request.headers_mut().insert(name, value.parse().expect("a value"));
    }
    let stream = crate::http::connect(address);
    stream.set_nodelay(true).expect("a socket");
    match tungstenite::client(request, stream) {
        Ok((socket, _)) => Ok(Viewer { socket, seq: 0 }),
        Err(tungstenite::HandshakeError::Failure(Error::Http(answer))) => {
            Err(answer.status().as_u16())
        }
        Err(other) => panic!("{other}"),
    }
}

impl Viewer {
    /// Opens a viewer of a scene, and hears its first word.
    pub fn of(address: &str, id: &str) -> (Self, Value) {
        let protocol = [("sec-websocket-protocol", "fogbank.v1")];
        let mut viewer = open(address, id, &protocol).expect("a socket");
        let hello = viewer.hear();
        let hello = hello.of_type("hello").unwrap_or_else(|| panic!("{hello:?}")).clone();
        (viewer, hello)
    }

    /// Says anything.
    pub fn say(&mut self, message: &Value) {
        self.socket.send(Message::text(message.to_string())).expect("an open socket");
    }

    /// Sends bytes.
    pub fn send(&mut self, bytes: Vec<u8>) {
        self.socket.send(Message::binary(bytes)).expect("an open socket");
    }

    /// Wants to see the scene from there.
    pub fn look(&mut self, position: [f64; 3], size: [u32; 2]) -> u64 {
        self.seq += 1;
        let camera = json!({ "position": position, "target": [0, 1, 0] });
        let (seq, [width, height]) = (self.seq, size);
        self.say(&json!({ "type": "view", "seq": seq, "camera": camera, "width": width, "height": height }));
        seq
    }

    /// Edits the scene.
    pub fn edit(&mut self, edit: &Value) -> u64 {
        self.seq += 1;
        self.say(&json!({ "type": "edit", "seq": self.seq, "edit": edit }));
        self.seq
    }

    /// Acknowledges a frame.
    pub fn acknowledge(&mut self, header: &Value) {
        self.say(&json!({ "type": "ack", "frame": header["frame"] }));
    }

    /// Hears the next thing, within a time that is longer than any test waits for.
    pub fn hear(&mut self) -> Heard {
        self.hear_for(Duration::from_secs(60)).expect("something is said")
    }

    /// Hears the next thing, if it comes within a time.
    pub fn hear_for(&mut self, time: Duration) -> Option<Heard> {
        self.socket.get_ref().set_read_timeout(Some(time)).expect("a timeout");
        loop {
            match self.socket.read() {
                Ok(Message::Text(text)) => {
                    return Some(Heard::Text(serde_json::from_str(&text).expect("JSON")));
                }
                Ok(Message::Binary(bytes)) => {
                    let (length, rest) = bytes.split_at(4);
                    let length =
                        u32::from_le_bytes(length.try_into().expect("four bytes")) as usize;
                    let header = serde_json::from_slice(&rest[..length]).expect("a header");
                    return Some(Heard::Frame(header, rest[length..].to_vec()));
                }
                Ok(Message::Close(close)) => return Some(Heard::Closed(close.map(code))),
                Ok(_) => {}
                Err(Error::Io(error))
                    if matches!(
                        error.kind(),
                        std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut
                    ) =>
                {
                    return None;
                }
                Err(_) => return Some(Heard::Closed(None)),
            }
        }
    }

    /// Hears until something is what is looked for; frames that come meanwhile are acknowledged.
    pub fn hear_until<T>(&mut self, mut look: impl FnMut(&Heard) -> Option<T>) -> T {
        loop {
            let heard = self.hear();
            if let Heard::Frame(header, _) = &heard {
                self.acknowledge(header);
            }
            if let Some(found) = look(&heard) {
                return found;
            }
            assert!(!matches!(heard, Heard::Closed(_)), "{heard:?}");
        }
    }
}

fn code(close: CloseFrame) -> u16 {
    close.code.into()
}
