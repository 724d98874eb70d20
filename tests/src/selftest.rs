//! What the program's self-test may find.

use serde_json::Value;

/// How far a model may be from the maths in f64: f32's rounding and the rules of pictures; where fog changes faster than
/// the knots of a grid are apart, what pictures are held to.
pub fn allowed(entry: &Value) -> f64 {
    // What changes faster than a grid's knots are apart: fog, and light between cones and shadows.
    let is_rippled =
        ["functions", "fogmap", "spot", "shadows"].iter().any(|model| entry["model"] == *model);
    // Three to six bands of a sky that has a kink at the horizon.
    let is_blurred = entry["model"] == "sky";
    if is_blurred || is_rippled && entry["layer"] == "airlight" { 3e-2 } else { 1e-3 }
}
