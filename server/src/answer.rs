//! The shapes of successful answers.

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
            let bytes = self.gzip.get_or_init(|| gzip(&self.bytes)).clone();
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
fn members(headers: &HeaderMap, name: HeaderName) -> impl Iterator<Item = &str> {
    let lines = headers.get_all(name).into_iter().filter_map(|line| line.to_str().ok());
    lines.flat_map(|line| line.split(',')).map(str::trim)
}

fn gzip(bytes: &[u8]) -> Bytes {
    let mut packed = Vec::new();
    // Reading from memory cannot fail.
    let _ = GzEncoder::new(bytes, Compression::fast()).read_to_end(&mut packed);
    packed.into()
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
