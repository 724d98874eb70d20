//! Fields along the eight rays that stand for a patch.

use super::patch::Patch;
use super::table::LightTable;
use crate::airlight::ToLight;
use crate::cpu::batch::{Rays, SIZE, load3};
use crate::cpu::blobs::{BlobList, Packed};
use crate::cpu::frame::{Context, Lamp};
use crate::cpu::kernels::{add_depth, splat3};
use crate::cpu::shade::blobs_between;
use crate::num::Lanes;
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
    /// Unit directions.
    pub direction: [Each; 3],
    /// Where each starts [m].
    pub offset: [Each; 3],
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

    /// Where a light stands relative to the first of the rays.
    pub fn light(&self, lamp: &Lamp) -> ToLight<f64> {
        let first = |rows: &[Each; 3]| rows.map(|row| f64::from(row[0])).into();
        let (offset, direction): (DVec3, DVec3) = (first(&self.offset), first(&self.direction));
        let light = lamp.from_camera - offset;
        ToLight::new(light.into(), direction.normalize().into())
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

    /// A point of one of the rays, relative to the camera.
    fn point(&self, c: usize, t: f32) -> Vec3 {
        Vec3::from_array([0, 1, 2].map(|k| self.direction[k][c].mul_add(t, self.offset[k][c])))
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
            let way =
                start + load3(simd, &control.direction, at).scale(Lanes::load(simd, &t[at..]));
            (table.means(simd, way) + beta).store(&mut mean[at..]);
        }
    }
}
