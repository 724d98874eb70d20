//! What the tests share.

pub mod camera;
pub mod cases;
pub mod decode;
pub mod errors;
pub mod extremes;
pub mod fields;
pub mod http;
pub mod mutation;
pub mod quadrature;
pub mod scenes;
pub mod server;
pub mod trials;
