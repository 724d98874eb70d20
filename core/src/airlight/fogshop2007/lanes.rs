//! The inner loop of the published airlight: depth of blobs along rays, and with it their airlight.
//! Rays stand in lanes, blobs are walked one by one.

use super::{Crossing, LightSide, Lit};
use crate::geometry::batch::{Fogged, Rays, Row, SIZE, load3};
use crate::json::limits::COUNTS;
use crate::light::{Source, least_distance};
use crate::media::Field;
use crate::media::gaussians::{BlobList, ExactRay, Seen, not_negative};
use crate::num::{Lanes, Num};
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
    pub fn new(field: &Field, light: Source, side: LightSide) -> Self {
        let blobs = super::blobs(field).iter().zip(&side.exponents).map(|(blob, exponent)| {
            let from = (blob.center - light.place()) * blob.a;
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
    /// Distance from the camera [m].
    pub distance: f32,
    /// For every blob of the field: a · (centre − light), and the exponent of f¹.
    pub blobs: &'a [[f32; 4]],
    /// The light relative to the list's origin [m].
    pub position: DVec3,
    /// The exponents in f64.
    pub exponents: &'a [f64],
}

/// Most lights of a frame, whose sums stand side by side.
const MOST_LIGHTS: usize = COUNTS.lights;

/// Adds depth of all blobs, and their airlight per unit of ω·I, a row a light, in one go: the light's part
/// reuses the line integral.
#[inline(always)]
pub fn add_airlight<S: Simd, const PARALLEL: bool>(
    simd: S,
    list: &BlobList,
    lights: &[LightRow<'_>],
    rays: &Rays,
    length: &Row,
    fogged: &mut Fogged,
) {
    let lights = &lights[..lights.len().min(MOST_LIGHTS)];
    let unit = Lanes::splat(simd, UNIT as f32);
    for at in (0..rays.count.min(SIZE)).step_by(Lanes::<S>::COUNT) {
        let direction = load3(simd, &rays.direction, at);
        let offset = load3(simd, &rays.offset, at);
        let length = Lanes::load(simd, &length[at..]);
        let depth = Lanes::load(simd, &fogged.depth[at..]);
        let mut sum = Sum { depth, airlight: [depth.lit(0.0); MOST_LIGHTS] };
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
        not_negative(sum.depth).store(&mut fogged.depth[at..]);
        for (row, sum) in fogged.airlight.iter_mut().zip(&sum.airlight).take(lights.len()) {
            sum.mul_add(unit, Lanes::load(simd, &row[at..])).store(&mut row[at..]);
        }
    }
    for (place, blob) in &list.opaque {
        for at in 0..rays.count {
            let ray = ExactRay::new(rays, length, at);
            add_opaque(*place, &ray.blob(blob), &ray, lights, at, fogged);
        }
    }
}

/// 1/(4π): the share of isotropic scattering that goes one way [1/sr].
const UNIT: f64 = 0.25 * std::f64::consts::FRAC_1_PI;

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
    for (light, row) in lights.iter().zip(&mut fogged.airlight) {
        let to_light = V3::from(light.position) - ray.offset;
        let from_light = blob.b - to_light.scale(blob.a);
        let lit = Lit { from_light, exponent: light.exponents[place] };
        let floor = least_distance(f64::from(light.distance));
        row[at] += (UNIT * crossing.scattered(blob, &lit, floor)) as f32;
    }
}

struct Sum<S: Simd> {
    depth: Lanes<S>,
    airlight: [Lanes<S>; MOST_LIGHTS],
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
        for (light, sum) in lights.iter().zip(&mut self.airlight) {
            let [x, y, z, exponent] = light.blobs[place as usize];
            let from_light = V3::splat(simd, [x, y, z]);
            let lit = Lit { from_light, exponent: Lanes::splat(simd, exponent) };
            let floor = least_distance(Lanes::splat(simd, light.distance));
            *sum += crossing.scattered(seen, &lit, floor);
        }
    }
}
