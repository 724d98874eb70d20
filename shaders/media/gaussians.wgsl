// Sums of Gaussians: βᵢ(x) = cᵢ exp(−aᵢ² |x − bᵢ|²) (Fogshop 2007, eqs. 6–7), and eq. 31, the
// integral of one of them along a segment: k exp(−miss²) (erf(end) − erf(start)), k = c√π/(2a).
//
// Dot and cross products stand for the paper's angle ξ, which is singular at the blob's centre.
// Lengths of a Line are in units of the blob's radius 1/a.
//
// Twin: core/src/media/gaussians.rs.

#define_import_path fogbank::media::gaussians

#import fogbank::num

/// A blob as the host writes it.
struct Blob {
    /// a · (centre − camera).
    place: vec3<f32>,
    /// Scale a = 1/radius [1/m].
    a: f32,
    /// Half depth k = c√π/(2a).
    half_depth: f32,
    /// Distance from its centre beyond which it counts for nothing [m].
    reach_m: f32,
    /// The group of terms that it belongs to.
    group: u32,
    /// 1 if view rays see a slab.
    is_slab: u32,
}

/// A blob relative to the origin of rays.
struct Seen {
    /// a · (centre − origin).
    b: vec3<f32>,
    /// Scale a [1/m].
    a: f32,
    /// Half depth.
    k: f32,
    is_slab: bool,
}

/// A segment relative to a blob.
struct Line {
    /// Where it starts, counted from its point closest to the centre.
    start: f32,
    /// Where it ends.
    end: f32,
    /// Squared distance of its line from the centre.
    miss_squared: f32,
    /// exp(−miss²).
    peak: f32,
}

/// A way between two points.
struct Way {
    /// Where it starts, from the camera [m].
    origin: vec3<f32>,
    /// Unit vector.
    direction: vec3<f32>,
    length_m: f32,
}

/// Half a slab's thickness in radii: √(3/2), by which it is as wide as the Gaussian.
const HALF_SLAB: f32 = 1.2247449;
/// Segments up to this length are integrated by a series, which is exact to 1e-10: of a short one
/// inside a large blob the difference of erf keeps few digits.
const SHORT: f32 = 5e-3;

/// A blob relative to a point, itself given relative to the camera [m].
fn seen_from(blob: Blob, origin: vec3<f32>) -> Seen {
    return Seen(blob.place - blob.a * origin, blob.a, blob.half_depth, blob.is_slab != 0u);
}

/// A blob's centre, relative to the camera [m].
fn center_of(blob: Blob) -> vec3<f32> {
    return blob.place / blob.a;
}

/// The way between two points. It starts at the one nearer to the camera, whose coordinates have
/// more digits: a sun's direction is exact where its place is not.
fn way_between(a: vec3<f32>, b: vec3<f32>) -> Way {
    let swap = dot(b, b) < dot(a, a);
    let origin = select(a, b, swap);
    let step = select(b, a, swap) - origin;
    let length_m = length(step);
    return Way(origin, step / max(length_m, num::LEAST), length_m);
}

/// The segment from the origin in the unit direction up to `length_m`.
fn line_of(seen: Seen, direction: vec3<f32>, length_m: f32) -> Line {
    let start = -dot(seen.b, direction);
    let aside = cross(seen.b, direction);
    let miss_squared = dot(aside, aside);
    return Line(start, start + seen.a * length_m, miss_squared, num::exp_bounded(-miss_squared));
}

/// erf(end) − erf(start) of a segment of the given length in units of the radius.
fn between(start: f32, end: f32, span: f32) -> f32 {
    return select(num::erf_difference(start, end), across_short(start + 0.5 * span, span), span < SHORT);
}

/// The same around the middle of a short segment.
fn across_short(middle: f32, span: f32) -> f32 {
    let square = middle * middle;
    let bend = 1.0 + span * span * (4.0 * min(square, 100.0) - 2.0) / 24.0;
    return num::TWO_BY_SQRT_PI * num::exp_bounded(-square) * span * bend;
}

/// What erf is to a Gaussian: from −1 before a slab to 1 behind it.
fn gathered(place: f32) -> f32 {
    return clamp(place / HALF_SLAB, -1.0, 1.0);
}

/// The same from one place to another, given how far that is: of a way within a slab no difference of places is
/// formed, which would have few digits in a large one.
fn gathered_between(start: f32, end: f32, way: f32) -> f32 {
    let is_within = start > -HALF_SLAB && end < HALF_SLAB;
    return select(gathered(end) - gathered(start), way / HALF_SLAB, is_within);
}

/// Between which parameters of a view ray a slab stands [m].
fn slab_ends(seen: Seen, line: Line, length_m: f32) -> vec2<f32> {
    let ends = (vec2<f32>(-HALF_SLAB, HALF_SLAB) - line.start) / seen.a;
    return clamp(ends, vec2<f32>(0.0), vec2<f32>(length_m));
}

/// T along a segment of `length_m` of a view ray.
fn depth_of(seen: Seen, line: Line, length_m: f32) -> f32 {
    if seen.is_slab {
        return seen.k * line.peak * gathered_between(line.start, line.end, seen.a * length_m);
    }
    return seen.k * line.peak * between(line.start, line.end, seen.a * length_m);
}

/// T along the view ray from the origin in the unit direction up to `length_m`.
fn optical_depth(seen: Seen, direction: vec3<f32>, length_m: f32) -> f32 {
    return depth_of(seen, line_of(seen, direction, length_m), length_m);
}

/// T along a way of light, at once 0 where it passes so far aside that it gathers less than rounding.
fn depth_on(way: Way, blob: Blob) -> f32 {
    let seen = seen_from(blob, way.origin);
    let aside = cross(seen.b, way.direction);
    let miss_squared = dot(aside, aside);
    if miss_squared > 45.0 {
        return 0.0;
    }
    let start = -dot(seen.b, way.direction);
    let span = seen.a * way.length_m;
    return seen.k * exp(-miss_squared) * between(start, start + span, span);
}
