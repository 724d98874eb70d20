//! From a checked request to a picture in an answer: queue, renderer, encoder.

use crate::answer;
use crate::app::App;
use crate::problem::Problem;
use axum::http::{HeaderName, HeaderValue, header};
use axum::response::{IntoResponse, Response};
use fogbank_core::Frame;
use fogbank_core::image::EncodeError;
use fogbank_core::request::{Quality, View};
use fogbank_core::scene::CheckedScene;
use std::time::{Duration, Instant};

/// A frame as a file, with what its headers say besides.
pub struct Encoded {
    /// The file.
    pub bytes: Vec<u8>,
    /// Its media type.
    pub content_type: &'static str,
    /// A header of this kind of file alone.
    pub extra: Option<(HeaderName, String)>,
}

/// Renders `view` when its turn comes, encodes it and says how long each step took.
///
/// # Errors
/// 503 when there is no place, 504 past the deadline, 500 when something broke.
pub async fn answer(
    app: &App,
    scene: CheckedScene,
    view: View,
    encode: impl FnOnce(&Frame) -> Result<Encoded, EncodeError> + Send + 'static,
) -> Result<Response, Problem> {
    let deadline = app.deadline(&scene);
    let render =
        app.queue.run(deadline, move |renderer, progress| renderer.render(&scene, &view, progress));
    let done = render.await?;
    let (frame, waited) = (done.value, done.waited);
    let finish = move || {
        let began = Instant::now();
        let encoded = encode(&frame)?;
        let etag = answer::etag(&encoded.bytes);
        let timing = server_timing(waited, &frame.timings, began.elapsed());
        Ok::<_, EncodeError>((encoded, etag, timing))
    };
    // The place is held until the file is made: what waits here is bounded as well.
    let (encoded, etag, timing) = tokio::task::spawn_blocking(finish).await??;
    drop(done.place);
    let mut response = encoded.bytes.into_response();
    let mut set = |name: HeaderName, value: &str| {
        if let Ok(value) = HeaderValue::from_str(value) {
            response.headers_mut().insert(name, value);
        }
    };
    set(header::CONTENT_TYPE, encoded.content_type);
    set(header::ETAG, &etag);
    set(HeaderName::from_static("server-timing"), &timing);
    set(HeaderName::from_static("fog-backend"), app.backend);
    set(HeaderName::from_static("fog-quality"), quality_name(view.quality));
    if let Some((name, value)) = encoded.extra {
        set(name, &value);
    }
    Ok(response)
}

fn quality_name(quality: Quality) -> &'static str {
    match quality {
        Quality::Draft => "draft",
        Quality::Full => "full",
    }
}

/// `queue;dur=0.1, surfaces;dur=3.2, encode;dur=4.0`, in milliseconds.
fn server_timing(
    waited: Duration,
    passes: &[(&'static str, Duration)],
    encoding: Duration,
) -> String {
    let all = [("queue", waited)].into_iter().chain(passes.iter().copied());
    let all = all.chain([("encode", encoding)]);
    let ms = |took: Duration| took.as_secs_f64() * 1e3;
    let all: Vec<_> = all.map(|(name, took)| format!("{name};dur={:.3}", ms(took))).collect();
    all.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn timings_are_in_milliseconds_and_in_order() {
        let ms = Duration::from_millis;
        let text = server_timing(ms(1), &[("surfaces", ms(20))], ms(3));
        assert_eq!(text, "queue;dur=1.000, surfaces;dur=20.000, encode;dur=3.000");
    }
}
