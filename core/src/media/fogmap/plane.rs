//! A plane of B-splines: β(x, z) = Σ c φ(u − i) φ(w − j), u and w in cells, φ the uniform B-spline of a degree with
//! support [0, degree + 1] (Giroud and Biri 2010, eqs. 5 and 9).
//!
//! In a cell it is a polynomial, so that a Gauss rule integrates it exactly along a way: the way is followed cell
//! by cell, for all rays of a register at once. They walk along the axis that they pass most cells of, and in each
//! step meet the few cells that any of them crosses there. Cells without fog are skipped, squares of sixteen
//! cells at once.

use super::wavelet::Grid;
use crate::media::vertical::Profile;
use crate::num::Num;
use crate::quadrature::gauss_legendre;
use crate::vector::V3;
use std::sync::LazyLock;

/// Cells along the side of a square that is skipped as one.
const SQUARE: usize = 16;

/// Gauss's rules on [0, 1], nodes and weights, that integrate the polynomial of a cell exactly along a way: one of as many
/// nodes as degrees, and one.
const RULES: [&[(f64, f64)]; 3] = [
    &[(0.5, 1.0)],
    &[(0.211_324_865_405_187_13, 0.5), (0.788_675_134_594_812_9, 0.5)],
    &[
        (0.112_701_665_379_258_3, 5.0 / 18.0),
        (0.5, 4.0 / 9.0),
        (0.887_298_334_620_741_7, 5.0 / 18.0),
    ],
];
/// One for such with an exponential as a factor: to rounding while that falls by e⁴.
static WITH_EXPONENTIAL: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| {
    let (nodes, weights) = gauss_legendre(8);
    nodes.into_iter().zip(weights).collect()
});

/// A plane of B-splines, in cells from its first coefficient on.
#[derive(Debug, PartialEq)]
pub struct Plane {
    pub degree: usize,
    /// Where the first coefficient stands [m], from the map's origin.
    pub start: [f64; 2],
    pub cell_m: f64,
    /// Columns and rows of coefficients.
    pub size: [usize; 2],
    /// With as many zeros around them as the degree says: no cell asks for more.
    padded: Vec<f64>,
    /// Which cells hold any, and which squares of cells.
    filled: Vec<bool>,
    squares: Vec<bool>,
}

/// A way through a plane, in cells.
#[derive(Clone, Copy)]
pub struct Way<N> {
    /// Where it begins.
    pub start: [N; 2],
    /// To its end.
    pub step: [N; 2],
    /// 1 by that; as good as endless where it is level.
    inverse: [N; 2],
    /// Height of its beginning, and what it climbs [m].
    pub height: N,
    pub climb: N,
}

impl Plane {
    /// Of a grid whose map has cells of `cell_m`; its own are that times 2^`coarser`.
    pub fn new(grid: &Grid, degree: usize, cell_m: f64, coarser: u32) -> Self {
        let cell_m = cell_m * f64::from(1u32 << coarser);
        let start = grid.first.map(|first| first as f64 * cell_m);
        let cells = grid.size.map(|size| size + degree);
        let mut plane = Self {
            degree,
            start,
            cell_m,
            size: grid.size,
            padded: padded(grid, degree),
            filled: vec![false; cells[0] * cells[1]],
            squares: vec![false; cells[0].div_ceil(SQUARE) * cells[1].div_ceil(SQUARE)],
        };
        let across = cells[0].div_ceil(SQUARE);
        for (at, _) in grid.values.iter().enumerate().filter(|(_, value)| **value != 0.0) {
            let [i, j] = [at % grid.size[0], at / grid.size[0]];
            for w in j..=j + degree {
                for u in i..=i + degree {
                    plane.filled[w * cells[0] + u] = true;
                    plane.squares[w / SQUARE * across + u / SQUARE] = true;
                }
            }
        }
        plane
    }

    /// Columns and rows of cells.
    pub fn cells(&self) -> [usize; 2] {
        self.size.map(|size| size + self.degree)
    }

    /// The coefficients, row by row.
    pub fn values(&self) -> impl Iterator<Item = f64> {
        let ([columns, rows], edge) = (self.size, self.degree);
        let lines = self.padded.chunks(columns + 2 * edge).skip(edge).take(rows);
        lines.flat_map(move |line| line[edge..edge + columns].iter().copied())
    }

    /// The largest coefficient; no place has more.
    pub fn most(&self) -> f64 {
        self.values().fold(0.0, f64::max)
    }

    /// At a place in cells.
    pub fn at(&self, u: f64, w: f64) -> f64 {
        let cells = self.cells();
        if !(u >= 0.0 && w >= 0.0 && u < cells[0] as f64 && w < cells[1] as f64) {
            return 0.0;
        }
        let [i, j] = [u as usize, w as usize];
        let (u, w) = (u - i as f64, w - j as f64);
        match self.degree {
            0 => self.around::<0>(i, j).at(u, w),
            1 => self.around::<1>(i, j).at(u, w),
            _ => self.around::<2>(i, j).at(u, w),
        }
    }

    /// What there is in a cell.
    #[inline(always)]
    fn around<const D: usize>(&self, i: usize, j: usize) -> Cell<D> {
        let across = self.size[0] + 2 * D;
        let mut values = [[0.0; 3]; 3];
        for (b, row) in values.iter_mut().enumerate().take(D + 1) {
            row[..=D].copy_from_slice(&self.padded[(j + b) * across + i..][..=D]);
        }
        Cell { values }
    }

    /// The mean along a way, times the share at each height; what has reached `enough` may stay short of it.
    #[inline(always)]
    pub fn mean<N: Num>(&self, way: &Way<N>, profile: Profile, enough: N) -> N {
        match self.degree {
            0 => self.mean_of::<N, 0>(way, profile, enough),
            1 => self.mean_of::<N, 1>(way, profile, enough),
            _ => self.mean_of::<N, 2>(way, profile, enough),
        }
    }

    #[inline(always)]
    fn mean_of<N: Num, const D: usize>(&self, way: &Way<N>, profile: Profile, enough: N) -> N {
        let (zero, one) = (way.height.lit(0.0), way.height.lit(1.0));
        match profile {
            Profile::Uniform => self.between::<N, D>(way, [zero, one], None, enough),
            Profile::Slab { min, max } => {
                let ends = heights(way, zero.lit(min), zero.lit(max));
                self.between::<N, D>(way, ends, None, enough)
            }
            Profile::Exponential { base, falloff } => {
                const FAR: f64 = 1e30;
                let (low, high) = (zero.lit(base), zero.lit(FAR));
                let falls = Some([base, falloff]);
                self.between::<N, D>(way, heights(way, -high, low), None, enough)
                    + self.between::<N, D>(way, heights(way, low, high), falls, enough)
            }
        }
    }

    /// Between two shares of the way; a falloff above a height, if there is one.
    #[inline(always)]
    fn between<N: Num, const D: usize>(
        &self,
        way: &Way<N>,
        ends: [N; 2],
        falls: Option<[f64; 2]>,
        enough: N,
    ) -> N {
        let zero = way.height.lit(0.0);
        let mut sum = zero;
        let spans = [0, 1].map(|k| {
            let [low, high] = N::range(way.step[k].abs());
            low.max(high)
        });
        let major = usize::from(spans[1] > spans[0]);
        let cells = self.cells();
        let Some([first, last]) = reached(way, ends, major, cells[major]) else { return sum };
        let mut step = first;
        while step <= last {
            let square = (step / SQUARE * SQUARE + SQUARE - 1).min(last);
            if step % SQUARE == 0 {
                if !N::any(sum.lt(enough)) {
                    break;
                }
                if !self.is_filled(way, ends, major, [step, square]) {
                    step = square + 1;
                    continue;
                }
            }
            let own = cut(way, ends, major, [step as f64, (step + 1) as f64]);
            if N::any(own[0].lt(own[1]))
                && let Some([from, to]) = reached(way, own, 1 - major, cells[1 - major])
            {
                for other in from..=to {
                    let (i, j) = if major == 0 { (step, other) } else { (other, step) };
                    if self.filled[j * cells[0] + i] {
                        let own = cut(way, own, 1 - major, [other as f64, (other + 1) as f64]);
                        let cell = self.around::<D>(i, j);
                        sum += cell.along(way, own, [i as f64, j as f64], falls);
                    }
                }
            }
            step += 1;
        }
        sum
    }

    /// Whether a way may meet any fog in some steps of a square's side.
    #[inline(always)]
    fn is_filled<N: Num>(
        &self,
        way: &Way<N>,
        ends: [N; 2],
        major: usize,
        steps: [usize; 2],
    ) -> bool {
        let cells = self.cells();
        let own = cut(way, ends, major, [steps[0] as f64, (steps[1] + 1) as f64]);
        if !N::any(own[0].lt(own[1])) {
            return false;
        }
        let Some([from, to]) = reached(way, own, 1 - major, cells[1 - major]) else { return false };
        let across = cells[0].div_ceil(SQUARE);
        (from / SQUARE..=to / SQUARE).any(|other| {
            let at = steps[0] / SQUARE;
            let (i, j) = if major == 0 { (at, other) } else { (other, at) };
            self.squares[j * across + i]
        })
    }
}

/// A grid's coefficients, with as many zeros around them as the degree says.
fn padded(grid: &Grid, degree: usize) -> Vec<f64> {
    let [columns, rows] = grid.size.map(|size| size + 2 * degree);
    let mut padded = vec![0.0; columns * rows];
    for (j, line) in grid.values.chunks(grid.size[0]).enumerate() {
        padded[(j + degree) * columns + degree..][..line.len()].copy_from_slice(line);
    }
    padded
}

/// Between which shares of a way it lies between two heights.
#[inline(always)]
fn heights<N: Num>(way: &Way<N>, low: N, high: N) -> [N; 2] {
    within(way.height, inverse(way.climb), low, high, [low.lit(0.0), low.lit(1.0)])
}

/// 1 by what a way moves; if it is level, so little that it stays on its side.
#[inline(always)]
fn inverse<N: Num>(step: N) -> N {
    const LEVEL: f64 = 1e-30;
    let level = step.lit(LEVEL);
    step.lit(1.0) / N::select(step.abs().lt(level), level, step)
}

/// Between which of some shares a coordinate lies between two numbers, given 1 by what it moves.
#[inline(always)]
fn within<N: Num>(start: N, inverse: N, low: N, high: N, ends: [N; 2]) -> [N; 2] {
    let (a, b) = ((low - start) * inverse, (high - start) * inverse);
    let from = a.min(b).max(ends[0]).min(ends[1]);
    [from, a.max(b).min(ends[1]).max(from)]
}

#[inline(always)]
fn cut<N: Num>(way: &Way<N>, ends: [N; 2], axis: usize, [low, high]: [f64; 2]) -> [N; 2] {
    let like = way.height;
    within(way.start[axis], way.inverse[axis], like.lit(low), like.lit(high), ends)
}

/// The first and the last cell along an axis that ways touch between some of their shares; none if they
/// pass by.
#[inline(always)]
fn reached<N: Num>(way: &Way<N>, ends: [N; 2], axis: usize, cells: usize) -> Option<[usize; 2]> {
    let a = way.step[axis].mul_add(ends[0], way.start[axis]);
    let b = way.step[axis].mul_add(ends[1], way.start[axis]);
    let ([low, _], [_, high]) = (N::range(a.min(b)), N::range(a.max(b)));
    let is_there = high >= 0.0 && low < cells as f64;
    is_there.then(|| [low.max(0.0) as usize, (high as usize).min(cells - 1)])
}

/// The coefficients that count in a cell: of its last column and row, and of as many before as the degree says.
#[derive(Clone, Copy)]
struct Cell<const D: usize> {
    values: [[f64; 3]; 3],
}

impl<const D: usize> Cell<D> {
    /// At a place of the cell, from 0 to 1.
    #[inline(always)]
    fn at<N: Num>(&self, u: N, w: N) -> N {
        match D {
            0 => u.lit(self.values[0][0]),
            1 => {
                let [[a, b, _], [c, d, _], _] = self.values;
                let upper = u.mul_add(u.lit(b - a), u.lit(a));
                let lower = u.mul_add(u.lit(d - c), u.lit(c));
                w.mul_add(lower - upper, upper)
            }
            _ => {
                let across = quadratic(u);
                let [a, b, c] = [0, 1, 2].map(|j: usize| self.values[j]);
                let (a, b, c) = (row(across, a), row(across, b), row(across, c));
                let [x, y, z] = quadratic(w);
                x.mul_add(a, y.mul_add(b, z * c))
            }
        }
    }

    /// Its share of the mean along ways between two shares of them.
    #[inline(always)]
    fn along<N: Num>(
        &self,
        way: &Way<N>,
        [from, to]: [N; 2],
        corner: [f64; 2],
        falls: Option<[f64; 2]>,
    ) -> N {
        let Some([base, falloff]) = falls else {
            if D == 0 {
                return (to - from) * from.lit(self.values[0][0]);
            }
            return self.by_rule(way, [from, to], corner, RULES[D], None);
        };
        /// Exponents behind which nothing is left, and what a rule takes.
        const GONE: f64 = 40.0;
        const TAKEN: f64 = 4.0;
        let zero = from.lit(0.0);
        let rate = way.climb.abs() * from.lit(falloff);
        let reach = from.lit(GONE) / rate.max(from.lit(1e-30));
        let rises = zero.lt(way.climb);
        let end = N::select(rises, to.min(from + reach), to);
        let begin = N::select(rises, from, from.max(to - reach));
        let [_, exponent] = N::range((end - begin) * rate);
        let parts = (exponent / TAKEN).ceil().max(1.0);
        let step = (end - begin) * zero.lit(1.0 / parts);
        let mut sum = zero;
        let mut i = 0.0;
        while i < parts {
            let here = step.mul_add(zero.lit(i), begin);
            let ends = [here, here + step];
            sum += self.by_rule(way, ends, corner, &WITH_EXPONENTIAL, Some([base, falloff]));
            i += 1.0;
        }
        sum
    }

    #[inline(always)]
    fn by_rule<N: Num>(
        &self,
        way: &Way<N>,
        [from, to]: [N; 2],
        corner: [f64; 2],
        rule: &[(f64, f64)],
        falls: Option<[f64; 2]>,
    ) -> N {
        let length = to - from;
        let (u, w) = (way.start[0] - from.lit(corner[0]), way.start[1] - from.lit(corner[1]));
        let mut sum = from.lit(0.0);
        for (node, weight) in rule {
            let at = length.mul_add(from.lit(*node), from);
            let mut value = self.at(way.step[0].mul_add(at, u), way.step[1].mul_add(at, w));
            if let Some([base, falloff]) = falls {
                let above = way.climb.mul_add(at, way.height) - at.lit(base);
                value = value * (-(above.max(at.lit(0.0)) * at.lit(falloff))).exp();
            }
            sum = value.mul_add(at.lit(*weight), sum);
        }
        sum * length
    }
}

/// The three quadratic B-splines of a cell.
#[inline(always)]
fn quadratic<N: Num>(f: N) -> [N; 3] {
    let (one, half) = (f.lit(1.0), f.lit(0.5));
    let rest = one - f;
    let (first, last) = (rest.squared() * half, f.squared() * half);
    [first, one - first - last, last]
}

#[inline(always)]
fn row<N: Num>([x, y, z]: [N; 3], [a, b, c]: [f64; 3]) -> N {
    x.mul_add(x.lit(a), y.mul_add(x.lit(b), z * x.lit(c)))
}

impl<N: Num> Way<N> {
    /// Between two points, seen by a plane whose first coefficient stands there [m].
    #[inline(always)]
    pub fn new(a: V3<N>, b: V3<N>, [x, z]: [f64; 2], cell_m: f64) -> Self {
        let rate = a.x.lit(1.0 / cell_m);
        let step = [(b.x - a.x) * rate, (b.z - a.z) * rate];
        Self {
            start: [(a.x - a.x.lit(x)) * rate, (a.z - a.x.lit(z)) * rate],
            step,
            inverse: [inverse(step[0]), inverse(step[1])],
            height: a.y,
            climb: b.y - a.y,
        }
    }

    /// Its beginning, as a share.
    #[inline(always)]
    pub fn first(self, share: f64) -> Self {
        let share = self.height.lit(share);
        let step = [self.step[0] * share, self.step[1] * share];
        Self {
            step,
            inverse: [inverse(step[0]), inverse(step[1])],
            climb: self.climb * share,
            ..self
        }
    }
}
