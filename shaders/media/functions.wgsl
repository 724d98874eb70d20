// Families of functions (Biri and Michelin 2002): waves, polynomials on a period of space, and fog around objects,
// each integrated along the ray.
//
// A medium in closed form: the generated module `fogbank::haze` sums these functions over its rows. A polynomial
// is a row; its monomials stand among the numbers.
//
// Twins: core/src/media/functions/{cosine,polynomial,equipotential}.rs.

#define_import_path fogbank::media::functions

#import fogbank::num
#import fogbank::media::vertical
#import fogbank::media::numbers

/// A row as the host writes it: twelve numbers, of which the last tells the kind.
/// Waves: wave vector [turns/m], phase of the sine [turns], amplitude.
/// Polynomials: periods a metre on every axis, the first of their numbers; where a period is at the camera, monomials;
/// the least and the most, and whether powers are of 2u − 1, which keeps the digits of large terms that cancel. Their
/// numbers are the mean of all periods, the nodes of a rule that is exact, and for every monomial its coefficient and
/// in digits of 16 how many sums end behind it and which powers they are multiplied by.
/// Objects: a point, a sphere's radius; a line's direction, strength; c, d.
struct Row {
    at: array<f32, 12>,
}

const WAVE: f32 = 0.0;
const REPEATED: f32 = 1.0;
const POINT: f32 = 2.0;
const LINE: f32 = 3.0;
const SPHERE: f32 = 4.0;
/// Of one period alone.
const BOUNDED: f32 = 5.0;

/// Numbers in front of a polynomial's monomials.
const HEAD: u32 = 2u;
/// Gauss's rules of four and of eight nodes on [−1, 1], which are exact to the seventh and the fifteenth power. The sum
/// of the weights is 1.
const FOUR_NODES: vec4<f32> = vec4<f32>(-0.861136312, -0.339981044, 0.339981044, 0.861136312);
const FOUR_WEIGHTS: vec4<f32> = vec4<f32>(0.173927423, 0.326072577, 0.326072577, 0.173927423);
const INNER_NODES: vec4<f32> = vec4<f32>(-0.525532410, -0.183434642, 0.183434642, 0.525532410);
const INNER_WEIGHTS: vec4<f32> = vec4<f32>(0.156853323, 0.181341892, 0.181341892, 0.156853323);
const OUTER_NODES: vec4<f32> = vec4<f32>(-0.960289856, -0.796666477, 0.796666477, 0.960289856);
const OUTER_WEIGHTS: vec4<f32> = vec4<f32>(0.0506142681, 0.111190517, 0.111190517, 0.0506142681);

/// Ray parameters at which β jumps, of one row.
const EDGES: u32 = 6u;
/// Turns of a loop that every driver makes.
const TURNS: u32 = 50000u;

fn kind_of(row: Row) -> f32 {
    return row.at[11];
}

fn first(row: Row) -> vec3<f32> {
    return vec3<f32>(row.at[0], row.at[1], row.at[2]);
}

fn second(row: Row) -> vec3<f32> {
    return vec3<f32>(row.at[4], row.at[5], row.at[6]);
}

/// β at a point, from the camera [1/m].
fn extinction(row: Row, point: vec3<f32>) -> f32 {
    let kind = kind_of(row);
    if kind == WAVE {
        return wave(row, point);
    }
    if kind == POINT || kind == LINE || kind == SPHERE {
        return potential(row, relative(row, point));
    }
    let place = first(row) * point + second(row);
    if kind == REPEATED {
        return polynomial(row, place - floor(place));
    }
    let is_inside = all(place >= vec3<f32>(0.0)) && all(place < vec3<f32>(1.0));
    return select(0.0, polynomial(row, place), is_inside);
}

/// The mean of β between two points [1/m].
fn mean(row: Row, a: vec3<f32>, b: vec3<f32>) -> f32 {
    let kind = kind_of(row);
    if kind == WAVE {
        return mean_wave(row, a, b);
    }
    if kind == POINT || kind == LINE || kind == SPHERE {
        return mean_potential(row, a, b);
    }
    let start = first(row) * a + second(row);
    let end = first(row) * b + second(row);
    if kind != REPEATED {
        return bounded(row, start, end);
    }
    let axes = vec3<u32>(first(row) != vec3<f32>(0.0));
    if axes.x + axes.y + axes.z == 1u {
        return in_periods(row, start, end, vec3<f32>(axes));
    }
    return step_by_step(row, start, end);
}

/// The same as view rays see it.
fn view_mean(row: Row, a: vec3<f32>, b: vec3<f32>) -> f32 {
    return mean(row, a, b);
}

/// T from a point to beyond everything, which counts so far.
fn beyond(row: Row, point: vec3<f32>, toward: vec3<f32>, path_m: f32) -> f32 {
    return path_m * mean(row, point, point + path_m * toward);
}

/// From where to where there is any of it on a ray [m].
fn span(row: Row, origin: vec3<f32>, direction: vec3<f32>, length_m: f32) -> vec2<f32> {
    var ends = vec2<f32>(0.0, length_m);
    let kind = kind_of(row);
    if kind == BOUNDED {
        let start = first(row) * origin + second(row);
        let step = first(row) * direction;
        for (var k = 0u; k < 3u; k++) {
            if first(row)[k] != 0.0 {
                let own = vertical::between(start[k], step[k], vec2<f32>(0.0, 1.0), length_m);
                ends = vertical::overlap(ends, own);
            }
        }
    }
    return ends;
}

/// The least β anywhere, and the most [1/m].
fn bounds(row: Row) -> vec2<f32> {
    let kind = kind_of(row);
    if kind == WAVE {
        if all(first(row) == vec3<f32>(0.0)) {
            return vec2<f32>(wave(row, vec3<f32>(0.0)));
        }
        return abs(row.at[4]) * vec2<f32>(-1.0, 1.0);
    }
    if kind == POINT || kind == LINE || kind == SPHERE {
        let most = row.at[7] / row.at[8];
        return select(vec2<f32>(min(most, 0.0), max(most, 0.0)), vec2<f32>(most), row.at[9] == 0.0);
    }
    return vec2<f32>(row.at[8], row.at[9]);
}

/// The ray parameter of an edge; behind the ray's start where it has none [m].
fn edge(row: Row, which: u32, origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    if kind_of(row) != BOUNDED {
        return -1.0;
    }
    let axis = which / 2u;
    let rate = first(row)[axis];
    let climb = rate * direction[axis];
    let rise = f32(which % 2u) - (rate * origin[axis] + second(row)[axis]);
    if rate == 0.0 || abs(climb) * 1e30 <= abs(rise) {
        return -1.0;
    }
    return rise / climb;
}

fn wave(row: Row, x: vec3<f32>) -> f32 {
    return row.at[4] * num::sin_turns(dot(first(row), x) + row.at[3]);
}

fn mean_wave(row: Row, a: vec3<f32>, b: vec3<f32>) -> f32 {
    let turns = dot(first(row), b - a);
    let w = num::PI * turns;
    let square = w * w;
    let series = 1.0 + square * (square / 120.0 - 1.0 / 6.0);
    let is_short = abs(w) < 0.02;
    let share = select(num::sin_turns(0.5 * turns) / select(w, 0.5, is_short), series, is_short);
    return wave(row, 0.5 * (a + b)) * share;
}

/// What powers are taken of: u from 0 to 1, or what is counted from the middle of the period.
fn variable(row: Row, u: vec4<f32>) -> vec4<f32> {
    return select(u, 2.0 * u - 1.0, row.at[10] > 0.0);
}

/// A sum at four places, times a power of a variable.
fn raised(sum: vec4<f32>, variable: vec4<f32>, power: u32) -> vec4<f32> {
    var product = sum;
    for (var i = 0u; i < power; i++) {
        product *= variable;
    }
    return product;
}

/// Σ c u^p v^q w^r at four places of a period, by Horner's scheme.
fn at_four(row: Row, x: vec4<f32>, y: vec4<f32>, z: vec4<f32>) -> vec4<f32> {
    let u = variable(row, x);
    let v = variable(row, y);
    let w = variable(row, z);
    var inner = vec4<f32>(0.0);
    var middle = vec4<f32>(0.0);
    var outer = vec4<f32>(0.0);
    let first = u32(row.at[3]) + HEAD;
    for (var i = 0u; i < u32(row.at[7]); i++) {
        let step = u32(numbers::at(first + 2u * i + 1u));
        let folds = step >> 12u;
        inner = raised(inner + numbers::at(first + 2u * i), w, step & 15u);
        if folds > 0u {
            middle = raised(middle + inner, v, step >> 4u & 15u);
            inner = vec4<f32>(0.0);
        }
        if folds > 1u {
            outer = raised(outer + middle, u, step >> 8u & 15u);
            middle = vec4<f32>(0.0);
        }
    }
    return outer;
}

/// The same at one.
fn polynomial(row: Row, place: vec3<f32>) -> f32 {
    return at_four(row, place.xxxx, place.yyyy, place.zzzz).x;
}

/// The mean over all its periods.
fn mean_of_all(row: Row) -> f32 {
    return numbers::at(u32(row.at[3]));
}

/// Of one variable: parts of two periods, and the whole ones between them.
fn in_periods(row: Row, a: vec3<f32>, b: vec3<f32>, axes: vec3<f32>) -> f32 {
    let start = dot(axes, a);
    let end = dot(axes, b);
    let low = min(start, end);
    let high = max(start, end);
    let passed = floor(high) - floor(low);
    let first = low - floor(low);
    let last = high - floor(high);
    if passed < 0.5 {
        return between(row, axes * first, axes * (last - first), vec2<f32>(0.0, 1.0));
    }
    let sum = (1.0 - first) * between(row, axes * first, axes * (1.0 - first), vec2<f32>(0.0, 1.0))
        + last * between(row, vec3<f32>(0.0), axes * last, vec2<f32>(0.0, 1.0))
        + (passed - 1.0) * mean_of_all(row);
    return sum / (high - low);
}

/// Weighted β at four places of a segment.
fn weighed(row: Row, start: vec3<f32>, way: vec3<f32>, shares: vec4<f32>, weights: vec4<f32>) -> f32 {
    let x = start.x + way.x * shares;
    let y = start.y + way.y * shares;
    let z = start.z + way.z * shares;
    return dot(weights, at_four(row, x, y, z));
}

/// The mean between two shares of a segment that lie in one period: by a rule of as many nodes as its degree needs.
fn between(row: Row, start: vec3<f32>, way: vec3<f32>, ends: vec2<f32>) -> f32 {
    let middle = 0.5 * (ends.x + ends.y);
    let half = 0.5 * (ends.y - ends.x);
    if numbers::at(u32(row.at[3]) + 1u) <= 4.0 {
        return weighed(row, start, way, middle + half * FOUR_NODES, FOUR_WEIGHTS);
    }
    return weighed(row, start, way, middle + half * INNER_NODES, INNER_WEIGHTS)
        + weighed(row, start, way, middle + half * OUTER_NODES, OUTER_WEIGHTS);
}

/// Of the only period.
fn bounded(row: Row, start: vec3<f32>, end: vec3<f32>) -> f32 {
    let way = end - start;
    var ends = vec2<f32>(0.0, 1.0);
    for (var k = 0u; k < 3u; k++) {
        if first(row)[k] != 0.0 {
            let safe = select(way[k], 1e-30, abs(way[k]) < 1e-30);
            let planes = (vec2<f32>(0.0, 1.0) - start[k]) / safe;
            ends.x = min(max(ends.x, min(planes.x, planes.y)), 1.0);
            ends.y = max(min(ends.y, max(planes.x, planes.y)), 0.0);
        }
    }
    return max(ends.y - ends.x, 0.0) * between(row, start, way, ends);
}

/// Of several variables: from border to border.
fn step_by_step(row: Row, start: vec3<f32>, end: vec3<f32>) -> f32 {
    let way = end - start;
    let step = 1.0 / max(abs(way), vec3<f32>(1e-30));
    let part = start - floor(start);
    // Downwards from a whole number the first border is a period away.
    let down = select(vec3<f32>(1.0), part, part > vec3<f32>(0.0));
    let ahead = step * select(1.0 - part, down, way < vec3<f32>(0.0));
    var passed = vec3<f32>(0.0);
    var ends = vec2<f32>(0.0);
    var sum = 0.0;
    for (var many = 0u; many < 2u && ends.x < 1.0; many++) {
        for (var turn = 0u; turn < TURNS && ends.x < 1.0; turn++) {
            let borders = ahead + passed * step;
            let next = min(borders.x, min(borders.y, borders.z));
            passed += select(vec3<f32>(0.0), vec3<f32>(1.0), borders <= vec3<f32>(next));
            ends.y = min(next, 1.0);
            let cell = floor(start + way * (0.5 * (ends.x + ends.y)));
            sum += (ends.y - ends.x) * between(row, start - cell, way, ends);
            ends.x = ends.y;
        }
    }
    // The rest of a way from a light far away counts by the mean of all periods.
    return sum + (1.0 - ends.x) * mean_of_all(row);
}

/// A point from an object; of a line, across it.
fn relative(row: Row, x: vec3<f32>) -> vec3<f32> {
    let way = x - first(row);
    let line = second(row);
    return way - line * dot(way, line);
}

fn potential(row: Row, way: vec3<f32>) -> f32 {
    var square = dot(way, way);
    if kind_of(row) == SPHERE {
        let outside = max(sqrt(square) - row.at[3], 0.0);
        square = outside * outside;
    }
    return row.at[7] / (row.at[8] + row.at[9] * square);
}

fn mean_potential(row: Row, a: vec3<f32>, b: vec3<f32>) -> f32 {
    let c = row.at[8];
    let d = row.at[9];
    let start = relative(row, a);
    let end = relative(row, b);
    let way = end - start;
    let length_m = length(way);
    if d == 0.0 || length_m == 0.0 {
        return potential(row, start);
    }
    let along = way / length_m;
    let aside = cross(start, along);
    let miss2 = dot(aside, aside);
    let ends = vec2<f32>(dot(start, along), dot(end, along));
    var sum = 0.0;
    if kind_of(row) == SPHERE {
        sum = around_sphere(row, miss2, ends);
    } else {
        let m2 = miss2 + c / d;
        let m = sqrt(m2);
        sum = num::angle(m * length_m, m2 + ends.x * ends.y) / (m * d);
    }
    return sum * row.at[7] / length_m;
}

/// ∫ ds/(c + d r²) along a line that passes the sphere's middle at that squared distance, between two places
/// counted from where it is nearest.
fn around_sphere(row: Row, miss2: f32, ends: vec2<f32>) -> f32 {
    let radius = row.at[3];
    let half = sqrt(max(radius * radius - miss2, 0.0));
    let inside = max(min(ends.y, half) - max(ends.x, -half), 0.0);
    let before = outside(row, miss2, vec2<f32>(max(half, -ends.y), max(half, -ends.x)));
    let behind = outside(row, miss2, vec2<f32>(max(half, ends.x), max(half, ends.y)));
    return inside / row.at[8] + before + behind;
}

fn times(a: vec2<f32>, b: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x);
}

/// The root of a complex number in the upper half plane that lies in the first quarter.
fn root(z: vec2<f32>) -> vec2<f32> {
    let large = sqrt(0.5 * (length(z) + abs(z.x)));
    let small = 0.5 * z.y / large;
    return select(vec2<f32>(large, small), vec2<f32>(small, large), z.x < 0.0);
}

/// The same outside of the sphere, behind it.
fn outside(row: Row, miss2: f32, ends: vec2<f32>) -> f32 {
    let e = sqrt(row.at[8] / row.at[9]);
    let z = vec2<f32>(row.at[3], e);
    let s = root(vec2<f32>(z.x * z.x - z.y * z.y - miss2, 2.0 * z.x * z.y));
    let far = z + s;
    let near = vec2<f32>(far.x, -far.y) * (miss2 / dot(far, far));
    let a = logs(far, near, miss2, ends.x);
    let b = logs(far, near, miss2, ends.y);
    let difference = vec2<f32>(0.5 * num::log_bounded((b.x * a.y) / (b.y * a.x)), b.z - a.z);
    let along = times(times(z, vec2<f32>(s.x, -s.y)), difference).y / dot(s, s);
    return along / (row.at[9] * e);
}

/// ln((1 − far·t)/(1 − near·t)) at an end: squared sizes, and the angle of the quotient.
fn logs(far: vec2<f32>, near: vec2<f32>, miss2: f32, s: f32) -> vec3<f32> {
    let t = 1.0 / max(sqrt(s * s + miss2) + s, 1e-30);
    let a = vec2<f32>(1.0 - far.x * t, far.y * t);
    let b = vec2<f32>(1.0 - near.x * t, -near.y * t);
    return vec3<f32>(dot(a, a), dot(b, b), -num::angle(a.y, a.x) - num::angle(b.y, b.x));
}
