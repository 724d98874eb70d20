//! Fog that is the same everywhere, β(x) = β₀ and T(a, b) = β₀ |a − b| (Sun 2005, eq. 3), or changes
//! with height alone: β(x) = β₀ share(y), T(a, b) = |a − b| times the mean of that between both heights
//! ([`Profile`]).

mod lanes;

use super::vertical::{Profile, Uniform, Vertical};
use super::{Along, Common, Medium, Near, Search, Smooth, TermKind, Ways};
use crate::geometry::Ray;
use crate::json::{Albedo, Checker, Code, Spectrum, limits};
use crate::num::Num;
use crate::phase::Phase;
use fearless_simd::Level;
use glam::{DVec3, Vec4};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Fog that is the same everywhere, or depends on height alone. Give `extinction` or `visibility_m`, not both.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[schemars(extend("not" = {
    "required": ["extinction", "visibility_m"],
    "properties": {
        "extinction": { "type": ["number", "array"] },
        "visibility_m": { "type": "number" },
    },
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
    #[schemars(schema_with = "Spectrum::optional_extinction")]
    pub extinction: Option<Spectrum>,
    /// Meteorological visibility V [m]: extinction = −ln 0.05 / V.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = limits::VISIBILITY.min, max = limits::VISIBILITY.max))]
    #[schemars(extend("x-usual" = limits::USUAL_VISIBILITY))]
    #[schemars(extend("x-reciprocal-of" = ReciprocalOf::extinction()))]
    pub visibility_m: Option<f64>,
    /// Share of the extinguished light that this term scatters; the fog's own where nothing is said.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub albedo: Option<Albedo>,
    /// Into which directions this term scatters; as the fog's own where nothing is said.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phase: Option<Phase>,
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
            albedo: None,
            phase: None,
            vertical: Vertical::Uniform(Uniform {}),
        }
    }
}

impl Homogeneous {
    /// Extinction β [1/m] of this term.
    pub fn extinction_per_m(&self) -> Spectrum {
        let ReciprocalOf { product, default, .. } = ReciprocalOf::extinction();
        match (self.extinction, self.visibility_m) {
            (Some(extinction), _) => extinction,
            (None, Some(visibility_m)) => Spectrum::Grey(product / visibility_m),
            (None, None) => Spectrum::Grey(default),
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

impl TermKind for Homogeneous {
    type Medium = Haze;

    const SOURCE: &'static str = "Beer–Lambert law; visibility after Koschmieder 1924. A slab and an \
        exponential are the mean of β between two heights times the length, whatever the slope.";

    const TRIAL: &'static str = r#"[{"kind": "homogeneous", "extinction": 0.02},
        {"kind": "homogeneous", "extinction": 0.1,
         "vertical": {"kind": "slab", "min_m": 0, "max_m": 1.2}},
        {"kind": "homogeneous", "extinction": 0.05,
         "vertical": {"kind": "exponential", "base_m": 0.7, "falloff_per_m": 0.8}}]"#;

    fn what(&self) -> &'static str {
        match self.vertical {
            Vertical::Uniform(_) => "homogeneous fog",
            Vertical::Slab(_) | Vertical::Exponential(_) => "fog that changes with height",
        }
    }

    fn common(&self) -> Common<'_> {
        Common {
            id: self.id.as_deref(),
            enabled: self.enabled,
            albedo: self.albedo,
            phase: self.phase.as_ref(),
        }
    }

    fn check(&self, check: &mut Checker, at: &dyn Fn(&str) -> String) {
        if let Some(extinction) = self.extinction {
            check.spectrum(extinction, limits::EXTINCTION, || at("extinction"));
        }
        if let Some(visibility_m) = self.visibility_m {
            check.number(visibility_m, limits::VISIBILITY, || at("visibility_m"));
        }
        if self.extinction.is_some() && self.visibility_m.is_some() {
            let detail = "give extinction or visibility_m, not both";
            check.refuse(Code::Conflict, || at("visibility_m"), detail);
        }
        self.vertical.check(check, |name| at(&format!("vertical/{name}")));
    }

    fn is_grey(&self) -> bool {
        self.extinction_per_m().is_grey()
    }

    fn merge(terms: &[&Self], channel: usize) -> Haze {
        let mut haze = Haze::default();
        for term in terms {
            let beta = term.extinction_per_m().channels()[channel];
            if beta > 0.0 {
                haze.add(Layer { beta, profile: term.vertical.profile() });
            }
        }
        haze
    }
}

/// A term: an extinction and how it depends on height.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Layer {
    /// Where its share is 1 [1/m].
    beta: f64,
    profile: Profile,
}

/// The sum of all homogeneous terms, heights counted from the world's or from where rays start.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Haze {
    /// What is the same everywhere [1/m].
    uniform: f64,
    /// What is not.
    layers: Vec<Layer>,
}

impl Haze {
    fn add(&mut self, layer: Layer) {
        if layer.profile == Profile::Uniform {
            self.uniform += layer.beta;
        } else {
            self.layers.push(layer);
        }
    }

    /// β₀ [1/m] if it is the same everywhere.
    pub fn uniform_beta(&self) -> Option<f64> {
        self.layers.is_empty().then_some(self.uniform)
    }

    /// The same, heights counted from another one.
    fn seen_from(&self, height: f64) -> Self {
        let layer = |layer: &Layer| Layer { profile: layer.profile.seen_from(height), ..*layer };
        Self { uniform: self.uniform, layers: self.layers.iter().map(layer).collect() }
    }

    /// The largest β [1/m].
    fn most(&self) -> f64 {
        self.uniform + self.layers.iter().map(|layer| layer.beta).sum::<f64>()
    }

    /// β at a height [1/m].
    #[inline(always)]
    fn at<N: Num>(&self, y: N) -> N {
        let mut sum = y.lit(self.uniform);
        for layer in &self.layers {
            sum = layer.profile.at(y).mul_add(y.lit(layer.beta), sum);
        }
        sum
    }

    /// The mean of β between two heights [1/m].
    #[inline(always)]
    fn mean<N: Num>(&self, a: N, b: N) -> N {
        let mut sum = a.lit(self.uniform);
        for layer in &self.layers {
            sum = layer.profile.mean(a, b).mul_add(a.lit(layer.beta), sum);
        }
        sum
    }

    /// Heights at which it jumps or kinks.
    fn edges(&self) -> impl Iterator<Item = f64> {
        self.layers.iter().flat_map(|layer| layer.profile.edges())
    }
}

impl Medium for Haze {
    fn is_empty(&self) -> bool {
        self.most() == 0.0
    }

    fn beta(&self, x: DVec3) -> f64 {
        self.at(x.y)
    }

    fn depth(&self, ray: &Ray, length_m: f64) -> f64 {
        length_m * self.seen_from(ray.origin.y).mean(0.0, length_m * ray.direction.y)
    }

    fn along(&self, ray: &Ray, length_m: f64) -> Box<dyn Along> {
        let haze = self.seen_from(ray.origin.y);
        Box::new(HazeOnRay { haze, climb: ray.direction.y, length_m })
    }

    fn ways(&self, apex: DVec3, _ends: [DVec3; 2]) -> Box<dyn Ways> {
        Box::new(HazeFrom { haze: self.seen_from(apex.y), apex })
    }

    fn near(&self, _level: Level, search: &Search) -> Box<dyn Near> {
        Box::new(self.seen_from(search.bundle.origin.y))
    }

    fn smooth(&self, origin: DVec3) -> Option<Box<dyn Smooth>> {
        Some(Box::new(self.seen_from(origin.y)))
    }

    fn least(&self, length_m: f64) -> f64 {
        self.uniform * length_m
    }

    fn rows(&self, camera: DVec3) -> Option<Vec<Vec4>> {
        let haze = self.seen_from(camera.y);
        let layers = haze.layers.iter().map(|layer| layer.profile.row(layer.beta));
        Some([Profile::Uniform.row(haze.uniform)].into_iter().chain(layers).collect())
    }

    fn bytes(&self) -> usize {
        size_of_val(self.layers.as_slice())
    }
}

/// Along one ray; heights from where it starts.
#[derive(Debug)]
struct HazeOnRay {
    haze: Haze,
    /// Height gained per metre.
    climb: f64,
    length_m: f64,
}

impl HazeOnRay {
    /// Ray parameters between which a layer lies [m].
    fn span_of(&self, profile: Profile) -> Option<(f64, f64)> {
        let Profile::Slab { min, max } = profile else { return Some((0.0, self.length_m)) };
        if self.climb == 0.0 {
            return (min <= 0.0 && 0.0 <= max).then_some((0.0, self.length_m));
        }
        let (a, b) = (min / self.climb, max / self.climb);
        let (from, to) = (a.min(b).max(0.0), a.max(b).min(self.length_m));
        (from < to).then_some((from, to))
    }
}

impl Along for HazeOnRay {
    fn terms(&self) -> usize {
        1 + self.haze.layers.len()
    }

    fn is_smooth(&self) -> bool {
        true
    }

    fn beta(&self, t: f64) -> f64 {
        self.haze.at(t * self.climb)
    }

    fn depth(&self, t: f64) -> f64 {
        t * self.haze.mean(0.0, t * self.climb)
    }

    fn span(&self) -> Option<(f64, f64)> {
        if self.length_m <= 0.0 {
            return None;
        }
        if self.haze.uniform > 0.0 {
            return Some((0.0, self.length_m));
        }
        let spans = self.haze.layers.iter().filter_map(|layer| self.span_of(layer.profile));
        spans.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    fn edges(&self) -> Vec<f64> {
        self.haze.edges().map(|height| height / self.climb).filter(|t| t.is_finite()).collect()
    }
}

/// Between a point and others; heights from that point.
#[derive(Debug)]
struct HazeFrom {
    haze: Haze,
    apex: DVec3,
}

impl Ways for HazeFrom {
    fn terms(&self) -> usize {
        1 + self.haze.layers.len()
    }

    fn depth_to(&self, point: DVec3) -> f64 {
        self.apex.distance(point) * self.haze.mean(0.0, point.y - self.apex.y)
    }
}
