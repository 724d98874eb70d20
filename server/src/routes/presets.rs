//! `GET /v1/presets`: scenes to begin with.

use crate::answer::{self, Fixed, JSON};
use crate::openapi::Operation;
use crate::problem::Problem;
use crate::query::query;
use crate::store::presets as stored;
use axum::http::{HeaderMap, Uri};
use axum::response::Response;
use fogbank_core::presets::{self, Preset};
use fogbank_core::scene::Problem as Wrong;
use schemars::{JsonSchema, SchemaGenerator};
use serde::{Deserialize, Serialize};
use serde_json::json;
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

/// How they are listed.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Listing {
    /// False leaves the scenes out: each is there under `/v1/scenes/{name}`.
    #[serde(default = "yes")]
    scenes: bool,
}

fn yes() -> bool {
    true
}

/// All presets, with their scenes or without.
pub async fn list(uri: Uri, headers: HeaderMap) -> Result<Response, Problem> {
    let Listing { scenes } = query(&uri, Ok::<Listing, Vec<Wrong>>)?;
    if scenes {
        return Ok(presets().await?.answer(&headers));
    }
    // The first to ask makes them.
    let presets = tokio::task::spawn_blocking(stored::all).await?;
    Ok(answer::json(&json!({ "presets": presets })))
}

/// Its documentation.
pub fn operation(schemas: &mut SchemaGenerator) -> Operation {
    Operation::get("list_presets", "service", "Scenes to begin with.")
        .query::<Listing>(schemas)
        .json::<Presets>(schemas)
}
