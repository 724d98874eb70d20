// Where the nodes of a rule are placed on a ray: 32 invocations look at the medium along it, a
// probe each, and agree on two lumps of fog. Eight rays stand side by side, or one, for which eight
// invocations do the same and the first of them, the leader, writes.
//
// Every function is to be called by all invocations of the workgroup.
//
// Twins: core/src/cpu/mapped/pilot.rs, Probes and group in core/src/airlight/mapped.rs.

#define_import_path fogbank::mapped::pilot

#import fogbank::lamp
#import fogbank::airlight::mapped

/// Which ray an invocation works for, which probe of it is its own, and whether it writes.
struct Place {
    ray: u32,
    lane: u32,
    leads: bool,
}

/// A probe: its ray parameter and the length of its part [m].
struct Probe {
    at: f32,
    width: f32,
}

struct Lumps {
    low: mapped::Lump,
    high: mapped::Lump,
}

const ENDS: u32 = 33u;

var<workgroup> unsorted: array<f32, 264>;
var<workgroup> sorted: array<f32, 264>;
/// xyz: mass, mean and variance of what a probe sees.
var<workgroup> cells: array<vec4<f32>, 256>;
/// What remains within two lumps, by where they are told apart.
var<workgroup> within: array<f32, 256>;

/// The invocation's probe on a piece of its ray.
fn probe(
    place: Place,
    begin: f32,
    end: f32,
    dense: vec2<f32>,
    light: lamp::ToLight,
) -> Probe {
    let base = place.ray * ENDS;
    if place.leads {
        for (var i = place.lane; i < ENDS; i += 32u) {
            unsorted[base + i] = mapped::probe_end(i, begin, end, dense, light);
        }
    }
    workgroupBarrier();
    if place.leads {
        for (var i = place.lane; i < ENDS; i += 32u) {
            sorted[base + rank(base, i)] = unsorted[base + i];
        }
    }
    workgroupBarrier();
    let low = sorted[base + place.lane];
    let high = sorted[base + place.lane + 1u];
    return Probe(0.5 * (low + high), high - low);
}

/// How many ends stand before one.
fn rank(base: u32, i: u32) -> u32 {
    let own = unsorted[base + i];
    var before = 0u;
    for (var k = 0u; k < ENDS; k++) {
        let other = unsorted[base + k];
        before += u32(other < own || (other == own && k < i));
    }
    return before;
}

/// The two neighbouring groups of probes with the least variance within, one of which may be empty,
/// given how much of the nodes each probe deserves.
fn lumps(place: Place, own: Probe, deserves: f32) -> Lumps {
    let base = place.ray * 32u;
    if place.leads {
        let variance = own.width * own.width / 6.0;
        cells[base + place.lane] = vec4<f32>(deserves * own.width, own.at, variance, 0.0);
    }
    workgroupBarrier();
    if place.leads {
        let apart = told_apart(base, place.lane);
        within[base + place.lane] =
            apart.low.mass * apart.low.variance + apart.high.mass * apart.high.variance;
    }
    workgroupBarrier();
    var best = 0u;
    for (var i = 1u; i < 32u; i++) {
        if within[base + i] < within[base + best] {
            best = i;
        }
    }
    return told_apart(base, best);
}

/// The probes before one as a lump, and the others.
fn told_apart(base: u32, first: u32) -> Lumps {
    var low = mapped::no_lump();
    var high = mapped::no_lump();
    for (var i = 0u; i < 32u; i++) {
        let cell = cells[base + i].xyz;
        let lump = mapped::Lump(cell.x, cell.y, cell.z);
        if i < first {
            low = mapped::join(low, lump);
        } else {
            high = mapped::join(high, lump);
        }
    }
    return Lumps(low, high);
}
