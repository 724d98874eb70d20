//! Light of one source scattered once into a view ray: L_a = ∫ ω β k(α) I/d² e^(−T(v,x)−T(x,s)) dt.
//!
//! Every method here answers it per unit of ω·I, as one number a light, because a band of
//! colour knows one extinction, and a group of terms scatters alike ([`media`](crate::media)). All
//! about one stands in its own file; the list below names those that a scene may ask for.

pub mod about;
pub mod fogshop2007;
pub mod macklin2010;
pub mod mapped;
pub mod march;
mod massed;
mod path;
pub mod reference;
mod sky;
pub mod sun2005;

pub(crate) use path::Path;
pub(crate) use sky::Under;

use crate::media::{Field, Scattering, Term};
use about::{About, Exactness, Takes};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Declares the estimators: a scene's words for them, those of a comparison, and what they are matched to.
macro_rules! airlight {
    ($($(#[$doc:meta])* $Name:ident = $about:expr),* $(,)?) => {
        /// The estimator of light scattered into the view ray.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum Airlight { $($(#[$doc])* $Name),* }

        /// The estimators that can be compared: those of a scene's `airlight`, and ray marching.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum ComparedAirlight {
            $($(#[$doc])* $Name,)*
            /// The integral by fixed steps, as engines do it; extinction and shadowing fog are exact.
            March,
        }

        /// What computes airlight: an estimator that was asked for, or, once it is matched with a fog, the
        /// one that does it. Then `Auto` is [`mapped`].
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Method {
            $($(#[$doc])* $Name,)*
            /// [`march`] in so many steps.
            March(u32),
        }

        impl Airlight {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$Name),*];

            /// What is said about it.
            pub fn about(self) -> About {
                match self { $(Self::$Name => $about),* }
            }
        }

        impl ComparedAirlight {
            /// The scene's word for it; ray marching has none.
            pub fn of_a_scene(self) -> Option<Airlight> {
                match self {
                    $(Self::$Name => Some(Airlight::$Name),)*
                    Self::March => None,
                }
            }
        }

        impl From<Airlight> for ComparedAirlight {
            fn from(airlight: Airlight) -> Self {
                match airlight { $(Airlight::$Name => Self::$Name),* }
            }
        }

        impl From<Airlight> for Method {
            fn from(airlight: Airlight) -> Self {
                match airlight { $(Airlight::$Name => Self::$Name),* }
            }
        }
    };
}

airlight! {
    /// The best for real time on this scene.
    Auto = mapped::ABOUT,
    /// No airlight: only the veil.
    None = ABOUT_NONE,
    /// Sun 2005: exact for homogeneous fog alone.
    Sun2005 = sun2005::ABOUT,
    /// Fogshop 2007: its published approximation for homogeneous fog and Gaussians.
    Fogshop2007 = fogshop2007::ABOUT,
    /// Macklin 2010: homogeneous fog that takes no light away.
    Macklin2010 = macklin2010::ABOUT,
    /// The integral itself by adaptive quadrature: slow, for comparison.
    Reference = reference::ABOUT,
}

const ABOUT_NONE: About = About {
    source: "Only the veil: ambient · (1 − transmittance) (Biri 2002).",
    takes: None,
    error: Exactness::Words("Leaves out all light of the lamps that the fog scatters to the eye."),
};

#[expect(clippy::derivable_impls, reason = "the list names the variants")]
impl Default for Airlight {
    fn default() -> Self {
        Self::Auto
    }
}

impl Method {
    /// What does it in a fog. `Auto` is Sun's where that is exact.
    pub fn matched(self, scatterings: &[Scattering], field: &Field) -> Self {
        let is_isotropic = || scatterings.iter().all(|own| own.phase.is_isotropic());
        match self {
            _ if field.is_empty() => Self::None,
            Self::Auto if is_isotropic() && field.uniform_beta().is_some() => Self::Sun2005,
            asked => asked,
        }
    }
}

/// Why an estimator cannot take a fog of some terms, which scatter so; if so. All of them take no fog at all.
pub fn refusal(terms: &[Term], scatterings: &[Scattering], asked: Airlight) -> Option<String> {
    let Takes { name, what, term: takes, several } = asked.about().takes?;
    if scatterings.iter().any(|own| !own.phase.is_isotropic()) {
        return Some(format!("{name} scatters isotropically, not by henyey_greenstein; auto does"));
    }
    if !several && scatterings.len() > 1 {
        return Some(format!("{name} takes terms that all have one albedo; auto takes all"));
    }
    let mut terms = terms.iter().filter(|term| term.common().enabled);
    let strange = terms.find(|term| !takes(term))?.what();
    Some(format!("{name} takes {what} only, not {strange}; auto takes all"))
}
