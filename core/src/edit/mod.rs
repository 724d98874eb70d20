//! Changes of a scene by hand: strokes of a brush, an eraser, an airbrush, and all that a client says as a
//! patch. Each is a function from a scene to a scene, and deterministic by its seed.
//!
//! A change costs what it touches: a scene's large lists are shared with the scene before
//! ([`Shared`](crate::shared::Shared)), and only what differs is checked again. Several changes are made all
//! or none.

mod airbrush;
mod copy;
mod delete;
mod emitter;
mod erase;
mod fogmap_paint;
mod paint_stroke;
mod particles;
mod patch;
mod select;
mod shift;
mod simulate;
mod stroke;
mod term;
#[cfg(test)]
mod tests;

pub use airbrush::Airbrush;
pub use copy::Copy;
pub use delete::Delete;
pub use emitter::{EmitterAdd, EmitterRemove, EmitterUpdate};
pub use erase::Erase;
pub use fogmap_paint::FogmapPaint;
pub use paint_stroke::PaintStroke;
pub use patch::PatchScene;
pub use select::{SelectRequest, Selected, SelectedBlobs};
pub use shift::Move;
pub use simulate::Simulate;
pub use stroke::{Onto, StrokePoint, Strokes};
pub use term::Name;

use crate::json::tagged::{Tagged, tagged};
use crate::json::{Checker, Code, Problem};
use crate::progress::{Interrupted, Progress};
use crate::scene::{CheckedScene, Scene};
use crate::shapes::Geometry;
use std::sync::Arc;

tagged!(
    by "op"
    /// One change of a scene.
    Edit {
        /// Places blobs along a stroke (Fogshop 2007, section 6).
        PaintStroke = "paint_stroke",
        /// Thins the blobs under a stroke, and deletes those of which nothing is left.
        Erase = "erase",
        /// Adds copies of blobs beside them.
        Copy = "copy",
        /// Moves blobs.
        Move = "move",
        /// Deletes blobs.
        Delete = "delete",
        /// Adds an emitter.
        EmitterAdd = "emitter_add",
        /// Changes an emitter.
        EmitterUpdate = "emitter_update",
        /// Takes an emitter away.
        EmitterRemove = "emitter_remove",
        /// Sprays particles that spread until they are stopped by surfaces or by the end.
        Airbrush = "airbrush",
        /// Lets blobs go as particles, and freezes them where they are then.
        Simulate = "simulate",
        /// Raises or lowers a fogmap under a stroke.
        FogmapPaint = "fogmap_paint",
        /// Changes anything (RFC 6902).
        PatchScene = "patch",
    }
);

/// One kind of change.
trait Tool {
    /// Looks at its numbers, and counts what it would make; `at` names its members.
    fn check(&self, check: &mut Checker, at: &dyn Fn(&str) -> String);

    /// The scene after it.
    fn apply(&self, scene: &CheckedScene, desk: &mut Desk) -> Result<Scene, Refused>;

    /// Whether it names blobs by their places, which other changes shift.
    fn names_blobs(&self) -> bool {
        false
    }

    /// The stroke that it belongs to.
    fn stroke(&self) -> Option<&str> {
        None
    }
}

impl Edit {
    fn tool(&self) -> &dyn Tool {
        match self {
            Self::PaintStroke(tool) => tool,
            Self::Erase(tool) => tool,
            Self::Copy(tool) => tool,
            Self::Move(tool) => tool,
            Self::Delete(tool) => tool,
            Self::EmitterAdd(tool) => tool,
            Self::EmitterUpdate(tool) => tool,
            Self::EmitterRemove(tool) => tool,
            Self::Airbrush(tool) => tool,
            Self::Simulate(tool) => tool,
            Self::FogmapPaint(tool) => tool,
            Self::PatchScene(tool) => tool,
        }
    }

    /// Whether it names blobs by their places, which other changes shift.
    pub fn names_blobs(&self) -> bool {
        self.tool().names_blobs()
    }

    /// The stroke that it belongs to: changes of one stroke are undone together.
    pub fn stroke(&self) -> Option<&str> {
        self.tool().stroke()
    }

    /// What it is, as JSON says it.
    pub fn op(&self) -> &'static str {
        self.word()
    }
}

/// What changes are made with.
pub struct Desk<'a> {
    /// The surfaces of a scene, for strokes on them and for particles that bounce off them.
    pub surfaces: &'a dyn Fn(&CheckedScene) -> Result<Arc<Geometry>, Interrupted>,
    /// Strokes that may go on.
    pub strokes: &'a mut Strokes,
    /// Whether to go on.
    pub progress: &'a Progress,
}

/// Why a change was not made.
#[derive(Debug)]
pub enum Refusal {
    /// What is wrong: pointers into the list of edits, or into the scene as it would be, which begin with
    /// `/scene`.
    Invalid(Vec<Problem>),
    /// It took too long.
    Interrupted,
}

/// Why a tool does not apply.
#[derive(Debug)]
enum Refused {
    /// A member of it is wrong, for this scene.
    Member {
        member: String,
        code: Code,
        detail: String,
    },
    /// The scene would not be valid.
    Scene(Vec<Problem>),
    Interrupted,
}

impl Refused {
    fn conflict(member: &str, detail: impl Into<String>) -> Self {
        Self::Member { member: member.into(), code: Code::Conflict, detail: detail.into() }
    }
}

impl From<Interrupted> for Refused {
    fn from(Interrupted: Interrupted) -> Self {
        Self::Interrupted
    }
}

/// Looks at the numbers of some changes, and counts what they would make, before anything is made.
pub fn check(edits: &[Edit], check: &mut Checker) {
    for (i, edit) in edits.iter().enumerate() {
        edit.tool().check(check, &|name| format!("/edits/{i}/{name}"));
    }
}

/// A scene after some changes that were [checked](check()), one after the other: all of them, or none.
///
/// # Errors
/// What is wrong with one of them, or with the scene as it would be.
pub fn apply(
    scene: &CheckedScene,
    edits: &[Edit],
    desk: &mut Desk,
) -> Result<CheckedScene, Refusal> {
    edits.iter().enumerate().try_fold(scene.clone(), |scene, (i, edit)| {
        let tool = edit.tool();
        desk.progress.check().map_err(|_| Refusal::Interrupted)?;
        desk.strokes.settle_but(tool.stroke());
        let mut after = tool.apply(&scene, desk).map_err(|refused| refused.of(i))?;
        after.name_all();
        after.check_after(&scene).map_err(|problems| Refused::Scene(problems).of(i))
    })
}

impl Refused {
    /// As the refusal of the edit at that place.
    fn of(self, i: usize) -> Refusal {
        match self {
            Self::Interrupted => Refusal::Interrupted,
            Self::Member { member, code, detail } => {
                let pointer = format!("/edits/{i}/{member}");
                Refusal::Invalid(vec![Problem { pointer, code, detail }])
            }
            Self::Scene(problems) => Refusal::Invalid(in_scene(problems)),
        }
    }
}

/// Problems of a scene as it would be.
pub fn in_scene(problems: Vec<Problem>) -> Vec<Problem> {
    let of_scene =
        |problem: Problem| Problem { pointer: format!("/scene{}", problem.pointer), ..problem };
    problems.into_iter().map(of_scene).collect()
}
