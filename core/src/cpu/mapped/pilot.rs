//! One ray through the middle of a patch: along it the nodes of the patch's rule are placed, and it
//! tells how many are enough.

use super::control::{Control, Each, Fields, PADDED};
use super::patch::{Patch, Tolerance};
use super::pixels::{Head, Light, at};
use super::{CHECK, Pass};
use crate::airlight::mapped::{Map, PROBES, Probes, SIZES, UNMET};
use crate::num::{Lanes, Num};
use crate::quadrature::gauss_legendre;
use fearless_simd::{Simd, dispatch};
use std::sync::LazyLock;

/// Optical depth of a ray that is as good as clear.
const UNSEEN: f32 = 1e-4;

/// Share of a blob, in thin fog, that does not matter to where nodes are placed.
const FAINT: f32 = 1e-5;

/// What rounding leaves where there is no fog: ln β has a floor.
const NOTHING: f64 = 1e-20;

/// Abscissae and weights on [0, 1] of the rules that are tried, sixteen a row.
static RULES: LazyLock<Vec<[Vec<Each>; 2]>> = LazyLock::new(|| {
    let rows = |values: &[f64]| values.chunks(PADDED).map(row).collect();
    let rule = |size| gauss_legendre(size);
    SIZES.map(rule).iter().map(|(nodes, weights)| [rows(nodes), rows(weights)]).collect()
});

/// Numbers along one ray, in a full row.
fn row(values: &[f64]) -> Each {
    std::array::from_fn(|i| values[i] as f32)
}

/// Where the integrand is evaluated, sixteen places a row.
pub struct Nodes {
    /// Ray parameters [m].
    pub t: Vec<Each>,
    /// ln of the weights [m].
    pub log_weight: Vec<Each>,
}

/// What a rule makes of a ray.
struct Sums {
    /// The airlight per unit of ω·I₀.
    airlight: f64,
    /// ∫ β e^(−T) dt.
    removed: f64,
}

impl Pass<'_> {
    /// Nodes for what a patch's rays see between two ray parameters: the coarsest rule that agrees
    /// with the next.
    pub fn nodes(&self, patch: &Patch, dense: Option<(f64, f64)>, from: f64, to: f64) -> Nodes {
        let (context, level) = (self.context, self.context.level);
        let sight = self.sight(Control::within(context, patch, [0.0; 2]), FAINT);
        let to_light = sight.rays.light(self.lamp, to as f32);
        let probes = Probes::new(from, to, dense, &to_light);
        let t: Vec<Each> = probes.at.chunks(PADDED).map(row).collect();
        let fields = self.fields(&sight, &t);
        let through = sight.met.profile(context, &[[to as f32; PADDED]]).depth[0][0];
        let removed = -f64::from(-through).exp_m1();
        let seen = dispatch!(level, simd => {
            seen(simd, &Light::of(simd, context.phase, &to_light), &t, &fields)
        });
        let map = Map::new(context.phase, from, to, to_light, &probes, &seen);
        let sums = |nodes: &Nodes| {
            let fields = self.fields(&sight, &nodes.t);
            dispatch!(level, simd => {
                sums(simd, &Light::of(simd, context.phase, &to_light), nodes, &fields)
            })
        };
        let mut rules = RULES.iter().map(|rule| dispatch!(level, simd => place(simd, &map, rule)));
        let mut nodes = rules.next().unwrap_or_else(|| Nodes { t: vec![], log_weight: vec![] });
        let mut coarse = sums(&nodes);
        let tolerance = Tolerance::new(&context.view).agree;
        for finer in rules {
            let fine = sums(&finer);
            let agree = (fine.airlight - coarse.airlight).abs() <= tolerance * fine.airlight;
            if agree && (coarse.removed - removed).abs() <= UNMET * removed + NOTHING {
                break;
            }
            (nodes, coarse) = (finer, fine);
        }
        nodes
    }

    /// Whether quadratics miss the fields so much that it shows, at a place where all their errors
    /// do.
    pub fn is_rough(&self, patch: &Patch, nodes: &Nodes, head: &Head) -> bool {
        let context = self.context;
        let sight = self.sight(Control::within(context, patch, CHECK), 0.0);
        let exact = self.fields(&sight, &nodes.t);
        if exact.depth.last().is_none_or(|depth| depth[PADDED - 1] < UNSEEN) {
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
        let to_light = sight.rays.light(self.lamp, nodes.t[nodes.t.len() - 1][PADDED - 1]);
        let [is, would_be] = [&exact, &smooth].map(|fields| {
            dispatch!(context.level, simd => {
                sums(simd, &Light::of(simd, context.phase, &to_light), nodes, fields)
            })
        });
        let tolerance = Tolerance::new(&context.view).rough;
        (is.airlight - would_be.airlight).abs() > tolerance * is.airlight
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
fn place<S: Simd>(simd: S, map: &Map, [nodes, weights]: &[Vec<Each>; 2]) -> Nodes {
    let mut placed = Nodes { t: nodes.clone(), log_weight: weights.clone() };
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

/// What nodes make of fields along one ray.
#[inline(always)]
fn sums<S: Simd>(simd: S, light: &Light<S>, nodes: &Nodes, fields: &Fields) -> Sums {
    let zero = Lanes::splat(simd, 0.0);
    let (mut airlight, mut removed) = (zero, zero);
    for row in 0..nodes.t.len() {
        for at in (0..PADDED).step_by(Lanes::<S>::COUNT) {
            let t = Lanes::load(simd, &nodes.t[row][at..]);
            let log = Lanes::load(simd, &fields.log[row][at..])
                + Lanes::load(simd, &nodes.log_weight[row][at..]);
            airlight += light.scattered(t, log, Lanes::load(simd, &fields.mean[row][at..]));
            removed += log.exp();
        }
    }
    Sums { airlight: total(airlight), removed: total(removed) }
}

#[inline(always)]
fn total<S: Simd>(lanes: Lanes<S>) -> f64 {
    let mut each = [0.0f32; PADDED];
    lanes.store(&mut each);
    each.iter().copied().map(f64::from).sum()
}
