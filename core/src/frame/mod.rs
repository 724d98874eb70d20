//! A frame, whichever backend makes it: what goes into it, what is kept from one to the next, and what
//! comes out.

pub mod cache;
pub mod context;
pub mod light_table;
pub mod lights;
pub mod samples;
pub mod shafts;
pub mod skies;
pub mod sky_table;
pub mod tolerance;
pub mod viewpoint;

use crate::request::Layer;
use crate::scene::Camera;
use std::time::Duration;

/// What a pass took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lap {
    /// Its name.
    pub pass: &'static str,
    /// The time.
    pub took: Duration,
    /// Whether its output was kept from an earlier frame.
    pub is_reused: bool,
}

impl Lap {
    /// Of a pass that ran.
    pub fn new(pass: &'static str, took: Duration) -> Self {
        Self { pass, took, is_reused: false }
    }
}

/// A finished image: linear radiance, optical depths or distances, before any encoding.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Pixels along a row.
    pub width: usize,
    /// Rows of pixels.
    pub height: usize,
    /// Numbers a pixel has.
    pub channels: usize,
    /// What the numbers are.
    pub layer: Layer,
    /// Where it is seen from.
    pub camera: Camera,
    /// `[height][width][channels]`, top row first; empty if the frame is `shown`.
    pub pixels: Vec<f32>,
    /// What a screen shows, `[height][width][3]` in sRGB, where the backend has formed that.
    pub shown: Option<Vec<u8>>,
    /// What each pass took, in order.
    pub timings: Vec<Lap>,
    /// Where it was made: `cpu` or `gpu`.
    pub backend: &'static str,
}
