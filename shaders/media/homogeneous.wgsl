// Fog that is the same everywhere, β(x) = β₀ and T(a, b) = β₀ |a − b| (Sun 2005, eq. 3), or changes with
// height alone: T is the length times the mean of β between the heights of the ends.
//
// A medium in closed form: the generated module `fogbank::haze` sums these functions over its rows.
//
// Twins: core/src/media/homogeneous/mod.rs, core/src/media/vertical.rs.

#define_import_path fogbank::media::homogeneous

#import fogbank::num
#import fogbank::media::vertical

/// A row as the host writes it; heights from the camera.
struct Row {
    /// Extinction [1/m].
    extinction: f32,
    /// The lower end, from which on it falls off if it does [m].
    low_m: f32,
    /// The upper end [m].
    high_m: f32,
    /// Falloff above the lower end [1/m]; 0 for what is the same between both.
    falloff: f32,
}

/// Ray parameters at which β jumps or kinks, of one row.
const EDGES: u32 = 2u;

/// β at a point, from the camera [1/m].
fn extinction(row: Row, point: vec3<f32>) -> f32 {
    return row.extinction * vertical::share(profile(row), point.y);
}

/// The mean of β between two points [1/m].
fn mean(row: Row, a: vec3<f32>, b: vec3<f32>) -> f32 {
    let low = min(a.y, b.y);
    let high = max(a.y, b.y);
    if low >= high {
        return extinction(row, a);
    }
    var sum = max(min(high, row.high_m) - max(low, row.low_m), 0.0);
    if row.falloff > 0.0 {
        let turn = max(min(high, row.low_m), low);
        let above = high - turn;
        sum = turn - low + above * vertical::share(profile(row), turn) * falling_mean(above * row.falloff);
    }
    return row.extinction * sum / (high - low);
}

/// The same as view rays see it.
fn view_mean(row: Row, a: vec3<f32>, b: vec3<f32>) -> f32 {
    return mean(row, a, b);
}

/// T from a point to beyond everything; what has no end there counts so far.
fn beyond(row: Row, point: vec3<f32>, toward: vec3<f32>, path_m: f32) -> f32 {
    let length_m = vertical::ends(profile(row), point.y, toward.y, path_m);
    return length_m * mean(row, point, point + length_m * toward);
}

/// The least β anywhere, and the most [1/m].
fn bounds(row: Row) -> vec2<f32> {
    let is_uniform = row.low_m < -vertical::FAR && row.high_m > vertical::FAR;
    return vec2<f32>(select(0.0, row.extinction, is_uniform), row.extinction);
}

/// From where to where there is any of it on a ray [m].
fn span(row: Row, origin: vec3<f32>, direction: vec3<f32>, length_m: f32) -> vec2<f32> {
    let nothing = vec2<f32>(vertical::FAR, -vertical::FAR);
    return select(nothing, vertical::span(profile(row), origin.y, direction.y, length_m), row.extinction > 0.0);
}

/// The ray parameter of an edge; behind the ray's start where it has none [m].
fn edge(row: Row, which: u32, origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    return vertical::edge(profile(row), which, origin.y, direction.y);
}

fn profile(row: Row) -> vertical::Profile {
    return vertical::Profile(row.low_m, row.high_m, row.falloff);
}

/// (1 − e^(−x))/x: the mean of e^(−x) from 0 on.
fn falling_mean(x: f32) -> f32 {
    return select(1.0, num::absorptance(x) / x, x > 1e-30);
}
