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
use crate::airlight::ToLight;
use crate::airlight::mapped::{Map, NODES, OPAQUE, PROBES, Rule, probes};
use crate::num::{Lanes, Num};
use crate::vector::V3;
use control::{CONTROL, Control, Each, PADDED, Profile};
use fearless_simd::{Simd, dispatch};
use patch::{Patch, Places, Ray};
use pixels::{Head, Light, TAIL, Tail, Terms, surface};
pub use table::LightTable;

/// Rays of a layer end within this share of each other's way through the fog.
const LAYER: f32 = 0.12;
/// A layer is at least this share of the fog's extent.
const THIN: f32 = 0.02;

/// Adds the airlight of every light along the rays of some batches that stand together.
pub fn add_airlight(context: &Context, block: &[Ends<'_>], airlight: &mut [&mut Rows]) {
    let places = Places::new(context, block);
    let blobs = control::unpack(&blobs_on_view(context, block, Purpose::Nodes));
    for lamp in &context.lamps {
        let pass = Pass { context, blobs: &blobs, block, lamp, places: &places };
        let mut patches = vec![Patch::whole(block, &places)];
        while let Some(patch) = patches.pop() {
            match patch::split(context, lamp, &blobs, &places, &patch) {
                Some(parts) => patches.extend(parts),
                None => pass.light(&patch, airlight),
            }
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
    /// Adds the light's airlight to the rays of a patch.
    fn light(&self, patch: &Patch, airlight: &mut [&mut Rows]) {
        let length = |ray: &Ray| self.block[ray.batch()].hits.length[ray.at()];
        let longest = patch.members.iter().map(length).fold(0.0, f32::max);
        let control = Control::around(self.context, patch);
        let clear = self.context.field.homogeneous.beta == 0.0;
        let span = if clear { control.span(self.blobs, longest) } else { Some((0.0, longest)) };
        let Some((from, to)) = span.filter(|span| span.0 < span.1) else { return };
        let to = self.opaque_from(patch, from, to);
        let mut members = patch.members.clone();
        members.retain(|at| length(at) > from);
        members.sort_unstable_by(|a, b| length(a).total_cmp(&length(b)));
        let mut rest = members.as_slice();
        while let Some(nearest) = rest.first() {
            let first = length(nearest).min(to);
            let reach = first + (LAYER * (first - from)).max(THIN * (to - from));
            let count = rest.partition_point(|at| length(at).min(to) <= reach);
            let (members, behind) = rest.split_at(count);
            let last = members.last().map_or(first, |at| length(at).min(to));
            self.layer(patch, &control, &Layer { from, first, last, members }, airlight);
            rest = behind;
        }
    }

    /// Where nothing behind is seen any more.
    fn opaque_from(&self, patch: &Patch, from: f32, to: f32) -> f32 {
        let beta = self.context.field.homogeneous.beta as f32;
        let most = beta * to + self.blobs.iter().map(|blob| 2.0 * blob.k).sum::<f32>();
        if most < OPAQUE as f32 {
            return to;
        }
        let t = spread(&probes(f64::from(from), f64::from(to)));
        let center = Control::center(self.context, patch);
        let depth = flatten(&center.profile(self.context, self.blobs, &t).depth);
        let opaque = depth.iter().position(|depth| *depth > OPAQUE as f32);
        opaque.map_or(to, |at| t[at / PADDED][at % PADDED])
    }

    /// Adds the light's airlight to the rays of a layer.
    fn layer(&self, patch: &Patch, control: &Control, layer: &Layer, airlight: &mut [&mut Rows]) {
        let head = (layer.first - layer.from > 1e-6 * layer.first)
            .then(|| self.head(patch, control, layer.from, layer.first));
        let tail = (layer.last - layer.first > 1e-5 * (layer.last - layer.from))
            .then(|| self.tail(control, layer.first, layer.last));
        dispatch!(self.context.level, simd => {
            self.add(simd, patch, layer, head.as_ref(), tail.as_ref(), airlight);
        });
    }

    /// The nodes for what lies between two ray parameters, placed for the patch's middle.
    fn rule(&self, patch: &Patch, from: f64, to: f64) -> Rule {
        let context = self.context;
        let center = Control::center(context, patch);
        let t = spread(&probes(from, to));
        let Profile { log_beta, depth } = center.profile(context, self.blobs, &t);
        let mean = center.toward_light(context, self.lamp, &t);
        let (offset, direction) = context.viewpoint.ray(patch.middle().as_dvec2());
        let light = self.lamp.from_camera - offset;
        let to_light = ToLight::new(light.into(), direction.into(), to);
        let (log_beta, depth, mean) = (flatten(&log_beta), flatten(&depth), flatten(&mean));
        let at = probes(from, to);
        let seen = std::array::from_fn(|i| {
            let distance = (at[i] - to_light.closest).hypot(to_light.miss);
            let log = f64::from(log_beta[i] - depth[i]) - f64::from(mean[i]) * distance;
            let phase = context.phase.value((to_light.closest - at[i]) / distance);
            (0.5 * log).exp() * phase.sqrt()
        });
        Map::new(from, to, to_light, &seen).rule()
    }

    fn head(&self, patch: &Patch, control: &Control, from: f32, to: f32) -> Head {
        let rule = self.rule(patch, f64::from(from), f64::from(to));
        let t = rule.t.map(|t| [t as f32; 16]);
        let Profile { log_beta, depth } = control.profile(self.context, self.blobs, &t);
        let mean = control.toward_light(self.context, self.lamp, &t);
        let mut head = Head {
            t: rule.t.map(|t| t as f32),
            log: [[0.0; CONTROL]; NODES],
            most: [f32::NEG_INFINITY; NODES],
            mean: [[0.0; CONTROL]; NODES],
        };
        for j in 0..NODES {
            let weight = (rule.weight[j] as f32).max(f32::MIN_POSITIVE).ln();
            let log = seen(&log_beta[j], &depth[j], weight);
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
