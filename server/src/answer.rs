//! The shapes of successful answers, and what they may take in memory together.

use crate::budget::{Budget, Client, Held};
use crate::problem::Problem;
use axum::body::Bytes;
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use flate2::Compression;
use flate2::read::GzEncoder;
use serde::Serialize;
use sha2::{Digest, Sha256};
use std::io::Read;
use std::sync::{Arc, OnceLock};

/// Media type of JSON answers.
pub const JSON: &str = "application/json";

/// All answers together that may be made or be on their way to clients at a time [bytes].
const ALL_ANSWERS_BYTES: usize = 512 << 20;

/// The part of them that one client may wait for.
const CLIENT_ANSWERS_BYTES: usize = 384 << 20;

/// Answers up to this size [bytes] do not count among all: as many as there are connections fit
/// into memory, and so they come through whatever large ones there are.
const SMALL_BYTES: usize = 64 << 10;

/// JSON of less [bytes] is not worth compressing: it fits into a packet.
const PACKET_BYTES: usize = 1400;

/// Bounds what answers take together, from before they are made until they are sent.
#[derive(Clone)]
pub struct Answers(Budget);

impl Answers {
    /// Nothing is on its way.
    pub fn new() -> Self {
        Self(Budget::new(ALL_ANSWERS_BYTES, CLIENT_ANSWERS_BYTES))
    }

    /// Makes room for an answer of at most so many bytes.
    ///
    /// # Errors
    /// 503 when there is none.
    pub fn reserve(&self, client: Client, most_bytes: usize) -> Result<Held, Problem> {
        let units = if most_bytes <= SMALL_BYTES { 0 } else { most_bytes };
        let full = |_| Problem::busy("too many large answers at a time");
        self.0.take(client, units).map_err(full)
    }
}

/// Bytes that keep their room until the last of them is sent.
pub fn kept(bytes: Vec<u8>, mut room: Held) -> Bytes {
    struct Kept(Vec<u8>, #[expect(dead_code, reason = "it counts until it is dropped")] Held);
    impl AsRef<[u8]> for Kept {
        fn as_ref(&self) -> &[u8] {
            &self.0
        }
    }
    room.keep(bytes.len());
    Bytes::from_owner(Kept(bytes, room))
}

/// JSON that may be large, compressed for whoever takes that: not for a thread that serves others.
pub fn large_json(value: &impl Serialize, request: &HeaderMap, room: Held) -> Response {
    let text = serde_json::to_vec(value).unwrap_or_default();
    let vary = [(header::VARY, HeaderValue::from_static("accept-encoding"))];
    if text.len() < PACKET_BYTES || !takes_gzip(request) {
        return (vary, json_text(kept(text, room))).into_response();
    }
    let encoding = [(header::CONTENT_ENCODING, HeaderValue::from_static("gzip"))];
    (vary, encoding, json_text(kept(gzip(&text), room))).into_response()
}

/// A value as JSON.
pub fn json(value: &impl Serialize) -> Response {
    json_text(serde_json::to_vec(value).unwrap_or_default().into())
}

/// JSON that is text already.
pub fn json_text(text: Bytes) -> Response {
    ([(header::CONTENT_TYPE, HeaderValue::from_static(JSON))], text).into_response()
}

/// A strong entity tag: the same bytes have the same one.
pub fn etag(bytes: &[u8]) -> String {
    let hash = Sha256::digest(bytes);
    let hex: String = hash.iter().take(16).map(|byte| format!("{byte:02x}")).collect();
    format!("\"{hex}\"")
}

/// An answer that never changes while the program runs: a file of the page, a list.
#[derive(Clone)]
pub struct Fixed {
    content_type: &'static str,
    bytes: Bytes,
    /// The same, compressed once, when the first client asks for it.
    gzip: Arc<OnceLock<Bytes>>,
    etag: HeaderValue,
}

impl Fixed {
    /// Keeps `bytes` with their entity tag; it is weak, for they may be compressed.
    pub fn new(content_type: &'static str, bytes: impl Into<Bytes>) -> Self {
        let bytes = bytes.into();
        let etag = format!("W/{}", etag(&bytes));
        let etag = HeaderValue::try_from(etag).unwrap_or(HeaderValue::from_static("W/\"\""));
        Self { content_type, bytes, gzip: Arc::default(), etag }
    }

    /// Compresses it now, where that takes its time.
    pub fn compressed(self) -> Self {
        self.gzip.get_or_init(|| gzip(&self.bytes).into());
        self
    }

    /// The bytes, or 304 when the client has them already.
    pub fn answer(&self, request: &HeaderMap) -> Response {
        let headers = [
            (header::ETAG, self.etag.clone()),
            (header::CACHE_CONTROL, HeaderValue::from_static("no-cache")),
            (header::VARY, HeaderValue::from_static("accept-encoding")),
        ];
        if self.is_known(request) {
            return (StatusCode::NOT_MODIFIED, headers).into_response();
        }
        let content_type = [(header::CONTENT_TYPE, HeaderValue::from_static(self.content_type))];
        if takes_gzip(request) {
            let encoding = [(header::CONTENT_ENCODING, HeaderValue::from_static("gzip"))];
            let bytes = self.gzip.get_or_init(|| gzip(&self.bytes).into()).clone();
            return (headers, content_type, encoding, bytes).into_response();
        }
        (headers, content_type, self.bytes.clone()).into_response()
    }

    fn is_known(&self, request: &HeaderMap) -> bool {
        let own = self.etag.to_str().unwrap_or_default().trim_start_matches("W/");
        let mut tags = members(request, header::IF_NONE_MATCH);
        tags.any(|tag| tag == "*" || tag.trim_start_matches("W/") == own)
    }
}

fn takes_gzip(request: &HeaderMap) -> bool {
    members(request, header::ACCEPT_ENCODING).any(|member| {
        let (name, weight) = member.split_once(';').unwrap_or((member, ""));
        let q = weight.trim().strip_prefix("q=").and_then(|q| q.parse::<f32>().ok());
        name.trim().eq_ignore_ascii_case("gzip") && q != Some(0.0)
    })
}

/// The members of a header that is a list.
pub fn members(headers: &HeaderMap, name: HeaderName) -> impl Iterator<Item = &str> {
    let lines = headers.get_all(name).into_iter().filter_map(|line| line.to_str().ok());
    lines.flat_map(|line| line.split(',')).map(str::trim)
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut packed = Vec::new();
    // Reading from memory cannot fail.
    let _ = GzEncoder::new(bytes, Compression::fast()).read_to_end(&mut packed);
    packed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_client_has_is_not_sent_again() {
        let fixed = Fixed::new("text/plain", "fog");
        let first = fixed.answer(&HeaderMap::new());
        assert_eq!(first.status(), 200);
        let mut headers = HeaderMap::new();
        headers.insert(header::IF_NONE_MATCH, first.headers()[header::ETAG].clone());
        assert_eq!(fixed.answer(&headers).status(), 304);
        headers.insert(header::IF_NONE_MATCH, HeaderValue::from_static("\"other\""));
        assert_eq!(fixed.answer(&headers).status(), 200);
    }

    #[test]
    fn large_answers_count_until_they_are_dropped_and_small_ones_do_not() {
        let answers = Answers::new();
        let client = Client::default();
        let mut room = answers.reserve(client, CLIENT_ANSWERS_BYTES).unwrap();
        assert_eq!(answers.reserve(client, SMALL_BYTES + 1).unwrap_err().status(), 503);
        assert!(answers.reserve(client, SMALL_BYTES).is_ok());
        room.keep(CLIENT_ANSWERS_BYTES / 2);
        let bytes = kept(vec![0; 1 << 20], room);
        let part = bytes.slice(..1);
        drop(bytes);
        let all_but = |bytes| answers.reserve(client, CLIENT_ANSWERS_BYTES - bytes).is_ok();
        assert!(all_but(1 << 20) && !all_but(0));
        drop(part);
        assert!(all_but(0));
    }

    #[test]
    fn large_json_is_compressed_for_whoever_takes_that() {
        let room = || Answers::new().reserve(Client::default(), 0).unwrap();
        let gzip =
            HeaderMap::from_iter([(header::ACCEPT_ENCODING, HeaderValue::from_static("gzip"))]);
        let encoding = |count: usize, request: &HeaderMap| {
            let answer = large_json(&vec![0; count], request, room());
            answer.headers().get(header::CONTENT_ENCODING).cloned()
        };
        assert_eq!(encoding(10_000, &gzip).unwrap(), "gzip");
        assert_eq!(encoding(10_000, &HeaderMap::new()), None);
        assert_eq!(encoding(10, &gzip), None);
    }

    #[test]
    fn it_is_compressed_for_whoever_takes_that() {
        let fixed = Fixed::new("text/plain", "fog");
        let encoding = |accept: &'static str| {
            let headers = [(header::ACCEPT_ENCODING, HeaderValue::from_static(accept))];
            let answer = fixed.answer(&headers.into_iter().collect());
            answer.headers().get(header::CONTENT_ENCODING).cloned()
        };
        assert_eq!(encoding("br, gzip;q=0.5").unwrap(), "gzip");
        assert_eq!(encoding("gzip;q=0, identity"), None);
        assert_eq!(encoding("br"), None);
    }
}
