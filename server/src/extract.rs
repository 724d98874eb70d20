//! From a request's body to a checked request: size, type and form are looked at here, once.

use crate::budget::{Budget, Client, Held};
use crate::conditional;
use crate::pace::{Least, Pace};
use crate::problem::Problem;
use axum::body::Body;
use axum::extract::Request;
use axum::http::{HeaderMap, StatusCode, header};
use fogbank_core::scene;
use http_body_util::BodyExt;
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::Semaphore;

/// Largest body of a request [bytes].
pub const BODY_BYTES: usize = 32 << 20;

/// All bodies together that may be in memory at a time [bytes]. Reading one takes at most 8 times its
/// size: a request that is all the smallest items there are is that much larger than its text.
const ALL_BODIES_BYTES: usize = 8 * BODY_BYTES;

/// The part of them that one client may send.
const CLIENT_BODIES_BYTES: usize = 6 * BODY_BYTES;

/// How long a client may take to send its body.
const BODY_TIME: Duration = Duration::from_secs(30);

/// The least of a body that must come meanwhile: a client that sends less holds a place for nothing.
const LEAST: Least = Least { bytes: 5 * (64 << 10), window: Duration::from_secs(5) };

/// Bodies up to this size [bytes] are read in well under a millisecond: no other thread needed.
/// They do not count among all bodies: as many as there are connections fit into memory, and so
/// they come through whatever large ones there are.
const SMALL_BYTES: usize = 64 << 10;

/// Reads bodies, and bounds what they take together.
#[derive(Clone)]
pub struct Intake {
    /// Bytes that have arrived and were not yet read into a request.
    bytes: Budget,
    /// One permit a large body that is being parsed.
    parsers: Arc<Semaphore>,
}

impl Intake {
    /// Parses at most `parsers` large bodies at a time.
    pub fn new(parsers: usize) -> Self {
        let bytes = Budget::new(ALL_BODIES_BYTES, CLIENT_BODIES_BYTES);
        Self { bytes, parsers: Arc::new(Semaphore::new(parsers)) }
    }

    /// The checked request that the body holds.
    ///
    /// # Errors
    /// 400, 408, 413, 415, 422 or 503, each where it is due.
    pub async fn read<T, C>(
        &self,
        request: Request,
        check: fn(T) -> Result<C, Vec<scene::Problem>>,
    ) -> Result<C, Problem>
    where
        T: DeserializeOwned + JsonSchema + 'static,
        C: Send + 'static,
    {
        self.digest(request, check).await.map(|body| body.value)
    }

    /// The same, and what tells it apart from others if it may be repeated.
    ///
    /// # Errors
    /// As [`Intake::read`].
    pub async fn digest<T, C>(
        &self,
        request: Request,
        check: fn(T) -> Result<C, Vec<scene::Problem>>,
    ) -> Result<Digested<C>, Problem>
    where
        T: DeserializeOwned + JsonSchema + 'static,
        C: Send + 'static,
    {
        let about = About::of(&request);
        check_headers(request.headers())?;
        let client = request.extensions().get().copied().unwrap_or_default();
        let collect = tokio::time::timeout(BODY_TIME, self.collect(client, request.into_body()));
        // Held until the bytes are read into a request.
        let (bytes, _held) = collect.await.map_err(|_| too_slow())??;
        let is_small = bytes.len() <= SMALL_BYTES;
        let parse = move || {
            let value = check(scene::read::<T>(&bytes)?).map_err(Problem::invalid)?;
            Ok(Digested { value, digest: about.digest(&bytes) })
        };
        if is_small {
            return parse();
        }
        let _parser = self.parsers.acquire().await.map_err(|_| Problem::broken())?;
        tokio::task::spawn_blocking(parse).await?
    }

    /// Takes memory for what came, never for what was announced.
    async fn collect(&self, client: Client, mut body: Body) -> Result<(Vec<u8>, Held), Problem> {
        let full = |_| Problem::busy("too many large requests at a time");
        let mut bytes = Vec::new();
        let mut held = self.bytes.take(client, 0).map_err(full)?;
        let mut pace = Pace::new(LEAST);
        while let Some(frame) = pace.unless_too_slow(body.frame()).await.ok_or_else(too_slow)? {
            let frame = frame.map_err(|error| {
                Problem::new(StatusCode::BAD_REQUEST, format!("the body broke off: {error}"))
            })?;
            let Ok(data) = frame.into_data() else { continue };
            let length = bytes.len() + data.len();
            if length > BODY_BYTES {
                return Err(too_large());
            }
            if length > SMALL_BYTES {
                held.take(data.len()).map_err(full)?;
            }
            pace.moved(data.len());
            bytes.extend_from_slice(&data);
        }
        Ok((bytes, held))
    }
}

/// What a body held, and a number that other requests hardly have.
pub struct Digested<T> {
    /// The checked request.
    pub value: T,
    /// Of method, address and body; 0 where the request has no key.
    pub digest: u64,
}

/// What tells a request with this body apart from others.
pub fn digest_of(request: &Request, body: &[u8]) -> u64 {
    About::of(request).digest(body)
}

/// Method and address, where the request has a key.
struct About(Option<String>);

impl About {
    fn of(request: &Request) -> Self {
        let has_key = request.headers().contains_key(conditional::KEY);
        Self(has_key.then(|| format!("{} {}", request.method(), request.uri())))
    }

    fn digest(&self, body: &[u8]) -> u64 {
        let Self(Some(about)) = self else { return 0 };
        let hash = Sha256::new().chain_update(about).chain_update(body).finalize();
        hash.iter().take(8).fold(0, |sum, byte| sum << 8 | u64::from(*byte))
    }
}

fn check_headers(headers: &HeaderMap) -> Result<(), Problem> {
    let unsupported = |detail| Problem::new(StatusCode::UNSUPPORTED_MEDIA_TYPE, detail);
    let text = |name| headers.get(name).map(|value| value.to_str().unwrap_or_default());
    // A browser posts for a page of another site without asking only what has another type or none.
    if !text(header::CONTENT_TYPE).is_some_and(is_json) {
        return Err(unsupported("the body must be application/json"));
    }
    if text(header::CONTENT_ENCODING).is_some_and(|value| !value.eq_ignore_ascii_case("identity")) {
        return Err(unsupported("the body must not be compressed"));
    }
    let length = text(header::CONTENT_LENGTH).map(str::parse::<usize>);
    if length.is_some_and(|length| length.is_ok_and(|length| length > BODY_BYTES)) {
        return Err(too_large());
    }
    Ok(())
}

/// `application/json`, or any type of the form `application/….+json`; parameters do not matter.
fn is_json(content_type: &str) -> bool {
    let name = content_type.split(';').next().unwrap_or_default().trim().to_ascii_lowercase();
    name == "application/json" || name.ends_with("+json")
}

fn too_large() -> Problem {
    let detail = format!("a body may have {BODY_BYTES} bytes");
    Problem::new(StatusCode::PAYLOAD_TOO_LARGE, detail)
}

fn too_slow() -> Problem {
    let (all, bytes, window) = (BODY_TIME.as_secs(), LEAST.bytes, LEAST.window.as_secs());
    let detail =
        format!("the body must arrive within {all} s, and {bytes} bytes of it in every {window} s");
    Problem::new(StatusCode::REQUEST_TIMEOUT, detail)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fogbank_core::request::RenderRequest;

    fn status(request: axum::http::request::Builder, body: impl Into<Body>) -> u16 {
        let request = request.body(body.into()).unwrap();
        let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build().unwrap();
        let intake = Intake::new(1);
        let read = runtime.block_on(intake.read(request, RenderRequest::check));
        read.map_or_else(|problem| problem.status().as_u16(), |_| 200)
    }

    fn json() -> axum::http::request::Builder {
        Request::builder().header("content-type", "application/json")
    }

    const GOOD: &str = r#"{"scene": {}, "width": 8, "height": 8}"#;

    #[test]
    fn json_is_read_whatever_its_media_type_says_besides() {
        for content_type in ["application/json", "application/json; charset=utf-8", "a/b+json"] {
            let request = Request::builder().header("content-type", content_type);
            assert_eq!(status(request, GOOD), 200, "{content_type}");
        }
    }

    #[test]
    fn other_media_types_are_unsupported() {
        assert_eq!(status(Request::builder(), GOOD), 415);
        assert_eq!(status(Request::builder().header("content-type", "text/plain"), GOOD), 415);
        assert_eq!(status(json().header("content-encoding", "gzip"), GOOD), 415);
    }

    #[test]
    fn a_body_that_does_not_come_is_a_408() {
        let began = std::time::Instant::now();
        let (_sender, silent) = http_body_util::Channel::<axum::body::Bytes>::new(1);
        assert_eq!(status(json(), Body::new(silent)), 408);
        assert!(began.elapsed() < BODY_TIME);
    }

    #[test]
    fn small_bodies_are_read_while_large_ones_hold_all_memory() {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build().unwrap();
        let intake = Intake::new(1);
        let client = |last: u8| Client::from(std::net::IpAddr::from([10, 0, 0, last]));
        let _held = intake.bytes.take(client(1), CLIENT_BODIES_BYTES).unwrap();
        let _rest = intake.bytes.take(client(2), ALL_BODIES_BYTES - CLIENT_BODIES_BYTES).unwrap();
        let status = |body: Vec<u8>| {
            let request = json().body(Body::from(body)).unwrap();
            let read = runtime.block_on(intake.read(request, RenderRequest::check));
            read.map_or_else(|problem| problem.status().as_u16(), |_| 200)
        };
        let mut body = GOOD.as_bytes().to_vec();
        body.resize(SMALL_BYTES, b' ');
        assert_eq!(status(body.clone()), 200);
        body.push(b' ');
        assert_eq!(status(body), 503);
    }

    #[test]
    fn a_large_body_is_refused_by_its_length_alone() {
        let length = BODY_BYTES + 1;
        assert_eq!(status(json().header("content-length", length), ""), 413);
    }

    #[test]
    fn a_large_body_without_a_length_is_refused_while_it_comes() {
        assert_eq!(status(json(), vec![b' '; BODY_BYTES + 1]), 413);
        let mut padded = GOOD.as_bytes().to_vec();
        padded.resize(BODY_BYTES, b' ');
        assert_eq!(status(json(), padded), 200);
    }
}
