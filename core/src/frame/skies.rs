//! Skies as the passes need them: as lamps of one colour each, and as light that surfaces get from all around.

use super::cache::Cache;
use super::context::{Context, Lamp};
use super::sky_table::{SkyTable, Summing};
use crate::airlight::Method;
use crate::geometry::Beyond;
use crate::light::{Source, sun};
use crate::media::{Field, Moment, Scattering};
use crate::phase::PhaseFunction;
use crate::progress::Interrupted;
use crate::request::Quality;
use crate::sky::psf::Glow;
use crate::sky::{Fineness, Radiance, harmonics};
use glam::DVec3;
use std::f64::consts::PI;
use std::sync::Arc;

/// Bands of harmonics of light that matte surfaces get: what they lose is some hundredths under a sky with a kink.
pub const MATTE: usize = 3;
/// The same of light that a phase function prefers.
const PREFERRED: usize = 6;
/// Most places of a table, of a draft and in full.
const PLACES: [usize; 2] = [4 << 10, 64 << 10];
/// Bytes of all tables of a frame; and the places that each may have in any case.
const BYTES: usize = 128 << 20;
const LEAST: usize = 512;

/// A sky as the passes need it.
#[derive(Debug)]
pub struct Sky<'a> {
    /// How bright it is.
    pub radiance: &'a Radiance,
    /// How far fog that has no end towards it counts [m].
    pub path_m: f64,
    /// The channels that differ, each with the colour that it stands for.
    pub channels: Vec<(usize, DVec3)>,
    /// Its mean over all directions [W/(m² sr)].
    pub mean: DVec3,
    /// Blurred as the published methods have it, for them alone.
    pub glow: Option<Glow>,
    /// How it is summed up, once something asks for that.
    pub summing: Option<Arc<Summing>>,
    /// What is left of it over space, where a table holds that.
    pub table: Arc<Option<SkyTable>>,
    /// The same for surfaces that it reaches as in clear air.
    pub clear: Option<SkyTable>,
}

/// A channel of a sky as a lamp, scattered by one phase function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OfSky {
    /// The sky, by its place among those of the frame.
    pub sky: usize,
    /// Its channel, by its place among those that differ.
    pub place: usize,
    /// Where fog scatters its light.
    pub phase: PhaseFunction,
    /// The most radiance that goes on of it anywhere, which a sun that is scattered evenly stands for.
    pub most: f64,
}

impl<'a> Sky<'a> {
    /// Of a scene's; `band` is the only channel that is asked for, if there is one.
    pub fn new(radiance: &'a Radiance, path_m: f64, band: Option<usize>, asked: Method) -> Self {
        let whole: DVec3 = radiance.all_parts(Fineness::FAST).iter().map(|part| part.weight).sum();
        let alone = |channel: usize| (channel, DVec3::AXES[channel]);
        let differ = match band {
            Some(channel) => vec![alone(channel)],
            None => match of_one_colour(radiance, whole) {
                Some(colour) => vec![colour],
                None => (0..3).map(alone).collect(),
            },
        };
        let is_lit = |(channel, _): &(usize, DVec3)| whole[*channel] > 0.0;
        let glow =
            matches!(asked, Method::Sun2005 | Method::Fogshop2007).then(|| Glow::new(radiance));
        Self {
            radiance,
            path_m,
            mean: whole / (4.0 * PI),
            channels: differ.into_iter().filter(is_lit).collect(),
            glow,
            summing: None,
            table: Arc::default(),
            clear: None,
        }
    }

    /// Its lamps, as that of place `sky` of the frame, for all phase functions of the fog.
    pub fn lamps(&self, sky: usize, scatterings: &[Scattering]) -> Vec<Lamp> {
        let mut phases: Vec<PhaseFunction> = Vec::new();
        for own in scatterings {
            if !phases.contains(&own.phase) {
                phases.push(own.phase);
            }
        }
        let source = Source::Sun(sun::Place(Beyond { toward: DVec3::Y, path_m: self.path_m }));
        let mut lamps = Vec::new();
        for phase in phases {
            let most = most(self.radiance, phase);
            for (place, (channel, colour)) in self.channels.iter().enumerate() {
                let most = most[*channel];
                let strength = *colour * (4.0 * PI * most * sun::DISTANCE_M * sun::DISTANCE_M);
                let of_sky = Some(OfSky { sky, place, phase, most });
                lamps.push(Lamp { of_sky, ..Lamp::new(source, strength) });
            }
        }
        lamps
    }
}

/// The channel and colour of a sky that has only one.
fn of_one_colour(radiance: &Radiance, whole: DVec3) -> Option<(usize, DVec3)> {
    let brightest = (0..3).max_by(|a, b| whole[*a].total_cmp(&whole[*b]))?;
    let colour = whole / whole[brightest];
    let is_alike = |weight: DVec3| {
        (weight - colour * weight[brightest]).abs().max_element() <= 1e-9 * whole[brightest]
    };
    let parts = radiance.all_parts(Fineness::FAST);
    parts.iter().all(|part| is_alike(part.weight)).then_some((brightest, colour))
}

/// No less than what a phase function lets on of the sky in any direction, in clear air, each channel.
fn most(radiance: &Radiance, phase: PhaseFunction) -> DVec3 {
    let sums = radiance.harmonics(PREFERRED);
    let factors: Vec<_> = bands_of(phase, PREFERRED).collect();
    let toward = |d: DVec3| -> DVec3 {
        let values = harmonics::all(PREFERRED, d);
        let terms = sums.iter().zip(&factors).zip(values);
        terms.map(|((sum, factor), value)| *sum * *factor * value).sum()
    };
    if phase.is_isotropic() {
        return toward(DVec3::Y);
    }
    let all = radiance.all_parts(Fineness::REFERENCE);
    all.iter().map(|part| toward(part.toward)).fold(DVec3::splat(f64::MIN_POSITIVE), DVec3::max)
        * 1.05
}

/// What Henyey and Greenstein's function leaves of each harmonic below `order`: gˡ.
fn bands_of(phase: PhaseFunction, order: usize) -> impl Iterator<Item = f64> {
    harmonics::bands(order).map(move |l| phase.g.powi(l as i32))
}

/// Factors by which a phase function sums harmonics up to what goes on along `d`.
pub fn along(phase: PhaseFunction, order: usize, d: DVec3) -> Vec<f32> {
    let values = harmonics::all(order, d);
    bands_of(phase, order).zip(values).map(|(factor, value)| (factor * value) as f32).collect()
}

/// The frame's lights without a place: tabulates what is left of them, where something asks for it, in no more than
/// its share of the bytes. Tells whether any table had to be made.
///
/// # Errors
/// [`Interrupted`] when the job's progress says so.
pub fn fill(context: &mut Context, cache: &Cache, contexts: usize) -> Result<bool, Interrupted> {
    let lights_fog = context.is_lit() && context.asked == Method::Auto;
    let lights_surfaces = context.shows_surfaces();
    if !lights_fog && !lights_surfaces {
        return Ok(false);
    }
    let turns = lights_fog && context.lamps.iter().any(|lamp| !lamp.is_even());
    let is_glossy = context.materials.iter().any(|own| own[3..6].iter().any(|share| *share > 0.0));
    let is_full = context.view.quality == Quality::Full;
    let order = match (turns || is_glossy && lights_surfaces, lights_surfaces) {
        (true, _) => PREFERRED,
        (false, true) => MATTE,
        (false, false) => 1,
    };
    let parts = if is_full || turns { Fineness::FAST } else { Fineness::DRAFT };
    let place = size_of::<f32>() * 3 * order * order;
    let most = (BYTES / (place * contexts * context.skies.len().max(1)))
        .clamp(LEAST, PLACES[usize::from(is_full)]);
    let air = Field::new(&[], 0, &Moment::default());
    let (job, field, is_clear) = (context.job, context.field, context.is_clear);
    let mut makes = false;
    for sky in &mut context.skies {
        let channels: Vec<_> = sky.channels.iter().map(|(channel, _)| *channel).collect();
        let of_sky = (sky.radiance.clone(), sky.path_m, channels.clone());
        let summing = Summing::new((sky.radiance, sky.path_m), channels, (parts, order));
        if is_clear && lights_surfaces {
            sky.clear = SkyTable::new(&job, &air, &summing, 1)?;
        }
        if lights_fog || !is_clear {
            sky.table =
                cache.sky_table(field, of_sky, (parts, order, most), job.progress, || {
                    makes = true;
                    SkyTable::new(&job, field, &summing, most)
                })?;
        }
        sky.summing = Some(Arc::new(summing));
    }
    Ok(makes)
}
