//! The inner loop of the published airlight: depth of blobs along rays, and with it their airlight.
//! Rays stand in lanes, blobs are walked one by one.

use super::{Crossing, LightSide, Lit};
use crate::geometry::batch::{Fogged, Rays, Row, SIZE, load3};
use crate::json::limits::COUNTS;
use crate::light::{Source, ToLight, least_distance};
use crate::media::Field;
use crate::media::gaussians::{BlobList, ExactRay, Seen, not_negative};
use crate::num::{Lanes, Num};
use crate::vector::V3;
use fearless_simd::Simd;
use glam::Vec4;

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

/// Which parts of rays a light reaches.
pub trait Reach {
    /// Looks at some rays.
    fn look<S: Simd>(
        &mut self,
        simd: S,
        start: V3<Lanes<S>>,
        direction: V3<Lanes<S>>,
        light: &ToLight<Lanes<S>>,
        length: Lanes<S>,
    );

    /// Share of the light that reaches a ray parameter of those that were looked at last.
    fn at<S: Simd>(&self, simd: S, light: &ToLight<Lanes<S>>, t: Lanes<S>) -> Lanes<S>;
}

/// One light as the airlight kernel reads it.
pub struct LightRow<'a, R> {
    /// Where its light comes from, as seen from the list's origin.
    pub source: Source,
    /// What surfaces hide of it.
    pub reach: Option<R>,
    /// Distance from the camera [m].
    pub distance: f32,
    /// For every blob of the field: a · (centre − light), and the exponent of f¹.
    pub blobs: &'a [[f32; 4]],
    /// The exponents in f64.
    pub exponents: &'a [f64],
}

/// Most lights of a frame, whose sums stand side by side.
const MOST_LIGHTS: usize = COUNTS.lights;

/// Adds depth of all blobs, and their airlight per unit of ω·I, a row a light, in one go: the light's part
/// reuses the line integral.
#[inline(always)]
pub fn add_airlight<S: Simd, R: Reach, const PARALLEL: bool>(
    simd: S,
    list: &BlobList,
    lights: &mut [LightRow<'_, R>],
    rays: &Rays,
    lengths: &Row,
    fogged: &mut Fogged,
) {
    let most = lights.len().min(MOST_LIGHTS);
    let lights = &mut lights[..most];
    let unit = Lanes::splat(simd, UNIT as f32);
    for at in (0..rays.count.min(SIZE)).step_by(Lanes::<S>::COUNT) {
        let direction = load3(simd, &rays.direction, at);
        let offset = load3(simd, &rays.offset, at);
        let length = Lanes::load(simd, &lengths[at..]);
        for light in lights.iter_mut() {
            let to = light.source.beside(offset, direction);
            if let Some(reach) = &mut light.reach {
                reach.look(simd, offset, direction, &to, length);
            }
        }
        let along = Along { start: offset, direction, length };
        let depth = Lanes::load(simd, &fogged.depth[at..]);
        let mut sum = Sum { depth, airlight: [depth.lit(0.0); MOST_LIGHTS] };
        for blob in &list.cut {
            let seen = blob.seen::<S, PARALLEL>(simd, offset);
            let crossing = Crossing::new::<false>(&seen, direction, length);
            sum.add(simd, &along, &seen, &crossing, lights, blob.place);
        }
        for blob in &list.dense {
            let seen = blob.seen::<S, PARALLEL>(simd, offset);
            let crossing = Crossing::new::<true>(&seen, direction, length);
            sum.add(simd, &along, &seen, &crossing, lights, blob.place);
        }
        for blob in &list.whole {
            let seen = blob.seen::<S, PARALLEL>(simd, offset);
            let crossing = Crossing::whole(&seen, direction);
            sum.add(simd, &along, &seen, &crossing, lights, blob.place);
        }
        not_negative(sum.depth).store(&mut fogged.depth[at..]);
        for (row, sum) in fogged.airlight.iter_mut().zip(&sum.airlight).take(lights.len()) {
            sum.mul_add(unit, Lanes::load(simd, &row[at..])).store(&mut row[at..]);
        }
        for (place, blob) in &list.opaque {
            add_opaque(simd, (*place, blob), &along, (rays, lengths, at), lights, fogged);
        }
    }
}

/// 1/(4π): the share of isotropic scattering that goes one way [1/sr].
const UNIT: f64 = 0.25 * std::f64::consts::FRAC_1_PI;

/// Depth and airlight of one opaque blob along a register of rays, one by one in f64.
#[inline(always)]
fn add_opaque<S: Simd>(
    simd: S,
    (place, blob): (usize, &Seen<f64>),
    along: &Along<S>,
    (rays, lengths, first): (&Rays, &Row, usize),
    lights: &[LightRow<'_, impl Reach>],
    fogged: &mut Fogged,
) {
    let last = (first + Lanes::<S>::COUNT).min(rays.count);
    let mut closest = [0.0; 16];
    for at in first..last {
        let ray = ExactRay::new(rays, lengths, at);
        let seen = ray.blob(blob);
        closest[at - first] = (seen.b.dot(ray.direction) / seen.a) as f32;
    }
    let t = Lanes::load(simd, &closest).max(along.length.lit(0.0)).min(along.length);
    let mut lit = [[1.0; 16]; MOST_LIGHTS];
    for (light, lit) in lights.iter().zip(&mut lit) {
        if let Some(reach) = &light.reach {
            let to = light.source.beside(along.start, along.direction);
            reach.at(simd, &to, t).store(lit);
        }
    }
    for at in first..last {
        let ray = ExactRay::new(rays, lengths, at);
        add_exact(place, &ray.blob(blob), &ray, (lights, &lit, at - first), at, fogged);
    }
}

/// The same along one of them, given how much of each light reaches it.
fn add_exact(
    place: usize,
    blob: &Seen<f64>,
    ray: &ExactRay,
    (lights, lit, lane): (&[LightRow<'_, impl Reach>], &[[f32; 16]; MOST_LIGHTS], usize),
    at: usize,
    fogged: &mut Fogged,
) {
    let crossing = Crossing::new::<true>(blob, ray.direction, ray.length);
    fogged.depth[at] += crossing.depth as f32;
    for ((light, row), share) in lights.iter().zip(&mut fogged.airlight).zip(lit) {
        let to_light = V3::from(light.source.place()) - ray.offset;
        let from_light = blob.b - to_light.scale(blob.a);
        let beam = light.source.beam();
        let lit = Lit { from_light, exponent: light.exponents[place], beam };
        let floor = least_distance(f64::from(light.distance));
        row[at] += (UNIT * crossing.scattered(blob, &lit, floor)) as f32 * share[lane];
    }
}

/// Some rays.
struct Along<S: Simd> {
    start: V3<Lanes<S>>,
    direction: V3<Lanes<S>>,
    length: Lanes<S>,
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
        rays: &Along<S>,
        seen: &Seen<Lanes<S>>,
        crossing: &Crossing<Lanes<S>>,
        lights: &[LightRow<'_, impl Reach>],
        place: u32,
    ) {
        self.depth += crossing.depth;
        for (light, sum) in lights.iter().zip(&mut self.airlight) {
            let [x, y, z, exponent] = light.blobs[place as usize];
            let from_light = V3::splat(simd, [x, y, z]);
            let exponent = Lanes::splat(simd, exponent);
            let lit = Lit { from_light, exponent, beam: light.source.beam() };
            let floor = least_distance(Lanes::splat(simd, light.distance));
            let scattered = crossing.scattered(seen, &lit, floor);
            *sum += match &light.reach {
                // Ours: a blob is lit as its centre on the ray is.
                Some(reach) => {
                    let t = seen.b.dot(rays.direction) / seen.a;
                    let t = t.max(floor.lit(0.0)).min(rays.length);
                    let to = light.source.beside(rays.start, rays.direction);
                    scattered * reach.at(simd, &to, t)
                }
                None => scattered,
            };
        }
    }
}
