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
mod pixels;
mod table;

use super::batch::Rows;
use super::blobs::Purpose;
use super::fog::{Ends, blobs_on_view};
use super::frame::{Context, Lamp};
use crate::airlight::mapped::{Map, NODES, OPAQUE, PROBES, Probes, Rule};
use crate::num::{Lanes, Num};
use crate::vector::V3;
use control::{CONTROL, Control, Each, PADDED, Profile};
use fearless_simd::{Simd, dispatch};
use patch::{Patch, Places, Ray, SMALLEST, Surroundings, Tolerance};
use pixels::{Head, Light, TAIL, Tail, Terms, at, surface};
pub use table::LightTable;

/// Where quadratics are compared with what they stand for: neither even nor odd errors vanish here.
const CHECK: [f32; 2] = [0.55, 0.45];
/// Optical depth of a ray that is as good as clear.
const UNSEEN: f32 = 1e-4;
/// A patch of many layers is split if it is larger than this [px].
const LEAST_LAYERED: f32 = 8.0;
/// A layer is at least this share of the blobs' extent.
const THIN: f32 = 0.02;

/// Adds the airlight of every light along the rays of some batches that stand together.
pub fn add_airlight(context: &Context, block: &[Ends<'_>], airlight: &mut [&mut Rows]) {
    let places = Places::new(context, block);
    let blobs = control::unpack(&blobs_on_view(context, block, Purpose::Nodes));
    for lamp in &context.lamps {
        let mut patches = vec![Patch::whole(block, &places)];
        while let Some(patch) = patches.pop() {
            let around = Surroundings::new(context, &blobs, &patch);
            let pass = Pass { context, blobs: &around.blobs, block, lamp, places: &places };
            let parts = patch::split(context, lamp, &around, &places, &patch)
                .or_else(|| pass.light(&patch, airlight));
            patches.extend(parts.into_iter().flatten());
        }
    }
}

/// Rays before one light.
struct Pass<'a> {
    context: &'a Context<'a>,
    blobs: &'a [control::Blob],
    block: &'a [Ends<'a>],
    lamp: &'a Lamp,
    places: &'a Places,
}

/// Rays that end between two ray parameters [m], as a part of a patch.
struct Layer<'a> {
    from: f32,
    first: f32,
    last: f32,
    members: &'a [Ray],
}

impl Pass<'_> {
    /// Adds the light's airlight to the rays of a patch; its parts, if they end too differently.
    fn light(&self, patch: &Patch, airlight: &mut [&mut Rows]) -> Option<Vec<Patch>> {
        let length = |ray: &Ray| self.block[ray.batch()].hits.length[ray.at()];
        let longest = patch.members.iter().map(length).fold(0.0, f32::max);
        let control = Control::around(self.context, patch);
        let clear = self.context.field.homogeneous.beta == 0.0;
        let dense = control.span(self.blobs, longest);
        let span = if clear { dense } else { Some((0.0, longest)) };
        let (from, to) = span.filter(|span| span.0 < span.1)?;
        let to = self.opaque_from(&control, from, to);
        let mut members = patch.members.clone();
        members.retain(|at| length(at) > from);
        members.sort_unstable_by(|a, b| length(a).total_cmp(&length(b)));
        let thin = dense.map_or(0.0, |(begin, end)| THIN * (end - begin));
        let tolerance = Tolerance::new(self.context.view.quality);
        let mut layers = Vec::new();
        let mut rest = members.as_slice();
        while let Some(nearest) = rest.first() {
            let first = length(nearest).min(to);
            let reach = first + (tolerance.layer * (first - from)).max(thin);
            let count = rest.partition_point(|at| length(at).min(to) <= reach);
            let (members, behind) = rest.split_at(count);
            let last = members.last().map_or(first, |at| length(at).min(to));
            layers.push(Layer { from, first, last, members });
            rest = behind;
        }
        if layers.len() > tolerance.layers && patch.size() > LEAST_LAYERED {
            return Some(patch.quarters(self.places));
        }
        let heads: Vec<_> = layers
            .iter()
            .map(|layer| {
                let seen = layer.first - layer.from > 1e-6 * layer.first;
                seen.then(|| self.head(patch, &control, dense, layer.from, layer.first))
            })
            .collect();
        let rough = |head: &Head| self.is_rough(patch, head);
        if patch.size() > SMALLEST && heads.iter().flatten().any(rough) {
            return Some(patch.quarters(self.places));
        }
        for (layer, head) in layers.iter().zip(&heads) {
            self.layer(patch, &control, layer, head.as_ref(), airlight);
        }
        None
    }

    /// Whether quadratics miss the fields so much that it shows, at a place where all their errors
    /// do.
    fn is_rough(&self, patch: &Patch, head: &Head) -> bool {
        let context = self.context;
        let check = Control::within(context, patch, CHECK);
        let mut t = [[head.t[NODES - 1]; PADDED]; NODES.div_ceil(PADDED)];
        (0..NODES).for_each(|j| t[j / PADDED][j % PADDED] = head.t[j]);
        let Profile { log_beta, depth } = check.profile(context, self.blobs, &t);
        if depth[(NODES - 1) / PADDED][(NODES - 1) % PADDED] < UNSEEN {
            return false;
        }
        let mean = check.toward_light(context, self.lamp, &t);
        let [x, y] = CHECK;
        let light = check.light(self.lamp, head.t[NODES - 1]);
        let (mut exact, mut off) = (0.0f64, 0.0f64);
        for j in 0..NODES {
            let (row, lane) = (j / PADDED, j % PADDED);
            let distance = (f64::from(head.t[j]) - light.closest).hypot(light.miss);
            let value = |log: f32, mean: f32| {
                (f64::from(log) - f64::from(mean) * distance).exp() / (distance * distance)
            };
            let log = log_beta[row][lane] - depth[row][lane] + head.log_weight[j];
            let is = value(log, mean[row][lane]);
            exact += is;
            off += value(at(&head.log[j], x, y), at(&head.mean[j], x, y)) - is;
        }
        off.abs() > Tolerance::new(context.view.quality).rough * exact
    }

    /// Where nothing behind is seen any more.
    fn opaque_from(&self, control: &Control, from: f32, to: f32) -> f32 {
        let beta = self.context.field.homogeneous.beta as f32;
        let most = beta * to + self.blobs.iter().map(|blob| 2.0 * blob.k).sum::<f32>();
        if most < OPAQUE as f32 {
            return to;
        }
        let part = (to - from) / PROBES as f32;
        let t: [Each; PROBES] =
            std::array::from_fn(|i| [(i as f32 + 1.0).mul_add(part, from); PADDED]);
        let depth = control.profile(self.context, self.blobs, &t).depth;
        let thinnest =
            |depth: &Each| depth[..CONTROL].iter().copied().fold(f32::INFINITY, f32::min);
        let opaque = depth.iter().position(|depth| thinnest(depth) > OPAQUE as f32);
        opaque.map_or(to, |at| t[at][0])
    }

    /// Adds the light's airlight to the rays of a layer.
    fn layer(
        &self,
        patch: &Patch,
        control: &Control,
        layer: &Layer,
        head: Option<&Head>,
        airlight: &mut [&mut Rows],
    ) {
        let tail = (layer.last - layer.first > 1e-5 * (layer.last - layer.from))
            .then(|| self.tail(control, layer.first, layer.last));
        dispatch!(self.context.level, simd => {
            self.add(simd, patch, layer, head, tail.as_ref(), airlight);
        });
    }

    /// The nodes for what lies between two ray parameters, placed for the patch's middle.
    fn rule(&self, patch: &Patch, dense: Option<(f64, f64)>, from: f64, to: f64) -> Rule {
        let context = self.context;
        let center = Control::within(context, patch, [0.0; 2]);
        let to_light = center.light(self.lamp, to as f32);
        let probes = Probes::new(from, to, dense, &to_light);
        let (at, t) = (&probes.at, spread(&probes.at));
        let Profile { log_beta, depth } = center.profile(context, self.blobs, &t);
        let mean = center.toward_light(context, self.lamp, &t);
        let (log_beta, depth, mean) = (flatten(&log_beta), flatten(&depth), flatten(&mean));
        let seen = std::array::from_fn(|i| {
            let distance = (at[i] - to_light.closest).hypot(to_light.miss);
            let log = f64::from(log_beta[i] - depth[i]) - f64::from(mean[i]) * distance;
            let phase = context.phase.value((to_light.closest - at[i]) / distance);
            (0.5 * log).exp() * phase.sqrt()
        });
        Map::new(context.phase, from, to, to_light, &probes, &seen).rule()
    }

    fn head(
        &self,
        patch: &Patch,
        control: &Control,
        dense: Option<(f32, f32)>,
        from: f32,
        to: f32,
    ) -> Head {
        let dense = dense.map(|(a, b)| (f64::from(a), f64::from(b)));
        let rule = self.rule(patch, dense, f64::from(from), f64::from(to));
        let t = rule.t.map(|t| [t as f32; 16]);
        let Profile { log_beta, depth } = control.profile(self.context, self.blobs, &t);
        let mean = control.toward_light(self.context, self.lamp, &t);
        let mut head = Head {
            t: rule.t.map(|t| t as f32),
            log: [[0.0; CONTROL]; NODES],
            log_weight: [0.0; NODES],
            most: [f32::NEG_INFINITY; NODES],
            mean: [[0.0; CONTROL]; NODES],
        };
        for j in 0..NODES {
            let weight = (rule.weight[j] as f32).max(f32::MIN_POSITIVE).ln();
            let log = seen(&log_beta[j], &depth[j], weight);
            head.log_weight[j] = weight;
            head.most[j] = most(&log);
            head.log[j] = surface(&log);
            head.mean[j] = surface(&mean[j]);
        }
        head
    }

    fn tail(&self, control: &Control, from: f32, to: f32) -> Tail {
        let range = to - from;
        let t: Vec<Each> = CHEBYSHEV.iter().map(|x| [range.mul_add(*x, from); 16]).collect();
        let Profile { log_beta, depth } = control.profile(self.context, self.blobs, &t);
        let mean = control.toward_light(self.context, self.lamp, &t);
        let log: [Each; TAIL] = std::array::from_fn(|i| seen(&log_beta[i], &depth[i], 0.0));
        Tail {
            from,
            range,
            most: log.iter().map(most).fold(f32::NEG_INFINITY, f32::max),
            log: cubic(&log).map(|row| surface(&row)),
            mean: cubic(&[mean[0], mean[1], mean[2], mean[3]]).map(|row| surface(&row)),
        }
    }

    /// Sums at the pixels of a layer.
    #[inline(always)]
    fn add<S: Simd>(
        &self,
        simd: S,
        patch: &Patch,
        layer: &Layer,
        head: Option<&Head>,
        tail: Option<&Tail>,
        airlight: &mut [&mut Rows],
    ) {
        let one = Lanes::splat(simd, 1.0);
        let (middle, half) = (patch.middle(), patch.half());
        let rgb = self.lamp.scattered.as_vec3();
        for members in layer.members.chunks(Lanes::<S>::COUNT) {
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
                length,
            );
            let mut sum = one.lit(0.0);
            if let Some(head) = head {
                sum += pixels::head(simd, head, &terms, &light);
            }
            if let Some(tail) = tail {
                let end = length.min(Lanes::splat(simd, layer.last));
                sum += pixels::tail(simd, tail, &terms, &light, end);
            }
            let mut values = [0.0; 16];
            sum.store(&mut values);
            for (value, ray) in values.iter().zip(members) {
                let (rows, at) = (&mut *airlight[ray.batch()], ray.at());
                rows[0][at] += value * rgb.x;
                rows[1][at] += value * rgb.y;
                rows[2][at] += value * rgb.z;
            }
        }
    }

    /// Place in the picture, direction, start and length of a few rays; the last one repeated.
    fn gather(&self, members: &[Ray]) -> [[f32; 16]; 9] {
        let mut rows = [[0.0; 16]; 9];
        for lane in 0..16 {
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

/// ln(weight · β) − T on the control rays. Behind what is opaque its size does not matter.
fn seen(log_beta: &Each, depth: &Each, weight: f32) -> Each {
    std::array::from_fn(|c| weight + log_beta[c] - depth[c].min(2.0 * OPAQUE as f32))
}

/// The largest of the control rays' values, and room for what lies between them.
fn most(log: &Each) -> f32 {
    log[..CONTROL].iter().copied().fold(f32::NEG_INFINITY, f32::max) + 0.5
}

/// Numbers along one ray, in full rows.
fn spread(t: &[f64; PROBES]) -> Vec<Each> {
    let row = |t: &[f64]| std::array::from_fn(|c| t[c] as f32);
    t.chunks(PADDED).map(row).collect()
}

fn flatten(rows: &[Each]) -> [f32; PROBES] {
    std::array::from_fn(|i| rows[i / PADDED][i % PADDED])
}

/// Where a tail's fields are evaluated: Chebyshev's abscissae on [0, 1].
const CHEBYSHEV: [f32; TAIL] = [0.038_060_233, 0.308_658_28, 0.691_341_7, 0.961_939_75];

/// Coefficients of the cubic through values at [`CHEBYSHEV`], control ray by control ray.
fn cubic(values: &[Each; TAIL]) -> [Each; TAIL] {
    let mut coefficients = [[0.0; 16]; TAIL];
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
