//! One frame on the CPU, read top to bottom as a list of passes over tiles.

use super::edges::{self, Samples};
use super::tiles::tiles;
use super::trace::{self, Order};
use super::{composite, fog, mapped, shade, upsample};
use crate::frame::Frame;
use crate::frame::cache::Cache;
use crate::frame::context::Context;
use crate::frame::lights::{fill_tables, light_sides};
use crate::frame::samples::CENTER;
use crate::geometry::batch::{Ends, Fogged, Hits, Rows, SIZE, TILE};
use crate::progress::{Interrupted, Progress};
use crate::request::{Quality, View};
use crate::scene::CheckedScene;
use rayon::prelude::*;
use std::time::{Duration, Instant};

/// Renders one layer.
pub fn render(
    cache: &Cache,
    scene: &CheckedScene,
    view: &View,
    progress: &Progress,
) -> Result<Frame, Interrupted> {
    let mut clock = Clock::start(progress);
    let geometry = cache.geometry(scene, progress)?;
    let field = cache.field(scene, progress)?;
    clock.lap("prepare")?;
    let mut context = Context::new(scene, &geometry, &field, view, progress);

    let trace = || first_hits(&context);
    let hits = cache.first_hits(scene, &geometry, context.grid, progress, trace)?;
    clock.lap("surfaces")?;

    context.lit_blobs = light_sides(&context, cache)?;
    fill_tables(&mut context, cache)?;
    clock.lap("light_depth")?;

    let draft = view.quality == Quality::Draft && context.needs_low_resolution();
    let low = draft.then(|| upsample::Low::render(&context, &hits)).transpose()?;
    let low = low.as_ref();
    clock.lap_if(draft, "low_resolution")?;

    let surface = surfaces(&context, &hits, low)?;
    clock.lap("surface_radiance")?;

    let blocks = blocks(&context);
    let fog = fog(&context, &hits, low, &blocks);
    let has_edges = fog.iter().any(|block| !block.edges.is_empty());
    clock.lap(if has_edges { "airlight_and_edges" } else { "airlight" })?;

    let along_views = by_tile(&context, &blocks, &fog);
    let mut pixels = composite::picture(&context, &hits, &surface, &along_views);
    for (index, edges) in fog.iter().flat_map(|block| &block.edges) {
        edges::place(&context, *index, edges, &mut pixels);
    }
    clock.lap("composite")?;

    let (width, height) = (context.grid.width, context.grid.height);
    let (layer, camera) = (view.layer, scene.camera.clone());
    let (timings, backend) = (clock.laps, "cpu");
    Ok(Frame { width, height, layer, camera, pixels, shown: None, timings, backend })
}

fn first_hits(context: &Context) -> Result<Vec<Hits>, Interrupted> {
    let starts = std::array::from_fn(|row| row * TILE);
    let order = Order { starts, is_dense: true, shifts: [CENTER; 2] };
    let nothing = Hits::nothing(context.far_m);
    tiles(context, context.grid.count(), &nothing, |index| {
        let rays = context.viewpoint.tile(context.grid.tile(index), CENTER);
        trace::tile(context, index, &[rays], &order).pop().unwrap_or_else(|| nothing.clone())
    })
}

fn surfaces(
    context: &Context,
    hits: &[Hits],
    low: Option<&upsample::Low>,
) -> Result<Vec<Rows>, Interrupted> {
    if !context.shows_surfaces() {
        return Ok(Vec::new());
    }
    tiles(context, context.grid.count(), &[[0.0; SIZE]; 3], |index| {
        let rays = context.viewpoint.tile(context.grid.tile(index), CENTER);
        match low {
            Some(low) => {
                let depths = low.light_depths(context, index, &rays, &hits[index]);
                shade::surface_radiance(context, &rays, &hits[index], &depths)
            }
            None => shade::batch(context, &rays, &hits[index]),
        }
    })
}

/// What fog does to a block of tiles.
struct Fog {
    /// Tile by tile, if the layer shows it.
    along_views: Vec<Fogged>,
    /// The edge pixels of some tiles, by the tile's place.
    edges: Vec<(usize, edges::Resolved)>,
}

/// Tiles whose fog is formed together: what is interpolated across the picture serves them all.
fn blocks(context: &Context) -> Vec<Vec<usize>> {
    // What a draft interpolates reaches farther.
    let across = if context.view.quality == Quality::Draft { 4 } else { 2 };
    context.grid.blocks(across)
}

/// The fog of each block, for its pixels and the samples of its edges.
fn fog(
    context: &Context,
    hits: &[Hits],
    low: Option<&upsample::Low>,
    blocks: &[Vec<usize>],
) -> Vec<Fog> {
    let edges = context.view.samples.is_some_and(|samples| samples > 1);
    if !context.shows_fog() && !edges {
        return Vec::new();
    }
    let tiles = if context.shows_fog() { context.grid.count() } else { 0 };
    context.job.progress.start(tiles, 1.0);
    // One by one, because some take ten times as long as others.
    blocks.par_iter().with_max_len(1).map(|block| fog_of(context, hits, low, block)).collect()
}

/// The fog of each tile; of none if the layer shows no fog.
fn by_tile<'a>(context: &Context, blocks: &[Vec<usize>], fog: &'a [Fog]) -> Vec<&'a Fogged> {
    let tiles = blocks.iter().zip(fog).flat_map(|(block, fog)| block.iter().zip(&fog.along_views));
    let mut tiles: Vec<_> = tiles.collect();
    tiles.sort_unstable_by_key(|(index, _)| **index);
    debug_assert!(tiles.is_empty() || tiles.len() == context.grid.count());
    tiles.into_iter().map(|(_, fogged)| fogged).collect()
}

fn fog_of(context: &Context, hits: &[Hits], low: Option<&upsample::Low>, block: &[usize]) -> Fog {
    if context.job.progress.is_over() {
        return Fog { along_views: Vec::new(), edges: Vec::new() };
    }
    let rays = |index: &usize| context.viewpoint.tile(context.grid.tile(*index), CENTER);
    let rays: Vec<_> = block.iter().map(rays).collect();
    let samples: Vec<_> = block.iter().map(|index| Samples::new(context, hits, *index)).collect();
    // Tiles first, then the samples.
    let tiles = if context.shows_fog() { block.len() } else { 0 };
    let ends = |(index, rays): (&usize, _)| Ends { rays, hits: &hits[*index] };
    let mut ends: Vec<_> = block.iter().zip(&rays).take(tiles).map(ends).collect();
    ends.extend(samples.iter().flat_map(Samples::ends));
    let fog = |(at, Ends { rays, hits }): (usize, &Ends)| {
        let fogged = match low {
            Some(low) if at < tiles => low.fog(context, block[at], rays, hits),
            _ => fog::batch(context, rays, hits),
        };
        if at < tiles && !context.is_mapped() {
            context.job.progress.advance();
        }
        fogged
    };
    let mut along_views: Vec<_> = ends.iter().enumerate().map(fog).collect();
    if context.is_mapped() {
        mapped::add(context, &ends, &mut along_views);
        (0..tiles).for_each(|_| context.job.progress.advance());
    }
    let along_samples = along_views.split_off(tiles);
    let mut rest = along_samples.as_slice();
    let mut edges = Vec::new();
    for (index, samples) in block.iter().zip(&samples) {
        let (own, others) = rest.split_at(samples.ends().count());
        rest = others;
        if !own.is_empty() {
            edges.push((*index, samples.resolve(context, own)));
        }
    }
    Fog { along_views, edges }
}

/// Times passes, and stops between them.
struct Clock<'a> {
    progress: &'a Progress,
    since: Instant,
    laps: Vec<(&'static str, Duration)>,
}

impl<'a> Clock<'a> {
    fn start(progress: &'a Progress) -> Self {
        Self { progress, since: Instant::now(), laps: Vec::new() }
    }

    fn lap(&mut self, name: &'static str) -> Result<(), Interrupted> {
        self.lap_if(true, name)
    }

    fn lap_if(&mut self, ran: bool, name: &'static str) -> Result<(), Interrupted> {
        if ran {
            self.laps.push((name, self.since.elapsed()));
        }
        self.since = Instant::now();
        self.progress.check()
    }
}
