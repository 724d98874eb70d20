//! Blobs that are deleted.

use super::term::{Name, picked};
use super::{Desk, Refused, Tool};
use crate::json::limits::COUNTS;
use crate::json::{Checker, bounded};
use crate::scene::{CheckedScene, Scene};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Deletes blobs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Delete {
    /// Their term.
    pub term: Name,
    /// Their places in its list.
    #[serde(deserialize_with = "bounded::list::<{ COUNTS.blobs }, _, _>")]
    #[schemars(length(max = COUNTS.blobs))]
    pub blobs: Vec<u32>,
}

impl Tool for Delete {
    fn check(&self, check: &mut Checker, at: &dyn Fn(&str) -> String) {
        check.count(self.blobs.len(), COUNTS.blobs, "blobs", || at("blobs"));
    }

    fn apply(&self, scene: &CheckedScene, _desk: &mut Desk) -> Result<Scene, Refused> {
        let mut after = (**scene).clone();
        let (blobs, places) = picked(&mut after, &self.term, &self.blobs)?;
        let (mut places, mut place) = (places.into_iter().peekable(), 0);
        blobs.retain(|_| {
            place += 1;
            places.next_if_eq(&(place - 1)).is_none()
        });
        Ok(after)
    }

    fn names_blobs(&self) -> bool {
        true
    }
}
