//! What a fog is summed up by: bands of colour outside, groups of terms that scatter alike inside.
//!
//! A grey fog is one band and a coloured one three, each of which is a grey fog for itself; so everything
//! that follows light through fog knows one extinction. All groups of a band dim the light together, but
//! each scatters by an albedo and a phase function of its own: L_a = Σ ω ∫ β p(α) I/d² e^(−T) dt, β of
//! the group, T of all.

use super::{Field, Moment, Octave, Term};
use crate::json::Albedo;
use crate::phase::{Phase, PhaseFunction};
use glam::DVec3;
use std::sync::Arc;

/// How the terms of a group scatter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scattering {
    /// Share of the extinguished light that is scattered, channel by channel.
    pub albedo: DVec3,
    /// Where it goes.
    pub phase: PhaseFunction,
}

impl Scattering {
    /// How it scatters in an octave of its light.
    pub fn in_octave(&self, octave: Octave) -> Self {
        let phase = PhaseFunction { g: self.phase.g * octave.phase };
        Self { albedo: self.albedo * octave.albedo, phase }
    }
}

/// The enabled terms, those that say the same of how they scatter together.
///
/// What the fog itself says does not matter to it: a change of that leaves the groups as they are.
pub(super) fn groups(terms: &[Term]) -> Vec<Vec<&Term>> {
    let own = |term: &Term| (term.common().albedo, term.common().phase.map(Phase::function));
    let mut groups: Vec<Vec<&Term>> = Vec::new();
    for term in terms.iter().filter(|term| term.common().enabled) {
        match groups.iter_mut().find(|group| own(group[0]) == own(term)) {
            Some(group) => group.push(term),
            None => groups.push(vec![term]),
        }
    }
    groups
}

/// How each group of a [`Field`] of these terms scatters; what they do not say is the fog's own.
pub fn scatterings(terms: &[Term], albedo: Albedo, phase: &Phase) -> Vec<Scattering> {
    let of_group = |group: &Vec<&Term>| {
        let own = group[0].common();
        let (albedo, phase) = (own.albedo.unwrap_or(albedo), own.phase.unwrap_or(phase));
        Scattering { albedo: albedo.vector(), phase: phase.function() }
    };
    groups(terms).iter().map(of_group).collect()
}

/// The extinction of a scene: once if it is grey, else for red, green and blue.
#[derive(Clone, Debug)]
pub struct Bands(Vec<Arc<Field>>);

impl Bands {
    /// The bands of some terms at a moment.
    pub fn new(terms: &[Term], moment: &Moment) -> Self {
        let channels = 0..Self::count(terms);
        Self(channels.map(|channel| Arc::new(Field::new(terms, channel, moment))).collect())
    }

    /// How many bands some terms have: 1 if they are grey, else 3.
    pub fn count(terms: &[Term]) -> usize {
        let mut enabled = terms.iter().filter(|term| term.common().enabled);
        if enabled.all(Term::is_grey) { 1 } else { 3 }
    }

    /// The same with fewer blobs far from the eye: see [`Field::pruned`].
    #[must_use]
    pub fn pruned(&self, eye: DVec3, error: f64) -> Self {
        let band = |field: &Arc<Field>| match field.pruned(eye, error) {
            Some(pruned) => Arc::new(pruned),
            None => Arc::clone(field),
        };
        Self(self.0.iter().map(band).collect())
    }

    /// Each of them.
    pub fn each(&self) -> &[Arc<Field>] {
        &self.0
    }

    /// Bytes that they take, near enough.
    pub fn bytes(&self) -> usize {
        self.0.iter().map(|field| field.bytes()).sum()
    }
}

/// Of numbers that each band answers for all channels, those that are its own.
pub fn in_channels(bands: &[DVec3]) -> DVec3 {
    match *bands {
        [r, g, b] => DVec3::new(r.x, g.y, b.z),
        _ => bands.iter().copied().sum(),
    }
}
