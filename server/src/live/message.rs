//! What goes over the socket.

use crate::edits::EditsRequest;
use crate::problem::Problem;
use crate::watch::{HEADER, JobId};
use fogbank_core::edit::Edit;
use fogbank_core::json::document::Patch;
use fogbank_core::request::{Eye, FrameRequest, Layer, Options, Quality, Tonemap, View};
use fogbank_core::scene::{self, Camera, Code, Problem as Wrong, Scene};
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
    /// It wants to see nothing until its next view.
    Stop,
}

/// What a client wants to see.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// Its number of this view.
    pub seq: u64,
    /// From where, and when.
    pub eye: Eye,
    /// The picture.
    pub view: View,
    /// What its pictures are called while they are made, for whoever asks how far they are.
    pub job: Option<JobId>,
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
    #[serde(default)]
    samples: Option<u32>,
    #[serde(default)]
    options: Options,
    #[serde(default)]
    job: Option<String>,
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
            "stop" => Ok(Self::Stop),
            _ => {
                let detail = "expected one of view, edit, ack, stop".to_owned();
                let code = Code::UnknownWord;
                Err(Problem::invalid(vec![Wrong { pointer: "/type".into(), code, detail }]))
            }
        };
        read().map_err(|problem| (seq, problem))
    }
}

impl ViewMessage {
    fn check(self) -> Result<Up, Vec<Wrong>> {
        let request = FrameRequest {
            width: self.width,
            height: self.height,
            quality: Quality::Draft,
            layer: self.layer,
            camera: Some(self.camera),
            samples: self.samples,
            time_s: self.time_s,
            exposure_ev: self.exposure_ev,
            tonemap: self.tonemap,
            options: self.options,
        };
        let (view, eye) = request.check()?;
        let detail = format!("a job is called as in {HEADER}");
        let wrong = Wrong { pointer: "/job".into(), code: Code::OutOfRange, detail };
        let read = |job: String| JobId::read(&job).ok_or(vec![wrong]);
        let job = self.job.map(read).transpose()?;
        Ok(Up::View(Box::new(Wanted { seq: self.seq, eye, view, job })))
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
        /// The scene; left out where the client said that it has this revision.
        #[serde(skip_serializing_if = "Option::is_none")]
        scene: Option<&'a Scene>,
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
    /// The nearest and the farthest depth [m], between which the colours of the layer `depth` lie.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_range: Option<[f32; 2]>,
    /// Where it was rendered.
    pub backend: &'static str,
    /// Passes whose results were kept from an earlier frame.
    pub reused: Vec<&'static str>,
    /// What it took [ms]: waiting, each pass, encoding.
    pub timing_ms: BTreeMap<&'static str, f64>,
}
