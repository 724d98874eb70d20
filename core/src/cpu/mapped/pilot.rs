//! One ray through the middle of a patch: along it the nodes of the patch's rule are placed, and it
//! tells how many are enough.

use super::control::{self, Fields};
use super::pixels::{Head, Light, at};
use super::sight::{CHECK, Section, Sight, ToLamp};
use crate::airlight::mapped::{Map, OPAQUE, PROBES, Probes, SIZES};
use crate::frame::tolerance::Tolerance;
use crate::geometry::control::{Each, PADDED};
use crate::light::ToLight;
use crate::num::{Lanes, Num};
use crate::quadrature::gauss_legendre;
use fearless_simd::{Simd, dispatch};
use std::sync::LazyLock;

/// Optical depth of a ray that is as good as clear.
const UNSEEN: f32 = 1e-4;

/// What rounding leaves where there is no fog: ln β has a floor.
const NOTHING: f64 = 1e-20;

/// What rounding leaves of the haze's depth where that is taken away from the whole.
const ROUNDING: f64 = 1e-6;

/// A rule may miss so many times more on other rays of its patch: its own estimate of that is the
/// square of a ratio, and exceeds what is really missed by as much.
const ELSEWHERE: f64 = 30.0;

/// The rules that are tried.
static RULES: LazyLock<Vec<Rule>> = LazyLock::new(|| SIZES.map(Rule::new).into());

/// Highest polynomials that tell whether a rule resolves what it sums up.
const HIGHEST: usize = 4;

/// A Gauss–Legendre rule on [0, 1], sixteen numbers a row.
struct Rule {
    nodes: Vec<Each>,
    weights: Vec<Each>,
    /// (2k + 1) P_k at the nodes for the highest k below their number, row by row.
    highest: Vec<[Each; HIGHEST]>,
}

impl Rule {
    fn new(size: usize) -> Self {
        let rows = |values: &[f64]| values.chunks(PADDED).map(row).collect();
        let (nodes, weights) = gauss_legendre(size);
        let mut highest = vec![[[0.0; PADDED]; HIGHEST]; size / PADDED];
        for (j, node) in nodes.iter().enumerate() {
            let (x, mut before, mut value) = (2.0 * node - 1.0, 1.0, 2.0 * node - 1.0);
            for k in 1..size {
                if k + HIGHEST >= size {
                    let scale = (2 * k + 1) as f64;
                    highest[j / PADDED][k + HIGHEST - size][j % PADDED] = (scale * value) as f32;
                }
                let n = k as f64;
                (before, value) = (value, ((2.0 * n + 1.0) * x * value - n * before) / (n + 1.0));
            }
        }
        Self { nodes: rows(&nodes), weights: rows(&weights), highest }
    }

    /// What the rule may be off by, relative, given its terms. The Legendre coefficients of a smooth
    /// integrand fall geometrically; a rule of n nodes misses those from the 2n-th on, which are as
    /// far below the n-th as that is below the first.
    fn unresolved(&self, terms: &[Each]) -> f64 {
        let mut coefficients = [0.0f32; HIGHEST];
        for (row, highest) in terms.iter().zip(&self.highest) {
            for (coefficient, values) in coefficients.iter_mut().zip(highest) {
                *coefficient +=
                    row.iter().zip(values).map(|(term, value)| term * value).sum::<f32>();
            }
        }
        let largest = coefficients.iter().fold(0.0f32, |most, value| most.max(value.abs()));
        (f64::from(largest) / total(terms).max(f64::MIN_POSITIVE)).powi(2)
    }
}

/// Numbers along one ray, in a full row.
fn row(values: &[f64]) -> Each {
    std::array::from_fn(|i| values[i] as f32)
}

/// Where the integrand is evaluated on a section, sixteen places a row.
pub struct Nodes {
    /// The rule that they belong to.
    rule: &'static Rule,
    /// Where on the section.
    pub share: Vec<Each>,
    /// ln of the weights on the ray that they were placed on [m].
    pub log_weight: Vec<Each>,
    /// What a share of 1 is long there [m].
    range: f32,
}

impl Nodes {
    /// Ray parameters on a section of one ray [m].
    fn on(&self, section: &Section) -> Vec<Each> {
        let (begin, range) = (section.begin[0], section.range[0]);
        self.share.iter().map(|row| row.map(|share| range.mul_add(share, begin))).collect()
    }

    /// What a rule makes of the airlight along a section of one ray per unit of ω·I₀, node by node.
    fn terms(
        &self,
        to: &ToLamp,
        light: &ToLight<f64>,
        section: &Section,
        log: &[Each],
        mean: &[Each],
    ) -> Vec<Each> {
        let (level, t) = (to.context.job.level, self.on(section));
        dispatch!(level, simd => {
            terms(simd, &Light::of(simd, to.scatter.phase, light), &t, log, mean)
        })
    }

    /// ln of what weights grow by on another ray, where the section is that long [m].
    pub fn log_stretch(&self, range: f32) -> f32 {
        (range / self.range).max(f32::MIN_POSITIVE).ln()
    }

    /// ln β − T with the weights of a section of one ray [m].
    fn weighed(&self, section: &Section, log: &[Each]) -> Vec<Each> {
        let stretch = self.log_stretch(section.range[0]);
        let rows = log.iter().zip(&self.log_weight);
        rows.map(|(log, weight)| std::array::from_fn(|i| log[i] + (weight[i] + stretch))).collect()
    }
}

/// Nodes for what a patch's rays see on a section: the smallest rule that resolves the ray through
/// its middle.
pub fn nodes(to: &ToLamp, sight: &Sight, section: &Section, dense: Option<(f32, f32)>) -> Nodes {
    let level = to.context.job.level;
    let to_light = control::to_light(&sight.rays, to.lamp);
    let dense = dense.map(|(a, b)| (f64::from(a), f64::from(b)));
    let (from, to_end) = section.on_first();
    let (begin, end) = (f64::from(from), f64::from(to_end));
    let probes = Probes::new(begin, end, dense, &to_light);
    let t: Vec<Each> = probes.at.chunks(PADDED).map(row).collect();
    let fields = sight.fields(to, &t);
    let phase = to.scatter.phase;
    let seen = dispatch!(level, simd => {
        seen(simd, &Light::of(simd, phase, &to_light), &t, &fields)
    });
    let map = Map::new(phase, begin, end, to_light, &probes, &seen);
    let known = Known::new(to, sight, section, dense);
    let place = |rule| dispatch!(level, simd => place(simd, &map, rule, section));
    let mut nodes = place(&RULES[0]);
    for rule in &RULES[1..] {
        if suffices(to, sight, section, &nodes, &to_light, &known) {
            break;
        }
        nodes = place(rule);
    }
    nodes
}

/// What the lumps on a section remove is known; a rule that misses it has not seen them all. Haze is
/// smooth, and far from the light most of it does not matter.
struct Known {
    /// ∫ β e^(−T) dt of the lumps alone.
    removed: f64,
    /// What a rule may miss is a share of this: beside as much haze, a thin lump need not be met as
    /// closely.
    counts: f64,
    /// Optical depth of the haze, for its rounding.
    haze: f64,
}

impl Known {
    fn new(to: &ToLamp, sight: &Sight, section: &Section, dense: Option<(f64, f64)>) -> Self {
        let level = to.context.job.level;
        let (begin, end) = section.on_first();
        let haze_to = |t: f32| f64::from(sight.met.haze_to(level, t));
        let lumps_to = |t: f32| {
            let whole = sight.met.fields(level, &[[t; PADDED]])[1][0][0];
            (f64::from(whole) - haze_to(t)).max(0.0)
        };
        let before = if begin > 0.0 { lumps_to(begin) } else { 0.0 };
        let removed = (-before).exp() * -(before - lumps_to(end)).min(0.0).exp_m1();
        let among = dense.map_or(0.0, |(low, high)| haze_to(high as f32) - haze_to(low as f32));
        Self { removed, counts: removed.max(-(-among).exp_m1()), haze: haze_to(end) }
    }
}

/// Whether a rule resolves the ray through the middle, and has seen all its lumps.
fn suffices(
    to: &ToLamp,
    sight: &Sight,
    section: &Section,
    nodes: &Nodes,
    to_light: &ToLight<f64>,
    known: &Known,
) -> bool {
    let level = to.context.job.level;
    let t = nodes.on(section);
    let fields = sight.fields(to, &t);
    let log = nodes.weighed(section, &fields.log);
    let terms = nodes.terms(to, to_light, section, &log, &fields.mean);
    let Tolerance { agree, unmet, .. } = *to.tolerance;
    if nodes.rule.unresolved(&terms) > agree {
        return false;
    }
    let haze = sight.met.haze(level, &t);
    let weights = &nodes.log_weight;
    let met = dispatch!(level, simd => removed_by_lumps(simd, weights, &fields, &haze));
    (met - known.removed).abs() <= unmet * known.counts + ROUNDING * known.haze + NOTHING
}

/// Whether the patch asks too much of its rule and its quadratics, at a place where all errors
/// of the latter show: the rule was chosen for the ray through the middle, and must resolve what
/// other rays see, too.
pub fn is_rough(to: &ToLamp, sight: &Sight, section: &Section, nodes: &Nodes, head: &Head) -> bool {
    let exact = sight.fields(to, &nodes.on(section));
    let Some(through) = exact.depth.last().map(|depth| depth[PADDED - 1]) else { return false };
    if through < UNSEEN {
        return false;
    }
    let [x, y] = CHECK;
    let (mut log, mut mean) = (exact.log.clone(), exact.mean.clone());
    for (j, node) in head.nodes.iter().enumerate() {
        log[j / PADDED][j % PADDED] = at(&node.log, x, y);
        mean[j / PADDED][j % PADDED] = at(&node.mean, x, y);
    }
    let [begin, range] = [&head.begin, &head.range].map(|field| [at(field, x, y); PADDED]);
    let to_light = control::to_light(&sight.rays, to.lamp);
    let is = nodes.terms(to, &to_light, section, &nodes.weighed(section, &exact.log), &exact.mean);
    let would_be = nodes.terms(to, &to_light, &Section { begin, range, ..*section }, &log, &mean);
    let Tolerance { rough, agree, .. } = *to.tolerance;
    let (is, would_be, missed) = (total(&is), total(&would_be), nodes.rule.unresolved(&is));
    (is - would_be).abs() > rough * is || missed > ELSEWHERE * agree
}

/// √(k(α) β e^(−T(v,x)−T(x,s))) at probes.
#[inline(always)]
fn seen<S: Simd>(simd: S, light: &Light<S>, t: &[Each], fields: &Fields) -> [f64; PROBES] {
    let mut out = [0.0f32; PROBES];
    for at in (0..PROBES).step_by(Lanes::<S>::COUNT) {
        let load = |rows: &[Each]| Lanes::load(simd, &rows[at / PADDED][at % PADDED..]);
        let value = light.root(load(t), load(&fields.log), load(&fields.mean));
        value.store(&mut out[at..]);
    }
    out.map(f64::from)
}

/// A rule's nodes on a section.
#[inline(always)]
fn place<S: Simd>(simd: S, map: &Map, rule: &'static Rule, section: &Section) -> Nodes {
    let (share, log_weight) = (rule.nodes.clone(), rule.weights.clone());
    let (begin, range) = (section.begin[0], section.range[0]);
    let mut placed = Nodes { rule, share, log_weight, range };
    for (share, log_weight) in placed.share.iter_mut().zip(&mut placed.log_weight) {
        for at in (0..PADDED).step_by(Lanes::<S>::COUNT) {
            let (place, slope) = map.solve(Lanes::load(simd, &share[at..]));
            let weight = Lanes::load(simd, &log_weight[at..]) / slope;
            let place = (place - Lanes::splat(simd, begin)) / Lanes::splat(simd, range);
            place.store(&mut share[at..]);
            weight.max(weight.lit(f64::from(f32::MIN_POSITIVE))).ln().store(&mut log_weight[at..]);
        }
    }
    placed
}

/// The airlight's terms along one ray; logarithms include the nodes' weights.
#[inline(always)]
fn terms<S: Simd>(simd: S, light: &Light<S>, t: &[Each], log: &[Each], mean: &[Each]) -> Vec<Each> {
    let mut terms = vec![[0.0; PADDED]; t.len()];
    for (row, terms) in terms.iter_mut().enumerate() {
        for at in (0..PADDED).step_by(Lanes::<S>::COUNT) {
            let load = |rows: &[Each]| Lanes::load(simd, &rows[row][at..]);
            light.scattered(load(t), load(log), load(mean)).store(&mut terms[at..]);
        }
    }
    terms
}

/// ∫ β e^(−T) dt of the lumps alone, as a rule has it: what is left of β and T without the haze.
#[inline(always)]
fn removed_by_lumps<S: Simd>(
    simd: S,
    log_weights: &[Each],
    fields: &Fields,
    [beta, depth]: &[Vec<Each>; 2],
) -> f64 {
    let mut terms = vec![[0.0; PADDED]; log_weights.len()];
    for (row, terms) in terms.iter_mut().enumerate() {
        for at in (0..PADDED).step_by(Lanes::<S>::COUNT) {
            let load = |rows: &[Each]| Lanes::load(simd, &rows[row][at..]);
            let whole = load(&fields.depth);
            let mut own =
                (load(&fields.log) + whole.min(whole.lit(2.0 * OPAQUE))).exp() - load(beta);
            if !fields.other_beta.is_empty() {
                own += load(&fields.other_beta);
            }
            let weight = load(log_weights) - whole + load(depth);
            (own.max(own.lit(0.0)) * weight.exp()).store(&mut terms[at..]);
        }
    }
    total(&terms)
}

fn total(terms: &[Each]) -> f64 {
    terms.as_flattened().iter().copied().map(f64::from).sum()
}
