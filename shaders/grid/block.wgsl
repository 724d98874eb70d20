// Where the rays of a block of the picture are tabulated along depth.
//
// Edges of the fog cut every ray into sections, each from edge to edge as that ray passes them; a ray that
// passes fewer has empty ones. A knot belongs to a section: it stands at the same distance on all rays of a cell,
// but for those whose section begins later or ends sooner, where it stands at that end.
//
// Twin: core/src/cpu/grid/knots.rs.

#define_import_path fogbank::grid::block

#import fogbank::view
#import fogbank::haze

/// How fine the grid is.
struct Fineness {
    /// A cell's side is at most its distance from a light's image, divided by this.
    near: f32,
    /// And there it is at most this [px].
    glow: f32,
    /// Share of the fog, in optical depth, that may hide between the rays.
    hidden: f32,
    /// Half a cell's diagonal is at most this [rad].
    wide: f32,
    /// Relative error that the ninth ray may show.
    rough: f32,
    /// Optical depth that is as good as nothing.
    unseen: f32,
    /// Knots along depth.
    knots: u32,
    /// Groups of terms that scatter in ways of their own.
    groups: u32,
}

/// The knots of a block.
struct Block {
    /// From where to where there is fog [m].
    ends: vec2<f32>,
    /// How many knots there are; none where there is no fog.
    count: u32,
    /// The first knot behind all blobs and lamps; it stands where the one before does.
    behind: u32,
    /// Where they stand if no edge cuts the rays [m].
    at: array<f32, 56>,
}

/// Pixels along the side of a block.
const SIDE: u32 = 64u;
/// Most edges that are followed, and one more section than that, as bounds.
const EDGES: u32 = 6u;
const BOUNDS: u32 = 8u;
/// Optical depth behind which nothing is seen: e⁻²⁴.
const OPAQUE: f32 = 24.0;
/// A section's first and last knot stand this share of their distance within it: at the edge itself β
/// has two values.
const WITHIN: f32 = 1e-5;
/// Farther than anything [m].
const FAR: f32 = 1e30;
/// An edge of the fog no farther than this share before a ray's end is its end: where fog lies on a floor.
const ALIKE: f32 = 1e-4;

/// Words of a mask of so many blobs.
fn words(blobs: u32) -> u32 {
    return (blobs + 31u) / 32u;
}

/// Where a ray passes edges, ascending [m].
struct Passed {
    at: array<f32, 6>,
    count: u32,
}

/// Where a ray passes edges of the fog between two ray parameters.
fn passed(ray: view::Ray, ends: vec2<f32>) -> Passed {
    var found: Passed;
    for (var i = 0u; i < haze::edge_count(); i++) {
        var t = haze::edge(i, ray.offset, ray.direction);
        if t > ends.x && t < ends.y {
            for (var k = 0u; k < min(found.count, EDGES); k++) {
                let other = found.at[k];
                found.at[k] = min(other, t);
                t = max(other, t);
            }
            if found.count < EDGES {
                found.at[found.count] = t;
            }
            found.count += 1u;
        }
    }
    return found;
}

/// Where the sections of a ray begin and end [m], given from where to where there is fog and how many edges
/// are followed.
fn bounds(ray: view::Ray, ends: vec2<f32>, edges: u32) -> array<f32, 8> {
    var bounds: array<f32, 8>;
    for (var i = 1u; i < BOUNDS; i++) {
        bounds[i] = ends.y;
    }
    bounds[0] = ends.x;
    if edges > 0u {
        let found = passed(ray, ends);
        for (var i = 0u; i < min(found.count, edges); i++) {
            bounds[i + 1u] = found.at[i];
        }
    }
    return bounds;
}

/// Where a knot lies on a ray whose section of it begins and ends so [m].
fn on(knot: vec2<f32>, section: vec2<f32>) -> f32 {
    return max(min(knot.y, section.y * (1.0 - WITHIN)), section.x * (1.0 + WITHIN));
}
