//! `GET /v1/presets`: scenes to begin with.

use crate::answer::{Fixed, JSON};
use crate::openapi::Operation;
use crate::problem::Problem;
use axum::http::HeaderMap;
use axum::response::Response;
use fogbank_core::presets::{self, Preset};
use schemars::{JsonSchema, SchemaGenerator};
use serde::Serialize;
use std::sync::LazyLock;

/// Scenes to begin with.
#[derive(Serialize, JsonSchema)]
struct Presets {
    /// The first one is the demo scene.
    presets: Vec<Preset>,
}

static PRESETS: LazyLock<Fixed> = LazyLock::new(|| {
    let presets = Presets { presets: presets::all() };
    Fixed::new(JSON, serde_json::to_vec(&presets).unwrap_or_default())
});

/// All presets with their scenes.
pub async fn list(headers: HeaderMap) -> Result<Response, Problem> {
    // Megabytes: made at the first call, and not on a thread that serves others.
    let presets = tokio::task::spawn_blocking(|| LazyLock::force(&PRESETS)).await?;
    Ok(presets.answer(&headers))
}

/// Its documentation.
pub fn operation(schemas: &mut SchemaGenerator) -> Operation {
    Operation::get("list_presets", "service", "Scenes to begin with.").json::<Presets>(schemas)
}
