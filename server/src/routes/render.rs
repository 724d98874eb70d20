//! `POST /v1/render`: a picture of a scene.

use crate::accept;
use crate::app::App;
use crate::budget::Client;
use crate::openapi::Operation;
use crate::picture::{self, Encoded};
use crate::problem::Problem;
use crate::watch::JobId;
use axum::extract::{Request, State};
use axum::response::Response;
use fogbank_core::Frame;
use fogbank_core::image::Format;
use fogbank_core::request::RenderRequest;
use schemars::SchemaGenerator;
use serde_json::{Value, json};

/// Renders one layer of a frame in the format that `Accept` asks for.
pub async fn render(
    State(app): State<App>,
    client: Client,
    request: Request,
) -> Result<Response, Problem> {
    let format = accept::choose(request.headers(), &Format::ALL, Format::content_type)?;
    let job = JobId::of(request.headers())?;
    let (scene, mut view) = app.intake.read(request, RenderRequest::check).await?;
    view = view.for_format(format);
    let encode = move |frame: &Frame| Encoded::of(frame, &view, format);
    picture::answer(&app, client, job, scene, view, format, encode).await
}

/// Its documentation.
pub fn operation(schemas: &mut SchemaGenerator) -> Operation {
    let summary = "A picture of a scene, or another layer of its frame.";
    Operation::post("render", "pictures", summary)
        .takes::<RenderRequest>(schemas)
        .example("lamp", "A lamp in fog, above a floor.", lamp_in_fog())
        .example("empty", "The smallest request.", json!({ "scene": {}, "width": 8, "height": 8 }))
        .picture(&Format::ALL)
}

fn lamp_in_fog() -> Value {
    json!({
        "scene": {
            "camera": { "position": [0, 1.7, 8], "target": [0, 1, 0] },
            "surfaces": [{ "id": "floor", "shape": { "kind": "plane" } }],
            "lights": [{ "kind": "point", "position": [0, 2.2, 1], "intensity": [40, 34, 24] }],
            "fog": { "terms": [
                { "kind": "homogeneous", "extinction": 0.03 },
                { "kind": "gaussians", "blobs": [
                    { "center": [-1, 0.6, 0], "radius": 1.2, "extinction": 0.5 },
                ] },
            ] },
        },
        "width": 64,
        "height": 48,
        "exposure_ev": 1,
    })
}
