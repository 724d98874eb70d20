//! `POST /v1/probe`: the numbers along rays.

use crate::answer;
use crate::app::App;
use crate::openapi::Operation;
use crate::problem::Problem;
use axum::extract::{Request, State};
use axum::response::Response;
use fogbank_core::probe::RayAnswer;
use fogbank_core::request::ProbeRequest;
use fogbank_core::scene::Airlight;
use schemars::{JsonSchema, SchemaGenerator};
use serde::Serialize;

/// What a probe found.
#[derive(Serialize, JsonSchema)]
pub struct ProbeAnswer {
    /// One answer a ray, in the order of the request.
    pub rays: Vec<RayAnswer>,
}

/// Evaluates rays in f64.
pub async fn probe(State(app): State<App>, request: Request) -> Result<Response, Problem> {
    let (scene, rays) = app.intake.read(request, ProbeRequest::check).await?;
    let deadline = app.deadline(scene.fog.airlight == Airlight::Reference);
    let probe =
        app.queue.run(deadline, move |renderer, progress| renderer.probe(&scene, &rays, progress));
    let done = probe.await?;
    let answer = ProbeAnswer { rays: done.value };
    Ok(tokio::task::spawn_blocking(move || answer::json(&answer)).await?)
}

/// Its documentation.
pub fn operation(schemas: &mut SchemaGenerator) -> Operation {
    let summary = "Optical depth, transmittance, airlight and radiance along rays, in f64.";
    Operation::post::<ProbeRequest>(summary, schemas).json::<ProbeAnswer>(schemas)
}
