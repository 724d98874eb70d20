//! Up to 256 rays side by side, one array per coordinate, as SIMD lanes want them.

use fearless_simd::Simd;

use crate::num::Lanes;
use crate::vector::V3;
use glam::{DVec3, Vec3};

/// Pixels along the side of a tile.
pub const TILE: usize = 16;
/// Rays of a batch.
pub const SIZE: usize = TILE * TILE;

/// One number a ray.
pub type Row = [f32; SIZE];
/// One vector a ray.
pub type Rows = [Row; 3];

/// Rays: a tile of pixels in rows, or any others.
#[derive(Clone, Debug)]
pub struct Rays {
    /// How many are in use; the rest repeat the last one.
    pub count: usize,
    /// Unit directions.
    pub direction: Rows,
    /// Where each starts, relative to the viewpoint [m].
    pub offset: Offsets,
}

/// Where rays start: rows of numbers, which take no memory while all are zero, as under perspective.
#[derive(Clone, Debug, Default)]
pub struct Offsets(Option<Box<Rows>>);

impl Offsets {
    /// Sets where one ray starts.
    #[inline(always)]
    fn set(&mut self, at: usize, offset: Vec3) {
        if self.0.is_none() && offset == Vec3::ZERO {
            return;
        }
        let rows = self.0.get_or_insert_with(|| Box::new([[0.0; SIZE]; 3]));
        (0..3).for_each(|k| rows[k][at] = offset[k]);
    }
}

impl std::ops::Deref for Offsets {
    type Target = Rows;

    #[inline(always)]
    fn deref(&self) -> &Rows {
        static ZERO: Rows = [[0.0; SIZE]; 3];
        self.0.as_deref().unwrap_or(&ZERO)
    }
}

/// Where rays end.
#[derive(Clone, Debug)]
pub struct Hits {
    /// Distance along the ray [m]; `far_m` where nothing is hit.
    pub length: Row,
    /// Unit normal, on the side of the surface that the eye sees; zero where nothing is hit.
    pub normal: Rows,
    /// Place among the scene's surfaces, or [`NOTHING`].
    pub surface: [u32; SIZE],
    /// Where on which triangles, if that is asked for.
    pub triangles: Option<Box<OnTriangles>>,
}

/// Where rays end on triangles.
#[derive(Clone, Debug)]
pub struct OnTriangles {
    /// Places among the geometry's triangles; of what else is hit larger than any.
    pub place: [u32; SIZE],
    /// The shares of the first and of the second corner; the third has the rest.
    pub shares: [Row; 2],
}

/// Marks a ray that hits nothing.
pub const NOTHING: u32 = u32::MAX;

/// What the fog does along rays.
#[derive(Clone, Debug)]
pub struct Fogged {
    /// Optical depth.
    pub depth: Row,
    /// Airlight per unit of ω·I of some lamps, a row each [1/m²].
    pub airlight: Vec<Row>,
}

impl Rays {
    /// No rays yet.
    pub fn empty() -> Self {
        Self { count: 0, direction: [[0.0; SIZE]; 3], offset: Offsets::default() }
    }

    /// Appends a ray of another batch.
    pub fn push(&mut self, from: &Self, at: usize) {
        for k in 0..3 {
            self.direction[k][self.count] = from.direction[k][at];
        }
        self.offset.set(self.count, get3(&from.offset, at));
        self.count += 1;
    }

    /// Appends a ray: its start relative to the viewpoint and its unit direction.
    pub fn push_ray(&mut self, ray: (DVec3, DVec3)) {
        self.set_ray(self.count, ray);
        self.count += 1;
    }

    /// Sets the ray at a place.
    #[inline(always)]
    pub fn set_ray(&mut self, at: usize, (offset, direction): (DVec3, DVec3)) {
        self.set_direction(at, direction);
        self.offset.set(at, offset.as_vec3());
    }

    /// Sets the unit direction of the ray at a place.
    #[inline(always)]
    pub fn set_direction(&mut self, at: usize, direction: DVec3) {
        for k in 0..3 {
            self.direction[k][at] = direction[k] as f32;
        }
    }

    /// Bytes that they take.
    pub fn bytes(&self) -> usize {
        size_of::<Self>() + self.offset.0.as_ref().map_or(0, |rows| size_of_val(&**rows))
    }

    /// Repeats the last ray to the end, so that whole registers may be read.
    pub fn pad(&mut self) {
        let Some(last) = self.count.checked_sub(1) else { return };
        for rows in [Some(&mut self.direction), self.offset.0.as_deref_mut()].into_iter().flatten()
        {
            for row in rows {
                let value = row[last];
                row[self.count..].fill(value);
            }
        }
    }
}

impl Default for Hits {
    fn default() -> Self {
        Self::nothing(0.0)
    }
}

impl Hits {
    /// Nothing hit up to `far_m`.
    pub fn nothing(far_m: f32) -> Self {
        Self {
            length: [far_m; SIZE],
            normal: [[0.0; SIZE]; 3],
            surface: [NOTHING; SIZE],
            triangles: None,
        }
    }

    /// Bytes that they take.
    pub fn bytes(&self) -> usize {
        size_of::<Self>() + self.triangles.as_ref().map_or(0, |on| size_of_val(&**on))
    }

    /// Whether a ray meets no surface.
    pub fn sees_nothing(&self, at: usize) -> bool {
        self.surface[at] == NOTHING
    }

    /// Copies where one ray of another batch ends.
    pub fn copy(&mut self, at: usize, from: &Self, place: usize) {
        self.length[at] = from.length[place];
        self.surface[at] = from.surface[place];
        for k in 0..3 {
            self.normal[k][at] = from.normal[k][place];
        }
    }

    /// Repeats the ray at `last` to the end.
    pub fn pad(&mut self, last: usize) {
        let (length, surface) = (self.length[last], self.surface[last]);
        self.length[last..].fill(length);
        self.surface[last..].fill(surface);
        for row in &mut self.normal {
            let value = row[last];
            row[last..].fill(value);
        }
    }
}

impl Fogged {
    /// Clear air, before so many lamps.
    pub fn clear(lamps: usize) -> Self {
        Self { depth: [0.0; SIZE], airlight: vec![[0.0; SIZE]; lamps] }
    }
}

/// The lanes of three rows from `at` on.
#[inline(always)]
pub fn load3<S: Simd, const N: usize>(simd: S, rows: &[[f32; N]; 3], at: usize) -> V3<Lanes<S>> {
    let [x, y, z] = rows;
    V3::new(Lanes::load(simd, &x[at..]), Lanes::load(simd, &y[at..]), Lanes::load(simd, &z[at..]))
}

/// One vector of three rows.
pub fn get3(rows: &Rows, at: usize) -> Vec3 {
    Vec3::new(rows[0][at], rows[1][at], rows[2][at])
}

/// Rays and where they end.
#[derive(Clone, Copy)]
pub struct Ends<'a> {
    /// The rays.
    pub rays: &'a Rays,
    /// Their first hits.
    pub hits: &'a Hits,
}
