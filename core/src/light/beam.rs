//! A cone of light, and how much of it a ray passes.
//!
//! What is compared is v = 1 − cos ψ of the angle ψ from the axis, as half a squared distance of unit vectors: cosines
//! of narrow cones have no digits. Along a ray v is a sine squared of half the angle that the light sees, so
//! where a ray enters and leaves a cone is known in closed form.

use super::{ToLight, least_distance};
use crate::num::Num;
use crate::vector::V3;
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI, TAU};

/// A cone of light: full within the inner angle, none outside of the outer one, smoothstep of the cosine between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// Unit vector along its middle.
    pub axis: DVec3,
    /// 1 − cos of the half angle within which it is full.
    pub inner: f64,
    /// 1 − cos of the half angle where it ends.
    pub outer: f64,
}

/// No vector is shorter that is divided by its length.
const LEAST_ACROSS: f64 = 1e-12;
/// Least difference of the two that counts: cones with one angle are hard, to rounding.
const LEAST_STEP: f64 = 1e-30;

impl Beam {
    /// Along `axis`, with half angles [degrees].
    pub fn new(axis: DVec3, inner_deg: f64, outer_deg: f64) -> Self {
        let versine = |degrees: f64| 2.0 * (0.5 * degrees.to_radians()).sin().powi(2);
        Self { axis, inner: versine(inner_deg), outer: versine(outer_deg) }
    }

    /// Share of the light that goes in the unit `direction`.
    #[inline(always)]
    pub fn weight<N: Num>(&self, direction: V3<N>) -> N {
        let like = direction.x;
        let apart = direction - V3::lit(like, self.axis);
        self.at(apart.length_squared() * like.lit(0.5))
    }

    /// The same of v.
    #[inline(always)]
    fn at<N: Num>(&self, versine: N) -> N {
        let (zero, one) = (versine.lit(0.0), versine.lit(1.0));
        let step = versine.lit((self.outer - self.inner).max(LEAST_STEP));
        let x = ((versine.lit(self.outer) - versine) / step).max(zero).min(one);
        x.squared() * (x.lit(3.0) - x - x)
    }

    /// How a ray in the unit `direction` passes it, given the light's place relative to the ray's start.
    #[inline(always)]
    pub fn beside<N: Num>(&self, light: V3<N>, direction: V3<N>) -> Crossed<N> {
        let like = direction.x;
        let axis = V3::lit(like, self.axis);
        let (zero, one) = (like.lit(0.0), like.lit(1.0));
        // From the light to the closest point of the ray, and across both.
        let way = direction.scale(light.dot(direction)) - light;
        let length = way.length_squared().sqrt();
        let aside = way.scale(one / length.max(like.lit(LEAST_ACROSS)));
        let (a, b) = (axis.dot(aside), -axis.dot(direction));
        let across2 = axis.dot(aside.cross(direction)).squared();
        let level = across2 / (one + (one - across2).max(zero).sqrt());
        let turn = N::angle(a.abs(), b);
        let behind = N::select(b.lt(zero), like.lit(TAU) - turn, -turn);
        let swing = (one - level) + (one - level);
        let crossed = Crossed {
            beam: *self,
            level,
            swing,
            middle: N::select(a.lt(zero), behind, turn),
            outer: half(like.lit(self.outer), level, swing),
            inner: half(like.lit(self.inner), level, swing),
        };
        // What rounding leaves of the way of a ray through the light tells nothing.
        let is_through = length.lt(least_distance(light.length_squared().sqrt()));
        crossed.or(self.through(direction, axis), is_through)
    }

    /// The same of a ray through the light, which lies in the cone behind it, before it, or not at all.
    #[inline(always)]
    fn through<N: Num>(&self, direction: V3<N>, axis: V3<N>) -> Crossed<N> {
        let like = direction.x;
        let (zero, right_angle) = (like.lit(0.0), like.lit(FRAC_PI_2));
        let is_behind = axis.dot(direction).lt(zero);
        let apart = V3::select(is_behind, axis + direction, axis - direction);
        let level = apart.length_squared() * like.lit(0.5);
        Crossed {
            beam: *self,
            level,
            swing: zero,
            middle: N::select(is_behind, zero, like.lit(PI)),
            outer: N::select(level.lt(like.lit(self.outer)), right_angle, zero),
            inner: N::select(level.lt(like.lit(self.inner)), right_angle, zero),
        }
    }
}

/// How far beside the place nearest to the axis v reaches an edge; 0 if it never does [rad].
#[inline(always)]
fn half<N: Num>(edge: N, level: N, swing: N) -> N {
    let one = edge.lit(1.0);
    let share = (edge - level) / swing.max(edge.lit(1e-12));
    let share = share.max(edge.lit(0.0)).min(one);
    N::angle(share.sqrt(), (one - share).sqrt()) * edge.lit(2.0)
}

/// How a ray passes a cone, by the angle at the light from the direction that is opposite to the ray's: it grows
/// along the ray, from 0 to π if the ray has no ends ([`ToLight::angle_at`]).
#[derive(Clone, Copy, Debug)]
pub struct Crossed<N> {
    beam: Beam,
    /// v where the ray is nearest to the axis, and how it grows beside.
    level: N,
    swing: N,
    /// The angle of that place.
    middle: N,
    /// How far on both sides of it the ray is within the outer and the inner angle.
    outer: N,
    inner: N,
}

/// Abscissae on [−1, 1] and weights of the Gauss–Legendre rule between both angles: the weight is a cubic there of
/// what is nearly a square.
const RULE: [(f64, f64); 5] = [
    (0.0, 0.284_444_444_444_444_44),
    (0.538_469_310_105_683_1, 0.239_314_335_249_683_24),
    (-0.538_469_310_105_683_1, 0.239_314_335_249_683_24),
    (0.906_179_845_938_664, 0.118_463_442_528_094_54),
    (-0.906_179_845_938_664, 0.118_463_442_528_094_54),
];

impl<N: Num> Crossed<N> {
    /// Another one where a mask holds.
    #[inline(always)]
    fn or(self, other: Self, mask: N::Mask) -> Self {
        Self {
            beam: self.beam,
            level: N::select(mask, other.level, self.level),
            swing: N::select(mask, other.swing, self.swing),
            middle: N::select(mask, other.middle, self.middle),
            outer: N::select(mask, other.outer, self.outer),
            inner: N::select(mask, other.inner, self.inner),
        }
    }

    /// From where to where the ray is within the cone.
    #[inline(always)]
    pub fn within(&self) -> [N; 2] {
        [self.middle - self.outer, self.middle + self.outer]
    }

    /// And where its light is full.
    #[inline(always)]
    pub fn full(&self) -> [N; 2] {
        [self.middle - self.inner, self.middle + self.inner]
    }

    /// As much of some angles as is within the cone; it begins where it ends if nothing is.
    #[inline(always)]
    pub fn narrowed(&self, [from, to]: [N; 2]) -> [N; 2] {
        let [begin, end] = self.within();
        let begin = begin.max(from);
        [begin, end.min(to).max(begin)]
    }

    /// The weight at an angle.
    #[inline(always)]
    pub fn weight(&self, angle: N) -> N {
        let half = ((angle - self.middle) * angle.lit(0.25 * FRAC_1_PI)).sin_turns();
        self.beam.at(self.swing.mul_add(half.squared(), self.level))
    }

    /// Where to look between both angles, and how much each place counts of the integral over a part of the ray.
    #[inline(always)]
    pub fn soft(&self, [from, to]: [N; 2]) -> [[N; 2]; 2 * RULE.len()] {
        let (zero, one_half) = (from.lit(0.0), from.lit(0.5));
        let ([begin, end], [full, faint]) = (self.within(), self.full());
        let mut nodes = [[zero; 2]; 2 * RULE.len()];
        let mut i = 0;
        for [a, b] in [[begin, full], [faint, end]] {
            let (a, b) = (a.max(from), b.min(to));
            let width = (b - a).max(zero);
            let (middle, half) = ((a + b) * one_half, width * one_half);
            for (x, weight) in RULE {
                let angle = half.mul_add(from.lit(x), middle);
                nodes[i] = [angle, self.weight(angle) * width * from.lit(weight)];
                i += 1;
            }
        }
        nodes
    }

    /// The part of some angles where the light is full; it begins where it ends if there is none.
    #[inline(always)]
    pub fn full_between(&self, [from, to]: [N; 2]) -> [N; 2] {
        let [begin, end] = self.full();
        let begin = begin.max(from);
        [begin, end.min(to).max(begin)]
    }

    /// ∫ of the weight between two angles.
    #[inline(always)]
    pub fn turn(&self, ends: [N; 2]) -> N {
        let [begin, end] = self.full_between(ends);
        let mut sum = end - begin;
        for [_, weight] in self.soft(ends) {
            sum += weight;
        }
        sum
    }
}

impl<N: Num> ToLight<N> {
    /// The angle at the light from the direction opposite to the ray's, at a ray parameter.
    #[inline(always)]
    pub fn angle_at(&self, t: N) -> N {
        N::angle(self.miss, self.closest - t)
    }

    /// The ray parameter at such an angle [m]; at 0 and π as far as there are numbers.
    #[inline(always)]
    pub fn t_at(&self, angle: N) -> N {
        let turns = angle * angle.lit(0.5 * FRAC_1_PI);
        let (sine, cosine) = (turns.sin_turns(), (turns + angle.lit(0.25)).sin_turns());
        self.closest - self.miss * cosine / sine.max(angle.lit(1e-12))
    }
}

/// All angles that a ray may have.
pub const ALL_ANGLES: [f64; 2] = [0.0, PI];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::adaptive;

    /// Rays from all sides past a cone: the weight by the angle is that by direction, and its integral is the sum.
    #[test]
    fn a_ray_passes_a_cone_where_its_points_do() {
        let beams = [(20.0, 30.0), (0.0, 89.0), (45.0, 45.0), (1e-3, 1e-3), (0.0, 1e-3)];
        for (i, (inner, outer)) in beams.into_iter().enumerate() {
            for k in 0..40 {
                let x = (i * 40 + k) as f64;
                let axis = DVec3::new(x.sin(), (1.7 * x).cos(), (2.3 * x).sin()).normalize();
                let beam = Beam::new(axis, inner, outer);
                // Towards a point on the beam, so that narrow ones are met.
                let light = DVec3::new(1.0 + x.cos(), 2.0, (0.4 * x).sin());
                let direction = (light + 3.0 * axis).normalize();
                let to = ToLight::new(light.into(), direction.into());
                let crossed = beam.beside(light.into(), V3::from(direction));
                let weight = |angle: f64| {
                    let point = to.t_at(angle) * direction;
                    beam.weight(V3::from((point - light).normalize()))
                };
                let [begin, end] = crossed.within();
                let [full, faint] = crossed.full();
                let mut ends = vec![0.0, PI];
                ends.extend([begin, end, full, faint].iter().filter(|a| **a > 0.0 && **a < PI));
                ends.sort_by(f64::total_cmp);
                for pair in ends.windows(2) {
                    let middle = 0.5 * (pair[0] + pair[1]);
                    if pair[1] - pair[0] > 1e-9 {
                        let apart = (crossed.weight(middle) - weight(middle)).abs();
                        assert!(apart < 1e-6, "{inner} {outer} {k}: {apart}");
                    }
                }
                let wanted = adaptive(&ends, 1e-9, |angle| crossed.weight(angle));
                let found = crossed.turn(ALL_ANGLES);
                assert!((found - wanted).abs() <= 1e-4 * wanted + 1e-12, "{k}: {found} {wanted}");
            }
        }
    }

    /// A ray parameter and its angle are two names of a place.
    #[test]
    fn angles_and_ray_parameters_belong_together() {
        let to = ToLight::new(DVec3::new(3.0, 1.0, -2.0).into(), DVec3::X.into());
        for t in [0.0, 1.0, 3.0, 8.0, 100.0] {
            assert!((to.t_at(to.angle_at(t)) - t).abs() < 1e-9 * (1.0 + t * t));
        }
        assert_eq!(to.angle_at(0.0), to.first_angle());
    }
}
