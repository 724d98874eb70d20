// Optical depth along every view ray of the media in closed form, and with AIRLIGHT_SUN2005 the
// airlight of the lamps in fog that is the same everywhere; both are added to what stands in the
// target.
//
// Twin: along and add_homogeneous in core/src/cpu/fog.rs.

#import fogbank::view
#import fogbank::lamp
#import fogbank::haze
#import fogbank::airlight::sun2005

@group(0) @binding(0) var<uniform> frame: view::View;
@group(0) @binding(1) var hits: texture_2d<f32>;
#ifdef AIRLIGHT_SUN2005
@group(0) @binding(2) var<storage, read> lamps: array<lamp::Lamp>;
@group(0) @binding(3) var<storage, read> scatters: array<lamp::Scatter>;
#endif

@vertex
fn cover(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return view::covering_corner(index);
}

@fragment
fn add(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = vec2<u32>(at.xy);
    let length_m = textureLoad(hits, view::pixel_of(frame, pixel), 0).w;
    let ray = view::ray_of(frame, pixel);
    var airlight = vec3<f32>(0.0);
#ifdef AIRLIGHT_SUN2005
    let beta = haze::bounds().x;
    for (var i = 0u; i < frame.scatters; i++) {
        let scatter = scatters[i];
        let toward = lamps[scatter.lamp].position - ray.offset;
        let value = sun2005::airlight(beta, toward, ray.direction, length_m);
        airlight += value * scatter.share * scatter.colour;
    }
#endif
    return vec4<f32>(airlight, haze::depth(ray.offset, ray.direction, length_m));
}
