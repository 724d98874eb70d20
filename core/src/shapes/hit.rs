//! First hits of single rays in f64, for probes and picking.

use super::{Cuboid, Geometry, Plane, Solid, Sphere, Triangle};
use glam::DVec3;

/// Where a ray first meets a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray [m].
    pub distance: f64,
    /// Unit normal, on the side of the surface that the ray comes from.
    pub normal: DVec3,
    /// Place among the scene's surfaces.
    pub surface: u32,
}

/// A ray relative to the anchor.
struct Ray {
    origin: DVec3,
    direction: DVec3,
    inverse: DVec3,
}

impl Geometry {
    /// The first surface along a ray in the unit `direction`, no farther than `limit` [m].
    pub fn first_hit(&self, origin: DVec3, direction: DVec3, limit: f64) -> Option<Hit> {
        let ray = Ray { origin: origin - self.anchor, direction, inverse: 1.0 / direction };
        let mut best: Option<Hit> = None;
        let mut keep = |hit: Option<Hit>, limit: &mut f64| {
            if let Some(hit) = hit.filter(|hit| hit.distance <= *limit) {
                *limit = hit.distance;
                best = Some(hit);
            }
        };
        let mut limit = limit;
        for plane in &self.planes {
            keep(plane.meet(&ray), &mut limit);
        }
        let mut stack = vec![0usize];
        while let Some(at) = stack.pop() {
            let Some(node) = self.hierarchy.nodes.get(at) else { break };
            if !ray.meets_box(node.bounds.min.as_dvec3(), node.bounds.max.as_dvec3(), limit) {
                continue;
            }
            let first = node.first as usize;
            if node.count == 0 {
                stack.extend([first, first + 1]);
                continue;
            }
            for solid in &self.solids[first..first + node.count as usize] {
                keep(self.meet(solid, &ray), &mut limit);
            }
        }
        best
    }

    /// Whether a surface that throws shadows stands in the way between two distances [m].
    pub(super) fn is_met(&self, origin: DVec3, direction: DVec3, [from, to]: [f64; 2]) -> bool {
        let start = origin + from * direction - self.anchor;
        let ray = Ray { origin: start, direction, inverse: 1.0 / direction };
        let is_near = |hit: Hit| hit.distance <= to - from && self.throws(hit.surface);
        if self.planes.iter().filter_map(|plane| plane.meet(&ray)).any(is_near) {
            return true;
        }
        let mut stack = vec![0usize];
        while let Some(at) = stack.pop() {
            let Some(node) = self.hierarchy.nodes.get(at) else { break };
            let bounds = &node.bounds;
            if !ray.meets_box(bounds.min.as_dvec3(), bounds.max.as_dvec3(), to - from) {
                continue;
            }
            let first = node.first as usize;
            if node.count == 0 {
                stack.extend([first, first + 1]);
                continue;
            }
            let mut solids = self.solids[first..first + node.count as usize].iter();
            if solids.any(|solid| self.meet(solid, &ray).is_some_and(is_near)) {
                return true;
            }
        }
        false
    }

    fn meet(&self, solid: &Solid, ray: &Ray) -> Option<Hit> {
        match *solid {
            Solid::Triangle(at) => self.meet_triangle(&self.triangles[at as usize], ray),
            Solid::Sphere(at) => self.spheres[at as usize].meet(ray),
            Solid::Cuboid(at) => self.cuboids[at as usize].meet(ray),
        }
    }

    fn meet_triangle(&self, triangle: &Triangle, ray: &Ray) -> Option<Hit> {
        let [a, b, c] = triangle.corners.map(|corner| corner.as_dvec3() - ray.origin);
        let d = ray.direction;
        let [u, v, w] = [d.dot(c.cross(b)), d.dot(a.cross(c)), d.dot(b.cross(a))];
        let sum = u + v + w;
        let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
        if !inside || sum == 0.0 {
            return None;
        }
        let face = (b - a).cross(c - a);
        let distance = a.dot(face) / d.dot(face);
        let normal = match self.smooth.get(triangle.smooth as usize) {
            None => toward(d, face, face),
            Some(normals) => {
                let [na, nb, nc] = normals.map(|n| n.as_dvec3());
                toward(d, face, (u * na + v * nb + w * nc) / sum)
            }
        };
        let hit = Hit { distance, normal: normal.normalize_or_zero(), surface: triangle.surface };
        (distance > 0.0).then_some(hit)
    }
}

/// A normal, on the side that the ray comes from. A smooth one belongs to the side of its face, and at a silhouette may
/// look a little away from the eye.
fn toward(direction: DVec3, face: DVec3, normal: DVec3) -> DVec3 {
    let is_behind = (face.dot(direction) > 0.0) != (face.dot(normal) < 0.0);
    if is_behind { -normal } else { normal }
}

impl Plane {
    fn meet(&self, ray: &Ray) -> Option<Hit> {
        let speed = self.normal.dot(ray.direction);
        let distance = self.normal.dot(self.point - ray.origin) / speed;
        let normal = toward(ray.direction, self.normal, self.normal);
        let hit = Hit { distance, normal, surface: self.surface };
        (speed != 0.0 && distance > 0.0).then_some(hit)
    }
}

impl Sphere {
    fn meet(&self, ray: &Ray) -> Option<Hit> {
        let to = self.center.as_dvec3() - ray.origin;
        let radius = f64::from(self.radius);
        let along = to.dot(ray.direction);
        let half2 = radius * radius - to.cross(ray.direction).length_squared();
        let half = (half2 >= 0.0).then(|| half2.sqrt())?;
        let distance = nearest([along - half, along + half])?;
        let normal = (distance * ray.direction - to) / radius;
        let normal = toward(ray.direction, normal, normal);
        Some(Hit { distance, normal, surface: self.surface })
    }
}

impl Cuboid {
    fn meet(&self, ray: &Ray) -> Option<Hit> {
        let Self { min, max, surface } = *self;
        let (near, far) = ray.box_range(min.as_dvec3(), max.as_dvec3());
        let distance = (near <= far).then(|| nearest([near, far]))??;
        let middle = 0.5 * (min + max).as_dvec3();
        let half = 0.5 * (max - min).as_dvec3();
        let at = (ray.origin + distance * ray.direction - middle) / half;
        let axis = usize::from(at.y.abs() > at.x.abs());
        let axis = if at.z.abs() > at[axis].abs() { 2 } else { axis };
        let normal = toward(ray.direction, DVec3::AXES[axis], DVec3::AXES[axis]);
        Some(Hit { distance, normal, surface })
    }
}

impl Ray {
    /// Where the ray enters and leaves a box.
    fn box_range(&self, min: DVec3, max: DVec3) -> (f64, f64) {
        let a = (min - self.origin) * self.inverse;
        let b = (max - self.origin) * self.inverse;
        // 0 · ∞ where the ray runs within a side: f64::min and max pass over that NaN.
        let near = a.x.min(b.x).max(a.y.min(b.y)).max(a.z.min(b.z));
        let far = a.x.max(b.x).min(a.y.max(b.y)).min(a.z.max(b.z));
        (near, far)
    }

    fn meets_box(&self, min: DVec3, max: DVec3, limit: f64) -> bool {
        let (near, far) = self.box_range(min, max);
        near <= far && far >= 0.0 && near <= limit
    }
}

/// The smaller positive one of two ascending distances.
fn nearest([near, far]: [f64; 2]) -> Option<f64> {
    if near > 0.0 {
        Some(near)
    } else if far > 0.0 {
        Some(far)
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use crate::progress::Progress;
    use crate::scene::{Scene, read};
    use crate::shapes::Geometry;
    use glam::DVec3;

    fn geometry(surfaces: &str) -> Geometry {
        let json = format!("{{\"surfaces\": {surfaces}}}");
        let scene: Scene = read(json.as_bytes()).expect("valid JSON");
        let scene = scene.check().expect("valid scene");
        Geometry::build(&scene.surfaces, &Progress::default()).expect("in time")
    }

    /// A box is closed and may be seen from inside; its normal always faces the ray.
    #[test]
    fn a_box_is_met_from_both_sides() {
        let geometry =
            geometry(r#"[{"shape": {"kind": "box", "min": [-1, -1, -1], "max": [1, 1, 1]}}]"#);
        let outside = geometry.first_hit(DVec3::new(0.2, 0.1, 5.0), DVec3::NEG_Z, 1e4).unwrap();
        assert!((outside.distance - 4.0).abs() < 1e-9 && outside.normal == DVec3::Z);
        let inside = geometry.first_hit(DVec3::ZERO, DVec3::X, 1e4).unwrap();
        assert!((inside.distance - 1.0).abs() < 1e-9 && inside.normal == DVec3::NEG_X);
    }

    /// A smooth normal belongs to the side of its face: where it looks away from a ray that sees that side it stays, from
    /// behind it turns, whichever way round the corners are named.
    #[test]
    fn a_smooth_normal_stays_on_its_side() {
        for indices in ["[0, 1, 2]", "[0, 2, 1]"] {
            let geometry = geometry(&format!(
                r#"[{{"shape": {{"kind": "mesh", "positions": [[-1, -1, 0], [1, -1, 0], [0, 1, 0]],
                    "indices": [{indices}], "normals": [[0.9, 0, 0.4], [0.9, 0, 0.4], [0.9, 0, 0.4]]}}}}]"#
            ));
            let normal = DVec3::new(0.9, 0.0, 0.4).normalize();
            for (from, wanted) in
                [(DVec3::new(-5.0, 0.0, 1.0), normal), (DVec3::new(5.0, 0.0, -1.0), -normal)]
            {
                let hit = geometry.first_hit(from, -from.normalize(), 1e4).unwrap();
                assert!((hit.normal - wanted).length() < 1e-6, "{from}: {}", hit.normal);
            }
        }
    }

    /// Nested boxes, in whatever order: a ray meets the outermost one, from wherever it comes.
    #[test]
    fn the_outermost_of_nested_boxes_is_met() {
        for count in [140, 1_000, 10_000] {
            let half = |i: usize| 1.0 + i as f64 * 1e-3;
            let each = |i| {
                let h = half(i);
                format!(
                    r#"{{"shape": {{"kind": "box", "min": [-{h},-{h},-{h}], "max": [{h},{h},{h}]}}}}"#
                )
            };
            let boxes: Vec<_> = (0..count).map(each).collect();
            let geometry = geometry(&format!("[{}]", boxes.join(",")));
            let outermost = half(count - 1);
            for axis in DVec3::AXES {
                let from = 100.0 * axis + DVec3::splat(0.3);
                let hit = geometry.first_hit(from, -axis, 1e4).unwrap();
                let exact = 100.3 - outermost;
                assert!((hit.distance - exact).abs() < 1e-5, "{} of {count}", hit.distance);
            }
            let hit = geometry.first_hit(DVec3::ZERO, DVec3::X, 1e4).unwrap();
            assert!((hit.distance - half(0)).abs() < 1e-5, "{} from within {count}", hit.distance);
        }
    }

    /// Two triangles that share an edge leave no gap along it.
    #[test]
    fn shared_edges_are_tight() {
        let geometry = geometry(
            r#"[{"shape": {"kind": "mesh", "positions": [[-1,-1,0],[1,-1,0],[1,1,0],[-1,1,0]],
                 "indices": [[0,1,2],[0,2,3]]}}]"#,
        );
        for i in 0..100 {
            let x = -0.99 + 0.0198 * f64::from(i);
            let hit = geometry.first_hit(DVec3::new(x, x, 3.0), DVec3::NEG_Z, 1e4);
            assert!(hit.is_some(), "gap at {x}");
        }
    }
}
