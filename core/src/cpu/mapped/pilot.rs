//! One ray through the middle of a patch: along it the nodes of the patch's rule are placed, and it
//! tells how many are enough.

use super::control::{Each, Fields, PADDED};
use super::patch::Tolerance;
use super::pixels::{Head, Light, at};
use super::{CHECK, Pass, Sight};
use crate::airlight::ToLight;
use crate::airlight::mapped::{Map, OPAQUE, PROBES, Probes, SIZES};
use crate::num::{Lanes, Num};
use crate::quadrature::gauss_legendre;
use fearless_simd::{Simd, dispatch};
use std::sync::LazyLock;

/// Optical depth of a ray that is as good as clear.
const UNSEEN: f32 = 1e-4;

/// Surfaces may be off by so many times what airlight may.
const DIMMED: f64 = 2.0;

/// Share of a blob, in thin fog, that does not matter to where nodes are placed.
pub const FAINT: f32 = 1e-5;

/// What rounding leaves where there is no fog: ln β has a floor.
const NOTHING: f64 = 1e-20;

/// What rounding leaves of the homogeneous fog's depth where that is taken away from the whole.
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

/// Where the integrand is evaluated, sixteen places a row.
pub struct Nodes {
    /// The rule that they belong to.
    rule: &'static Rule,
    /// Ray parameters [m].
    pub t: Vec<Each>,
    /// ln of the weights [m].
    pub log_weight: Vec<Each>,
}

impl Pass<'_> {
    /// Nodes for what a patch's rays see between two ray parameters: the smallest rule that
    /// resolves the ray through its middle.
    pub fn nodes(&self, sight: &Sight, dense: Option<(f32, f32)>, from: f32, to: f32) -> Nodes {
        let (context, level) = (self.context, self.context.level);
        let beta = context.field.homogeneous.beta as f32;
        let to_light = sight.rays.light(self.lamp);
        let dense = dense.map(|(a, b)| (f64::from(a), f64::from(b)));
        let (begin, end) = (f64::from(from), f64::from(to));
        let probes = Probes::new(begin, end, dense, &to_light);
        let t: Vec<Each> = probes.at.chunks(PADDED).map(row).collect();
        let fields = self.fields(sight, &t);
        let seen = dispatch!(level, simd => {
            seen(simd, &Light::of(simd, context.phase, &to_light), &t, &fields)
        });
        let map = Map::new(context.phase, begin, end, to_light, &probes, &seen);
        // What the blobs alone remove is known; a rule that misses it has not seen them all. The
        // homogeneous fog is smooth, and far from the light most of it does not matter.
        let haze = beta * to;
        let through = sight.met.profile(context, &[[to; PADDED]]).depth[0][0];
        let removed = -f64::from(haze - through).exp_m1();
        // Beside as much homogeneous fog, a thin blob need not be met as closely.
        let among = dense.map_or(0.0, |(low, high)| f64::from(beta) * (high - low));
        let known = removed.max(-(-among).exp_m1());
        let Tolerance { agree, unmet, .. } = Tolerance::new(context);
        let suffices = |nodes: &Nodes| {
            let fields = self.fields(sight, &nodes.t);
            let met = dispatch!(level, simd => removed_by_blobs(simd, nodes, &fields, beta));
            let missed = (met - removed).abs();
            let resolves = nodes.rule.unresolved(&self.terms(&to_light, nodes, &fields)) <= agree;
            resolves && missed <= unmet * known + ROUNDING * f64::from(haze) + NOTHING
        };
        let place = |rule| dispatch!(level, simd => place(simd, &map, rule));
        let mut nodes = place(&RULES[0]);
        for rule in &RULES[1..] {
            if suffices(&nodes) {
                break;
            }
            nodes = place(rule);
        }
        nodes
    }

    /// What a rule makes of the airlight along a ray per unit of ω·I₀, node by node.
    fn terms(&self, to_light: &ToLight<f64>, nodes: &Nodes, fields: &Fields) -> Vec<Each> {
        dispatch!(self.context.level, simd => {
            terms(simd, &Light::of(simd, self.context.phase, to_light), nodes, fields)
        })
    }

    /// Whether the patch asks too much of its rule and its quadratics, at a place where all errors
    /// of the latter show: the rule was chosen for the ray through the middle, and must resolve what
    /// other rays see, too.
    pub fn is_rough(&self, sight: &Sight, nodes: &Nodes, head: &Head) -> bool {
        let exact = self.fields(sight, &nodes.t);
        let Some(through) = exact.depth.last().map(|depth| depth[PADDED - 1]) else { return false };
        if through < UNSEEN {
            return false;
        }
        let [x, y] = CHECK;
        let mut smooth =
            Fields { log: exact.log.clone(), mean: exact.mean.clone(), depth: Vec::new() };
        for (j, node) in head.nodes.iter().enumerate() {
            let (row, lane) = (j / PADDED, j % PADDED);
            smooth.log[row][lane] = at(&node.log, x, y) - node.log_weight;
            smooth.mean[row][lane] = at(&node.mean, x, y);
        }
        let to_light = sight.rays.light(self.lamp);
        let [is, would_be] = [&exact, &smooth].map(|fields| self.terms(&to_light, nodes, fields));
        let Tolerance { rough, agree, .. } = Tolerance::new(self.context);
        let dims = f64::from((at(&head.depth, x, y) - through).abs() * (-through).exp());
        let (is, would_be, missed) = (total(&is), total(&would_be), nodes.rule.unresolved(&is));
        (is - would_be).abs() > rough * is
            || missed > ELSEWHERE * agree
            || self.sets_depth && dims > DIMMED * rough
    }
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

/// A rule's nodes.
#[inline(always)]
fn place<S: Simd>(simd: S, map: &Map, rule: &'static Rule) -> Nodes {
    let mut placed = Nodes { rule, t: rule.nodes.clone(), log_weight: rule.weights.clone() };
    for (t, log_weight) in placed.t.iter_mut().zip(&mut placed.log_weight) {
        for at in (0..PADDED).step_by(Lanes::<S>::COUNT) {
            let (place, slope) = map.solve(Lanes::load(simd, &t[at..]));
            let weight = Lanes::load(simd, &log_weight[at..]) / slope;
            place.store(&mut t[at..]);
            weight.max(weight.lit(f64::from(f32::MIN_POSITIVE))).ln().store(&mut log_weight[at..]);
        }
    }
    placed
}

/// The airlight's terms along one ray.
#[inline(always)]
fn terms<S: Simd>(simd: S, light: &Light<S>, nodes: &Nodes, fields: &Fields) -> Vec<Each> {
    let mut terms = vec![[0.0; PADDED]; nodes.t.len()];
    for (row, terms) in terms.iter_mut().enumerate() {
        for at in (0..PADDED).step_by(Lanes::<S>::COUNT) {
            let t = Lanes::load(simd, &nodes.t[row][at..]);
            let log = Lanes::load(simd, &fields.log[row][at..])
                + Lanes::load(simd, &nodes.log_weight[row][at..]);
            let mean = Lanes::load(simd, &fields.mean[row][at..]);
            light.scattered(t, log, mean).store(&mut terms[at..]);
        }
    }
    terms
}

/// ∫ β e^(−T) dt of the blobs alone, as a rule has it: what is left of β and T without the
/// homogeneous fog's.
#[inline(always)]
fn removed_by_blobs<S: Simd>(simd: S, nodes: &Nodes, fields: &Fields, haze: f32) -> f64 {
    let haze = Lanes::splat(simd, haze);
    let mut terms = vec![[0.0; PADDED]; nodes.t.len()];
    for (row, terms) in terms.iter_mut().enumerate() {
        for at in (0..PADDED).step_by(Lanes::<S>::COUNT) {
            let t = Lanes::load(simd, &nodes.t[row][at..]);
            let depth = Lanes::load(simd, &fields.depth[row][at..]);
            let log = Lanes::load(simd, &fields.log[row][at..]);
            let own = (log + depth.min(depth.lit(2.0 * OPAQUE))).exp() - haze;
            let weight = Lanes::load(simd, &nodes.log_weight[row][at..]) - depth + haze * t;
            (own.max(own.lit(0.0)) * weight.exp()).store(&mut terms[at..]);
        }
    }
    total(&terms)
}

fn total(terms: &[Each]) -> f64 {
    terms.as_flattened().iter().copied().map(f64::from).sum()
}
