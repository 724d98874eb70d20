//! What lies in a rectangle of a picture.

use super::Name;
use crate::frame::viewpoint::Viewpoint;
use crate::json::limits;
use crate::json::{Checker, Code};
use crate::media::Term;
use crate::scene::{Camera, CheckedScene, Problem};
use glam::{DVec2, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Asks for what lies in a rectangle of a picture.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SelectRequest {
    /// Left, top, right and bottom, as shares of the picture from its upper left corner.
    #[schemars(inner(range(min = limits::FRACTION.min, max = limits::FRACTION.max)))]
    pub rectangle: [f64; 4],
    /// The camera; the scene's own where nothing is said.
    #[serde(default)]
    pub camera: Option<Camera>,
    /// Width of the picture as a share of its height.
    #[serde(default = "aspect")]
    #[schemars(range(min = limits::ASPECT.min, max = limits::ASPECT.max))]
    pub aspect: f64,
}

/// Pixels down a picture of which only the proportions matter.
const PIXELS: f64 = 1e6;

fn aspect() -> f64 {
    4.0 / 3.0
}

/// What lies in a rectangle of a picture, hidden or not.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Selected {
    /// Blobs whose centres lie there, term by term.
    pub blobs: Vec<SelectedBlobs>,
    /// Lights that have a place: their ids, or their places in the list.
    pub lights: Vec<Name>,
    /// Emitters that stand there, likewise.
    pub emitters: Vec<Name>,
}

/// Blobs of one term.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct SelectedBlobs {
    /// The term: its id, or its place.
    pub term: Name,
    /// Their places in its list.
    pub blobs: Vec<u32>,
}

impl SelectRequest {
    /// Checks everything.
    ///
    /// # Errors
    /// What is wrong, with pointers into this request.
    pub fn check(self) -> Result<Self, Vec<Problem>> {
        let mut check = Checker::default();
        for (i, value) in self.rectangle.into_iter().enumerate() {
            check.number(value, limits::FRACTION, || format!("/rectangle/{i}"));
        }
        let [left, top, right, bottom] = self.rectangle;
        if left > right || top > bottom {
            let detail = "left and top come before right and bottom";
            check.refuse(Code::Conflict, || "/rectangle".into(), detail);
        }
        check.number(self.aspect, limits::ASPECT, || "/aspect".into());
        if let Some(camera) = &self.camera {
            camera.check(&mut check);
        }
        check.finish(self)
    }

    /// What lies in the rectangle.
    pub fn select(&self, scene: &CheckedScene) -> Selected {
        let camera = self.camera.as_ref().unwrap_or(&scene.camera);
        // Only its proportions matter; so many pixels have them to the last digit.
        let view = Viewpoint::new(camera, (self.aspect * PIXELS) as usize, PIXELS as usize);
        let [left, top, right, bottom] = self.rectangle;
        let is_there = |point: DVec3| {
            let place = view.project(point - view.position).map(|place| place / view.size());
            place.is_some_and(|DVec2 { x, y }| left <= x && x <= right && top <= y && y <= bottom)
        };
        let mut selected = Selected::default();
        for (place, term) in (0u32..).zip(&scene.fog.terms) {
            let common = term.common();
            let name = name(common.id, place);
            match term {
                _ if !common.enabled => {}
                Term::Gaussians(gaussians) => {
                    let centers = (0u32..).zip(&gaussians.blobs);
                    let there = centers.filter(|(_, blob)| is_there(blob.center.vector()));
                    let blobs: Vec<_> = there.map(|(i, _)| i).collect();
                    if !blobs.is_empty() {
                        selected.blobs.push(SelectedBlobs { term: name, blobs });
                    }
                }
                Term::Emitter(emitter) if is_there(emitter.position.vector()) => {
                    selected.emitters.push(name);
                }
                _ => {}
            }
        }
        for (place, lit) in scene.lamps() {
            if lit.source.apex().is_some_and(&is_there) {
                selected.lights.push(name(lit.light.id(), place as u32));
            }
        }
        selected
    }
}

fn name(id: Option<&str>, place: u32) -> Name {
    id.map_or(Name::Place(place), |id| Name::Id(id.to_owned()))
}
