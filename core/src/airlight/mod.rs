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

pub(crate) use path::Path;

use crate::media::{Field, Term};
use crate::num::Num;
use crate::phase::Phase;
use crate::vector::V3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The estimator of light scattered into the view ray.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Airlight {
    /// The best for real time on this scene.
    #[default]
    Auto,
    /// No airlight: only the veil.
    None,
    /// Sun 2005: exact for homogeneous fog alone.
    Sun2005,
    /// Fogshop 2007: its published approximation for homogeneous fog and Gaussians.
    Fogshop2007,
    /// The integral itself by adaptive quadrature: slow, for comparison.
    Reference,
}

/// An estimator by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Estimator {
    /// One that a scene may name.
    Scene(Airlight),
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
    pub fn new(asked: Estimator, phase: &Phase, field: &Field) -> Self {
        let isotropic = phase.function().is_isotropic();
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
            Airlight::Auto if isotropic && field.uniform_beta().is_some() => Self::Sun2005,
            Airlight::Auto => Self::Mapped,
        }
    }
}

/// Why an estimator cannot take a fog of some terms, if so. All of them take no fog at all.
pub fn refusal(terms: &[Term], phase: &Phase, asked: Airlight) -> Option<String> {
    let (name, what, takes): (_, _, fn(&Term) -> bool) = match asked {
        Airlight::Sun2005 => ("sun2005", sun2005::TAKES, sun2005::takes),
        Airlight::Fogshop2007 => ("fogshop2007", fogshop2007::TAKES, fogshop2007::takes),
        Airlight::Auto | Airlight::None | Airlight::Reference => return None,
    };
    let mut terms = terms.iter().filter(|term| term.common().enabled).peekable();
    if terms.peek().is_some() && !phase.function().is_isotropic() {
        return Some(format!("{name} scatters isotropically, not by henyey_greenstein; auto does"));
    }
    let strange = terms.find(|term| !takes(term))?.what();
    Some(format!("{name} takes {what} only, not {strange}; auto takes all"))
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
