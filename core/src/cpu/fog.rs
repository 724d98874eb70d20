//! Optical depth and airlight of a batch of rays.

use crate::airlight::fogshop2007::{self, LightRow, add_airlight};
use crate::airlight::{Method, Path, march, reference, sun2005};
use crate::frame::context::{Context, Lamp};
use crate::geometry::Ray;
use crate::geometry::batch::{Ends, Fogged, Hits, Rays, Rows, SIZE, get3, load3};
use crate::geometry::bundle::Bundle;
use crate::media::gaussians::BlobList;
use crate::media::{Near, Purpose, Sum};
use crate::num::{Lanes, Num};
use crate::vector::V3;
use fearless_simd::{Simd, dispatch};
use glam::{DVec3, Vec3};

/// What the fog does along a batch, as far as the layer shows it; but for an airlight that
/// interpolates across the picture, which is formed for several batches at once.
pub fn batch(context: &Context, rays: &Rays, hits: &Hits) -> Fogged {
    if context.shows_fog() {
        along(context, rays, hits, context.shows_airlight())
    } else {
        Fogged::clear()
    }
}

/// Optical depth, and airlight if `lit`, along rays that end at `hits`, as far as the job goes; what
/// interpolates across the picture is added by [`mapped::add`](super::mapped::add).
fn along(context: &Context, rays: &Rays, hits: &Hits, lit: bool) -> Fogged {
    let mut fogged = Fogged::clear();
    let Context { job, field, .. } = context;
    if field.is_empty() || job.progress.is_over() {
        return fogged;
    }
    let parallel = context.viewpoint.parallel;
    if lit && context.interpolates() {
        let haze = field.smooth(context.viewpoint.position);
        haze.add_depth(job, rays, parallel, &hits.length, &mut fogged.depth);
        return fogged;
    }
    let method = if lit { context.method } else { Method::None };
    if method == Method::Fogshop2007 {
        published(context, rays, hits, &mut fogged);
        return fogged;
    }
    let near = near_views(context, &[Ends { rays, hits }], Purpose::Depth);
    near.add_depth(job, rays, parallel, &hits.length, &mut fogged.depth);
    match method {
        Method::Sun2005 => add_homogeneous(context, rays, hits, |_| 1.0, &mut fogged.airlight),
        Method::Reference | Method::March(_) => {
            add_ray_by_ray(context, rays, hits, &mut fogged.airlight);
        }
        Method::None | Method::Mapped | Method::Fogshop2007 => {}
    }
    fogged
}

/// Optical depth, and airlight as published.
fn published(context: &Context, rays: &Rays, hits: &Hits, fogged: &mut Fogged) {
    let haze = fogshop2007::haze(context.field) as f32;
    fogged.depth = hits.length.map(|length| length * haze);
    let factor = |light: usize| context.lit_blobs[light].homogeneous_factor;
    add_homogeneous(context, rays, hits, factor, &mut fogged.airlight);
    let gaussians = &context.field.media().gaussians;
    if gaussians.all().is_empty() {
        return;
    }
    let (bundle, shortest) = bundle_of_views(context, &[Ends { rays, hits }]);
    let search = context.field.search_for(gaussians, bundle, shortest, Purpose::Airlight);
    let list = BlobList::new(context.job.level, gaussians, &search);
    add_blobs(context, &list, rays, hits, fogged);
}

/// What matters of the fog to some batches of view rays.
pub fn near_views(context: &Context, block: &[Ends<'_>], purpose: Purpose) -> Sum<dyn Near> {
    let (bundle, shortest) = bundle_of_views(context, block);
    context.field.near(context.job.level, bundle, shortest, purpose)
}

/// Bounds some batches of view rays; and the shortest of them.
fn bundle_of_views(context: &Context, block: &[Ends<'_>]) -> (Bundle, f64) {
    let position = context.viewpoint.position;
    let lengths = || block.iter().flat_map(|ends| &ends.hits.length[..ends.rays.count]).copied();
    let shortest = f64::from(lengths().fold(f32::INFINITY, f32::min));
    let longest = f64::from(lengths().fold(0.0, f32::max));
    // Rays that spread too far for any bound: a picture of a few pixels under a wide angle.
    match bundle(position, block, longest) {
        Some(bundle) => (bundle, shortest),
        None => (Bundle::all_around(position, longest), 0.0),
    }
}

/// Bounds view rays around the camera: in f32, by chords, which keep the digits of small angles.
fn bundle(position: DVec3, block: &[Ends<'_>], longest: f64) -> Option<Bundle> {
    let places = || block.iter().flat_map(|ends| (0..ends.rays.count).map(|at| (ends.rays, at)));
    let direction = |(rays, at): (&Rays, usize)| get3(&rays.direction, at);
    let axis = places().map(direction).sum::<Vec3>().normalize();
    let largest = |values: &mut dyn Iterator<Item = f32>| f64::from(values.fold(0.0, f32::max));
    let chord2 = largest(&mut places().map(|place| direction(place).distance_squared(axis)));
    let radius2 = largest(&mut places().map(|(rays, at)| get3(&rays.offset, at).length_squared()));
    let half = 0.5 * chord2.sqrt() + 1e-7;
    let cos = 1.0 - 2.0 * half * half;
    if cos < 0.17 {
        return None;
    }
    let tan = (1.0 - cos * cos).sqrt() / cos;
    let radius = radius2.sqrt() * 1.000_001;
    let axis = axis.as_dvec3().normalize();
    Some(Bundle { origin: position, axis, radius, tan, length: longest + radius })
}

fn add_homogeneous(
    context: &Context,
    rays: &Rays,
    hits: &Hits,
    factor: impl Fn(usize) -> f64,
    airlight: &mut Rows,
) {
    if fogshop2007::haze(context.field) == 0.0 {
        return;
    }
    for (i, lamp) in context.lamps.iter().enumerate() {
        let intensity = (factor(i) * lamp.scattered).as_vec3();
        dispatch!(context.job.level, simd => {
            add_sun(simd, context, lamp, intensity, (rays, hits), airlight);
        });
    }
}

#[inline(always)]
fn add_sun<S: Simd>(
    simd: S,
    context: &Context,
    lamp: &Lamp,
    intensity: Vec3,
    (rays, hits): (&Rays, &Hits),
    airlight: &mut Rows,
) {
    let one = Lanes::splat(simd, 1.0);
    let beta = one.lit(fogshop2007::haze(context.field));
    for at in (0..rays.count).step_by(Lanes::<S>::COUNT) {
        let direction = load3(simd, &rays.direction, at);
        let light = V3::lit(one, lamp.from_camera) - load3(simd, &rays.offset, at);
        let length = Lanes::load(simd, &hits.length[at..]);
        let value = sun2005::airlight(beta, light, direction, length);
        accumulate(simd, value, intensity, airlight, at);
    }
}

#[inline(always)]
fn accumulate<S: Simd>(simd: S, value: Lanes<S>, rgb: Vec3, rows: &mut Rows, at: usize) {
    for (k, row) in rows.iter_mut().enumerate() {
        let sum = value.mul_add(Lanes::splat(simd, rgb[k]), Lanes::load(simd, &row[at..]));
        sum.store(&mut row[at..]);
    }
}

fn add_blobs(context: &Context, list: &BlobList, rays: &Rays, hits: &Hits, fogged: &mut Fogged) {
    let pairs = context.lamps.iter().zip(&context.lit_blobs);
    let lights: Vec<_> = pairs
        .map(|(lamp, lit)| LightRow {
            scattered: (lamp.scattered / (4.0 * std::f64::consts::PI)).as_vec3().to_array(),
            distance: lamp.from_camera.length() as f32,
            blobs: &lit.blobs,
            position: lamp.from_camera,
            exponents: &lit.exponents,
        })
        .collect();
    let (length, parallel) = (&hits.length, context.viewpoint.parallel);
    list.in_parts(lights.len(), context.job.progress, |list| {
        dispatch!(context.job.level, simd => if parallel {
            add_airlight::<_, true>(simd, list, &lights, rays, length, fogged);
        } else {
            add_airlight::<_, false>(simd, list, &lights, rays, length, fogged);
        });
    });
}

/// In f64.
fn add_ray_by_ray(context: &Context, rays: &Rays, hits: &Hits, airlight: &mut Rows) {
    for at in 0..rays.count.min(SIZE) {
        if context.job.progress.is_over() {
            return;
        }
        let origin = context.viewpoint.position + get3(&rays.offset, at).as_dvec3();
        let direction = get3(&rays.direction, at).as_dvec3().normalize();
        let ray = Ray { origin, direction };
        let length = f64::from(hits.length[at]);
        for lamp in &context.lamps {
            let (field, phase, light) = (context.field, context.phase, lamp.position);
            let path = Path::new(field, light, ray, length).of(context.job.progress);
            let unit = match context.method {
                Method::March(steps) => march::airlight_along(&path, phase, steps),
                _ => reference::airlight_along(&path, phase),
            };
            let radiance = (unit * lamp.scattered).as_vec3();
            airlight.iter_mut().enumerate().for_each(|(k, row)| row[at] += radiance[k]);
        }
    }
}
