// What the 256 invocations of a tile of 16×16 pixels do together. Every function but `keep` and
// `kept` is to be called by all of them.
//
// Twin: TILE and SIZE in core/src/cpu/batch.rs.

#define_import_path fogbank::tile

#import fogbank::view::{View, sample_of}
#import fogbank::bundle::{Bundle, of_view}

/// Pixels along the side of a tile.
const SIDE: u32 = 16u;
/// Pixels of a tile, and invocations of its workgroup.
const SIZE: u32 = 256u;
/// Blobs that are looked at in one go.
const CHUNK: u32 = 65536u;
/// Words of a mask of a chunk's blobs.
const WORDS: u32 = 2048u;

/// Values of all invocations are compared in two steps of sixteen: few barriers, and the
/// same order in every run.
const STEP: u32 = 16u;

var<workgroup> row: array<vec4<f32>, SIZE>;
var<workgroup> column: array<vec4<f32>, STEP>;
/// Which blobs of a chunk matter. A mask, not a list: its order does not depend on who is first, so
/// sums over it are the same in every run.
var<workgroup> mask: array<atomic<u32>, WORDS>;

/// The largest of every component over all invocations.
fn largest(place: u32, value: vec4<f32>) -> vec4<f32> {
    row[place] = value;
    workgroupBarrier();
    if place < STEP {
        var most = row[place * STEP];
        for (var i = 1u; i < STEP; i++) {
            most = max(most, row[place * STEP + i]);
        }
        column[place] = most;
    }
    workgroupBarrier();
    var most = column[0];
    for (var i = 1u; i < STEP; i++) {
        most = max(most, column[i]);
    }
    return most;
}

/// The view rays of a tile, no longer than `longest`.
fn bundle(frame: View, place: vec2<u32>, longest: f32) -> Bundle {
    let first = place * SIDE;
    return of_view(frame, sample_of(frame, first), sample_of(frame, first + SIDE - 1u), longest);
}

/// Empties the mask, before `keep`.
fn clear(place: u32) {
    workgroupBarrier();
    for (var word = place; word < WORDS; word += SIZE) {
        atomicStore(&mask[word], 0u);
    }
    workgroupBarrier();
}

/// Marks a blob of the chunk, by its place in it.
fn keep(blob: u32) {
    atomicOr(&mask[blob / 32u], 1u << (blob % 32u));
}

/// A word of the mask, after a barrier that follows all `keep`.
fn kept(word: u32) -> u32 {
    return atomicLoad(&mask[word]);
}

/// Words of the mask that a chunk of `blobs` or fewer fills.
fn words(blobs: u32) -> u32 {
    return min((blobs + 31u) / 32u, WORDS);
}
