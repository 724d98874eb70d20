// What a layer shows, put together of surface radiance, fog and veil, and added to what other
// samples of the pixels show. The fog stands in a texture (from the passes that blend), in a buffer
// (FOG_BUFFER, from the compute passes), and in a draft's low resolution (FOG_LOW).
//
// The first sample of several finds edges (MARK_EDGES); the others count at those (AT_EDGES).
//
// Twins: compose in core/src/cpu/composite.rs, is_edge and weight in core/src/cpu/edges.rs.

#import fogbank::num
#import fogbank::view
#import fogbank::sparse

@group(0) @binding(0) var<uniform> frame: view::View;
@group(0) @binding(1) var hits: texture_2d<f32>;
@group(0) @binding(2) var radiance: texture_2d<f32>;
@group(0) @binding(3) var fog_texture: texture_2d<f32>;
#ifdef FOG_BUFFER
@group(0) @binding(4) var<storage, read> fog_buffer: array<vec4<f32>>;
#endif
#ifdef FOG_LOW
@group(0) @binding(5) var<storage, read> fog_low: array<vec4<f32>>;
#endif
@group(0) @binding(6) var surfaces: texture_2d<u32>;
#ifdef AT_EDGES
@group(0) @binding(7) var edges: texture_2d<u32>;
#endif

struct Sample {
    /// rgb: the layer's value by its weight. w: the weight.
    @location(0) value: vec4<f32>,
#ifdef MARK_EDGES
    /// 1 where more samples are worth while, else 0.
    @location(1) edge: u32,
#endif
}

@vertex
fn cover(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return view::covering_corner(index);
}

@fragment
fn compose(@builtin(position) at: vec4<f32>) -> Sample {
    let pixel = vec2<u32>(at.xy);
#ifdef AT_EDGES
    if textureLoad(edges, pixel, 0).x == 0u {
        discard;
    }
#endif
    let value = layer(pixel);
    // On a screen a lamp's rim is a rim only if its radiance counts no more than white.
    let weight = 1.0 / (1.0 + max(value.r, max(value.g, value.b)) * frame.weighing);
    var sample: Sample;
    sample.value = vec4<f32>(value * weight, weight);
#ifdef MARK_EDGES
    sample.edge = edge(pixel);
#endif
    return sample;
}

fn layer(pixel: vec2<u32>) -> vec3<f32> {
#ifdef LAYER_BEAUTY
    return beauty(pixel);
#else ifdef LAYER_AIRLIGHT
    return fog(pixel).rgb;
#else ifdef LAYER_SURFACE
    return textureLoad(radiance, pixel, 0).rgb;
#else ifdef LAYER_NORMAL
    return textureLoad(hits, pixel, 0).xyz;
#else ifdef LAYER_OPTICAL_DEPTH
    return vec3<f32>(fog(pixel).w, 0.0, 0.0);
#else ifdef LAYER_TRANSMITTANCE
    return vec3<f32>(num::exp_bounded(-fog(pixel).w), 0.0, 0.0);
#else
    return vec3<f32>(textureLoad(hits, pixel, 0).w, 0.0, 0.0);
#endif
}

fn beauty(pixel: vec2<u32>) -> vec3<f32> {
    let along = fog(pixel);
    let lost = num::absorptance(along.w);
    let surface = textureLoad(radiance, pixel, 0).rgb;
    let through = select(0.0, 1.0 - lost, along.w < frame.opaque);
    return surface * through + along.rgb + frame.ambient * lost;
}

/// Airlight and optical depth of a pixel.
fn fog(pixel: vec2<u32>) -> vec4<f32> {
    var sum = textureLoad(fog_texture, pixel, 0);
#ifdef FOG_BUFFER
    sum += fog_buffer[view::index_of(frame, pixel)];
#endif
#ifdef FOG_LOW
    sum += low_fog(pixel);
#endif
    return sum;
}

#ifdef FOG_LOW
fn low_fog(pixel: vec2<u32>) -> vec4<f32> {
    let around = sparse::around(frame, pixel);
    let weights = sparse::weights(frame, hits, surfaces, around, pixel);
    var sum = vec4<f32>(0.0);
    for (var i = 0u; i < 4u; i++) {
        sum += weights[i] * fog_low[sparse::index_of(frame, sparse::cell(around, i))];
    }
    return sum;
}
#endif

#ifdef MARK_EDGES
fn edge(pixel: vec2<u32>) -> u32 {
    let last = vec2<u32>(frame.size) - 1u;
    let before = max(pixel, vec2<u32>(1u)) - 1u;
    let after = min(pixel + 1u, last);
    let is_edge = differs(pixel, vec2<u32>(before.x, pixel.y))
        || differs(pixel, vec2<u32>(after.x, pixel.y))
        || differs(pixel, vec2<u32>(pixel.x, before.y))
        || differs(pixel, vec2<u32>(pixel.x, after.y));
    return select(0u, 1u, is_edge);
}

/// Whether two pixels see another surface, orientation or depth.
fn differs(a: vec2<u32>, b: vec2<u32>) -> bool {
    if textureLoad(surfaces, a, 0).x != textureLoad(surfaces, b, 0).x {
        return true;
    }
    let one = textureLoad(hits, a, 0);
    let other = textureLoad(hits, b, 0);
    let bent = any(one.xyz != other.xyz) && dot(one.xyz, other.xyz) < 0.8;
    // A jump between two parts of one surface that face the same way.
    return bent || max(one.w, other.w) > 1.5 * min(one.w, other.w);
}
#endif
