//! Light that reaches a surface through the fog and is sent back to the eye.

pub mod attenuated;
