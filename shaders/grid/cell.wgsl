// A square of the picture: the eight rays that stand for it, and what lies between them.
//
// The rays run through the corners of the square and the middles of its sides. Their shape functions span
// 1, x, y, x², xy, y², x²y, xy².
//
// Twin: core/src/cpu/grid/cells.rs.

#define_import_path fogbank::grid::cell

#import fogbank::view::{View, Ray, ray_through, picture_place, is_parallel}
#import fogbank::lamp::{Lamp, is_sun}

/// A square of the picture.
struct Cell {
    /// Its middle, and half its side [px].
    middle: vec2<f32>,
    half: f32,
}

/// Rays that stand for a cell.
const RAYS: u32 = 8u;

/// Where they run in the square [−1, 1]².
const PLACES: array<vec2<f32>, 8> = array<vec2<f32>, 8>(
    vec2<f32>(-1.0, -1.0),
    vec2<f32>(1.0, -1.0),
    vec2<f32>(-1.0, 1.0),
    vec2<f32>(1.0, 1.0),
    vec2<f32>(0.0, -1.0),
    vec2<f32>(0.0, 1.0),
    vec2<f32>(-1.0, 0.0),
    vec2<f32>(1.0, 0.0),
);

/// Where the ninth ray is, by which a cell is checked: cubics, which quadratics miss, vanish in its middle.
const CHECK: vec2<f32> = vec2<f32>(0.58, 0.42);

/// How much each of the eight rays counts at a place: corners, then sides.
struct Shares {
    corners: vec4<f32>,
    sides: vec4<f32>,
}

fn shares(at: vec2<f32>) -> Shares {
    let x = at.x * vec4<f32>(-1.0, 1.0, -1.0, 1.0);
    let y = at.y * vec4<f32>(-1.0, -1.0, 1.0, 1.0);
    let corners = 0.25 * (1.0 + x) * (1.0 + y) * (x + y - 1.0);
    let square = 1.0 - at * at;
    let sides = 0.5 * vec4<f32>(
        square.x * (1.0 - at.y),
        square.x * (1.0 + at.y),
        square.y * (1.0 - at.x),
        square.y * (1.0 + at.x),
    );
    return Shares(corners, sides);
}

/// The view ray through a place of the square [−1, 1]².
fn ray_at(view: View, cell: Cell, place: vec2<f32>) -> Ray {
    return ray_through(view, cell.middle + cell.half * place);
}

/// Whether its rays spread more than that [rad].
fn is_wide(view: View, cell: Cell, widest: f32) -> bool {
    let middle = ray_at(view, cell, vec2<f32>(0.0)).direction;
    return distance(middle, ray_at(view, cell, vec2<f32>(1.0)).direction) > widest;
}

/// Whether a lamp's image is so close that its glow varies too much across it.
fn is_near(view: View, cell: Cell, light: Lamp, nearest: f32) -> bool {
    let at = picture_place(view, light.position);
    if is_sun(light) || at.z <= 0.0 {
        return false;
    }
    return 2.0 * cell.half * nearest > distance(cell.middle, image_of(view, at));
}

/// Where a point in front of the camera appears [px].
fn image_of(view: View, at: vec3<f32>) -> vec2<f32> {
    let depth = select(at.z, 1.0, is_parallel(view));
    return (vec2<f32>(at.x, -at.y) / depth + 1.0) * 0.5 * view.size;
}
