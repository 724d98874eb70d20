// What a blob adds at four places of a ray: T and β.
//
// Twin: add_fields in core/src/media/gaussians/lanes.rs.

#define_import_path fogbank::grid::crossing

#import fogbank::num
#import fogbank::view
#import fogbank::media::gaussians

/// T and β of all blobs and of those that scatter, at four knots of a ray.
struct Sums {
    depth: vec4<f32>,
    beta: vec4<f32>,
    own: vec4<f32>,
    own_beta: vec4<f32>,
}

/// A blob before a ray.
struct Crossing {
    a: f32,
    /// a · ray parameter of its closest point, counted backwards.
    start: f32,
    /// Half its depth along the line.
    density: f32,
    /// erf where the ray starts.
    begins: f32,
    is_dense: bool,
    is_slab: bool,
}

/// Half depth from which on the tails of erf are formed with care: below it the plain difference is
/// off by less than 1e-6 of optical depth.
const DENSE: f32 = 0.25;

fn of_blob(blob: gaussians::Blob, ray: view::Ray) -> Crossing {
    let seen = gaussians::seen_from(blob, ray.offset);
    let start = -dot(seen.b, ray.direction);
    let aside = cross(seen.b, ray.direction);
    let density = seen.k * num::exp_bounded(-dot(aside, aside));
    return Crossing(seen.a, start, density, num::erf(start), seen.k > DENSE, seen.is_slab);
}

/// Adds a blob at four places of a ray.
fn add(sums: ptr<function, Sums>, blob: Crossing, t: vec4<f32>, is_own: bool) {
    let ways = blob.a * t;
    let ends = blob.start + ways;
    var gathered: vec4<f32>;
    let core = blob.density * blob.a / num::HALF_SQRT_PI;
    var beta = core * exp(-min(ends * ends, vec4<f32>(87.0)));
    if blob.is_slab {
        let half = gaussians::HALF_SLAB;
        for (var i = 0u; i < 4u; i++) {
            gathered[i] = gaussians::gathered_between(blob.start, ends[i], ways[i]);
        }
        let flat = vec4<f32>(blob.density * blob.a / half);
        beta = select(vec4<f32>(0.0), flat, abs(ends) < vec4<f32>(half));
    } else if blob.is_dense {
        for (var i = 0u; i < 4u; i++) {
            gathered[i] = gaussians::between(blob.start, ends[i], ways[i]);
        }
    } else {
        for (var i = 0u; i < 4u; i++) {
            gathered[i] = num::erf(ends[i]) - blob.begins;
        }
    }
    let depth = blob.density * gathered;
    (*sums).depth += depth;
    (*sums).beta += beta;
    (*sums).own += select(vec4<f32>(0.0), depth, is_own);
    (*sums).own_beta += select(vec4<f32>(0.0), beta, is_own);
}
