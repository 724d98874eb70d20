//! Functions that are linear in the ray, of which triangles are made.

use crate::geometry::control::Each;
use crate::num::Lanes;
use crate::vector::V3;
use fearless_simd::Simd;
use glam::Vec3;

/// A function that is linear in the ray: a constant and a vector.
#[derive(Clone, Copy)]
pub struct Linear(pub f32, pub Vec3);

/// One in every lane.
pub struct LinearLanes<S: Simd>(pub Lanes<S>, pub V3<Lanes<S>>);

impl Linear {
    /// The same one in all lanes.
    #[inline(always)]
    pub fn lanes<S: Simd>(&self, simd: S) -> LinearLanes<S> {
        LinearLanes(Lanes::splat(simd, self.0), V3::splat(simd, self.1.to_array()))
    }
}

impl<S: Simd> LinearLanes<S> {
    /// Its value for rays.
    #[inline(always)]
    pub fn at(&self, ray: V3<Lanes<S>>) -> Lanes<S> {
        self.0 + self.1.dot(ray)
    }

    /// Writes a row a number.
    #[inline(always)]
    pub fn store(self, [constant, x, y, z]: &mut [Each; 4]) {
        self.0.store(constant);
        self.1.x.store(x);
        self.1.y.store(y);
        self.1.z.store(z);
    }
}

impl std::ops::Neg for &Linear {
    type Output = Linear;
    fn neg(self) -> Linear {
        Linear(-self.0, -self.1)
    }
}
