//! The mean extinction T(s, x)/d towards one light, tabulated by direction and by the logarithm of
//! the distance: where many blobs shade a light, a look-up costs the same whatever their number.
//!
//! The quotient is smooth through the light itself, where T has a cone, and the table is
//! interpolated by cubics in all three coordinates; for the eye by straight lines. Around a light among the blobs, directions are
//! those of a cube's six faces; a light far from them sees them through one window. A face is one
//! sample wider on each side, so that no cubic reaches over an edge.
//!
//! Of light that comes side by side from beyond everything T itself is tabulated, on a square across its way and at
//! even steps along it.

use crate::geometry::bundle::Bundle;
use crate::geometry::control::{Control, Each, PADDED};
use crate::geometry::{Beyond, Origin};
use crate::media::{Field, Outline, Patched, Purpose, Sum};
use crate::num::{Lanes, Num};
use crate::progress::{Interrupted, Job};
use crate::request::Quality;
use crate::vector::V3;
use fearless_simd::{Simd, SimdFloat};
use glam::DVec3;
use rayon::prelude::*;

/// Fewer blobs than this are summed up directly: for numbers, and for the eye.
const FEWEST_BLOBS: [usize; 2] = [48, 16];
/// Most samples of a table for the eye (8 MB; for numbers four times as many), and of all tables of a frame: as much as is
/// kept of them.
const MOST: usize = 2 << 20;
const MOST_TOGETHER: usize = 32 << 20;
/// Most shells around a light, and behind a window.
const MOST_SHELLS: [usize; 2] = [112, 160];
/// Directions that are summed up together: a square of them.
const GROUP: usize = 8;
/// Blobs at samples along directions side by side that take a few hundredths of a second.
const LUMPS_A_LOOK: usize = 1 << 20;

/// Whether looking T up in tables is cheaper than adding it up.
pub fn pay(field: &Field, for_the_eye: bool) -> bool {
    field.lumps() >= FEWEST_BLOBS[usize::from(for_the_eye)]
}

/// How many samples a table may have, and what is drawn through them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fineness {
    samples: usize,
    /// Straight lines, for the eye, else cubics.
    lines: bool,
}

impl Fineness {
    /// Of each of so many tables, one a light and band, which fit together. It halves from time to time, so that
    /// a light more or less seldom changes the tables of all others.
    ///
    /// While a lamp is dragged its table is made anew for every draft: half of the samples are made in about half of
    /// the time. A quarter would put the worst rays of drafts beyond 5 %.
    pub fn of(tables: usize, quality: Quality, lines: bool) -> Self {
        let most = match quality {
            Quality::Draft => MOST / 2,
            Quality::Full if lines => MOST,
            Quality::Full => 4 * MOST,
        };
        Self { samples: most.min(MOST_TOGETHER / tables.max(1).next_power_of_two()), lines }
    }
}

/// T(s, x)/d of a scene's blobs around one light; of one beyond everything T.
#[derive(Debug)]
pub struct LightTable {
    /// From where places are counted [m].
    apex: DVec3,
    /// The directions of the only face; `None` for those of a cube.
    window: Option<Window>,
    /// Samples along the side of a face, without those beyond its edges.
    side: usize,
    shells: usize,
    /// ln of the first shell's radius [m]; where all ways are parallel how far the first lies.
    first: f32,
    /// Shells per unit of that.
    density: f32,
    /// Whether straight lines are drawn between samples, which then stand where they fit those best.
    lines: bool,
    /// `[face][row][column][shell]`.
    values: Vec<f32>,
    /// The sums that lines were fitted to; empty where cubics run through them.
    sums: Vec<f32>,
    /// Of each square of directions what its sums depend on, where that can be told.
    prints: Vec<Option<u64>>,
}

/// The directions in which a light sees fog from outside.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Window {
    /// Across, down, and towards the fog's middle.
    axes: [DVec3; 3],
    /// Tangent of half the angle across; of parallel ways half the side [m].
    reach: f64,
    is_parallel: bool,
}

impl Window {
    /// `None` if the light is among the blobs or close to them.
    fn new(outline: &Outline, apex: DVec3) -> Option<Self> {
        let Outline { min, max, .. } = *outline;
        let (middle, radius) = (0.5 * (min + max), 0.5 * min.distance(max));
        let distance = middle.distance(apex);
        let tangent = radius / (distance * distance - radius * radius).max(0.0).sqrt();
        let toward = (middle - apex).normalize_or_zero();
        let (across, down) = toward.any_orthonormal_pair();
        let axes = [across, down, toward];
        (tangent < 1.0).then_some(Self { axes, reach: tangent, is_parallel: false })
    }
}

/// What light that comes side by side meets: the place in front of all lumps from which a table of it counts, its
/// window, and the spacing of samples that each lump needs [m].
fn side_by_side(field: &Field, beyond: &Beyond) -> Option<(DVec3, Window, Vec<f64>)> {
    /// As seen from so many times the lumps' extent all ways are parallel.
    const FAR: f64 = 1e6;
    let Outline { min, max, .. } = field.outline(DVec3::ZERO);
    let (middle, reach) = (0.5 * (min + max), 0.5 * min.distance(max));
    if !reach.is_finite() {
        return None;
    }
    let away = FAR * reach;
    let spacings = field.outline(middle + away * beyond.toward).spacings;
    let (across, down) = beyond.toward.any_orthonormal_pair();
    let window = Window { axes: [across, down, -beyond.toward], reach, is_parallel: true };
    let spacings = spacings.into_iter().map(|spacing| away * spacing).collect();
    Some((middle + reach * beyond.toward, window, spacings))
}

/// Geometry of a table: spacing of samples [rad], nearest and farthest shell [m].
struct Extent {
    spacing: f64,
    near: f64,
    far: f64,
}

impl Extent {
    /// For faces of that reach and at most so many samples along their sides; `None` if the blobs
    /// are too small for them.
    fn new(outline: Outline, reach: f64, most: usize) -> Option<Self> {
        let Outline { near, far, mut spacings, .. } = outline;
        spacings.sort_unstable_by(f64::total_cmp);
        let finest = 2.0 * reach / most as f64;
        // A few blobs that are finer than the rest do not decide: they are far away, or thin.
        let spacing = spacings[spacings.len() / 10].max(finest).min(0.25 * reach);
        let fits = spacings[spacings.len() / 4] > 0.17 * finest;
        fits.then_some(Self { spacing, near: near.max(1e-3 * far), far })
    }
}

impl LightTable {
    /// The table of a light; `None` if the blobs are too small for one. What `known`, a table of the same light, says of
    /// directions in which nothing has changed is taken from there, to the last bit.
    ///
    /// # Errors
    /// [`Interrupted`] when the job's progress says so.
    pub fn new(
        job: &Job,
        field: &Field,
        origin: Origin,
        fineness: Fineness,
        known: Option<&Self>,
    ) -> Result<Option<Self>, Interrupted> {
        let empty = match origin {
            Origin::At(apex) => Self::empty(field, apex, fineness),
            Origin::Beyond(beyond) => Self::empty_beyond(field, &beyond, fineness),
        };
        let Some(mut table) = empty else { return Ok(None) };
        let known = known.filter(|known| known.has_places_of(&table));
        table.fill(job, field, known)?;
        if table.lines {
            table.sums = table.fit(known);
        }
        Ok(Some(table))
    }

    /// Whether its samples stand where those of another table do.
    fn has_places_of(&self, other: &Self) -> bool {
        let places = |table: &Self| {
            let Self { apex, window, side, shells, first, density, lines, .. } = *table;
            (apex, window, side, shells, first, density, lines)
        };
        places(self) == places(other)
    }

    /// A table without its values.
    fn empty(field: &Field, apex: DVec3, fineness: Fineness) -> Option<Self> {
        let Fineness { samples, lines } = fineness;
        let outline = field.outline(apex);
        let window = Window::new(&outline, apex);
        let (faces, most_shells) =
            if window.is_some() { (1, MOST_SHELLS[1]) } else { (6, MOST_SHELLS[0]) };
        let reach = window.map_or(1.0, |window| window.reach);
        let most = ((samples / most_shells / faces) as f64).sqrt() as usize;
        let extent = Extent::new(outline, reach, most.saturating_sub(3))?;
        let side = (2.0 * reach / extent.spacing).ceil() as usize + 1;
        // A light among the fog meets its mean extinction from the first step on.
        let near = if window.is_some() { extent.near } else { 0.2 * extent.near };
        let span = (extent.far / near).ln();
        let shells = (span / extent.spacing).ceil().min((most_shells - 3) as f64) as usize + 3;
        // One shell stands before the first and one after the last.
        let density = (shells - 3) as f64 / span;
        let first = near.ln() - 1.0 / density;
        Some(Self {
            apex,
            window,
            side,
            shells,
            first: first as f32,
            density: density as f32,
            lines,
            values: vec![0.0; faces * (side + 2) * (side + 2) * shells],
            sums: Vec::new(),
            prints: Vec::new(),
        })
    }

    /// The same for light that comes side by side.
    fn empty_beyond(field: &Field, beyond: &Beyond, fineness: Fineness) -> Option<Self> {
        let Fineness { samples, lines } = fineness;
        let (apex, window, spacings) = side_by_side(field, beyond)?;
        let (reach, most_shells) = (window.reach, MOST_SHELLS[1]);
        let most = ((samples / most_shells) as f64).sqrt() as usize;
        let outline = Outline { near: reach, far: reach, spacings, ..Outline::default() };
        let spacing = Extent::new(outline, reach, most.saturating_sub(3))?.spacing;
        let side = (2.0 * reach / spacing).ceil() as usize + 1;
        let shells = (2.0 * reach / spacing).ceil().min((most_shells - 3) as f64) as usize + 3;
        // One shell stands before the first and one after the last.
        let density = (shells - 3) as f64 / (2.0 * reach);
        Some(Self {
            apex,
            window: Some(window),
            side,
            shells,
            first: (-1.0 / density) as f32,
            density: density as f32,
            lines,
            values: vec![0.0; (side + 2) * (side + 2) * shells],
            sums: Vec::new(),
            prints: Vec::new(),
        })
    }

    /// Squares of directions across a face.
    fn squares(&self) -> usize {
        (self.side + 2).div_ceil(GROUP)
    }

    /// What was summed up, before lines were fitted to it.
    fn sums(&self) -> &[f32] {
        if self.lines { &self.sums } else { &self.values }
    }

    fn fill(&mut self, job: &Job, field: &Field, known: Option<&Self>) -> Result<(), Interrupted> {
        let (wide, shells) = (self.side + 2, self.shells);
        let t: Vec<Each> = (0..shells).map(|i| [self.radius(i) as f32; PADDED]).collect();
        // Bands of a face's rows: in each, squares of directions share a list of blobs.
        let mut values = std::mem::take(&mut self.values);
        let faces = values.chunks_mut(wide * wide * shells).enumerate();
        let bands = faces.flat_map(|(face, values)| {
            let bands = values.chunks_mut(GROUP * wide * shells).enumerate();
            bands.map(move |(band, values)| (face, band, values))
        });
        let bands = bands.collect::<Vec<_>>().into_par_iter().map(|(face, band, part)| {
            let first = (face * self.squares() + band) * self.squares();
            let start = (face * wide + band * GROUP) * wide * shells;
            let mut prints = Vec::with_capacity(self.squares());
            for column in (0..wide).step_by(GROUP) {
                let place = |i: usize| self.ray(face, band * GROUP + i / GROUP, column + i % GROUP);
                let square: Vec<_> = (0..GROUP * GROUP).map(place).collect();
                let lumps = self.lumps(job, field, &square, &t);
                let print = lumps.1.fingerprint();
                let at = first + column / GROUP;
                let known = known.filter(|known| print.is_some() && known.prints[at] == print);
                let width = GROUP.min(wide - column) * shells;
                let lines = part.chunks_mut(wide * shells).enumerate();
                let lines = lines.map(|(y, line)| (y, &mut line[column * shells..][..width]));
                match known {
                    Some(known) => lines.for_each(|(y, line)| {
                        let from = start + (y * wide + column) * shells;
                        line.copy_from_slice(&known.sums()[from..][..width]);
                    }),
                    None => {
                        let depths = self.depths(job, &square, lumps, &t)?;
                        for (y, line) in lines {
                            for (x, line) in line.chunks_mut(shells).enumerate() {
                                line.copy_from_slice(&depths[y * GROUP + x]);
                            }
                        }
                    }
                }
                prints.push(print);
            }
            Ok(prints)
        });
        let prints: Vec<Vec<_>> = bands.collect::<Result<_, Interrupted>>()?;
        self.prints = prints.concat();
        self.values = values;
        Ok(())
    }

    /// Moves the samples to where straight lines between them are best, and answers where they were. A line between two
    /// values of a curve is off by h²/12 of its second derivative on the whole, always to the same side: each value less
    /// a twelfth of its second differences leaves errors to both sides, less than half as large.
    fn fit(&mut self, known: Option<&Self>) -> Vec<f32> {
        const SHARE: f32 = 1.0 / 12.0;
        let (wide, shells) = (self.side + 2, self.shells);
        let line = wide * shells;
        let bend = |before: f32, at: f32, after: f32| SHARE * (before + after - 2.0 * at);
        let mut fitted = self.values.clone();
        let row = |i: usize| &self.values[i * line..][..line];
        fitted.par_chunks_mut(line).enumerate().for_each(|(i, fitted)| {
            if let Some(known) = known.filter(|known| self.is_line_of(known, i)) {
                fitted.copy_from_slice(&known.values[i * line..][..line]);
                return;
            }
            let here = row(i);
            if 0 < i % wide && i % wide < wide - 1 {
                let (above, below) = (row(i - 1), row(i + 1));
                for k in 0..line {
                    fitted[k] -= bend(above[k], here[k], below[k]);
                }
            }
            for k in shells..line - shells {
                fitted[k] -= bend(here[k - shells], here[k], here[k + shells]);
            }
            for (fitted, here) in fitted.chunks_mut(shells).zip(here.chunks(shells)) {
                for k in 1..shells - 1 {
                    fitted[k] -= bend(here[k - 1], here[k], here[k + 1]);
                }
            }
        });
        std::mem::replace(&mut self.values, fitted)
    }

    /// Whether nothing around the line of samples at that place has changed since another table.
    fn is_line_of(&self, known: &Self, i: usize) -> bool {
        let (wide, squares) = (self.side + 2, self.squares());
        let (face, row) = (i / wide, i % wide);
        let bands = row.saturating_sub(1) / GROUP..=(row + 1).min(wide - 1) / GROUP;
        let first = (face * squares + bands.start()) * squares;
        let last = (face * squares + bands.end() + 1) * squares;
        let same = |at: usize| self.prints[at].is_some() && self.prints[at] == known.prints[at];
        (first..last).all(same)
    }

    /// How much memory it takes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.values.as_slice()) + size_of_val(self.sums.as_slice())
    }

    /// From where places are counted [m].
    pub fn apex(&self) -> DVec3 {
        self.apex
    }

    /// Whether all ways are parallel.
    pub fn is_parallel(&self) -> bool {
        self.window.is_some_and(|window| window.is_parallel)
    }

    /// Axes of the only face, across, down and towards the fog; zero for the faces of a cube.
    pub fn axes(&self) -> [DVec3; 3] {
        self.window.map_or([DVec3::ZERO; 3], |window| window.axes)
    }

    /// Tangent of half the angle across the only face, or half its side [m]; 0 for those of a cube.
    pub fn reach(&self) -> f32 {
        self.window.map_or(0.0, |window| window.reach as f32)
    }

    /// ln of the first shell's radius, shells per unit of ln r, samples along the side of a face
    /// without those beyond its edges, and shells.
    pub fn scale(&self) -> [f32; 4] {
        [self.first, self.density, self.side as f32, self.shells as f32]
    }

    /// `[face][row][column][shell]`, two rows and columns beyond each face's edges.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    fn radius(&self, shell: usize) -> f64 {
        let at = f64::from(self.first) + shell as f64 / f64::from(self.density);
        if self.is_parallel() { at.max(0.0) } else { at.exp() }
    }

    /// The way that a sample stands for: its start and its direction.
    fn ray(&self, face: usize, row: usize, column: usize) -> (DVec3, DVec3) {
        let at = |i: usize| -1.0 + (i as f64 - 1.0) * 2.0 / (self.side - 1) as f64;
        let (u, v) = (at(column), at(row));
        if let Some(Window { axes: [across, down, toward], reach, is_parallel }) = self.window {
            let aside = reach * (u * across + v * down);
            if is_parallel {
                return (self.apex + aside, toward);
            }
            return (self.apex, (toward + aside).normalize());
        }
        let major = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
        let direction = match face / 2 {
            0 => DVec3::new(major, u, v),
            1 => DVec3::new(v, major, u),
            _ => DVec3::new(u, v, major),
        };
        (self.apex, direction.normalize())
    }

    /// The lumps that matter to some ways, and the bundle that these are.
    fn lumps(
        &self,
        job: &Job,
        field: &Field,
        square: &[(DVec3, DVec3)],
        t: &[Each],
    ) -> (Bundle, Sum<dyn Patched>) {
        let longest = f64::from(t[t.len() - 1][0]);
        let around = Bundle::around(square, longest);
        let bundle = around.unwrap_or(Bundle::all_around(self.apex, longest));
        (bundle, field.near_lumps(job.level, bundle, 0.0, Purpose::Nodes).patched())
    }

    /// T/d of the lumps at every shell, or T, for each of some ways.
    fn depths(
        &self,
        job: &Job,
        square: &[(DVec3, DVec3)],
        (bundle, lumps): (Bundle, Sum<dyn Patched>),
        t: &[Each],
    ) -> Result<Vec<Vec<f32>>, Interrupted> {
        let mut all = Vec::with_capacity(square.len());
        let rows = (LUMPS_A_LOOK / lumps.terms().max(1)).max(1);
        let is_parallel = self.is_parallel();
        for rays in square.chunks(PADDED) {
            job.progress.check()?;
            let control = Control::new(|c| {
                let (start, direction) = rays[c % rays.len()];
                (if is_parallel { start - bundle.origin } else { DVec3::ZERO }, direction)
            });
            let lumps = lumps.on_rays(job.level, &control, is_parallel, 0.0);
            let mut depth = Vec::with_capacity(t.len());
            for t in t.chunks(rows) {
                job.progress.check()?;
                depth.extend(lumps.depth(job.level, t));
            }
            for c in 0..rays.len() {
                let by = |t: &Each| if is_parallel { 1.0 } else { t[c] };
                all.push(depth.iter().zip(t).map(|(depth, t)| depth[c] / by(t)).collect());
            }
        }
        Ok(all)
    }

    /// The blobs' mean extinction between the light and points relative to [`LightTable::apex`] [1/m], or T of
    /// light that comes side by side: by cubics in all three coordinates, or by straight lines, which cost a third.
    #[inline(always)]
    pub fn means<S: Simd>(&self, simd: S, way: V3<Lanes<S>>) -> Lanes<S> {
        let distance = way.length_squared().sqrt();
        let [face, u, v, seen, along] = self.on_face(simd, way, distance);
        let is_parallel = self.is_parallel();
        let half = Lanes::splat(simd, 0.5 * (self.side - 1) as f32);
        let last = Lanes::splat(simd, (self.side - 2) as f32);
        let (column, x) = cell(u.mul_add(half, half), last);
        let (row, y) = cell(v.mul_add(half, half), last);
        let one = distance.lit(1.0);
        let radial = if is_parallel { along } else { distance.ln() };
        let radial = (radial - Lanes::splat(simd, self.first)) * Lanes::splat(simd, self.density);
        let end = Lanes::splat(simd, (self.shells - 2) as f32);
        let (shell, r) = cell(radial.max(one), end - one);
        let r = r.min(one);
        let sum = if self.lines {
            self.lines(simd, [face, row, column, shell], [x, y, r])
        } else {
            let places = [face, row, column, shell].map(store);
            let weights = [cubic(x), cubic(y), cubic(r)].map(|weights| weights.map(store));
            let mut sums = [0.0; PADDED];
            for (lane, sum) in sums.iter_mut().enumerate().take(Lanes::<S>::COUNT) {
                *sum = self.cubics(places.map(|row| row[lane] as usize), &weights, lane);
            }
            Lanes::load(simd, &sums)
        };
        if is_parallel {
            return sum.max(one.lit(0.0)) * seen;
        }
        // Behind the last shell nothing is added.
        let beyond = (radial - end).max(one.lit(0.0)) / Lanes::splat(simd, self.density);
        sum.max(one.lit(0.0)) * (-beyond).exp() * seen
    }

    /// Straight lines in all three coordinates, from the eight samples around a place.
    #[inline(always)]
    fn lines<S: Simd>(
        &self,
        simd: S,
        [face, row, column, shell]: [Lanes<S>; 4],
        [x, y, r]: [Lanes<S>; 3],
    ) -> Lanes<S> {
        let (wide, shells) = (self.side + 2, self.shells);
        // The place of the first, exact: no table has as many samples as f32 has whole numbers.
        let times = |a: usize| Lanes::splat(simd, a as f32);
        let one = x.lit(1.0);
        let line = face.mul_add(times(wide), row + one);
        let place = line.mul_add(times(wide), column + one).mul_add(times(shells), shell);
        let mut around = [[0.0; PADDED]; 8];
        for (lane, first) in store(place).into_iter().enumerate().take(Lanes::<S>::COUNT) {
            let first = first as i32 as usize;
            let next = first + wide * shells;
            for (i, at) in [first, first + shells, next, next + shells].into_iter().enumerate() {
                let Some([near, far]) = self.values[at..].first_chunk::<2>() else { continue };
                (around[2 * i][lane], around[2 * i + 1][lane]) = (*near, *far);
            }
        }
        let load = |i: usize| Lanes::load(simd, &around[i]);
        let along = |i: usize| (load(2 * i + 1) - load(2 * i)).mul_add(r, load(2 * i));
        let (a, b, c, d) = (along(0), along(1), along(2), along(3));
        let (upper, lower) = ((b - a).mul_add(x, a), (d - c).mul_add(x, c));
        (lower - upper).mul_add(y, upper)
    }

    /// The face that points are seen through, where from −1 to 1, 0 for those that no face shows, and
    /// how far ahead they lie [m].
    #[inline(always)]
    fn on_face<S: Simd>(&self, simd: S, way: V3<Lanes<S>>, distance: Lanes<S>) -> [Lanes<S>; 5] {
        let (zero, one) = (distance.lit(0.0), distance.lit(1.0));
        let least = distance.lit(f64::from(f32::MIN_POSITIVE));
        if let Some(Window { axes, reach, is_parallel }) = self.window {
            let [across, down, toward] =
                axes.map(|axis| way.dot(V3::splat(simd, axis.as_vec3().to_array())));
            let ahead = if is_parallel { one } else { toward };
            let scale = one / (ahead * one.lit(reach)).max(least);
            let (u, v) = (across * scale, down * scale);
            let seen = Lanes::select(zero.lt(toward), one, zero);
            let seen = Lanes::select(one.lt(u.abs().max(v.abs())), zero, seen);
            return [zero, u.min(one).max(-one), v.min(one).max(-one), seen, toward];
        }
        let V3 { x, y, z } = way;
        let (y_wins, z_wins) = (x.abs().lt(y.abs()), x.abs().max(y.abs()).lt(z.abs()));
        let pick = |x, y, z| Lanes::select(z_wins, z, Lanes::select(y_wins, y, x));
        let (major, u, v) = (pick(x, y, z), pick(y, z, x), pick(z, x, y));
        let face = pick(zero, one.lit(2.0), one.lit(4.0));
        let face = face + Lanes::select(major.lt(zero), one, zero);
        let scale = one / major.abs().max(least);
        [face, u * scale, v * scale, one, distance]
    }

    /// The cubics of one lane.
    #[inline(always)]
    fn cubics(
        &self,
        [face, row, column, shell]: [usize; 4],
        [x, y, r]: &[[Each; 4]; 3],
        lane: usize,
    ) -> f32 {
        let wide = self.side + 2;
        let mut along = [0.0f32; 4];
        for (i, y) in y.iter().enumerate() {
            let row = (face * wide + row + i) * wide + column;
            for (k, x) in x.iter().enumerate() {
                let at = (row + k) * self.shells + shell - 1;
                let weight = x[lane] * y[lane];
                let Some(values) = self.values[at..].first_chunk::<4>() else { continue };
                for (sum, value) in along.iter_mut().zip(values) {
                    *sum += weight * value;
                }
            }
        }
        (along[0] * r[0][lane] + along[1] * r[1][lane])
            + (along[2] * r[2][lane] + along[3] * r[3][lane])
    }
}

/// The sample before a place, at most `last`, and how far behind it the place lies.
#[inline(always)]
fn cell<S: Simd>(at: Lanes<S>, last: Lanes<S>) -> (Lanes<S>, Lanes<S>) {
    let first = Lanes(at.0.floor()).max(at.lit(0.0)).min(last);
    (first, at - first)
}

#[inline(always)]
fn store<S: Simd>(lanes: Lanes<S>) -> Each {
    let mut each = [0.0; PADDED];
    lanes.store(&mut each);
    each
}

/// Weights of the cubic through samples at −1, 0, 1, 2.
#[inline(always)]
fn cubic<N: Num>(x: N) -> [N; 4] {
    let (one, sixth) = (x.lit(1.0), x.lit(1.0 / 6.0));
    let (before, after, end) = (x + one, x - one, x - x.lit(2.0));
    let (outer, inner) = (before * x, after * end);
    [
        -(x * inner) * sixth,
        before * inner * x.lit(0.5),
        -(outer * end) * x.lit(0.5),
        outer * after * sixth,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Progress;
    use crate::scene::Scene;
    use serde_json::json;

    /// Small blobs around a lamp, one of which is so thick.
    fn field(extinction: f64) -> Field {
        let blob = |i: usize| {
            let turn = i as f64;
            let center = [4.0 * turn.cos(), 3.0 * (1.7 * turn).sin(), 4.0 * turn.sin()];
            let extinction = if i == 7 { extinction } else { 0.5 };
            json!({ "center": center, "radius": 0.4, "extinction": extinction })
        };
        let blobs: Vec<_> = (0..60).map(blob).collect();
        let terms = json!([{ "kind": "gaussians", "blobs": blobs }]);
        let text = json!({ "fog": { "terms": terms } }).to_string();
        let scene: Scene = serde_json::from_str(&text).unwrap();
        Field::new(&scene.fog.terms, 0, &scene.fog.moment(0.0))
    }

    /// What is taken from a table of another fog is what would be summed up, and much is.
    #[test]
    fn a_table_does_not_depend_on_the_one_before() {
        let (progress, origin) = (Progress::default(), Origin::At(DVec3::ZERO));
        let job = Job::new(&progress);
        let fields = [field(0.5), field(0.7)];
        for lines in [true, false] {
            let fineness = Fineness::of(1, Quality::Draft, lines);
            let table = |field: &Field, known: Option<&LightTable>| {
                LightTable::new(&job, field, origin, fineness, known).unwrap().unwrap()
            };
            let before = table(&fields[0], None);
            let (anew, after) = (table(&fields[1], None), table(&fields[1], Some(&before)));
            assert!(after.has_places_of(&before));
            assert!(anew.values.iter().eq(&after.values) && anew.sums.iter().eq(&after.sums));
            assert_ne!(before.values, after.values);
            let same = before.prints.iter().zip(&after.prints).filter(|(a, b)| a == b).count();
            let all = after.prints.len();
            assert!(all / 2 < same && same < all, "{same} of {all} squares are the same");
        }
    }
}
