// Noise: view rays are bent before blobs, each by what Perlin noise says at the place of the ray that is nearest to
// the blob's centre (Fogshop 2007, section 5.5). A workgroup takes a tile and finds the blobs that its rays may be bent
// into. T changes by what they gather more or less, and of airlight as much is left as then is removed of light in
// proportion.
//
// Twins: core/src/media/noise.rs, core/src/cpu/noise.rs.

#import fogbank::num
#import fogbank::view
#import fogbank::bundle
#import fogbank::tile
#import fogbank::media::gaussians

struct Bend {
    /// Where the camera stands in the lattice [cells].
    moved: vec3<f32>,
    /// Cells a metre.
    rate: f32,
    strength: f32,
    /// How far from its straight ray a blob counts, in radii.
    reach: f32,
}

@group(0) @binding(0) var<uniform> frame: view::View;
@group(0) @binding(1) var hits: texture_2d<f32>;
@group(0) @binding(2) var<storage, read> blobs: array<gaussians::Blob>;
/// What passes that compute have made of the fog. rgb: airlight [W/(m² sr)]. w: optical depth. Row by row.
@group(0) @binding(3) var<storage, read_write> fogged: array<vec4<f32>>;
/// The same from passes that draw.
@group(0) @binding(4) var drawn: texture_2d<f32>;
@group(0) @binding(5) var<uniform> bend: Bend;
/// Three a place of the lattice: a gradient for each component.
@group(0) @binding(6) var<storage, read> gradients: array<vec4<f32>>;

/// Cells of the lattice along a period.
const CELLS: f32 = 8.0;
/// What stands for light removed where there is hardly any fog.
const HARDLY: f32 = 1e-4;

@compute @workgroup_size(16, 16)
fn bend_rays(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) place: u32,
) {
    let pixel = group.xy * tile::SIDE + local.xy;
    let ray = view::ray_of(frame, pixel);
    let is_inside = view::is_inside(frame, pixel);
    var length_m = 0.0;
    if is_inside {
        length_m = textureLoad(hits, view::pixel_of(frame, pixel), 0).w;
    }
    let longest = tile::largest(place, vec4<f32>(length_m)).x;
    let seen_by_tile = tile::bundle(frame, group.xy, longest);
    var more = 0.0;
    for (var first = 0u; first < frame.blobs; first += tile::CHUNK) {
        cull(first, place, seen_by_tile);
        for (var word = 0u; word < tile::words(frame.blobs - first); word++) {
            var bits = tile::kept(word);
            while bits != 0u {
                let blob = first + word * 32u + firstTrailingBit(bits);
                bits &= bits - 1u;
                more += change(blobs[blob], ray, length_m);
            }
        }
    }
    if is_inside {
        let index = view::index_of(frame, pixel);
        let other = textureLoad(drawn, pixel, 0);
        let straight = fogged[index] + other;
        let bent = max(straight.w + more, 0.0);
        let share = removed(bent) / removed(straight.w);
        fogged[index] = vec4<f32>(straight.rgb * share, bent) - other;
    }
}

/// Light removed along a ray.
fn removed(depth: f32) -> f32 {
    return HARDLY + num::absorptance(depth);
}

/// Marks the blobs of a chunk that some ray of the tile may be bent into.
fn cull(first: u32, place: u32, rays: bundle::Bundle) {
    tile::clear(place);
    for (var at = place; at < tile::CHUNK && first + at < frame.blobs; at += tile::SIZE) {
        let blob = blobs[first + at];
        if bundle::distance_to(rays, gaussians::center_of(blob)) * blob.a < bend.reach {
            tile::keep(at);
        }
    }
    workgroupBarrier();
}

/// By how much T of a blob grows where the ray is bent before it.
fn change(blob: gaussians::Blob, ray: view::Ray, length_m: f32) -> f32 {
    let seen = gaussians::seen_from(blob, ray.offset);
    let aside = cross(seen.b, ray.direction);
    if dot(aside, aside) > bend.reach * bend.reach {
        return 0.0;
    }
    let nearest = ray.offset + ray.direction * (dot(seen.b, ray.direction) / seen.a);
    let bent = ray.direction + noise(nearest) * (bend.strength / max(length(seen.b), 1.0));
    let size = length(bent);
    if size == 0.0 {
        return 0.0;
    }
    return gaussians::optical_depth(seen, bent / size, length_m)
        - gaussians::optical_depth(seen, ray.direction, length_m);
}

/// The noise at a place, which is given from the camera [m].
fn noise(point: vec3<f32>) -> vec3<f32> {
    let place = point * bend.rate + bend.moved;
    let corner = floor(place);
    let part = place - corner;
    let fade = part * part * part * (part * (part * 6.0 - 15.0) + 10.0);
    let first = corner - CELLS * floor(corner / CELLS);
    var sum = vec3<f32>(0.0);
    for (var i = 0u; i < 8u; i++) {
        let step = vec3<f32>(f32(i & 1u), f32(i >> 1u & 1u), f32(i >> 2u));
        let share = mix(1.0 - fade, fade, step);
        let at = first + step - CELLS * floor((first + step) / CELLS);
        let index = 3u * u32((at.z * CELLS + at.y) * CELLS + at.x);
        let way = part - step;
        let own = vec3<f32>(
            dot(gradients[index].xyz, way),
            dot(gradients[index + 1u].xyz, way),
            dot(gradients[index + 2u].xyz, way),
        );
        sum += share.x * share.y * share.z * own;
    }
    return sum;
}
