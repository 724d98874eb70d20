//! What the mapped airlight of a picture may miss.

use crate::media::Field;
use crate::request::{Quality, View};

/// What a patch may miss.
#[derive(Clone, Copy, Debug)]
pub struct Tolerance {
    /// A patch is at most this share of its distance from a light's image.
    pub near: f32,
    /// Share of the fog, in optical depth, that quadratics may miss of blobs that stand between the
    /// rays looked at.
    pub hidden: f32,
    /// Half a patch's diagonal is at most this [rad].
    pub wide: f32,
    /// Relative error of the airlight at the place where it is checked.
    pub rough: f64,
    /// Relative error of a rule, as its own terms tell it.
    pub agree: f64,
    /// Share that a rule may miss of the light that fog removes, which is known.
    pub unmet: f64,
    /// Rays of a layer end within this share of each other's way through the fog.
    pub layer: f32,
    /// A larger patch of more layers than this is split.
    pub layers: usize,
}

/// A layer of rays' ends is at least this share of the lumps' extent.
pub const THIN: f32 = 0.02;

/// Up to so many lumps, each casts a shadow of its own along a ray: its edges are sharper than what a
/// rule's terms can tell, so the rule must be this many times better. The shadows of more lie over
/// each other.
const FEW: usize = 16;
const SHARP: f64 = 8.0;

/// The closest agreement that f32 can show.
const CLOSEST: f64 = 3e-4;

impl Tolerance {
    /// Of a frame of a fog of so many lumps.
    pub fn new(view: &View, lumps: usize) -> Self {
        let usual = Self::of(view);
        let few = lumps <= FEW;
        let agree = if few { (usual.agree / SHARP).max(CLOSEST) } else { usual.agree };
        Self { agree, ..usual }
    }

    /// Of a picture whose numbers are wanted, of one for the eye, or of one in motion.
    fn of(view: &View) -> Self {
        match view.quality {
            Quality::Full if !view.for_screen => Self {
                near: 0.45,
                hidden: 3e-3,
                wide: 0.06,
                rough: 5e-4,
                agree: 3e-4,
                unmet: 5e-4,
                layer: 0.15,
                layers: 3,
            },
            Quality::Full => Self {
                near: 0.7,
                hidden: 1.5e-2,
                wide: 0.1,
                rough: 4e-3,
                agree: 4e-3,
                unmet: 3e-3,
                layer: 0.25,
                layers: 4,
            },
            Quality::Draft => Self {
                near: 1.0,
                hidden: 0.4,
                wide: 0.2,
                rough: 0.05,
                agree: 0.1,
                unmet: 0.1,
                layer: 0.5,
                layers: 8,
            },
        }
    }
}

/// How fine a grid of cumulative airlight is.
#[derive(Clone, Copy, Debug)]
pub struct Fineness {
    /// The side of its largest cells [px].
    pub side: f32,
    /// A cell's side is at most its distance from a light's image, divided by this.
    pub near: f32,
    /// And there it is at most this [px].
    pub glow: f32,
    /// Knots along depth.
    pub knots: usize,
    /// Relative error that the ray in a cell's middle may show.
    pub rough: f32,
    /// Share of the fog, in optical depth, that may hide between the rays.
    pub hidden: f32,
    /// Half a cell's diagonal is at most this [rad].
    pub wide: f32,
    /// Optical depth that is as good as nothing.
    pub unseen: f32,
}

/// Where there is less than this share of the heaviest lump, or of an optical depth of 1, the air is as good
/// as clear.
const UNSEEN: f64 = 1e-3;

impl Fineness {
    /// Of a picture whose numbers are wanted, of one for the eye, or of one in motion, of some fog.
    pub fn of(view: &View, field: &Field) -> Self {
        /// Cells along the shorter side of the picture, at least: one of a few pixels sees as much in each as
        /// others do. One in haste sees a little more in each.
        const ALONG: f32 = 12.0;
        const ALONG_IN_HASTE: f32 = 9.0;
        let unseen = (UNSEEN * field.heaviest().min(1.0)) as f32;
        let usual = if view.quality == Quality::Draft && view.is_hasty {
            // Two thirds of the work of a draft; errors are a fifth to twice as large as its own.
            Self {
                side: 32.0,
                near: 1.5,
                glow: 4.0,
                knots: 16,
                rough: 0.1,
                hidden: 0.4,
                wide: 0.2,
                unseen,
            }
        } else if view.quality == Quality::Draft {
            Self {
                side: 32.0,
                near: 1.5,
                glow: 4.0,
                knots: 24,
                rough: 0.05,
                hidden: 0.4,
                wide: 0.2,
                unseen,
            }
        } else if !view.for_screen {
            Self {
                side: 8.0,
                near: 4.0,
                glow: 4.0,
                knots: 96,
                rough: 5e-4,
                hidden: 3e-3,
                wide: 0.06,
                unseen,
            }
        } else {
            Self {
                side: 16.0,
                near: 2.5,
                glow: 8.0,
                knots: 48,
                rough: 0.004,
                hidden: 0.015,
                wide: 0.1,
                unseen,
            }
        };
        let along = if view.is_hasty { ALONG_IN_HASTE } else { ALONG };
        let most = view.width.min(view.height) as f32 / along;
        let mut side = usual.side;
        while side > most.max(2.0) {
            side *= 0.5;
        }
        Self { side, ..usual }
    }
}
