//! What turns one value into another, as a patch.

use super::operation::Patch;
use super::part::Part;
use super::place::Place;

/// What turns `before` into `after`.
pub fn difference<T: Part>(before: &T, after: &T) -> Patch {
    let mut patch = Vec::new();
    T::differ(before, after, &Place::Root, &mut patch);
    Patch(patch)
}
