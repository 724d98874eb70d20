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
#ifdef SHADOWS
#import fogbank::beam
#import fogbank::grid::shafts
#endif

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
        let light = lamps[scatter.lamp];
        var value = 0.0;
#ifdef SHADOWS
        if shafts::is_shaded(scatter.lamp) {
            value = in_parts(beta, scatter.lamp, ray, length_m);
        } else {
            value = within(beta, light, ray, vec2<f32>(0.0, length_m));
        }
#else
        value = within(beta, light, ray, vec2<f32>(0.0, length_m));
#endif
        airlight += value * scatter.share * scatter.colour;
    }
    return airlight;
}

/// The closed form between two ray parameters.
fn within(beta: f32, light: lamp::Lamp, ray: view::Ray, ends: vec2<f32>) -> f32 {
#ifdef AIRLIGHT_MACKLIN2010
    return macklin2010::within(beta, light, ray.offset, ray.direction, ends);
#else
    return sun2005::within(beta, light, ray.offset, ray.direction, ends);
#endif
}

#ifdef SHADOWS
/// Parts of a ray of which a closed form is summed up where surfaces hide some of the light.
const PARTS: u32 = 24u;

/// The same as far as it is lit, part by part, even in the angle at a lamp or along the ray.
fn in_parts(beta: f32, which: u32, ray: view::Ray, length_m: f32) -> f32 {
    let light = lamps[which];
    let before = lamp::beside(light, ray.offset, ray.direction);
    let seen = shafts::look_to(which, before, ray.offset, ray.direction, length_m);
    let is_far = lamp::is_sun(light);
    let begin = beam::angle_at(before, 0.0);
    let end = beam::angle_at(before, length_m);
    var sum = 0.0;
    var last = 0.0;
    for (var part = 1u; part <= PARTS; part++) {
        let share = f32(part) / f32(PARTS);
        let even = select(beam::t_at(before, mix(begin, end, share)), share * length_m, is_far);
        let next = select(clamp(even, last, length_m), length_m, part == PARTS);
        let lit = shafts::share_between(which, seen, before, vec2<f32>(last, next));
        if lit > 0.0 {
            sum += lit * within(beta, light, ray, vec2<f32>(last, next));
        }
        last = next;
    }
    return sum;
}
#endif
