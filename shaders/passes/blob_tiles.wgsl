// Optical depth of the blobs along every view ray, and with AIRLIGHT_FOGSHOP2007 or AIRLIGHT_MACKLIN2010 the airlight
// of the lamps in them: a workgroup takes a tile, finds the blobs that matter to it, and sums them up along its
// rays. Adds to the buffer; with MISSING only to pixels that a draft's low resolution lends nothing to.
//
// Twins: core/src/media/gaussians/list.rs, core/src/airlight/fogshop2007/lanes.rs.

#import fogbank::view
#import fogbank::bundle
#import fogbank::tile
#import fogbank::media::gaussians
#ifdef MISSING
#import fogbank::sparse
#endif
#import fogbank::num
#import fogbank::lamp
#ifdef SHADOWS
#import fogbank::grid::shafts
#endif
#import fogbank::airlight::fogshop2007
#import fogbank::airlight::macklin2010

@group(0) @binding(0) var<uniform> frame: view::View;
@group(0) @binding(1) var hits: texture_2d<f32>;
@group(0) @binding(2) var<storage, read> blobs: array<gaussians::Blob>;
/// rgb: airlight [W/(m² sr)]. w: optical depth. Row by row.
@group(0) @binding(3) var<storage, read_write> fogged: array<vec4<f32>>;
/// The blobs of this dispatch.
@group(0) @binding(4) var<uniform> part: view::Span;
#ifdef AIRLIGHT_FOGSHOP2007
/// For every lamp and blob, lamps outside: a · (centre − light), and the exponent of f¹.
@group(0) @binding(6) var<storage, read> lit: array<vec4<f32>>;
#endif
@group(0) @binding(5) var<storage, read> lamps: array<lamp::Lamp>;
@group(0) @binding(8) var<storage, read> scatters: array<lamp::Scatter>;

#ifdef MISSING
@group(0) @binding(7) var surfaces: texture_2d<u32>;
#endif

@compute @workgroup_size(16, 16)
fn add(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) place: u32,
) {
    let pixel = group.xy * tile::SIDE + local.xy;
    let ray = view::ray_of(frame, pixel);
    var length_m = 0.0;
    if is_asked_for(pixel) {
        length_m = textureLoad(hits, view::pixel_of(frame, pixel), 0).w;
    }
    let longest = tile::largest(place, vec4<f32>(length_m)).x;
    if longest == 0.0 {
        return;
    }
    let seen_by_tile = tile::bundle(frame, group.xy, longest);

    var sum = vec4<f32>(0.0);
    for (var first = part.first; first < part.end; first += tile::CHUNK) {
        cull(first, place, seen_by_tile);
        for (var word = 0u; word < tile::words(part.end - first); word++) {
            var bits = tile::kept(word);
            while bits != 0u {
                let blob = first + word * 32u + firstTrailingBit(bits);
                bits &= bits - 1u;
                sum += along(blob, ray, length_m);
            }
        }
    }
    if is_asked_for(pixel) {
        fogged[view::index_of(frame, pixel)] += sum;
    }
}

fn is_asked_for(pixel: vec2<u32>) -> bool {
#ifdef MISSING
    return view::is_inside(frame, pixel) && sparse::is_missing(frame, hits, surfaces, pixel);
#else
    return view::is_inside(frame, pixel);
#endif
}

/// Marks the blobs of a chunk that some ray of the tile meets.
fn cull(first: u32, place: u32, rays: bundle::Bundle) {
    tile::clear(place);
    for (var at = place; at < tile::CHUNK && first + at < part.end; at += tile::SIZE) {
        let blob = blobs[first + at];
        if bundle::distance_to(rays, gaussians::center_of(blob)) < blob.reach_m {
            tile::keep(at);
        }
    }
    workgroupBarrier();
}

/// Airlight and optical depth of one blob along one ray.
fn along(place: u32, ray: view::Ray, length_m: f32) -> vec4<f32> {
    let seen = gaussians::seen_from(blobs[place], ray.offset);
#ifdef AIRLIGHT_FOGSHOP2007
    let crossing = fogshop2007::crossing(seen, ray.direction, length_m);
    var airlight = vec3<f32>(0.0);
    for (var i = 0u; i < frame.scatters; i++) {
        let scatter = scatters[i];
        let light = lamps[scatter.lamp];
        let side = lit[scatter.lamp * frame.blobs + place];
        var value = fogshop2007::scattered(crossing, seen, side, light);
#ifdef SHADOWS
        // A blob is lit as its centre on the ray is.
        let t = clamp(dot(seen.b, ray.direction) / seen.a, 0.0, length_m);
        value *= lit_between(scatter.lamp, ray, length_m, vec2<f32>(t));
#endif
        airlight += value * scatter.colour;
    }
    return vec4<f32>(airlight / (4.0 * num::PI), crossing.depth);
#else
    let line = gaussians::line_of(seen, ray.direction, length_m);
    var airlight = vec3<f32>(0.0);
#ifdef AIRLIGHT_MACKLIN2010
    let beta = seen.k * line.peak * seen.a / gaussians::HALF_SLAB;
    let ends = gaussians::slab_ends(seen, line, length_m);
    for (var i = 0u; i < frame.scatters; i++) {
        let scatter = scatters[i];
        if scatter.group == blobs[place].group {
            let light = lamps[scatter.lamp];
            var own = macklin2010::within(beta, light, ray.offset, ray.direction, ends);
#ifdef SHADOWS
            own *= lit_between(scatter.lamp, ray, length_m, ends);
#endif
            airlight += own * scatter.colour;
        }
    }
#endif
    return vec4<f32>(airlight, gaussians::depth_of(seen, line, length_m));
#endif
}

#ifdef SHADOWS
/// Share of a lamp's light between two parameters of a ray.
fn lit_between(which: u32, ray: view::Ray, length_m: f32, ends: vec2<f32>) -> f32 {
    if !shafts::is_shaded(which) {
        return 1.0;
    }
    let light = lamp::beside(lamps[which], ray.offset, ray.direction);
    let seen = shafts::look_to(which, light, ray.offset, ray.direction, length_m);
    return shafts::share_between(which, seen, light, ends);
}
#endif
