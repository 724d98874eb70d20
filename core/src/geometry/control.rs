//! Sixteen rays side by side, for fields along them: eight that stand for a patch, repeated, or others.

use super::batch::{Rows, SIZE};
use glam::{DVec3, Vec3};

/// Numbers in a row: as many as the widest registers hold.
pub const PADDED: usize = 16;
/// One row: of eight rays at two places, or of sixteen rays at one.
pub type Each = [f32; PADDED];

/// As many rays as a row holds numbers, relative to an origin.
#[derive(Clone, Debug)]
pub struct Control {
    /// Unit directions.
    pub direction: [Each; 3],
    /// Where each starts [m].
    pub offset: [Each; 3],
}

impl Control {
    /// Rays by their starts and directions.
    pub fn new(ray: impl Fn(usize) -> (DVec3, DVec3)) -> Self {
        let zero = [[0.0; PADDED]; 3];
        let mut control = Self { direction: zero, offset: zero };
        for c in 0..PADDED {
            let (offset, direction) = ray(c);
            for k in 0..3 {
                control.direction[k][c] = direction[k] as f32;
                control.offset[k][c] = offset[k] as f32;
            }
        }
        control
    }

    /// Where the first of them starts, and its direction.
    pub fn first(&self) -> (DVec3, DVec3) {
        let first = |rows: &[Each; 3]| DVec3::from(rows.map(|row| f64::from(row[0])));
        (first(&self.offset), first(&self.direction).normalize())
    }

    /// Points of the rays, row by row; the last one again where there are fewer than a batch holds.
    pub fn points(&self, t: &[Each]) -> Rows {
        let t = t.as_flattened();
        let mut points = [[0.0; SIZE]; 3];
        for at in 0..SIZE {
            let point = self.point(at % PADDED, t[at.min(t.len() - 1)]);
            (0..3).for_each(|k| points[k][at] = point[k]);
        }
        points
    }

    /// A point of one of the rays.
    pub fn point(&self, c: usize, t: f32) -> Vec3 {
        Vec3::from_array([0, 1, 2].map(|k| self.direction[k][c].mul_add(t, self.offset[k][c])))
    }
}
