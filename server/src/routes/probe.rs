//! `POST /v1/probe`: the numbers along rays.

use crate::answer;
use crate::app::App;
use crate::budget::Client;
use crate::estimate::{lane_of_probe, probe_bytes};
use crate::openapi::Operation;
use crate::problem::Problem;
use crate::queue::Order;
use axum::extract::{Request, State};
use axum::http::HeaderMap;
use axum::response::Response;
use fogbank_core::probe::RayAnswer;
use fogbank_core::request::{ProbeRay, ProbeRequest};
use fogbank_core::scene::{self, Airlight, CheckedScene};
use fogbank_core::{Progress, Renderer};
use schemars::{JsonSchema, SchemaGenerator};
use serde::Serialize;
use serde_json::json;

/// Rays times lights of a probe: each such pair is three numbers of its answer, which is then about as
/// large as the largest request.
pub const RAY_LIGHTS: usize = 1 << 19;

/// What a probe found.
#[derive(Serialize, JsonSchema)]
pub struct ProbeAnswer {
    /// One answer a ray, in the order of the request.
    pub rays: Vec<RayAnswer>,
}

/// Evaluates rays in f64.
pub async fn probe(
    State(app): State<App>,
    client: Client,
    request: Request,
) -> Result<Response, Problem> {
    let headers = request.headers().clone();
    let (scene, rays) = app.intake.read(request, ProbeRequest::check).await?;
    answer(&app, client, headers, scene, rays).await
}

/// Evaluates checked rays.
///
/// # Errors
/// 422 where the answer would be too large, 503 where there is no place, 504 past the deadline.
pub async fn answer(
    app: &App,
    client: Client,
    headers: HeaderMap,
    scene: CheckedScene,
    rays: Vec<ProbeRay>,
) -> Result<Response, Problem> {
    check_answer(rays.len(), scene.lights.len())?;
    let room = app.answers.reserve(client, probe_bytes(&scene, rays.len()))?;
    let deadline = app.deadline(scene.fog.airlight == Airlight::Reference);
    let order = Order::new(lane_of_probe(&scene, rays.len()), client, deadline);
    let work =
        move |renderer: &Renderer, progress: &Progress| renderer.probe(&scene, &rays, progress);
    let done = app.queue.run(order, work).await?;
    let (answer, place) = (ProbeAnswer { rays: done.value }, done.place);
    let encode = move || answer::large_json(&answer, &headers, room);
    let response = tokio::task::spawn_blocking(encode).await?;
    // Held until now: what waits to be written as JSON is bounded as well.
    drop(place);
    Ok(response)
}

/// Refuses what would have too large an answer.
fn check_answer(rays: usize, lights: usize) -> Result<(), Problem> {
    let pairs = rays.saturating_mul(lights);
    if pairs <= RAY_LIGHTS {
        return Ok(());
    }
    let detail =
        format!("{rays} rays times {lights} lights are more than the limit of {RAY_LIGHTS}");
    Err(Problem::invalid(vec![scene::Problem {
        pointer: "/rays".into(),
        code: scene::Code::TooMany,
        detail,
    }]))
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
