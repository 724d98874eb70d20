//! What surfaces hide of a light, exactly and in f64: parts of a ray, and single points.
//!
//! A point is in the shadow of a triangle if it lies behind its plane and within the planes through its sides and the
//! light. Along a ray each of these is a linear inequality, so a triangle hides one part of a ray. What is round
//! or hollow is asked in the middle of the parts between all places where its answer may change.

use super::{Cuboid, Geometry, Hit, Plane, Solid, Sphere, Triangle};
use crate::geometry::{Beyond, Origin, Ray};
use glam::DVec3;

/// Parts of a ray closer than this share of where they are belong together: what rounding leaves of a common side.
const TOUCH: f64 = 1e-9;
/// A way to a light begins this share of the scene's coordinates off the surface: corners are in f32.
const OFF: f64 = 1e-6;
/// A light this share of the coordinates beside the plane of a triangle lies in it: corners are in f32.
pub const IN_PLANE: f64 = 1e-6;

/// Ways to lights begin this share of the eye's distance above a surface, along its normal: a third of a pixel of a usual
/// picture. Triangles with smooth normals are rougher than they look, by what their corners are rounded to.
pub const LIFT: f64 = 4e-4;
/// In pictures a point is behind a plane from this share of its distance on: some roundings of f32.
pub const BEHIND: f64 = 4e-6;

/// A light and a ray relative to the anchor.
struct Shaded {
    light: Origin,
    start: DVec3,
    direction: DVec3,
    length: f64,
}

impl Geometry {
    /// The parts of a ray up to `length` that a light does not reach, ascending [m].
    pub fn shadows(&self, light: Origin, ray: &Ray, length: f64) -> Vec<[f64; 2]> {
        let light = match light {
            Origin::At(apex) => Origin::At(apex - self.anchor),
            beyond => beyond,
        };
        let shaded =
            Shaded { light, start: ray.origin - self.anchor, direction: ray.direction, length };
        let mut parts: Vec<_> = Vec::new();
        for plane in self.planes.iter().filter(|plane| self.throws(plane.surface)) {
            parts.extend(shaded.by_plane(plane));
        }
        let swept = Swept::new(&shaded);
        let mut stack = vec![0usize];
        while let Some(at) = stack.pop() {
            let Some(node) = self.hierarchy.nodes.get(at) else { break };
            if !swept.meets(node.bounds.min.as_dvec3(), node.bounds.max.as_dvec3()) {
                continue;
            }
            let first = node.first as usize;
            if node.count == 0 {
                stack.extend([first, first + 1]);
                continue;
            }
            for solid in &self.solids[first..first + node.count as usize] {
                match *solid {
                    Solid::Triangle(at) => {
                        let triangle = &self.triangles[at as usize];
                        let throws = self.throws(triangle.surface);
                        parts.extend(shaded.by_triangle(triangle).filter(|_| throws));
                    }
                    Solid::Sphere(at) => {
                        let sphere = &self.spheres[at as usize];
                        if self.throws(sphere.surface) {
                            shaded.by_sphere(sphere, &mut parts);
                        }
                    }
                    Solid::Cuboid(at) => {
                        let cuboid = &self.cuboids[at as usize];
                        if self.throws(cuboid.surface) {
                            shaded.by_cuboid(cuboid, &mut parts);
                        }
                    }
                }
            }
        }
        joined(parts)
    }

    /// Whether a plane stands between a light and an eye: rays end at it, so that none of them sees any of that light.
    pub fn cuts_off(&self, light: Origin, eye: DVec3) -> bool {
        self.planes
            .iter()
            .any(|plane| self.throws(plane.surface) && self.sides(plane, light, eye) < 0.0)
    }

    /// The product of the heights of a light and an eye over a plane.
    fn sides(&self, plane: &Plane, light: Origin, eye: DVec3) -> f64 {
        let height = |point: DVec3| (point - self.anchor - plane.point).dot(plane.normal);
        let of_light = match light {
            Origin::At(apex) => height(apex),
            Origin::Beyond(Beyond { toward, .. }) => toward.dot(plane.normal),
        };
        of_light * height(eye)
    }

    /// Whether a light may be hidden from some of what is seen from an eye, or along parallel rays, which begin anywhere.
    /// Planes with both on one side, and hollow shapes with both inside, end what is seen and hide nothing of it.
    pub fn may_hide(&self, light: Origin, eye: Option<DVec3>) -> bool {
        let Some(eye) = eye else {
            let surfaces = self.planes.iter().map(|plane| plane.surface);
            return surfaces
                .chain(self.solids.iter().map(|solid| self.surface_of(solid)))
                .any(|own| self.throws(own));
        };
        let is_between =
            |plane: &Plane| self.throws(plane.surface) && self.sides(plane, light, eye) <= 0.0;
        let eye = eye - self.anchor;
        let is_within = |min: DVec3, max: DVec3| {
            let within = |point: DVec3| min.cmplt(point).all() && point.cmplt(max).all();
            within(eye) && matches!(light, Origin::At(apex) if within(apex - self.anchor))
        };
        let hides = |solid: &Solid| match *solid {
            Solid::Triangle(at) => self.throws(self.triangles[at as usize].surface),
            Solid::Cuboid(at) => {
                let Cuboid { min, max, surface } = self.cuboids[at as usize];
                self.throws(surface) && !is_within(min.as_dvec3(), max.as_dvec3())
            }
            Solid::Sphere(at) => {
                let Sphere { center, radius, surface } = self.spheres[at as usize];
                let within = |point: DVec3| point.distance(center.as_dvec3()) < radius.into();
                let both =
                    within(eye) && matches!(light, Origin::At(apex) if within(apex - self.anchor));
                self.throws(surface) && !both
            }
        };
        self.planes.iter().any(is_between) || self.solids.iter().any(hides)
    }

    fn surface_of(&self, solid: &Solid) -> u32 {
        match *solid {
            Solid::Triangle(at) => self.triangles[at as usize].surface,
            Solid::Sphere(at) => self.spheres[at as usize].surface,
            Solid::Cuboid(at) => self.cuboids[at as usize].surface,
        }
    }

    /// Whether a surface throws shadows.
    pub fn throws(&self, surface: u32) -> bool {
        self.throwing[surface as usize]
    }

    /// Whether a surface stands between a light and what a ray has met.
    pub fn hides_hit(&self, light: Origin, point: DVec3, hit: &Hit) -> bool {
        self.hides(light, point + LIFT * hit.distance * hit.normal)
    }

    /// Whether a surface stands between a light and a point.
    pub fn hides(&self, light: Origin, point: DVec3) -> bool {
        let local = point - self.anchor;
        let off = OFF * local.abs().max_element();
        let (direction, distance) = match light {
            Origin::At(apex) => {
                let way = apex - point;
                (way.normalize_or_zero(), way.length())
            }
            Origin::Beyond(Beyond { toward, .. }) => (toward, f64::INFINITY),
        };
        direction != DVec3::ZERO && self.is_met(point, direction, [off, distance - off])
    }
}

/// The same parts, those that overlap or touch as one.
fn joined(mut parts: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    parts.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
    let mut all: Vec<[f64; 2]> = Vec::with_capacity(parts.len());
    for [from, to] in parts {
        match all.last_mut() {
            Some(last) if from <= last[1] * (1.0 + TOUCH) => last[1] = last[1].max(to),
            _ => all.push([from, to]),
        }
    }
    all
}

/// The part of a ray on which some linear functions are not negative.
struct Within {
    from: f64,
    to: f64,
}

impl Within {
    /// Keeps where value + t · slope ≥ 0.
    fn keep(&mut self, value: f64, slope: f64) {
        if slope > 0.0 {
            self.from = self.from.max(-value / slope);
        } else if slope < 0.0 {
            self.to = self.to.min(-value / slope);
        } else if value < 0.0 {
            self.to = f64::NEG_INFINITY;
        }
    }

    fn part(self) -> Option<[f64; 2]> {
        (self.from < self.to).then_some([self.from, self.to])
    }
}

impl Shaded {
    fn all(&self) -> Within {
        Within { from: 0.0, to: self.length }
    }

    /// On which side of a plane through `point` the light is; 0 in the plane, but for a share of the coordinates.
    fn side(&self, normal: DVec3, point: DVec3, share: f64) -> f64 {
        let (height, scale) = match self.light {
            Origin::At(apex) => ((apex - point).dot(normal), apex.abs() + point.abs()),
            Origin::Beyond(Beyond { toward, .. }) => (toward.dot(normal), toward.abs()),
        };
        if height.abs() <= share * scale.dot(normal.abs()) { 0.0 } else { height.signum() }
    }

    /// Behind a plane as the light sees it.
    fn behind(&self, normal: DVec3, point: DVec3, side: f64) -> Within {
        let mut within = self.all();
        let height = (self.start - point).dot(normal);
        within.keep(-side * height, -side * self.direction.dot(normal));
        within
    }

    fn by_plane(&self, plane: &Plane) -> Option<[f64; 2]> {
        let side = self.side(plane.normal, plane.point, 1e-12);
        if side == 0.0 { None } else { self.behind(plane.normal, plane.point, side).part() }
    }

    fn by_triangle(&self, triangle: &Triangle) -> Option<[f64; 2]> {
        let corners = triangle.corners.map(|corner| corner.as_dvec3());
        let [a, b, c] = corners;
        let face = (b - a).cross(c - a);
        let side = self.side(face, a, IN_PLANE);
        if side == 0.0 {
            return None;
        }
        let mut within = self.behind(face, a, side);
        for [from, to] in [[a, b], [b, c], [c, a]] {
            let (normal, on) = match self.light {
                Origin::At(apex) => ((from - apex).cross(to - apex), apex),
                Origin::Beyond(Beyond { toward, .. }) => ((to - from).cross(toward), from),
            };
            // As it is seen from the light, the triangle lies on one side of all three.
            let normal = -side * normal;
            within.keep((self.start - on).dot(normal), self.direction.dot(normal));
        }
        within.part()
    }

    fn by_sphere(&self, sphere: &Sphere, parts: &mut Vec<[f64; 2]>) {
        let (center, radius) = (sphere.center.as_dvec3(), f64::from(sphere.radius));
        let mut places = Vec::with_capacity(6);
        let from = self.start - center;
        let (d, r2) = (self.direction, radius * radius);
        roots([1.0, from.dot(d), from.length_squared() - r2], &mut places);
        match self.light {
            Origin::At(apex) => {
                // The cone that touches it: (x·a)² = |x|² (|a|² − r²), both as seen from the light.
                let (a, x) = (center - apex, self.start - apex);
                let tangent2 = a.length_squared() - r2;
                let form = |p: DVec3, q: DVec3| p.dot(a) * q.dot(a) - p.dot(q) * tangent2;
                roots([form(d, d), form(x, d), form(x, x)], &mut places);
            }
            Origin::Beyond(Beyond { toward, .. }) => {
                let (p, q) = (from.cross(toward), d.cross(toward));
                roots([q.length_squared(), p.dot(q), p.length_squared() - r2], &mut places);
            }
        }
        self.between(places, parts, |point| {
            let (way, length) = self.way(point);
            let to = center - point;
            let along = to.dot(way);
            let half2 = r2 - to.cross(way).length_squared();
            let half = half2.max(0.0).sqrt();
            half2 > 0.0 && [along - half, along + half].iter().any(|t| 0.0 < *t && *t < length)
        });
    }

    fn by_cuboid(&self, cuboid: &Cuboid, parts: &mut Vec<[f64; 2]>) {
        let (min, max) = (cuboid.min.as_dvec3(), cuboid.max.as_dvec3());
        let mut places = Vec::with_capacity(32);
        let mut passes =
            |value: f64, slope: f64| places.extend((slope != 0.0).then(|| -value / slope));
        for axis in 0..3 {
            for bound in [min, max] {
                passes(self.start[axis] - bound[axis], self.direction[axis]);
            }
            // The planes through the light and the sides along this axis.
            let along = DVec3::AXES[axis];
            for i in 0..4 {
                let mut corner = min;
                let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
                if i & 1 == 1 {
                    corner[b] = max[b];
                }
                if i & 2 == 2 {
                    corner[c] = max[c];
                }
                let normal = match self.light {
                    Origin::At(apex) => along.cross(corner - apex),
                    Origin::Beyond(Beyond { toward, .. }) => along.cross(toward),
                };
                passes((self.start - corner).dot(normal), self.direction.dot(normal));
            }
        }
        self.between(places, parts, |point| {
            let (way, length) = self.way(point);
            let (a, b) = ((min - point) / way, (max - point) / way);
            let near = a.x.min(b.x).max(a.y.min(b.y)).max(a.z.min(b.z));
            let far = a.x.max(b.x).min(a.y.max(b.y)).min(a.z.max(b.z));
            near < far && [near, far].iter().any(|t| 0.0 < *t && *t < length)
        });
    }

    /// The unit vector from a point to the light, and how far that is [m].
    fn way(&self, point: DVec3) -> (DVec3, f64) {
        match self.light {
            Origin::At(apex) => {
                let way = apex - point;
                (way.normalize_or(DVec3::Z), way.length())
            }
            Origin::Beyond(Beyond { toward, .. }) => (toward, f64::INFINITY),
        }
    }

    /// Asks in the middle between some places.
    fn between(
        &self,
        mut places: Vec<f64>,
        parts: &mut Vec<[f64; 2]>,
        is_hidden: impl Fn(DVec3) -> bool,
    ) {
        places.retain(|t| 0.0 < *t && *t < self.length);
        places.extend([0.0, self.length]);
        places.sort_unstable_by(f64::total_cmp);
        for pair in places.windows(2) {
            let middle = self.start + 0.5 * (pair[0] + pair[1]) * self.direction;
            if pair[0] < pair[1] && is_hidden(middle) {
                parts.push([pair[0], pair[1]]);
            }
        }
    }
}

/// Solutions of a t² + 2 b t + c = 0.
fn roots([a, b, c]: [f64; 3], all: &mut Vec<f64>) {
    let under = b * b - a * c;
    if under < 0.0 {
        return;
    }
    // The sum that does not cancel first.
    let far = -b - under.sqrt().copysign(b);
    all.extend((a != 0.0).then(|| far / a));
    all.extend((far != 0.0).then(|| c / far));
}

/// The flat region between a ray and a light: what stands in it throws a shadow on the ray.
struct Swept {
    min: DVec3,
    max: DVec3,
    on: DVec3,
    normal: DVec3,
}

impl Swept {
    fn new(shaded: &Shaded) -> Self {
        let Shaded { light, start, direction, length } = *shaded;
        let end = start + length * direction;
        let (mut min, mut max) = (start.min(end), start.max(end));
        let across = match light {
            Origin::At(apex) => {
                (min, max) = (min.min(apex), max.max(apex));
                direction.cross(apex - start)
            }
            Origin::Beyond(Beyond { toward, .. }) => {
                for axis in 0..3 {
                    if toward[axis] > 0.0 {
                        max[axis] = f64::INFINITY;
                    } else if toward[axis] < 0.0 {
                        min[axis] = f64::NEG_INFINITY;
                    }
                }
                direction.cross(toward)
            }
        };
        Self { min, max, on: start, normal: across.normalize_or_zero() }
    }

    fn meets(&self, min: DVec3, max: DVec3) -> bool {
        if min.cmpgt(self.max).any() || max.cmplt(self.min).any() {
            return false;
        }
        let (middle, half) = (0.5 * (min + max), 0.5 * (max - min));
        let reach = half.dot(self.normal.abs());
        let room = 1e-9 * (middle.abs() + self.on.abs()).max_element();
        (middle - self.on).dot(self.normal).abs() <= reach + room
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Progress;
    use crate::random::Random;
    use crate::scene::{Scene, read};

    fn geometry(surfaces: &str) -> Geometry {
        let scene: Scene = read(format!("{{\"surfaces\": {surfaces}}}").as_bytes()).unwrap();
        Geometry::build(&scene.check().unwrap().surfaces, &Progress::default()).unwrap()
    }

    /// Wherever the light is, in a box or out of it: a place of a ray is in a part that is told if and only if
    /// something stands between it and the light.
    #[test]
    fn parts_of_a_ray_are_hidden_where_its_points_are() {
        let geometry = geometry(
            r#"[{"shape": {"kind": "plane", "point": [0, -2, 0], "normal": [0.1, 1, 0]}},
                {"shape": {"kind": "sphere", "center": [1, 0, 0.5], "radius": 0.8}},
                {"shape": {"kind": "box", "min": [-2, -1, -1], "max": [-0.5, 1.5, 0.4]}},
                {"shape": {"kind": "mesh", "positions": [[0, 1, -1], [1.5, 2, 0], [-0.5, 2, 1.5], [2, 1, 2]],
                           "indices": [[0, 1, 2], [1, 3, 2]]}}]"#,
        );
        let mut random = Random::new(7);
        let mut point =
            |reach: f64| DVec3::from_array([0, 1, 2].map(|_| random.between(-reach, reach)));
        let (mut hidden, mut all) = (0, 0);
        for i in 0..3000 {
            let light = if i % 3 == 0 {
                Origin::Beyond(Beyond { toward: point(1.0).normalize(), path_m: 1.0 })
            } else {
                Origin::At(point(3.0))
            };
            let (ray, length) = Ray::between(point(4.0), point(4.0));
            let parts = geometry.shadows(light, &ray, length);
            for k in 0..20 {
                let t = length * (f64::from(k) + 0.5) / 20.0;
                if parts.iter().flatten().any(|end| (end - t).abs() < 1e-4) {
                    continue;
                }
                let is_hidden = parts.iter().any(|[from, to]| *from <= t && t <= *to);
                assert_eq!(is_hidden, geometry.hides(light, ray.at(t)), "{light:?} {ray:?} {t}");
                hidden += usize::from(is_hidden);
                all += 1;
            }
        }
        assert!(all > 50_000 && all / 4 < hidden && hidden < 3 * all / 4, "{hidden} of {all}");
    }

    /// What two triangles hide that share a side has no gap.
    #[test]
    fn a_wall_of_triangles_lets_no_light_through() {
        let geometry = geometry(
            r#"[{"shape": {"kind": "mesh", "positions": [[-1,-1,0],[1,-1,0],[1,1,0],[-1,1,0]],
                 "indices": [[0,1,2],[0,2,3]]}}]"#,
        );
        for i in 0..100 {
            let height = 0.3 * f64::from(i) / 100.0;
            let (ray, length) =
                Ray::between(DVec3::new(-0.4, height, 1.0), DVec3::new(0.4, height + 0.1, 1.0));
            let parts = geometry.shadows(Origin::At(DVec3::new(0.1, 0.2, -2.0)), &ray, length);
            assert_eq!(parts, [[0.0, length]]);
        }
    }
}
