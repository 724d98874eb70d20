//! The mean extinction T(s, x)/d towards one light, tabulated by direction and by the logarithm of
//! the distance: where many blobs shade a light, a look-up costs the same whatever their number.
//!
//! The quotient is smooth through the light itself, where T has a cone, and the table is
//! interpolated by cubics in all three coordinates. Directions are those of a cube's six faces, one
//! sample wider on each side, so that no cubic reaches over an edge.

use super::control::{self, Control, Each};
use crate::airlight::ENDS;
use crate::cpu::blobs::{BlobList, Purpose};
use crate::cpu::frame::Context;
use crate::geometry::bundle::Bundle;
use crate::media::Field;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Fewer blobs than this are summed up directly.
const FEWEST_BLOBS: usize = 48;
/// Most samples along the side of a face, and along a direction.
const MOST: usize = 64;
const MOST_SHELLS: usize = 112;
/// What cubics between samples may miss of a blob's half depth, in optical depth.
const ERROR: f64 = 4e-3;
/// Directions that are summed up together: a square of them.
const GROUP: usize = 8;

/// T(s, x)/d of a scene's blobs around one light.
#[derive(Debug)]
pub struct LightTable {
    /// Samples along the side of a face, without those beyond its edges.
    side: usize,
    shells: usize,
    /// ln of the first shell's radius [m].
    first: f32,
    /// Shells per unit of ln r.
    density: f32,
    /// `[face][row][column][shell]`.
    values: Vec<f32>,
}

/// Geometry of a table: spacing of samples [rad], nearest and farthest shell [m].
struct Extent {
    spacing: f64,
    near: f64,
    far: f64,
}

impl Extent {
    /// `None` if the blobs are too small for any table.
    fn new(field: &Field, light: DVec3) -> Option<Self> {
        let (mut near, mut far) = (f64::INFINITY, 0.0f64);
        let mut spacings = Vec::with_capacity(field.blobs.len());
        for blob in &field.blobs {
            let distance = blob.center.distance(light);
            let radius = 1.0 / blob.a;
            // The fourth derivative of a Gaussian, met by the error of cubics.
            let sharp = (ERROR / (0.28 * blob.half_depth())).powf(0.25).min(1.5);
            spacings.push(sharp * radius / distance.max(radius));
            near = near.min(radius.max(distance - 3.0 * radius));
            far = far.max(distance + ENDS * radius);
        }
        spacings.sort_unstable_by(f64::total_cmp);
        let finest = 2.0 / MOST as f64;
        // A few blobs that are finer than the rest do not decide: they are far away, or thin.
        let spacing = spacings[spacings.len() / 10].clamp(finest, 0.25);
        let fits = spacings[spacings.len() / 4] > 0.25 * finest;
        fits.then_some(Self { spacing, near: (0.2 * near).max(1e-3 * far), far })
    }
}

impl LightTable {
    /// The table of a light, if it pays.
    pub fn new(context: &Context, light: DVec3) -> Option<Self> {
        if context.field.blobs.len() < FEWEST_BLOBS {
            return None;
        }
        let extent = Extent::new(context.field, light)?;
        let side = (2.0 / extent.spacing).ceil() as usize + 1;
        let span = (extent.far / extent.near).ln();
        let shells = (span / extent.spacing).ceil().min(MOST_SHELLS as f64) as usize + 3;
        // One shell stands before the first and one after the last.
        let density = (shells - 3) as f64 / span;
        let first = extent.near.ln() - 1.0 / density;
        let mut table = Self {
            side,
            shells,
            first: first as f32,
            density: density as f32,
            values: vec![0.0; 6 * (side + 2) * (side + 2) * shells],
        };
        table.fill(context, light);
        Some(table)
    }

    fn fill(&mut self, context: &Context, light: DVec3) {
        let (wide, side, shells) = (self.side + 2, self.side, self.shells);
        let t: Vec<Each> = (0..shells).map(|i| [self.radius(i) as f32; 16]).collect();
        // Bands of a face's rows: in each, squares of directions share a list of blobs.
        let band = GROUP * wide * shells;
        let bands: Vec<_> =
            (0..6).flat_map(|face| (0..wide).step_by(GROUP).map(move |row| (face, row))).collect();
        let mut rest = self.values.as_mut_slice();
        let mut parts = Vec::new();
        for (face, row) in bands {
            let rows = GROUP.min(wide - row);
            let (part, after) = rest.split_at_mut(band / GROUP * rows);
            parts.push((face, row, part));
            rest = after;
        }
        parts.into_par_iter().for_each(|(face, row, part)| {
            for column in (0..wide).step_by(GROUP) {
                let place = |i: usize| direction(face, row + i / GROUP, column + i % GROUP, side);
                let square: Vec<_> = (0..GROUP * GROUP).map(place).collect();
                for (i, shells_of) in group(context, light, &square, &t).into_iter().enumerate() {
                    let (y, x) = (i / GROUP, column + i % GROUP);
                    let at = (y * wide + x) * shells;
                    if x < wide && at < part.len() {
                        part[at..at + shells].copy_from_slice(&shells_of);
                    }
                }
            }
        });
    }

    /// How much memory it takes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.values.as_slice())
    }

    fn radius(&self, shell: usize) -> f64 {
        (f64::from(self.first) + shell as f64 / f64::from(self.density)).exp()
    }

    /// The blobs' mean extinction between the light and a point relative to it [1/m].
    pub fn mean(&self, way: Vec3) -> f32 {
        let distance = way.length().max(f32::MIN_POSITIVE);
        let (face, u, v) = face(way);
        let (column, fx) = self.cell(u);
        let (row, fy) = self.cell(v);
        let last = (self.shells - 2) as f32;
        let radial = (distance.ln() - self.first) * self.density;
        let shell = (radial.clamp(1.0, last - 1e-3)) as usize;
        let (wx, wy) = (cubic(fx), cubic(fy));
        let wr = cubic((radial - shell as f32).clamp(0.0, 1.0));
        let wide = self.side + 2;
        let mut sum = 0.0;
        for (i, wy) in wy.iter().enumerate() {
            let row = (face * wide + row + i) * wide + column;
            for (k, wx) in wx.iter().enumerate() {
                let at = (row + k) * self.shells + shell - 1;
                let [a, b, c, d] = self.values[at..at + 4] else { continue };
                let along = (wr[0] * a + wr[1] * b) + (wr[2] * c + wr[3] * d);
                sum += wx * wy * along;
            }
        }
        // Behind the last shell nothing is added.
        let beyond = (radial - last).max(0.0) / self.density;
        (sum * (-beyond).exp()).max(0.0)
    }

    /// The first sample of a cubic, and where it is used between the middle two.
    fn cell(&self, u: f32) -> (usize, f32) {
        let at = (u + 1.0) * 0.5 * (self.side - 1) as f32;
        let first = (at as usize).min(self.side - 2);
        (first, at - first as f32)
    }
}

/// Weights of the cubic through samples at −1, 0, 1, 2.
fn cubic(x: f32) -> [f32; 4] {
    let (before, after, end) = (x + 1.0, x - 1.0, x - 2.0);
    [
        -x * after * end / 6.0,
        before * after * end / 2.0,
        -before * x * end / 2.0,
        before * x * after / 6.0,
    ]
}

/// The face of a cube that a direction meets, and where.
fn face(way: Vec3) -> (usize, f32, f32) {
    let size = way.abs();
    let (axis, u, v) = if size.x >= size.y && size.x >= size.z {
        (0, way.y / size.x, way.z / size.x)
    } else if size.y >= size.z {
        (1, way.z / size.y, way.x / size.y)
    } else {
        (2, way.x / size.z, way.y / size.z)
    };
    let guard = |value: f32| if value.is_finite() { value } else { 0.0 };
    (2 * axis + usize::from(way[axis] < 0.0), guard(u), guard(v))
}

/// The direction of a sample.
fn direction(face: usize, row: usize, column: usize, side: usize) -> DVec3 {
    let at = |i: usize| -1.0 + (i as f64 - 1.0) * 2.0 / (side - 1) as f64;
    let (u, v) = (at(column), at(row));
    let major = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
    match face / 2 {
        0 => DVec3::new(major, u, v),
        1 => DVec3::new(v, major, u),
        _ => DVec3::new(u, v, major),
    }
    .normalize()
}

/// T/d at every shell, for each direction of a group.
fn group(context: &Context, light: DVec3, square: &[DVec3], t: &[Each]) -> Vec<Vec<f32>> {
    let field = context.field;
    let longest = f64::from(t[t.len() - 1][0]);
    let rays: Vec<_> = square.iter().map(|direction| (light, *direction)).collect();
    let around = Bundle::around(&rays, longest);
    let bundle = around.unwrap_or(Bundle::all_around(light, longest));
    let list = BlobList::new(context.level, field, &bundle, 0.0, Purpose::Nodes);
    let blobs = control::unpack(&list);
    let mut all = Vec::with_capacity(square.len());
    for rays in square.chunks(control::PADDED) {
        let control = Control::from_directions(rays);
        let depth = control.depth(context, &blobs, t);
        for c in 0..rays.len() {
            all.push(depth.iter().zip(t).map(|(depth, t)| depth[c] / t[c]).collect());
        }
    }
    all
}
