//! Whether a field is below 0 anywhere, at any time: no fog has such an extinction.
//!
//! First a bound: what every member takes away at most, and what is there everywhere (Biri's c₀ ≥ Σ|cᵢ|). Where
//! that proves nothing a negative place is searched for, from many points downhill.

use super::closed::Closed;
use super::functions::{Families, Functions, Member};
use super::homogeneous::Haze;
use super::{Bands, Field, Media, Medium, Moment, Term, Wind};
use glam::DVec3;

/// What rounding may take from a sum of terms, as a share of their sizes.
const ROUNDING: f64 = 1e-12;
/// Times that are looked at if anything moves, and points at each of them.
const TIMES: usize = 16;
const POINTS: usize = 512;
/// Of those points, as many as are followed downhill, and how often their step is halved.
const FOLLOWED: usize = 6;
const HALVINGS: usize = 40;

/// Where and when a fog is negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Negative {
    /// The point [m].
    pub point: DVec3,
    /// The time [s].
    pub time_s: f64,
    /// β there [1/m].
    pub beta: f64,
}

/// Whether a term may be below 0, or be there everywhere to make up for one that is.
pub fn decides_sign(term: &Term) -> bool {
    matches!(term, Term::Functions(_) | Term::Homogeneous(_))
}

/// A place where the field of some terms in a wind is negative, if one is found.
pub fn negative(terms: &[Term], wind: &Wind) -> Option<Negative> {
    let enabled = terms.iter().filter(|term| term.common().enabled);
    // What may be below 0, and what may make up for it everywhere.
    let (doubtful, even): (Vec<_>, Vec<_>) = enabled
        .filter(|term| decides_sign(term))
        .partition(|term| matches!(term, Term::Functions(_)));
    let functions: Vec<_> = doubtful.iter().filter_map(|term| functions(term)).collect();
    if functions.is_empty() {
        return None;
    }
    let members = || functions.iter().flat_map(|term| &term.members);
    let moves = !wind.is_calm() || members().any(Member::morphs);
    let times = if moves { TIMES } else { 1 };
    (0..Bands::count(terms)).find_map(|channel| {
        let haze = Media::new(&even, channel, &Moment::default()).homogeneous;
        if is_proven(&haze, &functions, channel) {
            return None;
        }
        let both = [&*doubtful, &*even].concat();
        (0..times).find_map(|i| search((terms, &both), &functions, channel, wind, i))
    })
}

fn functions<'a>(term: &'a &Term) -> Option<&'a Functions> {
    match term {
        Term::Functions(functions) => Some(functions),
        _ => None,
    }
}

/// Whether a channel's field is at least 0 by what its members take away at most.
fn is_proven(haze: &Haze, functions: &[&Functions], channel: usize) -> bool {
    let (mut sum, mut size) = (haze.least_beta(), haze.least_beta());
    for term in functions {
        let scale = term.scale.channels()[channel];
        for least in term.members.iter().map(Member::least) {
            (sum, size) = (sum + scale * least, size + scale * least.abs());
        }
    }
    sum >= -ROUNDING * size
}

/// Looks at one of several times.
fn search(
    (all, terms): (&[Term], &[&Term]),
    functions: &[&Functions],
    channel: usize,
    wind: &Wind,
    which: usize,
) -> Option<Negative> {
    let members = || functions.iter().flat_map(|term| &term.members);
    let longest = members().filter_map(Member::period_s).fold(60.0, f64::max);
    let time_s = longest * halton(which, 2);
    let moment = Moment { time_s, wind: wind.clone(), ..Moment::default() };
    let media = Media::new(terms, channel, &moment);
    let sum = Sum { haze: &media.homogeneous, families: &media.functions };
    let scales: Vec<_> = members().map(Member::scale).collect();
    let start = |i: usize| {
        let (length, center) = scales[i % scales.len()];
        // The middle itself, then around it, near and far.
        let at = DVec3::new(halton(i, 2), halton(i, 3), halton(i, 5)) - 0.5;
        let reach = if i < scales.len() { 0.0 } else { length * [1.0, 4.0, 16.0][i % 3] };
        (center + reach * at, length)
    };
    let most = (1 << 18) / (scales.len() + 1);
    let mut starts: Vec<_> = (0..POINTS.min(most).max(scales.len())).map(start).collect();
    starts.sort_by(|a, b| sum.at(a.0).total_cmp(&sum.at(b.0)));
    let ends = starts.into_iter().take(FOLLOWED).map(|(point, length)| sum.downhill(point, length));
    let below = ends.filter(|point| sum.at(*point) < 0.0);
    let below: Vec<_> = below.collect();
    if below.is_empty() {
        return None;
    }
    // Other media may make up for it.
    let field = Field::new(all, channel, &moment);
    let tolerance = -ROUNDING * (sum.families.most_beta() - sum.families.least_beta());
    let mut found =
        below.into_iter().map(|point| Negative { point, time_s, beta: field.beta(point) });
    found.find(|found| found.beta < tolerance)
}

/// What may be below 0, and what may make up for it everywhere.
struct Sum<'a> {
    haze: &'a Haze,
    families: &'a Families,
}

impl Sum<'_> {
    fn at(&self, point: DVec3) -> f64 {
        self.haze.beta(point) + self.families.beta(point)
    }

    /// To where no step along an axis goes further down.
    fn downhill(&self, mut point: DVec3, mut step: f64) -> DVec3 {
        let mut value = self.at(point);
        for _ in 0..HALVINGS {
            for axis in DVec3::AXES {
                for way in [step * axis, -step * axis] {
                    let next = self.at(point + way);
                    if next < value {
                        (point, value) = (point + way, next);
                    }
                }
            }
            step *= 0.6;
        }
        point
    }
}

/// A number of the Halton sequence, from 0 to 1.
fn halton(i: usize, base: usize) -> f64 {
    let (mut rest, mut digit, mut sum) = (i, 1.0, 0.0);
    while rest > 0 {
        digit /= base as f64;
        sum += digit * (rest % base) as f64;
        rest /= base;
    }
    sum
}
