//! Light of one source scattered once into a view ray: L_a = ∫ ω β k(α) I/d² e^(−T(v,x)−T(x,s)) dt.
//!
//! Every method here answers it per unit of ω·I, as one number a light, because extinction is grey.

pub mod errors;
pub mod fogshop2007;
pub mod mapped;
pub mod march;
mod path;
pub mod reference;
pub mod sun2005;

pub use path::ENDS;
pub(crate) use path::Path;

use crate::media::Field;
use crate::num::Num;
use crate::phase::Phase;
use crate::scene::{self, Fog, Term};
use crate::vector::V3;

/// An estimator by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Estimator {
    /// One that a scene may name.
    Scene(scene::Airlight),
    /// [`march`] in so many steps.
    March(u32),
}

/// An estimator that a scene's fog has been matched with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// No airlight.
    None,
    /// [`sun2005`].
    Sun2005,
    /// [`fogshop2007`].
    Fogshop2007,
    /// [`mapped`].
    Mapped,
    /// [`reference`](mod@reference).
    Reference,
    /// [`march`] in so many steps.
    March(u32),
}

impl Method {
    /// What is asked for in a fog. `auto` is Sun's where that is exact.
    pub fn new(asked: Estimator, fog: &Fog, field: &Field) -> Self {
        use scene::Airlight;
        let isotropic = Phase::from(&fog.phase).is_isotropic();
        let asked = match asked {
            _ if field.is_empty() => return Self::None,
            Estimator::March(steps) => return Self::March(steps),
            Estimator::Scene(asked) => asked,
        };
        match asked {
            Airlight::None => Self::None,
            Airlight::Sun2005 => Self::Sun2005,
            Airlight::Fogshop2007 => Self::Fogshop2007,
            Airlight::Reference => Self::Reference,
            Airlight::Auto if isotropic && field.blobs.is_empty() => Self::Sun2005,
            Airlight::Auto => Self::Mapped,
        }
    }
}

/// Why an estimator cannot take this fog, if so. All of them take no fog at all.
pub fn refusal(fog: &Fog, asked: scene::Airlight) -> Option<String> {
    use scene::Airlight;
    let name = match asked {
        Airlight::Sun2005 => "sun2005",
        Airlight::Fogshop2007 => "fogshop2007",
        Airlight::Auto | Airlight::None | Airlight::Reference => return None,
    };
    let mut terms = fog.terms.iter().filter(|term| term.enabled()).peekable();
    if terms.peek().is_some() && !Phase::from(&fog.phase).is_isotropic() {
        return Some(format!("{name} scatters isotropically, not by henyey_greenstein; auto does"));
    }
    let strange = terms.find_map(|term| match term {
        Term::Gaussians(_) if asked == Airlight::Sun2005 => Some("gaussians"),
        Term::Homogeneous(_) | Term::Gaussians(_) => None,
    })?;
    Some(format!("sun2005 takes homogeneous fog only, not {strange}; auto takes both"))
}

/// A light's nearest distance to a ray counts as at least this share of its distance from the ray's
/// origin: what rounding leaves of it. A ray through a light thereby has a finite answer. How long
/// the ray is does not matter: one into the sky is as near to a lamp as one that ends at a wall.
pub const MISS_FLOOR: f64 = 1e-6;
/// And as no less than this [m]: a hundredth of the smallest radius, at which the strongest light on the
/// strongest reflection, 1e12 · 1e12 / (1e-6)², is still a number in f32.
pub const LEAST_MISS: f64 = 1e-6;

/// The smallest distance from a light that counts for a ray whose origin is `reach` away from it [m].
#[inline(always)]
pub fn least_distance<N: Num>(reach: N) -> N {
    (reach * reach.lit(MISS_FLOOR)).max(reach.lit(LEAST_MISS))
}

/// Where a light stands relative to a ray.
#[derive(Clone, Copy, Debug)]
pub struct ToLight<N> {
    /// Ray parameter of the point closest to the light [m].
    pub closest: N,
    /// Distance of the light from the ray's line [m], floored by [`least_distance`].
    pub miss: N,
}

impl<N: Num> ToLight<N> {
    /// From the light's place relative to the ray's origin and the unit direction.
    #[inline(always)]
    pub fn new(light: V3<N>, direction: V3<N>) -> Self {
        let floor = least_distance(light.length_squared().sqrt());
        // Errata 17: a difference of squares would lose a small distance.
        let miss = light.cross(direction).length_squared().sqrt();
        Self { closest: light.dot(direction), miss: miss.max(floor) }
    }
}
