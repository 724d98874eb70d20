//! What goes over the socket.

use crate::edits::EditsRequest;
use crate::problem::Problem;
use fogbank_core::edit::Edit;
use fogbank_core::json::document::Patch;
use fogbank_core::request::{FrameRequest, Layer, Quality, Tonemap, View};
use fogbank_core::scene::{self, Camera, Problem as Wrong, Scene};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What a client says.
#[derive(Debug)]
pub enum Up {
    /// What it wants to see from now on.
    View(Box<Wanted>),
    /// What it changes.
    Edit(u64, Box<EditsRequest>),
    /// The frame that it has shown.
    Ack(u64),
}

/// What a client wants to see.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// Its number of this view.
    pub seq: u64,
    /// From where.
    pub camera: Camera,
    /// The picture.
    pub view: View,
    /// When, if not at the scene's own time.
    pub time_s: Option<f64>,
}

/// Tells messages apart; what else they hold is read then.
#[derive(Deserialize, JsonSchema)]
struct Kind {
    /// What is said.
    #[serde(rename = "type")]
    kind: String,
    /// The client's number of it.
    #[serde(default)]
    seq: Option<u64>,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct ViewMessage {
    #[serde(rename = "type")]
    _kind: String,
    seq: u64,
    camera: Camera,
    width: u32,
    height: u32,
    #[serde(default)]
    layer: Layer,
    #[serde(default)]
    exposure_ev: f64,
    #[serde(default)]
    tonemap: Tonemap,
    #[serde(default)]
    time_s: Option<f64>,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct EditMessage {
    #[serde(rename = "type")]
    _kind: String,
    seq: u64,
    edit: Edit,
    #[serde(default)]
    base_revision: Option<u64>,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct AckMessage {
    #[serde(rename = "type")]
    _kind: String,
    frame: u64,
}

impl Up {
    /// What a text says.
    ///
    /// # Errors
    /// What is wrong with it, and its number.
    pub fn read(text: &str) -> Result<Self, (Option<u64>, Problem)> {
        let bytes = text.as_bytes();
        let Kind { kind, seq } = scene::read(bytes).map_err(|error| (None, error.into()))?;
        let read = || match kind.as_str() {
            "view" => scene::read::<ViewMessage>(bytes)?.check().map_err(Problem::invalid),
            "edit" => scene::read::<EditMessage>(bytes)?.check().map_err(Problem::invalid),
            "ack" => Ok(Self::Ack(scene::read::<AckMessage>(bytes)?.frame)),
            _ => {
                let detail = "expected one of view, edit, ack".to_owned();
                let code = scene::Code::UnknownWord;
                Err(Problem::invalid(vec![Wrong { pointer: "/type".into(), code, detail }]))
            }
        };
        read().map_err(|problem| (seq, problem))
    }
}

impl ViewMessage {
    fn check(self) -> Result<Up, Vec<Wrong>> {
        let Self { seq, camera, width, height, layer, exposure_ev, tonemap, time_s, .. } = self;
        let (quality, samples) = (Quality::Draft, None);
        let request =
            FrameRequest { width, height, quality, layer, samples, time_s, exposure_ev, tonemap };
        let (view, time_s) = request.check()?;
        // The camera by the scene's own check, without its fog and surfaces.
        Scene { camera: camera.clone(), ..Scene::default() }.check()?;
        Ok(Up::View(Box::new(Wanted { seq, camera, view, time_s })))
    }
}

impl EditMessage {
    fn check(self) -> Result<Up, Vec<Wrong>> {
        let request = EditsRequest { edits: vec![self.edit], base_revision: self.base_revision };
        let request = request.check().map_err(of_edit)?;
        Ok(Up::Edit(self.seq, Box::new(request)))
    }
}

/// Pointers into a message of one edit.
pub fn of_edit(problems: Vec<Wrong>) -> Vec<Wrong> {
    let moved = |problem: Wrong| match problem.pointer.strip_prefix("/edits/0") {
        Some(rest) => Wrong { pointer: format!("/edit{rest}"), ..problem },
        None => problem,
    };
    problems.into_iter().map(moved).collect()
}

/// What the server says.
#[derive(Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum Down<'a> {
    /// The first word: the scene.
    Hello {
        /// Its id.
        id: &'a str,
        /// The revision that it is at.
        revision: u64,
        /// The scene.
        scene: &'a Scene,
    },
    /// It changed, whoever did it.
    Scene {
        /// The revision that it is at now.
        revision: u64,
        /// What changed since the one that was told before.
        patch: &'a Patch,
    },
    /// How many look at it.
    Viewers {
        /// So many, this one included.
        count: usize,
    },
    /// Something was refused.
    Error {
        /// The client's number of it.
        #[serde(skip_serializing_if = "Option::is_none")]
        seq: Option<u64>,
        /// Why.
        problem: &'a Problem,
    },
}

/// How good a frame is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Tier {
    /// For a moving hand.
    Draft,
    /// Every pixel.
    Full,
}

/// What stands in front of a picture.
#[derive(Serialize)]
pub struct Header {
    /// The frame's number, to be acknowledged.
    pub frame: u64,
    /// The view that it answers.
    pub seq: u64,
    /// The revision of the scene that it shows.
    pub revision: u64,
    /// How good it is.
    pub tier: Tier,
    /// Its size as a share of what the view asked for.
    pub scale: f64,
    /// What the picture is.
    pub content_type: &'static str,
    /// Pixels along a row.
    pub width: u32,
    /// Rows of pixels.
    pub height: u32,
    /// What it took [ms]: waiting, each pass, encoding.
    pub timing_ms: BTreeMap<&'static str, f64>,
}
