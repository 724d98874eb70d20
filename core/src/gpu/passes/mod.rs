//! The passes of a frame, as a recorder records them.

mod fog;
mod grid;
mod light;
mod picture;
mod surfaces;

#[cfg(test)]
pub use grid::BLOCK_BYTES;
