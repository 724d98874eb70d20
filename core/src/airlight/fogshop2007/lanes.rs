//! The inner loop of the published airlight: depth of blobs along rays, and with it their airlight.
//! Rays stand in lanes, blobs are walked one by one.

use super::{Crossing, LightSide, Lit};
use crate::airlight::least_distance;
use crate::geometry::batch::{Fogged, Rays, Row, SIZE, load3};
use crate::media::Field;
use crate::media::gaussians::{BlobList, ExactRay, Seen, not_negative};
use crate::num::Lanes;
use crate::vector::V3;
use fearless_simd::Simd;
use glam::{DVec3, Vec4};

/// What the published airlight needs of one light and every blob, as a kernel reads it.
pub struct LitBlobs {
    /// a · (centre − light), and the exponent of f¹.
    pub blobs: Vec<[f32; 4]>,
    /// The exponents in f64.
    pub exponents: Vec<f64>,
    /// Share of a light's homogeneous part that the blobs let through.
    pub homogeneous_factor: f64,
}

impl LitBlobs {
    /// a · (centre − light) of every blob, and the exponent of f¹.
    pub fn rows(&self) -> impl Iterator<Item = Vec4> + '_ {
        self.blobs.iter().copied().map(Vec4::from_array)
    }

    /// Packs a light's side of the published method.
    pub fn new(field: &Field, light: DVec3, side: LightSide) -> Self {
        let blobs = super::blobs(field).iter().zip(&side.exponents).map(|(blob, exponent)| {
            let from = (blob.center - light) * blob.a;
            let numbers = [from.x, from.y, from.z, *exponent];
            numbers.map(|number| number as f32)
        });
        Self {
            blobs: blobs.collect(),
            exponents: side.exponents,
            homogeneous_factor: side.homogeneous_factor,
        }
    }
}

/// One light as the airlight kernel reads it.
pub struct LightRow<'a> {
    /// ω·I/(4π) [W/sr].
    pub scattered: [f32; 3],
    /// Distance from the camera [m].
    pub distance: f32,
    /// For every blob of the field: a · (centre − light), and the exponent of f¹.
    pub blobs: &'a [[f32; 4]],
    /// The light relative to the list's origin [m].
    pub position: DVec3,
    /// The exponents in f64.
    pub exponents: &'a [f64],
}

/// Adds depth and airlight of all blobs in one go: the light's part reuses the line integral.
#[inline(always)]
pub fn add_airlight<S: Simd, const PARALLEL: bool>(
    simd: S,
    list: &BlobList,
    lights: &[LightRow<'_>],
    rays: &Rays,
    length: &Row,
    fogged: &mut Fogged,
) {
    for at in (0..rays.count.min(SIZE)).step_by(Lanes::<S>::COUNT) {
        let direction = load3(simd, &rays.direction, at);
        let offset = load3(simd, &rays.offset, at);
        let length = Lanes::load(simd, &length[at..]);
        let mut sum = Sum {
            depth: Lanes::load(simd, &fogged.depth[at..]),
            airlight: load3(simd, &fogged.airlight, at),
        };
        for blob in &list.cut {
            let seen = blob.seen::<S, PARALLEL>(simd, offset);
            let crossing = Crossing::new::<false>(&seen, direction, length);
            sum.add(simd, &seen, &crossing, lights, blob.place);
        }
        for blob in &list.dense {
            let seen = blob.seen::<S, PARALLEL>(simd, offset);
            let crossing = Crossing::new::<true>(&seen, direction, length);
            sum.add(simd, &seen, &crossing, lights, blob.place);
        }
        for blob in &list.whole {
            let seen = blob.seen::<S, PARALLEL>(simd, offset);
            let crossing = Crossing::whole(&seen, direction);
            sum.add(simd, &seen, &crossing, lights, blob.place);
        }
        let Sum { depth, airlight } = sum;
        not_negative(depth).store(&mut fogged.depth[at..]);
        airlight.x.store(&mut fogged.airlight[0][at..]);
        airlight.y.store(&mut fogged.airlight[1][at..]);
        airlight.z.store(&mut fogged.airlight[2][at..]);
    }
    for (place, blob) in &list.opaque {
        for at in 0..rays.count {
            let ray = ExactRay::new(rays, length, at);
            add_opaque(*place, &ray.blob(blob), &ray, lights, at, fogged);
        }
    }
}

/// Depth and airlight of one opaque blob along one ray, in f64.
fn add_opaque(
    place: usize,
    blob: &Seen<f64>,
    ray: &ExactRay,
    lights: &[LightRow<'_>],
    at: usize,
    fogged: &mut Fogged,
) {
    let crossing = Crossing::new::<true>(blob, ray.direction, ray.length);
    fogged.depth[at] += crossing.depth as f32;
    for light in lights {
        let to_light = V3::from(light.position) - ray.offset;
        let from_light = blob.b - to_light.scale(blob.a);
        let lit = Lit { from_light, exponent: light.exponents[place] };
        let floor = least_distance(f64::from(light.distance));
        let value = crossing.scattered(blob, &lit, floor) as f32;
        for (row, scattered) in fogged.airlight.iter_mut().zip(light.scattered) {
            row[at] += value * scattered;
        }
    }
}

struct Sum<S: Simd> {
    depth: Lanes<S>,
    airlight: V3<Lanes<S>>,
}

impl<S: Simd> Sum<S> {
    /// Adds what one blob takes away and, lit by every light, sends along the ray.
    #[inline(always)]
    fn add(
        &mut self,
        simd: S,
        seen: &Seen<Lanes<S>>,
        crossing: &Crossing<Lanes<S>>,
        lights: &[LightRow<'_>],
        place: u32,
    ) {
        self.depth += crossing.depth;
        for light in lights {
            let [x, y, z, exponent] = light.blobs[place as usize];
            let lit = Lit {
                from_light: V3::splat(simd, [x, y, z]),
                exponent: Lanes::splat(simd, exponent),
            };
            let floor = least_distance(Lanes::splat(simd, light.distance));
            let value = crossing.scattered(seen, &lit, floor);
            self.airlight = self.airlight + V3::splat(simd, light.scattered).scale(value);
        }
    }
}
