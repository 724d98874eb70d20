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

use super::about::{About, Exactness, PICTURES};
use super::massed;
use super::path::Path;
use crate::light::ToLight;
use crate::num::Num;
use crate::phase::PhaseFunction;
use crate::quadrature::gauss_legendre;
use std::f64::consts::FRAC_2_SQRT_PI;
use std::sync::LazyLock;

/// What is said about it.
pub const ABOUT: About = About {
    source: "Sun 2005 in isotropic homogeneous fog; else one Gauss rule per ray in a variable that \
        is smooth near lights and where fog lies, with exact β and T.",
    takes: None,
    error: Exactness::measured(PICTURES, [1.9e-6, 6.5e-5, 1.8e-2]),
};

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

/// More sections than this are one, of which the masses of its parts are summed up.
const MOST_SECTIONS: usize = 32;

/// Relative difference of two rules that agree along a single ray.
const AGREE: f64 = 1e-4;
/// What a rule may miss of the light that blobs scatter or absorb, ∫ β e^(−T) dt.
const UNMET: f64 = 3e-4;

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

/// A bump's share of the map: `weight` · erf((x − mean) · scale), counted from x = 0, where the piece
/// begins.
#[derive(Clone, Copy, Debug)]
struct Step {
    mean: f64,
    scale: f64,
    weight: f64,
    start: f64,
}

impl Step {
    /// For a bump of that middle and width, √2 standard deviations, on a piece from 0 to `end`.
    fn new(mean: f64, width: f64, share: f64, end: f64) -> Self {
        let scale = 1.0 / width;
        let start = libm::erf(-mean * scale);
        let range = libm::erf((end - mean) * scale) - start;
        Self { mean, scale, weight: share / range.max(f64::MIN_POSITIVE), start }
    }

    /// Its part of q, and the slope of that.
    #[inline(always)]
    fn value<N: Num>(&self, x: N) -> (N, N) {
        let x = (x - x.lit(self.mean)) * x.lit(self.scale);
        let peak = x.lit(self.weight * self.scale * FRAC_2_SQRT_PI);
        ((x.erf() - x.lit(self.start)) * x.lit(self.weight), (-x.squared()).exp() * peak)
    }
}

/// The angle at a light that a ray turns through, from where a piece of it begins.
#[derive(Clone, Copy, Debug)]
struct Angle {
    /// Distance of the light from the ray's line [m].
    miss: f64,
    /// From the point closest to the light to where the piece begins [m].
    ahead: f64,
}

impl Angle {
    /// The angle [rad] a `way` [m] behind the beginning, and its slope [rad/m]. No difference of two
    /// angles: a light far away sees all of a ray under a tiny one.
    #[inline(always)]
    fn value<N: Num>(&self, way: N) -> (N, N) {
        let (miss, ahead) = (way.lit(self.miss), way.lit(self.ahead));
        let there = way + ahead;
        let miss2 = miss.squared();
        let angle = N::angle(miss * way, ahead.mul_add(there, miss2));
        (angle, miss / there.mul_add(there, miss2))
    }
}

/// The map t → q from a piece of a ray to [0, 1] in which the integrand is smooth.
#[derive(Clone, Debug)]
pub struct Map {
    from: f64,
    to: f64,
    /// As the light stands; the medium's steps lie along it.
    angle: Angle,
    angle_weight: f64,
    steps: Vec<Step>,
    /// For a narrow phase function, as if the light stood farther aside.
    wide: Option<(Angle, f64)>,
    /// Along the ray itself, over the blobs.
    even: Option<Step>,
}

/// Where the medium on a piece of a ray is looked at: within parts that are short where fog lies or
/// the light is near.
#[derive(Clone, Copy, Debug)]
pub struct Probes {
    /// Ray parameters [m].
    pub at: [f64; PROBES],
    /// The same as the light sees them, and the widths of the parts [rad].
    angle: [f64; PROBES],
    width: [f64; PROBES],
    /// Where blobs lie on the piece, counted from its beginning: middle and half the extent [m].
    dense: Option<(f64, f64)>,
}

impl Probes {
    /// For a piece of a ray of which a part may hold more fog than the rest.
    pub fn new(from: f64, to: f64, dense: Option<(f64, f64)>, light: &ToLight<f64>) -> Self {
        let angle = Angle { miss: light.miss, ahead: from - light.closest };
        let (length, whole) = (to - from, angle.value(to - from).0);
        let dense =
            dense.map(|(a, b)| ((a - from).clamp(0.0, length), (b - from).clamp(0.0, length)));
        let (low, high) = dense.unwrap_or((0.0, length));
        let mut ends = [length; PROBES + 1];
        for (i, end) in ends.iter_mut().enumerate() {
            let share = (i / 4) as f64 / (PROBES / 4) as f64;
            *end = match i % 4 {
                0 => length * share,
                1 => angle.reaches(share * whole).min(length),
                _ => low + (high - low) * ((i / 4 * 2 + i % 2) as f64 + 0.5) / (PROBES / 2) as f64,
            };
        }
        (ends[0], ends[PROBES]) = (0.0, length);
        ends.sort_unstable_by(f64::total_cmp);
        let seen = ends.map(|end| angle.value(end).0);
        let middle: [f64; PROBES] = std::array::from_fn(|i| 0.5 * (seen[i] + seen[i + 1]));
        Self {
            at: std::array::from_fn(|i| {
                from + angle.reaches(middle[i]).clamp(ends[i], ends[i + 1])
            }),
            angle: middle,
            width: std::array::from_fn(|i| seen[i + 1] - seen[i]),
            dense: dense
                .filter(|(low, high)| low < high)
                .map(|(low, high)| (0.5 * (low + high), 0.5 * (high - low))),
        }
    }
}

impl Angle {
    /// How far behind the beginning the ray has turned through an angle [m].
    fn reaches(&self, angle: f64) -> f64 {
        let Self { miss, ahead } = *self;
        let (sin, cos) = angle.sin_cos();
        // tan(atan(ahead/miss) + angle) · miss − ahead, without a tangent that could be infinite.
        let rest = (miss * cos - ahead * sin).max(f64::MIN_POSITIVE);
        sin * (miss * miss + ahead * ahead) / rest
    }
}

impl Map {
    /// For a piece of a ray, given √(k(α) β e^(−T(v,x)−T(x,s))) up to a factor at its probes.
    pub fn new(
        phase: PhaseFunction,
        from: f64,
        to: f64,
        light: ToLight<f64>,
        probes: &Probes,
        seen: &[f64; PROBES],
    ) -> Self {
        let angle = Angle { miss: light.miss, ahead: from - light.closest };
        let whole = angle.value(to - from).0;
        let cell = |i: usize| {
            let (mean, width) = (probes.angle[i], probes.width[i]);
            Lump { mass: seen[i] * width, mean, variance: width * width / 6.0 }
        };
        let mut lumps = group(&std::array::from_fn(cell)).to_vec();
        lumps.retain(|lump| lump.mass > 0.0 && lump.variance > 0.0);
        let total: f64 = lumps.iter().map(|lump| lump.mass).sum();
        let medium_share = 1.0 - LIGHT_SHARE - EVEN_SHARE;
        let step = |lump: &Lump| {
            let share = medium_share * lump.mass / total;
            Step::new(lump.mean, (2.0 * lump.variance).sqrt(), share, whole)
        };
        let steps: Vec<_> = lumps.iter().map(step).collect();
        let even =
            probes.dense.map(|(middle, half)| Step::new(middle, half, EVEN_SHARE, to - from));
        // What is not needed elsewhere is the light's.
        let share = LIGHT_SHARE
            + if steps.is_empty() { medium_share } else { 0.0 }
            + if even.is_none() { EVEN_SHARE } else { 0.0 };
        // A narrow phase function prefers points from where the light stands straight ahead.
        let wide = (!phase.is_isotropic()).then(|| {
            let wide = Angle { miss: light.miss / (1.0 - phase.g.abs()), ..angle };
            (wide, 0.5 * share / wide.value(to - from).0.max(f64::MIN_POSITIVE))
        });
        let share = if wide.is_some() { 0.5 * share } else { share };
        let angle_weight = share / whole.max(f64::MIN_POSITIVE);
        Self { from, to, angle, angle_weight, steps, wide, even }
    }

    /// q(t) and dq/dt.
    #[inline(always)]
    fn value<N: Num>(&self, t: N) -> (N, N) {
        let way = t - t.lit(self.from);
        let (angle, turn) = self.angle.value(way);
        let (mut q, mut slope) = (angle * t.lit(self.angle_weight), t.lit(self.angle_weight));
        for step in &self.steps {
            let (part, rise) = step.value(angle);
            q += part;
            slope += rise;
        }
        slope = slope * turn;
        if let Some((wide, weight)) = &self.wide {
            let (angle, turn) = wide.value(way);
            q = angle.mul_add(t.lit(*weight), q);
            slope = turn.mul_add(t.lit(*weight), slope);
        }
        if let Some(even) = &self.even {
            let (part, rise) = even.value(way);
            q += part;
            slope += rise;
        }
        (q, slope)
    }

    /// t with q(t) = `q`, and dq/dt there. Newton's steps and the bisections that guard them turn
    /// the ray's point by an angle around the light, in which q hardly bends.
    #[inline(always)]
    pub fn solve<N: Num>(&self, q: N) -> (N, N) {
        let closest = q.lit(self.from - self.angle.ahead);
        let miss2 = q.lit(self.angle.miss).squared();
        let (mut low, mut high) = (q.lit(self.from) - closest, q.lit(self.to) - closest);
        let mut aside = bisector(low, high, miss2);
        let (mut value, mut slope) = self.value(aside + closest);
        for step in 0..64 {
            // The weight belongs to t as it is; where t lies matters little.
            if !N::any(q.lit(1e-5).lt((value - q).abs())) {
                break;
            }
            let below = value.lt(q);
            low = N::select(below, aside, low);
            high = N::select(below, high, aside);
            let middle = bisector(low, high, miss2);
            aside = if step > 5 && step % 2 == 1 {
                // Newton has had its chance: from here on the interval surely gets smaller.
                middle
            } else {
                // h tan(atan(aside/h) + turn), the turn that Newton asks for taken for its tangent.
                let along = (q - value) / slope;
                let distance2 = aside.mul_add(aside, miss2);
                let rest = distance2 - aside * along;
                let next = (aside * distance2 + along * miss2) / rest;
                let next = N::select(next.lt(high), next, middle);
                let next = N::select(low.lt(next), next, middle);
                N::select(q.lit(0.0).lt(rest), next, middle)
            };
            (value, slope) = self.value(aside + closest);
        }
        (aside + closest, slope)
    }
}

/// The place on a ray that a light sees halfway between two others, all counted from the point
/// closest to it; by the theorem of the angle's bisector.
#[inline(always)]
fn bisector<N: Num>(low: N, high: N, miss2: N) -> N {
    let (near, far) = (low.mul_add(low, miss2).sqrt(), high.mul_add(high, miss2).sqrt());
    (low * far + high * near) / (near + far)
}

/// L_a per unit of ω·I₀ [1/m²] of the path's light.
pub(crate) fn airlight_along(path: &Path, phase: PhaseFunction) -> f64 {
    let Some((from, to)) = path.span() else { return 0.0 };
    let to = path.reaches(OPAQUE, from, to);
    let of_part = |[from, to]: [f64; 2]| {
        let sections = path.sections(from, to);
        let sections = if sections.len() > MOST_SECTIONS { vec![from, to] } else { sections };
        sections.windows(2).map(|ends| within(path, phase, ends[0], ends[1])).sum::<f64>()
    };
    path.lit(from, to).map(of_part).sum::<f64>() + 0.0
}

/// The share of a part of the ray on which the fog is smooth.
fn within(path: &Path, phase: PhaseFunction, from: f64, to: f64) -> f64 {
    if to - from <= SHORTEST {
        return 0.0;
    }
    let probes = Probes::new(from, to, path.dense(), &path.to_light);
    let monitor = probes.at.map(|t| path.scattered(phase, t).0.sqrt());
    let map = Map::new(phase, from, to, path.to_light, &probes, &monitor);
    let by_masses = || massed::airlight(path, phase, [from, to], |q| map.solve(q).0);
    if massed::is_needed(path, from, to) {
        return by_masses();
    }
    // What the lumps alone remove is known; a rule that misses it has not seen them all.
    let (before, behind) = (path.depth_of_lumps(from), path.depth_of_lumps(to));
    let removed = (-before).exp() * -(before - behind).exp_m1();
    let mut coarse = f64::INFINITY;
    for (nodes, weights) in GAUSS.iter() {
        let (mut sum, mut met) = (0.0, 0.0);
        for (q, weight) in nodes.iter().zip(weights) {
            let (t, slope) = map.solve(*q);
            let (value, arrival) = path.scattered(phase, t);
            sum += weight / slope * arrival.falloff(value);
            met += weight / slope * path.extinction_of_lumps(t) * (-path.depth_of_lumps(t)).exp();
        }
        let agree = (sum - coarse).abs() <= path.slack() * AGREE * sum;
        coarse = sum;
        if agree && (met - removed).abs() <= path.slack() * UNMET * removed {
            return sum;
        }
    }
    // The masses of so many lumps are as good as the last rule at best; of waves and cells they are better.
    if path.is_rippled() { by_masses() } else { coarse }
}
