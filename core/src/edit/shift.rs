//! Blobs that are moved: `move`, which Rust keeps for itself.

use super::copy::moved;
use super::term::{Name, picked};
use super::{Desk, Refused, Tool};
use crate::json::limits::{self, COUNTS};
use crate::json::{Checker, Vec3, bounded};
use crate::scene::{CheckedScene, Scene};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Moves blobs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "MoveBlobs")]
pub struct Move {
    /// Their term.
    pub term: Name,
    /// Their places in its list.
    #[serde(deserialize_with = "bounded::list::<{ COUNTS.blobs }, _, _>")]
    #[schemars(length(max = COUNTS.blobs))]
    pub blobs: Vec<u32>,
    /// By how much [m].
    pub offset: Vec3,
}

impl Tool for Move {
    fn check(&self, check: &mut Checker, at: &dyn Fn(&str) -> String) {
        check.count(self.blobs.len(), COUNTS.blobs, "blobs", || at("blobs"));
        check.triple(self.offset.0, limits::COORDINATE, || at("offset"));
    }

    fn apply(&self, scene: &CheckedScene, _desk: &mut Desk) -> Result<Scene, Refused> {
        let mut after = (**scene).clone();
        let (blobs, places) = picked(&mut after, &self.term, &self.blobs)?;
        places.into_iter().for_each(|place| blobs[place] = moved(&blobs[place], self.offset));
        Ok(after)
    }

    fn names_blobs(&self) -> bool {
        true
    }
}
