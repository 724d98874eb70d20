//! B-spline fogmaps (Giroud and Biri 2010): β(x) = scale · share(y) · Σ c φ(u − i) φ(w − j) over a plane of cells.
//!
//! `plane` integrates it along a way, `wavelet` takes it apart into levels of detail. Of a view ray from O to P the
//! detail level n counts up to |OP| μ^(n + 1) (eq. 12, whose exponent is read so, level 0 the coarsest); ways from
//! lights see all details. Where μ is 1 nothing is dropped, and the map is followed as it was given.

mod plane;
mod wavelet;

use super::closed::{Closed, crossing, hull};
use super::places::Places;
use super::vertical::{Profile, Uniform, Vertical};
use super::{Moment, TermKind, Words};
use crate::geometry::Beyond;
use crate::json::document::parts;
use crate::json::limits::{self, COUNTS};
use crate::json::{Albedo, Checker, Code, Spectrum, bounded};
use crate::num::Num;
use crate::phase::Phase;
use crate::shared::Shared;
use crate::vector::V3;
use glam::{DVec3, Vec4};
use plane::{Plane, Way};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use wavelet::{Grid, decompose};

/// A map of fog, seen from above: a smooth sum of B-splines on square cells, the same at every height or as
/// `vertical` says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Fogmap {
    /// Name of this term, unique among the terms.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1, max = limits::COUNTS.id_chars))]
    pub id: Option<String>,
    /// False removes it from the fog.
    pub enabled: bool,
    /// Share of the extinguished light that this term scatters; the fog's own where nothing is said.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub albedo: Option<Albedo>,
    /// Into which directions this term scatters; as the fog's own where nothing is said.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phase: Option<Phase>,
    /// Share of the wind that moves this term, from 0 to 1.
    #[schemars(range(min = limits::FRACTION.min, max = limits::FRACTION.max))]
    pub wind_response: f64,
    /// Degree of the splines: 0 makes steps, 1 slopes, 2 is smooth.
    #[schemars(range(min = 0, max = 2))]
    pub degree: u8,
    /// Where the first coefficient's spline begins: x and z [m].
    #[schemars(inner(range(min = limits::COORDINATE.min, max = limits::COORDINATE.max)))]
    pub origin: [f64; 2],
    /// The side of a cell [m].
    #[schemars(range(min = limits::CELL.min, max = limits::CELL.max))]
    pub cell_m: f64,
    /// Extinction where the map is 1 [1/m].
    #[schemars(schema_with = "Spectrum::extinction")]
    pub scale: Spectrum,
    /// The map: rows along +z, columns along +x.
    #[serde(deserialize_with = "bounded::rows::<{ COUNTS.map_side }, _, _>")]
    #[schemars(length(min = 1, max = COUNTS.map_side), inner(length(min = 1, max = COUNTS.map_side)))]
    #[schemars(inner(inner(range(min = limits::EXTINCTION.min, max = limits::EXTINCTION.max))))]
    #[schemars(extend("x-map" = 1))]
    pub coefficients: Shared<Vec<Vec<f64>>>,
    /// Levels of detail that it is taken apart into.
    #[schemars(range(min = 0, max = 10))]
    pub levels: u8,
    /// How far along a ray details count, as a share of its length for every level: 1 keeps all.
    #[schemars(range(min = limits::FRACTION.min, max = limits::FRACTION.max))]
    pub mu: f64,
    /// Whether details are turned back into splines and merged, a level each: faster, and the same fog.
    pub deconstruct: bool,
    /// How the extinction depends on height.
    pub vertical: Vertical,
}

parts!(Fogmap { coefficients });

impl Default for Fogmap {
    fn default() -> Self {
        Self {
            id: None,
            enabled: true,
            albedo: None,
            phase: None,
            wind_response: 1.0,
            degree: 1,
            origin: [-2.5, -2.5],
            cell_m: 1.0,
            scale: Spectrum::Grey(0.3),
            coefficients: vec![
                vec![0.2, 0.6, 0.4, 0.1],
                vec![0.5, 1.0, 0.8, 0.3],
                vec![0.3, 0.9, 0.5, 0.2],
                vec![0.1, 0.4, 0.2, 0.0],
            ]
            .into(),
            levels: 0,
            mu: 1.0,
            deconstruct: true,
            vertical: Vertical::Uniform(Uniform {}),
        }
    }
}

impl Fogmap {
    /// Columns and rows.
    fn size(&self) -> [usize; 2] {
        [self.coefficients.first().map_or(0, Vec::len), self.coefficients.len()]
    }

    fn check_map(&self, check: &mut Checker, at: &dyn Fn(&str) -> String) {
        let [columns, rows] = self.size();
        if rows == 0 {
            check.refuse(Code::WrongLength, || at("coefficients"), "a map has at least one row");
        }
        for (j, row) in self.coefficients.iter().enumerate() {
            let of_row = || at(&format!("coefficients/{j}"));
            if row.is_empty() {
                check.refuse(Code::WrongLength, of_row, "a row has at least one coefficient");
            } else if row.len() != columns {
                let detail =
                    format!("this row has {} coefficients, the first {columns}", row.len());
                check.refuse(Code::Conflict, of_row, detail);
            }
            for (i, value) in row.iter().enumerate() {
                check.number(*value, limits::EXTINCTION, || at(&format!("coefficients/{j}/{i}")));
            }
        }
        let most = usize::BITS - columns.max(rows).saturating_sub(1).leading_zeros();
        if u32::from(self.levels) > most {
            let detail = format!("a map of {columns}×{rows} has up to {most} levels");
            check.refuse(Code::OutOfRange, || at("levels"), detail);
        }
    }
}

impl TermKind for Fogmap {
    type Medium = Fogmaps;

    const SOURCE: &'static str = "Giroud, Biri: Modeling and Rendering Heterogeneous Fog in Real-Time Using B-Spline \
        Wavelets (WSCG 2010), with the biorthogonal wavelets of Cohen, Daubechies and Feauveau (1992) for splines of \
        degree 0, 1 and 2: (1, 1), (2, 2) and (3, 1).";

    const TRIAL: &'static str = r#"[
        {"kind": "fogmap", "degree": 1, "origin": [-4, -4], "cell_m": 1.5, "scale": 0.4,
         "coefficients": [[0.2, 1, 0, 0.4], [0, 0.7, 0.9, 0.1], [0.5, 0, 0.3, 0.8]],
         "vertical": {"kind": "slab", "min_m": 0, "max_m": 2.2}},
        {"kind": "fogmap", "degree": 2, "origin": [-5, -5], "cell_m": 2, "scale": 0.3,
         "coefficients": [[0.4, 0.9, 0.1], [0.8, 0.2, 0.6]],
         "vertical": {"kind": "exponential", "base_m": 0.5, "falloff_per_m": 0.9}},
        {"kind": "fogmap", "degree": 0, "origin": [0.3, -3.2], "cell_m": 0.9, "scale": 0.2,
         "coefficients": [[0.4, 0.9], [0.8, 0.2]]}]"#;

    fn what(&self) -> &'static str {
        "a fogmap"
    }

    fn check(&self, check: &mut Checker, at: &dyn Fn(&str) -> String, _far_m: f64) {
        let degrees = limits::Range { min: 0.0, max: 2.0 };
        check.number(self.degree.into(), degrees, || at("degree"));
        for (k, origin) in self.origin.into_iter().enumerate() {
            check.number(origin, limits::COORDINATE, || at(&format!("origin/{k}")));
        }
        check.number(self.cell_m, limits::CELL, || at("cell_m"));
        check.spectrum(self.scale, limits::EXTINCTION, || at("scale"));
        check.number(self.mu, limits::FRACTION, || at("mu"));
        self.vertical.check(check, |name| at(&format!("vertical/{name}")));
        self.check_map(check, at);
    }

    fn cost(&self, _length_m: f64) -> usize {
        /// A cell takes as long as so many blobs, which rays of a picture share.
        const BLOBS: usize = 8;
        BLOBS * self.size().iter().sum::<usize>()
    }

    fn is_grey(&self) -> bool {
        self.scale.is_grey()
    }

    fn merge(terms: &[&Self], channel: usize, moment: &Moment) -> Fogmaps {
        let there = terms.iter().filter(|term| term.scale.channels()[channel] > 0.0);
        Fogmaps(there.map(|term| Placed::new(term, channel, moment)).collect())
    }
}

/// A map where it lies, seen from an origin.
#[derive(Clone, Debug, PartialEq)]
struct Placed {
    whole: Arc<Plane>,
    /// What view rays see of it: planes, each up to a share of their length; none if they see the whole.
    layers: Arc<Vec<(Plane, f64)>>,
    /// [1/m].
    scale: f64,
    /// Where the map's origin is [m].
    origin: [f64; 2],
    profile: Profile,
    /// Optical depth behind which nothing is asked.
    enough: f64,
}

impl Placed {
    fn new(term: &Fogmap, channel: usize, moment: &Moment) -> Self {
        let degree = usize::from(term.degree);
        let grid = Grid::new(term.size(), term.coefficients.concat());
        let shift = moment.shift(term.wind_response);
        let is_cut = term.mu < 1.0 && term.levels > 0;
        Self {
            whole: Arc::new(Plane::new(&grid, degree, term.cell_m, 0)),
            layers: Arc::new(if is_cut { layers(term, &grid) } else { Vec::new() }),
            scale: term.scale.channels()[channel] * moment.density,
            origin: [term.origin[0] + shift.x, term.origin[1] + shift.z],
            profile: term.vertical.profile().seen_from(-shift.y),
            enough: f64::INFINITY,
        }
    }

    #[inline(always)]
    fn way<N: Num>(&self, plane: &Plane, a: V3<N>, b: V3<N>) -> Way<N> {
        let start = [self.origin[0] + plane.start[0], self.origin[1] + plane.start[1]];
        Way::new(a, b, start, plane.cell_m)
    }

    #[inline(always)]
    fn at<N: Num>(&self, x: V3<N>) -> N {
        let plane = &*self.whole;
        let Way { start: [u, w], .. } = self.way(plane, x, x);
        let value = u.each(w, |u, w| plane.at(u, w));
        value * self.profile.at(x.y) * x.x.lit(self.scale)
    }

    #[inline(always)]
    fn mean<N: Num>(&self, a: V3<N>, b: V3<N>) -> N {
        let enough = if self.enough.is_finite() {
            let length = (b - a).length_squared().sqrt().max(a.x.lit(f64::MIN_POSITIVE));
            a.x.lit(self.enough / self.scale) / length
        } else {
            a.x.lit(f64::INFINITY)
        };
        self.whole.mean(&self.way(&self.whole, a, b), self.profile, enough) * a.x.lit(self.scale)
    }

    /// T from a point to beyond everything: to where its way leaves the map or its heights.
    #[inline(always)]
    fn beyond<N: Num>(&self, x: V3<N>, &Beyond { toward, path_m }: &Beyond) -> N {
        let zero = x.x.lit(0.0);
        let mut length = self.profile.ends(x.y, toward.y);
        for (axis, at, way) in [(0, x.x, toward.x), (1, x.z, toward.z)] {
            if way != 0.0 {
                let [low, high] = self.between(axis);
                let side = if way > 0.0 { high } else { low };
                let leaves = ((zero.lit(side) - at) * zero.lit(1.0 / way)).max(zero);
                length = Some(match length {
                    Some(length) => length.min(leaves),
                    None => leaves,
                });
            }
        }
        let length = length.unwrap_or(zero.lit(path_m));
        let end = x + V3::lit(zero, toward).scale(length);
        self.mean(x, end) * length
    }

    /// From where to where it lies, along x or z [m].
    fn between(&self, axis: usize) -> [f64; 2] {
        let low = self.origin[axis] + self.whole.start[axis];
        [low, low + self.whole.cell_m * self.whole.cells()[axis] as f64]
    }

    /// What a view ray sees of it. A detail may be below 0, fog never is.
    #[inline(always)]
    fn view_mean<N: Num>(&self, a: V3<N>, b: V3<N>) -> N {
        if self.layers.is_empty() {
            return self.mean(a, b);
        }
        let mut sum = a.x.lit(0.0);
        for (plane, share) in self.layers.iter() {
            let way = self.way(plane, a, b).first(*share);
            // Of details below 0 no sum is ever enough.
            let mean = plane.mean(&way, self.profile, sum.lit(f64::INFINITY));
            sum = mean.mul_add(sum.lit(*share), sum);
        }
        sum.max(sum.lit(0.0)) * sum.lit(self.scale)
    }

    /// The planes of cells' sides, of both axes, in cells.
    fn sides(&self, axis: usize) -> impl Iterator<Item = f64> {
        let start = self.origin[axis] + self.whole.start[axis];
        let cell_m = self.whole.cell_m;
        (0..=self.whole.cells()[axis]).map(move |i| start + cell_m * i as f64)
    }

    /// From where to where a ray from the origin is above the map, and at its heights [m].
    fn extent(&self, direction: DVec3, length_m: f64) -> Option<(f64, f64)> {
        let (mut from, mut to) = self.profile.span(direction.y, length_m)?;
        for (axis, way) in [(0, direction.x), (1, direction.z)] {
            let [low, high] = self.between(axis);
            if way == 0.0 {
                if low > 0.0 || high < 0.0 {
                    return None;
                }
                continue;
            }
            let (a, b) = (low / way, high / way);
            (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
        }
        (from < to).then_some((from, to))
    }
}

/// The coarse map, which counts everywhere, and its details, of which the finer count the shorter.
fn layers(term: &Fogmap, grid: &Grid) -> Vec<(Plane, f64)> {
    let (degree, levels) = (usize::from(term.degree), u32::from(term.levels));
    let (coarse, details) = decompose(grid, degree, usize::from(term.levels));
    let mut layers = vec![(Plane::new(&coarse, degree, term.cell_m, levels), 1.0)];
    for (n, detail) in (0..levels).zip(&details) {
        let share = term.mu.powi(n as i32 + 1);
        let plane = |grid: &Grid| (Plane::new(grid, degree, term.cell_m, levels - 1 - n), share);
        if term.deconstruct {
            layers.push(plane(&detail.merged(degree)));
        } else {
            layers.extend(detail.deconstructed(degree).iter().map(plane));
        }
    }
    layers.retain(|(_, share)| *share > 0.0);
    layers
}

/// The maps of all terms, seen from an origin.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fogmaps(Vec<Placed>);

impl Closed for Fogmaps {
    fn places(&self, places: &mut Places) -> bool {
        for map in &self.0 {
            let plane = &map.whole;
            for (axis, k) in [(0, 0), (2, 1)] {
                let from = map.origin[k] + plane.start[k];
                let extent = (plane.size[k] + plane.degree) as f64 * plane.cell_m;
                // A row of cells is a bump two cells wide, of which straight lines take half a cell.
                places.add(axis, from, from + extent, (0.5 * plane.cell_m).max(extent / 48.0));
            }
            places.add_profile(map.profile, map.scale * plane.most());
        }
        true
    }

    fn is_nothing(&self) -> bool {
        self.0.is_empty()
    }

    fn seen_from(&self, origin: DVec3) -> Self {
        let seen = |map: &Placed| Placed {
            origin: [map.origin[0] - origin.x, map.origin[1] - origin.z],
            profile: map.profile.seen_from(origin.y),
            ..map.clone()
        };
        Self(self.0.iter().map(seen).collect())
    }

    fn whole(&self) -> Self {
        let whole = |map: &Placed| Placed { layers: Arc::default(), ..map.clone() };
        Self(self.0.iter().map(whole).collect())
    }

    fn until(&self, depth: f64) -> Self {
        let until = |map: &Placed| Placed { enough: depth, ..map.clone() };
        Self(self.0.iter().map(until).collect())
    }

    fn count(&self) -> usize {
        self.0.len()
    }

    fn cost(&self, way: DVec3) -> usize {
        let of_map = |map: &Placed| {
            let passed = (way.x.abs() + way.z.abs()) / map.whole.cell_m;
            1 + (passed as usize).min(map.whole.cells().iter().sum())
        };
        self.0.iter().map(of_map).sum()
    }

    #[inline(always)]
    fn at<N: Num>(&self, x: V3<N>) -> N {
        let mut sum = x.x.lit(0.0);
        for map in &self.0 {
            sum += map.at(x);
        }
        sum
    }

    #[inline(always)]
    fn mean<N: Num>(&self, a: V3<N>, b: V3<N>) -> N {
        let mut sum = a.x.lit(0.0);
        for map in &self.0 {
            sum += map.mean(a, b);
        }
        sum
    }

    #[inline(always)]
    fn view_mean<N: Num>(&self, a: V3<N>, b: V3<N>) -> N {
        let mut sum = a.x.lit(0.0);
        for map in &self.0 {
            sum += map.view_mean(a, b);
        }
        sum
    }

    #[inline(always)]
    fn beyond<N: Num>(&self, x: V3<N>, beyond: &Beyond) -> N {
        let mut sum = x.x.lit(0.0);
        for map in &self.0 {
            sum += map.beyond(x, beyond);
        }
        sum
    }

    fn is_cut(&self) -> bool {
        self.0.iter().any(|map| !map.layers.is_empty())
    }

    fn least_beta(&self) -> f64 {
        0.0
    }

    fn most_beta(&self) -> f64 {
        self.0.iter().map(|map| map.scale * map.whole.most()).sum()
    }

    fn uniform(&self) -> Option<f64> {
        self.is_nothing().then_some(0.0)
    }

    fn jumps(&self, start: DVec3, direction: DVec3, edge: &mut dyn FnMut(f64)) {
        let heights = self.0.iter().flat_map(|map| map.profile.edges());
        heights.for_each(|height| edge(crossing(height - start.y, direction.y)));
    }

    fn borders(&self, direction: DVec3, _length_m: f64, edge: &mut dyn FnMut(f64)) {
        /// Of more cells the masses are summed up anyway.
        const MOST: usize = 1024;
        for map in self.0.iter().filter(|map| map.whole.cells().iter().sum::<usize>() < MOST) {
            map.sides(0).for_each(|x| edge(crossing(x, direction.x)));
            map.sides(1).for_each(|z| edge(crossing(z, direction.z)));
        }
    }

    fn extent(&self, direction: DVec3, length_m: f64) -> Option<(f64, f64)> {
        hull(self.0.iter().filter_map(|map| map.extent(direction, length_m)))
    }

    fn is_rippled(&self) -> bool {
        true
    }

    fn ripple_m(&self, direction: DVec3, from: f64, to: f64) -> f64 {
        let of_map = |map: &Placed| {
            let (a, b) = map.extent(direction, to)?;
            (a < to && b > from).then(|| map.whole.cell_m / direction.x.hypot(direction.z))
        };
        self.0.iter().filter_map(of_map).fold(f64::INFINITY, f64::min)
    }

    fn words(&self, numbers: &mut Vec<f32>) -> Vec<Words> {
        let mut rows = Vec::new();
        for map in &self.0 {
            let whole = if map.layers.is_empty() { SEEN_BY_ALL } else { SEEN_BY_LIGHTS };
            rows.push(map.words(&map.whole, whole, 1.0, numbers));
            for (plane, share) in map.layers.iter() {
                rows.push(map.words(plane, SEEN_BY_EYES, *share, numbers));
            }
        }
        rows
    }

    fn size(&self) -> usize {
        let bytes = |plane: &Plane| 10 * plane.size[0] * plane.size[1];
        let of_map = |map: &Placed| {
            bytes(&map.whole) + map.layers.iter().map(|(plane, _)| bytes(plane)).sum::<usize>()
        };
        self.0.iter().map(of_map).sum()
    }
}

/// Who sees a row of the shader.
const SEEN_BY_ALL: f32 = 0.0;
const SEEN_BY_LIGHTS: f32 = 1.0;
const SEEN_BY_EYES: f32 = 2.0;

impl Placed {
    /// A plane as the shader reads it: its coefficients go to a list of their own.
    fn words(&self, plane: &Plane, seen: f32, share: f64, numbers: &mut Vec<f32>) -> Words {
        let first = numbers.len() as f32;
        numbers.extend(plane.values().map(|value| value as f32));
        let start = [0, 1].map(|k| (self.origin[k] + plane.start[k]) as f32);
        let [columns, rows] = plane.size.map(|size| size as f32);
        let profile = self.profile.row(self.scale);
        vec![
            Vec4::new(start[0], start[1], 1.0 / plane.cell_m as f32, plane.degree as f32),
            Vec4::new(columns, rows, first, share as f32),
            profile,
            Vec4::new(seen, plane.most() as f32, 0.0, 0.0),
        ]
    }
}
