// Optical depth of the blobs along every view ray, and with AIRLIGHT_FOGSHOP2007 the airlight of
// the lamps in them: one quad a blob, as large as it appears, added to what stands in the target.
//
// Twin: add_depth and add_airlight in core/src/cpu/kernels.rs.

#import fogbank::view
#import fogbank::screen
#import fogbank::media::gaussians
#ifdef AIRLIGHT_FOGSHOP2007
#import fogbank::num
#import fogbank::lamp
#import fogbank::airlight::fogshop2007
#endif

struct Corner {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) blob: u32,
}

@group(0) @binding(0) var<uniform> frame: view::View;
@group(0) @binding(1) var hits: texture_2d<f32>;
@group(0) @binding(2) var<storage, read> blobs: array<gaussians::Blob>;
#ifdef AIRLIGHT_FOGSHOP2007
@group(0) @binding(3) var<storage, read> lamps: array<lamp::Lamp>;
/// For every lamp and blob, lamps outside: a · (centre − light), and the exponent of f¹.
@group(0) @binding(4) var<storage, read> lit: array<vec4<f32>>;
#endif

@vertex
fn bound(@builtin(vertex_index) index: u32, @builtin(instance_index) instance: u32) -> Corner {
    let blob = blobs[instance];
    let area = screen::around_ball(frame, gaussians::center_of(blob), blob.weight.y);
    return Corner(screen::corner(area, index), instance);
}

@fragment
fn add(corner: Corner) -> @location(0) vec4<f32> {
    let pixel = vec2<u32>(corner.clip.xy);
    let length_m = textureLoad(hits, view::pixel_of(frame, pixel), 0).w;
    let ray = view::ray_of(frame, pixel);
    let seen = gaussians::seen_from(blobs[corner.blob], ray.offset);
#ifdef AIRLIGHT_FOGSHOP2007
    let crossing = fogshop2007::crossing(seen, ray.direction, length_m);
    var airlight = vec3<f32>(0.0);
    for (var i = 0u; i < frame.counts.w; i++) {
        let light = lamps[i];
        let side = lit[i * frame.counts.z + corner.blob];
        let floor_m = fogshop2007::floor_of(light);
        airlight += fogshop2007::scattered(crossing, seen, side, floor_m) * light.scattered.rgb;
    }
    return vec4<f32>(airlight / (4.0 * num::PI), crossing.depth);
#else
    let depth = gaussians::optical_depth(seen, ray.direction, length_m);
    return vec4<f32>(0.0, 0.0, 0.0, depth);
#endif
}
