//! From a checked request to a file in an answer: queue, renderer, encoder.

use crate::answer::{self, JSON};
use crate::app::App;
use crate::budget::{Client, Held};
use crate::estimate::{lane_of_picture, picture_bytes};
use crate::problem::Problem;
use crate::queue::Order;
use crate::watch::JobId;
use axum::http::{HeaderName, HeaderValue, header};
use axum::response::{IntoResponse, Response};
use fogbank_core::frame::Lap;
use fogbank_core::image::{EncodeError, Format, depth_range, encode};
use fogbank_core::request::{Layer, Quality, View};
use fogbank_core::scene::{Airlight, CheckedScene};
use fogbank_core::{Frame, Interrupted, Progress, Renderer};
use std::time::{Duration, Instant};

/// What a renderer made as a file, with what its headers say besides.
pub struct Encoded {
    /// The file.
    pub bytes: Vec<u8>,
    /// Where it was rendered.
    pub backend: &'static str,
    /// Its media type.
    pub content_type: &'static str,
    /// A header of this kind of file alone.
    pub extra: Option<(HeaderName, String)>,
}

impl Encoded {
    /// A frame as a file of some format.
    ///
    /// # Errors
    /// Those of the encoder.
    pub fn of(frame: &Frame, view: &View, format: Format) -> Result<Self, EncodeError> {
        let bytes = encode(frame, view, format)?;
        let (content_type, backend) = (format.content_type(), frame.backend);
        let range = depth_range(frame).map(|[least, most]| format!("{least} {most}"));
        let extra = range.map(|range| (HeaderName::from_static("fog-depth-range"), range));
        Ok(Self { bytes, backend, content_type, extra })
    }
}

/// What a job made, and what each of its passes took, in order.
pub type Timed<T> = (T, Vec<Lap>);

/// Renders `view` when its turn comes, encodes it and says how long each step took.
///
/// # Errors
/// Those of [`answer_job`].
pub async fn answer(
    app: &App,
    client: Client,
    job: Option<JobId>,
    scene: CheckedScene,
    view: View,
    format: Format,
    encode: impl FnOnce(&Frame) -> Result<Encoded, EncodeError> + Send + 'static,
) -> Result<Response, Problem> {
    let render = move |renderer: &Renderer, scene: &CheckedScene, progress: &Progress| {
        renderer.render(scene, &view, progress)
    };
    answer_by(app, client, job, scene, view, format, (render, encode)).await
}

/// The same of a frame as large as that of `view`, however it is made.
///
/// # Errors
/// Those of [`answer_job`].
pub async fn answer_by(
    app: &App,
    client: Client,
    job: Option<JobId>,
    scene: CheckedScene,
    view: View,
    format: Format,
    (render, encode): (
        impl FnOnce(&Renderer, &CheckedScene, &Progress) -> Result<Frame, Interrupted> + Send + 'static,
        impl FnOnce(&Frame) -> Result<Encoded, EncodeError> + Send + 'static,
    ),
) -> Result<Response, Problem> {
    let channels = view.layer.channels(scene.fog.bands());
    // A PNG of optical depths may have 16 bits a number.
    let is_deep = view.layer == Layer::OpticalDepth && !format.is_float();
    let numbers = if is_deep { 2 * channels } else { channels };
    let most_bytes = picture_bytes(view.width, view.height, numbers, format);
    let room = app.answers.reserve(client, most_bytes)?;
    let deadline = app.deadline(scene.fog.airlight == Airlight::Reference);
    let order = Order::new(lane_of_picture(&scene, &view), client, deadline);
    let render = move |renderer: &Renderer, progress: &Progress| {
        let mut frame = render(renderer, &scene, progress)?;
        let timings = std::mem::take(&mut frame.timings);
        Ok((frame, timings))
    };
    let mut response = answer_job(app, order, room, job, view.quality, render, encode).await?;
    if view.options.far_cut > 0.0 {
        let cut = view.options.far_cut.to_string();
        if let Ok(cut) = HeaderValue::from_str(&cut) {
            response.headers_mut().insert("fog-far-cut", cut);
        }
    }
    Ok(response)
}

/// Does `work` when its turn comes, encodes what it made into the room that is reserved for it and
/// says how long each step took. Until then clients may ask how far it is.
///
/// # Errors
/// 409 when another job has that id, 503 when there is no place, 504 past the deadline, 500 when something broke.
pub async fn answer_job<T: Send + 'static>(
    app: &App,
    order: Order,
    room: Held,
    job: Option<JobId>,
    quality: Quality,
    work: impl FnOnce(&Renderer, &Progress) -> Result<Timed<T>, Interrupted> + Send + 'static,
    encode: impl FnOnce(&T) -> Result<Encoded, EncodeError> + Send + 'static,
) -> Result<Response, Problem> {
    let _watched = job.map(|id| app.watch.add(id, &order.progress)).transpose()?;
    let done = app.queue.run(order, work).await?;
    let ((value, timings), waited) = (done.value, done.waited);
    let finish = move || {
        let began = Instant::now();
        let encoded = encode(&value)?;
        let etag = answer::etag(&encoded.bytes);
        let timing = server_timing(waited, &timings, began.elapsed());
        Ok::<_, EncodeError>((encoded, etag, timing))
    };
    // The place is held until the file is made: what waits here is bounded as well.
    let (encoded, etag, timing) = tokio::task::spawn_blocking(finish).await??;
    drop(done.place);
    let mut response = answer::kept(encoded.bytes, room).into_response();
    let mut set = |name: HeaderName, value: &str| {
        if let Ok(value) = HeaderValue::from_str(value) {
            response.headers_mut().insert(name, value);
        }
    };
    set(header::CONTENT_TYPE, encoded.content_type);
    if encoded.content_type != JSON {
        set(header::ETAG, &etag);
    }
    set(HeaderName::from_static("server-timing"), &timing);
    set(HeaderName::from_static("fog-backend"), encoded.backend);
    set(HeaderName::from_static("fog-quality"), quality_name(quality));
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

/// `queue;dur=0.1, surfaces;desc=reused;dur=0.0, encode;dur=4.0`, in milliseconds.
fn server_timing(waited: Duration, passes: &[Lap], encoding: Duration) -> String {
    let (queue, encode) = (Lap::new("queue", waited), Lap::new("encode", encoding));
    let all = [queue].into_iter().chain(passes.iter().copied()).chain([encode]);
    let text = |Lap { pass, took, is_reused }: Lap| {
        let kept = if is_reused { ";desc=reused" } else { "" };
        format!("{pass}{kept};dur={:.3}", took.as_secs_f64() * 1e3)
    };
    all.map(text).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn timings_are_in_milliseconds_and_in_order() {
        let ms = Duration::from_millis;
        let kept = Lap { is_reused: true, ..Lap::new("airlight", ms(0)) };
        let text = server_timing(ms(1), &[Lap::new("surfaces", ms(20)), kept], ms(3));
        let expected = "queue;dur=1.000, surfaces;dur=20.000, airlight;desc=reused;dur=0.000, \
            encode;dur=3.000";
        assert_eq!(text, expected);
    }
}
