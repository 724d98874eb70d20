// B-spline fogmaps (Giroud and Biri 2010): a plane of cells, in each of which β is a polynomial that a Gauss rule
// integrates exactly along a way, cell by cell.
//
// A medium in closed form: the generated module `fogbank::haze` sums these functions over its rows, a row a plane:
// the map itself, or, where view rays drop details, the map for lights and its levels for the eye.
//
// Twins: core/src/media/fogmap/{mod,plane}.rs.

#define_import_path fogbank::media::fogmap

#import fogbank::num
#import fogbank::media::vertical
#import fogbank::media::numbers

/// A plane as the host writes it; heights from the camera.
struct Row {
    /// Where the first coefficient stands: x and z [m].
    x: f32,
    z: f32,
    /// Cells a metre.
    rate: f32,
    degree: f32,
    columns: f32,
    rows: f32,
    /// Where its coefficients begin.
    first: f32,
    /// Up to which share of a view ray it counts.
    share: f32,
    /// Extinction where the map is 1 [1/m].
    extinction: f32,
    low_m: f32,
    high_m: f32,
    falloff: f32,
    /// Who sees it.
    seen: f32,
    /// The largest coefficient.
    most: f32,
    gap: f32,
    gap_too: f32,
}

const BY_LIGHTS: f32 = 1.0;
const BY_EYES: f32 = 2.0;

/// Ray parameters at which β jumps or kinks, of one row.
const EDGES: u32 = 2u;
/// β at a point, from the camera [1/m].
fn extinction(row: Row, point: vec3<f32>) -> f32 {
    if row.seen == BY_EYES {
        return 0.0;
    }
    let place = in_cells(row, point);
    if any(place < vec2<f32>(0.0)) || any(place >= cells(row)) {
        return 0.0;
    }
    let cell = floor(place);
    let there = value(row.degree, around(row, cell), place - cell);
    return row.extinction * vertical::share(profile(row), point.y) * there;
}

/// The mean of β between two points [1/m].
fn mean(row: Row, a: vec3<f32>, b: vec3<f32>) -> f32 {
    if row.seen == BY_EYES {
        return 0.0;
    }
    return row.extinction * along(row, a, b - a);
}

/// The same as view rays see it, which begin at the first point.
fn view_mean(row: Row, a: vec3<f32>, b: vec3<f32>) -> f32 {
    if row.seen == BY_LIGHTS {
        return 0.0;
    }
    return row.extinction * row.share * along(row, a, row.share * (b - a));
}

/// T from a point to beyond everything: to where its way leaves the map or its heights.
fn beyond(row: Row, point: vec3<f32>, toward: vec3<f32>, path_m: f32) -> f32 {
    if row.seen == BY_EYES {
        return 0.0;
    }
    let from_corner = point.xz - vec2<f32>(row.x, row.z);
    let size = cells(row) / row.rate;
    var length_m = vertical::ends(profile(row), point.y, toward.y, vertical::FAR);
    for (var k = 0u; k < 2u; k++) {
        let way = toward.xz[k];
        if way != 0.0 {
            let side = select(0.0, size[k], way > 0.0);
            length_m = min(length_m, max((side - from_corner[k]) / way, 0.0));
        }
    }
    length_m = select(length_m, path_m, length_m >= vertical::FAR);
    return length_m * mean(row, point, point + length_m * toward);
}

/// The least β anywhere, and the most [1/m].
fn bounds(row: Row) -> vec2<f32> {
    return vec2<f32>(0.0, select(row.extinction * row.most, 0.0, row.seen == BY_EYES));
}

/// From where to where there is any of it on a ray [m].
fn span(row: Row, origin: vec3<f32>, direction: vec3<f32>, length_m: f32) -> vec2<f32> {
    var ends = vertical::span(profile(row), origin.y, direction.y, length_m);
    let start = in_cells(row, origin);
    for (var k = 0u; k < 2u; k++) {
        let step = direction.xz[k] * row.rate;
        ends = vertical::overlap(ends, vertical::between(start[k], step, vec2<f32>(0.0, cells(row)[k]), length_m));
    }
    return ends;
}

/// The ray parameter of an edge; behind the ray's start where it has none [m].
fn edge(row: Row, which: u32, origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    if row.seen == BY_EYES {
        return -1.0;
    }
    return vertical::edge(profile(row), which, origin.y, direction.y);
}

fn profile(row: Row) -> vertical::Profile {
    return vertical::Profile(row.low_m, row.high_m, row.falloff);
}

fn in_cells(row: Row, point: vec3<f32>) -> vec2<f32> {
    return (point.xz - vec2<f32>(row.x, row.z)) * row.rate;
}

/// Columns and rows of cells.
fn cells(row: Row) -> vec2<f32> {
    return vec2<f32>(row.columns, row.rows) + row.degree;
}

fn coefficient(row: Row, i: f32, j: f32) -> f32 {
    if i < 0.0 || j < 0.0 || i >= row.columns || j >= row.rows {
        return 0.0;
    }
    return numbers::at(u32(row.first) + u32(j) * u32(row.columns) + u32(i));
}

/// Weights of the splines that count in a cell, of the one that begins there last.
fn weights(degree: f32, f: f32) -> vec3<f32> {
    if degree == 0.0 {
        return vec3<f32>(0.0, 0.0, 1.0);
    }
    if degree == 1.0 {
        return vec3<f32>(0.0, 1.0 - f, f);
    }
    let first = 0.5 * (1.0 - f) * (1.0 - f);
    let last = 0.5 * f * f;
    return vec3<f32>(first, 1.0 - first - last, last);
}

/// The coefficients that count in a cell: a column of the map each, those of the last splines last. They are read once a
/// cell.
fn around(row: Row, cell: vec2<f32>) -> mat3x3<f32> {
    let last = coefficient(row, cell.x, cell.y);
    if row.degree == 0.0 {
        return mat3x3<f32>(vec3<f32>(0.0), vec3<f32>(0.0), vec3<f32>(0.0, 0.0, last));
    }
    let here = vec3<f32>(0.0, coefficient(row, cell.x, cell.y - 1.0), last);
    let beside = vec3<f32>(
        0.0,
        coefficient(row, cell.x - 1.0, cell.y - 1.0),
        coefficient(row, cell.x - 1.0, cell.y),
    );
    if row.degree == 1.0 {
        return mat3x3<f32>(vec3<f32>(0.0), beside, here);
    }
    let above = vec3<f32>(
        coefficient(row, cell.x - 2.0, cell.y - 2.0),
        coefficient(row, cell.x - 1.0, cell.y - 2.0),
        coefficient(row, cell.x, cell.y - 2.0),
    );
    let first = vec3<f32>(
        above.x,
        coefficient(row, cell.x - 2.0, cell.y - 1.0),
        coefficient(row, cell.x - 2.0, cell.y),
    );
    return mat3x3<f32>(first, vec3<f32>(above.y, beside.yz), vec3<f32>(above.z, here.yz));
}

/// The map's value at a place of a cell.
fn value(degree: f32, around: mat3x3<f32>, f: vec2<f32>) -> f32 {
    return dot(weights(degree, f.y), around * weights(degree, f.x));
}

/// A node of the Gauss rule that is exact for a degree, and its weight.
fn node_of(degree: f32, i: u32) -> vec2<f32> {
    let t = f32(i);
    if degree == 0.0 {
        return vec2<f32>(0.5, 1.0);
    }
    if degree == 1.0 {
        return vec2<f32>(0.21132487 + t * 0.57735026, 0.5);
    }
    return vec2<f32>(0.11270167 + t * 0.38729833, select(0.2777778, 0.44444445, i == 1u));
}

/// Between which of some shares of a way a coordinate lies between two numbers.
fn within(start: f32, step: f32, low: f32, high: f32, ends: vec2<f32>) -> vec2<f32> {
    let safe = select(step, 1e-30, abs(step) < 1e-30);
    let a = (low - start) / safe;
    let b = (high - start) / safe;
    let first = min(max(min(a, b), ends.x), ends.y);
    return vec2<f32>(first, max(min(max(a, b), ends.y), first));
}

/// The mean of the map along a way, times the share at each height.
fn along(row: Row, start: vec3<f32>, way: vec3<f32>) -> f32 {
    let whole = vec2<f32>(0.0, 1.0);
    if row.falloff > 0.0 {
        let below = within(start.y, way.y, -vertical::FAR, row.low_m, whole);
        let above = within(start.y, way.y, row.low_m, vertical::FAR, whole);
        return between(row, start, way, below, false) + between(row, start, way, above, true);
    }
    return between(row, start, way, within(start.y, way.y, row.low_m, row.high_m, whole), false);
}

/// Between two shares of the way, cell by cell.
fn between(row: Row, start: vec3<f32>, way: vec3<f32>, given: vec2<f32>, falls: bool) -> f32 {
    let place = in_cells(row, start);
    let step = way.xz * row.rate;
    let count = cells(row);
    var ends = within(place.x, step.x, 0.0, count.x, given);
    ends = within(place.y, step.y, 0.0, count.y, ends);
    var sum = 0.0;
    var here = ends.x;
    if ends.x >= ends.y {
        return 0.0;
    }
    // A way passes no more sides than there are.
    let most = u32(count.x + count.y) + 4u;
    var cell = clamp(floor(place + step * here), vec2<f32>(0.0), count - 1.0);
    // Where the next sides are, of both axes.
    let ahead = select(vec2<f32>(0.0), vec2<f32>(1.0), step > vec2<f32>(0.0));
    let turn = select(vec2<f32>(-1.0), vec2<f32>(1.0), step > vec2<f32>(0.0));
    let level = abs(step) < vec2<f32>(1e-30);
    let safe = select(step, vec2<f32>(1.0), level);
    for (var i = 0u; i < most && here < ends.y; i++) {
        var sides = (cell + ahead - place) / safe;
        sides = select(sides, vec2<f32>(2.0), level);
        let next = clamp(min(sides.x, sides.y), here, ends.y);
        if next > here {
            sum += in_cell(row, start, way, vec2<f32>(here, next), cell, falls);
        }
        here = next;
        if next < ends.y {
            cell += select(vec2<f32>(0.0, turn.y), vec2<f32>(turn.x, 0.0), sides.x <= sides.y);
        }
        if any(cell < vec2<f32>(0.0)) || any(cell >= count) {
            break;
        }
    }
    return sum;
}

/// A cell's share of the mean.
fn in_cell(row: Row, start: vec3<f32>, way: vec3<f32>, given: vec2<f32>, cell: vec2<f32>, falls: bool) -> f32 {
    let coefficients = around(row, cell);
    let place = in_cells(row, start) - cell;
    let step = way.xz * row.rate;
    var sum = 0.0;
    if !falls {
        for (var i = 0u; i <= u32(row.degree); i++) {
            let node = node_of(row.degree, i);
            let at = mix(given.x, given.y, node.x);
            sum += node.y * value(row.degree, coefficients, place + step * at);
        }
        return sum * (given.y - given.x);
    }
    // Exponents behind which nothing is left, and what a rule takes.
    let rate = abs(way.y) * row.falloff;
    let reach = 40.0 / max(rate, 1e-30);
    var ends = given;
    if way.y > 0.0 {
        ends.y = min(ends.y, ends.x + reach);
    } else {
        ends.x = max(ends.x, ends.y - reach);
    }
    let parts = max(ceil((ends.y - ends.x) * rate / 4.0), 1.0);
    let part = (ends.y - ends.x) / parts;
    for (var k = 0.0; k < parts; k += 1.0) {
        for (var i = 0u; i < 8u; i++) {
            // To rounding while the exponential falls by e⁴.
            let node = num::gauss(i);
            let at = ends.x + part * (k + node.x);
            let height = vertical::share(profile(row), start.y + way.y * at);
            sum += node.y * height * value(row.degree, coefficients, place + step * at);
        }
    }
    return sum * part;
}
