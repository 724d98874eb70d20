// Optical depth along every view ray of the media in closed form, and with AIRLIGHT_SUN2005 or AIRLIGHT_MACKLIN2010 the
// airlight of the lamps in fog that is the same everywhere; both are added to what stands in the
// target.
//
// Twin: along and add_homogeneous in core/src/cpu/fog.rs.

#import fogbank::view
#import fogbank::lamp
#import fogbank::haze
#import fogbank::airlight::sun2005
#import fogbank::airlight::macklin2010

@group(0) @binding(0) var<uniform> frame: view::View;
@group(0) @binding(1) var hits: texture_2d<f32>;
@group(0) @binding(2) var<storage, read> lamps: array<lamp::Lamp>;
@group(0) @binding(3) var<storage, read> scatters: array<lamp::Scatter>;

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
    airlight = closed(ray, length_m);
#endif
#ifdef AIRLIGHT_MACKLIN2010
    airlight = closed(ray, length_m);
#endif
    return vec4<f32>(airlight, haze::depth(ray.offset, ray.direction, length_m));
}

/// The lamps' airlight, each in closed form.
fn closed(ray: view::Ray, length_m: f32) -> vec3<f32> {
    let beta = haze::bounds().x;
    var airlight = vec3<f32>(0.0);
    for (var i = 0u; i < frame.scatters; i++) {
        let scatter = scatters[i];
        let toward = lamps[scatter.lamp].position - ray.offset;
#ifdef AIRLIGHT_MACKLIN2010
        let value = macklin2010::airlight(beta, toward, ray.direction, length_m);
#else
        let value = sun2005::airlight(beta, toward, ray.direction, length_m);
#endif
        airlight += value * scatter.share * scatter.colour;
    }
    return airlight;
}
