// Fog that is the same everywhere: β(x) = β₀, T(a, b) = β₀ |a − b| (Sun 2005, eq. 3).
//
// Twin: core/src/media/homogeneous.rs.

#define_import_path fogbank::media::homogeneous

/// T along a path of that length [m] in fog of extinction `beta` [1/m].
fn optical_depth(beta: f32, length_m: f32) -> f32 {
    return beta * length_m;
}
