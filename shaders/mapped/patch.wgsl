// The patch of the picture over which fields are interpolated: its square, and whether one set of
// nodes serves it.
//
// Twin: core/src/cpu/mapped/patch.rs.

#define_import_path fogbank::mapped::patch

#import fogbank::view::{View, Ray, sample_of, ray_through, picture_place, is_parallel}
#import fogbank::lamp::Lamp

/// What a patch may miss.
struct Tolerance {
    /// A patch is at most this share of its distance from a lamp's image.
    near: f32,
    /// Share of the fog, in optical depth, of blobs that may hide between the eight rays.
    hidden: f32,
    /// Half a patch's diagonal [rad].
    wide: f32,
    /// Relative error on the ninth ray.
    rough: f32,
    /// Relative difference of two rules that agree.
    agree: f32,
    /// Share that a rule may miss of the light that fog removes.
    unmet: f32,
    /// Rays of a layer end within this share of each other's way through the fog.
    layer: f32,
    /// A layer is at least this share of the blobs' extent.
    thin: f32,
}

/// The samples of a patch's pixels lie between xy and zw in the full picture [px].
fn area_of(view: View, first: vec2<u32>, side: u32) -> vec4<f32> {
    return vec4<f32>(sample_of(view, first), sample_of(view, first + side - 1u));
}

/// Coordinates of a place in the patch's square [−1, 1]².
fn place_in(area: vec4<f32>, sample: vec2<f32>) -> vec2<f32> {
    return (sample - middle_of(area)) / half_of(area);
}

fn middle_of(area: vec4<f32>) -> vec2<f32> {
    return 0.5 * (area.xy + area.zw);
}

/// Half its sides, never quite nothing [px].
fn half_of(area: vec4<f32>) -> vec2<f32> {
    return max(0.5 * (area.zw - area.xy), vec2<f32>(1e-2));
}

/// The view ray through a place of that square.
fn ray_at(view: View, area: vec4<f32>, place: vec2<f32>) -> Ray {
    return ray_through(view, middle_of(area) + half_of(area) * place);
}

/// Whether the patch's rays spread so much that no field is a quadratic across them.
fn is_wide(view: View, area: vec4<f32>, widest: f32) -> bool {
    let middle = ray_at(view, area, vec2<f32>(0.0)).direction;
    return distance(middle, ray_at(view, area, vec2<f32>(1.0)).direction) > widest;
}

/// Whether a lamp's image is so close that no rule serves all pixels of the patch. A lamp in the eye
/// itself is close to all of them: each ray has a floor of its own to the distance.
fn is_near(
    view: View,
    area: vec4<f32>,
    light: Lamp,
    longest: f32,
    nearest: f32,
) -> bool {
    let at = picture_place(view, light.position);
    if light.distance_m < 1e-5 * longest {
        return true;
    }
    if at.z <= 0.0 {
        return false;
    }
    let depth = select(max(at.z, 1e-9 * light.distance_m), 1.0, is_parallel(view));
    let image = (vec2<f32>(at.x, -at.y) / depth + 1.0) * 0.5 * view.size;
    let size = max(area.z - area.x, area.w - area.y);
    return size > nearest * distance(middle_of(area), image);
}
