//! One file a route.

pub mod compare;
pub mod health;
pub mod limits;
pub mod models;
pub mod openapi;
pub mod optical_depth;
pub mod page;
pub mod presets;
pub mod probe;
pub mod progress;
pub mod render;
pub mod selftest;
