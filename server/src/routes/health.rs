//! `GET /healthz` and `/readyz`: for whoever watches the process.

use crate::answer;
use crate::app::{App, Phase};
use crate::openapi::Operation;
use crate::problem::Problem;
use axum::extract::State;
use axum::http::StatusCode;
use axum::response::Response;
use schemars::{JsonSchema, SchemaGenerator};
use serde::Serialize;
use serde_json::json;
use std::sync::atomic::Ordering;

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

/// How the renderer is.
#[derive(Serialize, JsonSchema)]
struct Readiness {
    /// `ok`, or `degraded` when the CPU had to take over from a GPU that failed again and again.
    status: &'static str,
}

/// The renderer takes jobs.
pub async fn readyz(State(app): State<App>) -> Result<Response, Problem> {
    if *app.phase.borrow() != Phase::Serving {
        return Err(Problem::busy("the server is stopping"));
    }
    if !app.queue.is_alive() {
        return Err(Problem::busy("the renderer is gone"));
    }
    if let Some(overdue) = app.queue.overdue() {
        let seconds = overdue.as_secs_f64();
        let detail = format!("a job that was over {seconds:.1} s ago still runs");
        return Err(Problem::busy(&detail));
    }
    let fallen_back = app.has_fallen_back.load(Ordering::Relaxed);
    Ok(answer::json(&Readiness { status: if fallen_back { "degraded" } else { "ok" } }))
}

/// The documentation of `/healthz`.
pub fn healthz_operation(schemas: &mut SchemaGenerator) -> Operation {
    let summary = "Whether the process answers.";
    let operation = Operation::get("healthz", "health", summary).json::<Health>(schemas);
    operation.answers(json!({ "status": "ok" }))
}

/// The documentation of `/readyz`.
pub fn readyz_operation(schemas: &mut SchemaGenerator) -> Operation {
    let summary = "Whether the renderer takes jobs, and stops when they are over.";
    Operation::get("readyz", "health", summary)
        .json::<Readiness>(schemas)
        .answers(json!({ "status": "ok" }))
        .refuses(&[StatusCode::SERVICE_UNAVAILABLE])
}
