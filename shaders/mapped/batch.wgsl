// 32 nodes of a rule with their fields on the eight rays of a patch, as all invocations of its
// workgroup see them.
//
// Twin: Head in core/src/cpu/mapped/pixels.rs.

#define_import_path fogbank::mapped::batch

#import fogbank::lamp
#import fogbank::airlight::mapped
#import fogbank::mapped::pixels

/// x: the node's place on its section, as a share. y: logarithm of its weight on the ray through the
/// patch's middle [m].
var<workgroup> nodes: array<vec2<f32>, 32>;
/// Fields of a batch: eight rays a node. Logarithms include the nodes' weights.
var<workgroup> logs: array<f32, 256>;
var<workgroup> means: array<f32, 256>;
/// Each node's largest logarithm: quadratics may overshoot.
var<workgroup> node_most: array<f32, 32>;

/// Sets the fields of the invocation's node and ray; to be called by all.
fn fill(place: u32, log_seen: f32, mean: f32) {
    logs[place] = log_seen;
    means[place] = mean;
    workgroupBarrier();
    if place < 32u {
        node_most[place] = most_of(place);
    }
    workgroupBarrier();
}

/// The largest of eight rays' logarithms, and room for what lies between them.
fn most_of(node: u32) -> f32 {
    var most = logs[node * pixels::CONTROL];
    for (var c = 1u; c < pixels::CONTROL; c++) {
        most = max(most, logs[node * pixels::CONTROL + c]);
    }
    return most + 0.5;
}

/// A node of the batch at one place of the patch, whose ray has the section from `chart.x` on, a share of
/// 1 being `chart.y` long [m].
fn airlight(
    node: u32,
    g: f32,
    share: pixels::Shares,
    toward: lamp::ToLight,
    chart: vec2<f32>,
) -> f32 {
    let log_seen = min(log_between(node, share), node_most[node]);
    let aside = chart.x + chart.y * nodes[node].x - toward.closest;
    return mapped::scattered(g, toward, aside, log_seen, mean_between(node, share));
}

fn log_between(node: u32, share: pixels::Shares) -> f32 {
    let at = node * pixels::CONTROL;
    let corners = vec4<f32>(logs[at], logs[at + 1u], logs[at + 2u], logs[at + 3u]);
    let sides = vec4<f32>(logs[at + 4u], logs[at + 5u], logs[at + 6u], logs[at + 7u]);
    return pixels::between(share, corners, sides);
}

fn mean_between(node: u32, share: pixels::Shares) -> f32 {
    let at = node * pixels::CONTROL;
    let corners = vec4<f32>(means[at], means[at + 1u], means[at + 2u], means[at + 3u]);
    let sides = vec4<f32>(means[at + 4u], means[at + 5u], means[at + 6u], means[at + 7u]);
    return pixels::between(share, corners, sides);
}
