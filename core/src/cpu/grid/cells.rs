//! The squares of a block.

use super::knots::between;
use super::{BLOCK, Block, Grid, Scattered};
use crate::cpu::places::{CONTROL, Member, PLACES, Samples, cone};
use crate::frame::context::Context;
use crate::geometry::batch::{Ends, SIZE, get3};
use crate::num::Num;
use glam::{DVec2, Vec2, Vec3};

/// No cell is smaller [px]: between its rays is a pixel.
const LEAST: f32 = 2.0;

/// An edge of the fog no farther than this share before a ray's end is its end: where fog lies on a floor.
const ALIKE: f32 = 1e-4;

/// Where the ray is that a cell is checked by: cubics, which quadratics miss, vanish in its middle.
pub const CHECK: [f64; 2] = [0.58, 0.42];

/// A square of the picture with the samples in it.
pub struct Cell {
    /// Upper left corner [px].
    min: Vec2,
    side: f32,
    /// Its samples.
    pub members: Vec<Member>,
    /// The ray of its only sample, if that is tabulated itself.
    pub own: Option<usize>,
    /// The nearest and the farthest end of their rays [m].
    pub ends: [f32; 2],
}

impl Cell {
    fn new(min: Vec2, side: f32, members: Vec<Member>, samples: &Samples) -> Self {
        let mut ends = [f32::INFINITY, 0.0f32];
        for member in &members {
            let length = member.length(samples.block);
            ends = [ends[0].min(length), ends[1].max(length)];
        }
        Self { min, side, members, own: None, ends }
    }

    /// Its middle [px].
    pub fn middle(&self) -> Vec2 {
        self.min + 0.5 * self.side
    }

    /// Half its side [px].
    pub fn half(&self) -> f32 {
        0.5 * self.side
    }

    /// Whether it is as small as cells get.
    pub fn is_least(&self) -> bool {
        self.side <= LEAST
    }

    /// Where the ray passes that it is checked by [px].
    pub fn check(&self) -> Vec2 {
        self.middle() + self.half() * DVec2::from(CHECK).as_vec2()
    }

    /// Where the rays around it pass through the picture [px].
    pub fn rays(&self) -> [Vec2; CONTROL] {
        PLACES.map(|place| self.middle() + self.half() * Vec2::from(place))
    }

    /// Its quarters, as far as there are samples in them.
    pub fn quarters(self, samples: &Samples) -> Vec<Self> {
        let (middle, side) = (self.middle(), self.half());
        let mut parts: [Vec<Member>; 4] = Default::default();
        for member in self.members {
            let place = samples.places.get(member);
            parts[usize::from(place.x >= middle.x) + 2 * usize::from(place.y >= middle.y)]
                .push(member);
        }
        let corner = |i: usize| self.min + side * Vec2::new((i % 2) as f32, (i / 2) as f32);
        let parts = parts.into_iter().enumerate().filter(|(_, members)| !members.is_empty());
        parts.map(|(i, members)| Self::new(corner(i), side, members, samples)).collect()
    }

    /// Each of its samples as a cell of its own.
    pub fn alone(self, samples: &Samples) -> impl Iterator<Item = Self> {
        let cell = |member| Self::new(samples.places.get(member), 0.0, vec![member], samples);
        self.members.into_iter().map(cell)
    }

    /// Whether the lamps are near, one by one of what is scattered: their glow varies too much across it.
    pub fn near(&self, grid: &Grid, scattered: &Scattered) -> Vec<bool> {
        let nearest = grid.fineness.near;
        let near = |image: &Option<Vec2>| {
            image.is_some_and(|image| self.side * nearest > self.middle().distance(image))
        };
        scattered.images.iter().map(near).collect()
    }

    /// Whether some of its samples pass an edge of the fog that others do not, or that some of the rays
    /// around them do not.
    fn is_cut(&self, grid: &Grid, passed: &Passed) -> bool {
        let Some(first) = self.members.first().filter(|_| grid.has_edges) else { return false };
        let wanted = passed.by(*first);
        let mut edges = Vec::new();
        let mut around = |place: &Vec2| {
            let (start, direction) = grid.context.viewpoint.ray(place.as_dvec2());
            let ray = (start.as_vec3(), direction.as_vec3());
            count(grid, ray, passed.ends, &mut edges)
        };
        self.members.iter().any(|member| passed.by(*member) != wanted)
            || self.rays().iter().any(|place| around(place) < wanted)
    }

    /// Whether it is too large for what its rays may see: a lamp's image is near, lumps are so small that
    /// they may stand between the rays, or the rays spread too much.
    pub fn is_coarse(&self, grid: &Grid, scattered: &Scattered, block: &Block) -> bool {
        let Grid { context, fineness, .. } = grid;
        if self.is_cut(grid, &block.passed) {
            return true;
        }
        if self.side > fineness.glow && self.near(grid, scattered).contains(&true) {
            return true;
        }
        let cone = cone(context, self.middle(), &[Vec2::splat(self.half())], self.ends[1]);
        let lumps = block.fog.lumps(&cone);
        // In thin fog a lump stands out by what it adds.
        let hides = lumps.hidden_squared.sqrt() > fineness.hidden * lumps.depth.min(1.0);
        hides || cone.spread > fineness.wide
    }
}

/// How many edges of the fog the samples of a block pass.
pub struct Passed {
    /// Batch by batch; none where the fog has no edges.
    counts: Vec<[u8; SIZE]>,
    /// From where to where the block's rays meet fog [m].
    ends: [f32; 2],
}

impl Passed {
    /// By all samples of a block.
    pub fn new(grid: &Grid, samples: &Samples, ends: [f32; 2]) -> Self {
        let [from, to] = ends;
        let mut edges = Vec::new();
        let of_batch = |Ends { rays, hits }: &Ends| {
            let mut counts = [0; SIZE];
            for (at, own) in counts.iter_mut().enumerate().take(rays.count) {
                let end = (hits.length[at] * (1.0 - ALIKE)).min(to);
                let ray = (get3(&rays.offset, at), get3(&rays.direction, at));
                *own = count(grid, ray, [from, end], &mut edges) as u8;
            }
            counts
        };
        let counts = samples.block.iter().filter(|_| grid.has_edges).map(of_batch).collect();
        Self { counts, ends }
    }

    fn by(&self, member: Member) -> usize {
        self.counts[member.batch()][member.at()].into()
    }
}

/// How many edges of the fog a ray passes between two ray parameters; `edges` is room for them.
fn count(grid: &Grid, ray: (Vec3, Vec3), ends: [f32; 2], edges: &mut Vec<f32>) -> usize {
    between(&grid.haze, ray, ends, edges);
    edges.len()
}

/// How much the eight rays around a cell count at places of the square [−1, 1]²: those quadratics that are 1
/// at one ray and 0 at the others.
#[inline(always)]
pub fn weights<N: Num>(x: N, y: N) -> [N; CONTROL] {
    let (one, half, quarter) = (x.lit(1.0), x.lit(0.5), x.lit(0.25));
    let (left, right, upper, lower) = (one - x, one + x, one - y, one + y);
    let (across, down) = ((one - x.squared()) * half, (one - y.squared()) * half);
    [
        left * upper * (-x - y - one) * quarter,
        right * upper * (x - y - one) * quarter,
        left * lower * (y - x - one) * quarter,
        right * lower * (x + y - one) * quarter,
        across * upper,
        across * lower,
        down * left,
        down * right,
    ]
}

/// The largest cells of a block.
pub fn of_block(samples: &Samples, corner: Vec2, side: f32) -> Vec<Cell> {
    let across = (BLOCK as f32 / side) as usize;
    let mut squares = vec![Vec::new(); across * across];
    let square = |place: Vec2| {
        let [x, y] = ((place - corner) / side).to_array();
        let [x, y] = [x, y].map(|v| (v.max(0.0) as usize).min(across - 1));
        y * across + x
    };
    for (batch, ends) in samples.block.iter().enumerate() {
        let members = (0..ends.rays.count).map(|at| Member::new(batch, at));
        // A tile's pixels mostly lie in one of them.
        let [min, max] = samples.places.corners(batch, ends.rays.count);
        if square(min) == square(max) {
            squares[square(min)].extend(members);
        } else {
            members.for_each(|member| squares[square(samples.places.get(member))].push(member));
        }
    }
    let squares = squares.into_iter().enumerate().filter(|(_, members)| !members.is_empty());
    let min = |i: usize| corner + side * Vec2::new((i % across) as f32, (i / across) as f32);
    squares.map(|(i, members)| Cell::new(min(i), side, members, samples)).collect()
}

/// Where the lamps of what is scattered appear [px].
pub fn images(context: &Context, asked: &[usize]) -> Vec<Option<Vec2>> {
    let image = |i: &usize| {
        let lamp = &context.lamps[context.scatters[*i].lamp];
        lamp.image(&context.viewpoint).map(DVec2::as_vec2)
    };
    asked.iter().map(image).collect()
}
