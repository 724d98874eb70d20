//! What is written of a scene and of its revisions.

use fogbank_core::edit::Strokes;
use fogbank_core::json::document::Patch;
use fogbank_core::scene::CheckedScene;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A scene at a revision.
#[derive(Debug)]
pub struct Head {
    /// Larger with every write.
    pub revision: u64,
    /// The scene, in which everything has an id.
    pub scene: CheckedScene,
}

/// What is known of a scene, besides the scene.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Row {
    /// The newest revision.
    pub revision: u64,
    /// When it was made [ms since 1970].
    pub at_ms: u64,
    /// The revision of the snapshot.
    pub snapshot: u64,
    /// Its size [bytes].
    pub snapshot_bytes: u64,
    /// The oldest revision that history names.
    pub oldest: u64,
    /// Size of all changes that it names [bytes].
    pub history_bytes: u64,
    /// Size of those since the snapshot [bytes].
    pub bytes_since: u64,
}

/// What kind of write made a revision.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// The scene was made: that cannot be undone.
    Create,
    /// A whole scene was put in its place.
    Put,
    /// A merge patch or a JSON patch.
    Patch,
    /// Edits.
    Edit,
    /// Earlier revisions were reverted.
    Undo,
    /// What was undone was done again.
    Redo,
}

/// What a revision is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Heading {
    /// Its number.
    pub revision: u64,
    /// When it was made [ms since 1970, UTC].
    pub at_ms: u64,
    /// What kind of write made it.
    pub kind: Kind,
    /// The operations of its edits.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ops: Vec<String>,
    /// The stroke that it belongs to: revisions of one stroke are undone together.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stroke: Option<String>,
    /// The first and the last of the revisions that it reverted, or did again.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub of: Option<[u64; 2]>,
    /// The key of the request that made it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(skip)]
    pub key: Option<String>,
}

/// What a revision changed.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Change {
    /// From the revision before to this one.
    pub patch: Patch,
    /// And back.
    pub inverse: Patch,
}

/// A write that was made in memory, and is to be made durable.
pub struct Record {
    /// The scene's id.
    pub id: String,
    /// The revision that it was made from; none if the scene is new.
    pub base: Option<u64>,
    /// What it made.
    pub head: Arc<Head>,
    /// The revision.
    pub heading: Heading,
    /// Its [`Change`], as JSON.
    pub change: Vec<u8>,
    /// What a repeated request with its key must agree in.
    pub digest: u64,
    /// Strokes that may go on.
    pub strokes: Strokes,
}
