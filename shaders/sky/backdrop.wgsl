// How bright skies are, by direction: what stands behind everything.
//
// Twins: core/src/sky/radiance.rs and core/src/sky/map.rs.

#define_import_path fogbank::sky::backdrop

#import fogbank::num
#import fogbank::sky::harmonics

/// A sky.
struct Backdrop {
    /// UNIFORM, GRADIENT, HARMONICS or IMAGE.
    kind: u32,
    /// Where its colours begin among those of all, and how many there are.
    begin: u32,
    count: u32,
    /// Bands of harmonics, or pixels of a row.
    width: u32,
}

const UNIFORM: u32 = 0u;
/// Zenith, horizon, ground.
const GRADIENT: u32 = 1u;
/// By index.
const HARMONICS: u32 = 2u;
/// Equirectangular, row by row: its middle column is −Z, right of it +X, its top +Y.
const IMAGE: u32 = 3u;

@group(0) @binding(3) var<storage, read> backdrops: array<Backdrop>;
/// rgb [W/(m² sr)].
@group(0) @binding(5) var<storage, read> colours: array<vec4<f32>>;

/// Radiance of a sky towards the unit `d`, rgb [W/(m² sr)].
fn toward(which: u32, d: vec3<f32>) -> vec3<f32> {
    let sky = backdrops[which];
    switch sky.kind {
        case GRADIENT: { return of_gradient(sky, d); }
        case HARMONICS: { return of_harmonics(sky, d); }
        case IMAGE: { return of_image(sky, d); }
        default: { return colours[sky.begin].rgb; }
    }
}

/// Linear in the sine of the elevation.
fn of_gradient(sky: Backdrop, d: vec3<f32>) -> vec3<f32> {
    let end = select(sky.begin + 2u, sky.begin, d.y > 0.0);
    return mix(colours[sky.begin + 1u].rgb, colours[end].rgb, min(abs(d.y), 1.0));
}

fn of_harmonics(sky: Backdrop, d: vec3<f32>) -> vec3<f32> {
    var sum = vec3<f32>(0.0);
    var walk = harmonics::begin();
    while harmonics::is_within(walk, sky.width) {
        let values = harmonics::values(walk);
        let middle = sky.begin + harmonics::middle(walk);
        sum += values.x * colours[middle + walk.m].rgb + values.y * colours[middle - walk.m].rgb;
        walk = harmonics::next(walk, sky.width, d);
    }
    return max(sum, vec3<f32>(0.0));
}

/// Straight between pixels.
fn of_image(sky: Backdrop, d: vec3<f32>) -> vec3<f32> {
    let height = sky.count / sky.width;
    let size = vec2<f32>(f32(sky.width), f32(height));
    let turned = num::angle(abs(d.x), -d.z);
    let azimuth = select(turned, -turned, d.x < 0.0);
    let polar = num::angle(length(d.xz), d.y);
    let x = (0.5 + azimuth / (2.0 * num::PI)) * size.x - 0.5;
    let y = clamp(polar / num::PI * size.y - 0.5, 0.0, size.y - 1.0);
    let corner = floor(vec2<f32>(x, y));
    let share = vec2<f32>(x, y) - corner;
    // Around and around: the first column is right of the last.
    let left = u32(corner.x + size.x) % sky.width;
    let right = (left + 1u) % sky.width;
    let upper = sky.begin + u32(corner.y) * sky.width;
    let lower = sky.begin + min(u32(corner.y) + 1u, height - 1u) * sky.width;
    let above = mix(colours[upper + left], colours[upper + right], share.x);
    let below = mix(colours[lower + left], colours[lower + right], share.x);
    return mix(above, below, share.y).rgb;
}
