// What is left of skies at places in the fog, as it stands in their tables: at places on planes across the axes, ln of
// the first harmonic of what arrives there, and the others as shares of it; between places straight lines.
//
// Twins: core/src/frame/sky_table.rs, which fills the tables, and toward in core/src/cpu/sky.rs.

#define_import_path fogbank::sky::table

#import fogbank::lamp
#import fogbank::sky::harmonics

/// What a table covers.
struct Table {
    /// From where its planes are counted, from the camera [m].
    origin: vec3<f32>,
    /// Where its numbers begin among those of all: where the planes across x, y and z stand, and behind them
    /// `[z][y][x][channel][harmonic]`.
    begin: u32,
    /// Planes across each axis.
    size: vec3<u32>,
    /// Bands of harmonics.
    order: u32,
    /// What its channels stand for, rgb.
    colours: array<vec4<f32>, 3>,
    channels: u32,
}

/// The eight places around a point.
struct Corners {
    /// Where the numbers of those begin that lie at the lower z, and at the higher one.
    low: vec4<u32>,
    high: vec4<u32>,
    /// How far it is between them.
    share: vec3<f32>,
}

/// Most bands of harmonics.
const BANDS: u32 = 6u;
/// No less is left of what goes on along a ray, as a share of all that arrives.
const LEAST: f32 = 1e-4;

@group(0) @binding(10) var<storage, read> tables: array<Table>;
@group(0) @binding(13) var<storage, read> numbers: array<f32>;

/// T of a lamp that stands for a channel of a sky: −ln of what is left of it at a point and goes on along the unit `d`,
/// by the most that does anywhere.
fn depth(light: lamp::Lamp, point: vec3<f32>, d: vec3<f32>) -> f32 {
    let which = light.sky - 1u;
    var of_bands = array<f32, 6>(1.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for (var l = 1u; l < BANDS; l++) {
        of_bands[l] = of_bands[l - 1u] * light.sky_g;
    }
    let order = select(tables[which].order, 1u, light.sky_g == 0.0);
    let left = sum(which, light.channel, point, d, order, of_bands);
    return light.log_most - left.x - log(max(left.y, LEAST));
}

/// x: ln of the first harmonic of a channel of what arrives at a point. y: the sum of all below `order` towards the
/// unit `d`, each by the factor of its band, as a share of the first.
fn sum(
    which: u32,
    channel: u32,
    point: vec3<f32>,
    d: vec3<f32>,
    order: u32,
    factors: array<f32, 6>,
) -> vec2<f32> {
    var of_bands = factors;
    let corners = corners_of(which, channel, point);
    let log = between(corners, 0u);
    var share = of_bands[0] * harmonics::FIRST;
    var walk = harmonics::next(harmonics::begin(), order, d);
    while harmonics::is_within(walk, order) {
        let values = of_bands[walk.band] * harmonics::values(walk);
        let middle = harmonics::middle(walk);
        share += values.x * between(corners, middle + walk.m);
        if walk.m > 0u {
            share += values.y * between(corners, middle - walk.m);
        }
        walk = harmonics::next(walk, order, d);
    }
    return vec2<f32>(log, share);
}

/// What goes out of a lobe around `d`, given by what it leaves of each band.
fn lobe(
    which: u32,
    channel: u32,
    point: vec3<f32>,
    d: vec3<f32>,
    order: u32,
    of_bands: array<f32, 6>,
) -> f32 {
    let left = sum(which, channel, point, d, order, of_bands);
    return exp(left.x) * max(left.y, 0.0);
}

fn corners_of(which: u32, channel: u32, point: vec3<f32>) -> Corners {
    let table = tables[which];
    let at = point - table.origin;
    let x = side(table.begin, table.size.x, at.x);
    let y = side(table.begin + table.size.x, table.size.y, at.y);
    let z = side(table.begin + table.size.x + table.size.y, table.size.z, at.z);
    let across = vec4<u32>(x.first, x.next, x.first, x.next);
    let down = vec4<u32>(y.first, y.first, y.next, y.next) * table.size.x;
    let layer = table.size.x * table.size.y;
    let of_channel = table.order * table.order;
    let stride = of_channel * table.channels;
    let begin = table.begin + table.size.x + table.size.y + table.size.z + channel * of_channel;
    return Corners(
        begin + (across + down + z.first * layer) * stride,
        begin + (across + down + z.next * layer) * stride,
        vec3<f32>(x.share, y.share, z.share),
    );
}

/// The planes before and behind a coordinate.
struct Side {
    first: u32,
    next: u32,
    share: f32,
}

fn side(begin: u32, count: u32, at: f32) -> Side {
    // The first plane behind it.
    var low = 0u;
    var high = count;
    while low < high {
        let half = (low + high) / 2u;
        if numbers[begin + half] <= at {
            low = half + 1u;
        } else {
            high = half;
        }
    }
    let first = min(max(low, 1u) - 1u, max(count, 2u) - 2u);
    let next = min(first + 1u, count - 1u);
    let width = numbers[begin + next] - numbers[begin + first];
    let share = (at - numbers[begin + first]) / select(1.0, width, width > 0.0);
    return Side(first, next, select(0.0, clamp(share, 0.0, 1.0), width > 0.0));
}

/// A number of the places around a point.
fn between(corners: Corners, which: u32) -> f32 {
    let a = corners.low + which;
    let b = corners.high + which;
    let low = vec4<f32>(numbers[a.x], numbers[a.y], numbers[a.z], numbers[a.w]);
    let high = vec4<f32>(numbers[b.x], numbers[b.y], numbers[b.z], numbers[b.w]);
    let across = mix(low, high, corners.share.z);
    let along = mix(across.xz, across.yw, corners.share.x);
    return mix(along.x, along.y, corners.share.y);
}
