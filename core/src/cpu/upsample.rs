//! The low resolution of a draft, or of a picture that asks for one (Fogshop 5.4; Biri 2002, section 4.1): fog is computed
//! for one pixel in 16, or as many as are asked for, exactly as in a full frame, and its values are carried over to the pixels between that lie at a like depth.
//! Where no computed neighbour does, along depth edges, the pixel is computed itself: no halo of
//! background fog stands over a foreground edge. So are the pixels around a lamp's image, where
//! airlight has a peak, and in a picture at rest those whose lenders differ.

use super::tiles::tiles;
use super::{fog, shade};
use crate::frame::context::Context;
use crate::frame::samples::CENTER;
use crate::frame::viewpoint::Grid;
use crate::geometry::batch::{Ends, Fogged, Hits, Rays, Row, SIZE, TILE};
use crate::progress::Interrupted;
use crate::request::Quality;

/// A pixel of a picture at rest is computed itself where what fog lets through differs by more among those that
/// would lend it theirs: the most that it is off by where fog rises or falls from one to the next.
const ALIKE: f32 = 0.1;
/// Depths that differ by more than this share do not lend each other their fog.
const LIKE: f32 = 0.1;
/// Below this sum of weights a pixel has no neighbour to borrow from.
const ENOUGH: f32 = 0.25;
/// Pixels around a lamp's image that are computed themselves.
const GLOW: f64 = 12.0;
/// Of a draft's work, for its progress; how many pixels are computed themselves turns out later.
const SHARE: f64 = 0.5;

/// The computed pixels.
pub struct Low {
    /// Pixels from one of them to the next: a power of two up to the side of a tile.
    step: usize,
    grid: Grid,
    hits: Vec<Hits>,
    fogged: Vec<Fogged>,
    /// Of the lamps that are asked for, tile by tile.
    light_depths: Vec<Vec<Row>>,
    glows: Vec<(f64, f64)>,
}

/// The computed pixels around a tile.
struct Around {
    step: usize,
    /// Tile of the low resolution and place in it.
    at: Vec<(usize, usize)>,
    /// Length of the ray, negative where it meets nothing.
    length: Vec<f32>,
}

/// Computed pixels along the side of what a tile may borrow from.
fn reach(step: usize) -> usize {
    TILE / step + 2
}

/// Four places in [`Around`] with their weights, which add up to 1.
type Sources = [(usize, f32); 4];

impl Low {
    /// Computes one pixel of a square: the airlight of some lamps, and what lies between others and the surfaces.
    ///
    /// # Errors
    /// [`Interrupted`] when the job's progress says so.
    pub fn render(
        context: &Context,
        asked: &[usize],
        shaded: &[usize],
        hits: &[Box<Hits>],
    ) -> Result<Self, Interrupted> {
        let (full, step) = (context.grid, context.step());
        let grid = Grid { width: full.width.div_ceil(step), height: full.height.div_ceil(step) };
        context.job.progress.start(grid.count(), SHARE);
        let blank = (Hits::nothing(context.far_m), Fogged::clear(0), Vec::new());
        let tiles = tiles(context, 0..grid.count(), &blank, |index| {
            let (rays, hits) = gather(context, hits, grid, index);
            let fogged = fog::batch(context, asked, &rays, &hits);
            let depth = |i: &usize| shade::light_depth(context, &context.lamps[*i], &rays, &hits);
            let depths = shaded.iter().map(depth).collect();
            context.job.progress.advance();
            (hits, fogged, depths)
        });
        let images = context.lamps.iter().filter_map(|lamp| lamp.image(&context.viewpoint));
        let glows = images.map(|at| (at.x, at.y)).collect();
        let mut low =
            Self { step, grid, hits: vec![], fogged: vec![], light_depths: vec![], glows };
        for (hits, fogged, depths) in tiles? {
            low.hits.push(hits);
            low.fogged.push(fogged);
            low.light_depths.push(depths);
        }
        Ok(low)
    }

    /// Optical depth of a tile, and airlight of some lamps.
    pub fn fog(
        &self,
        context: &Context,
        asked: &[usize],
        index: usize,
        Ends { rays, hits }: Ends<'_>,
    ) -> Fogged {
        let around = self.around(context, index);
        let mut fogged = Fogged::clear(asked.len());
        let missing = self.carry(context, index, &around, hits, true, |at, sources| {
            for (source, weight) in sources {
                let (tile, place) = around.at[source];
                let from = &self.fogged[tile];
                fogged.depth[at] += weight * from.depth[place];
                for (row, from) in fogged.airlight.iter_mut().zip(&from.airlight) {
                    row[at] += weight * from[place];
                }
            }
        });
        let Some((rays, hits)) = subset(context, rays, hits, &missing) else { return fogged };
        let exact = fog::batch(context, asked, &rays, &hits);
        for (from, at) in missing.into_iter().enumerate() {
            fogged.depth[at] = exact.depth[from];
            for (row, exact) in fogged.airlight.iter_mut().zip(&exact.airlight) {
                row[at] = exact[from];
            }
        }
        fogged
    }

    /// Depth from some lights to the hits of a tile.
    pub fn light_depths(
        &self,
        context: &Context,
        shaded: &[usize],
        index: usize,
        Ends { rays, hits }: Ends<'_>,
    ) -> Vec<Row> {
        if context.field.lumps() == 0 {
            // A product with the distance is cheaper than any neighbour.
            let exact = |i: &usize| shade::light_depth(context, &context.lamps[*i], rays, hits);
            return shaded.iter().map(exact).collect();
        }
        let around = self.around(context, index);
        let mut depths = vec![[0.0; SIZE]; shaded.len()];
        let missing = self.carry(context, index, &around, hits, false, |at, sources| {
            for (source, weight) in sources {
                let (tile, place) = around.at[source];
                for (depth, from) in depths.iter_mut().zip(&self.light_depths[tile]) {
                    depth[at] += weight * from[place];
                }
            }
        });
        let Some((rays, hits)) = subset(context, rays, hits, &missing) else { return depths };
        for (depth, i) in depths.iter_mut().zip(shaded) {
            let exact = shade::light_depth(context, &context.lamps[*i], &rays, &hits);
            missing.iter().enumerate().for_each(|(from, at)| depth[*at] = exact[from]);
        }
        depths
    }

    /// The computed pixels around a tile, those at the picture's border repeated beyond it.
    fn around(&self, context: &Context, index: usize) -> Around {
        let tile = context.grid.tile(index);
        let (step, reach) = (self.step, reach(self.step));
        let clamp = |v: usize, count: usize| v.saturating_sub(1).min(count - 1);
        let place = |i: usize| {
            let x = clamp(tile.x / step + i % reach, self.grid.width);
            let y = clamp(tile.y / step + i / reach, self.grid.height);
            self.grid.locate(x, y)
        };
        let at: Vec<_> = (0..reach * reach).map(place).collect();
        let length = at.iter().map(|(tile, place)| signed_length(&self.hits[*tile], *place));
        Around { step, length: length.collect(), at }
    }

    /// Calls `carry` with the sources of every pixel of a tile that has any; returns the others. View rays have glows
    /// of lamps, and at rest are not lent what differs.
    fn carry(
        &self,
        context: &Context,
        index: usize,
        around: &Around,
        hits: &Hits,
        of_eyes: bool,
        mut carry: impl FnMut(usize, Sources),
    ) -> Vec<usize> {
        let tile = context.grid.tile(index);
        let glows = of_eyes && self.glow_near(tile.x, tile.y);
        let lends_all = !of_eyes || context.view.quality == Quality::Draft;
        let mut missing = Vec::new();
        for at in 0..SIZE {
            let (x, y) = tile.pixel(at);
            let sources = around.sources(at, signed_length(hits, at));
            let sources = sources.filter(|sources| lends_all || self.are_alike(around, sources));
            match sources {
                Some(sources) if !(glows && self.in_a_glow(x, y, GLOW)) => carry(at, sources),
                _ if context.grid.contains((x, y)) => missing.push(at),
                _ => {}
            }
        }
        missing
    }

    /// Whether fog lets as much through at pixels that lend theirs.
    fn are_alike(&self, around: &Around, sources: &Sources) -> bool {
        let through = |(source, _): &(usize, f32)| {
            let (tile, place) = around.at[*source];
            (-self.fogged[tile].depth[place]).exp()
        };
        let counted = sources.iter().filter(|(_, weight)| *weight > 0.0).map(through);
        let [least, most] = counted.fold([1.0f32, 0.0f32], |[a, b], v| [a.min(v), b.max(v)]);
        most - least < ALIKE
    }

    fn glow_near(&self, x: usize, y: usize) -> bool {
        self.in_a_glow(x + TILE / 2, y + TILE / 2, GLOW + TILE as f64)
    }

    fn in_a_glow(&self, x: usize, y: usize, radius: f64) -> bool {
        let (x, y) = (x as f64 + 0.5, y as f64 + 0.5);
        self.glows.iter().any(|glow| (glow.0 - x).hypot(glow.1 - y) < radius)
    }
}

/// The length of a ray, negative where it meets nothing.
fn signed_length(hits: &Hits, at: usize) -> f32 {
    if hits.sees_nothing(at) { -hits.length[at] } else { hits.length[at] }
}

impl Around {
    /// The four computed pixels around one, weighed by nearness and by likeness of depth.
    fn sources(&self, at: usize, length: f32) -> Option<Sources> {
        let (step, reach) = (self.step, reach(self.step));
        let between = |v: usize| {
            // The pixel in the middle of a cell is computed; one cell stands before the tile.
            let place = v + step - step / 2;
            (place / step, (place % step) as f32 / step as f32)
        };
        let (left, fx) = between(at % TILE);
        let (top, fy) = between(at / TILE);
        let first = top * reach + left;
        let scale = 1.0 / (LIKE * length.abs()).max(f32::MIN_POSITIVE);
        let mut sum = 0.0;
        let sources = [
            (first, (1.0 - fx) * (1.0 - fy)),
            (first + 1, fx * (1.0 - fy)),
            (first + reach, (1.0 - fx) * fy),
            (first + reach + 1, fx * fy),
        ]
        .map(|(source, near)| {
            let weight = near * (1.0 - (self.length[source] - length).abs() * scale).max(0.0);
            sum += weight;
            (source, weight)
        });
        (sum >= ENOUGH).then(|| sources.map(|(source, weight)| (source, weight / sum)))
    }
}

/// The pixels of the picture that a tile of the low resolution computes.
fn gather(context: &Context, hits: &[Box<Hits>], grid: Grid, index: usize) -> (Rays, Hits) {
    let tile = grid.tile(index);
    let mut rays = Rays::empty();
    let mut low = Hits::nothing(context.far_m);
    let step = context.step();
    for at in 0..SIZE {
        let (i, j) = (tile.x + at % TILE, tile.y + at / TILE);
        let x = (i * step + step / 2).min(context.grid.width - 1);
        let y = (j * step + step / 2).min(context.grid.height - 1);
        let (from, place) = context.grid.locate(x, y);
        low.copy(at, &hits[from], place);
        let pixel = glam::DVec2::new(x as f64, y as f64) + CENTER;
        rays.push_ray(context.viewpoint.ray(pixel));
    }
    (rays, low)
}

/// Some rays of a tile as a batch of their own.
pub fn subset(
    context: &Context,
    rays: &Rays,
    hits: &Hits,
    places: &[usize],
) -> Option<(Rays, Hits)> {
    let last = places.len().checked_sub(1)?;
    let mut some = Rays::empty();
    let mut ends = Hits::nothing(context.far_m);
    for place in places {
        ends.copy(some.count, hits, *place);
        some.push(rays, *place);
    }
    some.pad();
    ends.pad(last);
    Some((some, ends))
}
