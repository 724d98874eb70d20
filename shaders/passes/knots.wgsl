// Where the rays of every block of the picture are tabulated along depth: even steps in a mixture of the angles
// that the ray through the block's middle turns through before the lamps, the light that fog removes of some of
// its rays, and plain distance among the blobs. And which blobs are near the block.
//
// A workgroup takes a block.
//
// Twin: core/src/cpu/grid/knots.rs.

#import fogbank::num
#import fogbank::view
#import fogbank::bundle
#import fogbank::lamp
#import fogbank::haze
#import fogbank::media::gaussians
#import fogbank::grid::around
#import fogbank::grid::block
#import fogbank::grid::cell
#import fogbank::grid::glow

@group(0) @binding(0) var<uniform> frame: view::View;
@group(0) @binding(1) var hits: texture_2d<f32>;
@group(0) @binding(2) var<storage, read> blobs: array<gaussians::Blob>;
@group(0) @binding(5) var<storage, read> lamps: array<lamp::Lamp>;
@group(0) @binding(8) var<uniform> fineness: block::Fineness;
@group(0) @binding(14) var<storage, read_write> blocks: array<block::Block>;
/// A bit a blob, block by block: 1 where it is near.
@group(0) @binding(15) var<storage, read_write> near: array<u32>;

/// Invocations of a workgroup.
const SIZE: u32 = 64u;
/// Share of the knots that lie evenly in the angles seen from the lamps.
const LIGHT: f32 = 0.45;
/// Share of them that lie evenly in the light that the fog removes; the rest lies evenly among the blobs.
const FOG: f32 = 0.45;
/// Places that are looked at: both ends, evenly, halfway to the beginning again and again, among the blobs, and
/// where the first lamps see even angles.
const EVENLY: u32 = 12u;
const HALVINGS: u32 = 12u;
const AMONG: u32 = 32u;
const OF_A_LAMP: u32 = 6u;
const LAMPS: u32 = 4u;
const PLACES: u32 = 82u;
/// Rays of a block that they are looked at on.
const RAYS: u32 = 4u;
/// The first knot, as a share of the next.
const FIRST: f32 = 0.05;
/// Distances of a lamp from a ray at which it is left behind: from there on it sees the rest of the ray under
/// less than a third of a right angle.
const BEHIND: f32 = 2.0;
/// Knots that stand no farther apart than this are one.
const ALIKE: f32 = 1.00001;

/// Rays across a block on which it is asked where there is fog; between them fog may begin sooner and end later by
/// this share.
const ACROSS: u32 = 7u;
const ROOM: f32 = 0.1;

/// What of the picture a block covers [px].
struct Area {
    middle: vec2<f32>,
    half: vec2<f32>,
}

/// Where the fog of a block lies [m].
struct Reach {
    begin: f32,
    end: f32,
    /// From where to where there are blobs; none if it is empty.
    dense: vec2<f32>,
}

var<workgroup> longest: atomic<u32>;
var<workgroup> sums: array<vec2<f32>, SIZE>;
var<workgroup> spans: array<vec2<f32>, 49>;
var<workgroup> unsorted: array<f32, PLACES>;
var<workgroup> sorted: array<f32, PLACES>;
var<workgroup> removed: array<f32, 328>;
var<workgroup> share: array<f32, PLACES>;
/// The knots.
var<workgroup> even: array<f32, 64>;

@compute @workgroup_size(64)
fn place_knots(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) place: u32,
) {
    let index = group.y * groups.x + group.x;
    let corner = group.xy * block::SIDE;
    let area = area_of(corner);
    let deepest = min(deepest_end(place, corner), opaque_haze());
    let reach = reach_of(place, index, area, deepest);
    if reach.begin >= reach.end {
        if place == 0u {
            blocks[index].count = 0u;
        }
        return;
    }
    let middle = ray_at(area, vec2<f32>(0.0));
    let found = look_around(place, index, area, middle, reach);
    // What follows is short, and each step waits for the last.
    if place == 0u {
        let count = step_evenly(found, area, reach);
        blocks[index].ends = vec2<f32>(reach.begin, reach.end);
        part(index, count, behind_all(middle, reach));
    }
}

/// Of a block with that corner: rays beside the picture would see other fog.
fn area_of(corner: vec2<u32>) -> Area {
    let half = 0.5 * min(frame.size - vec2<f32>(corner), vec2<f32>(f32(block::SIDE)));
    return Area(vec2<f32>(corner) + half, half);
}

fn ray_at(area: Area, place: vec2<f32>) -> view::Ray {
    return view::ray_through(frame, area.middle + area.half * place);
}

/// Where the longest ray of the block ends [m].
fn deepest_end(place: u32, corner: vec2<u32>) -> f32 {
    if place == 0u {
        atomicStore(&longest, 0u);
    }
    workgroupBarrier();
    for (var at = place; at < block::SIDE * block::SIDE; at += SIZE) {
        let pixel = corner + vec2<u32>(at % block::SIDE, at / block::SIDE);
        if view::is_inside(frame, pixel) {
            // Positive numbers are ordered as their bits are.
            atomicMax(&longest, bitcast<u32>(textureLoad(hits, pixel, 0).w));
        }
    }
    workgroupBarrier();
    return bitcast<f32>(atomicLoad(&longest));
}

/// Where haze that is everywhere hides what is behind [m].
fn opaque_haze() -> f32 {
    return min(frame.opaque, block::OPAQUE) / max(haze::bounds().x, 1.0 / block::FAR);
}

/// Where the block's rays meet fog; marks the blobs near them.
fn reach_of(place: u32, index: u32, area: Area, deepest: f32) -> Reach {
    let rays = bundle::of_view(frame, area.middle - area.half, area.middle + area.half, deepest);
    let words = block::words(frame.blobs);
    var fog = around::nothing();
    for (var word = place; word < words; word += SIZE) {
        var bits = 0u;
        for (var at = 32u * word; at < min(32u * word + 32u, frame.blobs); at++) {
            let blob = blobs[at];
            if bundle::distance_to(rays, gaussians::center_of(blob)) < blob.reach_m {
                bits |= 1u << (at % 32u);
                around::add(&fog, blob, rays);
            }
        }
        near[index * words + word] = bits;
    }
    sums[place] = vec2<f32>(fog.begin, fog.end);
    // Other invocations read what is near, too.
    storageBarrier();
    workgroupBarrier();
    var dense = vec2<f32>(block::FAR, 0.0);
    for (var i = 0u; i < SIZE; i++) {
        dense = vec2<f32>(min(dense.x, sums[i].x), max(dense.y, sums[i].y));
    }
    dense = vec2<f32>(max(dense.x, 0.0), min(dense.y, deepest));
    if haze::bounds().y > 0.0 {
        let hazy = hazy(place, area, deepest);
        let is_dense = dense.x < dense.y;
        let both = vec2<f32>(min(hazy.x, dense.x), max(hazy.y, dense.y));
        let ends = select(hazy, both, is_dense);
        return Reach(ends.x, ends.y, dense);
    }
    return Reach(dense.x, dense.y, dense);
}

/// From where to where the block's rays meet what is smooth [m]; all of them where none that is looked at does.
fn hazy(place: u32, area: Area, deepest: f32) -> vec2<f32> {
    for (var i = place; i < ACROSS * ACROSS; i += SIZE) {
        let at = vec2<f32>(f32(i % ACROSS), f32(i / ACROSS)) * (2.0 / f32(ACROSS - 1u)) - 1.0;
        let ray = ray_at(area, at);
        spans[i] = haze::span(ray.offset, ray.direction, deepest);
    }
    workgroupBarrier();
    var ends = vec2<f32>(block::FAR, -block::FAR);
    for (var i = 0u; i < ACROSS * ACROSS; i++) {
        ends = vec2<f32>(min(ends.x, spans[i].x), max(ends.y, spans[i].y));
    }
    let roomy = vec2<f32>(ends.x * (1.0 - ROOM), min(ends.y * (1.0 + ROOM), deepest));
    return select(vec2<f32>(0.0, deepest), roomy, ends.x < ends.y);
}

/// Looks at places along the block's rays; returns how many there are.
fn look_around(
    place: u32,
    index: u32,
    area: Area,
    middle: view::Ray,
    reach: Reach,
) -> u32 {
    for (var i = place; i < PLACES; i += SIZE) {
        unsorted[i] = place_at(i, middle, reach);
    }
    workgroupBarrier();
    var count = 0u;
    for (var i = 0u; i < PLACES; i++) {
        count += select(0u, 1u, unsorted[i] < block::FAR);
    }
    for (var i = place; i < PLACES; i += SIZE) {
        sorted[rank(i)] = unsorted[i];
    }
    workgroupBarrier();
    for (var i = place; i < RAYS * count; i += SIZE) {
        let at = vec2<f32>(f32(i % RAYS % 2u), f32(i % RAYS / 2u)) - 0.5;
        let depth = depth_to(index, ray_at(area, at), sorted[i / RAYS]);
        removed[i] = num::absorptance(depth);
    }
    workgroupBarrier();
    for (var i = place; i < count; i += SIZE) {
        share[i] = mixture(i, count, middle, reach);
    }
    workgroupBarrier();
    return count;
}

/// One of the places, in no order; beyond all where there is none [m].
fn place_at(i: u32, middle: view::Ray, reach: Reach) -> f32 {
    let length_m = reach.end - reach.begin;
    var at = i;
    if at < 2u {
        return select(reach.begin, reach.end, at == 1u);
    }
    at -= 2u;
    if at < EVENLY {
        return reach.begin + length_m * (f32(at) + 0.5) / f32(EVENLY);
    }
    at -= EVENLY;
    if at < HALVINGS {
        return reach.begin + length_m * exp2(-f32(at + 1u));
    }
    at -= HALVINGS;
    if at < AMONG {
        let t = mix(reach.dense.x, reach.dense.y, (f32(at) + 0.5) / f32(AMONG));
        return select(2.0 * block::FAR, t, reach.dense.x < reach.dense.y);
    }
    at -= AMONG;
    if at / OF_A_LAMP >= arrayLength(&lamps) {
        return 2.0 * block::FAR;
    }
    let light = lamp::beside(lamps[at / OF_A_LAMP], middle.offset, middle.direction);
    let first = num::arc_tangent((reach.begin - light.closest) / light.miss);
    let last = num::arc_tangent((reach.end - light.closest) / light.miss);
    let angle = mix(first, last, (f32(at % OF_A_LAMP) + 0.5) / f32(OF_A_LAMP));
    let t = light.closest + light.miss * tan(angle);
    return select(2.0 * block::FAR, t, t > reach.begin && t < reach.end);
}

/// How many places stand before one.
fn rank(i: u32) -> u32 {
    let own = unsorted[i];
    var before = 0u;
    for (var k = 0u; k < PLACES; k++) {
        let other = unsorted[k];
        before += u32(other < own || (other == own && k < i));
    }
    return before;
}

/// T along a ray to a ray parameter [m].
fn depth_to(index: u32, ray: view::Ray, t: f32) -> f32 {
    let words = block::words(frame.blobs);
    var depth = 0.0;
    for (var word = 0u; word < words; word++) {
        var bits = near[index * words + word];
        while bits != 0u {
            let blob = blobs[32u * word + firstTrailingBit(bits)];
            bits &= bits - 1u;
            let seen = gaussians::seen_from(blob, ray.offset);
            let start = -dot(seen.b, ray.direction);
            let aside = cross(seen.b, ray.direction);
            var between = num::erf_plain_difference(start, start + seen.a * t);
            if seen.is_slab {
                between = gaussians::gathered_between(start, start + seen.a * t, seen.a * t);
            }
            depth += seen.k * num::exp_bounded(-dot(aside, aside)) * between;
        }
    }
    return max(depth, 0.0) + haze::depth(ray.offset, ray.direction, t);
}

/// How many of the knots should stand before a place, as a share.
fn mixture(i: u32, count: u32, middle: view::Ray, reach: Reach) -> f32 {
    let t = sorted[i];
    var turned = 0.0;
    for (var k = 0u; k < arrayLength(&lamps); k++) {
        let light = lamp::beside(lamps[k], middle.offset, middle.direction);
        let whole = glow::turn(light, reach.begin, reach.end);
        turned += glow::turn(light, reach.begin, t) / max(whole, num::LEAST);
    }
    let first = removed_to(0u);
    let rise = max(removed_to(count - 1u) - first, num::LEAST);
    let is_dense = reach.dense.x < reach.dense.y;
    let dense = select(vec2<f32>(reach.begin, reach.end), reach.dense, is_dense);
    let among = clamp((t - dense.x) / (dense.y - dense.x), 0.0, 1.0);
    return LIGHT * turned / f32(arrayLength(&lamps)) + FOG * (removed_to(i) - first) / rise
        + (1.0 - LIGHT - FOG) * among;
}

fn removed_to(i: u32) -> f32 {
    let at = i * RAYS;
    return removed[at] + removed[at + 1u] + removed[at + 2u] + removed[at + 3u];
}

/// The knots from the first to the last; returns how many.
fn step_evenly(found: u32, area: Area, reach: Reach) -> u32 {
    let first = share[0];
    let last = share[found - 1u];
    var count = 1u;
    var at = 0u;
    for (var k = 1u; k < fineness.knots; k++) {
        let wanted = mix(first, last, f32(k) / f32(fineness.knots));
        while at + 2u < found && share[at + 1u] < wanted {
            at += 1u;
        }
        let rise = max(share[at + 1u] - share[at], num::LEAST);
        let part = clamp((wanted - share[at]) / rise, 0.0, 1.0);
        count = insert(mix(sorted[at], sorted[at + 1u], part), count, reach);
    }
    count = insert_near(count, area, reach);
    even[0] = max(reach.begin, select(even[1], reach.end, count == 1u) * FIRST);
    even[count] = reach.end;
    var kept = 1u;
    for (var i = 1u; i <= count; i++) {
        if even[i] > even[kept - 1u] * ALIKE {
            even[kept] = even[i];
            kept += 1u;
        }
    }
    return kept;
}

/// Puts a place among those behind the first, if there is fog; returns how many there are.
fn insert(t: f32, count: u32, reach: Reach) -> u32 {
    if t <= reach.begin || t >= reach.end {
        return count;
    }
    var at = count;
    while at > 1u && even[at - 1u] > t {
        even[at] = even[at - 1u];
        at -= 1u;
    }
    even[at] = t;
    return count + 1u;
}

/// Puts places where the lamps are whose images are near: T towards a lamp has a cone there.
fn insert_near(before: u32, area: Area, reach: Reach) -> u32 {
    var count = before;
    var lit = 0u;
    for (var k = 0u; k < arrayLength(&lamps) && lit < LAMPS; k++) {
        let at = view::picture_place(frame, lamps[k].position);
        let image = cell::image_of(frame, at);
        if !lamp::is_sun(lamps[k]) && at.z > 0.0 && distance(image, area.middle) < 2.0 * f32(block::SIDE) {
            let ray = view::ray_through(frame, image);
            let light = lamp::beside(lamps[k], ray.offset, ray.direction);
            count = insert(light.closest, count, reach);
            lit += 1u;
        }
    }
    return count;
}

/// Where all blobs and lamps lie before [m].
fn behind_all(middle: view::Ray, reach: Reach) -> f32 {
    var behind = select(0.0, reach.dense.y, reach.dense.x < reach.dense.y);
    for (var k = 0u; k < arrayLength(&lamps); k++) {
        let light = lamp::beside(lamps[k], middle.offset, middle.direction);
        behind = max(behind, max(light.closest, 0.0) + BEHIND * light.miss);
    }
    return behind;
}

/// Writes the knots; puts two where all blobs and lamps lie before: one tells of them, one of what is behind.
fn part(index: u32, count: u32, behind: f32) {
    let parts = behind < even[count - 1u];
    var first = 0u;
    while first < count && even[first] < behind {
        first += 1u;
    }
    for (var i = 0u; i < count; i++) {
        blocks[index].at[i + select(0u, 2u, parts && i >= first)] = even[i];
    }
    blocks[index].behind = 0xffffffffu;
    blocks[index].count = count;
    if parts {
        blocks[index].at[first] = behind;
        blocks[index].at[first + 1u] = behind;
        blocks[index].behind = first + 1u;
        blocks[index].count = count + 2u;
    }
}
