//! Quadrature: adaptive Gauss–Kronrod, and Gauss–Legendre rules.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::f64::consts::PI;

/// Nodes of the 15-point Kronrod rule on [−1, 1]; the odd places are the 7 Gauss nodes.
const NODES: [f64; 8] = [
    0.991_455_371_120_812_6,
    0.949_107_912_342_758_5,
    0.864_864_423_359_769_1,
    0.741_531_185_599_394_4,
    0.586_087_235_467_691_1,
    0.405_845_151_377_397_2,
    0.207_784_955_007_898_47,
    0.0,
];
const KRONROD: [f64; 8] = [
    0.022_935_322_010_529_224,
    0.063_092_092_629_978_55,
    0.104_790_010_322_250_18,
    0.140_653_259_715_525_92,
    0.169_004_726_639_267_9,
    0.190_350_578_064_785_41,
    0.204_432_940_075_298_89,
    0.209_482_141_084_727_83,
];
const GAUSS: [f64; 4] = [
    0.129_484_966_168_869_7,
    0.279_705_391_489_276_64,
    0.381_830_050_505_118_9,
    0.417_959_183_673_469_4,
];

/// Bound on refinement: an integrand this rough is answered as well as it can be.
const MOST_PANELS: usize = 8192;

struct Panel {
    from: f64,
    to: f64,
    value: f64,
    error: f64,
}

impl PartialEq for Panel {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Panel {}
impl PartialOrd for Panel {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Panel {
    fn cmp(&self, other: &Self) -> Ordering {
        self.error.total_cmp(&other.error)
    }
}

/// ∫ f over consecutive panels with the given `ends`, until the estimated error is below
/// `relative` of the sum.
pub fn adaptive(ends: &[f64], relative: f64, mut f: impl FnMut(f64) -> f64) -> f64 {
    let mut panels: BinaryHeap<Panel> =
        ends.windows(2).map(|pair| kronrod(pair[0], pair[1], &mut f)).collect();
    loop {
        let value: f64 = panels.iter().map(|p| p.value).sum();
        let error: f64 = panels.iter().map(|p| p.error).sum();
        // Halve the worst ones in one go: summing anew after each would cost more than it saves.
        let goal = relative * value.abs();
        if error <= goal || panels.len() > MOST_PANELS {
            return value;
        }
        for _ in 0..panels.len().div_ceil(4) {
            let Some(worst) = panels.pop() else { break };
            let middle = 0.5 * (worst.from + worst.to);
            panels.push(kronrod(worst.from, middle, &mut f));
            panels.push(kronrod(middle, worst.to, &mut f));
        }
    }
}

fn kronrod(from: f64, to: f64, f: &mut impl FnMut(f64) -> f64) -> Panel {
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    let center = f(middle);
    let mut fine = KRONROD[7] * center;
    let mut coarse = GAUSS[3] * center;
    for i in 0..7 {
        let pair = f(middle - half * NODES[i]) + f(middle + half * NODES[i]);
        fine += KRONROD[i] * pair;
        if i % 2 == 1 {
            coarse += GAUSS[i / 2] * pair;
        }
    }
    // QUADPACK's rescaling in its simplest form: the pair's difference overstates the error of
    // the finer rule by far once it is small.
    let difference = (fine - coarse).abs();
    let scaled = if fine == 0.0 { 0.0 } else { (200.0 * difference / fine.abs()).powf(1.5) };
    Panel { from, to, value: half * fine, error: (half * fine).abs() * scaled.min(1.0) }
}

/// Abscissae and weights of the `n`-point Gauss–Legendre rule on [0, 1].
pub fn gauss_legendre(n: usize) -> (Vec<f64>, Vec<f64>) {
    let size = n as f64;
    let node = |i: usize| {
        let mut x = (PI * (i as f64 + 0.75) / (size + 0.5)).cos();
        let mut slope = 1.0;
        // Newton from there converges to rounding in four steps.
        for _ in 0..6 {
            let (mut before, mut legendre) = (1.0, x);
            for k in 2..=n {
                let k = k as f64;
                let next = ((2.0 * k - 1.0) * x * legendre - (k - 1.0) * before) / k;
                (before, legendre) = (legendre, next);
            }
            slope = size * (x * legendre - before) / (x * x - 1.0);
            x -= legendre / slope;
        }
        (0.5 - 0.5 * x, 1.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..n).map(node).unzip()
}

#[cfg(test)]
mod tests {
    use super::adaptive;

    /// A narrow peak far from any first node, and an integrable edge.
    #[test]
    fn rough_integrands_converge() {
        let peak = |x: f64| 1.0 / (1e-6 + (x - 0.123) * (x - 0.123));
        let exact = 1e3 * ((0.877e3f64).atan() + (0.123e3f64).atan());
        assert!((adaptive(&[0.0, 1.0], 1e-9, peak) / exact - 1.0).abs() < 1e-8);
        assert!((adaptive(&[0.0, 1.0], 1e-8, f64::sqrt) - 2.0 / 3.0).abs() < 1e-7);
    }
}
