//! Light of one source scattered once into a view ray: L_a = ∫ ω β k(α) I/d² e^(−T(v,x)−T(x,s)) dt.
//!
//! Every method here answers it per unit of ω·I, as one number a light, because extinction is grey.

pub mod fogshop2007;
pub mod reference;
pub mod sun2005;

use crate::media::Field;
use crate::num::Num;
use crate::scene::{self, Fog, Term};
use crate::vector::V3;

/// An estimator that a scene's fog has been matched with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// No airlight.
    None,
    /// [`sun2005`].
    Sun2005,
    /// [`fogshop2007`].
    Fogshop2007,
    /// [`reference`](mod@reference).
    Reference,
}

impl Method {
    /// What a scene asks for. `auto` is Sun's where it is exact, else Fogshop's.
    pub fn new(asked: scene::Airlight, field: &Field) -> Self {
        use scene::Airlight;
        match asked {
            _ if field.is_empty() => Self::None,
            Airlight::None => Self::None,
            Airlight::Sun2005 => Self::Sun2005,
            Airlight::Fogshop2007 => Self::Fogshop2007,
            Airlight::Reference => Self::Reference,
            Airlight::Auto if field.blobs.is_empty() => Self::Sun2005,
            Airlight::Auto => Self::Fogshop2007,
        }
    }
}

/// Why the asked estimator cannot take this fog, if so.
pub fn refusal(fog: &Fog) -> Option<String> {
    if fog.airlight != scene::Airlight::Sun2005 {
        return None;
    }
    let strange = fog.terms.iter().filter(|term| term.enabled()).find_map(|term| match term {
        Term::Homogeneous(_) => None,
        Term::Gaussians(_) => Some("gaussians"),
    })?;
    Some(format!("sun2005 takes homogeneous fog only, not {strange}; auto takes both"))
}

/// A light's nearest distance to a ray counts as at least this share of the scene's own distances:
/// what rounding leaves of it. A ray through a light thereby has a finite answer.
pub const MISS_FLOOR: f64 = 1e-6;
/// The same for a ray without length that starts in a light [m]: small, and its square no f32 zero.
pub const LEAST_MISS: f64 = 1e-15;

/// Where a light stands relative to a ray.
#[derive(Clone, Copy, Debug)]
pub struct ToLight<N> {
    /// Ray parameter of the point closest to the light [m].
    pub closest: N,
    /// Distance of the light from the ray's line [m], floored by [`MISS_FLOOR`].
    pub miss: N,
}

impl<N: Num> ToLight<N> {
    /// From the light's place relative to the ray's origin, the unit direction and the length.
    #[inline(always)]
    pub fn new(light: V3<N>, direction: V3<N>, length: N) -> Self {
        let floor = light.length_squared().sqrt().max(length) * length.lit(MISS_FLOOR);
        let floor = floor.max(length.lit(LEAST_MISS));
        // Errata 17: a difference of squares would lose a small distance.
        let miss = light.cross(direction).length_squared().sqrt();
        Self { closest: light.dot(direction), miss: miss.max(floor) }
    }
}
