//! One frame on the CPU, read top to bottom as a list of passes over tiles.

use super::composite::{self, Made};
use super::passes::{Depths, Fog, Fogging, Passes, Shading, Share, Tracing, is_low};
use super::tiles::tiles;
use super::traced::Traced;
use super::{fog, mapped, shade, upsample};
use crate::frame::cache::Cache;
use crate::frame::context::Context;
use crate::frame::lights::{fill_tables, light_sides};
use crate::frame::samples::CENTER;
use crate::frame::{Frame, Lap};
use crate::geometry::batch::{Ends, Fogged, Row};
use crate::kept::{Kept, Same};
use crate::progress::{Interrupted, Progress};
use crate::request::{Quality, View};
use crate::scene::CheckedScene;
use rayon::prelude::*;
use std::sync::Arc;
use std::time::Instant;

/// Tiles of the largest picture of which something is kept: 2 million pixels, 42 MB of first hits.
const KEPT_TILES: usize = 1 << 13;

/// Renders one layer.
pub fn render(
    cache: &Cache,
    passes: &Passes,
    scene: &CheckedScene,
    view: &View,
    progress: &Progress,
) -> Result<Frame, Interrupted> {
    let mut clock = Clock::start(progress);
    let geometry = cache.geometry(scene, progress)?;
    let field = cache.field(scene, progress)?;
    clock.lap("prepare", true)?;
    let mut context = Context::new(scene, &geometry, &field, view, progress);
    // What is kept of a large picture would push out all else.
    let fresh = (context.grid.count() > KEPT_TILES).then(Passes::default);
    let passes = fresh.as_ref().unwrap_or(passes);

    let tracing = Tracing {
        geometry: Same::new(&geometry),
        camera: scene.camera.clone(),
        grid: context.grid,
        far_m: scene.far_m,
        samples: view.samples.unwrap_or(1),
    };
    let mut traces = false;
    let trace = || {
        traces = true;
        Traced::new(&context)
    };
    let traced = passes.traced.get(&tracing, progress, trace)?;
    passes.forget_old_pictures();
    clock.lap("surfaces", traces)?;

    let fills = fill_tables(&mut context, cache)?;
    let mut shades = Lamps::shading(&context, passes, &traced);
    let mut fogs = Lamps::fogging(&context, passes, &traced);
    if fogs.is_wanting() {
        context.lit_blobs = light_sides(&context, cache)?;
    }
    clock.lap("light_depth", fills || !context.lit_blobs.is_empty())?;

    let draft = is_low(&context);
    let low = if draft && (shades.is_wanting() || fogs.is_wanting()) {
        let (lamps, shaded) = (&fogs.missing, &shades.missing);
        Some(upsample::Low::render(&context, lamps, shaded, &traced.tiles)?)
    } else {
        None
    };
    clock.lap_if(draft, "low_resolution", low.is_some())?;

    let runs = shades.is_wanting();
    shades.run(&passes.depths, |lamps| light_depths(&context, &traced, low.as_ref(), lamps))?;
    clock.lap("surface_radiance", runs)?;

    let runs = fogs.is_wanting();
    fogs.run(&passes.fog, |lamps| fog(&context, &traced, low.as_ref(), lamps))?;
    let has_edges = traced.samples.iter().any(|samples| !samples.is_empty());
    clock.lap(if has_edges { "airlight_and_edges" } else { "airlight" }, runs)?;

    let made =
        Made { context: &context, traced: &traced, fog: &fogs.shares, depths: &shades.shares };
    let pixels = composite::picture(&made);
    clock.lap("composite", true)?;

    let (width, height) = (context.grid.width, context.grid.height);
    let (layer, camera) = (view.layer, scene.camera.clone());
    let (timings, backend) = (clock.laps, "cpu");
    Ok(Frame { width, height, layer, camera, pixels, shown: None, timings, backend })
}

/// A pass lamp by lamp: what is kept of it, and which lamps it must be made for.
struct Lamps<K, T> {
    keys: Vec<K>,
    shares: Vec<Option<Arc<Share<T>>>>,
    missing: Vec<usize>,
    /// Whether there is more to it than lamps.
    is_alone: bool,
}

impl Lamps<Shading, Depths> {
    fn shading(context: &Context, passes: &Passes, traced: &Arc<Traced>) -> Self {
        let lamps = if context.shows_surfaces() { context.lamps.len() } else { 0 };
        let keys = (0..lamps).map(|i| Shading::new(context, traced, i)).collect();
        Self::find(keys, false, |key| passes.depths.find(key))
    }
}

impl Lamps<Fogging, Fog> {
    /// What takes light away stands for a lamp behind the last, where no lamp's own run tells it.
    fn fogging(context: &Context, passes: &Passes, traced: &Arc<Traced>) -> Self {
        let lamps = if context.is_lit() { context.lamps.len() } else { 0 };
        let mut keys: Vec<_> = (0..lamps).map(|i| Fogging::new(context, traced, Some(i))).collect();
        let is_alone = context.shows_fog() && !context.interpolates();
        keys.extend(is_alone.then(|| Fogging::new(context, traced, None)));
        // Who asks for an estimator by name measures it.
        let keeps = context.view.estimator.is_none();
        Self::find(keys, is_alone, |key| passes.fog.find(key).filter(|_| keeps))
    }
}

impl<K: PartialEq + Clone, T> Lamps<K, T> {
    fn find(keys: Vec<K>, is_alone: bool, find: impl Fn(&K) -> Option<Arc<Share<T>>>) -> Self {
        let shares: Vec<_> = keys.iter().map(find).collect();
        let lamps = keys.len() - usize::from(is_alone);
        let missing = (0..lamps).filter(|i| shares[*i].is_none()).collect();
        Self { keys, shares, missing, is_alone }
    }

    /// Whether anything must be made.
    fn is_wanting(&self) -> bool {
        self.shares.iter().any(Option::is_none)
    }

    /// Makes what is missing, all lamps in one run, and keeps it; `make` also tells its bytes a lamp.
    fn run(
        &mut self,
        kept: &Kept<K, Share<T>>,
        make: impl FnOnce(&[usize]) -> Result<(T, usize), Interrupted>,
    ) -> Result<(), Interrupted> {
        if !self.is_wanting() {
            return Ok(());
        }
        let (run, bytes) = make(&self.missing)?;
        let run = Arc::new(run);
        let alone =
            self.is_alone.then(|| self.keys.len() - 1).filter(|i| self.shares[*i].is_none());
        for (slot, i) in self.missing.iter().copied().chain(alone).enumerate() {
            let share = Share::new(&run, slot, bytes);
            self.shares[i] = Some(kept.put(self.keys[i].clone(), share));
        }
        Ok(())
    }
}

/// Depths from some lamps to all that is seen.
fn light_depths(
    context: &Context,
    traced: &Traced,
    low: Option<&upsample::Low>,
    lamps: &[usize],
) -> Result<(Depths, usize), Interrupted> {
    let depths = tiles(context, context.grid.count(), &Vec::new(), |index| {
        let rays = context.viewpoint.tile(context.grid.tile(index), CENTER);
        let of_batch = |(at, ends): (usize, Ends)| match low {
            Some(low) if at == 0 => low.light_depths(context, lamps, index, ends),
            _ => {
                let Ends { rays, hits } = ends;
                let depth = |i: &usize| shade::light_depth(context, &context.lamps[*i], rays, hits);
                lamps.iter().map(depth).collect::<Vec<_>>()
            }
        };
        traced.batches(index, &rays).enumerate().map(of_batch).collect::<Vec<_>>()
    })?;
    let batches: usize = depths.iter().map(Vec::len).sum();
    Ok((depths, batches * size_of::<Row>()))
}

/// Tiles whose fog is formed together: what is interpolated across the picture serves them all.
fn blocks(context: &Context) -> Vec<Vec<usize>> {
    // What a draft interpolates reaches farther.
    let across = if context.view.quality == Quality::Draft { 4 } else { 2 };
    context.grid.blocks(across)
}

/// The fog along all rays, with the light of some lamps.
fn fog(
    context: &Context,
    traced: &Traced,
    low: Option<&upsample::Low>,
    lamps: &[usize],
) -> Result<(Fog, usize), Interrupted> {
    context.job.progress.start(context.grid.count(), 1.0);
    // One by one, because some take ten times as long as others.
    let blocks = blocks(context);
    let made = blocks.par_iter().with_max_len(1);
    let made: Vec<_> = made.map(|block| fog_of(context, traced, low, lamps, block)).collect();
    context.job.progress.check()?;
    let mut by_tile: Fog = Vec::new();
    by_tile.resize_with(context.grid.count(), Vec::new);
    for (index, fogged) in blocks.into_iter().flatten().zip(made.into_iter().flatten()) {
        by_tile[index] = fogged;
    }
    let batches: usize = by_tile.iter().map(Vec::len).sum();
    // A row a lamp, and that of what is taken away.
    Ok((by_tile, batches * size_of::<Row>() * (lamps.len() + 1) / lamps.len().max(1)))
}

/// The same of some tiles.
fn fog_of(
    context: &Context,
    traced: &Traced,
    low: Option<&upsample::Low>,
    lamps: &[usize],
    block: &[usize],
) -> Vec<Vec<Fogged>> {
    if context.job.progress.is_over() {
        return Vec::new();
    }
    let rays = |index: &usize| context.viewpoint.tile(context.grid.tile(*index), CENTER);
    let rays: Vec<_> = block.iter().map(rays).collect();
    let mut batches = Vec::new();
    let mut counts = Vec::with_capacity(block.len());
    for (index, rays) in block.iter().zip(&rays) {
        let before = batches.len();
        batches.extend(traced.batches(*index, rays));
        counts.push(batches.len() - before);
    }
    let mut fogged = Vec::with_capacity(batches.len());
    let mut rest = batches.as_slice();
    for (index, count) in block.iter().zip(&counts) {
        let (own, others) = rest.split_at(*count);
        rest = others;
        for (at, ends) in own.iter().enumerate() {
            fogged.push(match low {
                Some(low) if at == 0 => low.fog(context, lamps, *index, *ends),
                _ => fog::batch(context, lamps, ends.rays, ends.hits),
            });
        }
        if !context.is_mapped() {
            context.job.progress.advance();
        }
    }
    if context.is_mapped() {
        mapped::add(context, lamps, &batches, &mut fogged);
        block.iter().for_each(|_| context.job.progress.advance());
    }
    let mut fogged = fogged.into_iter();
    counts.into_iter().map(|count| fogged.by_ref().take(count).collect()).collect()
}

/// Times passes, and stops between them.
struct Clock<'a> {
    progress: &'a Progress,
    since: Instant,
    laps: Vec<Lap>,
}

impl<'a> Clock<'a> {
    fn start(progress: &'a Progress) -> Self {
        Self { progress, since: Instant::now(), laps: Vec::new() }
    }

    /// A pass has ended; it ran, or its output was kept.
    fn lap(&mut self, pass: &'static str, ran: bool) -> Result<(), Interrupted> {
        self.lap_if(true, pass, ran)
    }

    fn lap_if(&mut self, counts: bool, pass: &'static str, ran: bool) -> Result<(), Interrupted> {
        if counts {
            self.laps.push(Lap { pass, took: self.since.elapsed(), is_reused: !ran });
        }
        self.since = Instant::now();
        self.progress.check()
    }
}
