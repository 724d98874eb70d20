//! What the tests share.

pub mod camera;
pub mod cases;
pub mod decode;
pub mod errors;
pub mod everyday;
pub mod http;
pub mod licences;
pub mod mutation;
pub mod quadrature;
pub mod server;

pub mod scenes;
pub mod trials;

use serde_json::Value;
use std::path::PathBuf;

/// A file of the exact cases that may lie beside the project, or `None` with a word about it.
pub fn truth(name: &str) -> Option<Value> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/truth").join(name);
    match std::fs::read(&path) {
        Ok(bytes) => Some(serde_json::from_slice(&bytes).unwrap_or_else(|e| panic!("{name}: {e}"))),
        Err(error) => {
            eprintln!("{name} is absent ({error}): its cases are not compared");
            None
        }
    }
}
