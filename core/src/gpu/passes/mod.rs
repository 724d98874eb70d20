//! The passes of a frame, as a recorder records them.

mod fog;
mod light;
mod mapped;
mod picture;
mod surfaces;

/// A triangle that covers the whole picture.
const COVER: (u32, u32) = (3, 1);
