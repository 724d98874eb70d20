//! A frame, whichever backend makes it: what goes into it, what is kept from one to the next, and what
//! comes out.

pub mod cache;
pub mod context;
pub mod light_table;
pub mod lights;
pub mod samples;
pub mod tolerance;
pub mod viewpoint;

use crate::request::Layer;
use crate::scene::Camera;
use std::time::Duration;

/// A finished image: linear radiance, optical depths or distances, before any encoding.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Pixels along a row.
    pub width: usize,
    /// Rows of pixels.
    pub height: usize,
    /// What the numbers are.
    pub layer: Layer,
    /// Where it is seen from.
    pub camera: Camera,
    /// `[height][width][layer.channels()]`, top row first; empty if the frame is `shown`.
    pub pixels: Vec<f32>,
    /// What a screen shows, `[height][width][3]` in sRGB, where the backend has formed that.
    pub shown: Option<Vec<u8>>,
    /// What each pass took, in order.
    pub timings: Vec<(&'static str, Duration)>,
    /// Where it was made: `cpu` or `gpu`.
    pub backend: &'static str,
}
