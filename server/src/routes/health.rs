//! `GET /healthz` and `/readyz`: for whoever watches the process.

use crate::answer;
use crate::app::App;
use crate::openapi::Operation;
use crate::problem::Problem;
use axum::extract::State;
use axum::http::StatusCode;
use axum::response::Response;
use schemars::{JsonSchema, SchemaGenerator};
use serde::Serialize;

/// How the process is.
#[derive(Serialize, JsonSchema)]
struct Health {
    /// `ok`.
    status: &'static str,
}

/// The process answers.
pub async fn healthz() -> Response {
    answer::json(&Health { status: "ok" })
}

/// The renderer takes jobs.
pub async fn readyz(State(app): State<App>) -> Result<Response, Problem> {
    if app.queue.is_alive() {
        return Ok(answer::json(&Health { status: "ok" }));
    }
    Err(Problem::busy("the renderer is gone"))
}

/// The documentation of `/healthz`.
pub fn healthz_operation(schemas: &mut SchemaGenerator) -> Operation {
    Operation::get("Whether the process answers.").json::<Health>(schemas)
}

/// The documentation of `/readyz`.
pub fn readyz_operation(schemas: &mut SchemaGenerator) -> Operation {
    let summary = "Whether the renderer takes jobs.";
    let operation = Operation::get(summary).json::<Health>(schemas);
    operation.refuses(StatusCode::SERVICE_UNAVAILABLE)
}
