//! The bounds of [`Bundle`] in lanes, one point a lane: widened by the rounding of f32, they hold as
//! the exact ones do.

use crate::geometry::bundle::Bundle;
use crate::num::{Lanes, Num};
use crate::vector::V3;
use fearless_simd::Simd;

/// Relative error of coordinates in f32, with room for the few operations on them.
pub const ROUNDING: f64 = 1e-6;

/// A bundle; points are relative to its origin.
pub struct Cone<S: Simd> {
    axis: V3<Lanes<S>>,
    radius: Lanes<S>,
    tan: Lanes<S>,
    cos: Lanes<S>,
    sin: Lanes<S>,
    length: Lanes<S>,
}

/// Where points lie relative to a [`Cone`].
pub struct Place<S: Simd> {
    along: Lanes<S>,
    aside: Lanes<S>,
    /// What rounding may have changed [m].
    slack: Lanes<S>,
}

impl<S: Simd> Cone<S> {
    /// A bundle in the lanes of `like`.
    #[inline(always)]
    pub fn new(like: Lanes<S>, bundle: &Bundle) -> Self {
        let cos = 1.0 / (1.0 + bundle.tan * bundle.tan).sqrt();
        Self {
            axis: V3::lit(like, bundle.axis),
            radius: like.lit(bundle.radius),
            tan: like.lit(bundle.tan),
            cos: like.lit(cos),
            sin: like.lit(bundle.tan * cos),
            length: like.lit(bundle.length),
        }
    }

    /// Coordinates of points relative to the axis.
    #[inline(always)]
    pub fn place(&self, to: V3<Lanes<S>>) -> Place<S> {
        let along = to.dot(self.axis);
        let aside = to.cross(self.axis).length_squared().sqrt();
        let slack = (along.abs() + aside + self.radius) * along.lit(ROUNDING);
        Place { along, aside, slack }
    }

    /// See [`Bundle::distance`].
    #[inline(always)]
    pub fn distance(&self, place: &Place<S>) -> Lanes<S> {
        let zero = place.along.lit(0.0);
        let beyond = (place.along - self.length).max(zero);
        let along = place.along.min(self.length);
        let aside = place.aside - self.radius - along * self.tan;
        // Beyond the end its rim is nearest, before it the side; behind the start the start may be.
        let rim = aside.max(zero).mul_add(aside.max(zero), beyond.squared()).sqrt();
        let side = (aside * self.cos).max(-place.along - self.radius);
        (Lanes::select(zero.lt(beyond), rim, side) - place.slack).max(zero)
    }

    /// See [`Bundle::farthest_miss`].
    #[inline(always)]
    pub fn farthest_miss(&self, place: &Place<S>) -> Lanes<S> {
        place.along.abs().mul_add(self.tan, place.aside + self.radius) + place.slack
    }

    /// See [`Bundle::closest_approach`].
    #[inline(always)]
    pub fn closest_approach(&self, place: &Place<S>) -> (Lanes<S>, Lanes<S>) {
        let Place { along, aside, slack } = place;
        let full = along.mul_add(*along, aside.squared()).sqrt();
        let (before, after) = (*along * self.cos, *aside * self.sin);
        // Inside the cone, or inside its mirror image behind the origin, some ray meets the point.
        let reach = *along * self.tan;
        let low = Lanes::select((-reach).lt(*aside), before - after, -full);
        let high = Lanes::select(reach.lt(*aside), before + after, full);
        (low - self.radius - *slack, high + self.radius + *slack)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};
    use glam::DVec3;
    use proptest::prelude::*;

    fn vector(range: f64) -> impl Strategy<Value = DVec3> {
        (-range..range, -range..range, -range..range).prop_map(|(x, y, z)| DVec3::new(x, y, z))
    }

    /// Distance, farthest miss and both ends of the closest approach.
    #[inline(always)]
    fn bounds<S: Simd>(simd: S, bundle: &Bundle, to: DVec3) -> [f32; 4] {
        let one = Lanes::splat(simd, 1.0);
        let cone = Cone::new(one, bundle);
        let place = cone.place(V3::lit(one, to));
        let (low, high) = cone.closest_approach(&place);
        let all = [cone.distance(&place), cone.farthest_miss(&place), low, high];
        [all[0].0[0], all[1].0[0], all[2].0[0], all[3].0[0]]
    }

    proptest! {
        /// Bounds in f32 never promise more than those in f64, and little less.
        #[test]
        fn bounds_in_lanes_hold_what_the_exact_ones_do(
            axis in vector(1.0),
            radius in 0.0f64..3.0,
            tan in 0.0f64..2.0,
            length in 0.1f64..1000.0,
            to in vector(2000.0),
        ) {
            prop_assume!(axis.length() > 0.01);
            let bundle = Bundle { origin: DVec3::ZERO, axis: axis.normalize(), radius, tan, length };
            let place = bundle.place(to);
            let (low, high) = bundle.closest_approach(place);
            let exact = [bundle.distance(place), bundle.farthest_miss(place), low, high];
            let lanes = dispatch!(Level::new(), simd => bounds(simd, &bundle, to));
            let room = 1e-5 * (to.length() + radius);
            for (k, above) in [(0, false), (1, true), (2, false), (3, true)] {
                let more = (f64::from(lanes[k]) - exact[k]) * if above { 1.0 } else { -1.0 };
                prop_assert!((0.0..=room).contains(&more) || exact[k] == 0.0, "{k}: {more}");
            }
        }
    }
}
