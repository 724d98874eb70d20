//! Light that was scattered several times, as sums of single scattering in ever thinner fog (Wrenninge, Kulla and Lundqvist:
//! Oz: The Great and Volumetric, SIGGRAPH 2013 talks): octave i has aⁱ of the extinction, bⁱ of what is scattered, and
//! its phase function cⁱ of g. Light that was scattered often goes farther than its optical depth lets through, comes
//! from everywhere, and there is less of it.

use crate::json::{Checker, limits};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Light that was scattered more than once, as sums of single scattering in ever thinner fog. It is a look, not a
/// solution of transport: without octaves nothing is scattered twice.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MultipleScattering {
    /// How many times single scattering is added; 0 turns it off.
    #[schemars(range(min = limits::OCTAVES.min, max = limits::OCTAVES.max))]
    pub octaves: u32,
    /// The extinction of an octave as a share of that of the octave before.
    #[schemars(range(min = limits::THINNING.min, max = limits::THINNING.max))]
    pub attenuation: f64,
    /// What it scatters, likewise; no more than `attenuation` where no light may be won.
    #[schemars(range(min = limits::FRACTION.min, max = limits::FRACTION.max))]
    pub contribution: f64,
    /// Mean cosine of its phase function, likewise.
    #[schemars(range(min = limits::FRACTION.min, max = limits::FRACTION.max))]
    pub phase: f64,
}

impl Default for MultipleScattering {
    fn default() -> Self {
        Self { octaves: 0, attenuation: 0.5, contribution: 0.5, phase: 0.5 }
    }
}

/// One octave, as shares of the fog itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Octave {
    /// Which it is; 0 is the fog itself.
    pub index: u32,
    /// Extinction.
    pub density: f64,
    /// Albedo.
    pub albedo: f64,
    /// Mean cosine of the phase function.
    pub phase: f64,
}

impl Octave {
    /// The fog itself.
    pub const FIRST: Self = Self { index: 0, density: 1.0, albedo: 1.0, phase: 1.0 };
}

impl MultipleScattering {
    /// Looks at all of its numbers; `at` names its members.
    pub fn check(&self, check: &mut Checker, at: &dyn Fn(&str) -> String) {
        check.number(f64::from(self.octaves), limits::OCTAVES, || at("octaves"));
        check.number(self.attenuation, limits::THINNING, || at("attenuation"));
        for (name, value) in [("contribution", self.contribution), ("phase", self.phase)] {
            check.number(value, limits::FRACTION, || at(name));
        }
    }

    /// The octaves behind the first, as far as anything is left of them.
    pub fn each(&self) -> impl Iterator<Item = Octave> {
        let Self { octaves, attenuation, contribution, phase } = *self;
        let octave = move |index: u32| {
            let [density, scattered, phase] =
                [attenuation, contribution, phase].map(|share| share.powi(index as i32));
            Octave { index, density, albedo: scattered / density, phase }
        };
        let some = if contribution > 0.0 { octaves } else { 0 };
        (1..=some).map(octave)
    }
}
