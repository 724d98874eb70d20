//! The camera as rays: pixel (i, j) looks through its centre, row 0 at the top.

use crate::airlight::fogshop2007::Eye;
use crate::geometry::batch::{Rays, SIZE, TILE};
use crate::scene::{Camera, Projection};
use fearless_simd::{Level, Simd, dispatch};
use glam::{DVec2, DVec3, Vec3};

/// A camera with a picture size.
#[derive(Clone, Copy, Debug)]
pub struct Viewpoint {
    /// Where the camera is [m].
    pub position: DVec3,
    /// Unit view direction.
    pub forward: DVec3,
    /// From the middle of the picture to its right edge: per metre of depth under perspective,
    /// else in metres.
    right: DVec3,
    /// From the middle of the picture to its upper edge, likewise.
    up: DVec3,
    /// Whether all rays are parallel.
    pub parallel: bool,
    size: DVec2,
}

impl Viewpoint {
    /// The camera for a picture of `width` × `height` pixels.
    pub fn new(camera: &Camera, width: usize, height: usize) -> Self {
        let position = camera.position.vector();
        let forward = (camera.target.vector() - position).normalize();
        let right = forward.cross(camera.up.vector().normalize()).normalize();
        let (half, parallel) = match &camera.projection {
            Projection::Perspective(p) => ((0.5 * p.vertical_fov_deg.to_radians()).tan(), false),
            Projection::Orthographic(o) => (0.5 * o.height_m, true),
        };
        let size = DVec2::new(width as f64, height as f64);
        let aspect = size.x / size.y;
        let up = right.cross(forward) * half;
        Self { position, forward, right: right * half * aspect, up, parallel, size }
    }

    /// From the middle of the picture to its right and to its upper edge: per metre of depth under
    /// perspective, else in metres.
    pub fn half_axes(&self) -> (DVec3, DVec3) {
        (self.right, self.up)
    }

    /// Pixels across and down.
    pub fn size(&self) -> DVec2 {
        self.size
    }

    /// How wide a pixel is, diagonally: as a share of its distance under perspective, else of the picture's own size.
    pub fn pixel(&self) -> f64 {
        let wide = 2.0 * (self.right.length() / self.size.x + self.up.length() / self.size.y);
        if self.parallel { 0.1 } else { wide }
    }

    /// Where rays start, for the published airlight.
    pub fn eye(&self) -> Eye {
        if self.parallel {
            Eye::Plane(self.position, self.forward)
        } else {
            Eye::Point(self.position)
        }
    }

    /// The ray through a place of the picture, in pixels from its upper left corner: its start
    /// relative to the camera and its unit direction.
    #[inline(always)]
    pub fn ray(&self, pixel: DVec2) -> (DVec3, DVec3) {
        let aside = self.aside(pixel);
        if self.parallel {
            (aside, self.forward)
        } else {
            (DVec3::ZERO, (self.forward + aside).normalize())
        }
    }

    /// The ray to a point, which is given relative to the camera: its start, its unit direction and its length [m].
    pub fn toward(&self, point: DVec3) -> (DVec3, DVec3, f64) {
        if self.parallel {
            let depth = point.dot(self.forward);
            return (point - depth * self.forward, self.forward, depth.max(0.0));
        }
        let length = point.length();
        (DVec3::ZERO, point.normalize_or(self.forward), length)
    }

    /// How far a place of the picture lies beside its middle: per metre of depth under perspective, else in
    /// metres.
    #[inline(always)]
    fn aside(&self, pixel: DVec2) -> DVec3 {
        let at = 2.0 * pixel / self.size - 1.0;
        at.x * self.right - at.y * self.up
    }

    /// The rays of a tile; `shift` moves them within their pixels, from (½, ½) in the centres.
    pub fn tile(&self, tile: Tile, shift: DVec2) -> Rays {
        let mut rays = Rays::empty();
        dispatch!(Level::new(), simd => fill(simd, self, tile, shift, &mut rays));
        rays
    }

    /// Where a point relative to the camera appears [px], if it lies in front of it.
    pub fn project(&self, point: DVec3) -> Option<DVec2> {
        let depth = point.dot(self.forward);
        if depth <= 0.0 {
            return None;
        }
        let at = self.plane_coordinates(point) / if self.parallel { 1.0 } else { depth };
        Some((at + 1.0) * 0.5 * self.size)
    }

    /// The two vectors whose products with a point give its place in the picture, before the
    /// division by depth: −1 to 1 across.
    pub fn picture_axes(&self) -> (Vec3, Vec3) {
        let (x, y) = (self.right, -self.up);
        ((x / x.length_squared()).as_vec3(), (y / y.length_squared()).as_vec3())
    }

    fn plane_coordinates(&self, point: DVec3) -> DVec2 {
        let x = point.dot(self.right) / self.right.length_squared();
        let y = -point.dot(self.up) / self.up.length_squared();
        DVec2::new(x, y)
    }
}

/// The rays of a tile, compiled for this machine's lanes.
#[inline(always)]
fn fill<S: Simd>(_simd: S, viewpoint: &Viewpoint, tile: Tile, shift: DVec2, rays: &mut Rays) {
    let (x, y) = (tile.x as f64 + shift.x, tile.y as f64 + shift.y);
    let aside =
        |row: usize, column: usize| viewpoint.aside(DVec2::new(x + column as f64, y + row as f64));
    // Row by row, at fixed places and in loops of their own: so the compiler sees lanes.
    if viewpoint.parallel {
        for row in 0..TILE {
            for column in 0..TILE {
                rays.set_ray(row * TILE + column, (aside(row, column), viewpoint.forward));
            }
        }
    } else {
        for row in 0..TILE {
            for column in 0..TILE {
                let direction = (viewpoint.forward + aside(row, column)).normalize();
                rays.set_direction(row * TILE + column, direction);
            }
        }
    }
    rays.count = SIZE;
}

/// A square of pixels.
#[derive(Clone, Copy, Debug)]
pub struct Tile {
    /// Left column.
    pub x: usize,
    /// Top row.
    pub y: usize,
}

impl Tile {
    /// The picture's pixel at a place of the tile's rows.
    pub fn pixel(self, place: usize) -> (usize, usize) {
        (self.x + place % TILE, self.y + place / TILE)
    }
}

/// A picture's tiles, row by row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
}

impl Grid {
    /// How many tiles.
    pub fn count(self) -> usize {
        self.width.div_ceil(TILE) * self.height.div_ceil(TILE)
    }

    /// The tiles in squares of up to `side` by `side`.
    pub fn blocks(self, side: usize) -> Vec<Vec<usize>> {
        let (across, down) = (self.width.div_ceil(TILE), self.height.div_ceil(TILE));
        let square = |x: usize, y: usize| {
            let rows = y..(y + side).min(down);
            rows.flat_map(|y| (x..(x + side).min(across)).map(move |x| y * across + x)).collect()
        };
        let (rows, columns) = ((0..down).step_by(side), (0..across).step_by(side));
        rows.flat_map(|y| columns.clone().map(move |x| square(x, y))).collect()
    }

    /// One of them.
    pub fn tile(self, index: usize) -> Tile {
        let across = self.width.div_ceil(TILE);
        Tile { x: index % across * TILE, y: index / across * TILE }
    }

    /// Tile and place in it of a pixel.
    pub fn locate(self, x: usize, y: usize) -> (usize, usize) {
        let across = self.width.div_ceil(TILE);
        (y / TILE * across + x / TILE, y % TILE * TILE + x % TILE)
    }

    /// Whether a pixel lies in the picture.
    pub fn contains(self, (x, y): (usize, usize)) -> bool {
        x < self.width && y < self.height
    }
}
