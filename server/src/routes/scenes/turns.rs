//! A scene's history: what was done, undone and done again.

use super::{Revised, a_write, revised, write};
use crate::answer;
use crate::app::App;
use crate::conditional;
use crate::openapi::Operation;
use crate::problem::Problem;
use crate::query::query;
use crate::scene_id::SceneId;
use crate::store::Key;
use crate::store::record::{Heading, Kind};
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode, Uri};
use axum::response::Response;
use fogbank_core::scene::{Checker, Problem as Wrong, limits};
use schemars::{JsonSchema, SchemaGenerator};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Revisions of one answer.
const MOST: u32 = 1000;

/// What part of a history is asked for.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct HistoryRequest {
    /// Only revisions before this one.
    #[serde(default)]
    before: Option<u64>,
    /// At most so many.
    #[serde(default = "usual")]
    #[schemars(range(min = 1, max = MOST))]
    limit: u32,
}

fn usual() -> u32 {
    100
}

impl HistoryRequest {
    fn check(self) -> Result<Self, Vec<Wrong>> {
        let mut check = Checker::default();
        let range = limits::Range { min: 1.0, max: MOST.into() };
        check.number(self.limit.into(), range, || "/limit".into());
        check.finish(self)
    }
}

/// A scene's newest revisions.
#[derive(Serialize, JsonSchema)]
struct History {
    /// The scene's id.
    id: String,
    /// The newest first.
    revisions: Vec<Heading>,
    /// Whether there is something to undo.
    can_undo: bool,
    /// Whether there is something to do again.
    can_redo: bool,
}

/// Answers a scene's newest revisions.
pub async fn history(
    State(app): State<App>,
    SceneId(id): SceneId,
    uri: Uri,
) -> Result<Response, Problem> {
    let HistoryRequest { before, limit } = query(&uri, HistoryRequest::check)?;
    let (store, name) = (Arc::clone(&app.store), id.clone());
    let read = move || store.history(&name, before.unwrap_or(u64::MAX), limit.into());
    let (revisions, [can_undo, can_redo]) = tokio::task::spawn_blocking(read).await??;
    Ok(answer::json(&History { id, revisions, can_undo, can_redo }))
}

/// Its documentation.
pub fn history_operation(schemas: &mut SchemaGenerator) -> Operation {
    let summary =
        "A scene's newest revisions, and whether there is something to undo and to do again.";
    Operation::get("scene_history", "scenes", summary)
        .of_scene()
        .query::<HistoryRequest>(schemas)
        .json::<History>(schemas)
}

/// Reverts the newest revision.
pub async fn undo(app: State<App>, id: SceneId, headers: HeaderMap) -> Result<Response, Problem> {
    turn(app, id, headers, Kind::Undo).await
}

/// Its documentation.
pub fn undo_operation(schemas: &mut SchemaGenerator) -> Operation {
    let summary = "Reverts the newest revision that is not reverted yet, whoever made it, and all of its stroke; \
        that is a new revision.";
    a_write(Operation::bare_post("undo", "scenes", summary))
        .refuses(&[StatusCode::CONFLICT])
        .json::<Revised>(schemas)
}

/// Does again what was undone last.
pub async fn redo(app: State<App>, id: SceneId, headers: HeaderMap) -> Result<Response, Problem> {
    turn(app, id, headers, Kind::Redo).await
}

/// Its documentation.
pub fn redo_operation(schemas: &mut SchemaGenerator) -> Operation {
    let summary =
        "Does again what was undone last, if nothing else came since; that is a new revision.";
    a_write(Operation::bare_post("redo", "scenes", summary))
        .refuses(&[StatusCode::CONFLICT])
        .json::<Revised>(schemas)
}

async fn turn(
    State(app): State<App>,
    SceneId(id): SceneId,
    headers: HeaderMap,
    kind: Kind,
) -> Result<Response, Problem> {
    let condition = conditional::condition(&headers)?;
    // Undo and redo differ in what they are, and in nothing else.
    let digest = u64::from(kind == Kind::Redo);
    let key = conditional::key(&headers)?.map(|name| Key { name, digest });
    let name = id.clone();
    let written = write(&app, move |store| store.turn(&name, &condition, key, kind));
    Ok(revised(id, written.await?, true))
}
