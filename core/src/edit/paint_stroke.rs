//! The paintbrush (Fogshop 2007, section 6): blobs along a stroke, three quarters of a radius apart, each moved by less
//! than a radius across the stroke.
//!
//! Ours: the first blob of a stroke stays where the hand began, because the stroke has no direction there yet; so a
//! stroke gives the same blobs in one call and in many.

use super::stroke::{Dab, Onto, StrokePoint, Trail, check_onto, check_points, check_stroke, drawn};
use super::term::{Name, painted};
use super::{Desk, Refused, Tool};
use crate::json::limits::{self, COUNTS};
use crate::json::{Checker, Spectrum, Vec3, bounded};
use crate::random::lattice;
use crate::rounding::rounded;
use crate::scene::{Blob, CheckedScene, Scene};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Places blobs along a stroke.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PaintStroke {
    /// The stroke: positions [m], each with the hand's pressure if it has one.
    #[serde(deserialize_with = "bounded::list::<{ COUNTS.stroke_points }, _, _>")]
    #[schemars(length(min = 1, max = COUNTS.stroke_points))]
    pub points: Vec<StrokePoint>,
    /// What it is drawn on: a plane, or `surfaces`; without it the points are where they are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plane: Option<Onto>,
    /// From where it is drawn on surfaces [m]; the scene's camera where nothing is said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub eye: Option<Vec3>,
    /// Radius of the blobs [m].
    #[schemars(range(min = limits::RADIUS.min, max = limits::RADIUS.max))]
    pub radius: f64,
    /// Extinction in the middle of each [1/m].
    #[schemars(schema_with = "Spectrum::extinction")]
    pub extinction: Spectrum,
    /// Distance from one to the next, in radii.
    #[serde(default = "spacing")]
    #[schemars(range(min = limits::SPACING.min, max = limits::SPACING.max))]
    pub spacing: f64,
    /// By how much they are moved across the stroke at most, in radii.
    #[serde(default = "jitter")]
    #[schemars(range(min = limits::FRACTION.min, max = limits::FRACTION.max))]
    pub jitter: f64,
    /// Chooses where to.
    #[serde(default)]
    pub seed: u32,
    /// The term that they are added to; the last one of blobs where nothing is said, made if there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub term: Option<Name>,
    /// Names the stroke: with the same name it goes on where it left off, and all of it is undone together.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1, max = COUNTS.id_chars))]
    pub stroke: Option<String>,
}

fn spacing() -> f64 {
    0.75
}

fn jitter() -> f64 {
    1.0
}

impl Tool for PaintStroke {
    fn check(&self, check: &mut Checker, at: &dyn Fn(&str) -> String) {
        check_points(&self.points, check, at);
        check_onto(self.plane.as_ref(), check, at);
        if let Some(eye) = self.eye {
            check.triple(eye.0, limits::COORDINATE, || at("eye"));
        }
        check.number(self.radius, limits::RADIUS, || at("radius"));
        check.spectrum(self.extinction, limits::EXTINCTION, || at("extinction"));
        check.number(self.spacing, limits::SPACING, || at("spacing"));
        check.number(self.jitter, limits::FRACTION, || at("jitter"));
        check_stroke(self.stroke(), check, at);
    }

    fn apply(&self, scene: &CheckedScene, desk: &mut Desk) -> Result<Scene, Refused> {
        let points = drawn(&self.points, (self.plane.as_ref(), self.eye), scene, desk)?;
        let mut brush = desk.strokes.brush(self.stroke());
        let dabs = brush.go(&points, self.spacing * self.radius)?;
        let mut after = (**scene).clone();
        let pressed = dabs.iter().filter(|dab| dab.pressure > 0.0);
        let blobs: Vec<_> = pressed.map(|dab| self.blob(dab)).collect();
        // A stroke beside all surfaces changes nothing.
        if !blobs.is_empty() {
            painted(&mut after, self.term.as_ref())?.1.blobs.extend(blobs);
        }
        desk.strokes.leave(self.stroke(), Trail::Brush(brush));
        Ok(after)
    }

    fn stroke(&self) -> Option<&str> {
        self.stroke.as_deref()
    }
}

impl PaintStroke {
    fn blob(&self, dab: &Dab) -> Blob {
        let [far, turn] = [0, 1].map(|i| lattice(dab.number.into(), i, self.seed.into()));
        let offset = dab.along.map(|along| {
            let (across, up) = along.any_orthonormal_pair();
            // Even over the disc.
            let length = self.jitter * self.radius * far.sqrt();
            length * ((TAU * turn).cos() * across + (TAU * turn).sin() * up)
        });
        let center = dab.center + offset.unwrap_or_default();
        let extinction = self.extinction.times(dab.pressure);
        Blob { center: rounded(center, steps(self.radius)), radius: self.radius, extinction }
    }
}

/// Places of a brush are rounded to a power of ten below a thousandth of its radius: nobody sees it, and patches
/// are half as long.
pub fn steps(radius: f64) -> f64 {
    10f64.powf((1e3 / radius).log10().ceil())
}
