//! `POST /v1/scenes/{id}/edits`: changes by hand, all or none.

use super::{Revised, a_write, revised, terms, write};
use crate::app::App;
use crate::edits::EditsRequest;
use crate::extract::Digested;
use crate::openapi::Operation;
use crate::problem::Problem;
use crate::scene_id::SceneId;
use axum::extract::{Request, State};
use axum::http::StatusCode;
use axum::response::Response;
use fogbank_core::Progress;
use schemars::SchemaGenerator;
use serde_json::json;
use std::sync::Arc;

/// Applies edits.
pub async fn edit(
    State(app): State<App>,
    SceneId(id): SceneId,
    request: Request,
) -> Result<Response, Problem> {
    let headers = request.headers().clone();
    let body: Digested<EditsRequest> = app.intake.digest(request, EditsRequest::check).await?;
    let (condition, key) = terms(&headers, &body)?;
    let (name, renderer) = (id.clone(), Arc::clone(&app.renderer));
    let progress = Progress::until(app.deadline(false));
    let written = write(&app, move |store| {
        store.write(&name, &condition, key, |head, strokes| {
            body.value.make((head, strokes), &renderer, &progress)
        })
    });
    Ok(revised(id, written.await?, true))
}

/// Its documentation.
pub fn edit_operation(schemas: &mut SchemaGenerator) -> Operation {
    let summary = "Changes a scene by hand: strokes of a brush, an eraser, an airbrush, and more. All edits are made, or \
        none; answers what changed. Where the scene would not be valid, pointers of the problem begin with `/scene`.";
    let stroke = json!({ "edits": [{
        "op": "paint_stroke", "points": [[-2, 0.5, 0], [2, 0.5, 0]], "radius": 0.6, "extinction": 0.4,
    }] });
    a_write(Operation::post("edit_scene", "scenes", summary).takes::<EditsRequest>(schemas))
        .refuses(&[StatusCode::CONFLICT])
        .example("stroke", "A stroke of fog.", stroke)
        .json::<Revised>(schemas)
}
