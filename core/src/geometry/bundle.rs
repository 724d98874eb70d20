//! Rays that run close together, bounded by a cone: what a tile of pixels or a group of points
//! sees, so that blobs and boxes that none of them meets are left out at once.

use glam::DVec3;

/// A cone with a blunt tip that holds all its rays: at the distance z along the axis they lie
/// within `radius + z · tan` of it, for 0 ≤ z ≤ `length`.
#[derive(Clone, Copy, Debug)]
pub struct Bundle {
    /// Where the axis starts [m].
    pub origin: DVec3,
    /// Unit vector.
    pub axis: DVec3,
    /// Radius at the origin [m].
    pub radius: f64,
    /// Tangent of the half angle.
    pub tan: f64,
    /// Where the longest ray ends [m].
    pub length: f64,
}

/// Where a point lies relative to a [`Bundle`].
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Coordinate along the axis [m].
    pub along: f64,
    /// Distance from the axis [m].
    pub aside: f64,
}

impl Bundle {
    /// Bounds rays `(origin, unit direction)` no longer than `length`.
    ///
    /// `None` when they spread over more than 80° from their mean direction.
    pub fn around(rays: &[(DVec3, DVec3)], length: f64) -> Option<Self> {
        let count = rays.len() as f64;
        let origin = rays.iter().map(|r| r.0).sum::<DVec3>() / count;
        let axis = rays.iter().map(|r| r.1).sum::<DVec3>().normalize_or_zero();
        let cos = rays.iter().map(|r| r.1.dot(axis)).fold(1.0, f64::min);
        if cos < 0.17 {
            return None;
        }
        let ball = rays.iter().map(|r| r.0.distance(origin)).fold(0.0, f64::max);
        // 1e-7: room for the rounding of f32 pixel rays.
        let tan = (1.0 - cos * cos).max(0.0).sqrt() / cos + 1e-7;
        // The cone whose surface touches the ball of all origins.
        let radius = ball * (1.0 + tan * tan).sqrt();
        Some(Self { origin, axis, radius, tan, length: length + ball })
    }

    /// Bounds the segments from `origin` to all points of a ball; `None` when it reaches around
    /// the origin.
    pub fn toward_ball(origin: DVec3, center: DVec3, radius: f64) -> Option<Self> {
        let distance = origin.distance(center);
        let sin = radius / distance;
        if sin.is_nan() || sin >= 0.98 {
            return None;
        }
        let tan = sin / (1.0 - sin * sin).sqrt() + 1e-7;
        let axis = (center - origin) / distance;
        Some(Self { origin, axis, radius: 0.0, tan, length: distance + radius })
    }

    /// Rays from `origin` into all directions: a ball, of which every point may be met.
    pub fn all_around(origin: DVec3, length: f64) -> Self {
        Self { origin, axis: DVec3::Z, radius: length, tan: 0.0, length }
    }

    /// Coordinates of a point relative to the axis.
    pub fn place(&self, point: DVec3) -> Place {
        let to = point - self.origin;
        let along = to.dot(self.axis);
        Place { along, aside: to.cross(self.axis).length() }
    }

    /// Lower bound of the distance from a point to any of the rays [m].
    pub fn distance(&self, place: Place) -> f64 {
        let cos = 1.0 / (1.0 + self.tan * self.tan).sqrt();
        let side = (place.aside - self.radius - place.along * self.tan) * cos;
        if place.along <= self.length {
            return side.max(-place.along - self.radius).max(0.0);
        }
        let rim = (place.aside - self.radius - self.length * self.tan).max(0.0);
        rim.hypot(place.along - self.length)
    }

    /// Upper bound of the distance from a point to the line of any of the rays [m].
    pub fn farthest_miss(&self, place: Place) -> f64 {
        place.aside + self.radius + place.along.abs() * self.tan
    }

    /// Bounds of where along its ray any ray passes closest to the point [m].
    pub fn closest_approach(&self, place: Place) -> (f64, f64) {
        let cos = 1.0 / (1.0 + self.tan * self.tan).sqrt();
        let sin = self.tan * cos;
        let Place { along, aside } = place;
        // Inside the cone, or inside its mirror image behind the origin, some ray meets the point.
        let within = aside <= along.abs() * self.tan;
        let full = along.hypot(aside);
        let low = if within && along < 0.0 { -full } else { along * cos - aside * sin };
        let high = if within && along > 0.0 { full } else { along * cos + aside * sin };
        (low - self.radius, high + self.radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vector(range: f64) -> impl Strategy<Value = DVec3> {
        (-range..range, -range..range, -range..range).prop_map(|(x, y, z)| DVec3::new(x, y, z))
    }

    fn distance_to_ray(point: DVec3, (origin, direction): (DVec3, DVec3), length: f64) -> f64 {
        let t = (point - origin).dot(direction).clamp(0.0, length);
        point.distance(origin + t * direction)
    }

    proptest! {
        /// No ray of a bundle passes a point closer than the bundle's bound says.
        #[test]
        fn the_bounds_hold(
            center in vector(5.0),
            spread in 0.0f64..0.6,
            shift in 0.0f64..2.0,
            turns in prop::collection::vec((vector(1.0), vector(1.0)), 1..6),
            point in vector(20.0),
            length in 0.1f64..30.0,
        ) {
            let rays: Vec<_> = turns
                .iter()
                .map(|(turn, offset)| {
                    let direction = (DVec3::NEG_Z + spread * *turn).normalize();
                    (center + shift * *offset, direction)
                })
                .collect();
            let Some(bundle) = Bundle::around(&rays, length) else { return Ok(()) };
            let place = bundle.place(point);
            let (low, high) = bundle.closest_approach(place);
            for ray in rays {
                let reach = distance_to_ray(point, ray, length);
                prop_assert!(bundle.distance(place) <= reach + 1e-9);
                let t = (point - ray.0).dot(ray.1);
                prop_assert!(low <= t + 1e-6 && t <= high + 1e-6, "{low} {t} {high}");
                let miss = (point - ray.0 - t * ray.1).length();
                prop_assert!(miss <= bundle.farthest_miss(place) + 1e-6);
            }
        }
    }
}
