// The airlight along a tabulated ray, from knot to knot.
//
// Twin: core/src/cpu/grid/rule.rs.

#define_import_path fogbank::grid::rule

#import fogbank::num

/// A knot of a ray.
struct Place {
    t: f32,
    /// From the point closest to the light [m].
    aside: f32,
    /// ln of the distance of the light [m], and the squared one of the ray from it [m²].
    log: f32,
    miss_squared: f32,
    /// T from the eye of what scatters.
    own: f32,
    /// T from the eye and from the light.
    total: f32,
    /// e^(−total).
    through: f32,
    /// β e^(−total) [1/m].
    seen: f32,
}

/// What stands for 1 − e^(−T) where there is no fog [1/m].
const CLEAR: f32 = 1e-7;

/// The mean of β e^(−T) between two knots: of a straight line, of which the integral with 1/d² is known, `clear`;
/// and in place of that line's area what the fog between them really scatters.
fn gain(clear: f32, a: Place, b: Place) -> f32 {
    // Sections may be empty.
    let step = max(b.t - a.t, num::LEAST);
    // Where on the way the light comes from, as a share. From far away logarithms do not tell: there its strength
    // is a straight line.
    let near = (b.log - a.log - a.aside * clear) / max(step * clear, num::LEAST);
    let middle = 0.5 * (a.aside + b.aside);
    let apart2 = middle * middle + a.miss_squared;
    let from_far = 0.5 - step * middle / (apart2 * 6.0);
    let far = clamp(select(near, from_far, step * step < apart2 * 1e-3), 0.0, 1.0);
    let line = mix(a.seen, b.seen, far);
    // ∫ β e^(−total) dt, total as a straight line of T.
    let turn = b.total - a.total;
    let series = a.through * (1.0 - 0.5 * turn + turn * turn / 6.0);
    let is_short = abs(turn) < 0.03;
    let falling = (a.through - b.through) / select(turn, 1.0, is_short);
    let mass = (b.own - a.own) * select(falling, series, is_short);
    let area = 0.5 * step * (a.seen + b.seen);
    return max(line + (mass - area) / step, 0.1 * line);
}

/// (1 − e^(−T))/t, and something where there is no fog.
fn bulk(depth: f32, t: f32) -> f32 {
    return num::absorptance(depth) / max(t, num::LEAST) + CLEAR;
}

/// The mean over a part of a square's way, given its values at both ends and its mean between.
fn between(ends: vec2<f32>, mean: f32, part: vec2<f32>) -> f32 {
    let bend = 3.0 * (ends.x + ends.y) - 6.0 * mean;
    let rise = ends.y - ends.x - bend;
    let squares = part.x * part.x + part.y * part.y + part.x * part.y;
    // Where what is seen leaps no square tells it.
    let value = ends.x + 0.5 * rise * (part.x + part.y) + bend * squares / 3.0;
    return clamp(value, 0.0, 3.0 * mean);
}
