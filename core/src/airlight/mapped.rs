//! Airlight by one Gauss rule over the whole ray, in a variable that is smooth wherever the
//! integrand β e^(−T(v,x)−T(x,s)) / d² is: any sum of media, any place of the light, any phase
//! function.
//!
//! The variable mixes three maps of the ray, each of which spreads the nodes evenly over one cause
//! of variation: the angle seen from the light (1/d² becomes constant), the medium that is seen and
//! lit (error functions around its lumps), and plain distance. In the mixture the integrand is
//! smooth, and a Gauss–Legendre rule converges exponentially with its nodes.
//!
//! β and both optical depths are exact at the nodes. Measured against
//! [`reference`](mod@super::reference) the error is below 0.1 % at the median on smooth and patchy
//! fog, and below 5 % next to the light. Fog that is thin against the distance between nodes, and
//! does not overlap with other fog on the ray, is what it resolves worst.

use super::ToLight;
use super::path::Path;
use crate::media::Field;
use crate::phase::Phase;
use crate::quadrature::gauss_legendre;
use glam::DVec3;
use std::f64::consts::FRAC_2_SQRT_PI;
use std::sync::LazyLock;

/// Nodes of the rule.
pub const NODES: usize = 48;
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

static GAUSS: LazyLock<([f64; NODES], [f64; NODES])> = LazyLock::new(gauss_legendre);

/// Quadrature nodes along a ray.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    /// Ray parameters, ascending [m].
    pub t: [f64; NODES],
    /// Weights [m].
    pub weight: [f64; NODES],
}

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
        Self { from, to, closest: light.closest, angles, steps, even_weight }
    }

    /// q(t), up to a constant, and dq/dt.
    fn value(&self, t: f64) -> (f64, f64) {
        let (mut q, mut slope) = (self.even_weight * t, self.even_weight);
        for Angle { miss, weight } in &self.angles {
            let s = (t - self.closest) / miss;
            q += weight * s.atan();
            slope += weight / (miss * (1.0 + s * s));
        }
        for Step { mean, scale, weight } in &self.steps {
            let x = (t - mean) * scale;
            q += weight * libm::erf(x);
            slope += weight * scale * FRAC_2_SQRT_PI * (-x * x).exp();
        }
        (q, slope)
    }

    /// The Gauss–Legendre rule in q.
    pub fn rule(&self) -> Rule {
        let mut rule = Rule { t: [0.0; NODES], weight: [0.0; NODES] };
        let start = self.value(self.from).0;
        let mut low = self.from;
        for j in 0..NODES {
            let (t, slope) = self.solve(start + GAUSS.0[j], low);
            rule.t[j] = t;
            rule.weight[j] = GAUSS.1[j] / slope;
            low = t;
        }
        rule
    }

    /// t with q(t) = `q`, and dq/dt there; bisection guards Newton's steps.
    fn solve(&self, q: f64, mut low: f64) -> (f64, f64) {
        let mut high = self.to;
        let mut t = low;
        let mut slope = 0.0;
        for _ in 0..64 {
            let value;
            (value, slope) = self.value(t);
            if value < q {
                low = t;
            } else {
                high = t;
            }
            let newton = t - (value - q) / slope;
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            // The weight belongs to t as it is; where t lies matters little.
            if (next - t).abs() <= 1e-6 / slope {
                break;
            }
            t = next;
        }
        (t, slope)
    }
}

/// L_a per unit of ω·I₀ [1/m²] of a light, along a ray in the unit `direction` up to `length` [m].
pub fn airlight(
    field: &Field,
    phase: Phase,
    light: DVec3,
    origin: DVec3,
    direction: DVec3,
    length: f64,
) -> f64 {
    let path = Path::new(field, light, origin, direction, length);
    let Some((from, to)) = path.span(length) else { return 0.0 };
    let to = path.reaches(OPAQUE, from, to);
    if to - from <= SHORTEST {
        return 0.0;
    }
    let seen = |t: f64| {
        let lit = path.lit(t);
        let through = (-path.depth(t) - lit.depth).exp();
        (path.extinction(t) * phase.value(lit.cos) * through, lit.distance)
    };
    let probes = Probes::new(from, to, path.dense(length), &path.to_light);
    let monitor = probes.at.map(|t| seen(t).0.sqrt());
    let Rule { t, weight } = Map::new(phase, from, to, path.to_light, &probes, &monitor).rule();
    let node = |j: usize| {
        let (value, distance) = seen(t[j]);
        weight[j] * value / (distance * distance)
    };
    (0..NODES).map(node).sum()
}
