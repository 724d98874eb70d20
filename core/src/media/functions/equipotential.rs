//! Fog around objects: β(x) = s/(c + d r²), r the distance from a point, a line or a sphere (Biri and Michelin 2002,
//! eq. 9), integrated along the ray, not, as the paper's words would have it, taken once a ray.
//!
//! Around a point and, in its cross-section, a line, the integral is an angle: with m² the squared distance of the
//! segment's line plus c/d, ∫ ds/(c + d(…)) = (angle of both ends as seen over m)/(d m).
//!
//! Around a sphere r is 0 inside and √(m² + s²) − R outside. With z = R + i√(c/d) and t = 1/(√(m² + s²) + s)
//! the integral outside is Im(z Λ/S)/(d √(c/d)), S² = z² − m² and Λ the difference between both ends of
//! ln((1 − (z + S) t)/(1 − (z − S) t)).

use super::member::member;
use crate::json::tagged::tagged;
use crate::json::{Checker, Vec3, limits};
use crate::media::Words;
use crate::media::toward::Toward;
use crate::num::Num;
use crate::vector::V3;
use glam::{DVec3, Vec4};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

tagged!(
    /// What the distance is counted from.
    Object {
        /// A point.
        PointObject = "point",
        /// A line without end.
        LineObject = "line",
        /// A sphere, the distance from which is 0 inside.
        SphereObject = "sphere",
    }
);

/// A point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PointObject {
    /// Where it is [m].
    pub position: Vec3,
}

/// A line without end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LineObject {
    /// Any of its points [m].
    pub position: Vec3,
    /// Where it runs; of any length but 0.
    pub direction: Vec3,
}

/// A sphere, the distance from which is 0 inside.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SphereObject {
    /// Its middle [m].
    pub center: Vec3,
    /// Its radius [m].
    #[schemars(range(min = limits::RADIUS.min, max = limits::RADIUS.max))]
    pub radius: f64,
}

impl Default for PointObject {
    fn default() -> Self {
        Self { position: Vec3([0.0, 1.0, 0.0]) }
    }
}

impl Default for LineObject {
    fn default() -> Self {
        Self { position: Vec3([0.0, 1.0, 0.0]), direction: Vec3([1.0, 0.0, 0.0]) }
    }
}

impl Default for SphereObject {
    fn default() -> Self {
        Self { center: Vec3([0.0, 1.0, 0.0]), radius: 1.0 }
    }
}

impl Toward for Object {
    fn toward(&self, other: &Self, share: f64) -> Self {
        match (self, other) {
            (Self::PointObject(a), Self::PointObject(b)) => {
                Self::PointObject(PointObject { position: a.position.toward(&b.position, share) })
            }
            (Self::LineObject(a), Self::LineObject(b)) => Self::LineObject(LineObject {
                position: a.position.toward(&b.position, share),
                direction: a.direction.toward(&b.direction, share),
            }),
            (Self::SphereObject(a), Self::SphereObject(b)) => Self::SphereObject(SphereObject {
                center: a.center.toward(&b.center, share),
                radius: a.radius.toward(&b.radius, share),
            }),
            // The check refuses objects of two kinds.
            _ => self.clone(),
        }
    }
}

member!(
    /// Fog around an object: strength / (c + d · r²), r the distance from it.
    Equipotential, EquipotentialMorph, EquipotentialParameters {
        /// What the distance is counted from.
        object: Object = Object::PointObject(PointObject::default()),
        /// Its strength; below 0 it takes fog away.
        #[schemars(range(min = limits::SIGNED_EXTINCTION.min, max = limits::SIGNED_EXTINCTION.max))]
        strength: f64 = 0.2,
        /// What the strength is divided by at the object.
        #[schemars(range(min = limits::DIVISOR.min, max = limits::DIVISOR.max))]
        c: f64 = 1.0,
        /// By how much that grows with the square of the distance [1/m²].
        #[schemars(range(min = limits::DIVISOR_GROWTH.min, max = limits::DIVISOR_GROWTH.max))]
        d: f64 = 2.0,
    }
);

impl EquipotentialParameters {
    /// Looks at all of its numbers; `at` names its members.
    pub fn check(&self, check: &mut Checker, at: &dyn Fn(&str) -> String) {
        let of = |name: &str| at(&format!("object/{name}"));
        match &self.object {
            Object::PointObject(point) => {
                check.triple(point.position.0, limits::COORDINATE, || of("position"));
            }
            Object::LineObject(line) => {
                check.triple(line.position.0, limits::COORDINATE, || of("position"));
                check.direction(line.direction, || of("direction"));
            }
            Object::SphereObject(sphere) => {
                check.triple(sphere.center.0, limits::COORDINATE, || of("center"));
                check.number(sphere.radius, limits::RADIUS, || of("radius"));
            }
        }
        check.number(self.strength, limits::SIGNED_EXTINCTION, || at("strength"));
        check.number(self.c, limits::DIVISOR, || at("c"));
        check.number(self.d, limits::DIVISOR_GROWTH, || at("d"));
    }
}

/// Fog around an object, seen from an origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Potential {
    /// A point of it [m].
    pub center: DVec3,
    /// The unit direction of a line.
    line: Option<DVec3>,
    /// The radius of a sphere, else 0 [m].
    radius: f64,
    strength: f64,
    c: f64,
    d: f64,
}

impl Potential {
    /// Of some parameters, times a factor.
    pub fn new(from: &EquipotentialParameters, scale: f64) -> Self {
        let (center, line, radius) = match &from.object {
            Object::PointObject(point) => (point.position, None, 0.0),
            Object::LineObject(line) => {
                (line.position, Some(line.direction.vector().normalize()), 0.0)
            }
            Object::SphereObject(sphere) => (sphere.center, None, sphere.radius),
        };
        let strength = scale * from.strength;
        Self { center: center.vector(), line, radius, strength, c: from.c, d: from.d }
    }

    /// The same from another origin.
    pub fn seen_from(self, origin: DVec3) -> Self {
        Self { center: self.center - origin, ..self }
    }

    /// The least and the most that it adds [1/m].
    pub fn bounds(&self) -> [f64; 2] {
        let most = self.strength / self.c;
        if self.d == 0.0 { [most; 2] } else { [most.min(0.0), most.max(0.0)] }
    }

    /// Over which length it changes [m].
    pub fn width(&self) -> f64 {
        self.radius + (self.c / self.d.max(1e-12)).sqrt().min(1e6)
    }

    /// Where a ray from the origin is nearest to it, and over which length it changes there [m].
    pub fn peak(&self, direction: DVec3) -> (f64, f64) {
        let (center, along) = (self.across(self.center), self.across(direction));
        let at = center.dot(along) / along.length_squared().max(f64::MIN_POSITIVE);
        let miss = center.distance(at * along);
        // As a hyperbola's arms are from its focus.
        let reach = (self.c / self.d).sqrt().max(miss - self.radius) + self.radius;
        (at, reach / along.length().max(f64::MIN_POSITIVE))
    }

    /// What of a vector counts: all but what runs along a line.
    fn across(&self, way: DVec3) -> DVec3 {
        self.line.map_or(way, |line| way - way.dot(line) * line)
    }

    #[inline(always)]
    fn relative<N: Num>(&self, x: V3<N>) -> V3<N> {
        let way = x - V3::lit(x.x, self.center);
        let Some(line) = self.line else { return way };
        let line = V3::lit(x.x, line);
        way - line.scale(way.dot(line))
    }

    /// At a point [1/m].
    #[inline(always)]
    pub fn at<N: Num>(&self, x: V3<N>) -> N {
        let way = self.relative(x);
        let one = x.x.lit(1.0);
        let square = if self.radius > 0.0 {
            let outside = way.length_squared().sqrt() - one.lit(self.radius);
            outside.max(one.lit(0.0)).squared()
        } else {
            way.length_squared()
        };
        one.lit(self.strength) / square.mul_add(one.lit(self.d), one.lit(self.c))
    }

    /// Its mean between two points [1/m].
    #[inline(always)]
    pub fn mean<N: Num>(&self, a: V3<N>, b: V3<N>) -> N {
        let one = a.x.lit(1.0);
        if self.d == 0.0 {
            return one.lit(self.strength / self.c);
        }
        let (from, to) = (self.relative(a), self.relative(b));
        let way = to - from;
        let length = way.length_squared().sqrt();
        let is_there = one.lit(0.0).lt(length);
        let safe = N::select(is_there, length, one);
        let along = way.scale(one / safe);
        let miss2 = from.cross(along).length_squared();
        let ends = [from.dot(along), to.dot(along)];
        let sum = if self.radius > 0.0 {
            self.around_sphere(miss2, ends)
        } else {
            let m2 = miss2 + one.lit(self.c / self.d);
            let m = m2.sqrt();
            let angle = N::angle(m * length, ends[0].mul_add(ends[1], m2));
            angle / (m * one.lit(self.d))
        };
        N::select(is_there, sum * one.lit(self.strength) / safe, self.at(a))
    }

    /// ∫ ds/(c + d r²) along a line that passes the sphere's middle at that squared distance, between two
    /// places counted from where it is nearest.
    #[inline(always)]
    fn around_sphere<N: Num>(&self, miss2: N, [from, to]: [N; 2]) -> N {
        let (zero, radius) = (from.lit(0.0), from.lit(self.radius));
        let half = (radius.squared() - miss2).max(zero).sqrt();
        let inside = (to.min(half) - from.max(-half)).max(zero);
        // What lies before the sphere is the mirror image of what lies behind it.
        let before = [half.max(-to), (-from).max(half)];
        let behind = [half.max(from), to.max(half)];
        let outside = self.outside(miss2, before) + self.outside(miss2, behind);
        inside.mul_add(zero.lit(1.0 / self.c), outside)
    }

    /// The same outside of the sphere, behind it.
    #[inline(always)]
    fn outside<N: Num>(&self, miss2: N, [from, to]: [N; 2]) -> N {
        let e = (self.c / self.d).sqrt();
        let z = Complex::new(from.lit(self.radius), from.lit(e));
        let s = Complex::new(z.re.squared() - z.im.squared() - miss2, z.re * z.im * from.lit(2.0))
            .root();
        let far = Complex::new(z.re + s.re, z.im + s.im);
        // (z + S)(z − S) = m².
        let near = far.conjugate().scale(miss2 / far.square());
        let [first, last] = [Logs::new(far, near, miss2, from), Logs::new(far, near, miss2, to)];
        let difference = Complex::new(
            ((last.far * first.near) / (last.near * first.far)).ln() * from.lit(0.5),
            last.turn - first.turn,
        );
        // Im(z Λ/S) = Im(z S* Λ)/|S|².
        let along = z.times(s.conjugate()).times(difference).im / s.square();
        along * from.lit(1.0 / (self.d * e))
    }

    /// As the shader reads it.
    pub fn words(&self) -> Words {
        let kind = if self.line.is_some() {
            3.0
        } else if self.radius > 0.0 {
            4.0
        } else {
            2.0
        };
        let line = self.line.unwrap_or_default().as_vec3();
        vec![
            self.center.as_vec3().extend(self.radius as f32),
            line.extend(self.strength as f32),
            Vec4::new(self.c as f32, self.d as f32, 0.0, kind),
        ]
    }
}

/// ln((1 − far·t)/(1 − near·t)) at an end: squared sizes, and the angle of the quotient.
struct Logs<N> {
    far: N,
    near: N,
    turn: N,
}

impl<N: Num> Logs<N> {
    #[inline(always)]
    fn new(far: Complex<N>, near: Complex<N>, miss2: N, s: N) -> Self {
        let one = s.lit(1.0);
        let t = one / (s.mul_add(s, miss2).sqrt() + s).max(one.lit(1e-30));
        let far = Complex::new(one - far.re * t, far.im * t);
        let near = Complex::new(one - near.re * t, -(near.im * t));
        // The imaginary part of the first is below 0, that of the second above.
        let turn = -(N::angle(far.im, far.re) + N::angle(near.im, near.re));
        Self { far: far.square(), near: near.square(), turn }
    }
}

/// A complex number.
#[derive(Clone, Copy)]
struct Complex<N> {
    re: N,
    im: N,
}

impl<N: Num> Complex<N> {
    #[inline(always)]
    fn new(re: N, im: N) -> Self {
        Self { re, im }
    }

    #[inline(always)]
    fn conjugate(self) -> Self {
        Self { re: self.re, im: -self.im }
    }

    #[inline(always)]
    fn scale(self, k: N) -> Self {
        Self { re: self.re * k, im: self.im * k }
    }

    #[inline(always)]
    fn times(self, o: Self) -> Self {
        Self {
            re: self.re.mul_add(o.re, -(self.im * o.im)),
            im: self.re.mul_add(o.im, self.im * o.re),
        }
    }

    /// The square of its size.
    #[inline(always)]
    fn square(self) -> N {
        self.re.mul_add(self.re, self.im * self.im)
    }

    /// The root of a number in the upper half plane that lies in the first quarter; no difference of like
    /// numbers.
    #[inline(always)]
    fn root(self) -> Self {
        let half = self.re.lit(0.5);
        let large = ((self.square().sqrt() + self.re.abs()) * half).sqrt();
        let small = self.im * half / large;
        let is_left = self.re.lt(half.lit(0.0));
        Self { re: N::select(is_left, small, large), im: N::select(is_left, large, small) }
    }
}
