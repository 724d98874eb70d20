//! Fog that is the same everywhere: β(x) = β₀, T(a, b) = β₀ |a − b| (Sun 2005, eq. 3).

use super::{
    Along, Common, Lumps, Medium, Near, OnRays, PatchCone, Patched, Search, Smooth, TermKind, Ways,
};
use crate::geometry::Ray;
use crate::geometry::batch::{Rays, Row};
use crate::geometry::control::{Control, Each, PADDED};
use crate::json::tagged::tagged;
use crate::json::{Checker, Code, limits};
use crate::progress::Job;
use crate::num::{Lanes, Num};
use fearless_simd::{Level, Simd, dispatch};
use glam::{DVec3, Vec3, Vec4};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Fog that is the same everywhere. Give `extinction` or `visibility_m`, not both.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[schemars(extend("not" = {
    "required": ["extinction", "visibility_m"],
    "properties": { "extinction": { "type": "number" }, "visibility_m": { "type": "number" } },
}))]
pub struct Homogeneous {
    /// Name of this term, unique among the terms.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1, max = limits::COUNTS.id_chars))]
    pub id: Option<String>,
    /// False removes it from the fog.
    pub enabled: bool,
    /// Extinction β [1/m]; 0.02 when neither it nor the visibility is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = limits::EXTINCTION.min, max = limits::EXTINCTION.max))]
    #[schemars(extend("x-usual" = limits::USUAL_EXTINCTION))]
    pub extinction: Option<f64>,
    /// Meteorological visibility V [m]: extinction = −ln 0.05 / V.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = limits::VISIBILITY.min, max = limits::VISIBILITY.max))]
    #[schemars(extend("x-usual" = limits::USUAL_VISIBILITY))]
    #[schemars(extend("x-reciprocal-of" = ReciprocalOf::extinction()))]
    pub visibility_m: Option<f64>,
    /// How the extinction depends on height.
    pub vertical: Vertical,
}

impl Default for Homogeneous {
    fn default() -> Self {
        Self {
            id: None,
            enabled: true,
            extinction: None,
            visibility_m: None,
            vertical: Vertical::Uniform(Uniform {}),
        }
    }
}

impl Homogeneous {
    /// Extinction β [1/m] of this term.
    pub fn extinction_per_m(&self) -> f64 {
        let ReciprocalOf { product, default, .. } = ReciprocalOf::extinction();
        match (self.extinction, self.visibility_m) {
            (Some(extinction), _) => extinction,
            (None, Some(visibility_m)) => product / visibility_m,
            (None, None) => default,
        }
    }
}

/// Says of a number that it is another way to give a property beside it: the hint `x-reciprocal-of`
/// of the JSON schema. With it a client converts one into the other and need not know why they are
/// related.
#[derive(Clone, Copy, Debug, Serialize)]
struct ReciprocalOf {
    /// The property.
    property: &'static str,
    /// The number times that property.
    product: f64,
    /// What that property is when neither is given.
    default: f64,
}

impl ReciprocalOf {
    /// A black object at the meteorological visibility keeps 5 % of its contrast.
    fn extinction() -> Self {
        const CONTRAST_THRESHOLD: f64 = 0.05;
        Self { property: "extinction", product: -CONTRAST_THRESHOLD.ln(), default: 0.02 }
    }
}

tagged!(
    /// How an extinction depends on height.
    Vertical {
        /// Not at all.
        Uniform = "uniform",
    }
);

/// The same at every height.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Uniform {}

impl TermKind for Homogeneous {
    type Medium = Haze;

    const SOURCE: &'static str = "Beer–Lambert law; visibility after Koschmieder 1924.";

    const TRIAL: &'static str = r#"[{"kind": "homogeneous", "extinction": 0.05}]"#;

    fn what(&self) -> &'static str {
        "homogeneous fog"
    }

    fn common(&self) -> Common<'_> {
        Common { id: self.id.as_deref(), enabled: self.enabled }
    }

    fn check(&self, check: &mut Checker, at: &dyn Fn(&str) -> String) {
        if let Some(extinction) = self.extinction {
            check.number(extinction, limits::EXTINCTION, || at("extinction"));
        }
        if let Some(visibility_m) = self.visibility_m {
            check.number(visibility_m, limits::VISIBILITY, || at("visibility_m"));
        }
        if self.extinction.is_some() && self.visibility_m.is_some() {
            let detail = "give extinction or visibility_m, not both";
            check.refuse(Code::Conflict, || at("visibility_m"), detail);
        }
    }

    fn merge(terms: &[&Self]) -> Haze {
        // An empty f64 sum is −0, and what is divided by that is minus infinity.
        Haze { beta: terms.iter().map(|term| term.extinction_per_m()).fold(0.0, |a, b| a + b) }
    }
}

/// The sum of all homogeneous terms.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Haze {
    /// Extinction β₀ [1/m].
    beta: f64,
}

impl Haze {
    /// β₀ [1/m] if it is the same everywhere.
    pub fn uniform_beta(&self) -> Option<f64> {
        Some(self.beta)
    }
}

impl Medium for Haze {
    fn is_empty(&self) -> bool {
        self.beta == 0.0
    }

    fn beta(&self, _x: DVec3) -> f64 {
        self.beta
    }

    fn depth(&self, _ray: &Ray, length_m: f64) -> f64 {
        self.beta * length_m
    }

    fn along(&self, _ray: &Ray, length_m: f64) -> Box<dyn Along> {
        Box::new(HazeOnRay { haze: *self, length_m })
    }

    fn ways(&self, apex: DVec3, _ends: [DVec3; 2]) -> Box<dyn Ways> {
        Box::new(HazeFrom { haze: *self, apex })
    }

    fn near(&self, _level: Level, _search: &Search) -> Box<dyn Near> {
        Box::new(*self)
    }

    fn smooth(&self, _origin: DVec3) -> Option<Box<dyn Smooth>> {
        Some(Box::new(*self))
    }

    fn least(&self, length_m: f64) -> f64 {
        self.beta * length_m
    }

    fn rows(&self, _camera: DVec3) -> Option<Vec<Vec4>> {
        Some(vec![Vec4::new(self.beta as f32, 0.0, 0.0, 0.0)])
    }

    fn bytes(&self) -> usize {
        0
    }
}

/// Along one ray.
#[derive(Debug)]
struct HazeOnRay {
    haze: Haze,
    length_m: f64,
}

impl Along for HazeOnRay {
    fn terms(&self) -> usize {
        1
    }

    fn is_smooth(&self) -> bool {
        true
    }

    fn beta(&self, _t: f64) -> f64 {
        self.haze.beta
    }

    fn depth(&self, t: f64) -> f64 {
        self.haze.beta * t
    }

    fn span(&self) -> Option<(f64, f64)> {
        (self.length_m > 0.0).then_some((0.0, self.length_m))
    }
}

/// Between a point and others.
#[derive(Debug)]
struct HazeFrom {
    haze: Haze,
    apex: DVec3,
}

impl Ways for HazeFrom {
    fn terms(&self) -> usize {
        1
    }

    fn depth_to(&self, point: DVec3) -> f64 {
        self.haze.beta * self.apex.distance(point)
    }
}

impl Near for Haze {
    fn add_depth(&self, _job: &Job, _rays: &Rays, _parallel: bool, length: &Row, depth: &mut Row) {
        let beta = self.beta as f32;
        depth.iter_mut().zip(length).for_each(|(depth, length)| *depth += beta * length);
    }

    fn patched(&self) -> Box<dyn Patched> {
        Box::new(*self)
    }
}

impl Smooth for Haze {
    fn add_mean(&self, level: Level, _light: Vec3, _: &Control, _t: &[Each], mean: &mut [Each]) {
        dispatch!(level, simd => add_everywhere(simd, self.beta as f32, mean));
    }
}

impl Patched for Haze {
    fn terms(&self) -> usize {
        1
    }

    fn within(&self, _cone: &PatchCone, _lumps: &mut Lumps) -> Box<dyn Patched> {
        Box::new(*self)
    }

    fn haze(&self, _cone: &PatchCone, length: f32) -> f32 {
        self.beta as f32 * length
    }

    fn on_rays(&self, _: Level, _rays: &Control, _parallel: bool, _: f32) -> Box<dyn OnRays> {
        Box::new(*self)
    }
}

impl OnRays for Haze {
    fn is_smooth(&self) -> bool {
        true
    }

    fn add(&self, level: Level, t: &[Each], beta: &mut [Each], depth: &mut [Each]) {
        dispatch!(level, simd => add_fields(simd, self.beta as f32, t, beta, depth));
    }

    fn most(&self, from: f32, to: f32) -> f32 {
        self.beta as f32 * (to - from)
    }

    fn span(&self) -> Option<(f32, f32)> {
        Some((0.0, f32::INFINITY))
    }

    fn hides_from(&self, from: f32, depth: f32) -> f32 {
        from + depth / self.beta as f32
    }
}

/// Adds β and T at ray parameters `t`.
#[inline(always)]
fn add_fields<S: Simd>(simd: S, own: f32, t: &[Each], beta: &mut [Each], depth: &mut [Each]) {
    add_everywhere(simd, own, beta);
    let own = Lanes::splat(simd, own);
    for (t, depth) in t.iter().zip(depth) {
        for at in (0..PADDED).step_by(Lanes::<S>::COUNT) {
            let before = Lanes::load(simd, &depth[at..]);
            own.mul_add(Lanes::load(simd, &t[at..]), before).store(&mut depth[at..]);
        }
    }
}

/// Adds the same to all numbers of some rows.
#[inline(always)]
fn add_everywhere<S: Simd>(simd: S, own: f32, rows: &mut [Each]) {
    let own = Lanes::splat(simd, own);
    for row in rows {
        for at in (0..PADDED).step_by(Lanes::<S>::COUNT) {
            (own + Lanes::load(simd, &row[at..])).store(&mut row[at..]);
        }
    }
}
