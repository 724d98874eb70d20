//! The live preview: a socket on which views and edits go up, and frames and changes come down.
//!
//! `message` says what goes over it, `viewer` is who sits at one, `picture` makes a viewer's frames, `scale` makes drafts as
//! large as the machine can in time.

mod message;
mod picture;
mod scale;
mod viewer;

use crate::app::App;
use crate::budget::Client;
use crate::openapi::Operation;
use crate::problem::Problem;
use crate::query::query;
use crate::scene_id::SceneId;
use crate::seat::Seat;
use crate::store::Refusal;
use axum::Extension;
use axum::extract::State;
use axum::extract::ws::rejection::WebSocketUpgradeRejection;
use axum::extract::ws::{WebSocket, WebSocketUpgrade};
use axum::http::{HeaderMap, StatusCode, Uri};
use axum::response::Response;
use fogbank_core::scene::Problem as Wrong;
use schemars::{JsonSchema, SchemaGenerator};
use serde::Deserialize;
use serde_json::json;
use std::sync::Arc;

/// What is spoken on the socket.
const PROTOCOL: &str = "fogbank.v1";

/// Bytes of a message from a client: an edit may hold a long patch.
const MESSAGE_BYTES: usize = 256 << 10;

/// What a client has when it opens a socket.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Known {
    /// The revision of the scene that it has: if the scene is still there, `hello` does not bring it again.
    #[serde(default)]
    revision: Option<u64>,
}

/// Opens a viewer's socket.
pub async fn live(
    State(app): State<App>,
    SceneId(id): SceneId,
    client: Client,
    seat: Option<Extension<Seat>>,
    uri: Uri,
    headers: HeaderMap,
    upgrade: Result<WebSocketUpgrade, WebSocketUpgradeRejection>,
) -> Result<Response, Problem> {
    // A browser opens sockets for pages of any site, and only the server can tell.
    app.names.check_origin(&headers)?;
    let Known { revision } = query(&uri, Ok::<Known, Vec<Wrong>>)?;
    let upgrade = upgrade.map_err(|rejection| {
        Problem::new(StatusCode::BAD_REQUEST, format!("a WebSocket is opened here: {rejection}"))
    })?;
    let upgrade = upgrade.protocols([PROTOCOL]);
    if upgrade.selected_protocol().is_none() {
        let detail = format!("the subprotocol {PROTOCOL} is spoken here");
        return Err(Problem::new(StatusCode::BAD_REQUEST, detail));
    }
    let store = Arc::clone(&app.store);
    let room = tokio::task::spawn_blocking(move || store.room(&id)).await??;
    let head = room.head().ok_or(Refusal::Missing)?;
    let begin = move |socket: WebSocket| async move {
        viewer::Viewer::new(socket, app, room, (head, revision), client).serve().await;
        // Its place counts until here.
        drop(seat);
    };
    // What is written goes out at once, so nothing gathers behind a slow reader.
    let upgrade =
        upgrade.max_message_size(MESSAGE_BYTES).max_frame_size(MESSAGE_BYTES).write_buffer_size(0);
    Ok(upgrade.on_upgrade(begin))
}

/// Its documentation.
pub fn live_operation(schemas: &mut SchemaGenerator) -> Operation {
    let summary = "A WebSocket of the subprotocol `fogbank.v1`: views, edits and acknowledgements up, changes and frames \
        down. Text up: `{\"type\": \"view\", seq, camera, width, height, layer?, exposure_ev?, tonemap?, time_s?, samples?, options?, job?}`, \
        `{\"type\": \"edit\", seq, edit, base_revision?}`, `{\"type\": \"ack\", frame}`, `{\"type\": \"stop\"}`. Text down: `hello`, `scene`, \
        `viewers`, `error`. Binary down, one frame each: a u32 (little-endian) with the length of the JSON header, the \
        header `{frame, seq, revision, tier, scale, content_type, width, height, depth_range?, backend, reused, timing_ms}`, and the picture. At most \
        two frames are unacknowledged; the latest view wins.";
    Operation::get("live", "scenes", summary)
        .of_scene()
        .query::<Known>(schemas)
        .content("text/plain", json!({ "schema": { "type": "string" } }))
        .refuses(&[StatusCode::FORBIDDEN, StatusCode::SERVICE_UNAVAILABLE])
}
