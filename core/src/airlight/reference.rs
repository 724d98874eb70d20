//! The airlight integral itself (Fogshop 2, Sun 3), by adaptive quadrature in f64: closed-form T on
//! both legs, no closed form of airlight. Slow; what every other method is measured against.
//!
//! With t = t_s + h sinh u the factor dt/d² is du/d: a light close to the ray costs no accuracy, and
//! the integrand stays smooth. Panels are first halved until none is long against the blobs that
//! it crosses, so that no blob is overlooked, then where the Gauss–Kronrod pair differs most.
//! Relative error below 1e-6; scattering is isotropic.

use super::ToLight;
use crate::media::gaussians::Gaussian;
use crate::media::{Field, toward};
use crate::quadrature;
use glam::DVec3;

/// L_a per unit of ω·I₀ [1/m²] of a light, along a ray in the unit `direction` up to `length` [m].
pub fn airlight(field: &Field, light: DVec3, origin: DVec3, direction: DVec3, length: f64) -> f64 {
    if length <= 0.0 || field.is_empty() {
        return 0.0;
    }
    let path = Path::new(field, light, origin, direction, length);
    let panels = path.panels(length);
    quadrature::adaptive(&panels, 1e-7, |u| path.integrand(u)) / (4.0 * std::f64::consts::PI)
}

/// A blob that the view ray meets.
struct Met {
    blob: Gaussian,
    /// Ray parameter of its closest point [m].
    at: f64,
    /// Squared distance of the ray from its centre in units of its radius.
    miss2: f64,
    /// erf at the ray's origin.
    erf_start: f64,
}

struct Path {
    beta: f64,
    to_light: ToLight<f64>,
    light: DVec3,
    origin: DVec3,
    direction: DVec3,
    met: Vec<Met>,
    /// Blobs between the light and the ray.
    shading: Vec<Gaussian>,
}

impl Path {
    fn new(field: &Field, light: DVec3, origin: DVec3, direction: DVec3, length: f64) -> Self {
        let mut met = Vec::new();
        field.near_segment(origin, direction, length, |blob| {
            let at = (blob.center - origin).dot(direction);
            let miss = (blob.center - origin).cross(direction).length() * blob.a;
            let erf_start = libm::erf(-blob.a * at);
            met.push(Met { blob: *blob, at, miss2: miss * miss, erf_start });
            0.0
        });
        Self {
            beta: field.homogeneous.beta,
            to_light: ToLight::new((light - origin).into(), direction.into(), length),
            light,
            origin,
            direction,
            met,
            shading: field.near_triangle(light, origin, origin + length * direction),
        }
    }

    fn u(&self, t: f64) -> f64 {
        ((t - self.to_light.closest) / self.to_light.miss).asinh()
    }

    fn t(&self, u: f64) -> f64 {
        self.to_light.closest + self.to_light.miss * u.sinh()
    }

    /// β e^(−T(v,x)−T(x,s)) / d, the integrand over u.
    fn integrand(&self, u: f64) -> f64 {
        let t = self.t(u);
        let x = self.origin + t * self.direction;
        let (mut beta, mut depth) = (self.beta, self.beta * t);
        for Met { blob, at, miss2, erf_start } in &self.met {
            let s = blob.a * (t - at);
            beta += blob.c * (-miss2 - s * s).exp();
            depth += blob.half_depth() * (-miss2).exp() * (libm::erf(s) - erf_start);
        }
        let (direction, distance) = toward(self.light, x);
        // The lamp's distance as the falloff counts it, floor included.
        let floored = self.to_light.miss * u.cosh();
        depth += self.beta * floored;
        for blob in &self.shading {
            depth += blob.optical_depth_if_near(self.light, direction, distance);
        }
        beta * (-depth).exp() / floored
    }

    /// Ends of panels in u, each short against the blobs that it crosses.
    fn panels(&self, length: f64) -> Vec<f64> {
        let mut ends = vec![0.0];
        let mut open = vec![length];
        if (0.0..length).contains(&self.to_light.closest) {
            open.push(self.to_light.closest);
        }
        while let Some(&end) = open.last() {
            let start = ends[ends.len() - 1];
            if end - start > self.resolution(start, end) && ends.len() < 4096 {
                open.push(0.5 * (start + end));
            } else {
                ends.push(end);
                open.pop();
            }
        }
        ends.iter().map(|t| self.u(*t)).collect()
    }

    /// The longest panel that still sees every blob between two ray parameters [m].
    fn resolution(&self, start: f64, end: f64) -> f64 {
        const RADII: f64 = 5.0;
        let crossed = self.met.iter().filter(|met| {
            let radius = 1.0 / met.blob.a;
            let counts = met.blob.half_depth() * (-met.miss2).exp() > 1e-9;
            counts && met.at + 4.0 * radius > start && met.at - 4.0 * radius < end
        });
        crossed.map(|met| RADII / met.blob.a).fold(f64::INFINITY, f64::min)
    }
}
