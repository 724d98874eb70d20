//! Airlight by one Gauss rule over the whole ray, in a variable that is smooth wherever the
//! integrand β e^(−T(v,x)−T(x,s)) / d² is: any sum of media, any place of the light, any phase
//! function.
//!
//! The variable mixes three maps of the ray, each of which spreads the nodes evenly over one cause
//! of variation: the angle seen from the light (1/d² becomes constant), the medium that is seen and
//! lit (error functions around its lumps), and plain distance. In the mixture the integrand is
//! smooth, and a Gauss–Legendre rule converges exponentially with its nodes: 16 do for most rays.
//!
//! β and both optical depths are exact at the nodes. The number of nodes doubles until two rules
//! agree, and until the rule meets ∫ β e^(−T) dt = 1 − e^(−T), of which the answer is known: that
//! shows fog that stands unseen between the nodes.

use super::ToLight;
use super::path::Path;
use crate::num::Num;
use crate::phase::Phase;
use crate::quadrature::gauss_legendre;
use std::f64::consts::FRAC_2_SQRT_PI;
use std::sync::LazyLock;

/// Nodes of the rules that are tried, one after the other.
pub const SIZES: [usize; 6] = [16, 32, 64, 128, 256, 512];
/// Places along a ray where the medium is looked at before the nodes are placed.
pub const PROBES: usize = 32;
/// Share of the nodes that the light's map places.
const LIGHT_SHARE: f64 = 0.45;
/// Share of the nodes that lie evenly.
const EVEN_SHARE: f64 = 0.1;
/// No ray is shorter [m]: the square of its part must not vanish.
const SHORTEST: f64 = 1e-100;
/// Optical depth behind which nothing is seen: e⁻²⁴.
pub const OPAQUE: f64 = 24.0;

/// Relative difference of two rules that agree along a single ray.
const AGREE: f64 = 1e-4;
/// What a rule may miss of the light that fog scatters or absorbs, ∫ β e^(−T) dt.
const UNMET: f64 = 0.03;

/// Gauss–Legendre abscissae and weights on [0, 1], one pair for each of [`SIZES`].
static GAUSS: LazyLock<Vec<(Vec<f64>, Vec<f64>)>> =
    LazyLock::new(|| SIZES.map(gauss_legendre).into());

/// Fog that lies together on a ray.
#[derive(Clone, Copy, Debug)]
struct Lump {
    mass: f64,
    mean: f64,
    variance: f64,
}

impl Lump {
    fn join(self, other: Self) -> Self {
        let mass = self.mass + other.mass;
        if mass <= 0.0 {
            return self;
        }
        let (p, q) = (self.mass / mass, other.mass / mass);
        let apart = self.mean - other.mean;
        Self {
            mass,
            mean: p * self.mean + q * other.mean,
            variance: p * self.variance + q * other.variance + p * q * apart * apart,
        }
    }
}

/// The two neighbouring groups with the least variance within; one of them may be empty.
fn group(cells: &[Lump; PROBES]) -> [Lump; 2] {
    const NONE: Lump = Lump { mass: 0.0, mean: 0.0, variance: 0.0 };
    let mut after = [NONE; PROBES + 1];
    for i in (0..PROBES).rev() {
        after[i] = cells[i].join(after[i + 1]);
    }
    let within = |lump: &Lump| lump.mass * lump.variance;
    let mut best = [NONE, after[0]];
    let mut before = NONE;
    for i in 0..PROBES {
        before = before.join(cells[i]);
        if within(&before) + within(&after[i + 1]) < within(&best[0]) + within(&best[1]) {
            best = [before, after[i + 1]];
        }
    }
    best
}

/// One lump's share of the map: `weight` · erf((t − mean) · scale).
#[derive(Clone, Copy, Debug)]
struct Step {
    mean: f64,
    scale: f64,
    weight: f64,
}

/// One angle's share of the map: `weight` · atan((t − closest)/`miss`).
#[derive(Clone, Copy, Debug)]
struct Angle {
    miss: f64,
    weight: f64,
}

/// The map t → q from a piece of a ray to [0, 1] in which the integrand is smooth.
#[derive(Clone, Debug)]
pub struct Map {
    from: f64,
    to: f64,
    /// What the maps below amount to at `from`.
    start: f64,
    closest: f64,
    angles: Vec<Angle>,
    steps: Vec<Step>,
    even_weight: f64,
}

/// Where the medium on a piece of a ray is looked at: the middles of parts that are short where fog
/// lies or the light is near.
#[derive(Clone, Copy, Debug)]
pub struct Probes {
    /// Ray parameters [m].
    pub at: [f64; PROBES],
    /// Lengths of the parts [m].
    width: [f64; PROBES],
}

impl Probes {
    /// For a piece of a ray of which a part may hold more fog than the rest.
    pub fn new(from: f64, to: f64, dense: Option<(f64, f64)>, light: &ToLight<f64>) -> Self {
        let mut ends = [to; PROBES + 1];
        let (low, high) = dense.map_or((from, to), |(a, b)| (a.clamp(from, to), b.clamp(from, to)));
        let angle = |t: f64| ((t - light.closest) / light.miss).atan();
        let (first, last) = (angle(from), angle(to));
        for (i, end) in ends.iter_mut().enumerate() {
            let share = (i / 4) as f64 / (PROBES / 4) as f64;
            let seen = light.closest + light.miss * (first + share * (last - first)).tan();
            *end = match i % 4 {
                0 => from + (to - from) * share,
                1 => seen.clamp(from, to),
                _ => low + (high - low) * ((i / 4 * 2 + i % 2) as f64 + 0.5) / (PROBES / 2) as f64,
            };
        }
        (ends[0], ends[PROBES]) = (from, to);
        ends.sort_unstable_by(f64::total_cmp);
        Self {
            at: std::array::from_fn(|i| 0.5 * (ends[i] + ends[i + 1])),
            width: std::array::from_fn(|i| ends[i + 1] - ends[i]),
        }
    }
}

impl Map {
    /// For a piece of a ray, given √(k(α) β e^(−T(v,x)−T(x,s))) up to a factor at its probes.
    pub fn new(
        phase: Phase,
        from: f64,
        to: f64,
        light: ToLight<f64>,
        probes: &Probes,
        seen: &[f64; PROBES],
    ) -> Self {
        let cell = |i: usize| {
            let (mean, width) = (probes.at[i], probes.width[i]);
            Lump { mass: seen[i] * width, mean, variance: width * width / 6.0 }
        };
        let mut lumps = group(&std::array::from_fn(cell)).to_vec();
        lumps.retain(|lump| lump.mass > 0.0 && lump.variance > 0.0);
        let total: f64 = lumps.iter().map(|lump| lump.mass).sum();
        let medium_share = 1.0 - LIGHT_SHARE - EVEN_SHARE;
        let step = |lump: &Lump| {
            let scale = 1.0 / (2.0 * lump.variance).sqrt();
            let range = libm::erf((to - lump.mean) * scale) - libm::erf((from - lump.mean) * scale);
            let weight = medium_share * lump.mass / total / range;
            Step { mean: lump.mean, scale, weight }
        };
        let steps: Vec<_> = lumps.iter().map(step).collect();
        let even_share = EVEN_SHARE + if steps.is_empty() { medium_share } else { 0.0 };
        // A narrow phase function prefers points from where the light stands straight ahead.
        let wide = light.miss / (1.0 - phase.g.abs());
        let share = if phase.is_isotropic() { LIGHT_SHARE } else { 0.5 * LIGHT_SHARE };
        let angle = |miss: f64| {
            let at = |t: f64| ((t - light.closest) / miss).atan();
            Angle { miss, weight: share / (at(to) - at(from)).max(f64::MIN_POSITIVE) }
        };
        let mut angles = vec![angle(light.miss)];
        angles.extend((!phase.is_isotropic()).then(|| angle(wide)));
        let even_weight = even_share / (to - from);
        let mut map =
            Self { from, to, start: 0.0, closest: light.closest, angles, steps, even_weight };
        map.start = map.value(from).0;
        map
    }

    /// q(t) and dq/dt.
    #[inline(always)]
    fn value<N: Num>(&self, t: N) -> (N, N) {
        let mut slope = t.lit(self.even_weight);
        let mut q = (t - t.lit(self.from)) * slope - t.lit(self.start);
        for Angle { miss, weight } in &self.angles {
            let s = (t - t.lit(self.closest)) * t.lit(1.0 / miss);
            q = t.lit(*weight).mul_add(s.atan(), q);
            slope += t.lit(weight / miss) / s.mul_add(s, t.lit(1.0));
        }
        for Step { mean, scale, weight } in &self.steps {
            let x = (t - t.lit(*mean)) * t.lit(*scale);
            q = t.lit(*weight).mul_add(x.erf(), q);
            let peak = t.lit(weight * scale * FRAC_2_SQRT_PI);
            slope = peak.mul_add((-x.squared()).exp(), slope);
        }
        (q, slope)
    }

    /// t with q(t) = `q`, and dq/dt there; bisection guards Newton's steps.
    #[inline(always)]
    pub fn solve<N: Num>(&self, q: N) -> (N, N) {
        let (mut low, mut high) = (q.lit(self.from), q.lit(self.to));
        let mut t = q.mul_add(high - low, low);
        let (mut value, mut slope) = self.value(t);
        for _ in 0..64 {
            let below = value.lt(q);
            low = N::select(below, t, low);
            high = N::select(below, high, t);
            let middle = (low + high) * q.lit(0.5);
            let newton = t - (value - q) / slope;
            let next = N::select(newton.lt(high), newton, middle);
            let next = N::select(low.lt(next), next, middle);
            // The weight belongs to t as it is; where t lies matters little.
            if !N::any(q.lit(1e-5).lt((next - t).abs() * slope)) {
                break;
            }
            t = next;
            (value, slope) = self.value(t);
        }
        (t, slope)
    }
}

/// L_a per unit of ω·I₀ [1/m²] of the path's light.
pub(crate) fn airlight_along(path: &Path, phase: Phase) -> f64 {
    let Some((from, to)) = path.span() else { return 0.0 };
    let to = path.reaches(OPAQUE, from, to);
    if to - from <= SHORTEST {
        return 0.0;
    }
    let seen = |t: f64| {
        let lit = path.lit(t);
        let through = (-path.depth(t) - lit.depth).exp();
        (path.extinction(t) * phase.value(lit.cos) * through, lit.distance)
    };
    let probes = Probes::new(from, to, path.dense(), &path.to_light);
    let monitor = probes.at.map(|t| seen(t).0.sqrt());
    let map = Map::new(phase, from, to, path.to_light, &probes, &monitor);
    let (before, behind) = (path.depth(from), path.depth(to));
    let removed = (-before).exp() * -(before - behind).exp_m1();
    let mut coarse = f64::INFINITY;
    for (nodes, weights) in GAUSS.iter() {
        let (mut sum, mut met) = (0.0, 0.0);
        for (q, weight) in nodes.iter().zip(weights) {
            let (t, slope) = map.solve(*q);
            let (value, distance) = seen(t);
            sum += weight / slope * value / (distance * distance);
            met += weight / slope * path.extinction(t) * (-path.depth(t)).exp();
        }
        let agree = (sum - coarse).abs() <= AGREE * sum;
        coarse = sum;
        if agree && (met - removed).abs() <= UNMET * removed {
            break;
        }
    }
    coarse
}
