//! What the tests share.

pub mod camera;
pub mod cases;
pub mod decode;
pub mod directory;
pub mod errors;
pub mod everyday;
pub mod extremes;
pub mod fields;
pub mod http;
pub mod licences;
pub mod live;
pub mod mutation;
pub mod parted;
pub mod quadrature;
pub mod scenes;
pub mod selftest;
pub mod server;
pub mod skies;
pub mod soak;
pub mod trials;
pub mod walk;
