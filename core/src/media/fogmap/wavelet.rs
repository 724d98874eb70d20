//! Mallat's decomposition of a map by biorthogonal B-spline wavelets (Cohen, Daubechies and Feauveau 1992): scaling
//! functions are the uniform B-splines of degree 0, 1 and 2, and the wavelets those of the pairs (1, 1), which is Haar's,
//! (2, 2) and (3, 1), whose filters are all finite, to either side. So a decomposition is lossless, of maps of any size:
//! what lies beside a map is zero, and the few coefficients that reach over its sides are kept.
//!
//! Two dimensions by the nonstandard way: rows and columns once a level, and again what is coarse in both.

/// Coefficients on a grid: its first place may lie beside the map's.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Column and row of the first coefficient.
    pub first: [i64; 2],
    /// Columns and rows.
    pub size: [usize; 2],
    /// Row by row.
    pub values: Vec<f64>,
}

/// A level of detail: what is fine along x, along z, and along both.
#[derive(Clone, Debug, PartialEq)]
pub struct Detail {
    /// The coefficients of ψφ, φψ and ψψ.
    pub parts: [Grid; 3],
}

/// Filter coefficients, from a place on.
#[derive(Clone, Copy, Debug)]
struct Filter {
    first: i64,
    values: &'static [f64],
}

/// The refinement of a B-spline: φ(x) = Σ p φ(2x − k).
const SCALING: [Filter; 3] = [
    Filter { first: 0, values: &[1.0, 1.0] },
    Filter { first: 0, values: &[0.5, 1.0, 0.5] },
    Filter { first: 0, values: &[0.25, 0.75, 0.75, 0.25] },
];
/// What is coarse of a signal: the dual filters.
const COARSE: [Filter; 3] = [
    Filter { first: 0, values: &[0.5, 0.5] },
    Filter { first: -1, values: &[-0.125, 0.25, 0.75, 0.25, -0.125] },
    Filter { first: 0, values: &[-0.25, 0.75, 0.75, -0.25] },
];
/// The wavelets: ψ(x) = Σ q φ(2x − k), q(k) = 2 (−1)^k coarse(1 − k).
const WAVELET: [Filter; 3] = [
    Filter { first: 0, values: &[1.0, -1.0] },
    Filter { first: -2, values: &[-0.25, -0.5, 1.5, -0.5, -0.25] },
    Filter { first: -2, values: &[-0.5, -1.5, 1.5, 0.5] },
];
/// What is fine of a signal: (−1)^k scaling(1 − k) / 2.
const FINE: [Filter; 3] = [
    Filter { first: 0, values: &[0.5, -0.5] },
    Filter { first: -1, values: &[-0.25, 0.5, -0.25] },
    Filter { first: -2, values: &[0.125, -0.375, 0.375, -0.125] },
];

impl Grid {
    /// A map's coefficients, row by row.
    pub fn new(size: [usize; 2], values: Vec<f64>) -> Self {
        Self { first: [0; 2], size, values }
    }

    fn get(&self, x: i64, z: i64) -> f64 {
        let [i, j] = [x - self.first[0], z - self.first[1]];
        let [columns, rows] = self.size.map(|size| size as i64);
        let is_there = (0..columns).contains(&i) && (0..rows).contains(&j);
        if is_there { self.values[(j * columns + i) as usize] } else { 0.0 }
    }

    /// Of every line along an axis another line: `reach` says from where to where.
    fn along(
        &self,
        axis: usize,
        [from, to]: [i64; 2],
        value: impl Fn(i64, &dyn Fn(i64) -> f64) -> f64,
    ) -> Self {
        let (mut first, mut size) = (self.first, self.size);
        (first[axis], size[axis]) = (from, (to - from) as usize);
        let mut values = Vec::with_capacity(size[0] * size[1]);
        for z in first[1]..first[1] + size[1] as i64 {
            for x in first[0]..first[0] + size[0] as i64 {
                let line = |k: i64| if axis == 0 { self.get(k, z) } else { self.get(x, k) };
                values.push(value(if axis == 0 { x } else { z }, &line));
            }
        }
        Self { first, size, values }
    }

    /// Σ f(k − 2m) c(k) for every m that it reaches.
    fn halved(&self, axis: usize, filter: Filter) -> Self {
        let Filter { first, values } = filter;
        let (low, high) = (self.first[axis], self.first[axis] + self.size[axis] as i64);
        let last = first + values.len() as i64 - 1;
        let ends = [-(last - low).div_euclid(2), (high - 1 - first).div_euclid(2) + 1];
        self.along(axis, ends, |m, line| {
            values.iter().zip(2 * m + first..).map(|(f, k)| f * line(k)).sum()
        })
    }

    /// Σ f(k − 2m) c(m) for every k that it reaches.
    pub fn doubled(&self, axis: usize, degree: usize, is_fine: bool) -> Self {
        let Filter { first, values } = if is_fine { WAVELET[degree] } else { SCALING[degree] };
        let (low, high) = (self.first[axis], self.first[axis] + self.size[axis] as i64);
        let ends = [2 * low + first, 2 * (high - 1) + first + values.len() as i64];
        self.along(axis, ends, |k, line| {
            let of = |(i, f): (usize, &f64)| {
                let twice = k - first - i as i64;
                if twice.rem_euclid(2) == 0 { f * line(twice / 2) } else { 0.0 }
            };
            values.iter().enumerate().map(of).sum()
        })
    }

    /// The sum of both.
    pub fn plus(&self, other: &Self) -> Self {
        let [first, end] = [0, 1].map(|axis| {
            let ends = [self, other].map(|grid| grid.first[axis] + grid.size[axis] as i64);
            [self.first[axis].min(other.first[axis]), ends[0].max(ends[1])]
        });
        let size = [(first[1] - first[0]) as usize, (end[1] - end[0]) as usize];
        let mut values = Vec::with_capacity(size[0] * size[1]);
        for z in end[0]..end[1] {
            values.extend((first[0]..first[1]).map(|x| self.get(x, z) + other.get(x, z)));
        }
        Self { first: [first[0], end[0]], size, values }
    }
}

/// What is coarse of a map, and its details from the coarsest level on.
pub fn decompose(map: &Grid, degree: usize, levels: usize) -> (Grid, Vec<Detail>) {
    let mut coarse = map.clone();
    let mut details = Vec::with_capacity(levels);
    for _ in 0..levels {
        let [low, high] = [COARSE[degree], FINE[degree]].map(|filter| coarse.halved(0, filter));
        let parts = [
            high.halved(1, COARSE[degree]),
            low.halved(1, FINE[degree]),
            high.halved(1, FINE[degree]),
        ];
        coarse = low.halved(1, COARSE[degree]);
        details.push(Detail { parts });
    }
    details.reverse();
    (coarse, details)
}

impl Detail {
    /// Its parts as B-splines of half the size, by the wavelets' two-scale relation.
    pub fn deconstructed(&self, degree: usize) -> [Grid; 3] {
        let fine = [[true, false], [false, true], [true, true]];
        let part =
            |i: usize| self.parts[i].doubled(0, degree, fine[i][0]).doubled(1, degree, fine[i][1]);
        [part(0), part(1), part(2)]
    }

    /// The same, merged.
    pub fn merged(&self, degree: usize) -> Grid {
        let [a, b, c] = self.deconstructed(degree);
        a.plus(&b).plus(&c)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(columns: usize, rows: usize) -> Grid {
        let value = |i: usize| ((i * 7919 + 13) % 101) as f64 / 100.0;
        Grid::new([columns, rows], (0..columns * rows).map(value).collect())
    }

    /// What was taken apart comes together again, to rounding, whatever the size and the number of levels.
    #[test]
    fn decomposition_is_lossless() {
        for degree in 0..3 {
            for (columns, rows, levels) in [(8, 8, 3), (5, 7, 2), (1, 1, 1), (13, 4, 4)] {
                let whole = map(columns, rows);
                let (mut sum, details) = decompose(&whole, degree, levels);
                assert_eq!(details.len(), levels);
                for detail in &details {
                    sum = sum.doubled(0, degree, false).doubled(1, degree, false);
                    sum = sum.plus(&detail.merged(degree));
                }
                for z in -9..rows as i64 + 9 {
                    for x in -9..columns as i64 + 9 {
                        let off = (sum.get(x, z) - whole.get(x, z)).abs();
                        assert!(off < 1e-12, "degree {degree}, {levels} levels: {off} at {x} {z}");
                    }
                }
            }
        }
    }

    /// Haar's coarse map has the means of squares.
    #[test]
    fn haar_keeps_means() {
        let whole = map(4, 4);
        let (coarse, details) = decompose(&whole, 0, 2);
        let mean = whole.values.iter().sum::<f64>() / 16.0;
        assert_eq!((coarse.size, details.len()), ([1, 1], 2));
        assert!((coarse.values[0] - mean).abs() < 1e-15);
    }

    /// Where a map is the same all around, or rises evenly, wavelets of linear splines see nothing.
    #[test]
    fn smooth_maps_have_no_detail_inside() {
        let values = (0..16 * 16).map(|i| 1.0 + (i % 16) as f64 * 0.25).collect();
        let (_, details) = decompose(&Grid::new([16, 16], values), 1, 1);
        for part in &details[0].parts {
            for z in 3..5 {
                for x in 3..5 {
                    assert!(part.get(x, z).abs() < 1e-14);
                }
            }
        }
    }
}
