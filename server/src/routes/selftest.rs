//! `POST /v1/selftest`: what each backend makes of small scenes, against the f64 maths.

use crate::answer;
use crate::app::App;
use crate::budget::Client;
use crate::openapi::Operation;
use crate::problem::Problem;
use crate::queue::{Lane, Order};
use axum::extract::State;
use axum::response::Response;
use fogbank_core::selftest::BackendReport;
use fogbank_core::{Progress, Renderer};
use schemars::{JsonSchema, SchemaGenerator};
use serde::Serialize;

/// Every backend that this process renders on.
#[derive(Serialize, JsonSchema)]
pub struct Selftest {
    /// The backends.
    pub backends: Vec<BackendReport>,
}

/// Compares them with the f64 maths.
pub async fn selftest(State(app): State<App>, client: Client) -> Result<Response, Problem> {
    let test = |renderer: &Renderer, progress: &Progress| renderer.selftest(progress);
    // It holds pictures against references, and a driver in software makes all pipelines for it.
    let order = Order::new(Lane::Long, client, app.deadline(true));
    let done = app.queue.run(order, test).await?;
    Ok(answer::json(&Selftest { backends: done.value }))
}

/// Its documentation.
pub fn operation(schemas: &mut SchemaGenerator) -> Operation {
    let summary = "Each backend's largest difference from the f64 maths, model by model.";
    Operation::post("selftest", "health", summary).json::<Selftest>(schemas)
}
