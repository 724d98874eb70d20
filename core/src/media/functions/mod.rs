//! Families of functions (Biri and Michelin 2002, eq. 7): β(x) = scale · Σ γᵢ(x), each of which has a closed form
//! along a ray (eq. 8). A member alone may be below 0; the field as a whole must not ([`sign`](super::sign)).

mod bernstein;
mod cosine;
mod equipotential;
mod horner;
mod member;
mod monomial;
mod polynomial;

pub use cosine::{Cosine, CosineMorph, CosineParameters, WaveVector};
pub use equipotential::{
    Equipotential, EquipotentialMorph, EquipotentialParameters, LineObject, Object, PointObject,
    SphereObject,
};
pub use monomial::{Monomial, Monomials};
pub use polynomial::{Periods, Polynomial, PolynomialMorph, PolynomialParameters};

use super::closed::{Closed, hull};
use super::{Moment, TermKind, Words};
use crate::json::document::Part;
use crate::json::limits::{self, COUNTS};
use crate::json::tagged::tagged;
use crate::json::{Albedo, Checker, Code, Spectrum, bounded};
use crate::num::Num;
use crate::phase::Phase;
use crate::vector::V3;
use cosine::Wave;
use equipotential::Potential;
use glam::DVec3;
use polynomial::Periodic;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A sum of functions that are known in closed form: waves, polynomials, and fog around objects. Where some of them are
/// below 0 others must make up for it: no fog has an extinction below 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Functions {
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
    /// What the sum of the members is multiplied by.
    #[schemars(schema_with = "Spectrum::extinction")]
    pub scale: Spectrum,
    /// What is summed up.
    #[serde(deserialize_with = "bounded::list::<{ COUNTS.members }, _, _>")]
    #[schemars(length(max = COUNTS.members))]
    pub members: Vec<Member>,
}

tagged!(
    /// A function of a sum.
    Member {
        /// A wave.
        Cosine = "cosine",
        /// A polynomial on a period of space.
        Polynomial = "polynomial",
        /// Fog around an object.
        Equipotential = "equipotential",
    }
);

impl Part for Functions {}

impl Default for Functions {
    fn default() -> Self {
        let constant = Cosine { wave_vector: WaveVector([0.0; 3]), ..Cosine::default() };
        Self {
            id: None,
            enabled: true,
            albedo: None,
            phase: None,
            wind_response: 1.0,
            scale: Spectrum::Grey(1.0),
            members: vec![Member::Cosine(constant), Member::Cosine(Cosine::default())],
        }
    }
}

impl Member {
    fn check(&self, check: &mut Checker, at: &dyn Fn(&str) -> String, far_m: f64) {
        let to = |name: &str| at(&format!("morph/to/{name}"));
        if let Some(period_s) = self.period_s() {
            check.number(period_s, limits::PERIOD, || at("morph/period_s"));
        }
        match self {
            Self::Cosine(own) => {
                own.own().check(check, at);
                let Some(morph) = &own.morph else { return };
                morph.to.check(check, &to);
            }
            Self::Polynomial(own) => {
                own.own().check(check, at, far_m);
                let Some(morph) = &own.morph else { return };
                morph.to.check(check, &to, far_m);
                let axes = [own.period_m, morph.to.period_m].map(Periods::axes);
                if axes[0] != axes[1] {
                    let detail = "depends on the same axes as what it comes from";
                    check.refuse(Code::Conflict, || to("period_m"), detail);
                }
                if morph.to.repeat != own.repeat {
                    let detail = "repeats where what it comes from does";
                    check.refuse(Code::Conflict, || to("repeat"), detail);
                }
            }
            Self::Equipotential(own) => {
                own.own().check(check, at);
                let Some(morph) = &own.morph else { return };
                morph.to.check(check, &to);
                let kinds = [&own.object, &morph.to.object].map(std::mem::discriminant);
                if kinds[0] != kinds[1] {
                    let detail = "is of the same kind as what it comes from";
                    check.refuse(Code::Conflict, || to("object/kind"), detail);
                }
            }
        }
    }

    /// After which time it is what it was, if it morphs [s].
    pub fn period_s(&self) -> Option<f64> {
        match self {
            Self::Cosine(own) => own.morph.as_ref().map(|morph| morph.period_s),
            Self::Polynomial(own) => own.morph.as_ref().map(|morph| morph.period_s),
            Self::Equipotential(own) => own.morph.as_ref().map(|morph| morph.period_s),
        }
    }

    /// Whether it does.
    pub fn morphs(&self) -> bool {
        self.period_s().is_some()
    }
}

impl Member {
    /// Terms that a ray of that length sums up: those of a polynomial in every period.
    fn cost(&self, length_m: f64) -> usize {
        /// A monomial on the nodes of a period takes as long as so many blobs, which rays of a picture share.
        const BLOBS: usize = 8;
        let Self::Polynomial(own) = self else { return 1 };
        let periods = own.period_m.0.iter().flatten().map(|period| length_m / period);
        let passed = if own.repeat { periods.sum::<f64>() as usize } else { 0 };
        BLOBS * own.monomials.0.len() * (1 + passed.min(COUNTS.periods))
    }

    /// A bound that it never falls below, at any time [1/m].
    pub fn least(&self) -> f64 {
        match self {
            Self::Cosine(own) => {
                let least = |wave: &CosineParameters| Wave::new(wave, 1.0).bounds()[0];
                let (from, to) = (own.own(), own.morph.as_ref().map(|morph| &morph.to));
                let Some(to) = to else { return least(&from) };
                // A wave has its amplitude's opposite somewhere; a constant is what it is.
                let constant = [&from, to].iter().all(|wave| wave.wave_vector.0 == [0.0; 3]);
                if constant && from.phase_rad == to.phase_rad {
                    least(&from).min(least(to))
                } else {
                    -from.amplitude.abs().max(to.amplitude.abs())
                }
            }
            // What lies between two functions is nowhere below the lower of them.
            Self::Polynomial(own) => {
                let least = |own: &PolynomialParameters| Periodic::new(own, 1.0).bounds()[0];
                let to = own.morph.as_ref().map_or(f64::INFINITY, |morph| least(&morph.to));
                least(&own.own()).min(to)
            }
            Self::Equipotential(own) => {
                let from = own.own();
                let Some(to) = own.morph.as_ref().map(|morph| &morph.to) else {
                    return Potential::new(&from, 1.0).bounds()[0].min(0.0);
                };
                from.strength.min(to.strength).min(0.0) / from.c.min(to.c)
            }
        }
    }

    /// The length over which it changes [m], and a place where it may be least.
    pub fn scale(&self) -> (f64, DVec3) {
        match self {
            Self::Cosine(own) => {
                let k = DVec3::from(own.wave_vector.0).length();
                (if k > 0.0 { std::f64::consts::TAU / k } else { 1.0 }, DVec3::ZERO)
            }
            Self::Polynomial(own) => {
                let periods = own.period_m.0.iter().flatten();
                (periods.fold(0.0, |a: f64, b| a.max(*b)).max(1e-3), DVec3::ZERO)
            }
            Self::Equipotential(own) => {
                let own = Potential::new(&own.own(), 1.0);
                (own.width(), own.center)
            }
        }
    }
}

impl TermKind for Functions {
    type Medium = Families;

    const SOURCE: &'static str = "Biri, Michelin, Arquès: Real-Time Animation of Realistic Fog (Eurographics Workshop \
        on Rendering 2002): cosines, periodic polynomials and equipotentials, each integrated along the ray.";

    const TRIAL: &'static str = r#"[{"kind": "functions", "scale": 0.2, "members": [
        {"kind": "cosine", "amplitude": 0.4, "wave_vector": [0, 0, 0]},
        {"kind": "cosine", "amplitude": 0.3, "wave_vector": [0.6, 2, 0.3], "phase_rad": 0.4},
        {"kind": "polynomial", "period_m": [3, null, 4], "monomials": [
            {"powers": [1, 0, 1], "coefficient": 1}, {"powers": [2, 0, 2], "coefficient": -1}]},
        {"kind": "polynomial", "period_m": [2, 2, 3], "repeat": false, "monomials": [
            {"powers": [0, 1, 0], "coefficient": 0.8}]},
        {"kind": "equipotential", "object": {"kind": "point", "position": [-1, 0.6, 0]}},
        {"kind": "equipotential", "strength": 0.7, "d": 3,
         "object": {"kind": "line", "position": [0, 0.3, -2], "direction": [1, 0, 0.2]}},
        {"kind": "equipotential", "strength": 0.5, "d": 4,
         "object": {"kind": "sphere", "center": [1.5, 1, -1], "radius": 0.5}}]}]"#;

    fn what(&self) -> &'static str {
        "functions"
    }

    fn check(&self, check: &mut Checker, at: &dyn Fn(&str) -> String, far_m: f64) {
        check.spectrum(self.scale, limits::EXTINCTION, || at("scale"));
        check.count(self.members.len(), COUNTS.members, "members", || at("members"));
        for (i, member) in self.members.iter().enumerate().take(COUNTS.members) {
            member.check(check, &|name| at(&format!("members/{i}/{name}")), far_m);
        }
    }

    fn cost(&self, length_m: f64) -> usize {
        self.members.iter().map(|member| member.cost(length_m)).sum()
    }

    fn changes(&self) -> bool {
        self.members.iter().any(Member::morphs)
    }

    fn longest_m(&self) -> f64 {
        let of_member = |member: &Member| match member {
            Member::Polynomial(own) => {
                let to = own.morph.as_ref().map_or(f64::INFINITY, |morph| morph.to.longest_m());
                own.own().longest_m().min(to)
            }
            Member::Cosine(_) | Member::Equipotential(_) => f64::INFINITY,
        };
        self.members.iter().map(of_member).fold(f64::INFINITY, f64::min)
    }

    fn is_grey(&self) -> bool {
        self.scale.is_grey()
    }

    fn merge(terms: &[&Self], channel: usize, moment: &Moment) -> Families {
        let mut families = Families::default();
        for term in terms {
            families.add(term, channel, moment);
        }
        families
    }
}

/// The sum of the members of all terms, seen from an origin.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Families {
    waves: Vec<Wave>,
    polynomials: Vec<Periodic>,
    potentials: Vec<Potential>,
    /// A bound that the sum never falls below, and one that it never exceeds [1/m].
    bounds: [f64; 2],
}

impl Families {
    /// Adds a term at a moment.
    fn add(&mut self, term: &Functions, channel: usize, moment: &Moment) {
        let scale = term.scale.channels()[channel] * moment.density;
        let from = -moment.shift(term.wind_response);
        for member in term.members.iter().filter(|_| scale > 0.0) {
            let [least, most] = match member {
                Member::Cosine(own) => {
                    let wave = Wave::new(&own.at(moment.time_s), scale).seen_from(from);
                    self.waves.push(wave);
                    wave.bounds()
                }
                Member::Polynomial(own) => {
                    let own = Periodic::new(&own.at(moment.time_s), scale).seen_from(from);
                    let bounds = own.bounds();
                    self.polynomials.push(own);
                    bounds
                }
                Member::Equipotential(own) => {
                    let own = Potential::new(&own.at(moment.time_s), scale).seen_from(from);
                    self.potentials.push(own);
                    own.bounds()
                }
            };
            self.bounds = [self.bounds[0] + least, self.bounds[1] + most];
        }
    }
}

impl Closed for Families {
    fn is_nothing(&self) -> bool {
        self.count() == 0
    }

    fn seen_from(&self, origin: DVec3) -> Self {
        Self {
            waves: self.waves.iter().map(|wave| wave.seen_from(origin)).collect(),
            polynomials: self.polynomials.iter().map(|own| own.seen_from(origin)).collect(),
            potentials: self.potentials.iter().map(|own| own.seen_from(origin)).collect(),
            bounds: self.bounds,
        }
    }

    fn count(&self) -> usize {
        let monomials = self.polynomials.iter().map(Periodic::count).sum::<usize>();
        self.waves.len() + self.potentials.len() + monomials
    }

    fn cost(&self, way: DVec3) -> usize {
        let periods = self.polynomials.iter().map(|own| own.count() * own.passed(way));
        self.waves.len() + self.potentials.len() + periods.sum::<usize>()
    }

    #[inline(always)]
    fn at<N: Num>(&self, x: V3<N>) -> N {
        let mut sum = x.x.lit(0.0);
        for wave in &self.waves {
            sum += wave.at(x);
        }
        for polynomial in &self.polynomials {
            sum += polynomial.at(x);
        }
        for potential in &self.potentials {
            sum += potential.at(x);
        }
        sum
    }

    #[inline(always)]
    fn mean<N: Num>(&self, a: V3<N>, b: V3<N>) -> N {
        let mut sum = a.x.lit(0.0);
        for wave in &self.waves {
            sum += wave.mean(a, b);
        }
        for polynomial in &self.polynomials {
            sum += polynomial.mean(a, b);
        }
        for potential in &self.potentials {
            sum += potential.mean(a, b);
        }
        sum
    }

    fn least_beta(&self) -> f64 {
        self.bounds[0]
    }

    fn most_beta(&self) -> f64 {
        self.bounds[1]
    }

    fn uniform(&self) -> Option<f64> {
        self.is_nothing().then_some(0.0)
    }

    fn jumps(&self, start: DVec3, direction: DVec3, edge: &mut dyn FnMut(f64)) {
        self.polynomials.iter().for_each(|own| own.jumps(start, direction, edge));
    }

    fn borders(&self, direction: DVec3, length_m: f64, edge: &mut dyn FnMut(f64)) {
        self.polynomials.iter().for_each(|own| own.borders(direction, length_m, edge));
    }

    fn extent(&self, direction: DVec3, length_m: f64) -> Option<(f64, f64)> {
        if !self.waves.is_empty() || !self.potentials.is_empty() {
            return Some((0.0, length_m));
        }
        hull(self.polynomials.iter().filter_map(|own| own.extent(direction, length_m)))
    }

    fn is_rippled(&self) -> bool {
        true
    }

    fn ripple_m(&self, direction: DVec3, from: f64, to: f64) -> f64 {
        /// Widths from its middle up to which a peak is one.
        const REACH: f64 = 6.0;
        let waves = self.waves.iter().map(|wave| 1.0 / wave.k.dot(direction).abs());
        let periods = self.polynomials.iter().map(|own| own.shortest_m(direction));
        let peaks = self.potentials.iter().filter_map(|own| {
            let (at, width) = own.peak(direction);
            let reach = REACH * width;
            (at + reach > from && at - reach < to).then_some(width)
        });
        // Panels of five such lengths: three quarters of a wave, to 1e-9 by their fifteen nodes.
        waves.chain(periods).map(|length| 0.15 * length).chain(peaks).fold(f64::INFINITY, f64::min)
    }

    fn words(&self, numbers: &mut Vec<f32>) -> Vec<Words> {
        let waves = self.waves.iter().map(Wave::words);
        let polynomials = self.polynomials.iter().map(|one| one.words(numbers));
        waves.chain(polynomials).chain(self.potentials.iter().map(Potential::words)).collect()
    }

    fn size(&self) -> usize {
        let monomials = self.polynomials.iter().map(Periodic::size).sum::<usize>();
        size_of_val(self.waves.as_slice())
            + size_of_val(self.potentials.as_slice())
            + size_of_val(self.polynomials.as_slice())
            + monomials
    }
}
