//! The eraser (Fogshop 2007, section 6): lowers the extinction of the blobs that it covers, and deletes those of
//! which nothing is left.

use super::stroke::{StrokePoint, bounds, check_points, check_stroke, distance};
use super::term::{Name, all_gaussians};
use super::{Desk, Refused, Tool};
use crate::json::limits::{self, COUNTS};
use crate::json::{Checker, bounded};
use crate::media::gaussians::HALF_SQRT_PI;
use crate::scene::{Blob, CheckedScene, Scene};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Optical depth through the middle of a blob below which nothing is left of it: an eighth of the step between two
/// grey levels.
const NOTHING: f64 = 5e-4;

/// Thins the blobs whose centres lie under a stroke.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Erase {
    /// The stroke: positions [m], each with the hand's pressure if it has one.
    #[serde(deserialize_with = "bounded::list::<{ COUNTS.stroke_points }, _, _>")]
    #[schemars(length(min = 1, max = COUNTS.stroke_points))]
    pub points: Vec<StrokePoint>,
    /// How far around it the eraser reaches [m].
    #[schemars(range(min = limits::RADIUS.min, max = limits::RADIUS.max))]
    pub radius: f64,
    /// The share of the extinction that is taken away; 1 deletes.
    #[serde(default = "strength")]
    #[schemars(range(min = limits::FRACTION.min, max = limits::FRACTION.max))]
    pub strength: f64,
    /// The term that is erased from; all of blobs where nothing is said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub term: Option<Name>,
    /// Names the stroke that it is a part of: all of it is undone together.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1, max = COUNTS.id_chars))]
    pub stroke: Option<String>,
}

fn strength() -> f64 {
    1.0
}

impl Tool for Erase {
    fn check(&self, check: &mut Checker, at: &dyn Fn(&str) -> String) {
        check_points(&self.points, check, at);
        check.number(self.radius, limits::RADIUS, || at("radius"));
        check.number(self.strength, limits::FRACTION, || at("strength"));
        check_stroke(self.stroke(), check, at);
    }

    fn apply(&self, scene: &CheckedScene, _desk: &mut Desk) -> Result<Scene, Refused> {
        let mut after = (**scene).clone();
        let (min, max) = bounds(&self.points, self.radius);
        let is_covered = |blob: &Blob| {
            let center = blob.center.vector();
            center.cmpge(min).all()
                && center.cmple(max).all()
                && distance(&self.points, center) < self.radius
        };
        for gaussians in all_gaussians(&mut after, self.term.as_ref())? {
            // A list that nothing is erased from stays shared.
            if gaussians.blobs.iter().any(is_covered) {
                gaussians.blobs.retain_mut(|blob| !is_covered(blob) || self.thin(blob));
            }
        }
        Ok(after)
    }

    fn stroke(&self) -> Option<&str> {
        self.stroke.as_deref()
    }
}

impl Erase {
    /// Thins a blob; says whether anything is left of it.
    fn thin(&self, blob: &mut Blob) -> bool {
        blob.extinction = blob.extinction.times(1.0 - self.strength);
        let most = blob.extinction.values().iter().fold(0.0, |most: f64, value| most.max(*value));
        2.0 * HALF_SQRT_PI * blob.radius * most > NOTHING
    }
}
