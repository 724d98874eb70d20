//! Where the ways of a light to anywhere begin.

use glam::DVec3;

/// A place, or all that lies in a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Origin {
    /// A place [m].
    At(DVec3),
    /// Beyond everything.
    Beyond(Beyond),
}

/// Ways that come from beyond everything, side by side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beyond {
    /// Unit vector towards where they come from.
    pub toward: DVec3,
    /// Fog that has no end in that direction counts so far [m].
    pub path_m: f64,
}
