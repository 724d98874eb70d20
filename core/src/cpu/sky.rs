//! Light of skies: at places of rays, on surfaces, behind everything, and as the published methods have it.

use crate::airlight::Under;
use crate::frame::context::{Context, Lamp, Scatter};
use crate::frame::skies::{self, OfSky, Sky};
use crate::frame::sky_table::{SkyTable, Summing};
use crate::geometry::Ray;
use crate::geometry::batch::{Hits, NOTHING, Rays, Row, Rows, SIZE, get3};
use crate::geometry::control::{Control, Each, PADDED};
use crate::light::sun;
use crate::num::Num;
use crate::phase::PhaseFunction;
use crate::sky::{SkyWays, harmonics};
use glam::{DVec3, Vec3};
use std::f32::consts::PI;
use std::rc::Rc;

/// No less is left of what goes on along a ray, as a share of all that arrives: a few harmonics of a narrow light may
/// come to less than nothing.
const LEAST: f32 = 1e-4;

/// −ln of what is left of a sky as a lamp at ray parameters `t`, by a sun's distance: as the mean extinction towards a
/// lamp [1/m].
pub fn toward(context: &Context, own: &OfSky, rays: &Control, t: &[Each]) -> Vec<Each> {
    let mut mean = vec![[0.0; PADDED]; t.len()];
    let sky = &context.skies[own.sky];
    let Some(summing) = &sky.summing else { return mean };
    let direction = |c: usize| DVec3::from([0, 1, 2].map(|k| f64::from(rays.direction[k][c])));
    let along = |c: usize| skies::along(own.phase, summing.order(), direction(c).normalize());
    let along: Vec<_> = (0..PADDED).map(along).collect();
    for (t, mean) in t.chunks(SIZE / PADDED).zip(mean.chunks_mut(SIZE / PADDED)) {
        let (points, mean) = (rays.points(t), mean.as_flattened_mut());
        let arrives = Arriving::new(context, sky.table.as_ref().as_ref(), summing, &points);
        for (at, mean) in mean.iter_mut().enumerate() {
            let (log, share) = arrives.sum(at, own.place, &along[at % PADDED]);
            let depth = (own.most as f32).ln() - log - share.max(LEAST).ln();
            *mean = depth * (1.0 / sun::DISTANCE_M) as f32;
        }
    }
    mean
}

/// What arrives of a sky at a batch of points.
struct Arriving<'a> {
    summing: &'a Summing,
    table: Option<&'a SkyTable>,
    /// From the table's origin, if there is one.
    points: Rows,
    /// Point by point, if there is no table.
    values: Vec<f32>,
}

impl<'a> Arriving<'a> {
    /// At points given relative to the camera.
    fn new(
        context: &Context,
        table: Option<&'a SkyTable>,
        summing: &'a Summing,
        points: &Rows,
    ) -> Self {
        let camera = context.viewpoint.position;
        let Some(table) = table else {
            let values = summing.at(&context.job, context.field, camera, points);
            return Self { summing, table: None, points: *points, values };
        };
        let shift = (camera - table.origin()).as_vec3();
        let points = std::array::from_fn(|k| points[k].map(|own| own + shift[k]));
        Self { summing, table: Some(table), points, values: Vec::new() }
    }

    /// See [`Summing::sum`]: at a point, of a channel by its place.
    fn sum(&self, at: usize, channel: usize, factors: &[f32]) -> (f32, f32) {
        match self.table {
            Some(table) => {
                let corners = table.corners(get3(&self.points, at));
                self.summing.sum(table.values(), &corners, channel, factors)
            }
            None => self.summing.sum(&self.values, &[(at, 1.0)], channel, factors),
        }
    }

    /// All that arrives at a point, channel by channel.
    fn blend(&self, at: usize, own: &mut [f32]) {
        match self.table {
            Some(table) => {
                let corners = table.corners(get3(&self.points, at));
                self.summing.blend(table.values(), &corners, own);
            }
            None => self.summing.blend(&self.values, &[(at, 1.0)], own),
        }
    }
}

/// Adds what surfaces send on of skies, and skies themselves where nothing is hit.
pub fn add_to_surfaces(context: &Context, rays: &Rays, hits: &Hits, radiance: &mut Rows) {
    for sky in &context.skies {
        add_behind(sky, rays, hits, radiance);
        let is_unlit = hits.surface[..rays.count].iter().all(|surface| *surface == NOTHING);
        let Some(summing) = sky.summing.as_deref().filter(|_| !is_unlit) else { continue };
        let table = if context.is_clear { sky.clear.as_ref() } else { sky.table.as_ref().as_ref() };
        let points: Rows = std::array::from_fn(|k| {
            let along = |at: usize| rays.offset[k][at] + rays.direction[k][at] * hits.length[at];
            std::array::from_fn(along)
        });
        let arrives = Arriving::new(context, table, summing, &points);
        let harmonics = summing.order() * summing.order();
        let mut own = vec![0.0; summing.channels() * harmonics];
        let mut lobe = Lobe::new(summing.order());
        for at in (0..rays.count).filter(|at| hits.surface[*at] != NOTHING) {
            let [d0, d1, d2, s0, s1, s2, .., shininess] =
                context.materials[hits.surface[at] as usize];
            let (diffuse, specular) = (Vec3::new(d0, d1, d2), Vec3::new(s0, s1, s2));
            arrives.blend(at, &mut own);
            let colours = sky.channels.iter().map(|(_, colour)| colour.as_vec3());
            let mut sent = Vec3::ZERO;
            let normal = get3(&hits.normal, at);
            lobe.turn(skies::MATTE.min(summing.order()), normal, &MATTE);
            for (own, colour) in own.chunks_exact(harmonics).zip(colours.clone()) {
                sent += diffuse * colour * (lobe.of(own) / PI);
            }
            if specular != Vec3::ZERO {
                let direction = get3(&rays.direction, at);
                let mirrored = direction - 2.0 * normal.dot(direction) * normal;
                lobe.turn(summing.order(), mirrored, &lobe_bands(f64::from(shininess)));
                let above = above(f64::from(shininess), f64::from(mirrored.dot(normal)));
                for (own, colour) in own.chunks_exact(harmonics).zip(colours) {
                    sent += specular * colour * (lobe.of(own) * above);
                }
            }
            (0..3).for_each(|k| radiance[k][at] += sent[k]);
        }
    }
}

fn add_behind(sky: &Sky, rays: &Rays, hits: &Hits, radiance: &mut Rows) {
    for at in (0..rays.count).filter(|at| hits.surface[*at] == NOTHING) {
        let direction = get3(&rays.direction, at).as_dvec3().normalize();
        let seen = sky.radiance.toward(direction).as_vec3();
        (0..3).for_each(|k| radiance[k][at] += seen[k]);
    }
}

/// What the cosine over a half space leaves of each band (Ramamoorthi and Hanrahan 2001).
const MATTE: [f64; 6] = {
    use std::f64::consts::PI;
    [PI, 2.0 * PI / 3.0, PI / 4.0, 0.0, -PI / 24.0, 0.0]
};

/// The same of the lobe cosⁿ: 2π ∫ xⁿ Pₗ(x) dx from 0 to 1, by two bands at a time.
fn lobe_bands(n: f64) -> [f64; 6] {
    use std::f64::consts::TAU;
    let moment = |power: f64| TAU / (n + power + 1.0);
    let [m0, m1, m2, m3, m4, m5] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0].map(moment);
    [
        m0,
        m1,
        1.5 * m2 - 0.5 * m0,
        2.5 * m3 - 1.5 * m1,
        (35.0 * m4 - 30.0 * m2 + 3.0 * m0) / 8.0,
        (63.0 * m5 - 70.0 * m3 + 15.0 * m1) / 8.0,
    ]
}

/// Which share of the lobe cosⁿ goes out of a surface, near enough, given the cosine between its middle and the normal:
/// of a narrow one as of a Gaussian, to some hundredths of all; nothing comes from below.
fn above(n: f64, cos: f64) -> f32 {
    (0.5 * (1.0 + Num::erf(1.1 * cos * (0.5 * (n + 1.0)).sqrt()))) as f32
}

/// Factors that sum harmonics up to a lobe around an axis.
struct Lobe {
    values: Vec<f64>,
    factors: Vec<f32>,
}

impl Lobe {
    /// Of so many bands at most.
    fn new(order: usize) -> Self {
        let most = order * order;
        Self { values: vec![0.0; most], factors: Vec::with_capacity(most) }
    }

    /// Around another axis, by what the lobe leaves of each band; of no more bands than it was made for.
    fn turn(&mut self, order: usize, axis: Vec3, of_bands: &[f64; 6]) {
        let values = &mut self.values[..order * order];
        harmonics::fill(order, axis.as_dvec3().normalize_or_zero(), values);
        self.factors.clear();
        let factors = harmonics::bands(order).zip(values);
        self.factors.extend(factors.map(|(l, value)| (of_bands[l.min(5)] * *value) as f32));
    }

    /// What goes on of the harmonics of a channel, the first of them by its logarithm, the others as shares of it.
    fn of(&self, own: &[f32]) -> f32 {
        let further = self.factors.iter().zip(own).skip(1);
        let share = self.factors[0] + further.map(|(factor, value)| factor * value).sum::<f32>();
        own[0].exp() * share.max(0.0)
    }
}

/// Adds what methods scatter of skies that have no closed form for one: the point spread function of the published ones,
/// or all of it in fog that takes no light away.
pub fn add_published(
    context: &Context,
    asked: &[usize],
    (rays, hits): (&Rays, &Hits),
    airlight: &mut [Row],
    depth: &Row,
) {
    for (i, row) in asked.iter().zip(airlight) {
        let Scatter { lamp, group, .. } = context.scatters[*i];
        let lamp = &context.lamps[lamp];
        let Some(own) = lamp.of_sky else { continue };
        let sky = &context.skies[own.sky];
        let (channel, _) = sky.channels[own.place];
        for at in 0..rays.count {
            let under = under(sky, in_full(context, rays, hits, at));
            let scattered = match &sky.glow {
                Some(glow) => under.published(context.field, group, glow, f64::from(depth[at])),
                None => under.thin(context.field, group, sky.mean),
            };
            row[at] += (scattered[channel] / scale(lamp, channel, sky)) as f32;
        }
    }
}

/// What a lamp that stands for a sky is multiplied by in its channel.
fn scale(lamp: &Lamp, channel: usize, sky: &Sky) -> f64 {
    let colour =
        sky.channels.iter().find(|(own, _)| *own == channel).map_or(1.0, |own| own.1[channel]);
    lamp.strength[channel] / colour
}

/// A sky before a ray of some length.
fn under<'a>(sky: &Sky<'a>, (ray, length): (Ray, f64)) -> Under<'a> {
    Under { sky: sky.radiance, path_m: sky.path_m, ray, length, channels: [true; 3] }
}

/// A ray in f64, and its length [m].
pub fn in_full(context: &Context, rays: &Rays, hits: &Hits, at: usize) -> (Ray, f64) {
    let origin = context.viewpoint.position + get3(&rays.offset, at).as_dvec3();
    let direction = get3(&rays.direction, at).as_dvec3().normalize();
    (Ray { origin, direction }, f64::from(hits.length[at]))
}

/// The fog between a ray and its skies, which all channels share.
#[derive(Default)]
pub struct Ways(Vec<((usize, PhaseFunction), Rc<SkyWays>)>);

impl Ways {
    /// What is scattered of a sky as a lamp, at unit strength, by the integral itself.
    pub fn airlight(
        &mut self,
        context: &Context,
        (lamp, own): (&Lamp, &OfSky),
        group: usize,
        (ray, length): (Ray, f64),
    ) -> f64 {
        let sky = &context.skies[own.sky];
        let (channel, _) = sky.channels[own.place];
        let key = (own.sky, own.phase);
        let known = self.0.iter().find(|(other, _)| *other == key).map(|(_, ways)| Rc::clone(ways));
        let under = under(sky, (ray, length));
        let (field, method) = (context.field, context.method);
        let ways = known.unwrap_or_else(|| {
            let ways = under.ways(field, own.phase, method);
            self.0.push((key, Rc::clone(&ways)));
            ways
        });
        let scattered = under.along(field, group, (&ways, channel), method, context.job.progress);
        scattered / scale(lamp, channel, sky)
    }
}
