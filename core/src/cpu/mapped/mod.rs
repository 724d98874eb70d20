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
mod crossings;
mod patch;
mod pilot;
mod pixels;
mod table;

use super::batch::Fogged;
use super::blobs::Purpose;
use super::fog::{Ends, blobs_on_view};
use super::frame::{Context, Lamp};
use crate::airlight::mapped::{OPAQUE, PROBES};
use crate::num::{Lanes, Num};
use crate::vector::V3;
use control::{Blob, CONTROL, Control, Each, Fields, PADDED, of_place, pairs};
use crossings::{Crossings, Profile};
use fearless_simd::{Simd, dispatch};
pub use patch::Tolerance;
use patch::{Patch, Places, Ray, SMALLEST, Surroundings};
use pilot::{FAINT, Nodes};
use pixels::{Head, Light, Node, Surface, TAIL, Tail, Terms, surface};
pub use table::{Fineness, LightTable, pay as tables_pay};

/// Where quadratics are compared with what they stand for: neither even nor odd errors vanish here.
const CHECK: [f32; 2] = [0.55, 0.45];
/// A patch of many layers is split if it is larger than this [px].
const LEAST_LAYERED: f32 = 8.0;
/// A tail among blobs may be so many of their radii long, times a layer's share: over a radius, as
/// in 8-bit pictures, a Gaussian is a cubic to 2 %.
const SMOOTH: f32 = 4.5;
/// A layer is at least this share of the blobs' extent.
pub const THIN: f32 = 0.02;

/// Adds the airlight of every light along the rays of some batches that stand together, and where
/// the picture allows it sets what fog takes away, too.
pub fn add(context: &Context, block: &[Ends<'_>], fogged: &mut [Fogged]) {
    let places = Places::new(context, block);
    let blobs = control::unpack(&blobs_on_view(context, block, Purpose::Nodes));
    let mut patches = vec![Patch::whole(block, &places)];
    while let Some(patch) = patches.pop().filter(|_| !context.progress.is_over()) {
        let longest = patch.members.last().map_or(0.0, |ray| ray.length(block));
        let around = Surroundings::new(context, &blobs, &patch, longest);
        if around.is_coarse {
            patches.extend(patch.quarters(&places));
            continue;
        }
        let sights = Sights::new(context, &around.blobs, &patch);
        for (i, lamp) in context.lamps.iter().enumerate() {
            let sets_depth = i == 0 && context.interpolates();
            let pass = Pass { context, block, lamp, places: &places, sets_depth };
            let mut parts = pass.light(&patch, &sights, fogged);
            while let Some(part) = parts.pop().filter(|_| !context.progress.is_over()) {
                let sights = Sights::new(context, &around.blobs, &part);
                parts.extend(pass.light(&part, &sights, fogged));
            }
        }
    }
}

/// Rays before one light.
struct Pass<'a> {
    context: &'a Context<'a>,
    block: &'a [Ends<'a>],
    lamp: &'a Lamp,
    places: &'a Places,
    /// Whether what fog takes away is set on the way.
    sets_depth: bool,
}

/// A few rays of a row, and the blobs that they cross.
struct Sight {
    rays: Control,
    met: Crossings,
}

/// The rays that stand for a patch.
struct Sights {
    /// Around it.
    control: Sight,
    /// Through its middle: there nodes are placed.
    middle: Sight,
    /// Where quadratics are compared with what they stand for.
    check: Sight,
}

impl Sights {
    fn new(context: &Context, blobs: &[Blob], patch: &Patch) -> Self {
        let sight = |rays: Control, least: f32| {
            let met = Crossings::on_view(context, &rays, blobs, least);
            Sight { rays, met }
        };
        Self {
            control: sight(Control::around(context, patch), 0.0),
            middle: sight(Control::within(context, patch, [0.0; 2]), FAINT),
            check: sight(Control::within(context, patch, CHECK), 0.0),
        }
    }
}

/// What the pixels of a layer sum up.
struct Sums<'a> {
    layer: &'a Layer<'a>,
    head: Option<&'a Head>,
    tail: Option<&'a Tail>,
    /// T where they end, as in [`Tail`].
    depth: Option<[Surface; TAIL]>,
}

/// Where rays meet fog, in ray parameters [m].
struct Reach {
    /// Where fog begins.
    from: f32,
    /// Where it ends, or nothing behind is seen.
    to: f32,
    /// From where to where blobs are.
    dense: Option<(f32, f32)>,
}

/// Rays that end between two ray parameters [m], as a part of a patch.
struct Layer<'a> {
    from: f32,
    first: f32,
    last: f32,
    members: &'a [Ray],
}

impl Pass<'_> {
    /// Adds the light's airlight to the rays of a patch; its parts, if it is too large for them.
    fn light(&self, patch: &Patch, sights: &Sights, fogged: &mut [Fogged]) -> Vec<Patch> {
        let split = || patch.quarters(self.places);
        if patch::is_near(self.context, self.lamp, patch) {
            return split();
        }
        let Some(Reach { from, to, dense }) = self.reach(patch, &sights.control) else {
            return Vec::new();
        };
        let layers = self.layers(patch, &sights.control, from, to, dense);
        let tolerance = Tolerance::new(self.context);
        if layers.len() > tolerance.layers && patch.size() > LEAST_LAYERED {
            return split();
        }
        let mut heads = Vec::with_capacity(layers.len());
        for layer in &layers {
            if layer.first - layer.from <= 1e-6 * layer.first {
                heads.push(None);
                continue;
            }
            let nodes = self.nodes(&sights.middle, dense, layer.from, layer.first);
            let head = self.head(&sights.control, &nodes);
            if patch.size() > SMALLEST && self.is_rough(&sights.check, &nodes, &head) {
                return split();
            }
            heads.push(Some(head));
        }
        for (layer, head) in layers.iter().zip(&heads) {
            self.layer(patch, &sights.control, layer, head.as_ref(), fogged);
        }
        Vec::new()
    }

    /// Where the patch's rays meet fog that is seen; `None` if nowhere.
    fn reach(&self, patch: &Patch, control: &Sight) -> Option<Reach> {
        let beta = self.context.field.homogeneous.beta as f32;
        let longest = patch.members.last().map_or(0.0, |ray| ray.length(self.block));
        // What is the same everywhere hides the rest of a long ray by itself.
        let longest = if beta > 0.0 { longest.min(OPAQUE as f32 / beta) } else { longest };
        let dense = control.met.span(longest);
        let span = if beta == 0.0 { dense } else { Some((0.0, longest)) };
        let (from, to) = span.filter(|span| span.0 < span.1)?;
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
        let end = |ray: &Ray| ray.length(self.block).min(to);
        let reached = patch.members.partition_point(|ray| ray.length(self.block) <= from);
        let thin = dense.map_or(0.0, |(begin, end)| THIN * (end - begin));
        let share = Tolerance::new(self.context).layer;
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

    /// Where nothing behind is seen any more: among the blobs, else behind them, where only
    /// homogeneous fog is left.
    fn opaque_from(&self, sight: &Sight, from: f32, to: f32, dense: Option<(f32, f32)>) -> f32 {
        let Some((_, end)) = dense.filter(|_| sight.met.most(to) >= OPAQUE as f32) else {
            return to;
        };
        let part = (end - from) / PROBES as f32;
        let t: [f32; PROBES] = std::array::from_fn(|i| (i as f32 + 1.0).mul_add(part, from));
        let depth = sight.met.profile(self.context, &pairs(&t)).depth;
        let thinnest = |at: usize| of_place(&depth, at).into_iter().fold(f32::INFINITY, f32::min);
        if let Some(opaque) = (0..PROBES).find(|at| thinnest(*at) > OPAQUE as f32) {
            return t[opaque];
        }
        let beta = self.context.field.homogeneous.beta as f32;
        to.min(end + (OPAQUE as f32 - thinnest(PROBES - 1)) / beta)
    }

    /// Adds the light's airlight to the rays of a layer.
    fn layer(
        &self,
        patch: &Patch,
        control: &Sight,
        layer: &Layer,
        head: Option<&Head>,
        fogged: &mut [Fogged],
    ) {
        let has_tail = layer.last - layer.first > 1e-5 * (layer.last - layer.from);
        let tail = has_tail.then(|| self.tail(control, layer.first, layer.last));
        let flat = || {
            let depth = control.met.profile(self.context, &pairs(&[layer.last])).depth;
            [surface(of_place(&depth, 0)), [0.0; CONTROL], [0.0; CONTROL], [0.0; CONTROL]]
        };
        let depth = self.sets_depth.then(|| tail.as_ref().map_or_else(flat, |tail| tail.depth));
        let sums = Sums { layer, head, tail: tail.as_ref(), depth };
        dispatch!(self.context.level, simd => self.add(simd, patch, &sums, fogged));
    }

    fn fields(&self, sight: &Sight, t: &[Each]) -> Fields {
        let Profile { mut log_beta, depth } = sight.met.profile(self.context, t);
        for (log, depth) in log_beta.iter_mut().zip(&depth) {
            for (log, depth) in log.iter_mut().zip(depth) {
                *log -= depth.min(2.0 * OPAQUE as f32);
            }
        }
        let mean = sight.rays.toward_light(self.context, self.lamp, t);
        Fields { log: log_beta, mean, depth }
    }

    fn head(&self, sight: &Sight, nodes: &Nodes) -> Head {
        let t = nodes.t.as_flattened();
        let Fields { log, mean, depth } = self.fields(sight, &pairs(t));
        let last = t.len() - 1;
        let node = |(j, log_weight): (usize, &f32)| {
            let log = of_place(&log, j).map(|log| log + log_weight);
            let (most, log) = (most(&log), surface(log));
            Node { t: t[j], log, log_weight: *log_weight, most, mean: surface(of_place(&mean, j)) }
        };
        Head {
            nodes: nodes.log_weight.as_flattened().iter().enumerate().map(node).collect(),
            depth: surface(of_place(&depth, last)),
        }
    }

    fn tail(&self, sight: &Sight, from: f32, to: f32) -> Tail {
        let range = to - from;
        let t = CHEBYSHEV.map(|x| range.mul_add(x, from));
        let Fields { log, mean, depth } = self.fields(sight, &pairs(&t));
        let along = |rows: &[Each]| cubic(std::array::from_fn(|i| of_place(rows, i))).map(surface);
        let most = (0..TAIL).map(|i| most(&of_place(&log, i))).fold(f32::NEG_INFINITY, f32::max);
        Tail { from, range, log: along(&log), most, mean: along(&mean), depth: along(&depth) }
    }

    /// Sums at the pixels of a layer.
    #[inline(always)]
    fn add<S: Simd>(&self, simd: S, patch: &Patch, sums: &Sums, fogged: &mut [Fogged]) {
        let one = Lanes::splat(simd, 1.0);
        let (middle, half) = (patch.middle(), patch.half());
        let rgb = self.lamp.scattered.as_vec3();
        for members in sums.layer.members.chunks(Lanes::<S>::COUNT) {
            let gathered = self.gather(members);
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
            let light = Light::new(
                self.context.phase,
                V3::lit(one, self.lamp.from_camera) - offset,
                direction,
            );
            let mut sum = one.lit(0.0);
            if let Some(head) = sums.head {
                sum += pixels::head(simd, head, &terms, &light);
            }
            let end = length.min(Lanes::splat(simd, sums.layer.last));
            if let Some(tail) = sums.tail {
                sum += pixels::tail(simd, tail, &terms, &light, end);
            }
            let mut values = [0.0; PADDED];
            sum.store(&mut values);
            for (value, ray) in values.iter().zip(members) {
                let (rows, at) = (&mut fogged[ray.batch()].airlight, ray.at());
                rows[0][at] += value * rgb.x;
                rows[1][at] += value * rgb.y;
                rows[2][at] += value * rgb.z;
            }
            let Some(depth) = &sums.depth else { continue };
            let Layer { first, last, .. } = sums.layer;
            pixels::depth(simd, depth, &terms, (*first, last - first), end).store(&mut values);
            for (value, ray) in values.iter().zip(members) {
                fogged[ray.batch()].depth[ray.at()] = *value;
            }
        }
    }

    /// Place in the picture, direction, start and length of a few rays; the last one repeated.
    fn gather(&self, members: &[Ray]) -> [[f32; PADDED]; 9] {
        let mut rows = [[0.0; PADDED]; 9];
        for lane in 0..PADDED {
            let ray = members[lane.min(members.len() - 1)];
            let (Ends { rays, hits }, at) = (&self.block[ray.batch()], ray.at());
            [rows[0][lane], rows[1][lane]] = self.places.get(ray).to_array();
            for k in 0..3 {
                rows[2 + k][lane] = rays.direction[k][at];
                rows[5 + k][lane] = rays.offset[k][at];
            }
            rows[8][lane] = hits.length[at];
        }
        rows
    }
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
