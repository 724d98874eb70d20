//! Two airlight estimators on one scene, pixel by pixel: how far `a` is from `b`, and how long both
//! took.

use crate::airlight::{ComparedAirlight, Method};
use crate::frame::{Frame, Lap};
use crate::image::{self, ErrorImage};
use crate::progress::{Interrupted, Progress};
use crate::renderer::Renderer;
use crate::request::{Eye, Layer, Options, Quality, Tonemap, View, check_scene, check_size};
use crate::scene::limits::{self, COUNTS, Range};
use crate::scene::{Camera, CheckedScene, Checker, Code, Problem, Scene};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// Asks how far one airlight estimator is from another, on the layer `airlight` of a scene.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CompareRequest {
    /// What to look at; its own `airlight` does not matter here.
    pub scene: Scene,
    /// Pixels along a row.
    #[schemars(range(min = 1, max = COUNTS.picture_side))]
    pub width: u32,
    /// Rows of pixels.
    #[schemars(range(min = 1, max = COUNTS.picture_side))]
    pub height: u32,
    /// What is judged.
    #[serde(default)]
    pub a: Side,
    /// What it is judged by.
    #[serde(default = "Side::reference")]
    pub b: Side,
}

/// Asks the same of a scene that the server has.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EstimatorsRequest {
    /// Pixels along a row.
    #[schemars(range(min = 1, max = COUNTS.picture_side))]
    pub width: u32,
    /// Rows of pixels.
    #[schemars(range(min = 1, max = COUNTS.picture_side))]
    pub height: u32,
    /// From where; the scene's own camera where nothing is said.
    #[serde(default)]
    pub camera: Option<Camera>,
    /// When [s]; at the scene's own time where nothing is said.
    #[serde(default)]
    #[schemars(range(min = limits::TIME.min, max = limits::TIME.max))]
    pub time_s: Option<f64>,
    /// What is judged.
    #[serde(default)]
    pub a: Side,
    /// What it is judged by.
    #[serde(default = "Side::reference")]
    pub b: Side,
}

impl EstimatorsRequest {
    /// Checks everything.
    ///
    /// # Errors
    /// What is wrong, with pointers into this request.
    pub fn check(self, scene: &CheckedScene) -> Result<(CheckedScene, Pair), Vec<Problem>> {
        let Self { width, height, camera, time_s, a, b } = self;
        let mut check = Checker::default();
        let eye = Eye { camera, time_s };
        eye.check(&mut check);
        let pair = Pair::new(&mut check, scene, (width, height), [a, b]);
        let pair = check.finish(pair)?;
        Ok((eye.on(scene)?, pair))
    }
}

/// One side of a comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend(
    "if" = { "properties": { "airlight": { "const": "march" } } },
    "then" = { "required": ["steps"], "properties": { "steps": { "type": "integer" } } },
    "else" = { "properties": { "steps": { "type": "null" } } },
))]
pub struct Side {
    /// The estimator.
    pub airlight: ComparedAirlight,
    /// Steps along every ray: needed for `march`, refused for all others.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1, max = COUNTS.march_steps))]
    pub steps: Option<u32>,
}

impl Side {
    /// The integral itself.
    pub fn reference() -> Self {
        Self { airlight: ComparedAirlight::Reference, steps: None }
    }

    /// The estimator; `at` is this side's pointer.
    fn check(self, check: &mut Checker, scene: &Scene, at: &str) -> Method {
        let steps_at = || format!("{at}/steps");
        let Some(airlight) = self.airlight.of_a_scene() else {
            let range = Range { min: 1.0, max: COUNTS.march_steps as f64 };
            match self.steps {
                Some(steps) => check.number(f64::from(steps), range, steps_at),
                None => check.refuse(Code::Missing, steps_at, "march needs a number of steps"),
            }
            return Method::March(self.steps.unwrap_or(1));
        };
        if self.steps.is_some() {
            check.refuse(Code::Conflict, steps_at, "only march takes steps");
        }
        if let Some(detail) = scene.fog.refusal(airlight) {
            check.refuse(Code::Conflict, || format!("{at}/airlight"), detail);
        }
        airlight.into()
    }
}

impl Default for Side {
    fn default() -> Self {
        Self { airlight: ComparedAirlight::Auto, steps: None }
    }
}

/// A checked comparison without its scene.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    width: u32,
    height: u32,
    sides: [Side; 2],
    estimators: [Method; 2],
}

impl CompareRequest {
    /// Checks everything.
    ///
    /// # Errors
    /// What is wrong, with pointers into this request.
    pub fn check(self) -> Result<(CheckedScene, Pair), Vec<Problem>> {
        let Self { scene, width, height, a, b } = self;
        let mut check = Checker::default();
        let pair = Pair::new(&mut check, &scene, (width, height), [a, b]);
        Ok((check_scene(check, scene)?, pair))
    }
}

impl Pair {
    fn new(
        check: &mut Checker,
        scene: &Scene,
        (width, height): (u32, u32),
        sides: [Side; 2],
    ) -> Self {
        check_size(check, width, height, COUNTS.compare_pixels);
        let [a, b] = sides;
        let estimators = [a.check(check, scene, "/a"), b.check(check, scene, "/b")];
        Self { width, height, sides, estimators }
    }

    /// Pixels along a row, and rows of pixels.
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// Whether a side is the reference, which takes its time.
    pub fn is_slow(&self) -> bool {
        self.estimators.iter().any(is_reference)
    }

    /// Share of the first side in the work, roughly, for the progress of both.
    fn share_of_a(&self) -> f64 {
        /// The reference takes from tens to thousands of times as long as any other.
        const SLOWNESS: f64 = 50.0;
        let [a, b] = self.estimators.map(|side| if is_reference(&side) { SLOWNESS } else { 1.0 });
        a / (a + b)
    }

    fn view(&self, estimator: Method) -> View {
        View {
            width: self.width,
            height: self.height,
            quality: Quality::Full,
            layer: Layer::Airlight,
            samples: Some(1),
            exposure_ev: 0.0,
            tonemap: Tonemap::default(),
            for_screen: false,
            is_hasty: false,
            estimator: Some(estimator),
            options: Options::default(),
        }
    }
}

fn is_reference(estimator: &Method) -> bool {
    *estimator == Method::Reference
}

/// How far `a` is from `b`. The error of a pixel is (a − b) / max(b, 0.001 · mean b), where a and b
/// are luminances (Rec. 709: 0.2126 R + 0.7152 G + 0.0722 B) of the layer `airlight`, scene-linear,
/// one ray through each pixel's centre. Where b is black altogether, mean a stands for mean b.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Comparison {
    /// What is judged.
    pub a: Side,
    /// What it is judged by.
    pub b: Side,
    /// Mean of the signed errors: above 0, `a` is too bright.
    pub bias: f64,
    /// Median of the errors' sizes.
    pub median: f64,
    /// 95th percentile of the errors' sizes, between neighbours interpolated.
    pub p95: f64,
    /// The largest size of an error.
    pub max: f64,
    /// Mean FLIP difference of both pictures at 0 EV through AgX, in 8 bits, seen at 67 pixels a
    /// degree: 0 for the same, 0.97 for black and white.
    pub flip: f64,
    /// Mean luminance of b [W/(m² sr)].
    pub mean_b: f64,
    /// Time that `a` took [ms], without the surfaces, which both sides share.
    pub a_ms: f64,
    /// Time that `b` took [ms].
    pub b_ms: f64,
}

/// All that a comparison finds.
#[derive(Clone, Debug, PartialEq)]
pub struct Compared {
    /// The numbers.
    pub comparison: Comparison,
    /// Where the errors are.
    pub errors: ErrorImage,
    /// What each step took, in order.
    pub timings: Vec<Lap>,
    /// Where `a` was rendered.
    pub backend: &'static str,
}

/// Renders both sides and compares them.
///
/// # Errors
/// [`Interrupted`] when `progress` says so.
pub fn run(
    renderer: &Renderer,
    scene: &CheckedScene,
    pair: &Pair,
    progress: &Progress,
) -> Result<Compared, Interrupted> {
    let [view_a, view_b] = pair.estimators.map(|estimator| pair.view(estimator));
    let began = Instant::now();
    let middle = pair.share_of_a();
    progress.stretch(0.0, middle);
    let a = renderer.render(scene, &view_a, progress)?;
    let between = Instant::now();
    progress.stretch(middle, 1.0);
    let b = renderer.render(scene, &view_b, progress)?;
    let after = Instant::now();
    let errors = Errors::new(&luminances(&a), &luminances(&b));
    let flip = flip(&a, &b, &view_b, progress)?;
    let timings = [("a", between - began), ("b", after - between), ("compare", after.elapsed())];
    let timings = timings.map(|(pass, took)| Lap::new(pass, took)).to_vec();
    let sizes = errors.sizes();
    let comparison = Comparison {
        a: pair.sides[0],
        b: pair.sides[1],
        bias: mean(&errors.signed),
        median: quantile(&sizes, 0.5),
        p95: quantile(&sizes, 0.95),
        max: quantile(&sizes, 1.0),
        flip,
        mean_b: errors.mean_b,
        a_ms: milliseconds(&a),
        b_ms: milliseconds(&b),
    };
    Ok(Compared { comparison, errors: errors.image(&a), timings, backend: a.backend })
}

/// What the estimator took, not what both sides share.
fn milliseconds(frame: &Frame) -> f64 {
    let own = frame.timings.iter().filter(|lap| !["prepare", "surfaces"].contains(&lap.pass));
    own.map(|lap| lap.took.as_secs_f64() * 1e3).sum()
}

/// Finite ones: a lamp in the eye may be brighter than a float32 can say.
fn luminances(frame: &Frame) -> Vec<f64> {
    let luminance = |rgb: &[f32]| {
        let [r, g, b] = [0, 1, 2].map(|k| f64::from(rgb[k]));
        (0.2126 * r + 0.7152 * g + 0.0722 * b).min(f64::from(f32::MAX))
    };
    frame.pixels.chunks_exact(3).map(luminance).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

struct Errors {
    /// (a − b) / max(b, floor), pixel by pixel.
    signed: Vec<f64>,
    mean_b: f64,
}

impl Errors {
    fn new(a: &[f64], b: &[f64]) -> Self {
        const FLOOR: f64 = 1e-3;
        let mean_b = mean(b);
        let floor = FLOOR * if mean_b > 0.0 { mean_b } else { mean(a) };
        let error = |(a, b): (&f64, &f64)| if a == b { 0.0 } else { (a - b) / b.max(floor) };
        Self { signed: a.iter().zip(b).map(error).collect(), mean_b }
    }

    /// From the smallest to the largest.
    fn sizes(&self) -> Vec<f64> {
        let mut sizes: Vec<_> = self.signed.iter().map(|error| error.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        sizes
    }

    fn image(&self, like: &Frame) -> ErrorImage {
        let pixels = self.signed.iter().map(|error| error.abs().min(f64::from(f32::MAX)) as f32);
        ErrorImage { width: like.width, height: like.height, pixels: pixels.collect() }
    }
}

/// The value below which the share `q` of sorted values lies, interpolated between neighbours.
fn quantile(sorted: &[f64], q: f64) -> f64 {
    let place = q * (sorted.len() - 1) as f64;
    let (low, high) = (sorted[place.floor() as usize], sorted[place.ceil() as usize]);
    low + place.fract() * (high - low)
}

/// Mean FLIP difference of two frames as pictures (Andersson et al. 2020).
fn flip(a: &Frame, b: &Frame, view: &View, progress: &Progress) -> Result<f64, Interrupted> {
    let [test, reference] = [a, b].map(|frame| image::on_screen(frame, view));
    image::flip::mean(&reference, &test, b.width, progress)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_relative_to_b_but_not_where_it_is_next_to_black() {
        let errors = Errors::new(&[1.1, 0.0, 0.001], &[1.0, 2.0, 0.0]);
        let expected = [0.1, -1.0, 1.0];
        for (error, expected) in errors.signed.iter().zip(expected) {
            assert!((error - expected).abs() < 1e-12, "{error} instead of {expected}");
        }
        assert_eq!(errors.sizes()[2], 1.0);
    }

    #[test]
    fn beside_black_errors_stay_finite() {
        assert_eq!(Errors::new(&[0.0, 0.0], &[0.0, 0.0]).signed, [0.0, 0.0]);
        assert_eq!(Errors::new(&[0.0, 4.0], &[0.0, 0.0]).signed, [0.0, 2000.0]);
    }

    #[test]
    fn quantiles_lie_between_neighbours() {
        assert_eq!(quantile(&[7.0], 0.95), 7.0);
        assert_eq!(quantile(&[0.0, 1.0, 2.0, 3.0], 0.5), 1.5);
        assert_eq!(quantile(&[0.0, 1.0, 2.0, 3.0], 1.0), 3.0);
    }
}
