//! One frame on the CPU, read top to bottom as a list of passes over tiles.

use super::composite::{self, Made};
use super::corners::AtCorners;
use super::grid::{self, Grid};
use super::noise::bend;
use super::passes::{Depths, Fog, Fogging, Passes, Shading, Share, Tracing};
use super::rims::Seen;
use super::tiles::{Strip, by_blocks, tiles};
use super::traced::Traced;
use super::{fog, mapped, rims, shade, shadow, upsample};
use crate::frame::cache::Cache;
use crate::frame::context::Context;
use crate::frame::lights::{cast, fill_skies, fill_tables, light_sides};
use crate::frame::samples::CENTER;
use crate::frame::{Frame, Lap};
use crate::geometry::batch::{Ends, Fogged, Row, TILE};
use crate::kept::{Kept, Same};
use crate::progress::{Interrupted, Progress};
use crate::request::View;
use crate::scene::{CheckedScene, Octave};
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
    let bands = view.octaves(&scene.fog).into_iter().map(|octave| {
        let bands = cache.seen_bands(scene, octave, view, progress)?;
        Ok((octave, bands))
    });
    let octaves = bands.collect::<Result<Vec<_>, Interrupted>>()?;
    clock.lap("prepare", true)?;
    let bands = octaves[0].1.each().len();
    let context = |(octave, band): (usize, usize)| {
        let (octave, bands) = &octaves[octave];
        let channel = (bands.each().len() > 1).then_some(band);
        let field = (&bands.each()[band], *octave, channel);
        Context::new(scene, &geometry, field, view, progress)
    };
    // Band by band, the octaves of each behind it.
    let all = (0..bands).flat_map(|band| (0..octaves.len()).map(move |octave| (octave, band)));
    let mut contexts: Vec<_> = all.map(context).collect();
    let grid = contexts[0].grid;

    let tracing = Tracing {
        geometry: Same::new(&geometry),
        camera: scene.camera.clone(),
        grid,
        far_m: scene.far_m,
        samples: view.samples.unwrap_or(1),
        tells_triangles: contexts[0].is_per_vertex(),
    };
    let mut traces = false;
    let trace = || {
        traces = true;
        Traced::new(&contexts[0])
    };
    // What is kept of a large picture would push out all else.
    let fresh = Passes::default();
    let kept = if grid.count() > KEPT_TILES { &fresh } else { passes };
    let traced = kept.traced.get(&tracing, progress, trace)?;
    passes.forget_old_pictures();
    clock.lap("surfaces", traces)?;

    let mut fills = false;
    for context in &mut contexts {
        fills |= fill_tables(context, cache)?;
    }
    clock.lap("light_depth", fills)?;
    if contexts.iter().any(|context| !context.skies.is_empty()) {
        let (mut fills, count) = (false, contexts.len());
        for context in &mut contexts {
            fills |= fill_skies(context, cache, count)?;
        }
        clock.lap("sky", fills)?;
    }
    // All bands and octaves see the same shadows.
    let casts = cast(&mut contexts[0], cache)?;
    let shafts: Vec<_> = contexts[0].lamps.iter().map(|lamp| lamp.shafts.clone()).collect();
    for context in &mut contexts {
        let lamps = context.lamps.iter_mut().zip(&shafts);
        lamps.for_each(|(lamp, shafts)| lamp.shafts.clone_from(shafts));
    }
    if contexts.iter().flat_map(|context| &context.lamps).any(|lamp| lamp.shafts.is_some()) {
        clock.lap("shadows", casts)?;
    }

    let channels = view.layer.channels(bands);
    let pixels = strips(&mut contexts, cache, kept, &traced, channels, &mut clock)?;

    let (layer, camera, backend) = (view.layer, scene.camera.clone(), "cpu");
    let (width, height, timings) = (grid.width, grid.height, clock.laps);
    Ok(Frame { width, height, channels, layer, camera, pixels, shown: None, timings, backend })
}

/// The picture, strip by strip, in all bands. Nothing is kept of several strips.
fn strips(
    contexts: &mut [Context],
    cache: &Cache,
    passes: &Passes,
    traced: &Arc<Traced>,
    channels: usize,
    clock: &mut Clock,
) -> Result<Vec<f32>, Interrupted> {
    let (grid, progress) = (contexts[0].grid, clock.progress);
    let rows = |context: &Context| context.lamps.len() + context.scatters.len() + 1;
    let strips = Strip::all(grid, contexts.iter().map(rows).sum());
    let parts = contexts.len() * strips.len();
    let [begin, end] = progress.frame();
    let at = |part: usize| begin + (end - begin) * part as f64 / parts as f64;
    let mut done = 0;
    let mut lit: Vec<_> = contexts.iter_mut().map(Lit::new).collect();
    let mut pictures = Vec::with_capacity(strips.len());
    for strip in &strips {
        let fresh = Passes::default();
        let passes = if strips.len() > 1 { &fresh } else { passes };
        let mut light = Vec::with_capacity(lit.len());
        for lit in &mut lit {
            progress.stretch(at(done), at(done + 1));
            light.push(lit.light((cache, passes), (traced, strip), clock)?);
            done += 1;
        }
        let bands = lit.iter().zip(&light).map(|(lit, (fogs, shades))| composite::Band {
            context: lit.context,
            fog: &fogs.shares,
            depths: &shades.shares,
            octaves: Vec::new(),
        });
        let made = Made { traced, strip, bands: with_octaves(bands) };
        pictures.push(composite::picture(&made, channels));
        clock.lap("composite", true)?;
    }
    // Most pictures are one strip.
    Ok(if pictures.len() > 1 { pictures.concat() } else { pictures.pop().unwrap_or_default() })
}

/// The bands, each with the octaves that come behind it.
fn with_octaves<'a>(all: impl Iterator<Item = composite::Band<'a>>) -> Vec<composite::Band<'a>> {
    let mut bands: Vec<composite::Band> = Vec::new();
    for own in all {
        match bands.last_mut().filter(|_| own.context.octave != Octave::FIRST) {
            Some(band) => band.octaves.push(own),
            None => bands.push(own),
        }
    }
    bands
}

/// What fog and surfaces make of the light of all lamps.
type Light = (Lamps<Fogging, Fog>, Lamps<Shading, Depths>);

/// A band of colour, with what serves all of its strips.
struct Lit<'a, 'c> {
    context: &'a mut Context<'c>,
    low: Option<upsample::Low>,
}

impl<'a, 'c> Lit<'a, 'c> {
    fn new(context: &'a mut Context<'c>) -> Self {
        Self { context, low: None }
    }

    /// What fog and surfaces make of the light in a strip.
    fn light(
        &mut self,
        (cache, passes): (&Cache, &Passes),
        (traced, strip): (&Arc<Traced>, &Strip),
        clock: &mut Clock,
    ) -> Result<Light, Interrupted> {
        let mut shades = Lamps::shading(self.context, passes, traced);
        let mut fogs = Lamps::fogging(self.context, passes, traced);
        if fogs.is_wanting() && self.context.lit_blobs.is_empty() {
            self.context.lit_blobs = light_sides(self.context, cache)?;
            clock.lap("light_depth", !self.context.lit_blobs.is_empty())?;
        }
        let draft = self.context.is_low();
        let renders = draft && self.low.is_none() && (shades.is_wanting() || fogs.is_wanting());
        if renders {
            let (asked, shaded) = (&fogs.missing, &shades.missing);
            self.low = Some(upsample::Low::render(self.context, asked, shaded, &traced.tiles)?);
        }
        clock.lap_if(draft, "low_resolution", renders)?;

        let Self { context, low } = &*self;
        let (runs, low) = (shades.is_wanting(), low.as_ref());
        shades.run(&passes.depths, |lamps| light_depths(context, traced, strip, low, lamps))?;
        clock.lap("surface_radiance", runs)?;

        let runs = fogs.is_wanting();
        fogs.run(&passes.fog, |asked| fog(context, traced, strip, low, asked))?;
        let has_edges = traced.samples.iter().any(|samples| !samples.is_empty());
        clock.lap(if has_edges { "airlight_and_edges" } else { "airlight" }, runs)?;
        Ok((fogs, shades))
    }
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
        let lamps = if context.shows_surfaces() { context.direct().len() } else { 0 };
        let keys = (0..lamps).map(|i| Shading::new(context, traced, i)).collect();
        Self::find(keys, false, |key| passes.depths.find(key))
    }
}

impl Lamps<Fogging, Fog> {
    /// What takes light away stands for a lamp behind the last, where no lamp's own run tells it.
    fn fogging(context: &Context, passes: &Passes, traced: &Arc<Traced>) -> Self {
        let scatters = if context.is_lit() { context.scatters.len() } else { 0 };
        let keys = (0..scatters).map(|i| Fogging::new(context, traced, Some(i)));
        let mut keys: Vec<_> = keys.collect();
        let is_alone = context.shows_fog() && !context.interpolates();
        keys.extend(is_alone.then(|| Fogging::new(context, traced, None)));
        // Who asks for an estimator by name measures it.
        let keeps = context.view.estimator.is_none();
        let mut lamps = Self::find(keys, is_alone, |key| passes.fog.find(key).filter(|_| keeps));
        if context.has_grid() && lamps.is_wanting() {
            // They share a grid.
            lamps.missing = (0..scatters).collect();
        }
        lamps
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
    strip: &Strip,
    low: Option<&upsample::Low>,
    lamps: &[usize],
) -> Result<(Depths, usize), Interrupted> {
    let made = tiles(context, strip.tiles.clone(), &Default::default(), |index| {
        let rays = context.viewpoint.tile(context.grid.tile(index), CENTER);
        let mut seen = Vec::new();
        let of_batch = |(at, ends): (usize, Ends)| {
            let Ends { rays, hits } = ends;
            let mut depths = match low {
                Some(low) if at == 0 => low.light_depths(context, lamps, index, ends),
                _ => {
                    let depth =
                        |i: &usize| shade::light_depth(context, &context.lamps[*i], rays, hits);
                    lamps.iter().map(depth).collect::<Vec<_>>()
                }
            };
            let lit = |i: &usize| shadow::lit(context, &context.lamps[*i], (rays, hits));
            let lit: Vec<_> = lamps.iter().map(lit).collect();
            if context.softens() && at == 0 {
                seen = lit;
            } else {
                let shaded = lit.iter().zip(&mut depths);
                shaded.for_each(|(lit, depth)| lit.iter().for_each(|lit| shadow::add(lit, depth)));
            }
            depths
        };
        let depths: Vec<_> = traced.batches(index, &rays).enumerate().map(of_batch).collect();
        (depths, seen)
    })?;
    let (mut depths, seen): (Depths, Seen) = made.into_iter().unzip();
    if seen.iter().flatten().any(Option::is_some) {
        rims::add(context, (traced, strip), lamps, &seen, &mut depths)?;
    }
    let batches: usize = depths.iter().map(Vec::len).sum();
    Ok((depths, batches * size_of::<Row>()))
}

/// The fog along all rays, with what is scattered of some lamps.
fn fog(
    context: &Context,
    traced: &Traced,
    strip: &Strip,
    low: Option<&upsample::Low>,
    asked: &[usize],
) -> Result<(Fog, usize), Interrupted> {
    context.job.progress.start(strip.tiles.len(), 1.0);
    // What is interpolated across the picture serves all tiles of a block; patches of numbers are smaller.
    let across = if context.has_grid() { grid::BLOCK / TILE } else { 2 };
    let grid = context.has_grid().then(|| Grid::new(context, asked));
    let corners = context.is_per_vertex().then(|| AtCorners::new(context, traced, strip));
    let corners = corners.transpose()?;
    let formed = Formed { context, traced, low, grid, corners, asked };
    let by_tile: Fog =
        by_blocks(context, strip.tiles.clone(), across, |block| formed.fog_of(block))?;
    let batches: usize = by_tile.iter().map(Vec::len).sum();
    // A row a lamp, and that of what is taken away.
    Ok((by_tile, batches * size_of::<Row>() * (asked.len() + 1) / asked.len().max(1)))
}

/// What fog is formed from.
struct Formed<'a, 'c> {
    context: &'a Context<'c>,
    traced: &'a Traced,
    low: Option<&'a upsample::Low>,
    grid: Option<Grid<'a>>,
    corners: Option<AtCorners<'a>>,
    asked: &'a [usize],
}

impl Formed<'_, '_> {
    /// The fog of some tiles.
    fn fog_of(&self, block: &[usize]) -> Vec<Vec<Fogged>> {
        let &Self { context, traced, low, asked, .. } = self;
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
                fogged.push(match (&self.corners, low) {
                    (Some(corners), _) => corners.fog(context, *ends),
                    (None, Some(low)) if at == 0 => low.fog(context, asked, *index, *ends),
                    _ => fog::batch(context, asked, ends.rays, ends.hits),
                });
            }
            if !context.is_mapped() {
                context.job.progress.advance();
            }
        }
        if context.is_mapped() {
            let corner = context.grid.tile(block[0]);
            match &self.grid {
                Some(grid) if context.interpolates() => grid.light(corner, &batches, &mut fogged),
                Some(grid) => {
                    mapped::add(context, asked, &batches, &mut fogged);
                    grid.take_shares(corner, &batches, &mut fogged);
                }
                None => mapped::add(context, asked, &batches, &mut fogged),
            }
            if let Some(noise) = &context.noise {
                let all = batches.iter().zip(&mut fogged);
                all.for_each(|(ends, fogged)| bend(context, noise, *ends, fogged));
            }
            block.iter().for_each(|_| context.job.progress.advance());
        }
        let mut fogged = fogged.into_iter();
        counts.into_iter().map(|count| fogged.by_ref().take(count).collect()).collect()
    }
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
            let took = self.since.elapsed();
            // Of several bands and strips it is told in one.
            match self.laps.iter_mut().find(|lap| lap.pass == pass) {
                Some(lap) => (lap.took, lap.is_reused) = (lap.took + took, lap.is_reused && !ran),
                None => self.laps.push(Lap { pass, took, is_reused: !ran }),
            }
        }
        self.since = Instant::now();
        self.progress.check()
    }
}
