//! Optical depth and airlight of a batch of rays.

use super::lit::Lit;
use super::noise::bend;
use super::sky;
use super::views::{bundle_of_views, near_views};
use crate::airlight::fogshop2007::{self, LightRow, add_airlight};
use crate::airlight::{Method, Path, macklin2010, march, reference, sun2005};
use crate::frame::context::{Context, Lamp, Scatter};
use crate::geometry::batch::{Ends, Fogged, Hits, Rays, Row, SIZE, load3};
use crate::light::{Crossed, Source, ToLight};
use crate::media::gaussians::BlobList;
use crate::media::{Medium, Purpose};
use crate::num::{Lanes, Num};
use fearless_simd::{Simd, dispatch};

/// Parts of a ray of which a closed form is summed up where surfaces hide some of the light.
const PARTS: usize = 24;

/// What the fog does along a batch, as far as the layer shows it; but for an airlight that
/// interpolates across the picture, which is formed for several batches at once.
pub fn batch(context: &Context, asked: &[usize], rays: &Rays, hits: &Hits) -> Fogged {
    if !context.shows_fog() {
        return Fogged::clear(0);
    }
    let mut fogged = along(context, asked, rays, hits);
    if let Some(noise) = context.noise.as_ref().filter(|_| !context.is_mapped()) {
        bend(context, noise, Ends { rays, hits }, &mut fogged);
    }
    fogged
}

/// Optical depth, and airlight if `lit`, along rays that end at `hits`, as far as the job goes; what
/// interpolates across the picture is added by [`mapped::add`](super::mapped::add).
fn along(context: &Context, asked: &[usize], rays: &Rays, hits: &Hits) -> Fogged {
    let mut fogged = Fogged::clear(asked.len());
    let Context { job, field, .. } = context;
    if field.is_empty() || job.progress.is_over() {
        return fogged;
    }
    let parallel = context.viewpoint.parallel;
    if context.interpolates() {
        let (bundle, shortest) = bundle_of_views(context, &[Ends { rays, hits }]);
        let haze = field.near_haze(job.level, bundle, shortest, Purpose::Sight);
        haze.add_depth(job, rays, parallel, &hits.length, &mut fogged.depth);
        return fogged;
    }
    let method = if context.shows_airlight() { context.method } else { Method::None };
    if method == Method::Fogshop2007 {
        published(context, asked, rays, hits, &mut fogged);
        sky::add_published(context, asked, (rays, hits), &mut fogged.airlight, &fogged.depth);
        return fogged;
    }
    let near = near_views(context, &[Ends { rays, hits }], context.purpose());
    near.add_depth(job, rays, parallel, &hits.length, &mut fogged.depth);
    match method {
        Method::Sun2005 | Method::Macklin2010 => {
            let factor = |scatter: &Scatter| sun2005::share(field, scatter.group);
            add_homogeneous(context, asked, (rays, hits), factor, &mut fogged);
            if method == Method::Macklin2010 {
                add_slabs(context, asked, rays, hits, &mut fogged.airlight);
            }
        }
        Method::Reference | Method::March(_) => {
            add_ray_by_ray(context, asked, rays, hits, &mut fogged.airlight);
        }
        Method::None | Method::Auto | Method::Fogshop2007 => {}
    }
    if matches!(context.asked, Method::Sun2005 | Method::Macklin2010) {
        sky::add_published(context, asked, (rays, hits), &mut fogged.airlight, &fogged.depth);
    }
    fogged
}

/// Optical depth, and airlight as published.
fn published(context: &Context, asked: &[usize], rays: &Rays, hits: &Hits, fogged: &mut Fogged) {
    // Skies, which come last, have no blobs' closed form.
    let lamps = asked.partition_point(|i| context.lamp_of(*i).of_sky.is_none());
    let asked = &asked[..lamps];
    let haze = fogshop2007::haze(context.field) as f32;
    fogged.depth = hits.length.map(|length| length * haze);
    let factor = |scatter: &Scatter| context.lit_blobs[scatter.lamp].homogeneous_factor;
    add_homogeneous(context, asked, (rays, hits), factor, fogged);
    let gaussians = &context.field.only().gaussians;
    if gaussians.all().is_empty() {
        return;
    }
    let (bundle, shortest) = bundle_of_views(context, &[Ends { rays, hits }]);
    let search = context.field.search_for(gaussians, bundle, shortest, Purpose::Airlight);
    let list = BlobList::new(context.job.level, gaussians, &search);
    add_blobs(context, asked, &list, (rays, hits), fogged);
}

fn add_homogeneous(
    context: &Context,
    asked: &[usize],
    (rays, hits): (&Rays, &Hits),
    factor: impl Fn(&Scatter) -> f64,
    fogged: &mut Fogged,
) {
    let beta = sun2005::haze(context.field);
    if beta == 0.0 {
        return;
    }
    for (i, row) in asked.iter().zip(&mut fogged.airlight) {
        let scatter = &context.scatters[*i];
        let lamp = &context.lamps[scatter.lamp];
        if lamp.of_sky.is_some() && context.asked != Method::Auto {
            continue;
        }
        let factor = factor(scatter);
        let is_thin = context.method == Method::Macklin2010;
        dispatch!(context.job.level, simd => if is_thin {
            add_closed::<_, true>(simd, (beta, factor), lamp, (rays, hits), row);
        } else {
            add_closed::<_, false>(simd, (beta, factor), lamp, (rays, hits), row);
        });
    }
}

/// Macklin's closed form if `THIN`, else Sun's.
#[inline(always)]
fn add_closed<S: Simd, const THIN: bool>(
    simd: S,
    (beta, factor): (f64, f64),
    lamp: &Lamp,
    (rays, hits): (&Rays, &Hits),
    row: &mut Row,
) {
    let one = Lanes::splat(simd, 1.0);
    let mut lit = lamp.shafts.as_deref().map(Lit::new);
    for at in (0..rays.count).step_by(Lanes::<S>::COUNT) {
        let (start, direction) = (load3(simd, &rays.offset, at), load3(simd, &rays.direction, at));
        let light = lamp.from_camera.beside(start, direction);
        let cone = lamp.from_camera.crossed(start, direction);
        let ends = [one.lit(0.0), Lanes::load(simd, &hits.length[at..])];
        if let Some(lit) = &mut lit {
            lit.see(simd, start, direction, &light, ends[1]);
        }
        let value = match lit.as_ref().filter(|lit| lit.is_hidden) {
            Some(lit) if lit.is_dark => one.lit(0.0),
            Some(lit) => {
                let fog = (one.lit(beta), lamp.source);
                in_parts::<S, THIN>(simd, lit, fog, &light, cone.as_ref(), ends)
            }
            None => within::<S, THIN>(one.lit(beta), lamp.source, light, cone.as_ref(), ends),
        };
        value.mul_add(one.lit(factor), Lanes::load(simd, &row[at..])).store(&mut row[at..]);
    }
}

/// Macklin's closed form if `THIN`, else Sun's, between two ray parameters.
#[inline(always)]
fn within<S: Simd, const THIN: bool>(
    beta: Lanes<S>,
    source: Source,
    light: ToLight<Lanes<S>>,
    cone: Option<&Crossed<Lanes<S>>>,
    ends: [Lanes<S>; 2],
) -> Lanes<S> {
    if THIN {
        macklin2010::within(beta, light, cone, ends)
    } else {
        sun2005::within(beta, source, light, cone, ends)
    }
}

/// The same where surfaces hide some of the light: part by part, even in the angle at a lamp or along the ray, each as
/// far as it is lit.
#[inline(always)]
fn in_parts<S: Simd, const THIN: bool>(
    simd: S,
    lit: &Lit,
    (beta, source): (Lanes<S>, Source),
    light: &ToLight<Lanes<S>>,
    cone: Option<&Crossed<Lanes<S>>>,
    [first, last]: [Lanes<S>; 2],
) -> Lanes<S> {
    let is_far = source.apex().is_none();
    let [begin, end] =
        if is_far { [first, last] } else { [light.angle_at(first), light.angle_at(last)] };
    let step = (end - begin) * beta.lit(1.0 / PARTS as f64);
    let (mut from, mut before) = (first, lit.look(simd, lit.place(simd, light, begin, first)));
    let mut sum = beta.lit(0.0);
    for part in 1..=PARTS {
        let angle = step.mul_add(beta.lit(part as f64), begin);
        let is_last = part == PARTS;
        let at = if is_far { angle } else { light.t_at(angle) };
        let to = if is_last { last } else { at.max(from).min(last) };
        let upto = lit.look(simd, lit.place(simd, light, angle, to));
        let share = upto.share_since(&before);
        if Lanes::<S>::any(share.lit(0.0).lt(share)) {
            sum += share * within::<S, THIN>(beta, source, *light, cone, [from, to]);
        }
        (from, before) = (to, upto);
    }
    sum
}

/// Airlight of all blobs as slabs, each in closed form (Macklin 2010).
fn add_slabs(context: &Context, asked: &[usize], rays: &Rays, hits: &Hits, airlight: &mut [Row]) {
    let (bundle, shortest) = bundle_of_views(context, &[Ends { rays, hits }]);
    for (group, media) in context.field.groups().iter().enumerate() {
        if media.gaussians.is_empty() {
            continue;
        }
        let search =
            context.field.search_for(&media.gaussians, bundle, shortest, Purpose::Airlight);
        let list = BlobList::new(context.job.level, &media.gaussians, &search);
        let parallel = context.viewpoint.parallel;
        list.in_parts(context.job.progress, |list| {
            for (i, row) in asked.iter().zip(airlight.iter_mut()) {
                let scatter = &context.scatters[*i];
                let lamp = &context.lamps[scatter.lamp];
                if scatter.group != group || lamp.of_sky.is_some() {
                    continue;
                }
                dispatch!(context.job.level, simd => if parallel {
                    add_slabs_of::<_, true>(simd, list, lamp, (rays, hits), row);
                } else {
                    add_slabs_of::<_, false>(simd, list, lamp, (rays, hits), row);
                });
            }
        });
    }
}

#[inline(always)]
fn add_slabs_of<S: Simd, const PARALLEL: bool>(
    simd: S,
    list: &BlobList,
    lamp: &Lamp,
    (rays, hits): (&Rays, &Hits),
    row: &mut Row,
) {
    let mut lit = lamp.shafts.as_deref().map(Lit::new);
    for at in (0..rays.count).step_by(Lanes::<S>::COUNT) {
        let direction = load3(simd, &rays.direction, at);
        let offset = load3(simd, &rays.offset, at);
        let light = lamp.from_camera.beside(offset, direction);
        let cone = lamp.from_camera.crossed(offset, direction);
        let length = Lanes::load(simd, &hits.length[at..]);
        if let Some(lit) = &mut lit {
            lit.see(simd, offset, direction, &light, length);
        }
        let mut sum = Lanes::load(simd, &row[at..]);
        for blob in list.each() {
            let slab = blob.seen::<S, PARALLEL>(simd, offset).slab(direction, length);
            let whole = macklin2010::within(slab.beta, light, cone.as_ref(), slab.ends);
            sum += match lit.as_ref().filter(|lit| lit.is_hidden) {
                Some(lit) => whole * lit.between(simd, &light, slab.ends),
                None => whole,
            };
        }
        sum.store(&mut row[at..]);
    }
}

fn add_blobs(
    context: &Context,
    asked: &[usize],
    list: &BlobList,
    (rays, hits): (&Rays, &Hits),
    fogged: &mut Fogged,
) {
    let light = |i: &usize| {
        let lamp = context.scatters[*i].lamp;
        let (lamp, lit) = (&context.lamps[lamp], &context.lit_blobs[lamp]);
        let source = lamp.from_camera;
        let distance = source.place().length() as f32;
        let (blobs, exponents) = (&lit.blobs, &lit.exponents);
        LightRow { source, reach: lamp.shafts.as_deref().map(Lit::new), distance, blobs, exponents }
    };
    let mut lights: Vec<_> = asked.iter().map(light).collect();
    let (length, parallel) = (&hits.length, context.viewpoint.parallel);
    list.in_parts(context.job.progress, |list| {
        dispatch!(context.job.level, simd => if parallel {
            add_airlight::<_, _, true>(simd, list, &mut lights, rays, length, fogged);
        } else {
            add_airlight::<_, _, false>(simd, list, &mut lights, rays, length, fogged);
        });
    });
}

/// In f64.
fn add_ray_by_ray(
    context: &Context,
    asked: &[usize],
    rays: &Rays,
    hits: &Hits,
    airlight: &mut [Row],
) {
    for at in 0..rays.count.min(SIZE) {
        if context.job.progress.is_over() {
            return;
        }
        let (ray, length) = sky::in_full(context, rays, hits, at);
        let mut ways = sky::Ways::default();
        for (i, row) in asked.iter().zip(airlight.iter_mut()) {
            let Scatter { lamp, group, phase, .. } = context.scatters[*i];
            let lamp = &context.lamps[lamp];
            if let Some(own) = &lamp.of_sky {
                row[at] += ways.airlight(context, (lamp, own), group, (ray, length)) as f32;
                continue;
            }
            let shadows = context.shadows(lamp, &ray, length);
            let path = Path::new(context.field, group, lamp.source, ray, length).shaded(&shadows);
            let path = path.of(context.job.progress);
            row[at] += match context.method {
                Method::March(steps) => march::airlight_along(&path, phase, steps),
                _ => reference::airlight_along(&path, phase),
            } as f32;
        }
    }
}
