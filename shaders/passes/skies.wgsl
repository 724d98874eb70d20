// Light of skies that surfaces send towards the eye, and skies themselves where nothing is seen, added to the target.
//
// Twin: add_to_surfaces in core/src/cpu/sky.rs.

#import fogbank::num
#import fogbank::view
#import fogbank::sky::backdrop
#import fogbank::sky::table
#import fogbank::surface::attenuated

@group(0) @binding(0) var<uniform> frame: view::View;
@group(0) @binding(1) var hits: texture_2d<f32>;
@group(0) @binding(2) var surfaces: texture_2d<u32>;
@group(0) @binding(4) var<storage, read> materials: array<attenuated::Material>;

/// Bands of harmonics of light that matte surfaces get.
const MATTE: u32 = 3u;

@vertex
fn cover(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return view::covering_corner(index);
}

@fragment
fn add(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = vec2<u32>(at.xy);
    let ray = view::ray_of(frame, pixel);
    let surface = textureLoad(surfaces, pixel, 0).x;
    var sum = vec3<f32>(0.0);
    if surface == view::NOTHING {
        for (var i = 0u; i < arrayLength(&backdrop::backdrops); i++) {
            sum += backdrop::toward(i, ray.direction);
        }
        return vec4<f32>(sum, 0.0);
    }
    let hit = textureLoad(hits, pixel, 0);
    let point = ray.offset + hit.w * ray.direction;
    for (var i = 0u; i < arrayLength(&table::tables); i++) {
        sum += sent(i, materials[surface], point, hit.xyz, ray.direction);
    }
    return vec4<f32>(sum, 0.0);
}

/// What a surface with the unit `normal` on the eye's side sends on of a sky.
fn sent(
    which: u32,
    material: attenuated::Material,
    point: vec3<f32>,
    normal: vec3<f32>,
    direction: vec3<f32>,
) -> vec3<f32> {
    let order = table::tables[which].order;
    let is_glossy = any(material.specular != vec3<f32>(0.0));
    let mirrored = direction - 2.0 * dot(normal, direction) * normal;
    let share = above(material.shininess, dot(mirrored, normal));
    var sum = vec3<f32>(0.0);
    for (var c = 0u; c < table::tables[which].channels; c++) {
        let matte = table::lobe(which, c, point, normal, min(MATTE, order), of_cosine());
        var factor = material.diffuse * (matte / num::PI);
        if is_glossy {
            let bands = of_lobe(material.shininess);
            factor += material.specular * (share * table::lobe(which, c, point, mirrored, order, bands));
        }
        sum += factor * table::tables[which].colours[c].rgb;
    }
    return sum;
}

/// What the cosine over a half space leaves of each band (Ramamoorthi and Hanrahan 2001).
fn of_cosine() -> array<f32, 6> {
    let pi = num::PI;
    return array<f32, 6>(pi, 2.0 * pi / 3.0, pi / 4.0, 0.0, -pi / 24.0, 0.0);
}

/// The same of the lobe cosⁿ: 2π ∫ xⁿ Pₗ(x) dx from 0 to 1, by two bands at a time.
fn of_lobe(n: f32) -> array<f32, 6> {
    let even = 2.0 * num::PI / (vec3<f32>(n) + vec3<f32>(1.0, 3.0, 5.0));
    let odd = 2.0 * num::PI / (vec3<f32>(n) + vec3<f32>(2.0, 4.0, 6.0));
    return array<f32, 6>(
        even.x,
        odd.x,
        1.5 * even.y - 0.5 * even.x,
        2.5 * odd.y - 1.5 * odd.x,
        (35.0 * even.z - 30.0 * even.y + 3.0 * even.x) / 8.0,
        (63.0 * odd.z - 70.0 * odd.y + 15.0 * odd.x) / 8.0,
    );
}

/// Which share of the lobe cosⁿ goes out of a surface, near enough, given the cosine between its middle and the
/// normal: of a narrow one as of a Gaussian.
fn above(n: f32, cosine: f32) -> f32 {
    return 0.5 * (1.0 + num::erf(1.1 * cosine * sqrt(0.5 * (n + 1.0))));
}
