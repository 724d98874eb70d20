//! How rays meet each kind of solid.

use super::best::{Best, Sample};
use super::linear::Linear;
use super::target::Target;
use super::triangle::{Ready, Waiting};
use super::{CUBOID, SPHERE, TRIANGLE, Tracer};
use crate::geometry::batch::{Rays, SIZE, load3};
use crate::num::{Lanes, Num};
use crate::shapes::{Cuboid, Plane, Solid, Sphere};
use crate::vector::V3;
use fearless_simd::Simd;
use glam::{DVec3, Vec3};

/// Of a triangle on so few pixels the box around it tells well enough which registers of rays it may touch.
const SMALL: usize = 64;

impl Tracer<'_> {
    /// Rays of all targets meet a solid, or it waits until more of its kind are met.
    #[inline(always)]
    pub fn meet<S: Simd>(
        &self,
        simd: S,
        place: usize,
        waiting: &mut Waiting,
        targets: &mut [Target<'_>],
    ) {
        match self.geometry.solids[place] {
            Solid::Triangle(at) => {
                let shift = self.anchor.as_vec3();
                let corners = self.geometry.triangles[at as usize].corners;
                waiting.push(corners.map(|corner| corner + shift), TRIANGLE | at);
                if waiting.is_full(simd) {
                    self.meet_waiting(simd, waiting, targets);
                }
            }
            Solid::Sphere(at) => {
                let (Sphere { center, radius, .. }, id) =
                    (self.geometry.spheres[at as usize], SPHERE | at);
                let to = self.anchor + center.as_dvec3();
                let power = to.length_squared() - f64::from(radius).powi(2);
                let around = (to.as_vec3(), Vec3::splat(radius));
                meet_near(simd, around, targets, |rays, best| {
                    self.meet_sphere(simd, (to, power, f64::from(radius)), id, rays, best);
                });
            }
            Solid::Cuboid(at) => {
                let (Cuboid { min, max, .. }, id) =
                    (self.geometry.cuboids[at as usize], CUBOID | at);
                let [min, max] = [min, max].map(|corner| self.anchor + corner.as_dvec3());
                let around = ((0.5 * (min + max)).as_vec3(), (0.5 * (max - min)).as_vec3());
                meet_near(simd, around, targets, |rays, best| {
                    self.meet_box(simd, [min, max], id, rays, best);
                });
            }
        }
    }

    /// Rays meet a plane.
    #[inline(always)]
    pub fn meet_plane<S: Simd>(
        &self,
        simd: S,
        plane: &Plane,
        id: u32,
        rays: &Rays,
        best: &mut Best,
    ) {
        let one = Lanes::splat(simd, 1.0);
        let normal = V3::lit(one, plane.normal);
        let height = one.lit(plane.normal.dot(self.anchor + plane.point));
        for at in (0..rays.count).step_by(Lanes::<S>::COUNT) {
            let direction = load3(simd, &rays.direction, at);
            let offset = load3(simd, &rays.offset, at);
            let distance = (height - normal.dot(offset)) / normal.dot(direction);
            best.keep(simd, at, one.lit(0.0).lt(distance), distance, (one, one), id);
        }
    }

    #[inline(always)]
    fn meet_sphere<S: Simd>(
        &self,
        simd: S,
        (to, power, radius): (DVec3, f64, f64),
        id: u32,
        rays: &Rays,
        best: &mut Best,
    ) {
        let one = Lanes::splat(simd, 1.0);
        let zero = one.lit(0.0);
        let center = V3::lit(one, to);
        for at in (0..rays.count).step_by(Lanes::<S>::COUNT) {
            let direction = load3(simd, &rays.direction, at);
            let offset = load3(simd, &rays.offset, at);
            let to = center - offset;
            // The power of the origin, |to|² − r²: formed in f64 where it would cancel most.
            let power = one.lit(power) + offset.dot(offset - center - center);
            let along = to.dot(direction);
            let half2 = one.lit(radius * radius) - to.cross(direction).length_squared();
            let half = half2.max(zero).sqrt();
            let outside = zero.lt(power);
            let distance = Lanes::select(outside, power / (along + half), along + half);
            let distance = Lanes::select(half2.lt(zero), -one, distance);
            best.keep(simd, at, zero.lt(distance), distance, (one, one), id);
        }
    }

    #[inline(always)]
    fn meet_box<S: Simd>(
        &self,
        simd: S,
        [min, max]: [DVec3; 2],
        id: u32,
        rays: &Rays,
        best: &mut Best,
    ) {
        let one = Lanes::splat(simd, 1.0);
        let (min, max) = (V3::lit(one, min), V3::lit(one, max));
        for at in (0..rays.count).step_by(Lanes::<S>::COUNT) {
            let direction = load3(simd, &rays.direction, at);
            let offset = load3(simd, &rays.offset, at);
            let inverse = V3::new(
                one / guarded(direction.x),
                one / guarded(direction.y),
                one / guarded(direction.z),
            );
            let (a, b) = ((min - offset) * inverse, (max - offset) * inverse);
            let near = a.x.min(b.x).max(a.y.min(b.y)).max(a.z.min(b.z));
            let far = a.x.max(b.x).min(a.y.max(b.y)).min(a.z.max(b.z));
            let zero = one.lit(0.0);
            let distance = Lanes::select(zero.lt(near), near, far);
            let distance = Lanes::select(far.lt(near), -one, distance);
            best.keep(simd, at, zero.lt(distance), distance, (one, one), id);
        }
    }

    /// Rays of all targets meet the triangles that wait.
    #[inline(always)]
    pub fn meet_waiting<S: Simd>(
        &self,
        simd: S,
        waiting: &mut Waiting,
        targets: &mut [Target<'_>],
    ) {
        let ready = waiting.take(simd, &self.screen);
        let mut bits = ready.seen;
        while bits != 0 {
            self.meet_triangle(simd, &ready, bits.trailing_zeros() as usize, targets);
            bits &= bits - 1;
        }
    }

    /// Edge functions: volumes of the ray's direction (under parallel projection its offset) with
    /// the corners, equal and opposite for the two triangles of an edge, so that none leaves a gap.
    #[inline(always)]
    fn meet_triangle<S: Simd>(
        &self,
        simd: S,
        ready: &Ready,
        at: usize,
        targets: &mut [Target<'_>],
    ) {
        let (area, id, linear) = (ready.area(at), ready.id(at), ready.linear(at));
        let slopes = (area.count() > SMALL).then(|| self.slopes(&linear)).flatten();
        let [u, v, w, numerator] = &linear;
        let met = [u.lanes(simd), v.lanes(simd), w.lanes(simd)];
        let numerator = numerator.lanes(simd);
        for tile in area.tiles() {
            let Some(target) = targets.get_mut(self.tiles[tile]) else { continue };
            let Some(part) = target.part(&area, slopes.as_ref()) else { continue };
            let Target { groups, samples, reach, .. } = &mut *target;
            for first in groups.registers(simd, &part) {
                let mut bits = groups.open(simd, first, &part, reach);
                while bits != 0 {
                    let group = first + bits.trailing_zeros() as usize;
                    bits &= bits - 1;
                    let place = group * Lanes::<S>::COUNT;
                    let (Sample { rays, best }, at) = (&mut samples[place / SIZE], place % SIZE);
                    let variable =
                        if self.screen.parallel { &rays.offset } else { &rays.direction };
                    if best.meet(simd, at, &met, &numerator, load3(simd, variable, at), id) {
                        reach[group] = best.farthest(simd, at);
                    }
                }
            }
            target.look(simd);
        }
    }

    /// The edge functions on the screen, with the sign that makes them positive on the triangle where it is
    /// seen; none under parallel projection, where the distance has no sign of its own.
    #[inline(always)]
    fn slopes(&self, [u, v, w, numerator]: &[Linear; 4]) -> Option<[[f32; 3]; 3]> {
        let slope = |of: &Linear| self.screen.slope(&if numerator.0 > 0.0 { *of } else { -of });
        (!self.screen.parallel).then(|| [slope(u), slope(v), slope(w)])
    }
}

/// All rays of the targets that a box around a solid, told by its middle and half its size, does not lie beside.
#[inline(always)]
fn meet_near<S: Simd>(
    simd: S,
    (middle, half): (Vec3, Vec3),
    targets: &mut [Target<'_>],
    meet: impl Fn(&Rays, &mut Best),
) {
    for target in targets {
        if target.sides.exclude(middle, half) {
            continue;
        }
        for Sample { rays, best } in &mut target.samples {
            meet(rays, best);
        }
        target.reach_anew(simd);
    }
}

/// A ray within a side of a box divides 0 by this instead of by 0.
#[inline(always)]
fn guarded<S: Simd>(d: Lanes<S>) -> Lanes<S> {
    let least = d.lit(1e-30);
    Lanes::select(d.abs().lt(least), least, d)
}
