//! From a request's body to a checked request: size, type and form are looked at here, once.

use crate::problem::Problem;
use axum::body::Body;
use axum::extract::Request;
use axum::http::{HeaderMap, StatusCode, header};
use fogbank_core::scene;
use http_body_util::BodyExt;
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

/// Largest body of a request [bytes].
pub const BODY_BYTES: usize = 32 << 20;

/// All bodies together that may be in memory at a time [bytes]. Reading one takes at most 8 times its
/// size: a request that is all the smallest items there are is that much larger than its text.
const ALL_BODIES_BYTES: usize = 8 * BODY_BYTES;

/// How long a client may take to send its body.
const BODY_TIME: Duration = Duration::from_secs(30);

/// Bodies up to this size [bytes] are read in well under a millisecond: no other thread needed.
const SMALL_BYTES: usize = 64 << 10;

/// Reads bodies, and bounds what they take together.
#[derive(Clone)]
pub struct Intake {
    /// One permit a byte that has arrived and was not yet read into a request.
    bytes: Arc<Semaphore>,
    /// One permit a large body that is being parsed.
    parsers: Arc<Semaphore>,
}

impl Intake {
    /// Parses at most `parsers` large bodies at a time.
    pub fn new(parsers: usize) -> Self {
        let bytes = Arc::new(Semaphore::new(ALL_BODIES_BYTES));
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
        check_headers(request.headers())?;
        let collect = tokio::time::timeout(BODY_TIME, self.collect(request.into_body()));
        // Held until the bytes are read into a request.
        let (bytes, held) = collect.await.map_err(|_| too_slow())??;
        let parse = move || check(scene::read::<T>(&bytes)?).map_err(Problem::invalid);
        if held.num_permits() <= SMALL_BYTES {
            return parse();
        }
        let _parser = self.parsers.acquire().await.map_err(|_| Problem::broken())?;
        tokio::task::spawn_blocking(parse).await?
    }

    /// Takes memory for what came, never for what was announced.
    async fn collect(&self, mut body: Body) -> Result<(Vec<u8>, OwnedSemaphorePermit), Problem> {
        let mut bytes = Vec::new();
        let mut held = self.hold(0)?;
        while let Some(frame) = body.frame().await {
            let frame = frame.map_err(|error| {
                Problem::new(StatusCode::BAD_REQUEST, format!("the body broke off: {error}"))
            })?;
            let Ok(data) = frame.into_data() else { continue };
            if bytes.len() + data.len() > BODY_BYTES {
                return Err(too_large());
            }
            held.merge(self.hold(data.len())?);
            bytes.extend_from_slice(&data);
        }
        Ok((bytes, held))
    }

    fn hold(&self, bytes: usize) -> Result<OwnedSemaphorePermit, Problem> {
        let permits = u32::try_from(bytes).unwrap_or(u32::MAX);
        let held = Arc::clone(&self.bytes).try_acquire_many_owned(permits);
        held.map_err(|_| Problem::busy("too many large requests at a time"))
    }
}

fn check_headers(headers: &HeaderMap) -> Result<(), Problem> {
    let unsupported = |detail| Problem::new(StatusCode::UNSUPPORTED_MEDIA_TYPE, detail);
    let text = |name| headers.get(name).map(|value| value.to_str().unwrap_or_default());
    if text(header::CONTENT_TYPE).is_some_and(|value| !is_json(value)) {
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
    let detail = format!("the body must arrive within {} s", BODY_TIME.as_secs());
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

    const GOOD: &str = r#"{"scene": {}, "width": 8, "height": 8}"#;

    #[test]
    fn json_is_read_whatever_its_media_type_says_besides() {
        for content_type in ["application/json", "application/json; charset=utf-8", "a/b+json"] {
            let request = Request::builder().header("content-type", content_type);
            assert_eq!(status(request, GOOD), 200, "{content_type}");
        }
        assert_eq!(status(Request::builder(), GOOD), 200);
    }

    #[test]
    fn other_media_types_are_unsupported() {
        assert_eq!(status(Request::builder().header("content-type", "text/plain"), GOOD), 415);
        assert_eq!(status(Request::builder().header("content-encoding", "gzip"), GOOD), 415);
    }

    #[test]
    fn a_large_body_is_refused_by_its_length_alone() {
        let length = BODY_BYTES + 1;
        assert_eq!(status(Request::builder().header("content-length", length), ""), 413);
    }

    #[test]
    fn a_large_body_without_a_length_is_refused_while_it_comes() {
        assert_eq!(status(Request::builder(), vec![b' '; BODY_BYTES + 1]), 413);
        let mut padded = GOOD.as_bytes().to_vec();
        padded.resize(BODY_BYTES, b' ');
        assert_eq!(status(Request::builder(), padded), 200);
    }
}
