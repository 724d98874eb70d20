//! Airlight of batches of rays by [`mapped`](crate::airlight::mapped)'s rule.
//!
//! What is expensive is smooth across the picture: at a node of the rule, ln β − T(v,x) and
//! T(x,s)/d, the mean extinction towards the light, are evaluated on eight rays around a patch of
//! pixels and interpolated quadratically. 1/d² and the exponential, which are not smooth near a
//! light, are evaluated at every pixel. A pixel's cost does not depend on the number of blobs.
//!
//! Rays of a patch end at different depths. Those that end close to each other share a layer: the
//! rule covers what all of them see (the head), and a short rule of each pixel's own the rest (the
//! tail).

mod control;
mod patch;
mod pilot;
mod pixels;
mod sight;

pub use control::toward_light;

use super::places::{Member, Places, Samples};
use super::views::near_views;
use crate::airlight::mapped::PROBES;
use crate::frame::context::Context;
use crate::frame::tolerance::{THIN, Tolerance};
use crate::geometry::batch::{Ends, Fogged, get3};
use crate::geometry::control::{Each, PADDED};
use crate::media::{Legs, Purpose, Smooth, Sum};
use crate::num::{Lanes, Num};
use crate::vector::V3;
use control::{CONTROL, Fields, of_place, pairs};
use fearless_simd::{Simd, dispatch};
use patch::{Patch, SMALLEST, Surroundings};
use pilot::{Nodes, is_rough, nodes};
use pixels::{Head, Light, Node, TAIL, Tail, Terms, quadratic};
use sight::{Edges, Section, Sight, Sights, ToLamp};

/// A patch of many layers is split if it is larger than this [px].
const LEAST_LAYERED: f32 = 8.0;
/// A tail among blobs may be so many of their radii long, times a layer's share: over a radius, as
/// in 8-bit pictures, a Gaussian is a cubic to 2 %.
const SMOOTH: f32 = 4.5;

/// Adds what is scattered of some lamps along the rays of some batches that stand together.
pub fn add(context: &Context, asked: &[usize], block: &[Ends<'_>], fogged: &mut [Fogged]) {
    let places = Places::new(context, block);
    let fog = near_views(context, block, Purpose::Nodes).patched();
    let haze = &context.field.smooth(context.viewpoint.position, Legs::OfEyes);
    let tolerance = &Tolerance::new(&context.view, context.field.lumps());
    let is_over = || context.job.progress.is_over();
    let mut patches = vec![Patch::whole(block, &places)];
    while let Some(patch) = patches.pop().filter(|_| !is_over()) {
        let longest = patch.members.last().map_or(0.0, |ray| ray.length(block));
        let around = Surroundings::new(context, tolerance, &fog, &patch, longest);
        if around.is_coarse {
            patches.extend(patch.quarters(&places));
            continue;
        }
        let sights = Sights::new(context, &around.fog, &patch);
        for (row, i) in asked.iter().enumerate() {
            let scatter = &context.scatters[*i];
            let lamp = &context.lamps[scatter.lamp];
            let to = ToLamp { context, lamp, scatter, tolerance };
            let pass = Pass { to, row, haze, block, places: &places };
            let mut parts = pass.light(&patch, &sights, fogged);
            while let Some(part) = parts.pop().filter(|_| !is_over()) {
                let sights = Sights::new(context, &around.fog, &part);
                parts.extend(pass.light(&part, &sights, fogged));
            }
        }
    }
}

/// Rays before one lamp.
struct Pass<'a> {
    to: ToLamp<'a>,
    /// Where its airlight stands among that of the lamps that are asked for.
    row: usize,
    /// What is smooth, for rays from the viewpoint.
    haze: &'a Sum<dyn Smooth>,
    block: &'a [Ends<'a>],
    places: &'a Places,
}

/// What the pixels of a layer sum up.
struct Sums<'a> {
    layer: &'a Layer<'a>,
    heads: &'a [Head],
    tail: Option<&'a Tail>,
}

/// Where rays meet fog, in ray parameters [m].
struct Reach {
    /// Where fog begins.
    from: f32,
    /// Where it ends, or nothing behind is seen.
    to: f32,
    /// From where to where lumps are.
    dense: Option<(f32, f32)>,
}

/// Rays that end between two ray parameters [m], as a part of a patch.
struct Layer<'a> {
    from: f32,
    first: f32,
    last: f32,
    members: &'a [Member],
}

impl Pass<'_> {
    /// Adds the lamp's airlight to the rays of a patch; its parts, if it is too large for them.
    fn light(&self, patch: &Patch, sights: &Sights, fogged: &mut [Fogged]) -> Vec<Patch> {
        let split = || patch.quarters(self.places);
        let (to, can_split) = (&self.to, patch.size() > SMALLEST);
        if patch::is_near(to.context, to.tolerance.near, to.lamp, patch) {
            return split();
        }
        let Some(Reach { from, to: end, dense }) = self.reach(patch, &sights.control) else {
            return Vec::new();
        };
        let layers = self.layers(patch, &sights.control, from, end, dense);
        if layers.len() > to.tolerance.layers && patch.size() > LEAST_LAYERED {
            return split();
        }
        let mut heads = Vec::with_capacity(layers.len());
        for layer in &layers {
            let edges = match self.edges(sights, layer) {
                Some(edges) => edges,
                None if can_split => return split(),
                // A pixel's samples that are too different take what they get.
                None => Edges::default(),
            };
            match self.heads(sights, layer, dense, &edges, can_split) {
                Some(own) => heads.push((own, edges.bound)),
                None => return split(),
            }
        }
        for (layer, (heads, bound)) in layers.iter().zip(&heads) {
            self.layer(patch, &sights.control, layer, heads, *bound, fogged);
        }
        Vec::new()
    }

    /// What the rays of a layer have to do with the edges of the fog.
    fn edges(&self, sights: &Sights, layer: &Layer) -> Option<Edges> {
        if !sights.has_edges() {
            return Some(Edges::default());
        }
        let ray = |member: &Member| {
            let (Ends { rays, hits }, at) = (&self.block[member.batch()], member.at());
            (get3(&rays.offset, at), get3(&rays.direction, at), hits.length[at])
        };
        let ends = [layer.from, layer.first, layer.last];
        sights.edges(self.haze, layer.members.iter().map(ray), ends)
    }

    /// The sections before the first end of a layer; `None` if the patch should be split for them.
    fn heads(
        &self,
        sights: &Sights,
        layer: &Layer,
        dense: Option<(f32, f32)>,
        edges: &Edges,
        can_split: bool,
    ) -> Option<Vec<Head>> {
        let is_short = |from: f32, to: f32| to - from <= 1e-6 * to;
        if is_short(layer.from, layer.first) {
            return Some(Vec::new());
        }
        let sections = sights.sections(layer.from, layer.first, &edges.passed);
        let mut heads = Vec::with_capacity(sections.middle.len());
        for (i, middle) in sections.middle.iter().enumerate() {
            let (from, to) = middle.on_first();
            if is_short(from, to) {
                continue;
            }
            let nodes = nodes(&self.to, &sights.middle, middle, dense);
            let head = self.head(&sights.control, &sections.control[i], &nodes);
            let check = &sections.check[i];
            if can_split && is_rough(&self.to, &sights.check, check, &nodes, &head) {
                return None;
            }
            heads.push(head);
        }
        Some(heads)
    }

    /// Where the patch's rays meet fog that is seen; `None` if nowhere.
    fn reach(&self, patch: &Patch, control: &Sight) -> Option<Reach> {
        let longest = patch.members.last().map_or(0.0, |ray| ray.length(self.block));
        // Haze hides the rest of a long ray by itself.
        let longest = longest.min(control.met.hides_from(0.0, self.to.context.opaque()));
        let dense = control.met.dense(longest);
        let (from, to) = control.met.span_of(self.to.scatter.group, longest)?;
        Some(Reach { from, to: self.opaque_from(control, from, to, dense), dense })
    }

    /// The patch's rays that meet fog, by where they end.
    fn layers<'b>(
        &self,
        patch: &'b Patch,
        control: &Sight,
        from: f32,
        to: f32,
        dense: Option<(f32, f32)>,
    ) -> Vec<Layer<'b>> {
        let end = |ray: &Member| ray.length(self.block).min(to);
        let reached = patch.members.partition_point(|ray| ray.length(self.block) <= from);
        let thin = dense.map_or(0.0, |(begin, end)| THIN * (end - begin));
        let share = self.to.tolerance.layer;
        let mut layers = Vec::new();
        let mut rest = &patch.members[reached..];
        while let Some(nearest) = rest.first() {
            let first = end(nearest);
            let reach = (share * (first - from)).max(thin);
            // A tail's cubics hold what is smooth across it.
            let finest = control.met.finest(first, first + reach);
            let reach = first + reach.min(SMOOTH * share * finest).max(1e-5 * first);
            let (members, behind) = rest.split_at(rest.partition_point(|ray| end(ray) <= reach));
            let last = members.last().map_or(first, end);
            layers.push(Layer { from, first, last, members });
            rest = behind;
        }
        layers
    }

    /// Where nothing behind is seen any more: among the lumps, else behind them, where only haze is
    /// left.
    fn opaque_from(&self, sight: &Sight, from: f32, to: f32, dense: Option<(f32, f32)>) -> f32 {
        let Some((_, end)) = dense.filter(|_| sight.met.most(to) >= self.to.context.opaque())
        else {
            return to;
        };
        let part = (end - from) / PROBES as f32;
        let t: [f32; PROBES] = std::array::from_fn(|i| (i as f32 + 1.0).mul_add(part, from));
        let depth = &sight.met.depth(self.to.context.job.level, &pairs(&t));
        let thinnest = |at: usize| of_place(depth, at).into_iter().fold(f32::INFINITY, f32::min);
        if let Some(opaque) = (0..PROBES).find(|at| thinnest(*at) > self.to.context.opaque()) {
            return t[opaque];
        }
        to.min(sight.met.hides_from(end, self.to.context.opaque() - thinnest(PROBES - 1)))
    }

    /// Adds the lamp's airlight to the rays of a layer.
    fn layer(
        &self,
        patch: &Patch,
        control: &Sight,
        layer: &Layer,
        heads: &[Head],
        bound: Option<usize>,
        fogged: &mut [Fogged],
    ) {
        let level = self.to.context.job.level;
        let has_tail = layer.last - layer.first > 1e-5 * (layer.last - layer.from);
        let tail = has_tail.then(|| {
            self.tail(control, layer.first, &control.up_to(layer.first, bound, layer.last))
        });
        let sums = Sums { layer, heads, tail: tail.as_ref() };
        dispatch!(level, simd => self.add(simd, patch, &sums, fogged));
    }

    fn head(&self, sight: &Sight, section: &Section, nodes: &Nodes) -> Head {
        let (shares, log_weights) = (nodes.share.as_flattened(), nodes.log_weight.as_flattened());
        let t: Vec<_> = shares.chunks(PADDED / CONTROL).map(|x| section.at(x)).collect();
        let Fields { log, mean, .. } = sight.fields(&self.to, &t);
        let stretch = first_half(&section.range).map(|range| nodes.log_stretch(range));
        let node = |(j, (share, log_weight)): (usize, (&f32, &f32))| {
            let at = of_place(&log, j);
            let log = std::array::from_fn(|c| at[c] + (log_weight + stretch[c]));
            let (most, log) = (most(&log), quadratic(log));
            Node { share: *share, log, most, mean: quadratic(of_place(&mean, j)) }
        };
        Head {
            begin: quadratic(first_half(&section.begin)),
            range: quadratic(first_half(&section.range)),
            nodes: shares.iter().zip(log_weights).enumerate().map(node).collect(),
        }
    }

    fn tail(&self, sight: &Sight, from: f32, section: &Section) -> Tail {
        let t: Vec<_> = CHEBYSHEV.chunks(PADDED / CONTROL).map(|x| section.at(x)).collect();
        let Fields { log, mean, .. } = sight.fields(&self.to, &t);
        let along =
            |rows: &[Each]| cubic(std::array::from_fn(|i| of_place(rows, i))).map(quadratic);
        let most = (0..TAIL).map(|i| most(&of_place(&log, i))).fold(f32::NEG_INFINITY, f32::max);
        let [begin, range] = [&section.begin, &section.range].map(|row| quadratic(first_half(row)));
        let [log, mean] = [&log, &mean].map(|rows| along(rows));
        Tail { from, begin, range, log, most, mean }
    }

    /// Sums at the pixels of a layer.
    #[inline(always)]
    fn add<S: Simd>(&self, simd: S, patch: &Patch, sums: &Sums, fogged: &mut [Fogged]) {
        let one = Lanes::splat(simd, 1.0);
        let (middle, half) = (patch.middle(), patch.half());
        let ToLamp { lamp, scatter, .. } = self.to;
        let samples = Samples { block: self.block, places: self.places };
        for members in sums.layer.members.chunks(Lanes::<S>::COUNT) {
            let gathered = samples.gather(members, Lanes::<S>::COUNT);
            let row = |i: usize| &gathered[i];
            let [x, y, dx, dy, dz, ox, oy, oz, length] =
                [row(0), row(1), row(2), row(3), row(4), row(5), row(6), row(7), row(8)];
            let x =
                (Lanes::load(simd, x) - Lanes::splat(simd, middle.x)) / Lanes::splat(simd, half.x);
            let y =
                (Lanes::load(simd, y) - Lanes::splat(simd, middle.y)) / Lanes::splat(simd, half.y);
            let terms = Terms::new(x, y);
            let direction =
                V3::new(Lanes::load(simd, dx), Lanes::load(simd, dy), Lanes::load(simd, dz));
            let offset =
                V3::new(Lanes::load(simd, ox), Lanes::load(simd, oy), Lanes::load(simd, oz));
            let length = Lanes::load(simd, length);
            let light = Light::new(scatter.phase, lamp.from_camera, offset, direction);
            let mut sum = one.lit(0.0);
            for head in sums.heads {
                sum += pixels::head(simd, head, &terms, &light);
            }
            let end = length.min(Lanes::splat(simd, sums.layer.last));
            if let Some(tail) = sums.tail {
                sum += pixels::tail(simd, tail, &terms, &light, end);
            }
            let mut values = [0.0; PADDED];
            sum.store(&mut values);
            for (value, ray) in values.iter().zip(members) {
                fogged[ray.batch()].airlight[self.row][ray.at()] += value;
            }
        }
    }
}

/// The values of eight rays, of which a row repeats each.
fn first_half(row: &Each) -> [f32; CONTROL] {
    std::array::from_fn(|c| row[c])
}

/// The largest of the control rays' values, and room for what lies between them.
fn most(log: &[f32; CONTROL]) -> f32 {
    log.iter().copied().fold(f32::NEG_INFINITY, f32::max) + 0.5
}

/// Where a tail's fields are evaluated: Chebyshev's abscissae on [0, 1].
const CHEBYSHEV: [f32; TAIL] = [0.038_060_233, 0.308_658_28, 0.691_341_7, 0.961_939_75];

/// Coefficients of the cubic through values at [`CHEBYSHEV`], control ray by control ray.
fn cubic(values: [[f32; CONTROL]; TAIL]) -> [[f32; CONTROL]; TAIL] {
    let mut coefficients = [[0.0; CONTROL]; TAIL];
    for c in 0..CONTROL {
        // Newton's divided differences, then expanded.
        let mut d = [0, 1, 2, 3].map(|i| f64::from(values[i][c]));
        let x = CHEBYSHEV.map(f64::from);
        for order in 1..TAIL {
            for i in (order..TAIL).rev() {
                d[i] = (d[i] - d[i - 1]) / (x[i] - x[i - order]);
            }
        }
        let mut p = [d[3], 0.0, 0.0, 0.0];
        for i in (0..3).rev() {
            for k in (1..TAIL).rev() {
                p[k] = p[k - 1] - x[i] * p[k];
            }
            p[0] = d[i] - x[i] * p[0];
        }
        (0..TAIL).for_each(|k| coefficients[k][c] = p[k] as f32);
    }
    coefficients
}
