//! Anything, as a patch.

use super::stroke::check_stroke;
use super::{Desk, Refused, Tool};
use crate::json::Checker;
use crate::json::document::{Node, Patch, closed};
use crate::json::limits::COUNTS;
use crate::scene::{CheckedScene, Scene};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Changes anything.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PatchScene {
    /// What changes (RFC 6902), with pointers into the scene.
    pub patch: Patch,
    /// Names the drag that it is a part of: all of it is undone together.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1, max = COUNTS.id_chars))]
    pub stroke: Option<String>,
}

impl Tool for PatchScene {
    fn check(&self, check: &mut Checker, at: &dyn Fn(&str) -> String) {
        self.patch.check(check, || at("patch"));
        check_stroke(self.stroke(), check, at);
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

    fn stroke(&self) -> Option<&str> {
        self.stroke.as_deref()
    }
}
