// How a lamp glows in fog that is the same everywhere and hides nothing: M(t) = ∫ k(α) dt/d² from the eye, the
// phase function over the angle that the ray turns through before the lamp, divided by its distance from
// the ray (Macklin 2010, for any phase function).
//
// Twin: core/src/cpu/grid/glow.rs, which tabulates the phase functions.

#define_import_path fogbank::grid::glow

#import fogbank::num
#import fogbank::phase
#import fogbank::lamp

/// For each group of terms, k and ∫ k dα at even steps of the angle from 0 to π.
@group(0) @binding(17) var<storage, read> phases: array<vec2<f32>>;

/// Steps of a tabulated phase function.
const STEPS: u32 = 1024u;
/// Below this angle [rad] the phase function is as good as constant: a difference of its integrals has few digits.
const NARROW: f32 = 0.02;

/// ∫ k dα over a turn from an angle on.
fn over(scatter: lamp::Scatter, angle: f32, turn: f32) -> f32 {
    if scatter.g == 0.0 {
        return turn * phase::ISOTROPIC;
    }
    let first = look_up(scatter.group, angle).y;
    let between = look_up(scatter.group, angle + turn).y - first;
    let narrow = look_up(scatter.group, angle + 0.5 * turn).x * turn;
    return select(between, narrow, turn < NARROW);
}

/// A straight line between a table's values.
fn look_up(group: u32, angle: f32) -> vec2<f32> {
    let at = angle * (f32(STEPS) / num::PI);
    let i = min(u32(max(at, 0.0)), STEPS - 1u);
    let first = group * (STEPS + 1u) + i;
    return mix(phases[first], phases[first + 1u], at - f32(i));
}

/// The angle that a ray turns through before a light between two ray parameters [rad].
fn turn(light: lamp::ToLight, begin: f32, end: f32) -> f32 {
    let a = begin - light.closest;
    let b = end - light.closest;
    return num::angle(light.miss * (end - begin), a * b + light.miss * light.miss);
}

/// The angle between the direction in which light travels to the ray's start and that back to the eye [rad].
fn first_angle(light: lamp::ToLight) -> f32 {
    let sine = sqrt(max(1.0 - light.tilt * light.tilt, 0.0));
    return num::angle(light.miss * sine, light.tilt * light.miss + light.closest);
}

/// ∫ k(α) dt/d² between two ray parameters [1/m].
fn between(scatter: lamp::Scatter, light: lamp::ToLight, begin: f32, end: f32) -> f32 {
    let before = first_angle(light) + turn(light, 0.0, begin);
    return over(scatter, before, turn(light, begin, end)) / light.miss;
}
