// Airlight of lamps in any fog by `mapped`'s rule, a tile of 16×16 pixels a workgroup.
//
// What is expensive is smooth across the tile: at the nodes of the rule, ln β − T(v,x) and T(x,s)/d
// are evaluated on eight rays around it, 32 nodes at once, one pair of node and ray an invocation,
// and each pixel interpolates them. The rays of a tile end at different depths: those that end
// close to each other share a layer, whose rule covers what all of them see (the head), and a short
// rule of each pixel's own the rest (the tail).
//
// Pixels for which that would not do are left to mapped_rays.wgsl: around a lamp's image, where
// blobs hide between the eight rays, where a ninth ray shows that quadratics miss the fields, and
// those of more layers than a tile may have. `left` tells which.
//
// Twins: core/src/cpu/mapped/{mod,patch,control,crossings,pilot}.rs.

#import fogbank::num
#import fogbank::view
#import fogbank::bundle
#import fogbank::lamp
#import fogbank::tile
#import fogbank::media::gaussians
#import fogbank::airlight::mapped
#import fogbank::mapped::pilot
#import fogbank::mapped::pixels
#import fogbank::mapped::around
#import fogbank::mapped::batch
#import fogbank::mapped::patch

/// The invocation's own pixel.
struct Own {
    ray: view::Ray,
    /// Where the ray ends; 0 if there is no such pixel [m].
    length_m: f32,
    /// How much each of the eight rays counts for it.
    share: pixels::Shares,
}

/// A tile before any lamp.
struct Scope {
    area: vec4<f32>,
    rays: bundle::Bundle,
    /// Where the fog begins and where nothing behind is seen any more [m].
    begin: f32,
    end: f32,
    /// From where to where there are blobs [m].
    dense: vec2<f32>,
}

/// A tile before one lamp, and a part of its rays' way.
struct Sight {
    light: lamp::Lamp,
    between: bundle::Wedge,
    dense: vec2<f32>,
    begin: f32,
    end: f32,
}

@group(0) @binding(0) var<uniform> frame: view::View;
@group(0) @binding(1) var hits: texture_2d<f32>;
@group(0) @binding(2) var<storage, read> blobs: array<gaussians::Blob>;
/// rgb: airlight [W/(m² sr)]. w: optical depth. Row by row.
@group(0) @binding(3) var<storage, read_write> fogged: array<vec4<f32>>;
/// xy: the lamps of this dispatch.
@group(0) @binding(4) var<uniform> part: view::Span;
@group(0) @binding(5) var<storage, read> lamps: array<lamp::Lamp>;
/// Gauss–Legendre abscissae and weights on [0, 1] of 32, 64, 128, 256 and 512 nodes, one after the
/// other.
@group(0) @binding(6) var<storage, read> rules: array<vec2<f32>>;
/// For every lamp of this dispatch and every tile, eight words of pixels that are left; lamps
/// outside.
@group(0) @binding(7) var<storage, read_write> left: array<u32>;
@group(0) @binding(8) var<uniform> limits: patch::Tolerance;

/// Nodes that are taken at once, and of the smallest rule.
const BATCH: u32 = 32u;
const LARGEST_RULE: u32 = 512u;
/// Layers of a tile.
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
var<workgroup> left_bits: array<atomic<u32>, 8>;

@compute @workgroup_size(16, 16)
fn add(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) place: u32,
) {
    let pixel = group.xy * tile::SIDE + local.xy;
    let area = patch::area_of(frame, group.xy);
    let own = own_of(pixel, area);
    let longest = tile::largest(place, vec4<f32>(own.length_m)).x;
    let rays = bundle::of_view(frame, area.xy, area.zw, longest);
    let fog = fog_around(place, rays, longest);
    let scope = scope_of(place, area, rays, fog);
    let unsuited = fog.hidden > limits.whole.y || patch::is_wide(frame, area, limits.whole.z);

    var airlight = vec3<f32>(0.0);
    for (var i = part.range.x; i < part.range.y; i++) {
        let light = lamps[i];
        let near = patch::is_near(frame, area, light, longest, limits.whole.x);
        clear_left(place);
        if scope.begin < scope.end {
            if unsuited || near {
                leave(place, own.length_m > scope.begin);
            } else {
                airlight += of_lamp(place, own, scope, light) * light.scattered.rgb;
            }
        }
        store_left(place, (i - part.range.x) * groups.x * groups.y + group.y * groups.x + group.x);
    }
    if view::is_inside(frame, pixel) {
        fogged[view::index_of(frame, pixel)] += vec4<f32>(airlight, 0.0);
    }
}

fn own_of(pixel: vec2<u32>, area: vec4<f32>) -> Own {
    let share = pixels::shares(patch::place_in(area, view::sample_of(frame, pixel)));
    var own = Own(view::ray_of(frame, pixel), 0.0, share);
    if view::is_inside(frame, pixel) {
        own.length_m = textureLoad(hits, view::pixel_of(frame, pixel), 0).w;
    }
    return own;
}

/// What all blobs around the tile's rays come to.
fn fog_around(place: u32, rays: bundle::Bundle, longest: f32) -> around::Fog {
    var fog = around::nothing();
    for (var at = place; at < frame.counts.z; at += tile::SIZE) {
        around::add(&fog, blobs[at], rays);
    }
    let ends = tile::largest(place, vec4<f32>(-fog.begin, fog.end, 0.0, 0.0));
    let sums = tile::total(place, vec4<f32>(fog.most, fog.hidden, 0.0, 0.0));
    return around::Fog(max(-ends.x, 0.0), min(ends.y, longest), sums.x, sums.y);
}

fn scope_of(place: u32, area: vec4<f32>, rays: bundle::Bundle, fog: around::Fog) -> Scope {
    let beta = frame.ambient.w;
    let dense = vec2<f32>(fog.begin, fog.end);
    var scope = Scope(area, rays, fog.begin, fog.end, dense);
    if beta > 0.0 {
        scope.begin = 0.0;
        scope.end = rays.length_m;
    }
    if scope.begin < scope.end && fog.most + beta * scope.end > mapped::OPAQUE {
        scope.end = opaque_from(place, scope);
    }
    return scope;
}

/// Where nothing behind is seen any more on any of the eight rays, looked for at 32 places.
fn opaque_from(place: u32, scope: Scope) -> f32 {
    let slot = place / pixels::CONTROL;
    let ray = control_ray(scope, place);
    let t = scope.begin + (scope.end - scope.begin) * f32(slot + 1u) / f32(BATCH);
    if place < BATCH {
        atomicStore(&thinnest[place], 0x7f7fffffu);
    }
    workgroupBarrier();
    let depth = view_sums(place, scope.rays, ray, t, ALL).y + frame.ambient.w * t;
    // Positive numbers are ordered as their bits are.
    atomicMin(&thinnest[slot], bitcast<u32>(max(depth, 0.0)));
    workgroupBarrier();
    var end = scope.end;
    if bitcast<f32>(atomicLoad(&thinnest[slot])) > mapped::OPAQUE {
        end = t;
    }
    return -tile::largest(place, vec4<f32>(-end)).x;
}

/// One lamp's airlight along the invocation's ray per unit of ω·I, layer by layer.
fn of_lamp(place: u32, own: Own, scope: Scope, light: lamp::Lamp) -> f32 {
    let end = min(own.length_m, scope.end);
    let thin = limits.rule.z * max(scope.dense.y - scope.dense.x, 0.0);
    var waits = own.length_m > scope.begin;
    var sum = 0.0;
    for (var layer = 0u; layer < LAYERS; layer++) {
        let first = -tile::largest(place, vec4<f32>(select(-FAR, -end, waits))).x;
        if first >= FAR {
            break;
        }
        let reach = first + max(limits.rule.y * (first - scope.begin), thin);
        let member = waits && end <= reach;
        let last = tile::largest(place, vec4<f32>(select(0.0, end, member))).x;
        waits = waits && !member;
        var head = vec2<f32>(0.0, 1.0);
        if first - scope.begin > 1e-6 * first {
            head = head_airlight(place, own, scope, sight_of(light, scope, scope.begin, first));
        }
        leave(place, member && head.y == 0.0);
        if head.y != 0.0 && last - first > 1e-5 * (last - scope.begin) {
            head.x += tail_airlight(place, own, scope, sight_of(light, scope, first, last));
        }
        sum += select(0.0, head.x, member && head.y != 0.0);
    }
    leave(place, waits);
    return sum;
}

fn sight_of(light: lamp::Lamp, scope: Scope, begin: f32, end: f32) -> Sight {
    let between = bundle::wedge(light.position.xyz, scope.rays, begin, end);
    return Sight(light, between, scope.dense, begin, end);
}

/// x: airlight of the head along the invocation's ray. y: 1, or 0 if quadratics miss the fields.
fn head_airlight(place: u32, own: Own, scope: Scope, sight: Sight) -> vec2<f32> {
    let middle = patch::ray_at(frame, scope.area, vec2<f32>(0.0));
    let map = map_along(place, scope, middle, sight);
    let through = depth_at_end(place, scope, middle, sight);
    let size = size_of(place, scope, middle, sight, map, num::absorptance(through));

    let toward = to_light(sight.light, own.ray, own.length_m);
    var sum = 0.0;
    // The airlight along the ninth ray, as it is and as it would be.
    var compared = vec2<f32>(0.0);
    for (var first = 0u; first < size; first += BATCH) {
        fill_batch(place, scope, sight, map, size, first);
        compared += on_ninth(place, scope, sight, rule_node(map, size, first + place / 8u));
        for (var j = 0u; j < BATCH; j++) {
            sum += batch::airlight(j, frame.optics.x, own.share, toward);
        }
    }
    let both = tile::total(place, vec4<f32>(compared, 0.0, 0.0)).xy;
    let rough = through > UNSEEN && abs(both.x - both.y) > limits.whole.w * both.x;
    return vec2<f32>(sum, select(1.0, 0.0, rough));
}

/// A node's share of the airlight along the ninth ray, from its fields there and from those between
/// the eight rays; eight invocations have the same.
fn on_ninth(place: u32, scope: Scope, sight: Sight, node: vec2<f32>) -> vec2<f32> {
    let g = frame.optics.x;
    let ray = patch::ray_at(frame, scope.area, pixels::CHECK);
    let toward = to_light(sight.light, ray, sight.end);
    let at = fields_of_eight(place, scope, ray, sight, node.x);
    let aside = node.x - toward.closest;
    return vec2<f32>(
        mapped::scattered(g, toward, aside, at.log_seen + node.y, at.mean),
        batch::airlight(place / 8u, g, pixels::shares(pixels::CHECK), toward),
    );
}

/// Evaluates the fields of a batch of nodes on the eight rays.
fn fill_batch(
    place: u32,
    scope: Scope,
    sight: Sight,
    map: mapped::Map,
    size: u32,
    first: u32,
) {
    let ray = control_ray(scope, place);
    let node = rule_node(map, size, first + place / pixels::CONTROL);
    let sums = sums_at(place, scope, ray, sight, node.x, ALL);
    let distance_m = distance_from(sight.light, ray, node.x);
    let at = mapped::fields(sums, frame.ambient.w, node.x, distance_m);
    // The last batch has been read.
    workgroupBarrier();
    batch::logs[place] = at.log_seen + node.y;
    batch::means[place] = at.mean;
    workgroupBarrier();
    if place < BATCH {
        batch::node_at[place] = rule_node(map, size, first + place).x;
        batch::node_most[place] = batch::most_of(place);
    }
    workgroupBarrier();
}

/// Airlight of the tail along the invocation's ray.
fn tail_airlight(place: u32, own: Own, scope: Scope, sight: Sight) -> f32 {
    // Four places on eight rays: eight invocations share the blobs of each pair.
    let pair = place / 8u;
    let range = sight.end - sight.begin;
    let t = sight.begin + range * pixels::CHEBYSHEV[pair / pixels::CONTROL];
    let at = fields_of_eight(place, scope, control_ray(scope, pair), sight, t);
    if place % 8u == 0u {
        batch::logs[pair] = at.log_seen;
        batch::means[pair] = at.mean;
    }
    workgroupBarrier();

    var tail = pixels::Tail(sight.begin, range, vec4<f32>(0.0), -FAR, vec4<f32>(0.0));
    for (var i = 0u; i < pixels::TAIL; i++) {
        tail.log_seen[i] = batch::log_between(i, own.share);
        tail.mean[i] = batch::mean_between(i, own.share);
        tail.most = max(tail.most, batch::most_of(i));
    }
    let toward = to_light(sight.light, own.ray, own.length_m);
    return pixels::tail_airlight(tail, frame.optics.x, toward, min(own.length_m, sight.end));
}

/// One of the eight rays.
fn control_ray(scope: Scope, place: u32) -> view::Ray {
    return patch::ray_at(frame, scope.area, pixels::PLACES[place % pixels::CONTROL]);
}

/// The map along a ray: 32 probes, eight invocations each.
fn map_along(place: u32, scope: Scope, ray: view::Ray, sight: Sight) -> mapped::Map {
    let own = pilot::Place(0u, place / 8u, place % 8u == 0u);
    let toward = to_light(sight.light, ray, sight.end);
    var dense = sight.dense;
    if dense.x >= dense.y {
        dense = vec2<f32>(sight.begin, sight.end);
    }
    let probe = pilot::probe(own, sight.begin, sight.end, dense, toward);
    let at = fields_of_eight(place, scope, ray, sight, probe.at);
    let deserves = mapped::weight_of(frame.optics.x, toward, probe.at - toward.closest, at);
    let lumps = pilot::lumps(own, probe, deserves);
    let g = frame.optics.x;
    return mapped::map_of(g, sight.begin, sight.end, toward, lumps.low, lumps.high);
}

/// T along a ray to the end of the piece.
fn depth_at_end(place: u32, scope: Scope, ray: view::Ray, sight: Sight) -> f32 {
    let share = view_sums(place, scope.rays, ray, sight.end, 1u << (place % 32u)).y;
    let depth = tile::total_of(place, 32u, vec4<f32>(share)).x;
    return tile::largest(place, vec4<f32>(depth)).x + frame.ambient.w * sight.end;
}

/// How many nodes are enough: the coarsest rule that agrees with the next along a ray, and that
/// meets what the fog is known to remove of light.
fn size_of(
    place: u32,
    scope: Scope,
    ray: view::Ray,
    sight: Sight,
    map: mapped::Map,
    removed: f32,
) -> u32 {
    var size = BATCH;
    var coarse = rule_sums(place, scope, ray, sight, map, size);
    while size < LARGEST_RULE && removed > mapped::CLEAR {
        let fine = rule_sums(place, scope, ray, sight, map, 2u * size);
        let agree = abs(fine.x - coarse.x) <= limits.rule.x * fine.x;
        if agree && abs(coarse.y - removed) <= mapped::UNMET * removed + mapped::NOTHING {
            break;
        }
        size *= 2u;
        coarse = fine;
    }
    return size;
}

/// What a rule makes of a ray: its airlight, and ∫ β e^(−T) dt.
fn rule_sums(
    place: u32,
    scope: Scope,
    ray: view::Ray,
    sight: Sight,
    map: mapped::Map,
    size: u32,
) -> vec2<f32> {
    let toward = to_light(sight.light, ray, sight.end);
    var sums = vec2<f32>(0.0);
    for (var first = 0u; first < size; first += BATCH) {
        let node = rule_node(map, size, first + place / 8u);
        let at = fields_of_eight(place, scope, ray, sight, node.x);
        let log_seen = at.log_seen + node.y;
        let aside = node.x - toward.closest;
        sums += vec2<f32>(
            mapped::scattered(frame.optics.x, toward, aside, log_seen, at.mean),
            num::exp_bounded(log_seen),
        );
    }
    // Eight invocations hold each node's values.
    return tile::total(place, vec4<f32>(sums, 0.0, 0.0)).xy / 8.0;
}

/// Ray parameter of a rule's node, and the logarithm of its weight.
fn rule_node(map: mapped::Map, size: u32, node: u32) -> vec2<f32> {
    let rule = rules[size - BATCH + node];
    let solved = mapped::solve(map, rule.x);
    return vec2<f32>(solved.x, num::log_bounded(rule.y / solved.y));
}

/// Fields at a place of a ray, the blobs shared by eight neighbouring invocations.
fn fields_of_eight(
    place: u32,
    scope: Scope,
    ray: view::Ray,
    sight: Sight,
    t: f32,
) -> mapped::Fields {
    let own = sums_at(place, scope, ray, sight, t, EIGHTH << (place % 8u));
    let sums = tile::total_of(place, 8u, vec4<f32>(own, 0.0)).xyz;
    return mapped::fields(sums, frame.ambient.w, t, distance_from(sight.light, ray, t));
}

/// β, T from the eye and T from the light at a place of a ray, over the blobs of a mask.
fn sums_at(place: u32, scope: Scope, ray: view::Ray, sight: Sight, t: f32, some: u32) -> vec3<f32> {
    let along = view_sums(place, scope.rays, ray, t, some);
    return vec3<f32>(along, light_sum(place, sight, ray.offset + t * ray.direction, some));
}

/// β and T from the eye.
fn view_sums(place: u32, rays: bundle::Bundle, ray: view::Ray, t: f32, some: u32) -> vec2<f32> {
    var sums = vec2<f32>(0.0);
    for (var first = 0u; first < frame.counts.z; first += tile::CHUNK) {
        tile::clear(place);
        for (var at = place; at < tile::CHUNK && first + at < frame.counts.z; at += tile::SIZE) {
            let blob = blobs[first + at];
            if bundle::distance_to(rays, gaussians::center_of(blob)) < blob.weight.y {
                tile::keep(at);
            }
        }
        workgroupBarrier();
        for (var word = 0u; word < tile::words(frame.counts.z - first); word++) {
            var bits = tile::kept(word) & some;
            while bits != 0u {
                let blob = blobs[first + word * 32u + firstTrailingBit(bits)];
                bits &= bits - 1u;
                let seen = gaussians::seen_from(blob, ray.offset);
                let line = gaussians::line_of(seen, ray.direction, t);
                sums.x += gaussians::extinction_at_end(seen, line);
                sums.y += gaussians::depth_of(seen, line, t);
            }
        }
    }
    return sums;
}

/// T from the light to a point.
fn light_sum(place: u32, sight: Sight, point: vec3<f32>, some: u32) -> f32 {
    let way = gaussians::way_between(point, sight.light.position.xyz);
    var sum = 0.0;
    for (var first = 0u; first < frame.counts.z; first += tile::CHUNK) {
        tile::clear(place);
        for (var at = place; at < tile::CHUNK && first + at < frame.counts.z; at += tile::SIZE) {
            let blob = blobs[first + at];
            let center = gaussians::center_of(blob);
            if bundle::distance_to_wedge(sight.between, center) < blob.weight.y {
                tile::keep(at);
            }
        }
        workgroupBarrier();
        for (var word = 0u; word < tile::words(frame.counts.z - first); word++) {
            var bits = tile::kept(word) & some;
            while bits != 0u {
                let blob = blobs[first + word * 32u + firstTrailingBit(bits)];
                bits &= bits - 1u;
                sum += gaussians::depth_on(way, blob);
            }
        }
    }
    return sum;
}

fn to_light(light: lamp::Lamp, ray: view::Ray, length_m: f32) -> lamp::ToLight {
    return lamp::to_light(light.position.xyz - ray.offset, ray.direction, length_m);
}

/// Distance of a place of a ray from a light [m].
fn distance_from(light: lamp::Lamp, ray: view::Ray, t: f32) -> f32 {
    return distance(ray.offset + t * ray.direction, light.position.xyz);
}

fn clear_left(place: u32) {
    workgroupBarrier();
    if place < 8u {
        atomicStore(&left_bits[place], 0u);
    }
    workgroupBarrier();
}

/// Leaves the invocation's pixel to mapped_rays.wgsl.
fn leave(place: u32, yes: bool) {
    if yes {
        atomicOr(&left_bits[place / 32u], 1u << (place % 32u));
    }
}

fn store_left(place: u32, tile_of_lamp: u32) {
    workgroupBarrier();
    if place < 8u {
        left[tile_of_lamp * 8u + place] = atomicLoad(&left_bits[place]);
    }
}
