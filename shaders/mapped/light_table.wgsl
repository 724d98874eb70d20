// Where the mean extinction towards a light, T(s, x)/d of all blobs, stands in its table: by
// direction and by the logarithm of the distance, for cubics in all three coordinates.
//
// Twin: core/src/cpu/mapped/table.rs, which fills the table.

#define_import_path fogbank::mapped::light_table

#import fogbank::num

/// What a table covers.
struct Extent {
    /// Axes of the only face: across, down and towards the fog.
    across: vec3<f32>,
    /// Tangent of half the angle across; 0 for the faces of a cube.
    reach: f32,
    down: vec3<f32>,
    /// ln of the first shell's radius [m].
    first: f32,
    toward: vec3<f32>,
    /// Shells per unit of ln r.
    density: f32,
    /// Samples along the side of a face, without those beyond its edges.
    side: f32,
    shells: f32,
}

/// The samples around a place, and the weights of cubics through them.
struct Cell {
    /// The first sample, and how far it is to those of the next row and the next column.
    first: u32,
    row: u32,
    column: u32,
    rows: vec4<f32>,
    columns: vec4<f32>,
    shells: vec4<f32>,
    /// 0 if no face shows the place; less than 1 behind the last shell.
    seen: f32,
}

/// A place on a face.
struct Place {
    face: f32,
    /// −1 to 1.
    at: vec2<f32>,
    seen: f32,
}

/// For a place relative to the light.
fn cell_of(extent: Extent, way: vec3<f32>, distance_m: f32) -> Cell {
    let side = extent.side;
    let shells = extent.shells;
    let place = on_face(extent, way);
    let at = (place.at + 1.0) * (0.5 * (side - 1.0));
    let sample = clamp(floor(at), vec2<f32>(0.0), vec2<f32>(side - 2.0));
    let radial = (num::log_bounded(distance_m) - extent.first) * extent.density;
    let shell = clamp(floor(max(radial, 1.0)), 0.0, shells - 3.0);
    let between = min(max(radial, 1.0) - shell, 1.0);
    let column = u32(shells);
    let row = u32(side + 2.0) * column;
    let first = (u32(place.face * (side + 2.0) + sample.y) * row) + u32(sample.x) * column;
    let beyond = max(radial - (shells - 2.0), 0.0) / extent.density;
    let seen = place.seen * num::exp_bounded(-beyond);
    let weights = array(cubic(at.y - sample.y), cubic(at.x - sample.x), cubic(between));
    return Cell(first + u32(shell) - 1u, row, column, weights[0], weights[1], weights[2], seen);
}

/// The face that a place is seen through, and where.
fn on_face(extent: Extent, way: vec3<f32>) -> Place {
    let reach = extent.reach;
    if reach > 0.0 {
        let depth = dot(way, extent.toward);
        let aside = vec2<f32>(dot(way, extent.across), dot(way, extent.down));
        let at = aside / max(depth * reach, num::LEAST);
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

/// Weights of the cubic through samples at −1, 0, 1, 2.
fn cubic(x: f32) -> vec4<f32> {
    let outer = (x + 1.0) * x;
    let inner = (x - 1.0) * (x - 2.0);
    return vec4<f32>(
        -x * inner / 6.0,
        (x + 1.0) * inner * 0.5,
        -outer * (x - 2.0) * 0.5,
        outer * (x - 1.0) / 6.0,
    );
}
