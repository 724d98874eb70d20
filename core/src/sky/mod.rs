//! The sky: light that comes from all around and from beyond everything.
//!
//! A sky is summed up as parts, each of which is a small sun: what is left of it at a place x, of what goes on towards
//! an eye in the direction −d, is
//!
//! ```text
//! J(x, d) = ∫ L(ω) p(ω·d) e^(−T(x, ω)) dω = 1/(4π) Σ wᵢ e^(−T(x, ωᵢ)).
//! ```
//!
//! So wherever airlight asks for T towards a lamp, −ln(Σ wᵢ e^(−Tᵢ) / Σ wᵢ) stands for it, and the sky is a sun of the
//! irradiance Σ wᵢ that shines the same whichever way one looks. Surfaces do not hide it from fog: what comes from
//! below is the sky's own ground.

pub mod harmonics;
mod map;
mod parts;
pub mod psf;
mod radiance;
mod ways;

pub use map::RadianceMap;
pub use parts::{Fineness, Part, around};
pub use radiance::{GradientSky, HarmonicSky, ImageSky, Radiance, UniformSky};
pub(crate) use ways::SkyWays;
