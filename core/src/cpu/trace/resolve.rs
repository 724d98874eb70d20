//! What was hit: surfaces and normals.

use super::best::Best;
use super::{CUBOID, KIND, SPHERE, TRIANGLE, Tracer};
use crate::geometry::batch::{Hits, NOTHING, OnTriangles, Rays, load3};
use crate::num::{Lanes, Num};
use crate::shapes::{Cuboid, Triangle};
use crate::vector::V3;
use fearless_simd::{Select, Simd, SimdBase, SimdMask};

impl Tracer<'_> {
    /// Normals and surfaces of the nearest hits.
    #[inline(always)]
    pub fn resolve<S: Simd>(&self, simd: S, rays: &Rays, best: &Best) -> Box<Hits> {
        let mut hits = Box::<Hits>::default();
        hits.length = best.length;
        // The kind of triangles is 0: all other ids are larger than any of theirs.
        let on_triangles = || OnTriangles { place: best.id, shares: [best.u, best.v] };
        hits.triangles = self.tells_triangles.then(|| Box::new(on_triangles()));
        for at in (0..rays.count).step_by(Lanes::<S>::COUNT) {
            let ids = S::u32s::from_slice(simd, &best.id[at..at + Lanes::<S>::COUNT]);
            let zero = Lanes::splat(simd, 0.0);
            let mut normal = V3::new(zero, zero, zero);
            let mut face = normal;
            let mut surface = S::u32s::splat(simd, NOTHING);
            // One after the other what any of these rays hit: neighbours mostly hit the same.
            let mut open = !ids.simd_eq(S::u32s::splat(simd, NOTHING));
            while open.any_true() {
                let first = open.to_bitmask().trailing_zeros() as usize;
                let id = best.id[at + first];
                let same = ids.simd_eq(S::u32s::splat(simd, id));
                let ([its_normal, its_face], its_surface) = self.normal(simd, id, (rays, best), at);
                normal = V3::select(same, its_normal, normal);
                face = V3::select(same, its_face, face);
                surface = same.select(S::u32s::splat(simd, its_surface), surface);
                open &= !same;
            }
            let [x, y, z] = &mut hits.normal;
            let facing = facing(normal, face, load3(simd, &rays.direction, at));
            facing.x.store(&mut x[at..]);
            facing.y.store(&mut y[at..]);
            facing.z.store(&mut z[at..]);
            surface.store_slice(&mut hits.surface[at..at + Lanes::<S>::COUNT]);
        }
        hits
    }

    /// Normals of what rays hit, and those of its face, of any length; and its surface.
    #[inline(always)]
    fn normal<S: Simd>(
        &self,
        simd: S,
        id: u32,
        (rays, best): (&Rays, &Best),
        at: usize,
    ) -> ([V3<Lanes<S>>; 2], u32) {
        let place = (id & !KIND) as usize;
        let (normal, surface) = match id & KIND {
            TRIANGLE => {
                let triangle = &self.geometry.triangles[place];
                let weights = (Lanes::load(simd, &best.u[at..]), Lanes::load(simd, &best.v[at..]));
                let face = V3::splat(simd, triangle.face().to_array());
                return ([self.of_triangle(simd, triangle, weights), face], triangle.surface);
            }
            SPHERE => {
                let sphere = &self.geometry.spheres[place];
                let center = V3::splat(simd, sphere.center.to_array());
                (self.points(simd, rays, best, at) - center, sphere.surface)
            }
            CUBOID => {
                let cuboid = &self.geometry.cuboids[place];
                (of_cuboid(simd, cuboid, self.points(simd, rays, best, at)), cuboid.surface)
            }
            _ => {
                let plane = &self.geometry.planes[place];
                (V3::splat(simd, plane.normal.as_vec3().to_array()), plane.surface)
            }
        };
        ([normal; 2], surface)
    }

    /// Where rays end, relative to the anchor.
    #[inline(always)]
    fn points<S: Simd>(&self, simd: S, rays: &Rays, best: &Best, at: usize) -> V3<Lanes<S>> {
        let length = Lanes::load(simd, &best.length[at..]);
        let way = load3(simd, &rays.direction, at).scale(length);
        let anchor = V3::splat(simd, self.anchor.as_vec3().to_array());
        load3(simd, &rays.offset, at) + way - anchor
    }

    #[inline(always)]
    fn of_triangle<S: Simd>(
        &self,
        simd: S,
        triangle: &Triangle,
        (u, v): (Lanes<S>, Lanes<S>),
    ) -> V3<Lanes<S>> {
        let Some([a, b, c]) = self.geometry.smooth.get(triangle.smooth as usize) else {
            return V3::splat(simd, triangle.face().to_array());
        };
        let [a, b, c] = [a.to_array(), b.to_array(), c.to_array()];
        let w = u.lit(1.0) - u - v;
        let ab = V3::splat(simd, a).scale(u) + V3::splat(simd, b).scale(v);
        ab + V3::splat(simd, c).scale(w)
    }
}

/// The normals of the sides on which points of a box lie.
#[inline(always)]
fn of_cuboid<S: Simd>(simd: S, cuboid: &Cuboid, point: V3<Lanes<S>>) -> V3<Lanes<S>> {
    let Cuboid { min, max, .. } = *cuboid;
    let at = point - V3::splat(simd, (0.5 * (min + max)).to_array());
    let size = V3::splat(simd, (max - min).to_array());
    let (x, y, z) = ((at.x / size.x).abs(), (at.y / size.y).abs(), (at.z / size.z).abs());
    let (zero, one) = (x.lit(0.0), x.lit(1.0));
    let is_z = x.max(y).lt(z);
    let is_y = x.lt(y);
    let flat = V3::new(Lanes::select(is_y, zero, one), Lanes::select(is_y, one, zero), zero);
    V3::select(is_z, V3::new(zero, zero, one), flat)
}

/// Normals on the side that rays come from, of unit length; what is zero remains so. A smooth one belongs to the side
/// of its face, and at a silhouette may look a little away from the eye.
#[inline(always)]
fn facing<S: Simd>(normal: V3<Lanes<S>>, face: V3<Lanes<S>>, ray: V3<Lanes<S>>) -> V3<Lanes<S>> {
    let zero = ray.x.lit(0.0);
    let along = face.plain_dot(ray);
    let along = Lanes::select(face.plain_dot(normal).lt(zero), -along, along);
    let square = normal.plain_dot(normal);
    let inverse = zero.lit(1.0) / square.sqrt();
    let inverse = Lanes::select(zero.lt(along), -inverse, inverse);
    let is_finite = inverse.abs().lt(zero.lit(f64::from(f32::MAX)));
    normal.scale(Lanes::select(is_finite, inverse, zero))
}
