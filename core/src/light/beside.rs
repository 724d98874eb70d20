//! Where a light stands relative to a ray or a point, and what arrives of it there.

use crate::num::Num;
use crate::vector::V3;

/// A light's nearest distance to a ray counts as at least this share of its distance from the ray's
/// origin: what rounding leaves of it. A ray through a light thereby has a finite answer. How long
/// the ray is does not matter: one into the sky is as near to a lamp as one that ends at a wall.
pub const MISS_FLOOR: f64 = 1e-6;
/// And as no less than this [m]: a hundredth of the smallest radius, at which the strongest light on the
/// strongest reflection, 1e12 · 1e12 / (1e-6)², is still a number in f32.
pub const LEAST_MISS: f64 = 1e-6;

/// The smallest distance from a light that counts for a ray whose origin is `reach` away from it [m].
#[inline(always)]
pub fn least_distance<N: Num>(reach: N) -> N {
    (reach * reach.lit(MISS_FLOOR)).max(reach.lit(LEAST_MISS))
}

/// Where a light stands relative to a ray.
#[derive(Clone, Copy, Debug)]
pub struct ToLight<N> {
    /// Ray parameter of the point closest to the light [m].
    pub closest: N,
    /// Distance of the light from the ray's line [m], floored by [`least_distance`].
    pub miss: N,
    /// What stands for the cosine towards a light whose direction is the same everywhere; 0 for all others.
    pub tilt: N,
}

/// What a place of a ray gets of a light.
#[derive(Clone, Copy, Debug)]
pub struct Arrival<N> {
    /// Distance of the light as its falloff counts it [m].
    pub distance: N,
    /// Cosine between the direction in which its light travels there and that back to the eye.
    pub cos: N,
    distance2: N,
}

impl<N: Num> ToLight<N> {
    /// From the light's place relative to the ray's origin and the unit direction.
    #[inline(always)]
    pub fn new(light: V3<N>, direction: V3<N>) -> Self {
        let floor = least_distance(light.length_squared().sqrt());
        // Errata 17: a difference of squares would lose a small distance.
        let miss = light.cross(direction).length_squared().sqrt();
        Self { closest: light.dot(direction), miss: miss.max(floor), tilt: floor.lit(0.0) }
    }

    /// What arrives `aside` behind the closest point [m].
    #[inline(always)]
    pub fn at_aside(&self, aside: N) -> Arrival<N> {
        let distance2 = aside.mul_add(aside, self.miss.squared());
        let distance = distance2.sqrt();
        Arrival { distance, cos: self.tilt - aside / distance, distance2 }
    }

    /// The angle that the ray turns through before the light between two ray parameters [rad].
    #[inline(always)]
    pub fn angle(&self, from: N, to: N) -> N {
        let (a, b) = (from - self.closest, to - self.closest);
        N::angle(self.miss * (to - from), a.mul_add(b, self.miss.squared()))
    }

    /// The angle between the direction in which light travels to the ray's start and that back to the eye [rad].
    #[inline(always)]
    pub fn first_angle(&self) -> N {
        let sine = (self.miss.lit(1.0) - self.tilt.squared()).max(self.miss.lit(0.0)).sqrt();
        N::angle(self.miss * sine, self.tilt.mul_add(self.miss, self.closest))
    }

    /// What arrives at the ray parameter `t` [m].
    #[inline(always)]
    pub fn at(&self, t: N) -> Arrival<N> {
        self.at_aside(t - self.closest)
    }
}

impl ToLight<f64> {
    /// The variable u in which falloff · dt = du/d: t = closest + miss sinh u.
    pub fn unrolled(&self, t: f64) -> f64 {
        ((t - self.closest) / self.miss).asinh()
    }

    /// t of such a u; dt = distance · du.
    pub fn rolled(&self, u: f64) -> f64 {
        self.closest + self.miss * u.sinh()
    }
}

impl<N: Num> Arrival<N> {
    /// `value` times the light that arrives per unit of strength, 1/d².
    #[inline(always)]
    pub fn falloff(&self, value: N) -> N {
        value / self.distance2
    }
}

/// A light's direct way to a point.
#[derive(Clone, Copy, Debug)]
pub struct Toward<N> {
    /// Unit vector towards the light.
    pub direction: V3<N>,
    distance2: N,
    /// Share of its light that goes this way.
    weight: N,
}

impl<N: Num> Toward<N> {
    /// Along a unit vector, with a squared distance [m²].
    #[inline(always)]
    pub fn along(direction: V3<N>, distance2: N) -> Self {
        Self { direction, distance2, weight: distance2.lit(1.0) }
    }

    /// From the light's place relative to the point; no distance counts as less than `floor` [m].
    #[inline(always)]
    pub fn new(light: V3<N>, floor: N) -> Self {
        let distance2 = light.length_squared().max(floor.squared());
        Self::along(light.scale(floor.lit(1.0) / distance2.sqrt()), distance2)
    }

    /// The same of a light of which only a share goes this way.
    #[inline(always)]
    pub fn weighed(self, weight: N) -> Self {
        Self { weight, ..self }
    }

    /// `value` times the light that arrives per unit of strength, 1/d².
    #[inline(always)]
    pub fn falloff(&self, value: N) -> N {
        value * self.weight / self.distance2
    }
}
