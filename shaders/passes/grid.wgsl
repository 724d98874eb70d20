// Airlight of pictures for the eye and of drafts: tabulated on a coarse grid of rays, cumulative along depth,
// and looked up by every pixel at its own ray and its own end; and T of the blobs, from the same rays.
//
// A workgroup takes a square cell of the picture. Eight rays around it are tabulated at the knots of its block,
// and a ninth tells whether they will do. A cell of which they do not, that a lamp's image is near, where blobs
// hide between the rays or that an edge of the fog passes is left to the next dispatch, in quarters; those of
// the smallest cells get rays of their own, one a pixel.
//
// What is tabulated is the airlight up to t divided by what is known in closed form,
//
//     R(t) = L(t) / (M(t) · (1 − e^(−T(t)) + ε t)/t),
//
// M the glow of the lamp without fog. A pixel multiplies R by its own M and T again.
//
// Twins: core/src/cpu/grid/{mod,cells,table,rule,look_up}.rs.

#import fogbank::num
#import fogbank::view
#import fogbank::bundle
#import fogbank::lamp
#import fogbank::beam
#import fogbank::haze
#import fogbank::media::gaussians
#import fogbank::grid::around
#import fogbank::grid::block
#import fogbank::grid::cell
#import fogbank::grid::crossing
#import fogbank::grid::glow
#import fogbank::grid::light_table
#import fogbank::grid::rule
#import fogbank::grid::shafts
#import fogbank::sky::table as sky

/// The work of a dispatch.
struct Task {
    /// Pixels along the side of a cell: 32 to 4; 2 where they are alone.
    side: u32,
    /// 1 where each of its pixels has a ray of its own.
    alone: u32,
    /// 1 where only pixels at edges count.
    at_edges: u32,
}

/// Cells, a workgroup each.
struct Cells {
    /// Workgroups across, down and deep; and how many cells there are.
    dispatch: vec4<u32>,
    /// Column in the lower half of a word, row in the upper one, in cells.
    places: array<u32>,
}

/// The same while they are gathered; all zero to begin with.
struct Parts {
    dispatch: array<atomic<u32>, 4>,
    places: array<u32>,
}

/// What a workgroup works on.
struct Scope {
    square: cell::Cell,
    /// Its first pixel.
    first: vec2<u32>,
    /// Its block.
    own: u32,
    /// The nearest and the farthest end of its pixels' rays [m].
    ends: vec2<f32>,
    /// The knots before the nearest and behind the farthest of those ends.
    reach: vec2<u32>,
    /// Knots that are tabulated, and the first behind all blobs and lamps.
    knots: u32,
    behind: u32,
    /// Edges that its pixels pass, if they all pass as many.
    passes: u32,
}

/// Where a pixel ends among the knots.
struct End {
    /// [m]
    t: f32,
    /// The knot before it, and where on the way to the next.
    knot: u32,
    at: f32,
    share: cell::Shares,
}

@group(0) @binding(0) var<uniform> frame: view::View;
@group(0) @binding(1) var hits: texture_2d<f32>;
@group(0) @binding(2) var<storage, read> blobs: array<gaussians::Blob>;
/// rgb: airlight [W/(m² sr)]. w: optical depth of the blobs. Row by row.
@group(0) @binding(3) var<storage, read_write> fogged: array<vec4<f32>>;
@group(0) @binding(4) var<uniform> task: Task;
@group(0) @binding(5) var<storage, read> lamps: array<lamp::Lamp>;
@group(0) @binding(6) var<storage, read> scatters: array<lamp::Scatter>;
/// What each lamp's table covers.
@group(0) @binding(7) var<storage, read> extents: array<light_table::Extent>;
@group(0) @binding(8) var<uniform> fineness: block::Fineness;
/// 1 where more samples are worth while.
@group(0) @binding(9) var rims: texture_2d<u32>;
/// The cells of this dispatch, and those of the next.
@group(0) @binding(11) var<storage, read> cells: Cells;
@group(0) @binding(12) var<storage, read_write> parts: Parts;
@group(0) @binding(14) var<storage, read> blocks: array<block::Block>;
@group(0) @binding(15) var<storage, read> near: array<u32>;

/// Invocations of a workgroup.
const SIZE: u32 = 64u;
/// Workgroups of a row of a dispatch.
const ACROSS: u32 = 32768u;
/// Rays of a cell, the one among them by which it is checked, and pixels of a cell whose rays are its own.
const RAYS: u32 = 9u;
const CHECK: u32 = 8u;
const ALONE: u32 = 4u;
/// Knots that fit in: more where edges cut them into sections.
#ifdef EDGES
const KNOTS: u32 = 112u;
#else
const KNOTS: u32 = 56u;
#endif
/// Invocations that share a ray, each of which takes eight of its knots: as many as there are for nine rays, or
/// for four.
const LANES: u32 = 7u;
const LANES_ALONE: u32 = 16u;
/// Words of a mask of the blobs that are looked at in one go.
const WORDS: u32 = 128u;
/// Radii from its centre beyond which a blob is left out: exp(−3.72²) is 1e-6.
const SEEN: f32 = 3.72;
/// No number at all.
const UNCUT: u32 = 0xffffffffu;
/// Up to this share of what a ray shows at its end an error does not matter.
const FAINT: f32 = 1e-3;

/// What is tabulated: T and β of all blobs; T and β of what scatters; of one lamp the airlight, the mean of
/// β e^(−T) since the knot before, and R. While they are formed: T from the eye and from the light, and M.
const DEPTH: u32 = 0u;
const BETA: u32 = 1u;
const OWN: u32 = 2u;
const OWN_BETA: u32 = 3u;
const LIGHT: u32 = 4u;
const MEAN: u32 = 5u;
const RATIO: u32 = 6u;
const FIELDS: u32 = 7u;

/// `[knot][field][ray]`.
#ifdef EDGES
var<workgroup> table: array<f32, 7056>;
var<workgroup> knots: array<vec2<f32>, 112>;
var<workgroup> sections: array<array<f32, 8>, RAYS>;
var<workgroup> passes: array<u32, RAYS>;
var<workgroup> fewest: atomic<u32>;
var<workgroup> most: atomic<u32>;
var<workgroup> edges: u32;
var<workgroup> knot_count: u32;
#else
var<workgroup> table: array<f32, 3528>;
var<workgroup> knots: array<vec2<f32>, 56>;
#endif
var<workgroup> mask: array<u32, WORDS>;
var<workgroup> sums: array<vec2<f32>, SIZE>;
var<workgroup> nearest: atomic<u32>;
var<workgroup> farthest: atomic<u32>;
var<workgroup> misses: atomic<u32>;

@compute @workgroup_size(64)
fn light(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) place: u32,
) {
    let index = group.y * ACROSS + group.x;
    if index >= cells.dispatch.w {
        return;
    }
    let packed = cells.places[index];
    let at = vec2<u32>(packed & 0xffffu, packed >> 16u);
    var scope = scope_of(place, at);
    let count = blocks[scope.own].count;
    if scope.ends.y < scope.ends.x || count == 0u {
        return;
    }
    if task.alone == 0u && is_coarse(place, scope) {
        pass_on(place, at);
        return;
    }
    scope.knots = take_knots(place, scope);
    if scope.knots > KNOTS {
        // So many that only smaller cells have room for them.
        pass_on(place, at);
        return;
    }
#ifdef EDGES
    scope.behind = select(blocks[scope.own].behind, UNCUT, edges > 0u);
    scope.reach = around_ends(scope);
#else
    scope.behind = blocks[scope.own].behind;
    scope.reach = around_ends(scope);
    scope.knots = min(scope.reach.y + 2u, scope.knots);
#endif

    // Rays of their own need no ninth one.
    let is_checked = task.alone == 0u;
    var is_first = true;
    var is_rough = false;
    for (var terms = 0u; terms < fineness.groups && !is_rough; terms++) {
        gather(place, scope, terms);
        is_rough = is_checked && is_first && misses_depth(place, scope);
        for (var i = 0u; i < frame.scatters && !is_rough; i++) {
            if scatters[i].group == terms {
                let is_near = is_near(scope, lamps[scatters[i].lamp]);
                tabulate(place, scope, i);
                is_rough = is_checked && misses_light(place, scope, is_near);
                if !is_rough {
                    look_up(place, scope, i, is_near, is_first);
                    is_first = false;
                }
            }
        }
    }
    if is_rough {
        pass_on(place, at);
    }
}

/// Leaves the quarters of a cell to the next dispatch.
fn pass_on(place: u32, at: vec2<u32>) {
    for (var i = place; i < 4u; i += SIZE) {
        let part = 2u * at + vec2<u32>(i % 2u, i / 2u);
        // The list has room for those that lie in the picture.
        if view::is_inside(frame, part * (task.side / 2u)) {
            let index = atomicAdd(&parts.dispatch[3], 1u);
            parts.places[index] = part.x | (part.y << 16u);
            atomicMax(&parts.dispatch[0], min(index + 1u, ACROSS));
            atomicMax(&parts.dispatch[1], index / ACROSS + 1u);
            atomicMax(&parts.dispatch[2], 1u);
        }
    }
}

/// A cell before its knots. It ends before it begins if it has no pixels.
fn scope_of(place: u32, at: vec2<u32>) -> Scope {
    let first = at * task.side;
    let across = (u32(frame.targets.x) + block::SIDE - 1u) / block::SIDE;
    let own = (first.y / block::SIDE) * across + first.x / block::SIDE;
    let half = 0.5 * f32(task.side);
    if place == 0u {
        atomicStore(&nearest, 0x7f7fffffu);
        atomicStore(&farthest, 0u);
        begin_passes();
    }
    workgroupBarrier();
    for (var i = place; i < task.side * task.side; i += SIZE) {
        let pixel = pixel_of(first, i);
        if is_asked_for(pixel) {
            // Positive numbers are ordered as their bits are.
            let end = bitcast<u32>(textureLoad(hits, pixel, 0).w);
            atomicMin(&nearest, end);
            atomicMax(&farthest, end);
            count_passes(pixel, own, bitcast<f32>(end));
        }
    }
    workgroupBarrier();
    let ends = vec2<f32>(bitcast<f32>(atomicLoad(&nearest)), bitcast<f32>(atomicLoad(&farthest)));
    let square = cell::Cell(vec2<f32>(first) + half, half);
    return Scope(square, first, own, ends, vec2<u32>(0u), 0u, 0u, passed_by_all());
}

fn pixel_of(first: vec2<u32>, i: u32) -> vec2<u32> {
    return first + vec2<u32>(i % task.side, i / task.side);
}

/// Rays that are tabulated.
fn rays_of_cell() -> u32 {
    return select(RAYS, ALONE, task.alone == 1u);
}

/// Whether there is such a pixel, and its value is wanted.
fn is_asked_for(pixel: vec2<u32>) -> bool {
    if !view::is_inside(frame, pixel) {
        return false;
    }
    return task.at_edges == 0u || textureLoad(rims, pixel, 0).x != 0u;
}

/// One of the tabulated rays.
fn ray_of(scope: Scope, c: u32) -> view::Ray {
    if task.alone == 1u {
        return view::ray_of(frame, pixel_of(scope.first, c % ALONE));
    }
    return cell::ray_at(frame, scope.square, select(cell::PLACES[c % CHECK], cell::CHECK, c == CHECK));
}

/// Whether a lamp lights parts of rays only.
fn is_parted(which: u32) -> bool {
    return lamp::is_beam(lamps[which]) || shafts::is_shaded(which);
}

fn is_near(scope: Scope, light: lamp::Lamp) -> bool {
    return task.alone == 0u && cell::is_near(frame, scope.square, light, fineness.near);
}

/// Whether a cell is too large for what its rays may see.
fn is_coarse(place: u32, scope: Scope) -> bool {
#ifdef EDGES
    if is_cut(place, scope) {
        return true;
    }
#endif
    if f32(task.side) > fineness.glow {
        for (var i = 0u; i < arrayLength(&lamps); i++) {
            if is_near(scope, lamps[i]) {
                return true;
            }
        }
    }
    if cell::is_wide(frame, scope.square, fineness.wide) {
        return true;
    }
    let hides = hides(place, scope);
    // In thin fog a blob stands out by what it adds.
    return sqrt(hides.y) > fineness.hidden * min(hides.x, 1.0);
}

/// Optical depth of the blobs around a cell, and what may hide of it between the rays, squared.
fn hides(place: u32, scope: Scope) -> vec2<f32> {
    let rays = bundle_to(scope, scope.ends.y);
    let words = block::words(frame.blobs);
    var fog = around::nothing();
    for (var word = place; word < words; word += SIZE) {
        var bits = near[scope.own * words + word];
        while bits != 0u {
            around::add(&fog, blobs[32u * word + firstTrailingBit(bits)], rays);
            bits &= bits - 1u;
        }
    }
    sums[place] = vec2<f32>(fog.depth, fog.hidden);
    workgroupBarrier();
    var sum = vec2<f32>(0.0);
    for (var i = 0u; i < min(SIZE, words); i++) {
        sum += sums[i];
    }
    return sum;
}

/// The cell's rays, so long.
fn bundle_to(scope: Scope, length_m: f32) -> bundle::Bundle {
    let square = scope.square;
    return bundle::of_view(frame, square.middle - square.half, square.middle + square.half, length_m);
}

#ifdef EDGES
/// Whether some pixels of a cell pass an edge of the fog that others do not, or that some of the rays around
/// them do not.
fn is_cut(place: u32, scope: Scope) -> bool {
    for (var c = place; c < cell::RAYS; c += SIZE) {
        passes[c] = block::passed(ray_of(scope, c), blocks[scope.own].ends).count;
    }
    workgroupBarrier();
    var differs = scope.passes == UNCUT;
    for (var c = 0u; c < cell::RAYS; c++) {
        differs = differs || passes[c] < scope.passes;
    }
    return differs;
}

fn begin_passes() {
    atomicStore(&fewest, UNCUT);
    atomicStore(&most, 0u);
}

/// Counts the edges that a pixel passes before it ends.
fn count_passes(pixel: vec2<u32>, own: u32, length_m: f32) {
    let fog = blocks[own].ends;
    let ends = vec2<f32>(fog.x, min(length_m * (1.0 - block::ALIKE), fog.y));
    let count = block::passed(view::ray_of(frame, pixel), ends).count;
    atomicMin(&fewest, count);
    atomicMax(&most, count);
}

fn passed_by_all() -> u32 {
    return select(UNCUT, atomicLoad(&most), atomicLoad(&fewest) == atomicLoad(&most));
}

/// The knots of a cell, cut at the edges that its rays pass: every section has its own. Returns how many there
/// are, be it more than there is room for.
fn take_knots(place: u32, scope: Scope) -> u32 {
    for (var c = place; c < rays_of_cell(); c += SIZE) {
        passes[c] = block::passed(ray_of(scope, c), blocks[scope.own].ends).count;
        sections[c] = bounds_of(scope, ray_of(scope, c), block::EDGES);
    }
    workgroupBarrier();
    for (var once = place; once < 1u; once++) {
        edges = 0u;
        for (var c = 0u; c < rays_of_cell(); c++) {
            edges = max(edges, min(passes[c], block::EDGES));
        }
        // Where there is no room for all of them and no smaller cell, every second one is left out, or more.
        var apart = 1u;
        knot_count = cut(scope, apart);
        while task.alone == 1u && knot_count > KNOTS {
            apart *= 2u;
            knot_count = cut(scope, apart);
        }
    }
    workgroupBarrier();
    return knot_count;
}

fn cut(scope: Scope, apart: u32) -> u32 {
    let own = scope.own;
    var total = 0u;
    if edges == 0u {
        for (var i = 0u; i < blocks[own].count; i++) {
            total = push(total, vec2<f32>(0.0, blocks[own].at[i]));
        }
        return total;
    }
    for (var section = 0u; section <= edges; section++) {
        var begin = block::FAR;
        var end = 0.0;
        for (var c = 0u; c < rays_of_cell(); c++) {
            begin = min(begin, sections[c][section]);
            end = max(end, sections[c][section + 1u]);
        }
        let first = select(0.0, blocks[own].at[0], section == 0u);
        total = push(total, vec2<f32>(f32(section), first));
        for (var i = 1u; i + 1u < blocks[own].count; i += apart) {
            let t = blocks[own].at[i];
            // Behind the farthest end one is enough.
            let counts = blocks[own].at[i - 1u] < scope.ends.y && i != blocks[own].behind;
            if counts && t >= begin && t < end {
                total = push(total, vec2<f32>(f32(section), t));
            }
        }
        total = push(total, vec2<f32>(f32(section), block::FAR));
    }
    return total;
}

fn push(total: u32, knot: vec2<f32>) -> u32 {
    if total < KNOTS {
        knots[total] = knot;
    }
    return total + 1u;
}

fn bounds_of(scope: Scope, ray: view::Ray, followed: u32) -> array<f32, 8> {
    return block::bounds(ray, blocks[scope.own].ends, followed);
}
#else
fn begin_passes() {}

fn count_passes(pixel: vec2<u32>, own: u32, length_m: f32) {}

fn passed_by_all() -> u32 {
    return 0u;
}

/// The knots of the block; returns how many there are.
fn take_knots(place: u32, scope: Scope) -> u32 {
    let count = min(blocks[scope.own].count, KNOTS);
    for (var k = place; k < count; k += SIZE) {
        knots[k] = vec2<f32>(0.0, blocks[scope.own].at[k]);
    }
    workgroupBarrier();
    return count;
}
#endif

/// Where a knot lies on one of the tabulated rays [m].
fn knot_on(c: u32, k: u32) -> f32 {
#ifdef EDGES
    let section = u32(knots[k].x);
    return block::on(knots[k], vec2<f32>(sections[c][section], sections[c][section + 1u]));
#else
    return knots[k].y;
#endif
}

/// The knots before the nearest and behind the farthest end of a cell's pixels, on the ray that it is checked by.
fn around_ends(scope: Scope) -> vec2<u32> {
    let count = scope.knots;
    let c = select(CHECK, 0u, task.alone == 1u);
    var found = vec2<u32>(count - 1u);
    for (var k = count; k > 0u; k--) {
        let t = knot_on(c, k - 1u);
        found = select(found, vec2<u32>(k - 1u), vec2<f32>(t) >= scope.ends);
    }
    return vec2<u32>(max(found.x, 1u) - 1u, found.y);
}

fn index_of(field: u32, c: u32, k: u32) -> u32 {
    return (k * FIELDS + field) * RAYS + c;
}

/// A field between the tabulated rays, at a knot.
fn between(share: cell::Shares, field: u32, k: u32) -> f32 {
    let i = index_of(field, 0u, k);
    let corners = vec4<f32>(table[i], table[i + 1u], table[i + 2u], table[i + 3u]);
    let sides = vec4<f32>(table[i + 4u], table[i + 5u], table[i + 6u], table[i + 7u]);
    return dot(share.corners, corners) + dot(share.sides, sides);
}

/// T and β at the knots of all rays, of all blobs and of a group of terms.
fn gather(place: u32, scope: Scope, group: u32) {
    let c = place % rays_of_cell();
    let lane = place / rays_of_cell();
    let lanes = select(LANES, LANES_ALONE, task.alone == 1u);
    let ray = ray_of(scope, c);
    let rays = bundle_to(scope, knots[scope.knots - 1u].y);
    let words = block::words(frame.blobs);
    for (var base = 0u; base < scope.knots; base += 8u * lanes) {
        var low: crossing::Sums;
        var high: crossing::Sums;
        let begin = base + lane;
        let near_t = ts_of(scope, c, begin, lanes);
        let far_t = ts_of(scope, c, begin + 4u * lanes, lanes);
        for (var word = 0u; word < words; word += WORDS) {
            let count = min(words - word, WORDS);
            cull(place, scope.own * words + word, word, count, rays);
            for (var w = 0u; w < count; w++) {
                var bits = mask[w];
                while bits != 0u {
                    let blob = blobs[32u * (word + w) + firstTrailingBit(bits)];
                    bits &= bits - 1u;
                    let crossed = crossing::of_blob(blob, ray);
                    let is_own = blob.group == group;
                    crossing::add(&low, crossed, near_t, is_own);
                    for (var more = base + 4u * lanes; more < scope.knots; more += scope.knots) {
                        crossing::add(&high, crossed, far_t, is_own);
                    }
                }
            }
        }
        // The last invocation has no ray.
        for (var once = lane; once < lanes; once += lanes) {
            put(scope, group, ray, c, vec2<u32>(begin, lanes), near_t, low);
            put(scope, group, ray, c, vec2<u32>(begin + 4u * lanes, lanes), far_t, high);
        }
    }
    workgroupBarrier();
}

/// Where four of an invocation's knots lie [m].
fn ts_of(scope: Scope, c: u32, begin: u32, lanes: u32) -> vec4<f32> {
    let last = scope.knots - 1u;
    return vec4<f32>(
        knot_on(c, min(begin, last)),
        knot_on(c, min(begin + lanes, last)),
        knot_on(c, min(begin + 2u * lanes, last)),
        knot_on(c, min(begin + 3u * lanes, last)),
    );
}

/// Marks the blobs near the cell among some words of those near its block.
fn cull(place: u32, first: u32, word: u32, count: u32, rays: bundle::Bundle) {
    workgroupBarrier();
    for (var w = place; w < count; w += SIZE) {
        var bits = near[first + w];
        var kept = 0u;
        while bits != 0u {
            let bit = firstTrailingBit(bits);
            bits &= bits - 1u;
            let blob = blobs[32u * (word + w) + bit];
            let reach_m = min(blob.reach_m, SEEN / blob.a);
            let is_met = bundle::distance_to(rays, gaussians::center_of(blob)) < reach_m;
            kept |= select(0u, 1u << bit, is_met);
        }
        mask[w] = kept;
    }
    workgroupBarrier();
}

/// Writes what was gathered at four knots, given by the first and how far the next is, and adds what stands in
/// closed form to what scatters.
fn put(
    scope: Scope,
    group: u32,
    ray: view::Ray,
    c: u32,
    begin: vec2<u32>,
    t: vec4<f32>,
    gathered: crossing::Sums,
) {
    for (var i = 0u; i < 4u; i++) {
        let k = begin.x + i * begin.y;
        if k < scope.knots {
            let point = ray.offset + t[i] * ray.direction;
            let filled = t[i] * haze::group_view_mean(group, ray.offset, point);
            table[index_of(DEPTH, c, k)] = gathered.depth[i];
            table[index_of(BETA, c, k)] = gathered.beta[i];
            table[index_of(OWN, c, k)] = gathered.own[i] + filled;
            table[index_of(OWN_BETA, c, k)] = gathered.own_beta[i] + haze::extinction(group, point);
        }
    }
}

/// Airlight, its means and R at the knots of all rays, of what is scattered of a lamp.
fn tabulate(place: u32, scope: Scope, i: u32) {
    let scatter = scatters[i];
    let light = lamps[scatter.lamp];
    let rays = rays_of_cell();
    let pairs = rays * scope.knots;
    // Until all have looked the lamp before up, its values stand.
    workgroupBarrier();
    for (var pair = place; pair < pairs; pair += SIZE) {
        let c = pair % rays;
        let k = pair / rays;
        table[index_of(LIGHT, c, k)] = total_at(ray_of(scope, c), scatter.lamp, c, k);
    }
    workgroupBarrier();
    for (var pair = place; pair < pairs; pair += SIZE) {
        let c = pair % rays;
        let k = pair / rays;
        let ray = ray_of(scope, c);
        let gain = gain_at(scatter, lamp::beside(light, ray.offset, ray.direction), c, k);
        table[index_of(MEAN, c, k)] = gain.x;
        table[index_of(RATIO, c, k)] = gain.y;
    }
    workgroupBarrier();
    let is_parted = is_parted(scatter.lamp);
    for (var c = place; c < rays; c += SIZE) {
        var sum = 0.0;
        var known = 0.0;
        for (var k = 0u; k < scope.knots; k++) {
            let part = table[index_of(RATIO, c, k)];
            let total = table[index_of(LIGHT, c, k)];
            sum += part * table[index_of(MEAN, c, k)];
            known += part;
            if is_parted {
                // The airlight is asked of the ninth ray alone: β e^(−T) stands in its place.
                let seen = table[index_of(OWN_BETA, c, k)] * num::exp_bounded(-min(total, 80.0));
                table[index_of(LIGHT, c, k)] = select(seen, sum, c == CHECK);
                table[index_of(RATIO, c, k)] = ratio_of(scope, c, k, sum, known);
            } else {
                table[index_of(LIGHT, c, k)] = sum;
                table[index_of(RATIO, c, k)] = known;
            }
        }
    }
    workgroupBarrier();
    let ratios = select(pairs, 0u, is_parted);
    for (var pair = place; pair < ratios; pair += SIZE) {
        let c = pair % rays;
        let k = pair / rays;
        let sum = table[index_of(LIGHT, c, k)];
        table[index_of(RATIO, c, k)] = ratio_of(scope, c, k, sum, table[index_of(RATIO, c, k)]);
    }
    workgroupBarrier();
}

/// R at a knot, of the airlight up to it and M.
fn ratio_of(scope: Scope, c: u32, k: u32, sum: f32, known: f32) -> f32 {
    // Behind all blobs and lamps R does not help any more.
    if k >= scope.behind {
        return sum;
    }
    let t = knot_on(c, k);
    let ray = ray_of(scope, c);
    let depth = table[index_of(DEPTH, c, k)] + haze::depth(ray.offset, ray.direction, t);
    return sum / (known * rule::bulk(depth, t));
}

/// T from the eye and from a lamp at a knot.
fn total_at(ray: view::Ray, which: u32, c: u32, k: u32) -> f32 {
    let t = knot_on(c, k);
    let point = ray.offset + t * ray.direction;
    let seen = table[index_of(DEPTH, c, k)] + haze::depth(ray.offset, ray.direction, t);
    if lamps[which].sky > 0u {
        return seen + max(sky::depth(lamps[which], point, ray.direction), 0.0);
    }
    if lamp::is_sun(lamps[which]) {
        return seen + max(from_sun(which, point), 0.0);
    }
    let light = lamps[which].position;
    let toward = lamp::beside(lamps[which], ray.offset, ray.direction);
    let aside = t - toward.closest;
    let distance_m = sqrt(aside * aside + toward.miss * toward.miss);
    var mean = haze::mean(point, light);
    if extents[which].shells > 0.0 {
        mean += light_table::mean(extents[which], point - light, distance(point, light));
    } else {
        let way = gaussians::way_between(point, light);
        var depth = 0.0;
        for (var at = 0u; at < frame.blobs; at++) {
            depth += gaussians::depth_on(way, blobs[at]);
        }
        mean += depth / max(way.length_m, num::LEAST);
    }
    return seen + max(mean, 0.0) * distance_m;
}

/// T from the sun to a point.
fn from_sun(which: u32, point: vec3<f32>) -> f32 {
    let light = lamps[which];
    var depth = haze::beyond(point, light.toward, light.path_m);
    if extents[which].shells > 0.0 {
        return depth + light_table::mean(extents[which], point - light.position, 0.0);
    }
    let way = gaussians::Way(point, light.toward, lamp::EVERYWHERE_M);
    for (var at = 0u; at < frame.blobs; at++) {
        depth += gaussians::depth_on(way, blobs[at]);
    }
    return depth;
}

/// x: the mean of β e^(−T) since the knot before, weighed by where the light comes from. y: that part of M.
fn gain_at(scatter: lamp::Scatter, light: lamp::ToLight, c: u32, k: u32) -> vec2<f32> {
    let b = place_on(light, c, k);
    if k == 0u {
        let part = glow::between(scatter, light, 0.0, b.t);
        return vec2<f32>(b.seen, part);
    }
    let a = place_on(light, c, k - 1u);
    let clear = glow::turn(light, a.t, b.t) / light.miss;
    return vec2<f32>(rule::gain(clear, a, b), glow::between(scatter, light, a.t, b.t));
}

fn place_on(light: lamp::ToLight, c: u32, k: u32) -> rule::Place {
    let t = knot_on(c, k);
    let aside = t - light.closest;
    let log = 0.5 * log(aside * aside + light.miss * light.miss);
    let total = table[index_of(LIGHT, c, k)];
    let through = num::exp_bounded(-min(total, 80.0));
    let seen = table[index_of(OWN_BETA, c, k)] * through;
    let miss_squared = light.miss * light.miss;
    return rule::Place(t, aside, log, miss_squared, table[index_of(OWN, c, k)], total, through, seen);
}

/// Whether some invocation found the ninth ray too far from what the eight make of it; to be called by all.
fn any_misses(differs: bool) -> bool {
    if differs {
        atomicStore(&misses, 1u);
    }
    workgroupBarrier();
    let found = atomicLoad(&misses) == 1u;
    workgroupBarrier();
    return found;
}

fn begin_misses(place: u32) {
    if place == 0u {
        atomicStore(&misses, 0u);
    }
    workgroupBarrier();
}

/// Whether the eight rays miss T of the blobs on the ninth, where pixels end.
fn misses_depth(place: u32, scope: Scope) -> bool {
    begin_misses(place);
    let share = cell::shares(cell::CHECK);
    var differs = false;
    for (var k = scope.reach.x + place; k <= scope.reach.y; k += SIZE) {
        let depth = table[index_of(DEPTH, CHECK, k)];
        let off = abs(between(share, DEPTH, k) - depth) * num::exp_bounded(-depth);
        differs = differs || off > fineness.rough * max(num::absorptance(depth), fineness.unseen);
    }
    return any_misses(differs);
}

/// Whether they miss a lamp's airlight there.
fn misses_light(place: u32, scope: Scope, is_near: bool) -> bool {
    begin_misses(place);
    let share = cell::shares(cell::CHECK);
    let last = table[index_of(LIGHT, CHECK, scope.reach.y)];
    let has_haze = haze::bounds().y > 0.0;
    var differs = false;
    if is_near {
        for (var once = place; once < 1u; once++) {
            differs = misses_glow(scope, share, last);
        }
    } else {
        for (var k = scope.reach.x + place; k <= scope.reach.y; k += SIZE) {
            let exact = table[index_of(RATIO, CHECK, k)];
            let off = abs(between(share, RATIO, k) - exact);
            // What no haze fills and few blobs reach.
            let is_filled = has_haze || table[index_of(DEPTH, CHECK, k)] >= fineness.unseen;
            let counts = table[index_of(LIGHT, CHECK, k)] > FAINT * last;
            differs = differs || is_filled && counts && off > fineness.rough * exact;
        }
    }
    return any_misses(differs);
}

/// What the means between the rays miss of the light up to each knot, near a lamp.
fn misses_glow(scope: Scope, share: cell::Shares, last: f32) -> bool {
    var off = 0.0;
    var before = 0.0;
    var differs = false;
    for (var k = 0u; k <= scope.reach.y; k++) {
        let exact = table[index_of(MEAN, CHECK, k)];
        let sum = table[index_of(LIGHT, CHECK, k)];
        let gained = sum - before;
        before = sum;
        if exact > 0.0 {
            off += (between(share, MEAN, k) / exact - 1.0) * gained;
        }
        let counts = k >= scope.reach.x && sum > FAINT * last;
        differs = differs || counts && abs(off) > fineness.rough * sum;
    }
    return differs;
}

/// Adds a lamp's airlight to the pixels of a cell; the first one also sets T of the blobs.
fn look_up(place: u32, scope: Scope, which: u32, is_near: bool, is_first: bool) {
    let scatter = scatters[which];
    for (var i = place; i < task.side * task.side; i += SIZE) {
        let pixel = pixel_of(scope.first, i);
        if is_asked_for(pixel) {
            let ray = view::ray_of(frame, pixel);
            let length_m = textureLoad(hits, pixel, 0).w;
#ifdef EDGES
            let sections = bounds_of(scope, ray, edges);
#else
            let sections = array<f32, 8>();
#endif
            let end = end_of(scope, pixel, i, length_m, sections);
            let lumps = lumps_at(end, sections);
            let depth = lumps + haze::depth(ray.offset, ray.direction, length_m);
            let light = lamp::beside(lamps[scatter.lamp], ray.offset, ray.direction);
            var value = 0.0;
            if is_near {
                value = near_lamp(scatter, light, end, sections);
            } else {
                value = beside_lamp(scope, scatter, light, end, sections, depth);
            }
            if is_parted(scatter.lamp) {
                value *= share_of(scatter, ray, light, end, sections);
            }
            let at = view::index_of(frame, pixel);
            let before = select(fogged[at], vec4<f32>(0.0, 0.0, 0.0, lumps), is_first);
            fogged[at] = before + vec4<f32>(value * scatter.colour, 0.0);
        }
    }
}

/// Where a knot lies on a pixel's ray [m].
fn knot_within(sections: array<f32, 8>, k: u32) -> f32 {
#ifdef EDGES
    var own = sections;
    let section = u32(knots[k].x);
    return block::on(knots[k], vec2<f32>(own[section], own[section + 1u]));
#else
    return knots[k].y;
#endif
}

/// Where a pixel ends among the knots.
fn end_of(scope: Scope, pixel: vec2<u32>, i: u32, length_m: f32, sections: array<f32, 8>) -> End {
    let t = min(length_m, blocks[scope.own].ends.y);
    var k = 0u;
    while k + 2u < scope.knots && knot_within(sections, k + 1u) < t {
        k += 1u;
    }
    let begin = knot_within(sections, k);
    let width = max(knot_within(sections, k + 1u) - begin, num::LEAST);
    let place = (view::sample_of(frame, pixel) - scope.square.middle) / scope.square.half;
    var share = cell::shares(place);
    if task.alone == 1u {
        let own = vec4<u32>(0u, 1u, 2u, 3u) == vec4<u32>(i);
        share = cell::Shares(select(vec4<f32>(0.0), vec4<f32>(1.0), own), vec4<f32>(0.0));
    }
    return End(t, k, clamp((t - begin) / width, 0.0, 1.0), share);
}

/// T of the blobs: the cubic that meets T and β at both knots.
fn lumps_at(end: End, sections: array<f32, 8>) -> f32 {
    let k = end.knot;
    let begin = knot_within(sections, k);
    let width = knot_within(sections, k + 1u) - begin;
    let near = between(end.share, DEPTH, k);
    let far = between(end.share, DEPTH, k + 1u);
    let rise = between(end.share, BETA, k) * width;
    let slope = between(end.share, BETA, k + 1u) * width;
    let at = end.at;
    let rest = 1.0 - at;
    let cubic = near * rest * rest * (1.0 + 2.0 * at) + far * at * at * (3.0 - 2.0 * at)
        + at * rest * (rise * rest - slope * at);
    let kept = max(clamp(cubic, min(near, far), max(near, far)), 0.0);
    // Before the first knot it grows from nothing.
    return kept * min(end.t / max(begin, num::LEAST), 1.0);
}

/// Airlight of a lamp whose image is elsewhere.
fn beside_lamp(
    scope: Scope,
    scatter: lamp::Scatter,
    light: lamp::ToLight,
    end: End,
    sections: array<f32, 8>,
    depth: f32,
) -> f32 {
    let ratio = between(end.share, RATIO, end.knot);
    if end.knot >= scope.behind {
        // The light so far, and what the rest of the way adds.
        let begin = knot_within(sections, end.knot);
        let mean = between(end.share, MEAN, end.knot + 1u);
        return max(ratio + mean * glow::between(scatter, light, begin, max(end.t, begin)), 0.0);
    }
    let here = mix(ratio, between(end.share, RATIO, end.knot + 1u), end.at);
    return max(here, 0.0) * glow::between(scatter, light, 0.0, end.t) * rule::bulk(depth, end.t);
}

/// Airlight near a lamp: the means between knots, each times its part of the glow.
fn near_lamp(scatter: lamp::Scatter, light: lamp::ToLight, end: End, sections: array<f32, 8>) -> f32 {
    var sum = 0.0;
    var begin = 0.0;
    for (var k = 0u; k <= end.knot + 1u; k++) {
        // The last one reaches to the end.
        let until = min(select(knot_within(sections, k), end.t, k > end.knot), end.t);
        let mean = max(between(end.share, MEAN, k), 0.0);
        sum += mean * glow::between(scatter, light, begin, max(until, begin));
        begin = max(until, begin);
    }
    return sum;
}

/// Share of the airlight of a lamp that lights parts of a ray only: from knot to knot the glow of what it lights, times
/// the mean there of β e^(−T), over the same of the whole ray.
fn share_of(
    scatter: lamp::Scatter,
    ray: view::Ray,
    light: lamp::ToLight,
    end: End,
    sections: array<f32, 8>,
) -> f32 {
    let source = lamps[scatter.lamp];
    let is_beam = lamp::is_beam(source);
    let is_shaded = shafts::is_shaded(scatter.lamp);
    let cone = beam::beside(source, ray.offset, ray.direction);
    let first = glow::first_angle(light);
    var seen: shafts::Seen;
    if is_shaded {
        seen = shafts::look_to(scatter.lamp, light, ray.offset, ray.direction, end.t);
    }
    var sum = 0.0;
    var all = 0.0;
    var begin = 0.0;
    var angle = first;
    var before = between(end.share, LIGHT, 0u);
    for (var k = 0u; k <= end.knot + 1u; k++) {
        let knot = max(knot_within(sections, k), begin);
        let until = max(select(min(knot, end.t), end.t, k > end.knot), begin);
        let whole = max(glow::turn(light, begin, knot), num::LEAST);
        let turn = glow::turn(light, begin, until);
        let next = between(end.share, LIGHT, k);
        let mean = max(between(end.share, MEAN, k), 0.0);
        all += rule::between(vec2<f32>(before, next), mean, vec2<f32>(0.0, turn / whole))
            * glow::over(scatter, angle, turn);
        // From the angle at the knot before: the sun's hardly change.
        var lit = vec2<f32>(0.0, turn);
        if is_beam {
            lit = beam::narrowed(cone, angle + lit) - angle;
        }
        let width = lit.y - lit.x;
        if width > 0.0 {
            var share = 1.0;
            if is_beam {
                share = beam::turn(source, cone, angle + lit) / width;
            }
            if is_shaded {
                let near = shafts::place_of(scatter.lamp, seen, first, angle + lit.x, begin);
                let far = shafts::place_of(scatter.lamp, seen, first, angle + lit.y, until);
                share *= shafts::share(scatter.lamp, seen, near, far);
            }
            let value = rule::between(vec2<f32>(before, next), mean, lit / whole);
            sum += value * share * glow::over(scatter, angle + lit.x, width);
        }
        angle += turn;
        begin = until;
        before = next;
    }
    return min(sum / max(all, num::LEAST), 1.0);
}
