//! A request to change a stored scene by hand, be it by HTTP or over a socket.

use crate::store::record::Head;
use crate::store::{Made, Refusal};
use fogbank_core::edit::{self, Desk, Edit, Strokes};
use fogbank_core::json::bounded;
use fogbank_core::scene::limits::COUNTS;
use fogbank_core::scene::{CheckedScene, Checker, Code, Problem as Wrong};
use fogbank_core::{Progress, Renderer};
use schemars::JsonSchema;
use serde::Deserialize;

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
        edit::check(&self.edits, &mut check);
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
        (head, strokes): (Option<&Head>, Strokes),
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
