//! The eight rays that stand for a patch, and the way from their points to a light.

use super::patch::Patch;
pub use crate::cpu::places::CONTROL;
use crate::cpu::places::PLACES;
use crate::cpu::shade::{Ways, from_beyond};
use crate::cpu::sky;
use crate::frame::context::{Context, Lamp};
use crate::frame::light_table::LightTable;
use crate::geometry::batch::{SIZE, load3};
use crate::geometry::control::{Control, Each, PADDED};
use crate::geometry::{Beyond, Origin};
use crate::light::{ToLight, sun};
use crate::media::Legs;
use crate::num::Lanes;
use crate::vector::V3;
use fearless_simd::{Simd, dispatch};
use glam::Vec2;

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

/// What airlight depends on, row by row.
#[derive(Clone, Debug)]
pub struct Fields {
    /// ln β − T, β of the group that scatters; behind what is opaque its size does not matter.
    pub log: Vec<Each>,
    /// β of all other groups; no rows if there are none.
    pub other_beta: Vec<Each>,
    /// T(x, s)/d, the mean extinction towards the light [1/m].
    pub mean: Vec<Each>,
    /// T.
    pub depth: Vec<Each>,
}

/// The rays around a patch.
pub fn around(context: &Context, patch: &Patch) -> Control {
    let (middle, half) = (patch.middle(), patch.half());
    through(context, |c| middle + half * Vec2::from(PLACES[c]))
}

/// One ray, repeated, through a place of the patch in [−1, 1]².
pub fn within(context: &Context, patch: &Patch, place: [f32; 2]) -> Control {
    let place = patch.middle() + patch.half() * Vec2::from(place);
    through(context, |_| place)
}

fn through(context: &Context, place: impl Fn(usize) -> Vec2) -> Control {
    Control::new(|c| context.viewpoint.ray(place(c % CONTROL).as_dvec2()))
}

/// Where a light stands relative to the first of some rays.
pub fn to_light(rays: &Control, lamp: &Lamp) -> ToLight<f64> {
    let (offset, direction) = rays.first();
    lamp.from_camera.beside(offset.into(), direction.into())
}

/// T(x, s)/d at ray parameters `t`: the mean extinction towards a light.
pub fn toward_light(context: &Context, lamp: &Lamp, rays: &Control, t: &[Each]) -> Vec<Each> {
    /// Points that share a list of lumps.
    const POINTS: usize = 64;
    let Context { job, field, .. } = context;
    if let Some(own) = &lamp.of_sky {
        return sky::toward(context, own, rays, t);
    }
    let apex = match lamp.from_camera.origin() {
        Origin::At(apex) => apex.as_vec3(),
        Origin::Beyond(beyond) => return toward_beyond(context, lamp, &beyond, rays, t),
    };
    let mut mean = vec![[0.0; PADDED]; t.len()];
    let haze = field.smooth(context.viewpoint.position, Legs::OfEyes);
    haze.add_mean(job.level, apex, rays, t, &mut mean);
    if let Some(table) = lamp.table.as_ref() {
        dispatch!(job.level, simd => {
            let apex = V3::splat(simd, apex.to_array());
            add_table(simd, rays, apex, table, t, &mut mean);
        });
    } else if field.lumps() > 0 {
        for (t, mean) in t.chunks(POINTS / PADDED).zip(mean.chunks_mut(POINTS / PADDED)) {
            add_lumps(context, lamp, rays, t, mean);
        }
    }
    mean
}

/// The same of a light as far away as the sun.
fn toward_beyond(
    context: &Context,
    lamp: &Lamp,
    beyond: &Beyond,
    rays: &Control,
    t: &[Each],
) -> Vec<Each> {
    let mut mean = vec![[0.0; PADDED]; t.len()];
    for (t, mean) in t.chunks(SIZE / PADDED).zip(mean.chunks_mut(SIZE / PADDED)) {
        let (points, mean) = (rays.points(t), mean.as_flattened_mut());
        let depth = from_beyond(context, lamp, beyond, &points, 0..mean.len(), true);
        let depths = mean.iter_mut().zip(depth);
        depths.for_each(|(mean, depth)| *mean = depth * (1.0 / sun::DISTANCE_M) as f32);
    }
    mean
}

fn add_lumps(context: &Context, lamp: &Lamp, rays: &Control, t: &[Each], mean: &mut [Each]) {
    let point = |at: usize| rays.point(at % PADDED, t.as_flattened()[at]);
    let ways = Ways::new(lamp, t.len() * PADDED, point);
    let mut depth = [0.0; SIZE];
    let near = ways.near(context, lamp.source.place(), 0..ways.rays.count);
    near.add_depth(&context.job, &ways.rays, false, &ways.length, &mut depth);
    for (at, mean) in mean.as_flattened_mut().iter_mut().enumerate() {
        *mean += depth[at] / ways.length[at];
    }
}

#[inline(always)]
fn add_table<S: Simd>(
    simd: S,
    rays: &Control,
    apex: V3<Lanes<S>>,
    table: &LightTable,
    t: &[Each],
    mean: &mut [Each],
) {
    for (mean, t) in mean.iter_mut().zip(t) {
        for at in (0..PADDED).step_by(Lanes::<S>::COUNT) {
            let start = load3(simd, &rays.offset, at) - apex;
            let way = start + load3(simd, &rays.direction, at).scale(Lanes::load(simd, &t[at..]));
            (table.means(simd, way) + Lanes::load(simd, &mean[at..])).store(&mut mean[at..]);
        }
    }
}
