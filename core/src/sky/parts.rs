//! A sky as a sum of small suns.

use super::Radiance;
use crate::phase::PhaseFunction;
use crate::quadrature::gauss_legendre;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// A part of a sky, as a sun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Unit vector to it.
    pub toward: DVec3,
    /// Its radiance times its solid angle, times 4π p for light that is scattered [W/m²].
    pub weight: DVec3,
}

/// How finely a sky is summed up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Fineness {
    /// Gauss's places between the horizon and the zenith; as many below.
    pub elevations: usize,
    /// Even steps around.
    pub azimuths: usize,
}

impl Fineness {
    /// For pictures and numbers in real time: what blobs let through from all around is smooth.
    pub const FAST: Self = Self { elevations: 5, azimuths: 12 };
    /// The same of a draft.
    pub const DRAFT: Self = Self { elevations: 3, azimuths: 8 };
    /// For the converged truth: twice as many change ten scenes by less than 1e-3.
    pub const REFERENCE: Self = Self { elevations: 16, azimuths: 24 };

    /// Parts of all directions.
    pub fn parts(self) -> usize {
        2 * self.elevations * self.azimuths
    }

    /// Sines of elevations with the part of the sphere's 2 that each stands for. A sky may have a kink at the horizon.
    pub fn even(self) -> Vec<[f64; 2]> {
        let (sines, weights) = gauss_legendre(self.elevations);
        let up = sines.iter().zip(&weights).map(|(sine, weight)| [*sine, *weight]);
        let down = sines.iter().zip(&weights).map(|(sine, weight)| [-*sine, *weight]);
        up.chain(down).collect()
    }

    /// The same around a direction that a phase function prefers, each part times 4π p: half of the places where it
    /// scatters evenly between them, the others even, for what comes from there may be brighter. By the balance
    /// heuristic (Veach and Guibas 1995) both together are one integral.
    fn preferred(self, g: f64) -> Vec<[f64; 2]> {
        let (places, weights) = gauss_legendre(3 * self.elevations / 2);
        let phase = PhaseFunction { g };
        let share = |cos: f64| 4.0 * PI * phase.value(cos);
        let near = places.iter().zip(&weights).map(|(u, weight)| {
            let cos = cosine(g, 2.0 * u - 1.0);
            [cos, 2.0 * weight * share(cos) / (share(cos) + 1.0)]
        });
        let even = places.iter().zip(&weights).map(|(u, weight)| {
            let cos = 2.0 * u - 1.0;
            [cos, 2.0 * weight * share(cos) / (share(cos) + 1.0)]
        });
        near.chain(even).collect()
    }
}

/// The cosine below which Henyey and Greenstein's function scatters the share (1 + v)/2, in a form that holds without a
/// preference, too.
fn cosine(g: f64, v: f64) -> f64 {
    let above = 2.0 * v + g * (v * v + 3.0) + 2.0 * g * g * v + g * g * g * (v * v - 1.0);
    (above / (2.0 * (1.0 + g * v).powi(2))).clamp(-1.0, 1.0)
}

/// Directions around an axis, given by cosines and weights for them, evenly turned; weights times 2π.
pub fn around(axis: DVec3, cosines: &[[f64; 2]], azimuths: usize) -> Vec<(DVec3, f64)> {
    /// A golden section of a step: rings do not stand in line.
    const TURN: f64 = 0.381_966_011_250_105;
    let (across, along) = axis.any_orthonormal_pair();
    let step = TAU / azimuths as f64;
    let ring = |(ring, [cos, weight]): (usize, &[f64; 2])| {
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let (cos, weight) = (*cos, weight * step);
        (0..azimuths).map(move |i| {
            let (y, x) = ((i as f64 + TURN * ring as f64) * step).sin_cos();
            (axis * cos + (across * x + along * y) * sin, weight)
        })
    };
    cosines.iter().enumerate().flat_map(ring).collect()
}

impl Radiance {
    /// What is scattered into a ray in the unit direction `d`: 4π p(ω·d) L(ω) dω.
    pub fn parts(&self, phase: PhaseFunction, d: DVec3, fineness: Fineness) -> Vec<Part> {
        if let Self::ImageSky(image) = self {
            let parts = image.map().parts(fineness);
            let share = |part: &Part| 4.0 * PI * phase.value(part.toward.dot(d));
            // A peak narrower than a part may meet one or none: in any case all of the light goes somewhere.
            let whole: f64 = parts.iter().map(|(part, solid)| share(part) * solid).sum();
            let scattered = |(part, _): &(Part, f64)| {
                let share = share(part) * 4.0 * PI / whole.max(f64::MIN_POSITIVE);
                Part { weight: part.weight * share, ..*part }
            };
            return parts.iter().map(scattered).collect();
        }
        let directions = if phase.is_isotropic() {
            around(DVec3::Y, &fineness.even(), fineness.azimuths)
        } else {
            around(d, &fineness.preferred(phase.g), fineness.azimuths)
        };
        let part = |(toward, weight)| Part { toward, weight: self.toward(toward) * weight };
        directions.into_iter().map(part).collect()
    }

    /// What reaches a surface with that unit normal, by the cosine: L(ω) cos θ dω.
    pub fn on_surface(&self, normal: DVec3) -> Vec<Part> {
        let above = |part: &Part| {
            let cos = part.toward.dot(normal);
            (cos > 0.0).then(|| Part { weight: part.weight * cos, ..*part })
        };
        if let Self::ImageSky(image) = self {
            let parts = image.map().parts(Fineness::REFERENCE);
            return parts.iter().filter_map(|(part, _)| above(part)).collect();
        }
        let (cosines, weights) = gauss_legendre(Fineness::REFERENCE.elevations);
        let cosines: Vec<_> = cosines.iter().zip(weights).map(|(cos, w)| [*cos, w]).collect();
        let directions = around(normal, &cosines, Fineness::REFERENCE.azimuths);
        let part = |(toward, weight)| Part { toward, weight: self.toward(toward) * weight };
        directions.into_iter().map(part).filter_map(|part| above(&part)).collect()
    }

    /// What goes on from a surface along a view ray by the lobe cosⁿ θ′ around the mirrored one: L(ω) cosⁿ θ′ dω.
    pub fn in_lobe(&self, normal: DVec3, direction: DVec3, shininess: f64) -> Vec<Part> {
        let mirrored = direction - 2.0 * normal.dot(direction) * normal;
        // Evenly in cosⁿ⁺¹, of which the lobe is the slope.
        let (places, weights) = gauss_legendre(Fineness::REFERENCE.elevations);
        let whole = 1.0 / (shininess + 1.0);
        let of = |(u, weight): (&f64, &f64)| [u.powf(whole), whole * weight];
        let cosines: Vec<_> = places.iter().zip(&weights).map(of).collect();
        let directions = around(mirrored, &cosines, Fineness::REFERENCE.azimuths);
        let lit = directions.into_iter().filter(|(toward, _)| toward.dot(normal) > 0.0);
        lit.map(|(toward, weight)| Part { toward, weight: self.toward(toward) * weight }).collect()
    }

    /// The sky itself: L(ω) dω.
    pub fn all_parts(&self, fineness: Fineness) -> Vec<Part> {
        self.parts(PhaseFunction::ISOTROPIC, DVec3::Y, fineness)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Parts of an even sky are all of it, whatever phase function prefers some, and where they are is where that scatters.
    #[test]
    fn an_even_sky_scatters_all_of_its_light() {
        let sky = Radiance::default();
        let d = DVec3::new(0.6, -0.48, 0.64);
        for g in [-0.95, -0.3, 1e-300, 1e-12, 1e-3, 0.5, 0.9, 0.99] {
            let parts = sky.parts(PhaseFunction { g }, d, Fineness::REFERENCE);
            let sum: f64 = parts.iter().map(|part| part.weight.x / (4.0 * PI * 0.3)).sum();
            let mean = |part: &Part| part.weight.x / (4.0 * PI * 0.3) * part.toward.dot(d);
            let cosine: f64 = parts.iter().map(mean).sum();
            assert!((sum - 1.0).abs() < 2e-3, "{g}: {sum}");
            assert!((cosine - g).abs() < 2e-3, "{g}: {cosine}");
        }
    }

    /// A picture of one colour gives all of its light, however narrow the function.
    #[test]
    fn an_even_picture_scatters_all_of_its_light() {
        let map = super::super::RadianceMap::new(64, vec![[0.3, 0.4, 0.5]; 64 * 32]).unwrap();
        let mut image = super::super::ImageSky::default();
        image.show(map);
        let sky = Radiance::ImageSky(image);
        for g in [0.0, 0.6, 0.99] {
            for d in [DVec3::X, DVec3::new(0.6, -0.48, 0.64)] {
                let parts = sky.parts(PhaseFunction { g }, d, Fineness::FAST);
                let sum: DVec3 = parts.iter().map(|part| part.weight / (4.0 * PI)).sum();
                assert!(sum.distance(DVec3::new(0.3, 0.4, 0.5)) < 1e-6, "{g}: {sum}");
            }
        }
    }
}
