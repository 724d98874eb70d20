// What a layer shows, put together of surface radiance, fog and veil. The fog may stand in a
// texture (FOG_TEXTURE, from the passes that blend), in a buffer (FOG_BUFFER, from the compute
// passes), in both, or be absent.
//
// Twin: compose in core/src/cpu/composite.rs.

#import fogbank::num
#import fogbank::view

@group(0) @binding(0) var<uniform> frame: view::View;
@group(0) @binding(1) var hits: texture_2d<f32>;
@group(0) @binding(2) var radiance: texture_2d<f32>;
#ifdef FOG_TEXTURE
@group(0) @binding(3) var fog_texture: texture_2d<f32>;
#endif
#ifdef FOG_BUFFER
@group(0) @binding(4) var<storage, read> fog_buffer: array<vec4<f32>>;
#endif

#ifdef EDGES
@group(0) @binding(5) var surfaces: texture_2d<u32>;
#endif

@vertex
fn cover(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return view::covering_corner(index);
}

@fragment
fn compose(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = vec2<u32>(at.xy);
#ifdef LAYER_BEAUTY
    return vec4<f32>(beauty(pixel), edge(pixel));
#else ifdef LAYER_AIRLIGHT
    return vec4<f32>(fog(pixel).rgb, edge(pixel));
#else ifdef LAYER_SURFACE
    return vec4<f32>(textureLoad(radiance, pixel, 0).rgb, edge(pixel));
#else ifdef LAYER_NORMAL
    return vec4<f32>(textureLoad(hits, pixel, 0).xyz, edge(pixel));
#else ifdef LAYER_OPTICAL_DEPTH
    return vec4<f32>(fog(pixel).w, 0.0, 0.0, edge(pixel));
#else ifdef LAYER_TRANSMITTANCE
    return vec4<f32>(num::exp_bounded(-fog(pixel).w), 0.0, 0.0, edge(pixel));
#else
    return vec4<f32>(textureLoad(hits, pixel, 0).w, 0.0, 0.0, edge(pixel));
#endif
}

fn beauty(pixel: vec2<u32>) -> vec3<f32> {
    let along = fog(pixel);
    let lost = num::absorptance(along.w);
    let surface = textureLoad(radiance, pixel, 0).rgb;
    return surface * (1.0 - lost) + along.rgb + frame.ambient.rgb * lost;
}

/// Airlight and optical depth of a pixel.
fn fog(pixel: vec2<u32>) -> vec4<f32> {
    var sum = vec4<f32>(0.0);
#ifdef FOG_TEXTURE
    sum += textureLoad(fog_texture, pixel, 0);
#endif
#ifdef FOG_BUFFER
    sum += fog_buffer[view::index_of(frame, pixel)];
#endif
    return sum;
}

/// 1 where EDGES are asked for and the pixel is one: there more samples are worth while. Else 0.
fn edge(pixel: vec2<u32>) -> f32 {
#ifdef EDGES
    let last = vec2<u32>(frame.size.xy) - 1u;
    let before = max(pixel, vec2<u32>(1u)) - 1u;
    let after = min(pixel + 1u, last);
    let is_edge = differs(pixel, vec2<u32>(before.x, pixel.y))
        || differs(pixel, vec2<u32>(after.x, pixel.y))
        || differs(pixel, vec2<u32>(pixel.x, before.y))
        || differs(pixel, vec2<u32>(pixel.x, after.y));
    return select(0.0, 1.0, is_edge);
#else
    return 0.0;
#endif
}

#ifdef EDGES
/// Whether two pixels see another surface, orientation or depth.
///
/// Twin: is_edge in core/src/cpu/edges.rs.
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
