// The phase function k(α): which share of the scattered light goes where, per solid angle [1/sr].
//
// Henyey and Greenstein 1941: k = (1 − g²) / (4π (1 + g² − 2 g cos α)^(3/2)), α the angle between
// the direction in which the light travels and the direction back to the eye; g = 0 is isotropic.
//
// Twin: core/src/phase.rs.

#define_import_path fogbank::phase

const ISOTROPIC: f32 = 0.07957747;

/// k(α) [1/sr] for g in (−1, 1) and a cosine in [−1, 1].
fn phase(g: f32, cosine: f32) -> f32 {
    // 1 + g² − 2 g cos α as a sum of what is not negative: it keeps the digits of a sharp peak.
    let off = max(1.0 - select(cosine, -cosine, g < 0.0), 0.0);
    let sharp = 1.0 - abs(g);
    let square = sharp * sharp + 2.0 * abs(g) * off;
    return ISOTROPIC * (1.0 - g * g) / (square * sqrt(square));
}
