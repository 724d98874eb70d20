//! `POST /v1/scenes/{id}/edits`: changes by hand, all or none.

use super::{Revised, SceneId, a_write, revised, terms, write};
use crate::app::App;
use crate::extract::Digested;
use crate::openapi::Operation;
use crate::problem::Problem;
use crate::store::{Made, Refusal};
use axum::extract::{Request, State};
use axum::http::StatusCode;
use axum::response::Response;
use fogbank_core::edit::{self, Desk, Edit, Strokes};
use fogbank_core::json::bounded;
use fogbank_core::scene::limits::COUNTS;
use fogbank_core::scene::{CheckedScene, Checker, Code, Problem as Wrong};
use fogbank_core::{Progress, Renderer};
use schemars::{JsonSchema, SchemaGenerator};
use serde::Deserialize;
use serde_json::json;
use std::sync::Arc;

/// Changes of a scene by hand.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EditsRequest {
    /// One after the other: all of them, or none.
    #[serde(deserialize_with = "bounded::list::<{ COUNTS.edits }, _, _>")]
    #[schemars(length(min = 1, max = COUNTS.edits))]
    pub edits: Vec<Edit>,
    /// The revision that the scene must be at; edits that name blobs by their places need it.
    #[serde(default)]
    pub base_revision: Option<u64>,
}

impl EditsRequest {
    /// Checks everything that does not depend on the scene.
    ///
    /// # Errors
    /// What is wrong, with pointers into this request.
    pub fn check(self) -> Result<Self, Vec<Wrong>> {
        let mut check = Checker::default();
        check.count(self.edits.len(), COUNTS.edits, "edits", || "/edits".into());
        if self.edits.is_empty() {
            check.refuse(Code::WrongLength, || "/edits".into(), "there is nothing to do");
        }
        for (i, edit) in self.edits.iter().enumerate().take(COUNTS.edits) {
            edit.check(&mut check, &|name| format!("/edits/{i}/{name}"));
        }
        if self.base_revision.is_none() && self.edits.iter().any(Edit::names_blobs) {
            let detail =
                "edits that name blobs by their places need the `base_revision` that these are of";
            check.refuse(Code::Missing, || "/base_revision".into(), detail);
        }
        check.finish(self)
    }

    /// The scene after them.
    ///
    /// # Errors
    /// Why there is none.
    pub fn make(
        &self,
        (head, strokes): (Option<&crate::store::record::Head>, Strokes),
        renderer: &Renderer,
        progress: &Progress,
    ) -> Result<Made, Refusal> {
        let head = head.ok_or(Refusal::Missing)?;
        if self.base_revision.is_some_and(|base| base != head.revision) {
            return Err(Refusal::MovedOn(head.revision));
        }
        let mut strokes = strokes;
        let surfaces = |scene: &CheckedScene| renderer.surfaces(scene, progress);
        let mut desk = Desk { surfaces: &surfaces, strokes: &mut strokes, progress };
        let scene =
            edit::apply(&head.scene, &self.edits, &mut desk).map_err(|refusal| match refusal {
                edit::Refusal::Invalid(problems) => Refusal::Invalid(problems),
                edit::Refusal::Interrupted => Refusal::Late,
            })?;
        let ops = self.edits.iter().map(|edit| edit.op().to_owned()).collect();
        Ok(Made::edited(scene, ops, self.stroke().map(str::to_owned), strokes))
    }

    /// The stroke that all of them belong to.
    fn stroke(&self) -> Option<&str> {
        let first = self.edits.first()?.stroke()?;
        self.edits.iter().all(|edit| edit.stroke() == Some(first)).then_some(first)
    }
}

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
