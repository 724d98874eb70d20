// Optical depth T(s, p) between one lamp and what every pixel sees of a surface. A workgroup takes
// a tile, bounds its surface points by a ball, and finds the blobs between the lamp and that. With
// MISSING it is 0 but for pixels that a draft's low resolution lends nothing to.
//
// Twin: light_depth and blobs_between in core/src/cpu/shade.rs.

#import fogbank::view
#import fogbank::bundle
#import fogbank::lamp
#import fogbank::tile
#import fogbank::haze
#import fogbank::media::gaussians
#ifdef MISSING
#import fogbank::sparse
#endif

@group(0) @binding(0) var<uniform> frame: view::View;
@group(0) @binding(1) var hits: texture_2d<f32>;
@group(0) @binding(2) var<storage, read> blobs: array<gaussians::Blob>;
/// For every lamp of a pass, the optical depth of every pixel; lamps outside.
@group(0) @binding(3) var<storage, read_write> depths: array<f32>;
/// The blobs of this dispatch, and its lamp. The blobs from 0 on go with what is not blobs.
@group(0) @binding(4) var<uniform> part: view::Span;
@group(0) @binding(5) var<storage, read> lamps: array<lamp::Lamp>;
@group(0) @binding(6) var surfaces: texture_2d<u32>;

@compute @workgroup_size(16, 16)
fn measure(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) place: u32,
) {
    let pixel = group.xy * tile::SIDE + local.xy;
    let light = lamps[part.lamp];
    let is_sun = lamp::is_sun(light);
    let full = view::pixel_of(frame, pixel);
    let sees = view::is_inside(frame, pixel) && sees_surface(full);
    let point = point_of(pixel, full);
    var way = gaussians::way_between(light.position, point);
    if is_sun {
        way = gaussians::Way(point, light.toward, lamp::EVERYWHERE_M);
    }
    let from_here = select(point - light.position, point, is_sun);
    let between = bundle_to(place, from_here, sees, light);

    var depth = 0.0;
    for (var first = part.first; first < part.end; first += tile::CHUNK) {
        cull(first, place, between);
        for (var word = 0u; word < tile::words(part.end - first); word++) {
            var bits = tile::kept(word);
            while bits != 0u {
                let blob = first + word * 32u + firstTrailingBit(bits);
                bits &= bits - 1u;
                depth += gaussians::depth_on(way, blobs[blob]);
            }
        }
    }
    if view::is_inside(frame, pixel) {
        var rest = 0.0;
        if is_sun {
            rest = haze::beyond(point, light.toward, light.path_m);
        } else {
            let end = way.origin + way.length_m * way.direction;
            rest = way.length_m * haze::mean(way.origin, end);
        }
        store(pixel, select(0.0, depth, sees), select(0.0, rest, sees));
    }
}

/// Whether a pixel of the full picture sees a surface whose depth is asked for.
fn sees_surface(pixel: vec2<u32>) -> bool {
#ifdef MISSING
    if !sparse::is_missing(frame, hits, surfaces, pixel) {
        return false;
    }
#endif
    return textureLoad(surfaces, pixel, 0).x != view::NOTHING;
}

/// Where the pixel's ray ends, from the camera.
fn point_of(pixel: vec2<u32>, full: vec2<u32>) -> vec3<f32> {
    let ray = view::ray_of(frame, pixel);
    return ray.offset + textureLoad(hits, full, 0).w * ray.direction;
}

/// Bounds the segments from the lamp to the tile's surface points, given relative to it; of the sun relative to the
/// camera.
fn bundle_to(place: u32, way: vec3<f32>, sees: bool, light: lamp::Lamp) -> bundle::Bundle {
    let no_point = vec3<f32>(-3e38);
    let high = tile::largest(place, vec4<f32>(select(no_point, way, sees), 0.0)).xyz;
    let low = -tile::largest(place, vec4<f32>(select(no_point, -way, sees), 0.0)).xyz;
    if high.x < low.x {
        // No surface at all: nothing is near a ball without size far away.
        return bundle::all_around(vec3<f32>(3e18), 0.0);
    }
    let middle = 0.5 * (low + high);
    let aside = select(0.0, distance(way, middle), sees);
    let radius = 1.000001 * tile::largest(place, vec4<f32>(aside)).x;
    if lamp::is_sun(light) {
        return bundle::Bundle(middle, light.toward, radius, 0.0, lamp::EVERYWHERE_M);
    }
    return bundle::toward_ball(light.position, light.position + middle, radius);
}

/// Marks the blobs of a chunk that lie between the lamp and the tile's surface points.
fn cull(first: u32, place: u32, between: bundle::Bundle) {
    tile::clear(place);
    for (var at = place; at < tile::CHUNK && first + at < part.end; at += tile::SIZE) {
        let blob = blobs[first + at];
        if bundle::distance_to(between, gaussians::center_of(blob)) < blob.reach_m {
            tile::keep(at);
        }
    }
    workgroupBarrier();
}

fn store(pixel: vec2<u32>, depth: f32, rest: f32) {
    let pixels = u32(frame.targets.x) * u32(frame.targets.y);
    let at = part.slot * pixels + view::index_of(frame, pixel);
    if part.first == 0u {
        depths[at] = depth + rest;
    } else {
        depths[at] += depth;
    }
}
