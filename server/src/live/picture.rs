//! A viewer's frame: from what it wants to bytes that can be sent.

use super::message::{Header, Tier, Wanted};
use super::scale::Scale;
use crate::answer;
use crate::app::App;
use crate::budget::{Client, Held};
use crate::estimate::{lane_of_picture, picture_bytes};
use crate::problem::Problem;
use crate::queue::Order;
use crate::store::record::Head;
use axum::body::Bytes;
use fogbank_core::image::{Format, depth_range, encode};
use fogbank_core::request::{Quality, View};
use fogbank_core::scene::{Airlight, CheckedScene};
use fogbank_core::{Progress, Renderer};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// What pictures are sent as: a screen's, and small.
const FORMAT: Format = Format::Jpeg;

/// A frame that can be sent.
pub struct Picture {
    /// Header and picture.
    pub bytes: Bytes,
    /// How good it is.
    pub tier: Tier,
    /// What passes and encoder took.
    pub took: Duration,
    /// Whether the camera moved: then it took what such a frame takes.
    pub is_typical: bool,
    /// Pixels of the whole picture, of which a draft has a share.
    pub pixels: f64,
}

/// A frame that is to be made.
pub struct Task {
    /// Its number.
    pub frame: u64,
    /// What the client wants to see.
    pub wanted: Wanted,
    /// The scene, and its revision.
    pub head: Arc<Head>,
    /// How good it is to be.
    pub tier: Tier,
    /// How large.
    pub scale: Scale,
    /// Since when its client waits for a turn.
    pub since: Instant,
}

/// Makes a frame. Whoever drops this stops it.
///
/// # Errors
/// What the scene, the queue or the encoder refuse.
pub async fn make(app: App, client: Client, task: Task) -> Result<Picture, Problem> {
    let scene = seen(&task)?;
    let view = sized(&task);
    let most_bytes = picture_bytes(view.width, view.height, 3, FORMAT);
    let room = app.answers.reserve(client, most_bytes)?;
    let deadline = app.deadline(scene.fog.airlight == Airlight::Reference);
    let order = Order::new(lane_of_picture(&scene, &view), client, deadline);
    // A name that another job has is no reason to show nothing.
    let _watched = task.wanted.job.clone().and_then(|id| app.watch.add(id, &order.progress).ok());
    let waited = task.since.elapsed();
    let work =
        move |renderer: &Renderer, progress: &Progress| renderer.render(&scene, &view, progress);
    let done = app.queue.run(order, work).await?;
    let (frame, waited) = (done.value, waited + done.waited);
    let place = done.place;
    let finish = move || {
        let began = Instant::now();
        let picture = encode(&frame, &view, FORMAT)?;
        drop(place);
        let encoding = began.elapsed();
        let ms = |time: Duration| time.as_secs_f64() * 1e3;
        let mut timing_ms = BTreeMap::from([("queue", ms(waited)), ("encode", ms(encoding))]);
        for lap in &frame.timings {
            *timing_ms.entry(lap.pass).or_default() += ms(lap.took);
        }
        let passes: Duration = frame.timings.iter().map(|lap| lap.took).sum();
        let reused = frame.timings.iter().filter(|lap| lap.is_reused).map(|lap| lap.pass).collect();
        // What a resting camera kept says little of what a moving one costs.
        let is_typical = !frame.timings.iter().any(|lap| lap.pass == "surfaces" && lap.is_reused);
        let header = Header {
            frame: task.frame,
            seq: task.wanted.seq,
            revision: task.head.revision,
            tier: task.tier,
            scale: if task.tier == Tier::Full { 1.0 } else { task.scale.share() },
            content_type: FORMAT.content_type(),
            width: view.width,
            height: view.height,
            depth_range: depth_range(&frame),
            backend: frame.backend,
            reused,
            timing_ms,
        };
        let bytes = packed(&header, &picture, room);
        let whole = task.wanted.view;
        let pixels = f64::from(whole.width) * f64::from(whole.height);
        let took = passes + encoding;
        Ok::<_, Problem>(Picture { bytes, tier: task.tier, took, is_typical, pixels })
    };
    tokio::task::spawn_blocking(finish).await?
}

fn seen(task: &Task) -> Result<CheckedScene, Problem> {
    task.wanted.eye.on(&task.head.scene).map_err(Problem::invalid)
}

fn sized(task: &Task) -> View {
    let view = task.wanted.view;
    let side = |pixels: u32| match task.tier {
        Tier::Draft => ((f64::from(pixels) * task.scale.share()).round() as u32).max(1),
        Tier::Full => pixels,
    };
    let quality = if task.tier == Tier::Draft { Quality::Draft } else { Quality::Full };
    let is_hasty = task.tier == Tier::Draft && task.scale.is_hasty();
    let view = View { width: side(view.width), height: side(view.height), quality, ..view };
    View { is_hasty, ..view }.for_format(FORMAT)
}

/// The length of the header, the header, the picture.
fn packed(header: &Header, picture: &[u8], room: Held) -> Bytes {
    let header = serde_json::to_vec(header).unwrap_or_default();
    let length = (header.len() as u32).to_le_bytes();
    answer::kept([&length[..], &header, picture].concat(), room)
}
