//! Skies as the passes need them: as lamps of one colour each, and as light that surfaces get from all around.

use super::sky_table::{SkyTable, Summing};
use crate::airlight::Method;
use crate::phase::PhaseFunction;
use crate::sky::psf::Glow;
use crate::sky::{Fineness, Radiance, harmonics};
use glam::DVec3;
use std::f64::consts::PI;
use std::sync::Arc;

/// Bands of harmonics of light that matte surfaces get: what they lose is some hundredths under a sky with a kink.
pub const MATTE: usize = 3;
/// The same of light that a phase function prefers.
pub const PREFERRED: usize = 6;
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
        let mean = radiance.mean();
        let alone = |channel: usize| (channel, DVec3::AXES[channel]);
        let differ = match band {
            Some(channel) => vec![alone(channel)],
            None => match of_one_colour(radiance, mean) {
                Some(colour) => vec![colour],
                None => (0..3).map(alone).collect(),
            },
        };
        let is_lit = |(channel, _): &(usize, DVec3)| mean[*channel] > 0.0;
        let glow =
            matches!(asked, Method::Sun2005 | Method::Fogshop2007).then(|| Glow::new(radiance));
        Self {
            radiance,
            path_m,
            mean,
            channels: differ.into_iter().filter(is_lit).collect(),
            glow,
            summing: None,
            table: Arc::default(),
            clear: None,
        }
    }
}

/// The channel and colour of a sky that has only one.
fn of_one_colour(radiance: &Radiance, mean: DVec3) -> Option<(usize, DVec3)> {
    let brightest = (0..3).max_by(|a, b| mean[*a].total_cmp(&mean[*b]))?;
    let colour = mean / mean[brightest];
    let is_alike = |weight: DVec3| {
        (weight - colour * weight[brightest]).abs().max_element()
            <= 1e-9 * 4.0 * PI * mean[brightest]
    };
    let parts = radiance.all_parts(Fineness::FAST);
    parts.iter().all(|part| is_alike(part.weight)).then_some((brightest, colour))
}

/// No less than what a phase function lets on of the sky in any direction, in clear air, each channel.
pub fn most(radiance: &Radiance, phase: PhaseFunction) -> DVec3 {
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
