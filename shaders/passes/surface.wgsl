// Radiance that the surface seen by every pixel sends towards the eye: its own, and what it
// reflects of the lamps, each dimmed by the fog between. Without BLOBS that fog is what
// stands in closed form; with LOW most depths come from a draft's low resolution, with TABLES all of them from
// those of the lamps. Added to the target, so that lamps may be taken in several passes.
//
// Twin: surface_radiance in core/src/cpu/shade.rs.

#import fogbank::num
#import fogbank::view
#import fogbank::lamp
#import fogbank::beam
#import fogbank::sparse
#import fogbank::haze
#import fogbank::surface::attenuated
#ifdef TABLES
#import fogbank::grid::light_table
#endif
#ifdef SHADOWS
#import fogbank::casters
#endif

@group(0) @binding(0) var<uniform> frame: view::View;
@group(0) @binding(1) var hits: texture_2d<f32>;
@group(0) @binding(2) var surfaces: texture_2d<u32>;
@group(0) @binding(3) var<storage, read> lamps: array<lamp::Lamp>;
/// One more than there are surfaces: the last one is what stands where nothing is seen.
@group(0) @binding(4) var<storage, read> materials: array<attenuated::Material>;
/// The lamps of this pass. Emission goes with the one at 0.
@group(0) @binding(5) var<uniform> part: view::Span;
#ifdef BLOBS
/// For every lamp of this pass, its optical depth to every pixel's surface; lamps outside.
@group(0) @binding(6) var<storage, read> depths: array<f32>;
#endif
#ifdef TABLES
/// What each lamp's table covers.
@group(0) @binding(8) var<storage, read> extents: array<light_table::Extent>;
#endif
#ifdef SHADOWS
/// Which lamps each pixel sees.
@group(0) @binding(9) var marks: texture_2d<u32>;
/// Where pixels at the rim of a shadow are looked at again, from their centres [px].
const WITHIN: array<vec2<f32>, 4> = array<vec2<f32>, 4>(
    vec2<f32>(-0.125, -0.375),
    vec2<f32>(0.375, -0.125),
    vec2<f32>(0.125, 0.375),
    vec2<f32>(-0.375, 0.125),
);
#endif
#ifdef LOW
/// The same in the low resolution; 0 stands above for what comes from here.
@group(0) @binding(7) var<storage, read> low_depths: array<f32>;
#endif

@vertex
fn cover(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return view::covering_corner(index);
}

@fragment
fn add(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = vec2<u32>(at.xy);
    let full = view::pixel_of(frame, pixel);
    let hit = textureLoad(hits, full, 0);
    let ray = view::ray_of(frame, pixel);
    let point = ray.offset + hit.w * ray.direction;
    let surface = min(textureLoad(surfaces, full, 0).x, arrayLength(&materials) - 1u);
    let material = materials[surface];
    var sum = select(vec3<f32>(0.0), material.emission, part.first == 0u);
#ifdef LOW
    let around = sparse::around(frame, pixel);
    let weights = sparse::weights(frame, hits, surfaces, around, pixel);
#endif
    for (var i = part.first; i < part.end; i++) {
        let light = lamps[i];
        var share = 1.0;
#ifdef SHADOWS
        let is_seen = surface + 1u < arrayLength(&materials);
        if is_seen && light.is_shaded == 1u {
            share = lit_share(i, pixel, point + casters::LIFT * hit.w * hit.xyz, hit.xyz);
        }
        if share == 0.0 {
            continue;
        }
#endif
        let toward = lamp::way_to(light, point);
        var depth = depth_of(i, pixel, point, toward);
#ifdef LOW
        depth += low_depth(i, around, weights);
#endif
        let through = num::exp_bounded(-depth) * beam::weight(light, -normalize(toward));
        let reflected = attenuated::reflection(
            hit.xyz,
            ray.direction,
            toward,
            material.shininess,
            hit.w * lamp::MISS_FLOOR,
        );
        let factor = material.diffuse * reflected.diffuse
            + material.specular * reflected.specular;
        sum += factor * light.strength * (through * share);
    }
    return vec4<f32>(sum, 0.0);
}

/// T(s, p) of a lamp at the pixel's surface.
fn depth_of(place: u32, pixel: vec2<u32>, point: vec3<f32>, toward: vec3<f32>) -> f32 {
#ifdef CLEAR
    return 0.0;
#else ifdef BLOBS
    let pixels = u32(frame.targets.x) * u32(frame.targets.y);
    return depths[(place - part.first) * pixels + view::index_of(frame, pixel)];
#else
    let light = lamps[place];
    if lamp::is_sun(light) {
        var depth = haze::beyond(point, light.toward, light.path_m);
#ifdef TABLES
        depth += light_table::mean(extents[place], point - light.position, 0.0);
#endif
        return depth;
    }
    let distance_m = length(toward);
    var mean = haze::mean(point, point + toward);
#ifdef TABLES
    mean += light_table::mean(extents[place], -toward, distance_m);
#endif
    return mean * distance_m;
#endif
}

#ifdef SHADOWS
/// How much of a pixel a lamp reaches, whose surface is at a point with a unit normal.
fn lit_share(which: u32, pixel: vec2<u32>, point: vec3<f32>, normal: vec3<f32>) -> f32 {
    if which >= casters::MARKED {
        return select(1.0, 0.0, casters::hides(lamps[which], point));
    }
    let own = mark_of(pixel, which);
    if frame.soft == 0u || !is_rim(pixel, which, own) {
        return f32(own);
    }
    var within = WITHIN;
    var sum = 0.0;
    for (var i = 0u; i < 4u; i++) {
        let ray = view::ray_through(frame, view::sample_of(frame, pixel) + within[i]);
        let t = dot(point - ray.offset, normal) / dot(ray.direction, normal);
        let on_plane = ray.offset + t * ray.direction;
        // Across an edge or at a grazing angle the plane leads astray.
        let is_near = distance(on_plane, point) < 0.1 * distance(point, ray.offset);
        let place = select(point, on_plane, is_near);
        sum += select(0.25, 0.0, casters::hides(lamps[which], place));
    }
    return sum;
}

fn mark_of(pixel: vec2<u32>, which: u32) -> u32 {
    return textureLoad(marks, pixel, 0).x >> which & 1u;
}

/// Whether a pixel beside sees a surface in another light.
fn is_rim(pixel: vec2<u32>, which: u32, own: u32) -> bool {
    let last = vec2<u32>(frame.targets) - 1u;
    let before = max(pixel, vec2<u32>(1u)) - 1u;
    let after = min(pixel + 1u, last);
    return differs(vec2<u32>(before.x, pixel.y), which, own)
        || differs(vec2<u32>(after.x, pixel.y), which, own)
        || differs(vec2<u32>(pixel.x, before.y), which, own)
        || differs(vec2<u32>(pixel.x, after.y), which, own);
}

fn differs(pixel: vec2<u32>, which: u32, own: u32) -> bool {
    let is_seen = textureLoad(surfaces, pixel, 0).x != view::NOTHING;
    return is_seen && mark_of(pixel, which) != own;
}
#endif

#ifdef LOW
fn low_depth(place: u32, around: sparse::Around, weights: vec4<f32>) -> f32 {
    let size = sparse::size_of(frame);
    let first = (place - part.first) * size.x * size.y;
    var sum = 0.0;
    for (var i = 0u; i < 4u; i++) {
        sum += weights[i] * low_depths[first + sparse::index_of(frame, sparse::cell(around, i))];
    }
    return sum;
}
#endif
