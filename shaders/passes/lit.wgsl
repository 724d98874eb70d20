// Which lamps each pixel's surface sees: a bit each of the first ones, 1 where nothing hides it.
//
// Twin: cast in core/src/cpu/shadow.rs.

#import fogbank::view
#import fogbank::lamp
#import fogbank::casters

@group(0) @binding(0) var<uniform> frame: view::View;
@group(0) @binding(1) var hits: texture_2d<f32>;
@group(0) @binding(2) var surfaces: texture_2d<u32>;
@group(0) @binding(3) var<storage, read> lamps: array<lamp::Lamp>;

@vertex
fn cover(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return view::covering_corner(index);
}

@fragment
fn mark(@builtin(position) at: vec4<f32>) -> @location(0) u32 {
    let pixel = vec2<u32>(at.xy);
    if textureLoad(surfaces, pixel, 0).x == view::NOTHING {
        return 0u;
    }
    let hit = textureLoad(hits, pixel, 0);
    let ray = view::ray_of(frame, pixel);
    let surface = ray.offset + hit.w * ray.direction;
    let point = surface + casters::LIFT * hit.w * hit.xyz;
    var bits = 0u;
    for (var i = 0u; i < min(arrayLength(&lamps), casters::MARKED); i++) {
        let faces = dot(hit.xyz, lamp::way_to(lamps[i], surface)) > 0.0;
        let is_lit = lamps[i].is_shaded == 0u || faces && !casters::hides(lamps[i], point);
        bits |= select(0u, 1u << i, is_lit);
    }
    return bits;
}
