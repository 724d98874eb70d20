//! The airlight along tabulated rays, from knot to knot.

use super::glow::Glow;
use super::knots::Knots;
use crate::frame::context::Lamp;
use crate::geometry::batch::load3;
use crate::geometry::control::{Control, Each, PADDED};
use crate::light::ToLight;
use crate::num::{Lanes, Num};
use fearless_simd::Simd;

/// What stands for 1 − e^(−T) where there is no fog [1/m].
const CLEAR: f64 = 1e-7;

/// (1 − e^(−T))/t, and something where there is no fog.
#[inline(always)]
pub fn bulk<N: Num>(depth: N, t: N) -> N {
    depth.absorptance() / t + t.lit(CLEAR)
}

/// Where what is scattered of a lamp goes.
pub struct Page<'a> {
    pub knots: &'a Knots,
    pub rows: &'a mut [Each],
    /// Rows of a knot.
    pub width: usize,
    /// Those of R, of the mean since the knot before, and of the airlight.
    pub fields: [usize; 3],
    /// That of β e^(−T), where it is wanted.
    pub seen: Option<usize>,
}

/// What sixteen rays meet at their knots.
pub struct Met<'a> {
    pub t: &'a [Each],
    /// β and T of what scatters.
    pub beta: &'a [Each],
    pub own: &'a [Each],
    /// T of all.
    pub depth: &'a [Each],
    /// T/d towards the lamp.
    pub mean: &'a [Each],
}

/// R, the mean of β e^(−T) since the knot before, and the airlight, at all knots of sixteen rays. Behind all
/// lumps and lamps R does not help any more, and the airlight itself stands in its place.
#[inline(always)]
pub fn cumulate<S: Simd>(
    simd: S,
    glow: &Glow,
    lamp: &Lamp,
    rays: &Control,
    met: &Met,
    page: &mut Page,
) {
    for at in (0..PADDED).step_by(Lanes::<S>::COUNT) {
        let start = load3(simd, &rays.offset, at);
        let to = lamp.from_camera.beside(start, load3(simd, &rays.direction, at));
        let mut before = Place::new(simd, met, &to, 0, at);
        let mut angle = to.first_angle();
        let turn = to.angle(before.t.lit(0.0), before.t);
        let scale = before.t.lit(1.0) / to.miss;
        let mut known = glow.over(simd, angle, turn) * scale;
        angle += turn;
        let mut mean = before.seen;
        let mut sum = mean * known;
        for (k, rows) in page.rows.chunks_mut(page.width).enumerate() {
            if k > 0 {
                let next = Place::new(simd, met, &to, k, at);
                let turn = to.angle(before.t, next.t);
                let part = glow.over(simd, angle, turn) * scale;
                mean = gain(turn * scale, &before, &next);
                sum += mean * part;
                angle += turn;
                known += part;
                before = next;
            }
            let ratio = if page.knots.is_behind(k) {
                sum
            } else {
                sum / (known * bulk(before.depth, before.t))
            };
            ratio.store(&mut rows[page.fields[0]][at..]);
            mean.store(&mut rows[page.fields[1]][at..]);
            sum.store(&mut rows[page.fields[2]][at..]);
            if let Some(seen) = page.seen {
                before.seen.store(&mut rows[seen][at..]);
            }
        }
    }
}

/// A knot of some rays.
struct Place<N> {
    t: N,
    /// From the point closest to the light [m].
    aside: N,
    /// ln of the distance of the light [m], and the squared one of the ray from it [m²].
    log: N,
    miss2: N,
    /// T from the eye, of what scatters and of all.
    own: N,
    depth: N,
    /// T from the eye and from the light.
    total: N,
    /// e^(−total).
    through: N,
    /// β e^(−total) [1/m].
    seen: N,
}

impl<S: Simd> Place<Lanes<S>> {
    #[inline(always)]
    fn new(simd: S, met: &Met, to: &ToLight<Lanes<S>>, k: usize, at: usize) -> Self {
        let t = Lanes::load(simd, &met.t[k][at..]);
        let aside = t - to.closest;
        let distance = to.at_aside(aside).distance;
        let depth = Lanes::load(simd, &met.depth[k][at..]);
        let mean = Lanes::load(simd, &met.mean[k][at..]).max(t.lit(0.0));
        let total = mean.mul_add(distance, depth);
        let through = (-total.min(t.lit(80.0))).exp();
        let seen = Lanes::load(simd, &met.beta[k][at..]) * through;
        let own = Lanes::load(simd, &met.own[k][at..]);
        let miss2 = to.miss.squared();
        Self { t, aside, log: distance.ln(), miss2, own, depth, total, through, seen }
    }
}

/// The mean of β e^(−T) between two knots, weighed by where the light comes from: as a straight line, of which the integral
/// with 1/d² is known; and in place of that line's area what the fog between them really scatters.
#[inline(always)]
fn gain<N: Num>(clear: N, a: &Place<N>, b: &Place<N>) -> N {
    let (zero, half) = (a.t.lit(0.0), a.t.lit(0.5));
    // Sections may be empty.
    let step = (b.t - a.t).max(a.t.lit(f64::from(f32::MIN_POSITIVE)));
    let log = b.log - a.log;
    let least = a.t.lit(f64::from(f32::MIN_POSITIVE));
    // Where on the way the light comes from, as a share. From far away logarithms do not tell: there its strength
    // is a straight line.
    let far = (log - a.aside * clear) / (step * clear).max(least);
    let middle = half * (a.aside + b.aside);
    let apart2 = middle.mul_add(middle, a.miss2);
    let from_far = half - step * middle / (apart2 * a.t.lit(6.0));
    let is_far = step.squared().lt(apart2 * a.t.lit(1e-3));
    let far = N::select(is_far, from_far, far).max(zero).min(a.t.lit(1.0));
    let line = (b.seen - a.seen).mul_add(far, a.seen);
    // ∫ β e^(−total) dt, total as a straight line of T.
    let turn = b.total - a.total;
    let series = a.through * (a.t.lit(1.0) - turn * half + turn.squared() * a.t.lit(1.0 / 6.0));
    let is_short = turn.abs().lt(a.t.lit(0.03));
    let safe = N::select(is_short, a.t.lit(1.0), turn);
    let mean = N::select(is_short, series, (a.through - b.through) / safe);
    let mass = (b.own - a.own) * mean;
    let area = half * step * (a.seen + b.seen);
    (line + (mass - area) / step).max(line * a.t.lit(0.1))
}
