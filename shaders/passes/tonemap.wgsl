// The mean of all samples: as it is, or brought onto a screen (SCREEN) by exposure, tone map and
// the sRGB transfer function. AGX is Troy Sobotka's: primaries drawn inwards, a logarithmic range of
// 16.5 stops around middle grey, a sigmoid as a fitted polynomial, primaries drawn out again; its
// result is display-encoded, and its brightest light is made white. REINHARD is L/(1 + L); without
// either radiance is clipped at 1.
//
// Levels are rounded here, not by the target, for their thresholds differ from pixel to pixel.
//
// Twins: core/src/image/display.rs and dither.rs.

#import fogbank::num
#import fogbank::view

@group(0) @binding(0) var<uniform> frame: view::View;
/// rgb: sum of weighted samples. w: sum of their weights.
@group(0) @binding(1) var sums: texture_2d<f32>;

@vertex
fn cover(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return view::covering_corner(index);
}

@fragment
fn show(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let sum = textureLoad(sums, vec2<u32>(at.xy), 0);
    let mean = sum.rgb / sum.w;
#ifdef SCREEN
    let shown = on_screen(mean * frame.exposure);
    return vec4<f32>(floor(shown * 255.0 + threshold(vec2<u32>(at.xy))) / 255.0, 1.0);
#else
    return vec4<f32>(mean, 1.0);
#endif
}

#ifdef SCREEN
/// Where the levels of a pixel round up, in (0, 1).
fn threshold(pixel: vec2<u32>) -> f32 {
    let place = pixel.x * 0xc13fa9a9u + pixel.y * 0x91e10da6u;
    return (f32(place >> 24u) + 0.5) / 256.0;
}

fn on_screen(rgb: vec3<f32>) -> vec3<f32> {
#ifdef AGX
    return agx(rgb);
#else ifdef REINHARD
    return srgb(rgb / (rgb + 1.0));
#else
    return srgb(rgb);
#endif
}

/// The sRGB transfer function, clamped (IEC 61966-2-1).
fn srgb(linear: vec3<f32>) -> vec3<f32> {
    let v = clamp(linear, vec3<f32>(0.0), vec3<f32>(1.0));
    let curved = 1.055 * exp(log(max(v, vec3<f32>(1e-9))) / 2.4) - 0.055;
    return select(curved, 12.92 * v, v < vec3<f32>(0.0031308));
}

const LOWEST_EV: f32 = -12.47393;
const HIGHEST_EV: f32 = 4.026069;
/// What the fit makes of the brightest light, in its darkest channel.
const WHITE: f32 = 0.9984;

fn agx(rgb: vec3<f32>) -> vec3<f32> {
    // By columns.
    let inset = mat3x3<f32>(
        vec3<f32>(0.84247906, 0.04232824, 0.042375655),
        vec3<f32>(0.0784336, 0.87846864, 0.0784336),
        vec3<f32>(0.079223745, 0.07916613, 0.87914297),
    );
    let outset = mat3x3<f32>(
        vec3<f32>(1.196879, -0.052896852, -0.052971636),
        vec3<f32>(-0.09802088, 1.1519031, -0.09804345),
        vec3<f32>(-0.099029744, -0.09896118, 1.1510737),
    );
    let stops = log2(max(inset * rgb, vec3<f32>(1e-10)));
    let place = (stops - LOWEST_EV) / (HIGHEST_EV - LOWEST_EV);
    let shown = outset * sigmoid(clamp(place, vec3<f32>(0.0), vec3<f32>(1.0))) / WHITE;
    return clamp(shown, vec3<f32>(0.0), vec3<f32>(1.0));
}

fn sigmoid(x: vec3<f32>) -> vec3<f32> {
    let high = 31.96 + x * (-40.14 + x * 15.5);
    return -0.00232 + x * (0.1191 + x * (0.4298 + x * (-6.868 + x * high)));
}
#endif
