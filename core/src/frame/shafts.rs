//! What surfaces hide of a lamp from the view rays.
//!
//! A plane through the eye and the lamp holds many view rays and many ways of light, and what stands in it hides points of
//! those rays. In such a slice a place has two coordinates, of which one is the same along a way of light, the other
//! along a view ray: X, the cotangent of the angle at the lamp, and H, that of the angle at the eye. Straight lines
//! stay straight in them. At one X a ray sees light if its H is above that of all that stands there. So a slice is a
//! row of heights over X, and a ray asks on which part of the row it is above (epipolar rectification: Engelhardt and
//! Dachsbacher 2010, Chen et al. 2011). Ours: rows are drawn from the surfaces themselves, not from a shadow map, and
//! their range is that of the picture, so that they are as fine as it is, from near or far.
//!
//! The eye or the lamp may be infinitely far away; then their angles are distances.

use super::viewpoint::Viewpoint;
use crate::geometry::{Beyond, Origin};
use crate::progress::{Interrupted, Job};
use crate::request::{Quality, View};
use crate::shapes::{Geometry, Plane, Solid, Sphere};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// What stands for the height of nothing.
pub const NOTHING: f32 = -1e6;
/// Places of a row whose least and largest heights are known.
pub const BLOCK: usize = 16;
/// No angle is nearer to that of the other end of its range [rad].
const LEAST_ANGLE: f64 = 1e-4;
/// A line ends at a place of a row that it comes so near to: as much as the least angle moves those at both ends.
const NEAR: f64 = 0.05;
/// Bytes of the rows of all lamps of a picture: 64 of them have 700 slices each for a screen.
const BYTES: usize = 96 << 20;
/// Slices that a small picture has, too, but for drafts: what it shows is no coarser than a large one's.
const LEAST: usize = 384;
/// Triangles that are drawn before the job is asked whether it goes on.
const WATCHED: usize = 4096;
/// Slices that one thread draws.
const TOGETHER: usize = 32;

/// Where the eye and the lamp are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ends {
    /// An eye and a lamp.
    Both,
    /// An eye and the sun.
    Eye,
    /// Parallel view rays and a lamp.
    Lamp,
    /// Parallel view rays and the sun.
    Neither,
}

/// The planes through an eye and a lamp, and the coordinates in them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pencil {
    /// Which of them are at a place.
    pub ends: Ends,
    /// A point of the line that all planes share, relative to the camera [m].
    pub origin: DVec3,
    /// Unit vector along that line: to the lamp, or to the eye; where both are far away, along which H is measured.
    pub axis: DVec3,
    /// Unit vectors across: from the first one slices are counted. Where both are far away, the first tells the slice,
    /// along the other one X is measured.
    pub across: [DVec3; 2],
    /// Distance of the lamp [m], or what stands for it.
    pub far: f64,
    /// The middle of the range of slices.
    pub middle: f64,
}

/// A place in the coordinates of a pencil, both before they are divided by its distance from the line.
#[derive(Clone, Copy, Debug)]
struct Place {
    across: DVec2,
    height: f64,
    x: f64,
}

impl Pencil {
    fn new(light: Origin, viewpoint: &Viewpoint, scale: f64) -> Self {
        let middle = 0.0;
        match (light, viewpoint.parallel) {
            (Origin::At(apex), false) => {
                let way = apex - viewpoint.position;
                let (axis, far) = (way.normalize_or(viewpoint.forward), way.length());
                let across = across(axis);
                Self { ends: Ends::Both, origin: DVec3::ZERO, axis, across, far, middle }
            }
            (Origin::Beyond(Beyond { toward, .. }), false) => {
                let across = across(toward);
                let (ends, origin) = (Ends::Eye, DVec3::ZERO);
                Self { ends, origin, axis: toward, across, far: scale, middle }
            }
            (Origin::At(apex), true) => {
                let (axis, origin) = (-viewpoint.forward, apex - viewpoint.position);
                Self { ends: Ends::Lamp, origin, axis, across: across(axis), far: 1.0, middle }
            }
            (Origin::Beyond(Beyond { toward, .. }), true) => {
                let view = viewpoint.forward;
                let normal = view.cross(toward).normalize_or(view.any_orthonormal_vector());
                // Along a ray X grows.
                let x = toward.cross(normal);
                let x = if x.dot(view) < 0.0 { -x } else { x };
                let (ends, axis) = (Ends::Neither, normal.cross(view));
                Self { ends, origin: DVec3::ZERO, axis, across: [normal, x], far: scale, middle }
            }
        }
    }

    fn place(&self, point: DVec3) -> Place {
        let way = point - self.origin;
        let along = way.dot(self.axis);
        let across = DVec2::from(self.across.map(|unit| way.dot(unit)));
        let [height, x] = match self.ends {
            Ends::Both => [along, self.far - along],
            Ends::Eye => [along, self.far],
            Ends::Lamp => [1.0, along],
            Ends::Neither => [along, across.y],
        };
        Place { across, height, x }
    }

    /// The slice of a place: an angle from the middle of their range, or a distance.
    fn slice(&self, place: &Place) -> f64 {
        match self.ends {
            Ends::Neither => place.across.x - self.middle,
            _ => turned(place.across.y.atan2(place.across.x) - self.middle),
        }
    }

    fn x(&self, angle: f64) -> f64 {
        match self.ends {
            Ends::Neither => angle,
            _ => 1.0 / angle.tan(),
        }
    }
}

fn across(axis: DVec3) -> [DVec3; 2] {
    let (right, up) = axis.any_orthonormal_pair();
    [right, up]
}

/// An angle from −π to π.
fn turned(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

/// How fine the rows of a picture are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fineness {
    /// How many slices, at least 2.
    slices: usize,
    /// Parts of a row.
    bins: usize,
}

impl Fineness {
    /// Of a picture in which so many lamps may be hidden: all of their rows fit into a bounded memory.
    pub fn of(view: &View, lamps: usize) -> Self {
        let (most, bins) = match view.quality {
            Quality::Draft => (384, 256),
            Quality::Full if view.for_screen => (1536, 512),
            Quality::Full => (3072, 1024),
        };
        let fit = BYTES / (size_of::<f32>() * (bins + 2 * BLOCK) * lamps.max(1));
        let seen = 2 * (view.width + view.height) as usize;
        let seen = if view.quality == Quality::Full { seen.max(LEAST) } else { seen };
        let slices = most.min(fit).min(seen).max(2);
        Self { slices, bins }
    }
}

/// The rows of all slices of a picture.
#[derive(Debug)]
pub struct Shafts {
    /// The planes.
    pub pencil: Pencil,
    /// How many slices.
    pub slices: usize,
    /// The first one, from the middle of their range.
    pub first: f64,
    /// How far each is from the next.
    pub step: f64,
    /// Parts of a row.
    pub bins: usize,
    /// The angles at its ends.
    pub angles: [f64; 2],
    /// Heights at the ends of all parts, row by row, each with its first one twice and room for a register behind.
    heights: Vec<f32>,
    /// The least and the largest height of every block, with those of its ends.
    ranges: Vec<[f32; 2]>,
    /// The same of whole rows.
    wholes: Vec<[f32; 2]>,
}

impl Shafts {
    /// Of what hides a lamp in a picture.
    ///
    /// # Errors
    /// [`Interrupted`] when the job's progress says so.
    pub fn new(
        job: &Job,
        geometry: &Geometry,
        light: Origin,
        viewpoint: &Viewpoint,
        Fineness { slices, bins }: Fineness,
    ) -> Result<Self, Interrupted> {
        let shift = geometry.anchor - viewpoint.position;
        let scale = geometry.reach(shift);
        let mut pencil = Pencil::new(light, viewpoint, scale);
        let [first, last] = range_of_slices(&mut pencil, viewpoint);
        let angles = match pencil.ends {
            Ends::Both | Ends::Lamp => [0.0, PI],
            Ends::Eye => [0.0, FRAC_PI_2],
            Ends::Neither => {
                // Whatever stands in the picture's fog or before it.
                let reach = scale + shift.length();
                [-reach, reach]
            }
        };
        let step = (last - first) / (slices - 1) as f64;
        let mut shafts = Self {
            pencil,
            slices,
            first,
            step,
            bins,
            angles,
            heights: Vec::new(),
            ranges: Vec::new(),
            wholes: Vec::new(),
        };
        shafts.draw(job, geometry, shift)?;
        Ok(shafts)
    }

    /// Numbers of a row.
    pub fn width(&self) -> usize {
        self.bins + 2 * BLOCK
    }

    /// A row of heights.
    #[inline(always)]
    pub fn row(&self, slice: usize) -> &[f32] {
        &self.heights[slice * self.width()..][..self.width()]
    }

    /// The least and the largest heights of its blocks.
    #[inline(always)]
    pub fn ranges(&self, slice: usize) -> &[[f32; 2]] {
        let blocks = self.bins / BLOCK;
        &self.ranges[slice * blocks..][..blocks]
    }

    /// The same of a whole row.
    #[inline(always)]
    pub fn whole(&self, slice: usize) -> [f32; 2] {
        self.wholes[slice]
    }

    /// All heights.
    pub fn heights(&self) -> &[f32] {
        &self.heights
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.heights.as_slice()) + size_of_val(self.ranges.as_slice())
    }

    fn draw(&mut self, job: &Job, geometry: &Geometry, shift: DVec3) -> Result<(), Interrupted> {
        let edges = Edges::new(self);
        let facets = facets(self, geometry, shift);
        let spheres = geometry.spheres.iter().filter(|sphere| geometry.throws(sphere.surface));
        let spheres: Vec<_> = spheres.map(|sphere| (sphere, self.span_of(sphere, shift))).collect();
        let width = self.width();
        let mut heights = vec![NOTHING; self.slices * width];
        heights.par_chunks_mut(TOGETHER * width).enumerate().try_for_each(|(chunk, rows)| {
            job.progress.check()?;
            let (begin, end) = (chunk * TOGETHER, (chunk + 1) * TOGETHER);
            let own = facets.iter().filter(|facet| facet.last >= begin && facet.first < end);
            for (i, facet) in own.enumerate() {
                if i % WATCHED == 0 {
                    job.progress.check()?;
                }
                for slice in facet.first.max(begin)..=facet.last.min(end.min(self.slices) - 1) {
                    let row = &mut rows[(slice - begin) * width + 1..][..width - 1];
                    facet.draw(self, &edges, slice, row);
                }
            }
            for (sphere, [first, last]) in &spheres {
                job.progress.check()?;
                for slice in (*first).max(begin)..=(*last).min(end.min(self.slices) - 1) {
                    let row = &mut rows[(slice - begin) * width + 1..][..width - 1];
                    self.draw_sphere(&edges, slice, sphere, shift, row);
                }
            }
            for row in rows.chunks_mut(width) {
                row[0] = row[1];
                row[self.bins + 2] = row[self.bins + 1];
            }
            Ok::<_, Interrupted>(())
        })?;
        let none = [f32::INFINITY, f32::NEG_INFINITY];
        let of_block = |row: &[f32], block: usize| {
            let own = &row[1 + block * BLOCK..=1 + (block + 1) * BLOCK];
            own.iter().fold(none, |[a, b], h| [a.min(*h), b.max(*h)])
        };
        let blocks = self.bins / BLOCK;
        self.ranges = heights
            .par_chunks(width)
            .flat_map_iter(|row| (0..blocks).map(move |block| of_block(row, block)))
            .collect();
        let of_row =
            |row: &[[f32; 2]]| row.iter().fold(none, |[a, b], own| [a.min(own[0]), b.max(own[1])]);
        self.wholes = self.ranges.chunks(blocks).map(of_row).collect();
        self.heights = heights;
        Ok(())
    }

    /// Which slices lie between two angles.
    fn slices_between(&self, from: f64, to: f64) -> [usize; 2] {
        let place = |angle: f64| (angle - self.first) / self.step;
        let first = place(from).ceil().max(0.0);
        let last = place(to).floor().min((self.slices - 1) as f64);
        if first <= last { [first as usize, last as usize] } else { [1, 0] }
    }

    fn angle_of(&self, slice: usize) -> f64 {
        self.first + slice as f64 * self.step
    }

    fn span_of(&self, sphere: &Sphere, shift: DVec3) -> [usize; 2] {
        let place = self.pencil.place(sphere.center.as_dvec3() + shift);
        let (middle, radius) = (self.pencil.slice(&place), f64::from(sphere.radius));
        let half = match self.pencil.ends {
            Ends::Neither => radius,
            _ if place.across.length() <= radius => return [0, self.slices - 1],
            _ => (radius / place.across.length()).asin(),
        };
        if self.pencil.ends != Ends::Neither && middle.abs() + half > PI {
            return [0, self.slices - 1];
        }
        self.slices_between(middle - half, middle + half)
    }

    /// Where ways of light in a slice first meet a sphere.
    fn draw_sphere(
        &self,
        edges: &Edges,
        slice: usize,
        sphere: &Sphere,
        shift: DVec3,
        row: &mut [f32],
    ) {
        let Pencil { ends, origin, axis, across: [right, up], far, middle } = self.pencil;
        let center = sphere.center.as_dvec3() + shift - origin;
        let at = self.angle_of(slice) + middle;
        // In the slice: along the axis and away from it; where both are far away, H and X.
        let (aside, away, off) = match ends {
            Ends::Neither => (axis, up, center.dot(right) - at),
            _ => {
                let away = right * at.cos() + up * at.sin();
                (axis, away, center.dot(axis.cross(away)))
            }
        };
        let radius2 = f64::from(sphere.radius).powi(2) - off * off;
        if radius2 <= 0.0 {
            return;
        }
        let (along, away) = (center.dot(aside), center.dot(away));
        for (height, x) in row.iter_mut().zip(&edges.x) {
            // A way of light: where it begins, or a point of it, and where it goes, as (along, away).
            let (start, way) = match ends {
                Ends::Both => (DVec2::new(far, 0.0), DVec2::new(-x, 1.0).normalize()),
                Ends::Lamp => (DVec2::ZERO, DVec2::new(*x, 1.0).normalize()),
                Ends::Eye => (DVec2::new(0.0, far / x), DVec2::NEG_X),
                Ends::Neither => (DVec2::new(0.0, *x), DVec2::NEG_X),
            };
            let to = DVec2::new(along, away) - start;
            let (near, miss) = (to.dot(way), to.perp_dot(way));
            let half2 = radius2 - miss * miss;
            if half2 <= 0.0 {
                continue;
            }
            let half = half2.sqrt();
            let is_placed = matches!(ends, Ends::Both | Ends::Lamp);
            let t = if is_placed && near - half < 0.0 { near + half } else { near - half };
            if is_placed && t <= 0.0 {
                continue;
            }
            let point = start + t * way;
            let own = match ends {
                Ends::Lamp => 1.0 / point.y,
                Ends::Neither => point.x,
                _ => point.x / point.y,
            };
            *height = height.max(own as f32);
        }
    }
}

/// X at the ends of the parts of rows, and where slices lie.
struct Edges {
    x: Vec<f64>,
    /// Slice by slice the sine and cosine of its angle, or its distance.
    slices: Vec<[f64; 2]>,
}

impl Edges {
    fn new(shafts: &Shafts) -> Self {
        let [first, last] = shafts.angles;
        let least = if shafts.pencil.ends == Ends::Neither { 0.0 } else { LEAST_ANGLE };
        let x = |i: usize| {
            let angle = first + (last - first) * i as f64 / shafts.bins as f64;
            shafts.pencil.x(angle.clamp(first + least, last - least))
        };
        let slice = |i: usize| {
            let at = shafts.angle_of(i) + shafts.pencil.middle;
            let (sine, cosine) = at.sin_cos();
            if shafts.pencil.ends == Ends::Neither { [at, 0.0] } else { [sine, cosine] }
        };
        Self {
            x: (0..=shafts.bins).map(x).collect(),
            slices: (0..shafts.slices).map(slice).collect(),
        }
    }
}

/// A triangle in the coordinates of a pencil.
struct Facet {
    corners: [Place; 3],
    /// The slices that it may meet.
    first: usize,
    last: usize,
}

/// All triangles that throw shadows, and those that boxes are made of.
fn facets(shafts: &Shafts, geometry: &Geometry, shift: DVec3) -> Vec<Facet> {
    let of_solid = |solid: &Solid| -> Vec<Facet> {
        match *solid {
            Solid::Triangle(at) => {
                let triangle = &geometry.triangles[at as usize];
                let corners = triangle.corners.map(|corner| corner.as_dvec3() + shift);
                let throws = geometry.throws(triangle.surface);
                Facet::new(shafts, corners).into_iter().filter(|_| throws).collect()
            }
            Solid::Cuboid(at) => {
                let cuboid = &geometry.cuboids[at as usize];
                if !geometry.throws(cuboid.surface) {
                    return Vec::new();
                }
                let ends = [cuboid.min, cuboid.max].map(|corner| corner.as_dvec3() + shift);
                of_box(ends).filter_map(|corners| Facet::new(shafts, corners)).collect()
            }
            Solid::Sphere(_) => Vec::new(),
        }
    };
    let mut all: Vec<_> = geometry.solids.par_iter().flat_map_iter(of_solid).collect();
    if matches!(shafts.pencil.ends, Ends::Lamp | Ends::Neither) {
        let planes = geometry.planes.iter().filter(|plane| geometry.throws(plane.surface));
        all.extend(
            planes
                .flat_map(|plane| wide(plane, shift, WIDE * geometry.reach(shift)))
                .filter_map(|corners| Facet::new(shafts, corners)),
        );
    }
    all
}

/// Extents of a scene that stand for all of a plane: of what is farther no parallel view ray knows.
const WIDE: f64 = 100.0;

/// The triangles that stand for a plane: before one eye planes hide all or nothing, before parallel rays parts.
fn wide(plane: &Plane, shift: DVec3, half: f64) -> [[DVec3; 3]; 2] {
    let (right, up) = plane.normal.any_orthonormal_pair();
    let center = plane.point + shift;
    let corner = |x: f64, y: f64| center + half * (x * right + y * up);
    let [a, b, c, d] = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    [[a, b, c], [a, c, d]]
}

/// The triangles of a box.
fn of_box([min, max]: [DVec3; 2]) -> impl Iterator<Item = [DVec3; 3]> {
    (0..6).flat_map(move |face| {
        let (axis, high) = (face % 3, face >= 3);
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        let corner = |u: bool, v: bool| {
            let mut corner = if high { max } else { min };
            corner[b] = if u { max[b] } else { min[b] };
            corner[c] = if v { max[c] } else { min[c] };
            corner
        };
        let [p, q, r, s] =
            [corner(false, false), corner(true, false), corner(true, true), corner(false, true)];
        [[p, q, r], [p, r, s]]
    })
}

impl Facet {
    fn new(shafts: &Shafts, corners: [DVec3; 3]) -> Option<Self> {
        let pencil = &shafts.pencil;
        let corners = corners.map(|corner| pencil.place(corner));
        let angles = corners.each_ref().map(|place| pencil.slice(place));
        let low = angles.iter().copied().fold(f64::INFINITY, f64::min);
        let high = angles.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let is_plane = pencil.ends == Ends::Neither;
        // What lies around the line, or across the back of the range, may be anywhere.
        let [first, last] = if !is_plane && high - low >= PI {
            [0, shafts.slices - 1]
        } else {
            shafts.slices_between(low, high)
        };
        (first <= last).then_some(Self { corners, first, last })
    }

    /// Raises the heights of a row to those of the line in which its slice cuts the triangle.
    fn draw(&self, shafts: &Shafts, edges: &Edges, slice: usize, row: &mut [f32]) {
        let is_plane = shafts.pencil.ends == Ends::Neither;
        let [sine, cosine] = edges.slices[slice];
        // How far corners lie beside the slice, and from the line.
        let side = |place: &Place| match is_plane {
            true => place.across.x - sine,
            false => place.across.y * cosine - place.across.x * sine,
        };
        let away = |place: &Place| match is_plane {
            true => 1.0,
            false => place.across.x * cosine + place.across.y * sine,
        };
        let mut ends = [[0.0; 3]; 3];
        let mut count = 0;
        for i in 0..3 {
            let (a, b) = (&self.corners[i], &self.corners[(i + 1) % 3]);
            let (p, q) = (side(a), side(b));
            if (p < 0.0) != (q < 0.0) {
                let part = p / (p - q);
                let mix = |a: f64, b: f64| a + (b - a) * part;
                ends[count] = [mix(away(a), away(b)), mix(a.height, b.height), mix(a.x, b.x)];
                count += 1;
            }
        }
        if count < 2 {
            return;
        }
        let [a, b] = [ends[0], ends[1]];
        let least = 1e-9 * (a[0].abs() + b[0].abs()) + f64::MIN_POSITIVE;
        if a[0] < least && b[0] < least {
            return;
        }
        let clipped = |from: [f64; 3], to: [f64; 3]| {
            if from[0] >= least {
                return from;
            }
            let part = (least - from[0]) / (to[0] - from[0]);
            [0, 1, 2].map(|k| from[k] + (to[k] - from[k]) * part)
        };
        let (a, b) = (clipped(a, b), clipped(b, a));
        draw_line(shafts, edges, [a, b].map(|[away, height, x]| [x / away, height / away]), row);
    }
}

/// The angle from 0 to π of a cotangent, to 2e-7: a thousandth of a part of a row (Abramowitz and Stegun 4.4.49).
fn cotangent(x: f64) -> f64 {
    let size = x.abs();
    let is_steep = size < 1.0;
    let ratio = if is_steep { size } else { 1.0 / size };
    let t = ratio * ratio;
    let high = 0.042_909_614 + t * (-0.016_165_737 + t * 0.002_866_225_7);
    let middle = -0.142_089 + t * (0.106_562_64 + t * (-0.075_289_64 + t * high));
    let small = ratio * (1.0 + t * (-0.333_331_45 + t * (0.199_935_5 + t * middle)));
    let acute = if is_steep { FRAC_PI_2 - small } else { small };
    if x < 0.0 { PI - acute } else { acute }
}

/// Raises a row to a line between two points of X and H.
fn draw_line(shafts: &Shafts, edges: &Edges, [a, b]: [[f64; 2]; 2], row: &mut [f32]) {
    let [first, last] = shafts.angles;
    let scale = shafts.bins as f64 / (last - first);
    let is_plane = shafts.pencil.ends == Ends::Neither;
    let place = |x: f64| (if is_plane { x } else { cotangent(x) } - first) * scale;
    let (p, q) = (place(a[0]), place(b[0]));
    let begin = (p.min(q) - NEAR).ceil().max(0.0) as usize;
    let end = (p.max(q) + NEAR).floor().min(shafts.bins as f64);
    if end < begin as f64 {
        return;
    }
    let slope = (b[1] - a[1]) / (b[0] - a[0]);
    let slope = if slope.is_finite() { slope } else { 0.0 };
    let end = end as usize;
    for (height, x) in row[begin..=end].iter_mut().zip(&edges.x[begin..=end]) {
        *height = height.max((a[1] + (x - a[0]) * slope) as f32);
    }
}

/// The slices that the rays of a picture lie in, from the middle of their range.
fn range_of_slices(pencil: &mut Pencil, viewpoint: &Viewpoint) -> [f64; 2] {
    let size = viewpoint.size();
    // A pixel beyond the picture: samples and cells at its rim.
    let at = |x: f64, y: f64| {
        let (start, direction) = viewpoint.ray(DVec2::new(x, y) * (size + 2.0) - 1.0);
        match pencil.ends {
            Ends::Both | Ends::Eye => direction,
            Ends::Lamp | Ends::Neither => start,
        }
    };
    let place = |point: DVec3| pencil.place(point);
    let middle = place(at(0.5, 0.5));
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| place(at(x, y)));
    let is_turned = pencil.ends != Ends::Neither;
    // The line passes through the picture if the corners turn around it.
    let turns = (0..4).map(|i| {
        let (a, b) = (corners[i].across, corners[(i + 1) % 4].across);
        a.perp_dot(b).atan2(a.dot(b))
    });
    let turns: Vec<f64> = turns.collect();
    let is_around =
        turns.iter().sum::<f64>().abs() > PI || turns.iter().any(|turn| turn.abs() > 0.9 * PI);
    if is_turned && is_around {
        pencil.middle = 0.0;
        return [-PI, PI];
    }
    let across = middle.across;
    pencil.middle = if is_turned { across.y.atan2(across.x) } else { across.x };
    let all = corners.each_ref().map(|corner| pencil.slice(corner));
    let low = all.iter().copied().fold(0.0, f64::min);
    let high = all.iter().copied().fold(0.0, f64::max);
    let least = 1e-9 * (1.0 + pencil.middle.abs());
    [low - least, high + least]
}
