//! Copies of blobs, beside them and in the same term.

use super::term::{Name, picked};
use super::{Desk, Refused, Tool};
use crate::json::limits::{self, COUNTS};
use crate::json::{Checker, Vec3, bounded};
use crate::scene::{Blob, CheckedScene, Scene};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Adds copies of blobs beside them, behind all others of their term.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Copy {
    /// Their term.
    pub term: Name,
    /// Their places in its list.
    #[serde(deserialize_with = "bounded::list::<{ COUNTS.blobs }, _, _>")]
    #[schemars(length(max = COUNTS.blobs))]
    pub blobs: Vec<u32>,
    /// By how much the copies are moved [m].
    pub offset: Vec3,
}

impl Tool for Copy {
    fn check(&self, check: &mut Checker, at: &dyn Fn(&str) -> String) {
        check.count(self.blobs.len(), COUNTS.blobs, "blobs", || at("blobs"));
        check.triple(self.offset.0, limits::COORDINATE, || at("offset"));
    }

    fn apply(&self, scene: &CheckedScene, _desk: &mut Desk) -> Result<Scene, Refused> {
        let mut after = (**scene).clone();
        let (blobs, places) = picked(&mut after, &self.term, &self.blobs)?;
        let copies: Vec<_> =
            places.iter().map(|place| moved(&blobs[*place], self.offset)).collect();
        blobs.extend(copies);
        Ok(after)
    }

    fn names_blobs(&self) -> bool {
        true
    }
}

/// The same blob elsewhere.
pub fn moved(blob: &Blob, offset: Vec3) -> Blob {
    Blob { center: Vec3((blob.center.vector() + offset.vector()).to_array()), ..*blob }
}
