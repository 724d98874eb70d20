//! Anything, as a patch.

use super::{Desk, Refused, Tool};
use crate::json::Checker;
use crate::json::document::{Node, Part, Patch, Place};
use crate::scene::{CheckedScene, Problem, Scene};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Changes anything.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PatchScene {
    /// What changes (RFC 6902), with pointers into the scene.
    pub patch: Patch,
}

impl Tool for PatchScene {
    fn check(&self, check: &mut Checker, at: &dyn Fn(&str) -> String) {
        self.patch.check(check, || at("patch"));
    }

    fn apply(&self, scene: &CheckedScene, _desk: &mut Desk) -> Result<Scene, Refused> {
        let mut document = open(scene);
        self.patch.clone().apply(&mut document).map_err(|problem| Refused::Member {
            member: format!("patch{}", problem.pointer),
            code: problem.code,
            detail: problem.detail,
        })?;
        close(document).map_err(Refused::Scene)
    }
}

/// A scene as a document, of which nothing is written out yet.
pub fn open(scene: &Scene) -> Node {
    Node::kept(scene)
}

/// The scene that a document holds, not yet checked.
///
/// # Errors
/// Why it holds none, with pointers into it.
pub fn close(document: Node) -> Result<Scene, Vec<Problem>> {
    let mut check = Checker::default();
    let scene = Scene::close(document, &Place::Root, &mut check);
    check.finish(()).map(|()| scene.unwrap_or_default())
}
