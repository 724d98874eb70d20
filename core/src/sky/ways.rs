//! What is left of a sky at the points of a ray, exact and in f64.

use super::parts::{Fineness, Part};
use crate::geometry::{Beyond, Origin, Ray};
use crate::light::sun;
use crate::media::{Field, Sum, Ways};
use crate::phase::PhaseFunction;
use crate::sky::Radiance;
use glam::DVec3;
use std::cell::RefCell;
use std::collections::HashMap;

/// The fog between a ray and all parts of a sky.
#[derive(Debug)]
pub(crate) struct SkyWays {
    parts: Vec<(Sum<dyn Ways>, DVec3)>,
    /// What all parts come to in clear air.
    whole: DVec3,
    /// What was found, by the ray parameter's bits: all channels ask at the same places.
    found: RefCell<HashMap<u64, DVec3>>,
}

impl SkyWays {
    /// Of a ray up to `length` [m], into which a phase function scatters the sky's light. Fog that has no end towards
    /// it counts as far as `path_m`.
    pub fn new(
        field: &Field,
        (sky, path_m): (&Radiance, f64),
        (phase, fineness): (PhaseFunction, Fineness),
        ray: &Ray,
        length: f64,
    ) -> Self {
        let parts = sky.parts(phase, ray.direction, fineness);
        let whole = parts.iter().map(|part| part.weight).sum();
        let lit = parts.into_iter().filter(|part| part.weight != DVec3::ZERO);
        let ends = [ray.origin, ray.at(length)];
        let way = |Part { toward, weight }| {
            let origin = Origin::Beyond(Beyond { toward, path_m });
            (field.ways(origin, ends), weight)
        };
        Self { parts: lit.map(way).collect(), whole, found: RefCell::default() }
    }

    /// How strong the sun is that shines as bright, each channel.
    pub fn strength(&self) -> DVec3 {
        self.whole * (sun::DISTANCE_M * sun::DISTANCE_M)
    }

    /// Terms that a look sums up.
    pub fn terms(&self) -> usize {
        self.parts.iter().map(|(ways, _)| 1 + ways.terms()).sum()
    }

    /// −ln of what is left of a channel at a point, whose ray parameter names it.
    pub fn depth_to(&self, t: f64, point: DVec3, channel: usize) -> f64 {
        let mut found = self.found.borrow_mut();
        let left = found.entry(t.to_bits()).or_insert_with(|| self.left_at(point));
        -(left[channel] / self.whole[channel]).ln()
    }

    fn left_at(&self, point: DVec3) -> DVec3 {
        self.parts.iter().map(|(ways, weight)| *weight * (-ways.depth_to(point)).exp()).sum()
    }
}
