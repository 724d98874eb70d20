// What the blobs around some rays come to, before any of them is followed.
//
// Twin: weigh in core/src/media/gaussians/lanes.rs.

#define_import_path fogbank::grid::around

#import fogbank::num
#import fogbank::bundle
#import fogbank::media::gaussians

struct Fog {
    /// Where the first blob begins and the last one ends on any of the rays [m].
    begin: f32,
    end: f32,
    /// Optical depth along the middle ray, if it has no end.
    depth: f32,
    /// Optical depth that quadratics may miss of blobs that stand between the rays looked at,
    /// squared: what many blobs hide has either sign.
    hidden: f32,
}

/// Larger than any distance [m].
const FAR: f32 = 1e30;
/// Radii from its middle on a ray at which a blob has ended there: exp(−4²) is 1e-7.
const ENDS: f32 = 4.0;
/// Radii from its centre at which a blob has ended aside of a ray: exp(−4.3²) is 1e-8.
const ASIDE: f32 = 4.3;
/// Blobs of which half a square's diagonal covers less than this share of the radius are seen.
const COARSE: f32 = 0.4;

fn nothing() -> Fog {
    return Fog(FAR, -FAR, 0.0, 0.0);
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
    (*fog).begin = min((*fog).begin, range.x - ENDS / a);
    (*fog).end = max((*fog).end, range.y + ENDS / a);
    (*fog).depth += 2.0 * k * num::exp_bounded(-aside * aside);
    if half > COARSE {
        // The third derivative of a Gaussian, met over half a square.
        let near = min(half, 4.0);
        let missed = 0.25 * k * near * near * near * num::exp_bounded(-miss * miss);
        (*fog).hidden += missed * missed;
    }
}
