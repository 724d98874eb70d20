//! Anything, as a patch.

use super::{Desk, Refused, Tool};
use crate::json::Checker;
use crate::json::document::{Node, Patch, closed};
use crate::scene::{CheckedScene, Scene};
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
        let mut document = Node::kept(&**scene);
        self.patch.clone().apply(&mut document).map_err(|problem| Refused::Member {
            member: format!("patch{}", problem.pointer),
            code: problem.code,
            detail: problem.detail,
        })?;
        closed(document).map_err(Refused::Scene)
    }
}
