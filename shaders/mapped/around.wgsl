// What the blobs around some rays come to, before any of them is followed.
//
// Twin: Surroundings in core/src/cpu/mapped/patch.rs, span and most in
// core/src/cpu/mapped/crossings.rs.

#define_import_path fogbank::mapped::around

#import fogbank::num
#import fogbank::bundle
#import fogbank::media::gaussians
#import fogbank::airlight::mapped

struct Fog {
    /// Where the first blob begins and the last one ends on any of the rays [m].
    begin: f32,
    end: f32,
    /// The most optical depth that any ray meets.
    most: f32,
    /// Optical depth along the middle ray, if it has no end.
    depth: f32,
    /// Optical depth that quadratics may miss of blobs that stand between the rays looked at,
    /// squared: what many blobs hide has either sign.
    hidden: f32,
}

/// Larger than any distance [m].
const FAR: f32 = 1e30;
/// Radii from its centre at which a blob has ended aside of a ray: exp(−4.3²) is 1e-8.
const ASIDE: f32 = 4.3;
/// Blobs of which half a patch's diagonal covers less than this share of the radius are seen.
const COARSE: f32 = 0.4;

fn nothing() -> Fog {
    return Fog(FAR, -FAR, 0.0, 0.0, 0.0);
}

/// Adds a blob, if some ray of the bundle meets it.
fn add(fog: ptr<function, Fog>, blob: gaussians::Blob, rays: bundle::Bundle) {
    let center = gaussians::center_of(blob);
    let a = blob.a;
    let k = blob.half_depth;
    let way = center - rays.origin;
    let half = 1.01 * a * (length(way) * rays.tangent + rays.radius);
    let aside = a * length(cross(way, rays.axis));
    let miss = max(aside - half, 0.0);
    if miss >= ASIDE {
        return;
    }
    let range = bundle::closest_approach(rays, center);
    (*fog).begin = min((*fog).begin, range.x - mapped::ENDS / a);
    (*fog).end = max((*fog).end, range.y + mapped::ENDS / a);
    let peak = num::exp_bounded(-miss * miss);
    (*fog).most += 2.0 * k * peak;
    (*fog).depth += 2.0 * k * num::exp_bounded(-aside * aside);
    if half > COARSE {
        // The third derivative of a Gaussian, met over half a patch.
        let near = min(half, 4.0);
        let missed = 0.25 * k * near * near * near * peak;
        (*fog).hidden += missed * missed;
    }
}
