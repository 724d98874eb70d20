//! `POST /v1/render`: a picture of a scene.

use crate::accept;
use crate::app::App;
use crate::openapi::Operation;
use crate::picture::{self, Encoded};
use crate::problem::Problem;
use crate::watch::JobId;
use axum::extract::{Request, State};
use axum::response::Response;
use fogbank_core::Frame;
use fogbank_core::image::{Format, encode};
use fogbank_core::request::RenderRequest;
use schemars::SchemaGenerator;

/// Renders one layer of a frame in the format that `Accept` asks for.
pub async fn render(State(app): State<App>, request: Request) -> Result<Response, Problem> {
    let format = accept::choose(request.headers(), &Format::ALL, Format::content_type)?;
    let job = JobId::of(request.headers())?;
    let (scene, mut view) = app.intake.read(request, RenderRequest::check).await?;
    view = view.for_format(format);
    let encode = move |frame: &Frame| {
        let bytes = encode(frame, &view, format)?;
        let (content_type, backend) = (format.content_type(), frame.backend);
        Ok(Encoded { bytes, backend, content_type, extra: None })
    };
    picture::answer(&app, job, scene, view, encode).await
}

/// Its documentation.
pub fn operation(schemas: &mut SchemaGenerator) -> Operation {
    let summary = "A picture of a scene, or another layer of its frame.";
    Operation::post::<RenderRequest>(summary, schemas).picture(&Format::ALL)
}
