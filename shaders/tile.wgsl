// What the 256 invocations of a tile of 16×16 pixels do together. Every function but `keep` and
// `kept` is to be called by all of them.
//
// Twin: TILE and SIZE in core/src/cpu/batch.rs.

#define_import_path fogbank::tile

/// Pixels along the side of a tile.
const SIDE: u32 = 16u;
/// Pixels of a tile, and invocations of its workgroup.
const SIZE: u32 = 256u;
/// Blobs that are looked at in one go: each invocation tells of four whether they matter.
const CHUNK: u32 = 1024u;
/// Words of a mask of a chunk's blobs.
const WORDS: u32 = 32u;

var<workgroup> row: array<vec4<f32>, SIZE>;
/// Which blobs of a chunk matter. A mask, not a list: its order does not depend on who is first, so
/// sums over it are the same in every run.
var<workgroup> mask: array<atomic<u32>, WORDS>;

/// The largest of every component over aligned groups of `size` invocations, a power of two.
fn largest_of(place: u32, size: u32, value: vec4<f32>) -> vec4<f32> {
    row[place] = value;
    workgroupBarrier();
    for (var half = size / 2u; half > 0u; half /= 2u) {
        if place % size < half {
            row[place] = max(row[place], row[place + half]);
        }
        workgroupBarrier();
    }
    let result = row[place - place % size];
    workgroupBarrier();
    return result;
}

/// The sum of every component, likewise.
fn total_of(place: u32, size: u32, value: vec4<f32>) -> vec4<f32> {
    row[place] = value;
    workgroupBarrier();
    for (var half = size / 2u; half > 0u; half /= 2u) {
        if place % size < half {
            row[place] += row[place + half];
        }
        workgroupBarrier();
    }
    let result = row[place - place % size];
    workgroupBarrier();
    return result;
}

/// The largest of every component over all invocations.
fn largest(place: u32, value: vec4<f32>) -> vec4<f32> {
    row[place] = largest_of(place, SIZE, value);
    return workgroupUniformLoad(&row[0]);
}

/// The sum of every component over all invocations.
fn total(place: u32, value: vec4<f32>) -> vec4<f32> {
    row[place] = total_of(place, SIZE, value);
    return workgroupUniformLoad(&row[0]);
}

/// Empties the mask, before `keep`.
fn clear(place: u32) {
    workgroupBarrier();
    if place < WORDS {
        atomicStore(&mask[place], 0u);
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
