//! `GET /v1/presets`: scenes to begin with.

use crate::answer::{Fixed, JSON};
use crate::openapi::Operation;
use crate::problem::Problem;
use axum::http::HeaderMap;
use axum::response::Response;
use fogbank_core::presets::{self, Preset};
use schemars::{JsonSchema, SchemaGenerator};
use serde::Serialize;
use tokio::sync::OnceCell;

/// Scenes to begin with.
#[derive(Serialize, JsonSchema)]
struct Presets {
    /// The first one is the demo scene.
    presets: Vec<Preset>,
}

static PRESETS: OnceCell<Fixed> = OnceCell::const_new();

/// Megabytes: made once, when the first client asks, and not on a thread that serves others.
async fn presets() -> Result<&'static Fixed, Problem> {
    let make = || {
        let presets = Presets { presets: presets::all() };
        Fixed::new(JSON, serde_json::to_vec(&presets).unwrap_or_default()).compressed()
    };
    let made = PRESETS.get_or_try_init(|| tokio::task::spawn_blocking(make)).await;
    made.map_err(Problem::from)
}

/// All presets with their scenes.
pub async fn list(headers: HeaderMap) -> Result<Response, Problem> {
    Ok(presets().await?.answer(&headers))
}

/// Its documentation.
pub fn operation(schemas: &mut SchemaGenerator) -> Operation {
    Operation::get("list_presets", "service", "Scenes to begin with.").json::<Presets>(schemas)
}
