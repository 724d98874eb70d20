// Where the nodes of a rule are placed on a ray: a workgroup of 256 looks at the medium along it at
// 32 probes, eight invocations each, and agrees on two lumps of fog.
//
// Every function but `told_apart` is to be called by all invocations.
//
// Twins: core/src/cpu/mapped/pilot.rs, Probes and group in core/src/airlight/mapped.rs.

#define_import_path fogbank::mapped::pilot

#import fogbank::lamp
#import fogbank::airlight::mapped

/// A probe: its ray parameter [m], and as the light sees them, its place and the width of its part
/// [rad].
struct Probe {
    at: f32,
    angle: f32,
    width: f32,
}

struct Lumps {
    low: mapped::Lump,
    high: mapped::Lump,
}

const ENDS: u32 = 33u;

var<workgroup> unsorted: array<f32, 33>;
var<workgroup> sorted: array<f32, 33>;
/// xyz: mass, mean and variance of what a probe sees.
var<workgroup> cells: array<vec4<f32>, 32>;
/// What remains within two lumps, by where they are told apart.
var<workgroup> within: array<f32, 32>;

/// The invocation's probe on a piece of a ray, of which a part may hold more fog than the rest.
fn probe(place: u32, begin: f32, end: f32, dense: vec2<f32>, light: lamp::ToLight) -> Probe {
    let angle = mapped::angle_from(light, begin);
    let length_m = end - begin;
    let inner = clamp(dense - begin, vec2<f32>(0.0), vec2<f32>(length_m));
    workgroupBarrier();
    if place < ENDS {
        unsorted[place] = mapped::probe_end(place, length_m, inner, angle);
    }
    workgroupBarrier();
    if place < ENDS {
        sorted[rank(place)] = unsorted[place];
    }
    workgroupBarrier();
    let low = sorted[place / 8u];
    let high = sorted[place / 8u + 1u];
    let seen = vec2<f32>(mapped::turned(angle, low).x, mapped::turned(angle, high).x);
    let middle = 0.5 * (seen.x + seen.y);
    return Probe(begin + clamp(mapped::way_of(angle, middle), low, high), middle, seen.y - seen.x);
}

/// How many ends stand before one.
fn rank(i: u32) -> u32 {
    let own = unsorted[i];
    var before = 0u;
    for (var k = 0u; k < ENDS; k++) {
        let other = unsorted[k];
        before += u32(other < own || (other == own && k < i));
    }
    return before;
}

/// The two neighbouring groups of probes with the least variance within, one of which may be empty,
/// given how much of the nodes each probe deserves.
fn lumps(place: u32, own: Probe, deserves: f32) -> Lumps {
    if place % 8u == 0u {
        let variance = own.width * own.width / 6.0;
        cells[place / 8u] = vec4<f32>(deserves * own.width, own.angle, variance, 0.0);
    }
    workgroupBarrier();
    if place < 32u {
        let apart = told_apart(place);
        within[place] = apart.low.mass * apart.low.variance + apart.high.mass * apart.high.variance;
    }
    workgroupBarrier();
    var best = 0u;
    for (var i = 1u; i < 32u; i++) {
        if within[i] < within[best] {
            best = i;
        }
    }
    return told_apart(best);
}

/// The probes before one as a lump, and the others.
fn told_apart(first: u32) -> Lumps {
    var low = mapped::no_lump();
    var high = mapped::no_lump();
    for (var i = 0u; i < 32u; i++) {
        let cell = cells[i].xyz;
        let lump = mapped::Lump(cell.x, cell.y, cell.z);
        if i < first {
            low = mapped::join(low, lump);
        } else {
            high = mapped::join(high, lump);
        }
    }
    return Lumps(low, high);
}
