//! Surface radiance of a batch of hits: direct light through the fog, and emission.

use super::sky;
use crate::frame::context::{Context, Lamp};
use crate::frame::light_table::LightTable;
use crate::frame::sky_table::depth_beyond;
use crate::geometry::batch::{Hits, NOTHING, Rays, Row, Rows, SIZE, get3, load3};
use crate::geometry::bundle::Bundle;
use crate::geometry::{Beyond, Origin};
use crate::light::least_distance;
use crate::media::{Legs, Near, Purpose, Sum};
use crate::num::{Lanes, Num};
use crate::surface::attenuated::{diffuse, specular};
use crate::vector::V3;
use fearless_simd::{Simd, dispatch};
use glam::{DVec3, Vec3};

/// Optical depth from one light to every hit; of what is smooth alone if the job is over, and none if that light
/// comes as in clear air.
pub fn light_depth(context: &Context, lamp: &Lamp, rays: &Rays, hits: &Hits) -> Row {
    let Context { job, field, .. } = context;
    if context.is_clear {
        return [0.0; SIZE];
    }
    let lit = (0..rays.count).filter(|at| hits.surface[*at] != NOTHING);
    let apex = match lamp.source.origin() {
        Origin::At(apex) => apex,
        Origin::Beyond(beyond) => {
            let points = dispatch!(job.level, simd => ends(simd, rays, hits));
            let looks_up = context.looks_up_lights();
            return from_beyond(context, lamp, &beyond, &points, lit, looks_up);
        }
    };
    let ways = dispatch!(job.level, simd => Ways::to_hits(simd, lamp, rays, hits));
    let mut depth = [0.0; SIZE];
    let is_unlit = hits.surface.iter().all(|s| *s == NOTHING);
    let haze = field.smooth(apex, Legs::OfLights);
    haze.add_depth(job, &ways.rays, false, &ways.length, &mut depth);
    if is_unlit || field.lumps() == 0 || job.progress.is_over() {
        return depth;
    }
    if let Some(table) = lamp.table.as_ref().as_ref().filter(|_| context.looks_up_lights()) {
        dispatch!(job.level, simd => add_tabled(simd, table, &ways, &mut depth));
        return depth;
    }
    let near = ways.near(context, apex, lit);
    near.add_depth(job, &ways.rays, false, &ways.length, &mut depth);
    depth
}

#[inline(always)]
fn add_tabled<S: Simd>(simd: S, table: &LightTable, ways: &Ways, depth: &mut Row) {
    for at in (0..ways.rays.count).step_by(Lanes::<S>::COUNT) {
        let length = Lanes::load(simd, &ways.length[at..]);
        let mean = table.means(simd, load3(simd, &ways.rays.direction, at).scale(length));
        mean.mul_add(length, Lanes::load(simd, &depth[at..])).store(&mut depth[at..]);
    }
}

/// Where rays end, from the camera [m].
#[inline(always)]
pub fn ends<S: Simd>(simd: S, rays: &Rays, hits: &Hits) -> Rows {
    let mut points = [[0.0; SIZE]; 3];
    for at in (0..SIZE).step_by(Lanes::<S>::COUNT) {
        let length = Lanes::load(simd, &hits.length[at..]);
        let way = load3(simd, &rays.direction, at).scale(length);
        let point = load3(simd, &rays.offset, at) + way;
        let [x, y, z] = &mut points;
        point.x.store(&mut x[at..]);
        point.y.store(&mut y[at..]);
        point.z.store(&mut z[at..]);
    }
    points
}

/// T of light that comes side by side to points given relative to the camera, of its lumps to those that are
/// `wanted`; of what is smooth alone if the job is over.
pub fn from_beyond(
    context: &Context,
    lamp: &Lamp,
    beyond: &Beyond,
    points: &Rows,
    mut wanted: impl Iterator<Item = usize> + Clone,
    looks_up: bool,
) -> Row {
    let Context { job, field, viewpoint, .. } = context;
    let Some(table) = lamp.table.as_ref().as_ref().filter(|_| looks_up) else {
        return depth_beyond(
            job,
            field,
            viewpoint.position,
            beyond,
            Purpose::Depth,
            points,
            wanted,
        );
    };
    let mut depth = [0.0; SIZE];
    let [x, y, z] = points;
    let haze = field.smooth(viewpoint.position, Legs::OfLights);
    haze.add_beyond(job.level, beyond, [x, y, z], &mut depth);
    if field.lumps() == 0 || wanted.next().is_none() || job.progress.is_over() {
        return depth;
    }
    let apex = table.apex() - viewpoint.position;
    dispatch!(job.level, simd => add_from_table(simd, table, apex, points, &mut depth));
    depth
}

#[inline(always)]
fn add_from_table<S: Simd>(
    simd: S,
    table: &LightTable,
    apex: DVec3,
    points: &Rows,
    depth: &mut Row,
) {
    let apex = V3::splat(simd, apex.as_vec3().to_array());
    for at in (0..SIZE).step_by(Lanes::<S>::COUNT) {
        let way = load3(simd, points, at) - apex;
        (table.means(simd, way) + Lanes::load(simd, &depth[at..])).store(&mut depth[at..]);
    }
}

/// The ways of a light to some points.
pub struct Ways {
    /// From where they all begin.
    pub rays: Rays,
    /// How long they are [m].
    pub length: Row,
}

impl Ways {
    /// To points given relative to the camera: there their own digits are not lost far away.
    pub fn new(lamp: &Lamp, count: usize, point: impl Fn(usize) -> Vec3) -> Self {
        let apex = lamp.from_camera.place().as_vec3();
        let (mut rays, mut length) = (Rays::empty(), [0.0; SIZE]);
        rays.count = count;
        for (at, length) in length.iter_mut().enumerate().take(count) {
            let way = point(at) - apex;
            *length = way.length().max(f32::MIN_POSITIVE);
            let direction = way * (1.0 / *length);
            (0..3).for_each(|k| rays.direction[k][at] = direction[k]);
        }
        Self { rays, length }
    }

    /// To where rays end.
    #[inline(always)]
    fn to_hits<S: Simd>(simd: S, lamp: &Lamp, from: &Rays, hits: &Hits) -> Self {
        let apex = V3::splat(simd, lamp.from_camera.place().as_vec3().to_array());
        let (mut rays, mut length) = (Rays::empty(), [0.0; SIZE]);
        rays.count = from.count;
        for at in (0..from.count).step_by(Lanes::<S>::COUNT) {
            let along =
                load3(simd, &from.direction, at).scale(Lanes::load(simd, &hits.length[at..]));
            let way = load3(simd, &from.offset, at) + along - apex;
            let square = way.x * way.x + way.y * way.y + way.z * way.z;
            let distance = square.sqrt().max(square.lit(f64::from(f32::MIN_POSITIVE)));
            distance.store(&mut length[at..]);
            let direction = way.scale(square.lit(1.0) / distance);
            let [x, y, z] = &mut rays.direction;
            direction.x.store(&mut x[at..]);
            direction.y.store(&mut y[at..]);
            direction.z.store(&mut z[at..]);
        }
        Self { rays, length }
    }

    /// What matters of the lumps between the light at `origin` and some of the points.
    pub fn near(
        &self,
        context: &Context,
        origin: DVec3,
        places: impl Iterator<Item = usize> + Clone,
    ) -> Sum<dyn Near> {
        let from_light = |at: usize| get3(&self.rays.direction, at) * self.length[at];
        let (mut min, mut max) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let mut shortest = f32::INFINITY;
        for at in places.clone() {
            let point = from_light(at);
            (min, max, shortest) = (min.min(point), max.max(point), shortest.min(self.length[at]));
        }
        let middle = 0.5 * (min + max);
        let radius2 = places.map(|at| from_light(at).distance_squared(middle)).fold(0.0, f32::max);
        let radius = f64::from(radius2.sqrt()) * 1.000_001;
        let center = origin + middle.as_dvec3();
        // A light among the points: they lie all around it.
        let (bundle, shortest) = match Bundle::toward_ball(origin, center, radius) {
            Some(bundle) => (bundle, f64::from(shortest)),
            None => (Bundle::all_around(origin, origin.distance(center) + radius), 0.0),
        };
        context.field.near_lumps(context.job.level, bundle, shortest, Purpose::Depth)
    }
}

/// Radiance that the hits send towards the eye, given each light's depth to them.
pub fn surface_radiance(context: &Context, rays: &Rays, hits: &Hits, depths: &[&Row]) -> Rows {
    let mut radiance = dispatch!(context.job.level, simd => {
        radiance_in_lanes(simd, context, rays, hits, depths)
    });
    if !context.skies.is_empty() {
        sky::add_to_surfaces(context, rays, hits, &mut radiance);
    }
    radiance
}

#[inline(always)]
fn radiance_in_lanes<S: Simd>(
    simd: S,
    context: &Context,
    rays: &Rays,
    hits: &Hits,
    depths: &[&Row],
) -> Rows {
    let one = Lanes::splat(simd, 1.0);
    let mut radiance = [[0.0; SIZE]; 3];
    for at in (0..rays.count).step_by(Lanes::<S>::COUNT) {
        let surfaces = &hits.surface[at..at + Lanes::<S>::COUNT];
        let material = MaterialLanes::gather(simd, context, surfaces);
        let direction = load3(simd, &rays.direction, at);
        let length = Lanes::load(simd, &hits.length[at..]);
        let point = load3(simd, &rays.offset, at) + direction.scale(length);
        let normal = load3(simd, &hits.normal, at);
        let mut sum = material.emission;
        for (lamp, depth) in context.lamps.iter().zip(depths) {
            let light = lamp.from_camera.toward(point, least_distance(length));
            let through = (-Lanes::load(simd, &depth[at..])).exp();
            let mut factor = material.diffuse.scale(diffuse(normal, &light));
            if material.is_glossy {
                let share = specular(normal, direction, &light, material.shininess);
                factor = factor + material.specular.scale(share);
            }
            sum = sum + factor * V3::lit(one, lamp.strength).scale(through);
        }
        sum.x.store(&mut radiance[0][at..]);
        sum.y.store(&mut radiance[1][at..]);
        sum.z.store(&mut radiance[2][at..]);
    }
    radiance
}

/// Materials of as many hits as there are lanes.
struct MaterialLanes<S: Simd> {
    diffuse: V3<Lanes<S>>,
    specular: V3<Lanes<S>>,
    shininess: Lanes<S>,
    emission: V3<Lanes<S>>,
    /// Whether any of them has a lobe.
    is_glossy: bool,
}

impl<S: Simd> MaterialLanes<S> {
    #[inline(always)]
    fn gather(simd: S, context: &Context, surfaces: &[u32]) -> Self {
        let material =
            |surface: u32| context.materials.get(surface as usize).unwrap_or(&context.background);
        let first = surfaces[0];
        if surfaces.iter().all(|surface| *surface == first) {
            let [a, b, c, d, e, f, g, h, i, j] = *material(first);
            return Self {
                diffuse: V3::splat(simd, [a, b, c]),
                specular: V3::splat(simd, [d, e, f]),
                emission: V3::splat(simd, [g, h, i]),
                shininess: Lanes::splat(simd, j),
                is_glossy: [d, e, f] != [0.0; 3],
            };
        }
        let mut rows = [[0.0f32; 16]; 10];
        for (lane, surface) in surfaces.iter().enumerate() {
            for (row, value) in rows.iter_mut().zip(material(*surface)) {
                row[lane] = *value;
            }
        }
        let [a, b, c, d, e, f, g, h, i, j] = &rows;
        let specular = load_rows(simd, [d, e, f]);
        let most = specular.x.max(specular.y).max(specular.z);
        Self {
            diffuse: load_rows(simd, [a, b, c]),
            specular,
            emission: load_rows(simd, [g, h, i]),
            shininess: Lanes::load(simd, j),
            is_glossy: Lanes::<S>::any(most.lit(0.0).lt(most)),
        }
    }
}

#[inline(always)]
fn load_rows<S: Simd>(simd: S, [x, y, z]: [&[f32]; 3]) -> V3<Lanes<S>> {
    V3::new(Lanes::load(simd, x), Lanes::load(simd, y), Lanes::load(simd, z))
}
