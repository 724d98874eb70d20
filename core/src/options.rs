//! What a frame may lose for speed, and how much that is.

use crate::json::{Checker, limits};
use schemars::JsonSchema;
use serde::Deserialize;

/// What a frame may lose for speed; nothing if nothing is said.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Options {
    /// Relative error that the mean optical depth of the picture may have: of many blobs far away some are left out,
    /// and the rest weighs more (stochastic pruning). 0 leaves none out.
    #[schemars(range(min = limits::LOD_ERROR.min, max = limits::LOD_ERROR.max))]
    pub lod_error: f64,
    /// Transmittance below which a ray ends: what lies behind is not seen (Biri 2002, section 4.2), so of its light
    /// that share is lost at most. 0 cuts nothing off.
    #[schemars(range(min = limits::FAR_CUT.min, max = limits::FAR_CUT.max))]
    pub far_cut: f64,
    /// Fog is computed for a grid of this fraction of the picture, halved from one to a sixteenth, and carried over
    /// between pixels that lie at a like depth (Biri 2002, section 4.1). Edges of depth have their own fog, and so has at rest
    /// what lies between pixels that differ; `auto` of
    /// 8-bit pictures stands on a grid anyway.
    #[schemars(range(min = limits::FOG_SCALE.min, max = limits::FOG_SCALE.max))]
    pub fog_scale: f64,
    /// What meshes lose of their light is computed at their corners and interpolated across triangles (Biri 2002,
    /// section 4.3), where these are dense enough; for pictures without airlight. It pays where fog is dear: many
    /// blobs, or a map of many cells.
    pub per_vertex: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self { lod_error: 0.0, far_cut: 0.0, fog_scale: 1.0, per_vertex: false }
    }
}

impl Options {
    /// Optical depth behind which nothing is seen.
    pub fn opaque(&self) -> f32 {
        if self.far_cut > 0.0 { -self.far_cut.ln() as f32 } else { f32::MAX }
    }

    /// Looks at all of its numbers.
    pub fn check(&self, check: &mut Checker) {
        check.number(self.lod_error, limits::LOD_ERROR, || "/options/lod_error".into());
        check.number(self.far_cut, limits::FAR_CUT, || "/options/far_cut".into());
        check.number(self.fog_scale, limits::FOG_SCALE, || "/options/fog_scale".into());
    }
}

/// By how much an option's pictures are off.
#[derive(Clone, Copy, Debug)]
pub struct Loss {
    /// The option.
    pub name: &'static str,
    /// Where it was published.
    pub source: &'static str,
    /// What is known of it.
    pub bound: &'static str,
    /// As measured: at some of its values, by how much the transmittance of pixels of the presets is off at most of
    /// half of them, of 95 per cent, and of all.
    pub measured: &'static [(f64, [f64; 3])],
}

/// Of every option. `cargo run -p fogbank-tests --example errors` measures and prints the numbers, and the tests measure
/// them again.
pub const LOSSES: [Loss; 4] = [
    Loss {
        name: "lod_error",
        source: "Macklin 2010, after Cook, Halstead, Planck, Ryu 2007 (stochastic pruning).",
        bound: "The mean optical depth of a picture is off by no more than this share of it, at three standard deviations.",
        measured: &[],
    },
    Loss {
        name: "far_cut",
        source: "Biri, Michelin 2002, section 4.2.",
        bound: "Of the light that surfaces send no more than this share is lost, and nothing of pixels that show more.",
        measured: &[],
    },
    Loss {
        name: "fog_scale",
        source: "Biri, Michelin 2002, section 4.1.",
        bound: "What is narrower than the pixels between may be missed.",
        measured: &[
            (0.5, [7.7e-6, 2.6e-3, 0.39]),
            (0.25, [1.5e-4, 7.1e-3, 0.4]),
            (0.125, [2.7e-4, 1.4e-2, 0.82]),
            (0.0625, [6.1e-6, 2.2e-2, 0.9]),
        ],
    },
    Loss {
        name: "per_vertex",
        source: "Biri, Michelin 2002, section 4.3.",
        bound: "No triangle is interpolated over whose corners the transmittance differs by more than 0.06, or that is \
            seen larger than a 24th of the picture's height.",
        measured: &[(1.0, [0.0, 1.5e-4, 8.4e-2])],
    },
];
