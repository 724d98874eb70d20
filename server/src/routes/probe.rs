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
use serde_json::json;

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
    let ray = json!({ "origin": [0, 0, 0], "direction": [0, 0, -1], "max_distance_m": 10 });
    let fog = json!({ "terms": [{ "kind": "homogeneous", "extinction": 0.1 }] });
    let answer = json!({
        "optical_depth": 1.0,
        "transmittance": 0.36787944117144233,
        "airlight": [0.0, 0.0, 0.0],
        "airlight_by_light": [],
        "ambient": [0.0, 0.0, 0.0],
        "radiance": [0.0, 0.0, 0.0],
        "hit": null,
    });
    Operation::post("probe", "numbers", summary)
        .takes::<ProbeRequest>(schemas)
        .example("ray", "10 m of fog.", json!({ "scene": { "fog": fog }, "rays": [ray] }))
        .json::<ProbeAnswer>(schemas)
        .answers(json!({ "rays": [answer] }))
}
