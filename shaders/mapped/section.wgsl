// A part of the rays' way on which the fog is smooth, from an edge of the fog to the next. On every ray of a
// patch it begins and ends where that ray passes the edges, so that the same share of it lies likewise
// between them.
//
// Twin: Section in core/src/cpu/mapped/sight.rs.

#define_import_path fogbank::mapped::section

#import fogbank::view
#import fogbank::haze

/// A part of the rays' way, on which the fog is smooth.
struct Piece {
    /// Where it begins and ends at the earliest and the latest [m].
    begin: f32,
    end: f32,
    /// The edges of the fog that cut it where it begins and where it ends, if any does.
    low: u32,
    high: u32,
}

/// An edge of the fog no farther than this share behind a ray's end is its end: where fog lies on a
/// floor.
const ALIKE: f32 = 1e-4;
/// No edge at all.
const UNCUT: u32 = 0xffffffffu;

/// The edge of the fog that a ray passes next between two ray parameters.
fn next_edge(ray: view::Ray, begin: f32, end: f32) -> u32 {
    var next = UNCUT;
    var at = end;
    for (var i = 0u; i < haze::edge_count(); i++) {
        let t = haze::edge(i, ray.offset, ray.direction);
        if t > begin && t < at {
            at = t;
            next = i;
        }
    }
    return next;
}

fn is_uncut(piece: Piece) -> bool {
    return piece.low == UNCUT && piece.high == UNCUT;
}

/// Where a piece begins and ends on a ray [m].
fn place_on(piece: Piece, ray: view::Ray) -> vec2<f32> {
    var ends = vec2<f32>(piece.begin, piece.end);
    if piece.low != UNCUT {
        ends.x = clamp(haze::edge(piece.low, ray.offset, ray.direction), piece.begin, piece.end);
    }
    if piece.high != UNCUT {
        ends.y = clamp(haze::edge(piece.high, ray.offset, ray.direction), ends.x, piece.end);
    }
    return ends;
}

/// Where the share 0 of a piece is on a ray, and what a share of 1 is long there [m]. Shares of a piece
/// that no edge cuts are ray parameters.
fn chart_on(piece: Piece, ray: view::Ray) -> vec2<f32> {
    let ends = place_on(piece, ray);
    return select(vec2<f32>(ends.x, ends.y - ends.x), vec2<f32>(0.0, 1.0), is_uncut(piece));
}

/// Where the share 0 of a tail is on a ray, and what a share of 1 is long there [m]: up to the edge that
/// bounds it, and never onto that.
fn tail_chart(piece: Piece, ray: view::Ray) -> vec2<f32> {
    if piece.high == UNCUT {
        return vec2<f32>(piece.begin, piece.end - piece.begin);
    }
    let bound = haze::edge(piece.high, ray.offset, ray.direction) * (1.0 - 0.1 * ALIKE);
    let begin = min(piece.begin, bound);
    return vec2<f32>(begin, bound - begin);
}
