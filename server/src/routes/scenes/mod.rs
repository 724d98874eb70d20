//! Scenes that live on the server: what all their routes share.

mod edits;
mod list;
mod one;
mod pictures;
mod turns;

pub use edits::{edit, edit_operation};
pub use list::{list, list_operation};
pub use one::{
    delete, delete_operation, get, get_operation, patch, patch_operation, put, put_operation,
};
pub use pictures::{
    compare, compare_operation, frame, frame_operation, optical_depth, optical_depth_operation,
    probe, probe_operation, select, select_operation,
};
pub use turns::{history, history_operation, redo, redo_operation, undo, undo_operation};

use crate::answer;
use crate::app::App;
use crate::conditional::{self, tag};
use crate::extract::Digested;
use crate::openapi::Operation;
use crate::problem::Problem;
use crate::store::record::Head;
use crate::store::{Condition, Key, Refusal, Store, Writing, Written};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use fogbank_core::json::document::Patch;
use schemars::JsonSchema;
use serde::Serialize;
use std::sync::Arc;

/// A scene as it is durable.
async fn head(app: &App, id: &str) -> Result<Arc<Head>, Problem> {
    let (store, id) = (Arc::clone(&app.store), id.to_owned());
    Ok(tokio::task::spawn_blocking(move || store.head(&id)).await??)
}

/// What a write came to.
#[derive(Serialize, JsonSchema)]
pub struct Revised {
    /// The scene's id.
    pub id: String,
    /// The revision that it is at now: its `ETag`.
    pub revision: u64,
    /// What changed since the revision before (RFC 6902).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub patch: Option<Patch>,
}

/// Makes a write where it may take its time, and waits until it is durable.
async fn write(
    app: &App,
    make: impl FnOnce(&Store) -> Result<Writing, Refusal> + Send + 'static,
) -> Result<Written, Problem> {
    let store = Arc::clone(&app.store);
    let writing = tokio::task::spawn_blocking(move || make(&store)).await??;
    Ok(writing.durable().await?)
}

/// What the headers of a write say: what it expects, and which request it is.
fn terms<T>(headers: &HeaderMap, body: &Digested<T>) -> Result<(Condition, Option<Key>), Problem> {
    let key = conditional::key(headers)?.map(|name| Key { name, digest: body.digest });
    Ok((conditional::condition(headers)?, key))
}

/// The answer to a write, in which the patch may be left out: a client that put a scene knows it.
fn revised(id: String, written: Written, with_patch: bool) -> Response {
    let status = if written.is_new { StatusCode::CREATED } else { StatusCode::OK };
    let etag = [(header::ETAG, conditional::value(&tag(written.revision)))];
    let patch = with_patch.then_some(written.patch);
    let body = answer::json(&Revised { id, revision: written.revision, patch });
    (status, etag, body).into_response()
}

/// What all writes have in common in their documentation.
fn a_write(operation: Operation) -> Operation {
    let key = "A name of the client's choice for this request: a repeated one is not done twice, and is answered \
        with the first one's revision. Known as long as history names that.";
    operation
        .of_scene()
        .header_parameter("If-Match", "Revisions, one of which the scene must be at.")
        .header_parameter(conditional::KEY, key)
        .header("ETag", "The revision.")
        .refuses(&[
            StatusCode::FORBIDDEN,
            StatusCode::PRECONDITION_FAILED,
            StatusCode::INSUFFICIENT_STORAGE,
            StatusCode::SERVICE_UNAVAILABLE,
        ])
}
