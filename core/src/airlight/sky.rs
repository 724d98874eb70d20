//! Light of a sky scattered once into a view ray: ∫ ω β J(x, d) e^(−T(v,x)) dt, J as in [`sky`](crate::sky).
//!
//! What sums up a lamp's integrand sums up a sky's, as that of a sun whose T is −ln of what is left of the sky. The
//! closed forms of the papers have no sky; they answer what their authors gave for one, a point spread function, or, where fog takes no light away, all of it.

use super::path::Path;
use super::{Method, mapped, march, reference, sun2005};
use crate::geometry::Ray;
use crate::media::Field;
use crate::phase::PhaseFunction;
use crate::progress::Progress;
use crate::sky::psf::{Glow, depth_before};
use crate::sky::{Fineness, Radiance, SkyWays};
use glam::DVec3;
use std::rc::Rc;

/// A view ray on which light of a sky is summed up.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Under<'a> {
    /// The sky.
    pub sky: &'a Radiance,
    /// How far fog that has no end towards it counts [m].
    pub path_m: f64,
    /// The ray.
    pub ray: Ray,
    /// How far it goes [m].
    pub length: f64,
    /// The channels that are asked for.
    pub channels: [bool; 3],
}

impl Under<'_> {
    /// What a group of terms scatters of it, were its albedo 1 [W/(m² sr)]; by the method that was asked for, not the
    /// one that lamps were matched to.
    pub fn airlight(
        &self,
        field: &Field,
        (group, phase): (usize, PhaseFunction),
        asked: Method,
        progress: &Progress,
    ) -> DVec3 {
        match asked {
            _ if field.is_empty() => return DVec3::ZERO,
            Method::None => return DVec3::ZERO,
            Method::Sun2005 | Method::Fogshop2007 => {
                let depth = field.depth(&self.ray, self.length);
                return self.published(field, group, &Glow::new(self.sky), depth);
            }
            Method::Macklin2010 => return self.thin(field, group, self.sky.mean()),
            Method::Reference | Method::Auto | Method::March(_) => {}
        }
        let ways = self.ways(field, phase, asked);
        let of_channel = |channel: usize| {
            let is_asked = self.channels[channel];
            let along = || self.along(field, group, (&ways, channel), asked, progress);
            if is_asked { along() } else { 0.0 }
        };
        DVec3::from_array(std::array::from_fn(of_channel))
    }

    /// The fog between the ray and the sky, as finely as a method asks for.
    pub fn ways(&self, field: &Field, phase: PhaseFunction, method: Method) -> Rc<SkyWays> {
        let fineness = match method {
            Method::Reference => Fineness::REFERENCE,
            _ => Fineness::FAST,
        };
        let sky = (self.sky, self.path_m);
        Rc::new(SkyWays::new(field, sky, (phase, fineness), &self.ray, self.length))
    }

    /// What a group scatters of one channel, summed up along the ray by a method.
    pub fn along(
        &self,
        field: &Field,
        group: usize,
        (ways, channel): (&Rc<SkyWays>, usize),
        method: Method,
        progress: &Progress,
    ) -> f64 {
        let strength = ways.strength()[channel];
        if strength == 0.0 {
            return 0.0;
        }
        let path = Path::under(field, group, (ways, channel), self.ray, self.length);
        let (path, even) = (path.of(progress), PhaseFunction::ISOTROPIC);
        strength
            * match method {
                Method::Reference => reference::airlight_along(&path, even),
                Method::March(steps) => march::airlight_along(&path, even, steps),
                _ => mapped::airlight_along(&path, even),
            }
    }

    /// T e^(−T) L ∗ NPSF (Sun 25–27, Fogshop 28), of which a group has its share.
    pub fn published(&self, field: &Field, group: usize, glow: &Glow, whole: f64) -> DVec3 {
        if whole <= 0.0 {
            return DVec3::ZERO;
        }
        let depth = depth_before(whole, sun2005::haze(field), self.length, self.path_m);
        let is_alone = field.groups().len() == 1;
        let share = if is_alone { 1.0 } else { self.own_depth(field, group) / whole };
        glow.airlight(depth, self.ray.direction) * share
    }

    /// T L̄: fog that takes no light away scatters as much of the sky's `mean` as it is thick.
    pub fn thin(&self, field: &Field, group: usize, mean: DVec3) -> DVec3 {
        mean * self.own_depth(field, group)
    }

    fn own_depth(&self, field: &Field, group: usize) -> f64 {
        field.along(&self.ray, self.length).depth_of(group, self.length)
    }
}
