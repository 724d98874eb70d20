//! What was hit: surfaces and normals.

use super::best::Best;
use super::{PLANE, Tracer};
use crate::geometry::batch::{Hits, NOTHING, Rays, Rows, SIZE, get3, load3};
use crate::num::{Lanes, Num};
use crate::shapes::Solid;
use fearless_simd::Simd;
use glam::Vec3;

impl Tracer<'_> {
    /// Normals and surfaces of the nearest hits.
    #[inline(always)]
    pub fn resolve<S: Simd>(&self, simd: S, rays: &Rays, best: &Best) -> Box<Hits> {
        let mut hits = Box::<Hits>::default();
        hits.length = best.length;
        for at in 0..rays.count {
            let id = best.id[at].to_bits();
            if id == NOTHING {
                continue;
            }
            let (normal, surface) = if id & PLANE != 0 {
                let plane = &self.geometry.planes[(id & !PLANE) as usize];
                (plane.normal.as_vec3(), plane.surface)
            } else {
                self.normal(&self.geometry.solids[id as usize], (rays, best), at)
            };
            hits.surface[at] = surface;
            for k in 0..3 {
                hits.normal[k][at] = normal[k];
            }
        }
        face_the_eye(simd, &rays.direction, &mut hits.normal);
        hits
    }

    /// A normal, of any length, and the surface.
    #[inline(always)]
    fn normal(&self, solid: &Solid, (rays, best): (&Rays, &Best), at: usize) -> (Vec3, u32) {
        let ray = get3(&rays.direction, at);
        let point = || get3(&rays.offset, at) + ray * best.length[at] - self.anchor.as_vec3();
        match *solid {
            Solid::Triangle(place) => {
                let triangle = &self.geometry.triangles[place as usize];
                let Some([a, b, c]) = self.geometry.smooth.get(triangle.smooth as usize) else {
                    return (triangle.face(), triangle.surface);
                };
                let [u, v] = [best.u[at], best.v[at]];
                let smooth = u * *a + v * *b + (1.0 - u - v) * *c;
                // A smooth normal on the far side of its face would light the wrong side.
                let flipped = smooth.dot(ray) * triangle.face().dot(ray) < 0.0;
                (if flipped { -smooth } else { smooth }, triangle.surface)
            }
            Solid::Sphere { center, surface, .. } => (point() - center, surface),
            Solid::Box { min, max, surface } => {
                let at = (point() - 0.5 * (min + max)) / (max - min);
                let axis = usize::from(at.y.abs() > at.x.abs());
                let axis = if at.z.abs() > at[axis].abs() { 2 } else { axis };
                (Vec3::AXES[axis], surface)
            }
        }
    }
}

/// Turns normals towards the eye and gives them unit length; what is zero remains so.
#[inline(always)]
fn face_the_eye<S: Simd>(simd: S, rays: &Rows, normals: &mut Rows) {
    for at in (0..SIZE).step_by(Lanes::<S>::COUNT) {
        let (ray, normal) = (load3(simd, rays, at), load3(simd, normals, at));
        let zero = ray.x.lit(0.0);
        let along = normal.x * ray.x + normal.y * ray.y + normal.z * ray.z;
        let square = normal.x * normal.x + normal.y * normal.y + normal.z * normal.z;
        let inverse = zero.lit(1.0) / square.sqrt();
        let inverse = Lanes::select(zero.lt(along), -inverse, inverse);
        let is_finite = inverse.abs().lt(zero.lit(f64::from(f32::MAX)));
        let inverse = Lanes::select(is_finite, inverse, zero);
        let [x, y, z] = normals;
        (normal.x * inverse).store(&mut x[at..]);
        (normal.y * inverse).store(&mut y[at..]);
        (normal.z * inverse).store(&mut z[at..]);
    }
}
