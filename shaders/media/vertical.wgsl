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
