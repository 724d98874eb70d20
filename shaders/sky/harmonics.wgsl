// Spherical harmonics, one pair after the other: real, orthonormal, index l² + l + m, polar axis +Z, no
// Condon–Shortley sign.
//
// Twin: core/src/sky/harmonics.rs.

#define_import_path fogbank::sky::harmonics

/// A place in a walk through the functions of some bands: those of m and −m, band by band, then those of the next m.
struct Walk {
    /// l.
    band: u32,
    m: u32,
    /// (x + iy)ᵐ.
    turned: vec2<f32>,
    /// Pₗᵐ / sinᵐ of the band, and of the one before.
    own: f32,
    before: f32,
    /// Pₘᵐ / sinᵐ.
    diagonal: f32,
}

/// √(1/4π), the first function of all.
const FIRST: f32 = 0.28209479;
const SQRT_2: f32 = 1.4142136;

fn begin() -> Walk {
    return Walk(0u, 0u, vec2<f32>(1.0, 0.0), FIRST, 0.0, FIRST);
}

/// Whether a walk has not yet passed all bands below `order`.
fn is_within(walk: Walk, order: u32) -> bool {
    return walk.m < order;
}

/// The index of the function of m = 0 in its band.
fn middle(walk: Walk) -> u32 {
    return walk.band * walk.band + walk.band;
}

/// The functions of m and −m; there is none of −0.
fn values(walk: Walk) -> vec2<f32> {
    if walk.m == 0u {
        return vec2<f32>(walk.own, 0.0);
    }
    return SQRT_2 * walk.own * walk.turned;
}

/// The next pair towards the unit vector `d`.
fn next(walk: Walk, order: u32, d: vec3<f32>) -> Walk {
    var after = walk;
    if walk.band + 1u < order {
        var below = 0.0;
        if walk.band > walk.m {
            below = walk.before / step_to(walk.band, walk.m);
        }
        after.band = walk.band + 1u;
        after.own = step_to(after.band, walk.m) * (d.z * walk.own - below);
        after.before = walk.own;
        return after;
    }
    let m = f32(walk.m);
    after.m = walk.m + 1u;
    after.band = after.m;
    let turned = walk.turned;
    after.turned = vec2<f32>(d.x * turned.x - d.y * turned.y, d.x * turned.y + d.y * turned.x);
    after.diagonal = walk.diagonal * sqrt((2.0 * m + 3.0) / (2.0 * m + 2.0));
    after.own = after.diagonal;
    after.before = 0.0;
    return after;
}

/// The factor of the recurrence from the band before `band`, which is above `m`.
fn step_to(band: u32, m: u32) -> f32 {
    let l = f32(band);
    let order = f32(m);
    return sqrt((4.0 * l * l - 1.0) / (l * l - order * order));
}
