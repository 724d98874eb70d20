//! `GET /v1/scenes`: what scenes there are.

use crate::answer;
use crate::app::App;
use crate::openapi::Operation;
use crate::problem::Problem;
use axum::extract::State;
use axum::response::Response;
use schemars::{JsonSchema, SchemaGenerator};
use serde::Serialize;
use std::sync::Arc;

/// All stored scenes.
#[derive(Serialize, JsonSchema)]
struct Scenes {
    /// In the order of their ids.
    scenes: Vec<Stored>,
}

/// A stored scene.
#[derive(Serialize, JsonSchema)]
struct Stored {
    /// Its id.
    id: String,
    /// The revision that it is at.
    revision: u64,
    /// When that was made [ms since 1970, UTC].
    at_ms: u64,
}

/// Lists all scenes.
pub async fn list(State(app): State<App>) -> Result<Response, Problem> {
    let store = Arc::clone(&app.store);
    let rows = tokio::task::spawn_blocking(move || store.list()).await??;
    let stored = |(id, row): (String, crate::store::record::Row)| Stored {
        id,
        revision: row.revision,
        at_ms: row.at_ms,
    };
    Ok(answer::json(&Scenes { scenes: rows.into_iter().map(stored).collect() }))
}

/// Its documentation.
pub fn list_operation(schemas: &mut SchemaGenerator) -> Operation {
    Operation::get("list_scenes", "scenes", "What scenes live on this server.")
        .json::<Scenes>(schemas)
}
