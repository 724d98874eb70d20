//! A sum of Gaussian blobs: β(x) = Σ cᵢ exp(−aᵢ² |x − bᵢ|²) (Fogshop 2007, eqs. 6–7).
//!
//! `blob` has the closed forms of one, `tree` finds those that matter, `exact` sums them up along one
//! ray in f64, `list` along a batch, `lanes` along the few rays that stand for a patch.

mod blob;
pub mod draw;
mod exact;
mod lanes;
mod list;
mod prune;
mod tree;

use blob::Line;
pub use blob::{Gaussian, HALF_SQRT_PI, Seen};
pub use draw::Draw;
pub use list::{BlobList, ExactRay, Packed, add_depth, not_negative};
pub use prune::Pruning;

use super::places::Places;
use super::toward::Toward;
use super::{
    Along, Medium, Moment, Near, Outline, PICTURE_LOSS, Patched, Search, Term, TermKind, Ways,
};
use crate::geometry::batch::{Rays, Row};
use crate::geometry::bundle::Bundle;
use crate::geometry::{Beyond, Origin, Ray};
use crate::json::document::{Part, parts};
use crate::json::limits::{self, COUNTS};
use crate::json::{Albedo, Checker, Code, Spectrum, Vec3, bounded};
use crate::phase::Phase;
use crate::progress::Job;
use crate::shared::Shared;
use exact::EVERYWHERE_M;
use fearless_simd::{Level, dispatch};
use glam::DVec3;
use lanes::PatchBlobs;
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};
use std::borrow::Cow;
use std::sync::OnceLock;
use tree::BlobTree;

/// A sum of Gaussian blobs: β(x) = Σ extinction · exp(−|x − center|² / radius²).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Gaussians {
    /// Name of this term, unique among the terms.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1, max = limits::COUNTS.id_chars))]
    pub id: Option<String>,
    /// False removes it from the fog.
    pub enabled: bool,
    /// Share of the extinguished light that this term scatters; the fog's own where nothing is said.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub albedo: Option<Albedo>,
    /// Into which directions this term scatters; as the fog's own where nothing is said.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phase: Option<Phase>,
    /// Share of the wind that moves this term, from 0 to 1.
    #[schemars(range(min = limits::FRACTION.min, max = limits::FRACTION.max))]
    pub wind_response: f64,
    /// The blobs.
    #[serde(deserialize_with = "bounded::shared::<{ COUNTS.blobs }, _, _>")]
    #[schemars(length(max = COUNTS.blobs), extend("x-items-in-all" = COUNTS.blobs))]
    pub blobs: Shared<Vec<Blob>>,
    /// Instead of blobs: the same ones at rising times, a simulation that is played back. Between two frames each
    /// blob changes in a straight line.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[serde(deserialize_with = "frames")]
    #[schemars(length(min = 1, max = COUNTS.frames))]
    pub frames: Option<Vec<BlobFrame>>,
    /// How view rays see the blobs.
    pub draw: Draw,
}

/// The blobs at a time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct BlobFrame {
    /// When [s].
    #[schemars(range(min = limits::TIME.min, max = limits::TIME.max))]
    pub time_s: f64,
    /// The blobs then, in the same order in every frame.
    #[serde(deserialize_with = "bounded::shared::<{ COUNTS.blobs }, _, _>")]
    #[schemars(length(max = COUNTS.blobs), extend("x-items-in-all" = COUNTS.blobs))]
    pub blobs: Shared<Vec<Blob>>,
}

/// Reads frames, or null; the blobs of all together are bounded.
fn frames<'de, D: Deserializer<'de>>(input: D) -> Result<Option<Vec<BlobFrame>>, D::Error> {
    let parts = |frame: &BlobFrame| frame.blobs.len();
    bounded::list_in_all_or_null::<{ COUNTS.frames }, _, _>(input, COUNTS.blobs, parts)
}

parts!(Gaussians { blobs });

impl Part for Blob {}

impl Default for Gaussians {
    fn default() -> Self {
        Self {
            id: None,
            enabled: true,
            albedo: None,
            phase: None,
            wind_response: 1.0,
            blobs: Shared::default(),
            frames: None,
            draw: Draw::Gaussian,
        }
    }
}

/// One Gaussian blob of fog.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Blob {
    /// Where it is densest [m].
    pub center: Vec3,
    /// Distance from the centre at which the extinction has fallen to 1/e [m].
    #[schemars(range(min = limits::RADIUS.min, max = limits::RADIUS.max))]
    pub radius: f64,
    /// Extinction at the centre [1/m].
    #[schemars(schema_with = "Spectrum::extinction")]
    pub extinction: Spectrum,
}

impl Default for Blob {
    fn default() -> Self {
        Self { center: Vec3::splat(0.0), radius: 1.0, extinction: Spectrum::Grey(0.4) }
    }
}

impl Blob {
    fn check(&self, check: &mut Checker, at: &dyn Fn(&str) -> String) {
        check.triple(self.center.0, limits::COORDINATE, || at("center"));
        check.number(self.radius, limits::RADIUS, || at("radius"));
        check.spectrum(self.extinction, limits::EXTINCTION, || at("extinction"));
    }
}

impl Toward for Blob {
    fn toward(&self, other: &Self, share: f64) -> Self {
        Self {
            center: self.center.toward(&other.center, share),
            radius: self.radius.toward(&other.radius, share),
            extinction: self.extinction.toward(&other.extinction, share),
        }
    }
}

impl Gaussians {
    /// The blobs at a time.
    pub fn at(&self, time_s: f64) -> Cow<'_, [Blob]> {
        let Some(frames) = &self.frames else { return Cow::Borrowed(&self.blobs) };
        let behind = frames.partition_point(|frame| frame.time_s <= time_s);
        let (Some(before), Some(after)) = (frames.get(behind.max(1) - 1), frames.get(behind))
        else {
            return Cow::Borrowed(frames.last().map_or(&[], |last| &last.blobs));
        };
        if behind == 0 {
            return Cow::Borrowed(&before.blobs);
        }
        let share = (time_s - before.time_s) / (after.time_s - before.time_s);
        let each = before.blobs.iter().zip(&after.blobs);
        each.map(|(a, b)| a.toward(b, share)).collect()
    }

    fn check_frames(&self, check: &mut Checker, at: &dyn Fn(&str) -> String) {
        let Some(frames) = &self.frames else { return };
        if !self.blobs.is_empty() {
            check.refuse(Code::Conflict, || at("frames"), "give blobs or frames, not both");
        }
        if frames.is_empty() {
            check.refuse(Code::WrongLength, || at("frames"), "there is at least one frame");
        }
        let count = frames.first().map_or(0, |frame| frame.blobs.len());
        for (i, frame) in frames.iter().enumerate() {
            let of = |name: &str| at(&format!("frames/{i}/{name}"));
            check.number(frame.time_s, limits::TIME, || of("time_s"));
            if i > 0 && frame.time_s <= frames[i - 1].time_s {
                check.refuse(Code::Conflict, || of("time_s"), "times rise from frame to frame");
            }
            if frame.blobs.len() != count {
                let detail =
                    format!("{} blobs here, {count} in the first frame", frame.blobs.len());
                check.refuse(Code::Conflict, || of("blobs"), detail);
            }
            for (j, blob) in frame.blobs.iter().enumerate() {
                blob.check(check, &|name| of(&format!("blobs/{j}/{name}")));
            }
        }
    }

    /// Every blob that it names.
    fn every(&self) -> impl Iterator<Item = &Blob> {
        let in_frames = self.frames.iter().flatten().flat_map(|frame| &frame.blobs);
        self.blobs.iter().chain(in_frames)
    }
}

impl TermKind for Gaussians {
    type Medium = Blobs;

    const SOURCE: &'static str = "Zhou, Hou, Gong, Snyder, Guo, Shum: Fogshop (Pacific Graphics 2007): the \
        optical depth of a Gaussian along a ray is a difference of error functions.";

    const TRIAL: &'static str = r#"[{"kind": "gaussians", "blobs": [
        {"center": [-1, 0.6, 0], "radius": 1.2, "extinction": 0.5},
        {"center": [1.5, 1, -2], "radius": 0.7, "extinction": 0.9},
        {"center": [0, 0.2, 3], "radius": 2, "extinction": 0.1}]}]"#;

    fn what(&self) -> &'static str {
        match self.draw {
            Draw::Gaussian => "gaussians",
            Draw::Slab => "gaussians as slabs",
        }
    }

    fn check(&self, check: &mut Checker, at: &dyn Fn(&str) -> String, _far_m: f64) {
        for (i, blob) in self.blobs.iter().enumerate() {
            blob.check(check, &|name| at(&format!("blobs/{i}/{name}")));
        }
        self.check_frames(check, at);
    }

    fn blobs(&self) -> usize {
        let in_frames = self.frames.iter().flatten().map(|frame| frame.blobs.len());
        self.blobs.len() + in_frames.sum::<usize>()
    }

    fn counted_at(&self) -> &'static str {
        if self.frames.is_some() { "frames" } else { "blobs" }
    }

    fn changes(&self) -> bool {
        self.frames.as_ref().is_some_and(|frames| frames.len() > 1)
    }

    fn is_grey(&self) -> bool {
        self.every().all(|blob| blob.extinction.is_grey())
    }

    fn merge(terms: &[&Self], channel: usize, moment: &Moment) -> Blobs {
        let mut all = Vec::new();
        for term in terms {
            let shift = moment.shift(term.wind_response);
            let blobs = term.at(moment.time_s);
            let own = |blob| {
                Gaussian::new(blob, channel).moved(shift).drawn(term.draw).thinned(moment.density)
            };
            let blobs = blobs.iter().map(own);
            all.extend(blobs.filter(|blob| blob.c > 0.0));
        }
        Blobs::new(all)
    }
}

/// How view rays see the blobs of a term, if it has any.
pub fn draw_of(term: &Term) -> Option<Draw> {
    match term {
        Term::Gaussians(term) => Some(term.draw),
        Term::Emitter(term) => Some(term.draw),
        _ => None,
    }
}

/// Radii from its middle on a ray at which a blob has ended there: exp(−4²) is 1e-7.
pub const ENDS: f64 = 4.0;

/// Optical depth that all blobs left out of an exact sum may have together: below the rounding of
/// its other terms.
const EXACT_LOSS: f64 = 1e-15;

/// The blobs of all terms, those that weigh nothing left out.
#[derive(Debug, Default)]
pub struct Blobs {
    all: Vec<Gaussian>,
    picture_tree: OnceLock<BlobTree>,
    exact_tree: OnceLock<BlobTree>,
}

impl Clone for Blobs {
    fn clone(&self) -> Self {
        Self::new(self.all.clone())
    }
}

impl Blobs {
    /// Some blobs.
    pub fn new(all: Vec<Gaussian>) -> Self {
        Self { all, ..Self::default() }
    }

    /// All of them.
    pub fn all(&self) -> &[Gaussian] {
        &self.all
    }

    /// The blobs that matter to any ray of a bundle, for pictures.
    fn picture_tree(&self) -> &BlobTree {
        let each = PICTURE_LOSS / 10.0 / self.all.len().max(1) as f64;
        self.picture_tree.get_or_init(|| BlobTree::new(&self.all, each))
    }

    fn exact_tree(&self) -> &BlobTree {
        let each = EXACT_LOSS / self.all.len().max(1) as f64;
        self.exact_tree.get_or_init(|| BlobTree::new(&self.all, each))
    }

    /// Places of the blobs that a ray meets, to rounding.
    pub fn on_ray(&self, ray: &Ray, length_m: f64) -> Vec<usize> {
        let Ray { origin, direction } = *ray;
        let bundle = Bundle { origin, axis: direction, radius: 0.0, tan: 0.0, length: length_m };
        let mut places = Vec::new();
        self.exact_tree().visit(&bundle, |place| places.push(place));
        places
    }

    /// T along a ray, to rounding, of the blobs that it meets.
    pub fn depth_nearby(&self, ray: &Ray, length_m: f64) -> f64 {
        let places = self.on_ray(ray, length_m);
        places.iter().map(|place| self.all[*place].depth(ray, length_m)).fold(0.0, |a, b| a + b)
    }

    /// The blobs that any way from beyond everything to a point between `from` and `to` meets, to rounding.
    fn in_strip(&self, beyond: &Beyond, ends: [DVec3; 2]) -> Vec<Gaussian> {
        let length =
            ends.map(|end| self.exact_tree().farthest(end)).into_iter().fold(0.0, f64::max);
        let mut near = Vec::new();
        if let Some(bundle) = Bundle::around(&ends.map(|end| (end, beyond.toward)), length) {
            self.exact_tree().visit(&bundle, |place| near.push(self.all[place]));
        }
        near
    }

    /// The blobs that any way from `apex` to a point between `from` and `to` meets, to rounding.
    fn in_triangle(&self, apex: DVec3, [from, to]: [DVec3; 2]) -> Vec<Gaussian> {
        let ray = |end| (apex, Ray::between(apex, end).0.direction);
        let length = apex.distance(from).max(apex.distance(to));
        let Some(bundle) = Bundle::around(&[ray(from), ray(to)], length) else {
            return self.all.clone();
        };
        let mut near = Vec::new();
        self.exact_tree().visit(&bundle, |place| near.push(self.all[place]));
        near
    }
}

impl Medium for Blobs {
    fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    fn beta(&self, x: DVec3) -> f64 {
        self.all.iter().map(|blob| blob.beta(x)).sum()
    }

    fn depth(&self, ray: &Ray, length_m: f64) -> f64 {
        self.all.iter().map(|blob| blob.seen_depth(ray, length_m)).sum()
    }

    fn along(&self, ray: &Ray, length_m: f64) -> Box<dyn Along> {
        Box::new(exact::OnRay::new(self, ray, length_m))
    }

    fn depth_beyond(&self, x: DVec3, beyond: &Beyond) -> f64 {
        let ray = Ray { origin: x, direction: beyond.toward };
        let places = self.on_ray(&ray, self.exact_tree().farthest(x));
        let depths = places.iter().map(|place| self.all[*place].depth(&ray, EVERYWHERE_M));
        depths.fold(0.0, |a, b| a + b)
    }

    fn ways(&self, origin: Origin, ends: [DVec3; 2]) -> Box<dyn Ways> {
        match origin {
            Origin::At(apex) => {
                Box::new(exact::Between { apex, blobs: self.in_triangle(apex, ends) })
            }
            Origin::Beyond(beyond) => {
                Box::new(exact::FromBeyond { beyond, blobs: self.in_strip(&beyond, ends) })
            }
        }
    }

    fn near(&self, level: Level, search: &Search) -> Box<dyn Near> {
        Box::new(BlobList::new(level, self, search))
    }

    fn reach(&self, from: DVec3) -> f64 {
        self.picture_tree().farthest(from)
    }

    fn is_rippled(&self) -> bool {
        // Slabs begin and end at once.
        self.all.iter().any(|blob| blob.is_slab)
    }

    fn heaviest(&self) -> f64 {
        self.all().iter().map(|blob| 2.0 * blob.half_depth()).fold(0.0, f64::max)
    }

    fn lumps(&self) -> usize {
        self.all.len()
    }

    fn places(&self, places: &mut Places) -> bool {
        /// Tails beyond so many radii shade nothing.
        const REACH: f64 = 2.5;
        /// What a straight line may miss of T: the second derivative of a Gaussian is no more than half its depth.
        const ERROR: f64 = 0.08;
        for blob in &self.all {
            let radius = 1.0 / blob.a;
            let step = radius * (ERROR / blob.half_depth().max(1e-12)).sqrt().clamp(0.25, 0.8);
            for axis in 0..3 {
                let middle = blob.center[axis];
                places.add(axis, middle - REACH * radius, middle + REACH * radius, step);
            }
        }
        true
    }

    fn outline(&self, apex: DVec3) -> Outline {
        self.all.iter().fold(Outline::default(), |mut outline, blob| {
            outline.add(apex, blob.center, 1.0 / blob.a, blob.half_depth());
            outline
        })
    }

    fn bytes(&self) -> usize {
        /// Bytes of a blob in both trees: two nodes and a place in each.
        const IN_TREES: usize = 136;
        self.all.len() * (size_of::<Gaussian>() + IN_TREES)
    }
}

impl Near for BlobList {
    fn add_depth(&self, job: &Job, rays: &Rays, parallel: bool, length: &Row, depth: &mut Row) {
        self.in_parts(job.progress, |list| {
            dispatch!(job.level, simd => if parallel {
                add_depth::<_, true>(simd, list, rays, length, depth);
            } else {
                add_depth::<_, false>(simd, list, rays, length, depth);
            });
        });
    }

    fn patched(&self) -> Box<dyn Patched> {
        Box::new(PatchBlobs::new(self))
    }
}
