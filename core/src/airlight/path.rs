//! The medium along one view ray and from there to one light, exact and in f64: what the methods
//! that sum up the integrand itself have in common.

use super::ToLight;
use crate::media::gaussians::Gaussian;
use crate::media::{Field, toward};
use crate::progress::{Progress, Watch};
use glam::DVec3;

/// Radii from its middle on a ray at which a blob has ended there: exp(−4²) is 1e-7.
pub const ENDS: f64 = 4.0;

/// A blob that the view ray meets.
struct Met {
    /// Scale a [1/m].
    a: f64,
    /// Ray parameter of its closest point [m].
    at: f64,
    /// Its extinction there [1/m].
    peak: f64,
    /// Half of T along the whole line.
    half_depth: f64,
    /// erf at the ray's origin.
    erf_start: f64,
}

/// A view ray and a light, with the blobs that matter to them to rounding.
///
/// When the job that it belongs to is over it has no blobs any more, so that whatever sums them up
/// comes to an end; the sum is for nobody then.
pub(crate) struct Path<'a> {
    beta: f64,
    /// How far the ray goes [m].
    pub length: f64,
    /// Where the light stands.
    pub to_light: ToLight<f64>,
    light: DVec3,
    origin: DVec3,
    direction: DVec3,
    met: Vec<Met>,
    /// Blobs between the light and the ray.
    shading: Vec<Gaussian>,
    watch: Option<Watch<'a>>,
}

/// What a point of the ray gets of the light.
pub(crate) struct Lit {
    /// Distance of the light as the falloff counts it, floor included [m].
    pub distance: f64,
    /// Cosine between the light's direction there and the direction back to the eye.
    pub cos: f64,
    /// T from the light.
    pub depth: f64,
}

impl<'a> Path<'a> {
    /// Gathers the blobs for a ray in the unit `direction` up to `length` [m].
    pub fn new(field: &Field, light: DVec3, origin: DVec3, direction: DVec3, length: f64) -> Self {
        let mut met = Vec::new();
        field.near_segment(origin, direction, length, |blob| {
            let at = (blob.center - origin).dot(direction);
            let miss = (blob.center - origin).cross(direction).length() * blob.a;
            let (through, a) = ((-miss * miss).exp(), blob.a);
            let (peak, half_depth) = (blob.c * through, blob.half_depth() * through);
            met.push(Met { a, at, peak, half_depth, erf_start: libm::erf(-a * at) });
            0.0
        });
        Self {
            beta: field.homogeneous.beta,
            length,
            to_light: ToLight::new((light - origin).into(), direction.into()),
            light,
            origin,
            direction,
            met,
            shading: field.near_triangle(light, origin, origin + length * direction),
            watch: None,
        }
    }

    /// As a part of a job.
    pub fn of(self, progress: &'a Progress) -> Self {
        Self { watch: Some(Watch::new(progress)), ..self }
    }

    fn met(&self) -> &[Met] {
        if self.goes_on(self.met.len()) { &self.met } else { &[] }
    }

    fn shading(&self) -> &[Gaussian] {
        if self.goes_on(self.shading.len()) { &self.shading } else { &[] }
    }

    /// Whether so many blobs may be summed up; a sum of none counts, too.
    fn goes_on(&self, blobs: usize) -> bool {
        self.watch.as_ref().is_none_or(|watch| watch.allows(blobs + 1))
    }

    /// β [1/m] at the ray parameter `t` [m].
    pub fn extinction(&self, t: f64) -> f64 {
        self.beta + self.extinction_of_blobs(t)
    }

    /// The same without the homogeneous fog.
    pub fn extinction_of_blobs(&self, t: f64) -> f64 {
        let blobs = self.met().iter().map(|Met { a, at, peak, .. }| {
            let s = a * (t - at);
            peak * (-s * s).exp()
        });
        blobs.sum()
    }

    /// T from the eye to the ray parameter `t` [m].
    pub fn depth(&self, t: f64) -> f64 {
        self.beta * t + self.depth_of_blobs(t)
    }

    /// The same without the homogeneous fog.
    pub fn depth_of_blobs(&self, t: f64) -> f64 {
        let blobs = self.met().iter().map(|Met { a, at, half_depth, erf_start, .. }| {
            half_depth * (libm::erf(a * (t - at)) - erf_start)
        });
        blobs.sum()
    }

    /// The light at the ray parameter `t` [m].
    pub fn lit(&self, t: f64) -> Lit {
        let (ahead, miss) = (self.to_light.closest - t, self.to_light.miss);
        let distance = ahead.hypot(miss);
        let (direction, length) = toward(self.light, self.origin + t * self.direction);
        let blobs = self.shading().iter();
        let blobs = blobs.map(|blob| blob.optical_depth_if_near(self.light, direction, length));
        let depth = self.beta * distance + blobs.sum::<f64>();
        Lit { distance, cos: ahead / distance, depth }
    }

    /// Whether there is no fog at all on the ray, not even the tails of blobs.
    pub fn is_clear(&self) -> bool {
        self.length <= 0.0 || (self.beta == 0.0 && self.met.is_empty())
    }

    /// From where to where there is fog on the ray [m]; `None` if there is none.
    pub fn span(&self) -> Option<(f64, f64)> {
        if self.beta > 0.0 {
            return (self.length > 0.0).then_some((0.0, self.length));
        }
        self.dense()
    }

    /// The same of the blobs alone.
    pub fn dense(&self) -> Option<(f64, f64)> {
        let from = self.met.iter().map(|met| met.at - ENDS / met.a).fold(f64::INFINITY, f64::min);
        let to = self.met.iter().map(|met| met.at + ENDS / met.a).fold(0.0, f64::max);
        let (from, to) = (from.max(0.0), to.min(self.length));
        (from < to).then_some((from, to))
    }

    /// Where T reaches `opaque` between two ray parameters, else the second one [m].
    pub fn reaches(&self, opaque: f64, from: f64, to: f64) -> f64 {
        let (mut low, mut high) = (from, to);
        if self.depth(to) <= opaque {
            return to;
        }
        // To a thousandth of itself is near enough for an end that nothing is seen of.
        while high - low > 1e-3 * (high - from) && high - low > 1e-12 * high {
            let middle = 0.5 * (low + high);
            if self.depth(middle) > opaque {
                high = middle;
            } else {
                low = middle;
            }
        }
        high
    }

    /// The longest panel that still sees every blob between two ray parameters [m].
    pub fn resolution(&self, start: f64, end: f64) -> f64 {
        const RADII: f64 = 5.0;
        let crossed = self.met().iter().filter(|met| {
            let radius = 1.0 / met.a;
            met.half_depth > 1e-9 && met.at + 4.0 * radius > start && met.at - 4.0 * radius < end
        });
        crossed.map(|met| RADII / met.a).fold(f64::INFINITY, f64::min)
    }
}
