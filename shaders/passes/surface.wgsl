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
#ifdef SHADOWS
        let is_seen = surface + 1u < arrayLength(&materials);
        if is_seen && light.is_shaded == 1u && casters::hides(light, point + casters::LIFT * hit.w * hit.xyz) {
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
        sum += factor * light.strength * through;
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
