//! What is left of a sky at places in the fog, tabulated over space: made once for a fog and a sky, it serves every
//! camera.
//!
//! At each place the sky's parts, each through its own fog, are summed up to spherical harmonics of what arrives there.
//! The first is kept as its logarithm and the others as shares of it: both change slowly, and between places straight
//! lines are drawn. Places stand on planes across the axes, close together where the fog asks for it
//! ([`Places`](crate::media::Places)).

use crate::geometry::Beyond;
use crate::geometry::batch::{Rays, Row, Rows, SIZE, get3};
use crate::geometry::bundle::Bundle;
use crate::media::{Field, Legs, Purpose};
use crate::progress::{Interrupted, Job};
use crate::sky::harmonics;
use crate::sky::{Fineness, Part, Radiance};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// A sky, ready to be summed up at places in fog.
#[derive(Debug)]
pub struct Summing {
    parts: Vec<Part>,
    /// The harmonics of each part.
    basis: Vec<Vec<f32>>,
    /// Fog that has no end towards it counts so far [m].
    path_m: f64,
    /// The sky's channels that are asked for.
    channels: Vec<usize>,
    order: usize,
}

impl Summing {
    /// Of some channels of a sky by so many parts, to so many bands of harmonics.
    pub fn new(
        (sky, path_m): (&Radiance, f64),
        channels: Vec<usize>,
        (parts, order): (Fineness, usize),
    ) -> Self {
        let parts = sky.all_parts(parts);
        let of_part = |part: &Part| {
            let values = harmonics::all(order, part.toward);
            values.iter().map(|value| *value as f32).collect()
        };
        let basis = parts.iter().map(of_part).collect();
        Self { parts, basis, path_m, channels, order }
    }

    /// Bands of harmonics.
    pub fn order(&self) -> usize {
        self.order
    }

    /// Channels that are asked for.
    pub fn channels(&self) -> usize {
        self.channels.len()
    }

    /// Numbers that a place has.
    fn stride(&self) -> usize {
        self.channels.len() * self.order * self.order
    }

    /// What arrives at points, given relative to an origin: `[point][channel][harmonic]`, ln of the first and the others
    /// as shares of it; nothing that matters once the job is over.
    pub fn at(&self, job: &Job, field: &Field, origin: DVec3, points: &Rows) -> Vec<f32> {
        let harmonics = self.order * self.order;
        let mut sums = vec![0.0f32; SIZE * self.stride()];
        if sums.is_empty() || job.progress.is_over() {
            return sums;
        }
        for (part, basis) in self.parts.iter().zip(&self.basis) {
            let beyond = Beyond { toward: part.toward, path_m: self.path_m };
            let depth = depth_beyond(job, field, origin, &beyond, Purpose::Shade, points, 0..SIZE);
            for (depth, sums) in depth.iter().zip(sums.chunks_exact_mut(self.stride())) {
                let through = (-depth).exp();
                for (channel, sums) in self.channels.iter().zip(sums.chunks_exact_mut(harmonics)) {
                    let light = part.weight[*channel] as f32 * through;
                    sums.iter_mut().zip(basis).for_each(|(sum, own)| *sum += light * own);
                }
            }
        }
        for sums in sums.chunks_exact_mut(harmonics) {
            let first = sums[0].max(f32::MIN_POSITIVE);
            sums[1..].iter_mut().for_each(|sum| *sum /= first);
            sums[0] = first.ln();
        }
        sums
    }

    /// Σ factor · harmonic of a channel, by its place among those that are asked for, at the places of a list that have
    /// some weight: ln of the first, and the sum as a share of that.
    #[inline]
    pub fn sum(
        &self,
        values: &[f32],
        corners: &[(usize, f32)],
        channel: usize,
        factors: &[f32],
    ) -> (f32, f32) {
        let harmonics = self.order * self.order;
        let (mut log, mut share) = (0.0, 0.0);
        for (place, weight) in corners.iter().filter(|(_, weight)| *weight > 0.0) {
            let own = &values[place * self.stride() + channel * harmonics..][..harmonics];
            let further = own.iter().zip(factors).skip(1).map(|(value, factor)| value * factor);
            log += weight * own[0];
            share += weight * (factors[0] + further.sum::<f32>());
        }
        (log, share)
    }

    /// All numbers at the places of a list together, by their weights.
    pub fn blend(&self, values: &[f32], corners: &[(usize, f32)], sums: &mut [f32]) {
        sums.fill(0.0);
        for (place, weight) in corners.iter().filter(|(_, weight)| *weight > 0.0) {
            let own = &values[place * self.stride()..];
            sums.iter_mut().zip(own).for_each(|(sum, value)| *sum += weight * value);
        }
    }
}

/// What is left of a sky, over space.
#[derive(Debug)]
pub struct SkyTable {
    /// From where places are counted [m].
    origin: DVec3,
    knots: [Vec<f32>; 3],
    /// Place by place as [`Summing::at`] tells it, x first.
    values: Vec<f32>,
}

/// Fog that asks for more places than these is summed up where it is looked at: blobs far from each other.
const NEEDED: usize = 6 << 20;

/// Places around a point, by their numbers and weights.
pub type Corners = [(usize, f32); 8];

impl SkyTable {
    /// Of a fog, in so many places; `None` where no table holds it.
    ///
    /// # Errors
    /// [`Interrupted`] when the job's progress says so.
    pub fn new(
        job: &Job,
        field: &Field,
        summing: &Summing,
        most: usize,
    ) -> Result<Option<Self>, Interrupted> {
        let Some(places) = field.places() else { return Ok(None) };
        let Some(knots) = places.knots(most, NEEDED) else { return Ok(None) };
        let middle = |knots: &Vec<f64>| 0.5 * (knots[0] + knots[knots.len() - 1]);
        let origin = DVec3::from(knots.each_ref().map(middle));
        let knots = std::array::from_fn(|axis| {
            knots[axis].iter().map(|knot| (knot - origin[axis]) as f32).collect()
        });
        let table = Self { origin, knots, values: Vec::new() };
        Ok(Some(Self { values: table.filled(job, field, summing)?, ..table }))
    }

    /// Its origin [m].
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// Where planes stand across each axis, from the origin [m].
    pub fn knots(&self) -> &[Vec<f32>; 3] {
        &self.knots
    }

    /// See [`Summing::sum`].
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Bytes that it takes, near enough.
    pub fn bytes(&self) -> usize {
        size_of_val(self.values.as_slice())
    }

    fn filled(&self, job: &Job, field: &Field, summing: &Summing) -> Result<Vec<f32>, Interrupted> {
        let sizes = self.knots.each_ref().map(Vec::len);
        // Cubes of four places along each side share what they meet.
        let blocks = sizes.map(|size| size.div_ceil(SIDE));
        let corner = |block: usize| {
            let [x, y] = [block % blocks[0], block / blocks[0] % blocks[1]];
            [x, y, block / (blocks[0] * blocks[1])].map(|place| place * SIDE)
        };
        job.progress.check()?;
        let all = (0..blocks.iter().product()).into_par_iter().map(|block| {
            let points = self.points(corner(block));
            summing.at(job, field, self.origin, &points)
        });
        let made: Vec<_> = all.collect();
        job.progress.check()?;
        let stride = summing.stride();
        let mut values = vec![0.0; sizes.iter().product::<usize>() * stride];
        for (block, own) in made.iter().enumerate() {
            let corner = corner(block);
            for (at, own) in own.chunks_exact(stride.max(1)).enumerate() {
                let offset = offset(at);
                let [x, y, z] = std::array::from_fn(|axis| corner[axis] + offset[axis]);
                if x < sizes[0] && y < sizes[1] && z < sizes[2] {
                    let at = ((z * sizes[1] + y) * sizes[0] + x) * stride;
                    values[at..at + stride].copy_from_slice(own);
                }
            }
        }
        Ok(values)
    }

    /// A cube of places; the last ones of an axis again and again behind its end.
    fn points(&self, corner: [usize; 3]) -> Rows {
        std::array::from_fn(|axis| {
            let (knots, first) = (&self.knots[axis], corner[axis]);
            std::array::from_fn(|at| knots[(first + offset(at)[axis]).min(knots.len() - 1)])
        })
    }

    /// Where a point lies, given relative to the origin [m].
    pub fn corners(&self, point: Vec3) -> Corners {
        let sizes = self.knots.each_ref().map(Vec::len);
        let sides = [0, 1, 2].map(|axis| self.side(axis, point[axis]));
        std::array::from_fn(|corner| {
            let [x, y, z] = [0, 1, 2].map(|axis| sides[axis][corner >> axis & 1]);
            ((z.0 * sizes[1] + y.0) * sizes[0] + x.0, x.1 * y.1 * z.1)
        })
    }

    /// The planes before and behind a coordinate, each with its weight.
    fn side(&self, axis: usize, at: f32) -> [(usize, f32); 2] {
        let knots = &self.knots[axis];
        let behind = knots.partition_point(|knot| *knot <= at);
        let first = behind.saturating_sub(1).min(knots.len().saturating_sub(2));
        let next = (first + 1).min(knots.len() - 1);
        let width = knots[next] - knots[first];
        let share = if width > 0.0 { ((at - knots[first]) / width).clamp(0.0, 1.0) } else { 0.0 };
        [(first, 1.0 - share), (next, share)]
    }
}

/// Places along a side of what is summed up together: a batch is a cube of them.
const SIDE: usize = 4;

/// Where one of such a cube's places lies in it.
fn offset(at: usize) -> [usize; 3] {
    [at % SIDE, at / SIDE % SIDE, at / (SIDE * SIDE)]
}

/// T from points, given relative to an origin, to beyond everything, of its lumps from those that are `wanted`; of what
/// is smooth alone if the job is over.
pub fn depth_beyond(
    job: &Job,
    field: &Field,
    origin: DVec3,
    beyond: &Beyond,
    purpose: Purpose,
    points: &Rows,
    wanted: impl Iterator<Item = usize> + Clone,
) -> Row {
    let mut depth = [0.0; SIZE];
    let [x, y, z] = points;
    let haze = field.smooth(origin, Legs::OfLights);
    haze.add_beyond(job.level, beyond, [x, y, z], &mut depth);
    if field.lumps() == 0 || wanted.clone().next().is_none() || job.progress.is_over() {
        return depth;
    }
    let middle = middle(points, wanted.clone());
    let rays = side_by_side(beyond, points, middle);
    let radius2 = wanted.map(|at| get3(points, at).distance_squared(middle)).fold(0.0, f32::max);
    let radius = f64::from(radius2.sqrt()) * 1.000_001;
    let origin = origin + middle.as_dvec3();
    let length = field.reach(origin) + radius;
    let bundle = Bundle { origin, axis: beyond.toward, radius, tan: 0.0, length };
    let near = field.near_lumps(job.level, bundle, length, purpose);
    near.add_depth(job, &rays, true, &[length as f32; SIZE], &mut depth);
    depth
}

/// The middle of the box around some points.
fn middle(points: &Rows, wanted: impl Iterator<Item = usize>) -> Vec3 {
    let (mut min, mut max) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for at in wanted {
        let point = get3(points, at);
        (min, max) = (min.min(point), max.max(point));
    }
    0.5 * (min + max)
}

/// Rays from points to beyond everything; they start relative to a place.
fn side_by_side(beyond: &Beyond, points: &Rows, middle: Vec3) -> Rays {
    let mut rays = Rays::empty();
    for at in 0..SIZE {
        let start = get3(points, at) - middle;
        rays.set_ray(at, (start.as_dvec3(), beyond.toward));
    }
    rays.count = SIZE;
    rays
}
