// Airlight of lamps along the rays that mapped_tiles.wgsl left: each has nodes of its own, at which
// the blobs are summed up. A workgroup takes eight neighbouring pixels, 32 invocations each.
//
// Twin: airlight in core/src/airlight/mapped.rs.

#import fogbank::num
#import fogbank::view
#import fogbank::bundle
#import fogbank::lamp
#import fogbank::tile
#import fogbank::media::gaussians
#import fogbank::airlight::mapped
#import fogbank::mapped::pilot
#import fogbank::mapped::around

/// A part of a ray before one lamp.
struct Sight {
    light: vec3<f32>,
    rays: bundle::Bundle,
    between: bundle::Wedge,
    begin: f32,
    end: f32,
}

@group(0) @binding(0) var<uniform> frame: view::View;
@group(0) @binding(1) var hits: texture_2d<f32>;
@group(0) @binding(2) var<storage, read> blobs: array<gaussians::Blob>;
/// rgb: airlight [W/(m² sr)]. w: optical depth. Row by row.
@group(0) @binding(3) var<storage, read_write> fogged: array<vec4<f32>>;
/// xy: the lamps of this dispatch, those of mapped_tiles.wgsl.
@group(0) @binding(4) var<uniform> part: view::Span;
@group(0) @binding(5) var<storage, read> lamps: array<lamp::Lamp>;
/// Gauss–Legendre abscissae and weights on [0, 1] of 32, 64, 128, 256 and 512 nodes, one after the
/// other.
@group(0) @binding(6) var<storage, read> rules: array<vec2<f32>>;
/// For every lamp of this dispatch and every tile, eight words of pixels that are left.
@group(0) @binding(7) var<storage, read> left: array<u32>;

/// Rays of a workgroup, and invocations of a ray.
const RAYS: u32 = 8u;
const LANES: u32 = 32u;
const LARGEST_RULE: u32 = 512u;
/// Relative difference of two rules that agree.
const AGREE: f32 = 1e-4;
/// Every blob of a mask.
const ALL: u32 = 0xffffffffu;

@compute @workgroup_size(256)
fn add(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) place: u32,
) {
    let own = pilot::Place(place / LANES, place % LANES, true);
    let pixel = pixel_of(group, own.ray);
    let inside = view::is_inside(frame, pixel);
    let ray = view::ray_of(frame, pixel);
    var length_m = 0.0;
    if inside {
        length_m = textureLoad(hits, view::pixel_of(frame, pixel), 0).w;
    }
    let rays = bundle_of(group, tile::largest(place, vec4<f32>(length_m)).x);
    let fog = fog_along(place, own, ray, length_m);
    let dense = vec2<f32>(fog.begin, fog.end);
    let piece = piece_of(place, own, rays, ray, fog, length_m);

    var airlight = vec3<f32>(0.0);
    for (var i = part.range.x; i < part.range.y; i++) {
        let tile_of_lamp = (i - part.range.x) * groups.x * groups.y + group.y * groups.x + group.x;
        let waiting = (left[tile_of_lamp * 8u + group.z / 4u] >> (8u * (group.z % 4u))) & 0xffu;
        if waiting == 0u {
            continue;
        }
        let mine = inside && piece.x < piece.y && ((waiting >> own.ray) & 1u) == 1u;
        let light = lamps[i];
        let sight = sight_of(place, light.position.xyz, rays, piece, mine);
        let value = of_lamp(place, own, ray, sight, dense, length_m, mine);
        airlight += select(0.0, value, mine) * light.scattered.rgb;
    }
    if inside && own.lane == 0u {
        fogged[view::index_of(frame, pixel)] += vec4<f32>(airlight, 0.0);
    }
}

/// The pixel of one of the workgroup's rays.
fn pixel_of(group: vec3<u32>, ray: u32) -> vec2<u32> {
    let at = group.z * RAYS + ray;
    return group.xy * tile::SIDE + vec2<u32>(at % tile::SIDE, at / tile::SIDE);
}

fn bundle_of(group: vec3<u32>, longest: f32) -> bundle::Bundle {
    let low = view::sample_of(frame, pixel_of(group, 0u));
    let high = view::sample_of(frame, pixel_of(group, RAYS - 1u));
    return bundle::of_view(frame, low, high, longest);
}

/// What all blobs on the invocation's ray come to.
fn fog_along(place: u32, own: pilot::Place, ray: view::Ray, length_m: f32) -> around::Fog {
    let line = bundle::Bundle(ray.offset, ray.direction, 0.0, 0.0, length_m);
    var fog = around::nothing();
    for (var at = own.lane; at < frame.counts.z; at += LANES) {
        around::add(&fog, blobs[at], line);
    }
    let ends = tile::largest_of(place, LANES, vec4<f32>(-fog.begin, fog.end, 0.0, 0.0));
    let most = tile::total_of(place, LANES, vec4<f32>(fog.most)).x;
    return around::Fog(max(-ends.x, 0.0), min(ends.y, length_m), most, 0.0);
}

/// From where to where there is fog on the ray that is seen [m].
fn piece_of(
    place: u32,
    own: pilot::Place,
    rays: bundle::Bundle,
    ray: view::Ray,
    fog: around::Fog,
    length_m: f32,
) -> vec2<f32> {
    let beta = frame.ambient.w;
    let piece = select(vec2<f32>(fog.begin, fog.end), vec2<f32>(0.0, length_m), beta > 0.0);
    let opaque = piece.x < piece.y && fog.most + beta * piece.y > mapped::OPAQUE;
    if tile::largest(place, vec4<f32>(select(0.0, 1.0, opaque))).x == 0.0 {
        return piece;
    }
    let t = piece.x + (piece.y - piece.x) * f32(own.lane + 1u) / f32(LANES);
    let depth = view_sums(place, rays, ray, t, ALL).y + beta * t;
    let end = select(piece.y, t, opaque && depth > mapped::OPAQUE);
    return vec2<f32>(piece.x, -tile::largest_of(place, LANES, vec4<f32>(-end)).x);
}

/// The invocation's ray before a lamp; the wedge holds those of all rays that wait.
fn sight_of(
    place: u32,
    light: vec3<f32>,
    rays: bundle::Bundle,
    piece: vec2<f32>,
    mine: bool,
) -> Sight {
    let none = vec2<f32>(-1e30, 0.0);
    let own = select(none, vec2<f32>(-piece.x, piece.y), mine);
    let ends = tile::largest(place, vec4<f32>(own, none)).xy;
    let begin = max(-ends.x, 0.0);
    let between = bundle::wedge(light, rays, min(begin, ends.y), ends.y);
    // A ray that does not wait goes along on a piece of its own, without effect.
    let taken = select(vec2<f32>(0.0, 1.0), piece, mine);
    return Sight(light, rays, between, taken.x, taken.y);
}

/// Airlight along the invocation's ray per unit of ω·I: the number of nodes doubles until two rules
/// agree, and until the rule meets what the fog is known to remove of light.
fn of_lamp(
    place: u32,
    own: pilot::Place,
    ray: view::Ray,
    sight: Sight,
    dense: vec2<f32>,
    length_m: f32,
    mine: bool,
) -> f32 {
    let toward = lamp::to_light(sight.light - ray.offset, ray.direction, length_m);
    let map = map_along(place, own, ray, sight, dense, toward);
    let removed = num::absorptance(depth_at_end(place, own, ray, sight));
    var coarse = rule_sums(place, own, ray, sight, map, toward, LANES);
    var waits = mine && removed > mapped::CLEAR;
    for (var size = 2u * LANES; size <= LARGEST_RULE; size *= 2u) {
        if tile::largest(place, vec4<f32>(select(0.0, 1.0, waits))).x == 0.0 {
            break;
        }
        let fine = rule_sums(place, own, ray, sight, map, toward, size);
        let agree = abs(fine.x - coarse.x) <= AGREE * fine.x;
        let met = abs(fine.y - removed) <= mapped::UNMET * removed + mapped::NOTHING;
        coarse = select(coarse, fine, waits);
        waits = waits && !(agree && met);
    }
    return coarse.x;
}

fn map_along(
    place: u32,
    own: pilot::Place,
    ray: view::Ray,
    sight: Sight,
    dense: vec2<f32>,
    toward: lamp::ToLight,
) -> mapped::Map {
    let whole = vec2<f32>(sight.begin, sight.end);
    let around_fog = select(whole, dense, dense.x < dense.y);
    let probe = pilot::probe(own, sight.begin, sight.end, around_fog, toward);
    let at = fields_at(place, ray, sight, probe.at);
    let g = frame.optics.x;
    let deserves = mapped::weight_of(g, toward, probe.at - toward.closest, at);
    let lumps = pilot::lumps(own, probe, deserves);
    return mapped::map_of(g, sight.begin, sight.end, toward, lumps.low, lumps.high);
}

/// T along a ray to the end of the piece, its blobs shared by the ray's invocations.
fn depth_at_end(place: u32, own: pilot::Place, ray: view::Ray, sight: Sight) -> f32 {
    let share = view_sums(place, sight.rays, ray, sight.end, 1u << own.lane).y;
    let sum = tile::total_of(place, LANES, vec4<f32>(share)).x;
    return sum + frame.ambient.w * sight.end;
}

/// What a rule makes of a ray: its airlight, and ∫ β e^(−T) dt.
fn rule_sums(
    place: u32,
    own: pilot::Place,
    ray: view::Ray,
    sight: Sight,
    map: mapped::Map,
    toward: lamp::ToLight,
    size: u32,
) -> vec2<f32> {
    var sums = vec2<f32>(0.0);
    for (var first = 0u; first < size; first += LANES) {
        let rule = rules[size - LANES + first + own.lane];
        let solved = mapped::solve(map, rule.x);
        let at = fields_at(place, ray, sight, solved.x);
        let log_seen = at.log_seen + num::log_bounded(rule.y / solved.y);
        let aside = solved.x - toward.closest;
        sums += vec2<f32>(
            mapped::scattered(frame.optics.x, toward, aside, log_seen, at.mean),
            num::exp_bounded(log_seen),
        );
    }
    return tile::total_of(place, LANES, vec4<f32>(sums, 0.0, 0.0)).xy;
}

/// Fields at a place of the invocation's ray.
fn fields_at(place: u32, ray: view::Ray, sight: Sight, t: f32) -> mapped::Fields {
    let along = view_sums(place, sight.rays, ray, t, ALL);
    let point = ray.offset + t * ray.direction;
    let sums = vec3<f32>(along, light_sum(place, sight, point));
    return mapped::fields(sums, frame.ambient.w, t, distance(point, sight.light));
}

/// β and T from the eye at a place of a ray, over the blobs of a mask.
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
fn light_sum(place: u32, sight: Sight, point: vec3<f32>) -> f32 {
    let way = gaussians::way_between(point, sight.light);
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
            var bits = tile::kept(word);
            while bits != 0u {
                let blob = blobs[first + word * 32u + firstTrailingBit(bits)];
                bits &= bits - 1u;
                sum += gaussians::depth_on(way, blob);
            }
        }
    }
    return sum;
}
