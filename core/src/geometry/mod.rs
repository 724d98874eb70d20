//! Rays and what bounds them: single ones in f64, batches and bundles of them for pictures. Nothing
//! here knows what they meet.

pub mod batch;
pub mod bundle;
pub mod cone;
pub mod control;
pub mod hierarchy;
mod origin;
pub mod parts;
pub mod ray;

pub use origin::{Beyond, Origin};
pub use ray::Ray;
