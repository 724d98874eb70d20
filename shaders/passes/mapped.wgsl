// Airlight of one lamp in any fog by `mapped`'s rule, a patch of the picture after the other.
//
// What is expensive is smooth across a patch: at the nodes of the rule, ln β − T(v,x) and T(x,s)/d
// are evaluated on eight rays around it, 32 nodes at once, one pair of node and ray an invocation,
// and each pixel interpolates them. The rays of a patch end at different depths: those that end
// close to each other share a layer, whose rule covers what all of them see (the head), and a short
// rule of each pixel's own the rest (the tail).
//
// Pixels for which that would not do are left to the next dispatch, whose patches are half as large:
// around a lamp's image, where blobs hide between the eight rays, where a ninth ray shows that
// quadratics miss the fields, and those of more layers than a patch may have. A patch of one pixel
// takes what it gets.
//
// Twins: core/src/cpu/mapped/{mod,patch,control,crossings,pilot}.rs.

#import fogbank::num
#import fogbank::view
#import fogbank::bundle
#import fogbank::lamp
#import fogbank::tile
#import fogbank::haze
#import fogbank::media::gaussians
#import fogbank::airlight::mapped
#import fogbank::mapped::pilot
#import fogbank::mapped::pixels
#import fogbank::mapped::around
#import fogbank::mapped::batch
#import fogbank::mapped::patch
#import fogbank::mapped::section
#ifdef LIGHT_TABLE
#import fogbank::mapped::light_table
#endif

/// The work of a dispatch.
struct Task {
    /// What is scattered of which lamp, by its place.
    scatter: u32,
    /// Pixels along the side of a patch: 16, 8, 4, 2 or 1.
    side: u32,
    /// The group that scatters, and the mean cosine of its phase function.
    group: u32,
    g: f32,
}

/// Patches, a workgroup each.
struct Patches {
    /// Workgroups across, down and deep; and how many patches there are.
    dispatch: vec4<u32>,
    /// Column in the lower half of a word, row in the upper one, in patches.
    places: array<u32>,
}

/// The same while they are gathered; all zero to begin with.
struct Parts {
    dispatch: array<atomic<u32>, 4>,
    places: array<u32>,
}

/// The invocation's own pixel.
struct Own {
    pixel: vec2<u32>,
    /// Whether there is such a pixel, and it waits for this dispatch.
    waits: bool,
    ray: view::Ray,
    /// Where the ray ends; 0 if it does not wait [m].
    length_m: f32,
    /// How much each of the eight rays counts for it.
    share: pixels::Shares,
}

/// A patch before its lamp.
struct Scope {
    area: vec4<f32>,
    rays: bundle::Bundle,
    /// Whether it must do as it is.
    is_last: bool,
    /// Where the fog begins and where nothing behind is seen any more [m].
    begin: f32,
    end: f32,
    /// From where to where there are blobs [m].
    dense: vec2<f32>,
}

@group(0) @binding(0) var<uniform> frame: view::View;
@group(0) @binding(1) var hits: texture_2d<f32>;
@group(0) @binding(2) var<storage, read> blobs: array<gaussians::Blob>;
/// rgb: airlight [W/(m² sr)]. w: optical depth. Row by row.
@group(0) @binding(3) var<storage, read_write> fogged: array<vec4<f32>>;
@group(0) @binding(4) var<uniform> task: Task;
@group(0) @binding(5) var<storage, read> lamps: array<lamp::Lamp>;
/// Gauss–Legendre abscissae and weights on [0, 1] of 32, 64, 128, 256 and 512 nodes, one after the
/// other.
@group(0) @binding(6) var<storage, read> rules: array<vec2<f32>>;
/// For every tile, eight words of pixels that have their airlight.
@group(0) @binding(7) var<storage, read_write> settled: array<atomic<u32>>;
@group(0) @binding(8) var<uniform> limits: patch::Tolerance;
#ifdef LIGHT_TABLE
@group(0) @binding(9) var<uniform> extent: light_table::Extent;
@group(0) @binding(10) var<storage, read> means: array<f32>;
#endif
@group(0) @binding(13) var<storage, read> scatters: array<lamp::Scatter>;
/// The patches of this dispatch, and those of the next.
@group(0) @binding(11) var<storage, read> patches: Patches;
@group(0) @binding(12) var<storage, read_write> parts: Parts;

/// Workgroups of a row of a dispatch.
const ACROSS: u32 = 32768u;
/// Nodes that are taken at once, and of the smallest rule.
const BATCH: u32 = 32u;
const LARGEST_RULE: u32 = 512u;
/// Layers of a patch.
const LAYERS: u32 = 4u;
/// Larger than any distance [m].
const FAR: f32 = 1e30;
/// Optical depth of a ray that is as good as clear.
const UNSEEN: f32 = 1e-4;
/// Every blob of a mask, every eighth, and every thirty-second.
const ALL: u32 = 0xffffffffu;
const EIGHTH: u32 = 0x01010101u;

/// Smallest depths of eight rays, as bits.
var<workgroup> thinnest: array<atomic<u32>, 32>;

@compute @workgroup_size(256)
fn add(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) place: u32,
) {
    let side = task.side;
    let index = group.y * ACROSS + group.x;
    if index >= patches.dispatch.w {
        return;
    }
    let packed = patches.places[index];
    let at = vec2<u32>(packed & 0xffffu, packed >> 16u);
    let area = patch::area_of(frame, at * side, side);
    let own = own_of(place, at * side, side, area);
    let longest = tile::largest(place, vec4<f32>(own.length_m)).x;
    let light = lamps[scatters[task.scatter].lamp];
    let rays = bundle::of_view(frame, area.xy, area.zw, longest);
    let fog = fog_around(place, rays, longest);
    let scope = scope_of(place, area, rays, fog, side == 1u);
    let middle = patch::ray_at(frame, area, vec2<f32>(0.0));
    let among = min(longest, max(fog.end, 0.0));
    let hidden_by = haze::depth(middle.offset, middle.direction, among);
    let hides = sqrt(fog.hidden) > limits.hidden * min(fog.depth + hidden_by, 1.0);
    let is_coarse = hides || patch::is_wide(frame, area, limits.wide);
    let is_near = patch::is_near(frame, area, light, longest, limits.near);

    // x: the airlight. y: 1 if it is none yet.
    var value = vec2<f32>(0.0);
    if scope.begin < scope.end {
        if (is_coarse || is_near) && !scope.is_last {
            value.y = 1.0;
        } else {
            value = of_lamp(place, own, scope, light);
        }
    }
    if own.waits {
        settle(own, value);
    }
    let stays = own.waits && value.y != 0.0;
    if tile::largest(place, vec4<f32>(select(0.0, 1.0, stays))).x > 0.0 && place < 4u {
        pass_on(2u * at + vec2<u32>(place % 2u, place / 2u));
    }
}

/// The invocation's pixel, if the patch has so many.
fn own_of(place: u32, first: vec2<u32>, side: u32, area: vec4<f32>) -> Own {
    let is_there = place < side * side;
    let pixel = first + select(vec2<u32>(0u), vec2<u32>(place % side, place / side), is_there);
    let share = pixels::shares(patch::place_in(area, view::sample_of(frame, pixel)));
    var own = Own(pixel, false, view::ray_of(frame, pixel), 0.0, share);
    if is_there && view::is_inside(frame, pixel) {
        own.waits = (atomicLoad(&settled[word_of(pixel)]) & bit_of(pixel)) == 0u;
    }
    if own.waits {
        own.length_m = textureLoad(hits, view::pixel_of(frame, pixel), 0).w;
    }
    return own;
}

/// Where a pixel's bit is in `settled`.
fn word_of(pixel: vec2<u32>) -> u32 {
    let tiles = (u32(frame.targets.x) + tile::SIDE - 1u) / tile::SIDE;
    let at = pixel / tile::SIDE;
    return (at.y * tiles + at.x) * 8u + (pixel.y % tile::SIDE) / 2u;
}

fn bit_of(pixel: vec2<u32>) -> u32 {
    return 1u << (pixel.x % tile::SIDE + tile::SIDE * (pixel.y % 2u));
}

/// Adds a pixel's airlight, unless there is none yet.
fn settle(own: Own, value: vec2<f32>) {
    if value.y != 0.0 {
        return;
    }
    let airlight = value.x * scatters[task.scatter].colour;
    fogged[view::index_of(frame, own.pixel)] += vec4<f32>(airlight, 0.0);
    atomicOr(&settled[word_of(own.pixel)], bit_of(own.pixel));
}

/// Leaves a quarter of the patch to the next dispatch.
fn pass_on(at: vec2<u32>) {
    let index = atomicAdd(&parts.dispatch[3], 1u);
    parts.places[index] = at.x | (at.y << 16u);
    atomicMax(&parts.dispatch[0], min(index + 1u, ACROSS));
    atomicMax(&parts.dispatch[1], index / ACROSS + 1u);
    atomicMax(&parts.dispatch[2], 1u);
}

/// What all blobs around the patch's rays come to; marks them.
fn fog_around(place: u32, rays: bundle::Bundle, longest: f32) -> around::Fog {
    var fog = around::nothing();
    for (var at = place; at < frame.blobs; at += tile::SIZE) {
        around::add(&fog, blobs[at], rays);
    }
    mark_seen(place, rays);
    let ends = tile::largest(place, vec4<f32>(-fog.begin, fog.end, 0.0, 0.0));
    let sums = tile::total(place, vec4<f32>(fog.most, fog.depth, fog.hidden, 0.0));
    return around::Fog(max(-ends.x, 0.0), min(ends.y, longest), sums.x, sums.y, sums.z);
}

/// Marks the blobs that matter to the patch's rays; the host sends no more than a chunk.
fn mark_seen(place: u32, rays: bundle::Bundle) {
    tile::clear(place);
    for (var at = place; at < frame.blobs; at += tile::SIZE) {
        let blob = blobs[at];
        if bundle::distance_to(rays, gaussians::center_of(blob)) < blob.reach_m {
            tile::keep(at);
        }
    }
    workgroupBarrier();
}

fn scope_of(
    place: u32,
    area: vec4<f32>,
    rays: bundle::Bundle,
    fog: around::Fog,
    is_last: bool,
) -> Scope {
    let beta = haze::bounds();
    let dense = vec2<f32>(fog.begin, fog.end);
    var scope = Scope(area, rays, is_last, fog.begin, fog.end, dense);
    if beta.y > 0.0 {
        // What is everywhere hides the rest of a long ray by itself.
        scope.begin = 0.0;
        scope.end = min(rays.length_m, mapped::OPAQUE / max(beta.x, mapped::LEAST_BETA));
    }
    let is_dense = dense.x < min(dense.y, scope.end);
    if is_dense && fog.most + beta.y * scope.end > mapped::OPAQUE {
        scope.end = opaque_from(place, scope);
    }
    return scope;
}

/// Where nothing behind is seen any more on any of the eight rays: looked for at 32 places among the
/// blobs, else behind them, where only haze is left.
fn opaque_from(place: u32, scope: Scope) -> f32 {
    let slot = place / pixels::CONTROL;
    let ray = control_ray(scope, place);
    let last = min(scope.dense.y, scope.end);
    let t = scope.begin + (last - scope.begin) * f32(slot + 1u) / f32(BATCH);
    if place < BATCH {
        atomicStore(&thinnest[place], 0x7f7fffffu);
    }
    workgroupBarrier();
    let depth = view_sums(ray, t, ALL).y + haze::depth(ray.offset, ray.direction, t);
    // Positive numbers are ordered as their bits are.
    atomicMin(&thinnest[slot], bitcast<u32>(max(depth, 0.0)));
    workgroupBarrier();
    let rest = mapped::OPAQUE - bitcast<f32>(atomicLoad(&thinnest[BATCH - 1u]));
    var end = min(scope.end, last + max(rest, 0.0) / max(haze::bounds().x, mapped::LEAST_BETA));
    if bitcast<f32>(atomicLoad(&thinnest[slot])) > mapped::OPAQUE {
        end = t;
    }
    return -tile::largest(place, vec4<f32>(-end)).x;
}

/// x: the lamp's airlight along the invocation's ray per unit of ω·I, layer by layer. y: 1 if the
/// patch is too large for it.
fn of_lamp(place: u32, own: Own, scope: Scope, light: lamp::Lamp) -> vec2<f32> {
    let end = min(own.length_m, scope.end);
    let thin = limits.thin * max(scope.dense.y - scope.dense.x, 0.0);
    var waits = own.length_m > scope.begin;
    var result = vec2<f32>(0.0);
    for (var layer = 0u; layer < LAYERS; layer++) {
        let first = -tile::largest(place, vec4<f32>(select(-FAR, -end, waits))).x;
        if first >= FAR {
            break;
        }
        let reach = first + max(limits.layer * (first - scope.begin), thin);
        let member = waits && end <= reach;
        let last = tile::largest(place, vec4<f32>(select(0.0, end, member))).x;
        waits = waits && !member;
        var value = vec2<f32>(0.0);
        if first - scope.begin > 1e-6 * first {
            value = heads_airlight(place, own, scope, light, first, member);
        }
        var piece = tail_piece(place, own, member, scope, first, last);
        if piece.begin > piece.end {
            value.y = select(1.0, value.y, scope.is_last);
            piece = section::Piece(first, last, section::UNCUT, section::UNCUT);
        }
        if value.y == 0.0 && last - first > 1e-5 * (last - scope.begin) {
            value.x += tail_airlight(place, own, scope, light, piece, member);
        }
        result = select(result, value, member);
    }
    return select(result, vec2<f32>(0.0, 1.0), waits);
}

/// x: airlight before the first end along a member's ray, section by section. y: 1 if quadratics miss
/// the fields.
fn heads_airlight(
    place: u32,
    own: Own,
    scope: Scope,
    light: lamp::Lamp,
    first: f32,
    member: bool,
) -> vec2<f32> {
    let middle = patch::ray_at(frame, scope.area, vec2<f32>(0.0));
    var sum = vec2<f32>(0.0);
    var piece = section::Piece(scope.begin, first, section::UNCUT, section::UNCUT);
    // No more sections than there are edges, and one.
    for (var i = 0u; i <= haze::edge_count(); i++) {
        piece.high = section::next_edge(middle, section::place_on(piece, middle).x, first * (1.0 - section::ALIKE));
        let ends = section::place_on(piece, middle);
        if ends.y - ends.x > 1e-6 * first {
            sum += head_airlight(place, own, scope, light, piece, member);
        }
        if piece.high == section::UNCUT {
            break;
        }
        piece.low = piece.high;
        piece.high = section::UNCUT;
    }
    return vec2<f32>(sum.x, min(sum.y, 1.0));
}

/// The edge of the fog at which a layer's rays end or before which they do, if one is near: the piece of
/// their tail. It begins behind its end if edges part the rays: some pass one, others do not.
fn tail_piece(
    place: u32,
    own: Own,
    member: bool,
    scope: Scope,
    first: f32,
    last: f32,
) -> section::Piece {
    let middle = patch::ray_at(frame, scope.area, vec2<f32>(0.0));
    let ray = control_ray(scope, place);
    var piece = section::Piece(first, last, section::UNCUT, section::UNCUT);
    var nearest = FAR;
    for (var i = 0u; i < haze::edge_count(); i++) {
        let t = haze::edge(i, own.ray.offset, own.ray.direction);
        let passes = t > scope.begin && t < min(own.length_m, scope.end) * (1.0 - section::ALIKE);
        let on_control = haze::edge(i, ray.offset, ray.direction);
        let is_inside = on_control > scope.begin && on_control < first * (1.0 - section::ALIKE);
        let is_ahead = on_control > scope.begin && on_control < last * (1.0 + section::ALIKE);
        let found = tile::largest(place, vec4<f32>(
            select(0.0, 1.0, member && passes),
            select(0.0, 1.0, member && !passes),
            select(0.0, 1.0, is_inside),
            select(0.0, 1.0, !is_inside),
        ));
        let is_near = tile::largest(place, vec4<f32>(select(0.0, 1.0, is_ahead))).x > 0.0;
        if found.x > 0.0 && (found.y > 0.0 || found.w > 0.0) || found.x == 0.0 && found.z > 0.0 {
            piece.begin = FAR;
        }
        let on_middle = haze::edge(i, middle.offset, middle.direction);
        if found.x == 0.0 && is_near && on_middle < nearest {
            nearest = on_middle;
            piece.high = i;
        }
    }
    return piece;
}

/// ln of what a node's weight grows by from the middle ray to another.
fn log_stretch(scope: Scope, piece: section::Piece, chart: vec2<f32>) -> f32 {
    let middle = section::chart_on(piece, patch::ray_at(frame, scope.area, vec2<f32>(0.0)));
    return num::log_bounded(chart.y / max(middle.y, num::LEAST));
}

/// x: airlight of a head along a member's ray. y: 1 if quadratics miss the fields.
fn head_airlight(
    place: u32,
    own: Own,
    scope: Scope,
    light: lamp::Lamp,
    piece: section::Piece,
    member: bool,
) -> vec2<f32> {
    let g = task.g;
    let middle = patch::ray_at(frame, scope.area, vec2<f32>(0.0));
    let map = map_along(place, scope, middle, light, piece);
    let ends = section::place_on(piece, middle);
    let before = depth_before(place, middle, piece);
    let of_blobs = depth_to(place, middle, ends.y);
    let through = of_blobs + haze::depth(middle.offset, middle.direction, ends.y);
    let is_clear = num::absorptance(through) <= mapped::CLEAR;
    var size = BATCH;
    if !is_clear {
        size = size_of(place, middle, light, map, piece, removed_by(before, of_blobs));
    }

    let toward = to_light(light, own.ray);
    let chart = section::chart_on(piece, own.ray);
    var sum = 0.0;
    // Along the ninth ray: the airlight as it is and as it would be, and what blobs remove there.
    var compared = vec3<f32>(0.0);
    for (var first = 0u; first < size; first += BATCH) {
        place_nodes(place, map, size, first, section::chart_on(piece, middle));
        fill_batch(place, scope, light, piece);
        compared += on_ninth(place, scope, light, piece);
        if member {
            for (var j = 0u; j < BATCH; j++) {
                sum += batch::airlight(j, g, own.share, toward, chart);
            }
        }
    }
    // Eight invocations hold each node's values.
    let ninth = tile::total(place, vec4<f32>(compared, 0.0)).xyz / 8.0;
    let checked = patch::ray_at(frame, scope.area, pixels::CHECK);
    let behind = depth_to(place, checked, section::place_on(piece, checked).y);
    let removed = removed_by(depth_before(place, checked, piece), behind);
    let misses = abs(ninth.z - removed) > limits.unmet * removed + mapped::NOTHING;
    let differs = abs(ninth.x - ninth.y) > limits.rough * ninth.x;
    let rough = through > UNSEEN && (differs || misses);
    return vec2<f32>(sum, select(0.0, 1.0, rough && !scope.is_last));
}

/// A node's share of the airlight along the ninth ray, from its fields there and from those between
/// the eight rays; eight invocations have the same.
fn on_ninth(place: u32, scope: Scope, light: lamp::Lamp, piece: section::Piece) -> vec3<f32> {
    let g = task.g;
    let ray = patch::ray_at(frame, scope.area, pixels::CHECK);
    let toward = to_light(light, ray);
    let node = batch::nodes[place / 8u];
    let chart = section::chart_on(piece, ray);
    let t = chart.x + chart.y * node.x;
    let log_weight = node.y + log_stretch(scope, piece, chart);
    let at = fields_of_eight(place, ray, light, t);
    return vec3<f32>(
        mapped::scattered(g, toward, t - toward.closest, at.log_seen + log_weight, at.mean),
        batch::airlight(place / 8u, g, pixels::shares(pixels::CHECK), toward, chart),
        at.of_blobs * num::exp_bounded(log_weight),
    );
}

/// Places a batch of a rule's nodes, as shares of a section of the middle ray.
fn place_nodes(place: u32, map: mapped::Map, size: u32, first: u32, chart: vec2<f32>) {
    // The last batch has been read.
    workgroupBarrier();
    if place < BATCH {
        let rule = rules[size - BATCH + first + place];
        let solved = mapped::solve(map, rule.x);
        let share = (solved.x - chart.x) / max(chart.y, num::LEAST);
        batch::nodes[place] = vec2<f32>(share, num::log_bounded(rule.y / solved.y));
    }
    workgroupBarrier();
}

/// Evaluates the fields of a batch on the eight rays.
fn fill_batch(place: u32, scope: Scope, light: lamp::Lamp, piece: section::Piece) {
    let node = batch::nodes[place / pixels::CONTROL];
    let ray = control_ray(scope, place);
    let chart = section::chart_on(piece, ray);
    let at = fields_at(ray, light, chart.x + chart.y * node.x);
    batch::fill(place, at.log_seen + node.y + log_stretch(scope, piece, chart), at.mean);
}

/// Airlight of the tail along a member's ray.
fn tail_airlight(
    place: u32,
    own: Own,
    scope: Scope,
    light: lamp::Lamp,
    piece: section::Piece,
    member: bool,
) -> f32 {
    // Four places on eight rays: eight invocations share the blobs of each pair.
    let pair = place / 8u;
    let ray = control_ray(scope, pair);
    let chart = section::tail_chart(piece, ray);
    let t = chart.x + chart.y * pixels::CHEBYSHEV[pair / pixels::CONTROL];
    let at = fields_of_eight(place, ray, light, t);
    workgroupBarrier();
    if place % 8u == 0u {
        batch::logs[pair] = at.log_seen;
        batch::means[pair] = at.mean;
    }
    workgroupBarrier();
    if !member {
        return 0.0;
    }
    let along = section::tail_chart(piece, own.ray);
    var tail = pixels::Tail(piece.begin, along, vec4<f32>(0.0), -FAR, vec4<f32>(0.0));
    for (var i = 0u; i < pixels::TAIL; i++) {
        tail.log_seen[i] = batch::log_between(i, own.share);
        tail.mean[i] = batch::mean_between(i, own.share);
        tail.most = max(tail.most, batch::most_of(i));
    }
    let toward = to_light(light, own.ray);
    return pixels::tail_airlight(tail, task.g, toward, min(own.length_m, piece.end));
}

/// One of the eight rays.
fn control_ray(scope: Scope, place: u32) -> view::Ray {
    return patch::ray_at(frame, scope.area, pixels::PLACES[place % pixels::CONTROL]);
}

/// The map along a ray: 32 probes, eight invocations each.
fn map_along(
    place: u32,
    scope: Scope,
    ray: view::Ray,
    light: lamp::Lamp,
    piece: section::Piece,
) -> mapped::Map {
    let g = task.g;
    let toward = to_light(light, ray);
    let ends = section::place_on(piece, ray);
    let dense = select(ends, scope.dense, scope.dense.x < scope.dense.y);
    let probe = pilot::probe(place, ends.x, ends.y, dense, toward);
    let at = fields_of_eight(place, ray, light, probe.at);
    let deserves = mapped::weight_of(g, toward, probe.at - toward.closest, at);
    let lumps = pilot::lumps(place, probe, deserves);
    let inner = clamp(scope.dense, vec2<f32>(ends.x), vec2<f32>(ends.y));
    return mapped::map_of(g, ends.x, ends.y, toward, lumps.low, lumps.high, inner);
}

/// T of the blobs along a ray to a ray parameter [m].
fn depth_to(place: u32, ray: view::Ray, t: f32) -> f32 {
    let share = view_sums(ray, t, 1u << (place % 32u)).y;
    return tile::total_of(place, 32u, vec4<f32>(share)).x;
}

/// T of the blobs to where a piece begins; none where no edge cuts it.
fn depth_before(place: u32, ray: view::Ray, piece: section::Piece) -> f32 {
    if piece.low == section::UNCUT {
        return 0.0;
    }
    return depth_to(place, ray, section::place_on(piece, ray).x);
}

/// Share of the light that blobs remove between two depths.
fn removed_by(before: f32, behind: f32) -> f32 {
    return num::exp_bounded(-before) * num::absorptance(max(behind - before, 0.0));
}

/// How many nodes are enough: the coarsest rule that agrees with the next along a ray, and that
/// meets what the blobs are known to remove of light.
fn size_of(
    place: u32,
    ray: view::Ray,
    light: lamp::Lamp,
    map: mapped::Map,
    piece: section::Piece,
    removed: f32,
) -> u32 {
    let toward = to_light(light, ray);
    let chart = section::chart_on(piece, ray);
    var coarse = vec2<f32>(-1.0);
    for (var size = BATCH; size <= LARGEST_RULE; size *= 2u) {
        let fine = rule_sums(place, ray, light, toward, map, size, chart);
        let agree = abs(fine.x - coarse.x) <= limits.agree * fine.x;
        if agree && abs(coarse.y - removed) <= limits.unmet * removed + mapped::NOTHING {
            return size / 2u;
        }
        coarse = fine;
    }
    return LARGEST_RULE;
}

/// What a rule makes of a ray: its airlight, and ∫ β e^(−T) dt of the blobs alone.
fn rule_sums(
    place: u32,
    ray: view::Ray,
    light: lamp::Lamp,
    toward: lamp::ToLight,
    map: mapped::Map,
    size: u32,
    chart: vec2<f32>,
) -> vec2<f32> {
    var sums = vec2<f32>(0.0);
    for (var first = 0u; first < size; first += BATCH) {
        place_nodes(place, map, size, first, chart);
        let node = batch::nodes[place / 8u];
        let t = chart.x + chart.y * node.x;
        let at = fields_of_eight(place, ray, light, t);
        let log_seen = at.log_seen + node.y;
        let aside = t - toward.closest;
        sums += vec2<f32>(
            mapped::scattered(task.g, toward, aside, log_seen, at.mean),
            at.of_blobs * num::exp_bounded(node.y),
        );
    }
    // Eight invocations hold each node's values.
    return tile::total(place, vec4<f32>(sums, 0.0, 0.0)).xy / 8.0;
}

/// Fields at a place of a ray, the blobs shared by eight neighbouring invocations.
fn fields_of_eight(place: u32, ray: view::Ray, light: lamp::Lamp, t: f32) -> mapped::Fields {
    let own = sums_at(ray, light, t, EIGHTH << (place % 8u));
    return fields_of(tile::total_of(place, 8u, own), ray, light, t);
}

/// The same by the invocation alone.
fn fields_at(ray: view::Ray, light: lamp::Lamp, t: f32) -> mapped::Fields {
    return fields_of(sums_at(ray, light, t, ALL), ray, light, t);
}

#ifdef LIGHT_TABLE
fn sums_at(ray: view::Ray, light: lamp::Lamp, t: f32, some: u32) -> vec4<f32> {
    return vec4<f32>(view_sums(ray, t, some), 0.0);
}

/// From sums over blobs, and the mean towards the light as its table has it.
fn fields_of(sums: vec4<f32>, ray: view::Ray, light: lamp::Lamp, t: f32) -> mapped::Fields {
    let way = ray.offset + t * ray.direction - light.position;
    let distance_m = length(way);
    let at = light_table::cell_of(extent, way, distance_m);
    // Loops that no compiler unrolls: there are many calls.
    var mean = 0.0;
    var rows = at.rows;
    for (var row = at.first; row < at.first + 4u * at.row; row += at.row) {
        var along = vec4<f32>(0.0);
        var columns = at.columns;
        for (var i = row; i < row + 4u * at.column; i += at.column) {
            along += columns.x * vec4<f32>(means[i], means[i + 1u], means[i + 2u], means[i + 3u]);
            columns = columns.yzwx;
        }
        mean += rows.x * dot(at.shells, along);
        rows = rows.yzwx;
    }
    let depth = max(mean, 0.0) * at.seen * distance_m;
    return mapped::fields(vec4<f32>(sums.xyz, depth), haze_at(ray, light, t), distance_m);
}
#else
/// β of the group that scatters, T from the eye, β of all and T from the light at a place of a ray, over
/// the blobs of a mask.
fn sums_at(ray: view::Ray, light: lamp::Lamp, t: f32, some: u32) -> vec4<f32> {
    let along = view_sums(ray, t, some);
    let way = gaussians::way_between(ray.offset + t * ray.direction, light.position);
    var depth = 0.0;
    for (var at = 0u; at < frame.blobs; at++) {
        if ((some >> (at % 32u)) & 1u) == 1u {
            depth += gaussians::depth_on(way, blobs[at]);
        }
    }
    return vec4<f32>(along, depth);
}

fn fields_of(sums: vec4<f32>, ray: view::Ray, light: lamp::Lamp, t: f32) -> mapped::Fields {
    let distance_m = distance(ray.offset + t * ray.direction, light.position);
    return mapped::fields(sums, haze_at(ray, light, t), distance_m);
}
#endif

/// β of the group, T from the eye and T/d from the light of what stands in closed form.
fn haze_at(ray: view::Ray, light: lamp::Lamp, t: f32) -> vec3<f32> {
    let point = ray.offset + t * ray.direction;
    return vec3<f32>(
        haze::extinction(task.group, point),
        haze::depth(ray.offset, ray.direction, t),
        haze::mean(point, light.position),
    );
}

/// β of the group that scatters, T from the eye, and β of all.
fn view_sums(ray: view::Ray, t: f32, some: u32) -> vec3<f32> {
    let group = task.group;
    var sums = vec3<f32>(0.0);
    for (var word = 0u; word < tile::words(frame.blobs); word++) {
        var bits = tile::kept(word) & some;
        while bits != 0u {
            let blob = blobs[word * 32u + firstTrailingBit(bits)];
            bits &= bits - 1u;
            let seen = gaussians::seen_from(blob, ray.offset);
            let line = gaussians::line_of(seen, ray.direction, t);
            let beta = gaussians::extinction_at_end(seen, line);
            sums += vec3<f32>(
                select(0.0, beta, blob.group == group),
                gaussians::depth_of(seen, line, t),
                beta,
            );
        }
    }
    return sums;
}

fn to_light(light: lamp::Lamp, ray: view::Ray) -> lamp::ToLight {
    return lamp::to_light(light.position - ray.offset, ray.direction);
}
