// How an extinction depends on height: the same between two heights, or falling off above the lower one.
//
// Twin: core/src/media/vertical.rs.

#define_import_path fogbank::media::vertical

#import fogbank::num

/// A share of an extinction by height, heights from the camera.
struct Profile {
    /// The lower end, from which on it falls off if it does [m].
    low_m: f32,
    /// The upper end [m].
    high_m: f32,
    /// Falloff above the lower end [1/m]; 0 for what is the same between both.
    falloff: f32,
}

/// Higher than any end that is one.
const FAR: f32 = 1e38;

/// The share at a height.
fn share(profile: Profile, y: f32) -> f32 {
    if profile.falloff > 0.0 {
        return num::exp_bounded(-max(y - profile.low_m, 0.0) * profile.falloff);
    }
    return select(0.0, 1.0, profile.low_m <= y && y <= profile.high_m);
}

/// Exponents behind which nothing is left.
const GONE: f32 = 30.0;

/// How far a way that climbs so a metre goes from a height until there is nothing left of it [m]; `otherwise` if it
/// has no end.
fn ends(profile: Profile, y: f32, climb: f32, otherwise: f32) -> f32 {
    if profile.falloff > 0.0 {
        let above = max(profile.low_m - y, 0.0) + GONE / profile.falloff;
        return select(otherwise, above / climb, climb > 0.0);
    }
    if climb > 0.0 && profile.high_m < FAR {
        return max(profile.high_m - y, 0.0) / climb;
    }
    if climb < 0.0 && profile.low_m > -FAR {
        return max(y - profile.low_m, 0.0) / -climb;
    }
    return otherwise;
}

/// Between which ray parameters there is any of it on a ray from a height that climbs so [m]; nothing if the second
/// lies before the first.
fn span(profile: Profile, height: f32, climb: f32, length_m: f32) -> vec2<f32> {
    if profile.falloff > 0.0 || profile.high_m > FAR {
        return vec2<f32>(0.0, length_m);
    }
    return between(height, climb, vec2<f32>(profile.low_m, profile.high_m), length_m);
}

/// The same of a coordinate between two numbers.
fn between(start: f32, step: f32, ends: vec2<f32>, length_m: f32) -> vec2<f32> {
    let low = ends.x - start;
    let high = ends.y - start;
    if abs(step) * FAR <= max(abs(low), abs(high)) {
        return select(vec2<f32>(FAR, -FAR), vec2<f32>(0.0, length_m), low <= 0.0 && high >= 0.0);
    }
    return vec2<f32>(max(min(low / step, high / step), 0.0), min(max(low / step, high / step), length_m));
}

/// What two of them have in common.
fn overlap(a: vec2<f32>, b: vec2<f32>) -> vec2<f32> {
    let both = vec2<f32>(max(a.x, b.x), min(a.y, b.y));
    return select(vec2<f32>(FAR, -FAR), both, both.x < both.y);
}

/// The ray parameter at which a ray from a height that climbs so passes an end; behind its start where it passes
/// none [m].
fn edge(profile: Profile, which: u32, height: f32, climb: f32) -> f32 {
    let end = select(profile.low_m, profile.high_m, which == 1u);
    let rise = end - height;
    // Also for a level ray, whose quotient would be no number.
    if abs(end) > FAR || abs(climb) * FAR <= abs(rise) {
        return -1.0;
    }
    return rise / climb;
}
