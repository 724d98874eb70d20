//! Fields along the eight rays that stand for a patch.

use super::patch::Patch;
use super::table::LightTable;
use crate::airlight::{ENDS, ToLight};
use crate::cpu::batch::{Rays, SIZE, load3};
use crate::cpu::blobs::{BlobList, DENSE, Packed};
use crate::cpu::frame::{Context, Lamp};
use crate::cpu::kernels::{add_depth, splat3};
use crate::cpu::shade::blobs_between;
use crate::media::gaussians::{HALF_SQRT_PI, Line};
use crate::num::{Lanes, Num};
use fearless_simd::{Simd, dispatch};
use glam::{DVec3, Vec2, Vec3};

/// Rays that stand for a patch: its corners and the middles of its sides.
pub const CONTROL: usize = 8;
/// Numbers in a row: as many as the widest registers hold.
pub const PADDED: usize = 16;
/// One row: of eight rays at two places, or of one ray at sixteen.
pub type Each = [f32; PADDED];

/// Corners of the square [−1, 1]² and middles of its sides, in the order of control rays.
pub const PLACES: [[f32; 2]; CONTROL] = [
    [-1.0, -1.0],
    [1.0, -1.0],
    [-1.0, 1.0],
    [1.0, 1.0],
    [0.0, -1.0],
    [0.0, 1.0],
    [-1.0, 0.0],
    [1.0, 0.0],
];

/// A blob relative to the camera.
#[derive(Clone, Copy, Debug)]
pub struct Blob {
    /// a · (centre − camera).
    pub b: [f32; 3],
    /// Scale a [1/m].
    pub a: f32,
    /// Half depth.
    pub k: f32,
}

/// All blobs of a list.
pub fn unpack(list: &BlobList) -> Vec<Blob> {
    let packed = [&list.cut, &list.dense, &list.whole].into_iter().flatten();
    let packed = packed.map(|Packed { b, a, k, .. }| Blob { b: *b, a: *a, k: *k });
    let opaque = list.opaque.iter().map(|(_, seen)| Blob {
        b: [seen.b.x as f32, seen.b.y as f32, seen.b.z as f32],
        a: seen.a as f32,
        k: seen.k as f32,
    });
    packed.chain(opaque).collect()
}

/// Places in rows, for eight rays: two a row.
pub fn pairs(t: &[f32]) -> Vec<Each> {
    let row = |t: &[f32]| std::array::from_fn(|c| t[(c / CONTROL).min(t.len() - 1)]);
    t.chunks(PADDED / CONTROL).map(row).collect()
}

/// The values of eight rays at a place.
pub fn of_place(rows: &[Each], place: usize) -> [f32; CONTROL] {
    let row = &rows[place * CONTROL / PADDED];
    std::array::from_fn(|c| row[place * CONTROL % PADDED + c])
}

/// As many rays as a row holds numbers, relative to the camera: eight repeated, or others.
#[derive(Clone, Debug)]
pub struct Control {
    direction: [Each; 3],
    offset: [Each; 3],
}

/// What rays meet, row by row.
#[derive(Clone, Debug)]
pub struct Profile {
    /// ln β.
    pub log_beta: Vec<Each>,
    /// T from the camera.
    pub depth: Vec<Each>,
}

/// What airlight depends on, row by row.
#[derive(Clone, Debug)]
pub struct Fields {
    /// ln β − T; behind what is opaque its size does not matter.
    pub log: Vec<Each>,
    /// T(x, s)/d, the mean extinction towards the light [1/m].
    pub mean: Vec<Each>,
    /// T.
    pub depth: Vec<Each>,
}

impl Control {
    /// The rays around a patch.
    pub fn around(context: &Context, patch: &Patch) -> Self {
        let (middle, half) = (patch.middle(), patch.half());
        Self::new(context, |c| middle + half * Vec2::from(PLACES[c]))
    }

    /// One ray, repeated, through a place of the patch in [−1, 1]².
    pub fn within(context: &Context, patch: &Patch, place: [f32; 2]) -> Self {
        let place = patch.middle() + patch.half() * Vec2::from(place);
        Self::new(context, |_| place)
    }

    /// Where a light stands relative to the first of the rays, of that length.
    pub fn light(&self, lamp: &Lamp, length: f32) -> ToLight<f64> {
        let first = |rows: &[Each; 3]| rows.map(|row| f64::from(row[0])).into();
        let (offset, direction): (DVec3, DVec3) = (first(&self.offset), first(&self.direction));
        let light = lamp.from_camera - offset;
        ToLight::new(light.into(), direction.normalize().into(), f64::from(length))
    }

    fn empty() -> Self {
        let zero = [[0.0; PADDED]; 3];
        Self { direction: zero, offset: zero }
    }

    fn new(context: &Context, place: impl Fn(usize) -> Vec2) -> Self {
        let mut control = Self::empty();
        for c in 0..PADDED {
            let (offset, direction) = context.viewpoint.ray(place(c % CONTROL).as_dvec2());
            for k in 0..3 {
                control.direction[k][c] = direction[k] as f32;
                control.offset[k][c] = offset[k] as f32;
            }
        }
        control
    }

    /// Rays from another origin; blobs are relative to that then.
    pub fn from_directions(directions: &[DVec3]) -> Self {
        let mut control = Self::empty();
        for c in 0..PADDED {
            let direction = directions[c % directions.len()];
            (0..3).for_each(|k| control.direction[k][c] = direction[k] as f32);
        }
        control
    }

    /// The blobs' T at ray parameters `t`, ascending from row to row.
    pub fn depth(&self, context: &Context, blobs: &[Blob], t: &[Each]) -> Vec<Each> {
        let zero = vec![[0.0; PADDED]; t.len()];
        let mut profile = Profile { log_beta: zero.clone(), depth: zero };
        dispatch!(context.level, simd => {
            fill::<_, false>(simd, self, blobs, 0.0, t, &mut profile);
        });
        profile.depth
    }

    /// A point of one of the rays, relative to the camera.
    fn point(&self, c: usize, t: f32) -> Vec3 {
        Vec3::from_array([0, 1, 2].map(|k| self.direction[k][c].mul_add(t, self.offset[k][c])))
    }

    /// From where to where blobs are on the rays up to `length`; `None` if none is.
    pub fn span(&self, blobs: &[Blob], length: f32) -> Option<(f32, f32)> {
        let (mut from, mut to) = (f32::INFINITY, 0.0f32);
        let ray = |c: usize, rows: &[Each; 3]| Vec3::new(rows[0][c], rows[1][c], rows[2][c]);
        for blob in blobs {
            let reach = ENDS as f32 / blob.a;
            for c in 0..4 {
                let b = Vec3::from(blob.b) / blob.a - ray(c, &self.offset);
                let along = b.dot(ray(c, &self.direction));
                (from, to) = (from.min(along - reach), to.max(along + reach));
            }
        }
        let (from, to) = (from.max(0.0), to.min(length));
        (from < to).then_some((from, to))
    }

    /// β and T at ray parameters `t`, ascending from row to row.
    pub fn profile(&self, context: &Context, blobs: &[Blob], t: &[Each]) -> Profile {
        let zero = vec![[0.0; PADDED]; t.len()];
        let mut profile = Profile { log_beta: zero.clone(), depth: zero };
        let beta = context.field.homogeneous.beta as f32;
        let parallel = context.viewpoint.parallel;
        dispatch!(context.level, simd => if parallel {
            fill::<_, true>(simd, self, blobs, beta, t, &mut profile);
        } else {
            fill::<_, false>(simd, self, blobs, beta, t, &mut profile);
        });
        profile
    }

    /// T(x, s)/d at ray parameters `t`: the mean extinction towards a light.
    pub fn toward_light(&self, context: &Context, lamp: &Lamp, t: &[Each]) -> Vec<Each> {
        if let Some(table) = lamp.table.as_ref() {
            return self.look_up(context, lamp, table, t);
        }
        /// Points that share a list of blobs.
        const POINTS: usize = 64;
        let mut mean = Vec::with_capacity(t.len());
        for rows in t.chunks(POINTS / PADDED) {
            self.add_toward_light(context, lamp, rows, &mut mean);
        }
        mean
    }

    fn look_up(&self, context: &Context, lamp: &Lamp, table: &LightTable, t: &[Each]) -> Vec<Each> {
        let mut mean = vec![[0.0; PADDED]; t.len()];
        dispatch!(context.level, simd => {
            look_up(simd, self, context, lamp, table, t, &mut mean);
        });
        mean
    }

    fn add_toward_light(
        &self,
        context: &Context,
        lamp: &Lamp,
        rows: &[Each],
        mean: &mut Vec<Each>,
    ) {
        let light = lamp.from_camera.as_vec3();
        let (mut paths, mut length) = (Rays::empty(), [0.0f32; SIZE]);
        paths.count = rows.len() * PADDED;
        for (row, t) in rows.iter().enumerate() {
            for (c, t) in t.iter().enumerate() {
                let way = self.point(c, *t) - light;
                let at = row * PADDED + c;
                length[at] = way.length().max(f32::MIN_POSITIVE);
                let direction = way / length[at];
                (0..3).for_each(|k| paths.direction[k][at] = direction[k]);
            }
        }
        let mut depth = [0.0; SIZE];
        if !context.field.blobs.is_empty() {
            let list = blobs_between(context, lamp, &paths, &length, 0..paths.count);
            dispatch!(context.level, simd => {
                add_depth::<_, false>(simd, &list, &paths, &length, &mut depth);
            });
        }
        let beta = context.field.homogeneous.beta as f32;
        for row in 0..rows.len() {
            let at = row * PADDED;
            mean.push(std::array::from_fn(|c| beta + depth[at + c] / length[at + c]));
        }
    }
}

#[inline(always)]
fn look_up<S: Simd>(
    simd: S,
    control: &Control,
    context: &Context,
    lamp: &Lamp,
    table: &LightTable,
    t: &[Each],
    mean: &mut [Each],
) {
    let light = splat3(simd, lamp.from_camera.as_vec3().to_array());
    let beta = Lanes::splat(simd, context.field.homogeneous.beta as f32);
    for (mean, t) in mean.iter_mut().zip(t) {
        for at in (0..PADDED).step_by(Lanes::<S>::COUNT) {
            let start = load3(simd, &control.offset, at) - light;
            let way = start + load3(simd, &control.direction, at).scale(Lanes::load(simd, &t[at..]));
            (table.means(simd, way) + beta).store(&mut mean[at..]);
        }
    }
}

/// Sums β and T over blobs. erf and exp are formed only where a blob is; behind it its whole depth
/// is added once, to the first row there, and carried on at the end.
#[inline(always)]
fn fill<S: Simd, const PARALLEL: bool>(
    simd: S,
    control: &Control,
    blobs: &[Blob],
    beta: f32,
    t: &[Each],
    out: &mut Profile,
) {
    let mut behind = vec![[0.0f32; PADDED]; t.len() + 1];
    let ends: Vec<(f32, f32)> = t.iter().map(|row| bounds(row)).collect();
    for at in (0..PADDED).step_by(Lanes::<S>::COUNT) {
        let direction = load3(simd, &control.direction, at);
        let offset = load3(simd, &control.offset, at);
        for blob in blobs {
            let a = Lanes::splat(simd, blob.a);
            let center = splat3(simd, blob.b);
            let center = if PARALLEL { center - offset.scale(a) } else { center };
            let middle = center.dot(direction);
            let peak = (-center.cross(direction).length_squared()).exp();
            let density = peak * Lanes::splat(simd, blob.k);
            let core = density * Lanes::splat(simd, blob.a / HALF_SQRT_PI as f32);
            let (dense, begins) = (blob.k > DENSE, (-middle).erf());
            let (first, last) = span(simd, middle, blob.a);
            let begin = ends.partition_point(|end| end.1 < first);
            let end = begin + ends[begin..].partition_point(|end| end.0 <= last);
            for (j, t) in t.iter().enumerate().take(end).skip(begin) {
                let t = Lanes::load(simd, &t[at..]);
                let s = a.mul_add(t, -middle);
                let gathered = if dense {
                    let line = Line { start: -middle, end: s, miss2: s, peak: s };
                    line.between(a * t)
                } else {
                    s.erf() - begins
                };
                add(simd, density * gathered, &mut out.depth[j], at);
                add(simd, core * (-s.squared()).exp(), &mut out.log_beta[j], at);
            }
            let whole =
                if dense { Num::erf_difference(-middle, a.lit(1e4)) } else { a.lit(1.0) - begins };
            add(simd, density * whole, &mut behind[end], at);
        }
        let mut sum = Lanes::splat(simd, 0.0);
        let beta = Lanes::splat(simd, beta);
        for j in 0..t.len() {
            sum += Lanes::load(simd, &behind[j][at..]);
            let own = Lanes::load(simd, &out.depth[j][at..]) + sum;
            beta.mul_add(Lanes::load(simd, &t[j][at..]), own).store(&mut out.depth[j][at..]);
            let sum = Lanes::load(simd, &out.log_beta[j][at..]) + beta;
            sum.max(beta.lit(1e-30)).ln().store(&mut out.log_beta[j][at..]);
        }
    }
}

#[inline(always)]
fn add<S: Simd>(simd: S, value: Lanes<S>, row: &mut Each, at: usize) {
    (value + Lanes::load(simd, &row[at..])).store(&mut row[at..]);
}

/// Between which ray parameters a blob is, given its closest point in units of its radius.
#[inline(always)]
fn span<S: Simd>(_simd: S, middle: Lanes<S>, a: f32) -> (f32, f32) {
    let mut each = [0.0; PADDED];
    middle.store(&mut each);
    let (mut low, mut high) = (each[0], each[0]);
    for value in &each[1..Lanes::<S>::COUNT] {
        low = low.min(*value);
        high = high.max(*value);
    }
    ((low - ENDS as f32) / a, (high + ENDS as f32) / a)
}

fn bounds(row: &[f32]) -> (f32, f32) {
    row.iter().fold((f32::INFINITY, 0.0), |(low, high), t| (low.min(*t), high.max(*t)))
}
