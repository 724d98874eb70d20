//! The passes of a frame, as a recorder records them.

mod fog;
mod grid;
mod light;
mod picture;
mod surfaces;

#[cfg(test)]
pub use grid::BLOCK_BYTES;

/// A triangle that covers the whole picture.
const COVER: (u32, u32) = (3, 1);
