//! What stands around the lights of a frame before any of its rays: kept while fog and lights stay.

use super::cache::Cache;
use super::context::{Context, Lamp};
use super::light_table::{self, Fineness, LightTable};
use super::shafts::{self, Shafts};
use super::skies;
use super::sky_table::{SkyTable, Summing};
use crate::airlight::Method;
use crate::airlight::fogshop2007::{self, LightSide, LitBlobs};
use crate::media::{Field, Moment};
use crate::progress::Interrupted;
use crate::request::Quality;
use crate::sky;
use std::sync::Arc;

/// Most places of a table, of a draft and in full.
const PLACES: [usize; 2] = [4 << 10, 64 << 10];
/// Bytes of all tables of a frame; and the places that each may have in any case.
const BYTES: usize = 128 << 20;
const LEAST: usize = 512;

/// For the published airlight: what lies between every blob and the lights and the eye.
///
/// # Errors
/// [`Interrupted`] when the job's progress says so.
pub fn light_sides(context: &Context, cache: &Cache) -> Result<Vec<LitBlobs>, Interrupted> {
    if context.method != Method::Fogshop2007 || !context.shows_airlight() {
        return Ok(Vec::new());
    }
    let (field, job, eye) = (context.field, &context.job, context.viewpoint.eye());
    let to_eye = fogshop2007::depths(job, field, |center| eye.facing(center))?;
    let side = |lamp: &Lamp| {
        let outlook = fogshop2007::outlook(field, lamp.source);
        let make = || fogshop2007::depths(job, field, |center| outlook.facing(center));
        let to_light = cache.to_light(field, lamp.source, job.progress, make)?;
        job.progress.check()?;
        let side = LightSide::new(field, eye, lamp.source, &to_eye, &to_light);
        Ok(LitBlobs::new(field, lamp.source, side))
    };
    context.direct().iter().map(side).collect()
}

/// For airlight: what surfaces hide of the lamps.
///
/// # Errors
/// [`Interrupted`] when the job's progress says so.
pub fn cast(context: &mut Context, cache: &Cache) -> Result<bool, Interrupted> {
    let is_exact = matches!(context.method, Method::Reference | Method::March(_));
    if !context.is_lit() || context.scatters.is_empty() || is_exact {
        return Ok(false);
    }
    let shaded = context.lamps.iter().filter(|lamp| lamp.is_shaded).count();
    let fineness = shafts::Fineness::of(&context.view, shaded);
    let mut makes = false;
    let mut of_lamp = |lamp: &Lamp| {
        if !lamp.is_shaded || lamp.is_cut_off {
            return Ok(None);
        }
        let make = || {
            makes = true;
            let Context { job, geometry, viewpoint, .. } = &*context;
            Shafts::new(job, geometry, lamp.source.origin(), viewpoint, fineness)
        };
        cache.shafts(context, lamp, fineness, make).map(Some)
    };
    let shafts = context.lamps.iter().map(&mut of_lamp).collect::<Result<Vec<_>, Interrupted>>()?;
    for (lamp, shafts) in context.lamps.iter_mut().zip(shafts) {
        lamp.shafts = shafts;
    }
    Ok(makes)
}

/// For the mapped airlight: what lies between the lights and everything else, to draw straight lines through for
/// the eye, else cubics. Tells whether any table had to be made.
///
/// # Errors
/// [`Interrupted`] when the job's progress says so.
pub fn fill_tables(context: &mut Context, cache: &Cache) -> Result<bool, Interrupted> {
    let lines = context.is_for_the_eye();
    if !context.is_mapped() || !light_table::pay(context.field, lines) {
        return Ok(false);
    }
    let bands = if context.band.is_some() { 3 } else { 1 };
    let lamps = context.direct().len();
    let fineness = Fineness::of(bands * lamps, context.view.quality, lines);
    let mut makes = false;
    let mut table = |lamp: &Lamp| {
        let (field, light) = (context.field, lamp.source);
        let make = |known: Option<&LightTable>| {
            makes = true;
            LightTable::new(&context.job, field, light.origin(), fineness, known)
        };
        cache.light_table(field, light, fineness, context.job.progress, make)
    };
    let tables = context.direct().iter().map(&mut table).collect::<Result<Vec<_>, _>>()?;
    for (lamp, table) in context.lamps.iter_mut().zip(tables) {
        lamp.table = table;
    }
    Ok(makes)
}

/// The frame's lights without a place: tabulates what is left of them, where something asks for it, in no more than
/// its share of the bytes. Tells whether any table had to be made.
///
/// # Errors
/// [`Interrupted`] when the job's progress says so.
pub fn fill_skies(
    context: &mut Context,
    cache: &Cache,
    contexts: usize,
) -> Result<bool, Interrupted> {
    let lights_fog = context.is_lit() && context.asked == Method::Auto;
    let lights_surfaces = context.shows_surfaces();
    if !lights_fog && !lights_surfaces {
        return Ok(false);
    }
    let turns = lights_fog && context.lamps.iter().any(|lamp| !lamp.is_even());
    let is_glossy =
        context.materials.iter().any(|material| material[3..6].iter().any(|share| *share > 0.0));
    let is_full = context.view.quality == Quality::Full;
    let order = match (turns || is_glossy && lights_surfaces, lights_surfaces) {
        (true, _) => skies::PREFERRED,
        (false, true) => skies::MATTE,
        (false, false) => 1,
    };
    let parts = if is_full || turns { sky::Fineness::FAST } else { sky::Fineness::DRAFT };
    let place = size_of::<f32>() * 3 * order * order;
    let most = (BYTES / (place * contexts * context.skies.len().max(1)))
        .clamp(LEAST, PLACES[usize::from(is_full)]);
    let air = Field::new(&[], 0, &Moment::default());
    let (job, field, is_clear) = (context.job, context.field, context.is_clear);
    let mut makes = false;
    for own in &mut context.skies {
        let channels: Vec<_> = own.channels.iter().map(|(channel, _)| *channel).collect();
        let of_sky = (own.radiance.clone(), own.path_m, channels.clone());
        let summing = Summing::new((own.radiance, own.path_m), channels, (parts, order));
        if is_clear && lights_surfaces {
            own.clear = SkyTable::new(&job, &air, &summing, 1)?;
        }
        if lights_fog || !is_clear {
            own.table =
                cache.sky_table(field, of_sky, (parts, order, most), job.progress, || {
                    makes = true;
                    SkyTable::new(&job, field, &summing, most)
                })?;
        }
        own.summing = Some(Arc::new(summing));
    }
    Ok(makes)
}
