// The mean extinction towards a light, T(s, x)/d of all blobs, as it stands in the light's table: by
// direction and by the logarithm of the distance, with straight lines between samples in all three
// coordinates. Of the sun T itself stands there, on a square across its way and at even steps along it.
//
// Twin: core/src/frame/light_table.rs, which fills the table.

#define_import_path fogbank::grid::light_table

#import fogbank::num

/// What a table covers.
struct Extent {
    /// Axes of the only face: across, down and towards the fog.
    across: vec3<f32>,
    /// Tangent of half the angle across, of the sun half the side [m]; 0 for the faces of a cube.
    reach: f32,
    down: vec3<f32>,
    /// ln of the first shell's radius [m]; of the sun how far the first lies.
    first: f32,
    toward: vec3<f32>,
    /// Shells per unit of that.
    density: f32,
    /// Samples along the side of a face, without those beyond its edges.
    side: f32,
    /// 0 where the light has no table.
    shells: f32,
    /// Where its samples begin among those of all lights.
    begin: u32,
    /// 1 for the sun.
    parallel: u32,
}

/// A place on a face.
struct Place {
    face: f32,
    /// −1 to 1.
    at: vec2<f32>,
    /// 0 if no face shows it.
    seen: f32,
}

/// Samples of all lights: `[face][row][column][shell]`, two rows and columns beyond each face's edges.
@group(0) @binding(16) var<storage, read> samples: array<f32>;

/// The mean to a place relative to the light [1/m]; T of the sun's.
fn mean(extent: Extent, way: vec3<f32>, distance_m: f32) -> f32 {
    let place = on_face(extent, way);
    let at = (place.at + 1.0) * (0.5 * (extent.side - 1.0));
    let sample = clamp(floor(at), vec2<f32>(0.0), vec2<f32>(extent.side - 2.0));
    let is_parallel = extent.parallel == 1u;
    let far = select(num::log_bounded(distance_m), dot(way, extent.toward), is_parallel);
    let radial = (far - extent.first) * extent.density;
    let last = extent.shells - 2.0;
    let shell = clamp(floor(max(radial, 1.0)), 0.0, last - 1.0);
    let part = vec3<f32>(at - sample, min(max(radial, 1.0) - shell, 1.0));
    let column = u32(extent.shells);
    let row = u32(extent.side + 2.0) * column;
    let corner = vec2<u32>(sample) + 1u;
    let face = u32(place.face) * u32(extent.side + 2.0);
    let i = extent.begin + (face + corner.y) * row + corner.x * column + u32(shell);
    let near = vec4<f32>(samples[i], samples[i + column], samples[i + row], samples[i + row + column]);
    let j = i + 1u;
    let behind = vec4<f32>(samples[j], samples[j + column], samples[j + row], samples[j + row + column]);
    let along = mix(near, behind, part.z);
    let across = mix(along.xz, along.yw, part.x);
    // Behind the last shell nothing is added.
    let beyond = select(max(radial - last, 0.0) / extent.density, 0.0, is_parallel);
    return max(mix(across.x, across.y, part.y), 0.0) * num::exp_bounded(-beyond) * place.seen;
}

/// The face that a place is seen through, and where.
fn on_face(extent: Extent, way: vec3<f32>) -> Place {
    let reach = extent.reach;
    if reach > 0.0 {
        let depth = dot(way, extent.toward);
        let aside = vec2<f32>(dot(way, extent.across), dot(way, extent.down));
        let ahead = select(depth, 1.0, extent.parallel == 1u);
        let at = aside / max(ahead * reach, num::LEAST);
        let shown = depth > 0.0 && max(abs(at.x), abs(at.y)) <= 1.0;
        return Place(0.0, clamp(at, vec2<f32>(-1.0), vec2<f32>(1.0)), select(0.0, 1.0, shown));
    }
    let size = abs(way);
    // The coordinate that is largest, and the two others in cyclic order.
    var face = 0.0;
    var turned = way;
    if size.x < size.y {
        face = 2.0;
        turned = way.yzx;
    }
    if max(size.x, size.y) < size.z {
        face = 4.0;
        turned = way.zxy;
    }
    face += select(0.0, 1.0, turned.x < 0.0);
    return Place(face, turned.yz / max(abs(turned.x), num::LEAST), 1.0);
}
