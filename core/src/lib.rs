//! Fogbank's fog models, passes and pictures. No HTTP here.

pub mod airlight;
pub mod compare;
pub mod cpu;
pub mod edit;
pub mod frame;
pub mod geometry;
pub mod gpu;
pub mod image;
pub mod json;
mod kept;
pub mod light;
pub mod light_map;
pub mod media;
pub mod num;
pub mod options;
pub mod phase;
pub mod presets;
pub mod probe;
mod progress;
mod quadrature;
mod random;
pub mod renderer;
pub mod request;
mod rounding;
pub mod scene;
pub mod selftest;
pub mod shapes;
pub mod shared;
pub mod sky;
pub mod surface;
pub mod vector;

pub use frame::Frame;
pub use progress::{Interrupted, Progress};
pub use renderer::{Backend, Renderer};
