//! How far a polynomial falls on the unit cube: the least of its coefficients in Bernstein's basis is a bound from
//! below, and the closer the smaller the part of the cube.

use super::monomial::Monomial;

/// A bound of a polynomial on the unit cube from below, near its least value: the least of its coefficients
/// in Bernstein's basis, of halves of the cube where that helps.
pub fn least_of(monomials: &[Monomial]) -> f64 {
    /// Coefficients that are looked at.
    const MOST: usize = 20_000;
    let whole = Tensor::new(monomials);
    let boxes = (MOST / whole.values.len()).clamp(8, 256);
    let mut least = whole.corners();
    let mut open = vec![(whole.bound(), whole)];
    for turn in 0..boxes {
        open.sort_by(|a, b| b.0.total_cmp(&a.0));
        let Some((bound, tensor)) = open.pop() else { break };
        if bound >= least {
            open.push((bound, tensor));
            break;
        }
        for half in tensor.halves(turn % 3) {
            least = least.min(half.corners());
            open.push((half.bound(), half));
        }
    }
    open.iter().map(|(bound, _)| *bound).fold(least, f64::min)
}

/// The same polynomial in 2u − 1 on every axis.
pub fn centred(monomials: &[Monomial]) -> Vec<Monomial> {
    /// What rounding leaves of a coefficient that is none.
    const NOTHING: f64 = 1e-14;
    // u^p = 2^(−p) Σ C(p, k) s^k.
    let change = |line: &[f64]| -> Vec<f64> {
        let of = |k: usize| {
            (k..line.len()).map(|p| line[p] * binomial(p, k) * 0.5f64.powi(p as i32)).sum()
        };
        (0..line.len()).map(of).collect()
    };
    let whole = Tensor::new(monomials);
    let most = whole.values.iter().fold(0.0f64, |most, value| most.max(value.abs()));
    let Tensor { size, values } = [0, 1, 2].iter().fold(whole, |t, k| t.along(*k, change));
    let there = values.iter().enumerate().filter(|(_, value)| value.abs() > NOTHING * most);
    let monomial = |(i, coefficient): (usize, &f64)| {
        let powers = [i / (size[1] * size[2]), i / size[2] % size[1], i % size[2]];
        Monomial { powers: powers.map(|power| power as u8), coefficient: *coefficient }
    };
    there.map(monomial).collect()
}

/// A polynomial's coefficients by its three powers.
struct Tensor {
    size: [usize; 3],
    values: Vec<f64>,
}

impl Tensor {
    fn new(monomials: &[Monomial]) -> Self {
        let most = |k: usize| monomials.iter().map(|one| usize::from(one.powers[k])).max();
        let size = [0, 1, 2].map(|k| most(k).unwrap_or(0) + 1);
        let mut values = vec![0.0; size.iter().product()];
        for Monomial { powers, coefficient } in monomials {
            let [p, q, r] = powers.map(usize::from);
            values[(p * size[1] + q) * size[2] + r] += coefficient;
        }
        Self { size, values }
    }

    /// All lines of coefficients along an axis, changed.
    fn along(&self, axis: usize, change: impl Fn(&[f64]) -> Vec<f64>) -> Self {
        let stride: usize = self.size[axis + 1..].iter().product();
        let mut values = self.values.clone();
        for first in (0..values.len()).filter(|i| (i / stride).is_multiple_of(self.size[axis])) {
            let line: Vec<_> = (0..self.size[axis]).map(|i| values[first + i * stride]).collect();
            for (i, value) in change(&line).into_iter().enumerate() {
                values[first + i * stride] = value;
            }
        }
        Self { size: self.size, values }
    }

    /// The least coefficient in Bernstein's basis.
    fn bound(&self) -> f64 {
        let bernstein = |line: &[f64]| -> Vec<f64> {
            let n = line.len() - 1;
            let share = |j: usize, i: usize| binomial(j, i) / binomial(n, i);
            (0..=n).map(|j| (0..=j).map(|i| share(j, i) * line[i]).sum()).collect()
        };
        let all =
            [0, 1, 2].iter().fold(self.along(0, <[f64]>::to_vec), |t, k| t.along(*k, bernstein));
        all.values.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// The least value at the cube's corners.
    fn corners(&self) -> f64 {
        let at = |corner: usize| {
            let is_far = |k: usize| corner >> k & 1 == 1;
            let place = |i: usize| {
                [
                    i / (self.size[1] * self.size[2]),
                    i / self.size[2] % self.size[1],
                    i % self.size[2],
                ]
            };
            let counts = |i: &usize| (0..3).all(|k| is_far(k) || place(*i)[k] == 0);
            (0..self.values.len()).filter(counts).map(|i| self.values[i]).sum::<f64>()
        };
        (0..8).map(at).fold(f64::INFINITY, f64::min)
    }

    /// Both halves along an axis, each on a cube of its own.
    fn halves(&self, axis: usize) -> [Self; 2] {
        let lower = self.along(axis, |line| {
            line.iter().enumerate().map(|(i, c)| c * 0.5f64.powi(i as i32)).collect()
        });
        // The lower half continued by one.
        let upper = lower.along(axis, |line| {
            let n = line.len();
            (0..n).map(|j| (j..n).map(|i| binomial(i, j) * line[i]).sum()).collect()
        });
        [lower, upper]
    }
}

fn binomial(n: usize, k: usize) -> f64 {
    (0..k).map(|i| (n - i) as f64 / (i + 1) as f64).product()
}
