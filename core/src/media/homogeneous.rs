//! Fog that is the same everywhere, β(x) = β₀ and T(a, b) = β₀ |a − b| (Sun 2005, eq. 3), or changes
//! with height alone: β(x) = β₀ share(y), T(a, b) = |a − b| times the mean of that between both heights
//! ([`Profile`]).

use super::closed::{Closed, crossing, hull};
use super::places::Places;
use super::vertical::{Profile, Uniform, Vertical};
use super::{Moment, TermKind, Words};
use crate::geometry::Beyond;
use crate::json::document::Part;
use crate::json::{Albedo, Checker, Code, Spectrum, limits};
use crate::num::Num;
use crate::phase::Phase;
use crate::vector::V3;
use glam::DVec3;
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
    /// Share of the wind that moves this term, from 0 to 1.
    #[schemars(range(min = limits::FRACTION.min, max = limits::FRACTION.max))]
    pub wind_response: f64,
    /// How the extinction depends on height.
    pub vertical: Vertical,
}

impl Part for Homogeneous {}

impl Default for Homogeneous {
    fn default() -> Self {
        Self {
            id: None,
            enabled: true,
            extinction: None,
            visibility_m: None,
            albedo: None,
            phase: None,
            wind_response: 1.0,
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

    fn check(&self, check: &mut Checker, at: &dyn Fn(&str) -> String, _far_m: f64) {
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

    fn merge(terms: &[&Self], channel: usize, moment: &Moment) -> Haze {
        let mut haze = Haze::default();
        for term in terms {
            let beta = term.extinction_per_m().channels()[channel] * moment.density;
            if beta > 0.0 {
                let shift = moment.shift(term.wind_response);
                let profile = term.vertical.profile().seen_from(-shift.y);
                haze.add(Layer { beta, profile });
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

    /// The largest β [1/m].
    fn most(&self) -> f64 {
        self.uniform + self.layers.iter().map(|layer| layer.beta).sum::<f64>()
    }
}

impl Closed for Haze {
    fn places(&self, places: &mut Places) -> bool {
        self.layers.iter().for_each(|layer| places.add_profile(layer.profile, layer.beta));
        true
    }

    fn is_nothing(&self) -> bool {
        self.most() == 0.0
    }

    fn seen_from(&self, origin: DVec3) -> Self {
        let layer = |layer: &Layer| Layer { profile: layer.profile.seen_from(origin.y), ..*layer };
        Self { uniform: self.uniform, layers: self.layers.iter().map(layer).collect() }
    }

    fn count(&self) -> usize {
        1 + self.layers.len()
    }

    #[inline(always)]
    fn at<N: Num>(&self, x: V3<N>) -> N {
        let mut sum = x.y.lit(self.uniform);
        for layer in &self.layers {
            sum = layer.profile.at(x.y).mul_add(x.y.lit(layer.beta), sum);
        }
        sum
    }

    #[inline(always)]
    fn mean<N: Num>(&self, a: V3<N>, b: V3<N>) -> N {
        let mut sum = a.y.lit(self.uniform);
        for layer in &self.layers {
            sum = layer.profile.mean(a.y, b.y).mul_add(a.y.lit(layer.beta), sum);
        }
        sum
    }

    #[inline(always)]
    fn beyond<N: Num>(&self, x: V3<N>, &Beyond { toward, path_m }: &Beyond) -> N {
        let mut sum = x.y.lit(self.uniform * path_m);
        for layer in &self.layers {
            sum = layer.profile.beyond(x.y, toward.y, path_m).mul_add(x.y.lit(layer.beta), sum);
        }
        sum
    }

    fn least_beta(&self) -> f64 {
        self.uniform
    }

    fn most_beta(&self) -> f64 {
        self.most()
    }

    fn uniform(&self) -> Option<f64> {
        self.layers.is_empty().then_some(self.uniform)
    }

    fn jumps(&self, start: DVec3, direction: DVec3, edge: &mut dyn FnMut(f64)) {
        let heights = self.layers.iter().flat_map(|layer| layer.profile.edges());
        heights.for_each(|height| edge(crossing(height - start.y, direction.y)));
    }

    fn extent(&self, direction: DVec3, length_m: f64) -> Option<(f64, f64)> {
        if self.uniform > 0.0 {
            return Some((0.0, length_m));
        }
        let span = |layer: &Layer| layer.profile.span(direction.y, length_m);
        hull(self.layers.iter().filter_map(span))
    }

    fn words(&self, _numbers: &mut Vec<f32>) -> Vec<Words> {
        let layers = self.layers.iter().map(|layer| vec![layer.profile.row(layer.beta)]);
        [vec![Profile::Uniform.row(self.uniform)]].into_iter().chain(layers).collect()
    }

    fn size(&self) -> usize {
        size_of_val(self.layers.as_slice())
    }
}
