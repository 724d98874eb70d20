//! A vector of [`Num`]: one in f64, or one for every lane.

use crate::num::{Lanes, Num};
use fearless_simd::Simd;
use glam::DVec3;
use std::ops::{Add, Mul, Neg, Sub};

/// Three coordinates.
#[derive(Clone, Copy, Debug)]
pub struct V3<N> {
    /// Along +X.
    pub x: N,
    /// Along +Y.
    pub y: N,
    /// Along +Z.
    pub z: N,
}

impl<N: Num> V3<N> {
    /// From its coordinates.
    #[inline(always)]
    pub fn new(x: N, y: N, z: N) -> Self {
        Self { x, y, z }
    }

    /// A constant vector in the lanes of `like`.
    #[inline(always)]
    pub fn lit(like: N, v: DVec3) -> Self {
        Self::new(like.lit(v.x), like.lit(v.y), like.lit(v.z))
    }

    /// Scalar product.
    #[inline(always)]
    pub fn dot(self, o: Self) -> N {
        self.x.mul_add(o.x, self.y.mul_add(o.y, self.z * o.z))
    }

    /// Scalar product of which every product is rounded: the same to the bit whether the machine fuses them or not.
    #[inline(always)]
    pub fn plain_dot(self, o: Self) -> N {
        self.x * o.x + self.y * o.y + self.z * o.z
    }

    /// Vector product.
    #[inline(always)]
    pub fn cross(self, o: Self) -> Self {
        Self::new(
            self.y.mul_add(o.z, -(self.z * o.y)),
            self.z.mul_add(o.x, -(self.x * o.z)),
            self.x.mul_add(o.y, -(self.y * o.x)),
        )
    }

    /// Squared length.
    #[inline(always)]
    pub fn length_squared(self) -> N {
        self.dot(self)
    }

    /// Scaled by a number.
    #[inline(always)]
    pub fn scale(self, k: N) -> Self {
        Self::new(self.x * k, self.y * k, self.z * k)
    }

    /// Component-wise choice.
    #[inline(always)]
    pub fn select(mask: N::Mask, a: Self, b: Self) -> Self {
        Self::new(N::select(mask, a.x, b.x), N::select(mask, a.y, b.y), N::select(mask, a.z, b.z))
    }
}

impl<N: Num> Neg for V3<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(-self.x, -self.y, -self.z)
    }
}

impl<N: Num> Add for V3<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self::new(self.x + o.x, self.y + o.y, self.z + o.z)
    }
}

impl<N: Num> Sub for V3<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self::new(self.x - o.x, self.y - o.y, self.z - o.z)
    }
}

impl<N: Num> Mul for V3<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        Self::new(self.x * o.x, self.y * o.y, self.z * o.z)
    }
}

impl From<DVec3> for V3<f64> {
    fn from(v: DVec3) -> Self {
        Self { x: v.x, y: v.y, z: v.z }
    }
}

impl<S: Simd> V3<Lanes<S>> {
    /// The same vector in every lane.
    // No closures over lanes here: array::map would be compiled without the lanes' instructions.
    #[inline(always)]
    pub fn splat(simd: S, [x, y, z]: [f32; 3]) -> Self {
        Self::new(Lanes::splat(simd, x), Lanes::splat(simd, y), Lanes::splat(simd, z))
    }
}
