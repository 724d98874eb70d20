//! What shines. A light says where its light comes from and how strong it is; all about one kind stands in
//! its own file, and the list below names them all.
//!
//! Whoever computes with a light asks its [`Source`]: that answers per unit of strength, whatever the
//! colour, so that what it answers can be kept while colours change.

mod beam;
mod beside;
pub mod environment;
pub mod point;
pub mod spot;
pub mod sun;

pub use beam::{ALL_ANGLES, Beam, Crossed};
pub use beside::{Arrival, LEAST_MISS, MISS_FLOOR, ToLight, Toward, least_distance};
pub use environment::Environment;
pub use point::Point;
pub use spot::Spot;
pub use sun::Sun;

use crate::geometry::{Beyond, Origin};
use crate::json::Checker;
use crate::json::document::Part;
use crate::json::tagged::tagged;
use crate::num::Num;
use crate::vector::V3;
use glam::DVec3;

/// Declares the lights: the union of those that a scene may hold, and of where the light of lamps comes from. The sky's
/// comes from everywhere.
macro_rules! lights {
    (
        lamps { $($(#[$doc:meta])* $Kind:ident = $kind:literal),* $(,)? }
        skies { $($(#[$sky_doc:meta])* $Sky:ident = $sky:literal),* $(,)? }
    ) => {
        tagged!(
            /// A source of light.
            Light { $($(#[$doc])* $Kind = $kind,)* $($(#[$sky_doc])* $Sky = $sky),* }
        );

        impl Light {
            /// The name given to it, if any.
            pub fn id(&self) -> Option<&str> {
                match self { $(Self::$Kind(light) => light.id(),)* $(Self::$Sky(light) => light.id()),* }
            }

            /// The name given to it.
            pub fn id_mut(&mut self) -> &mut Option<String> {
                match self { $(Self::$Kind(light) => &mut light.id,)* $(Self::$Sky(light) => &mut light.id),* }
            }

            /// Whether it shines.
            pub fn enabled(&self) -> bool {
                match self { $(Self::$Kind(light) => light.enabled(),)* $(Self::$Sky(light) => light.enabled()),* }
            }

            /// Whether surfaces hide its light.
            pub fn shadows(&self) -> bool {
                match self { $(Self::$Kind(light) => light.shadows(),)* $(Self::$Sky(light) => light.shadows()),* }
            }

            /// Looks at all of its numbers; `at` names its members.
            pub fn check(&self, check: &mut Checker, at: &dyn Fn(&str) -> String) {
                match self { $(Self::$Kind(light) => light.check(check, at),)* $(Self::$Sky(light) => light.check(check, at)),* }
            }

            /// Where a lamp's light comes from, and its colour and strength in the unit of its kind; fog without
            /// an end towards it counts so far [m].
            pub fn lamp(&self, path_m: f64) -> Option<(Source, DVec3)> {
                match self {
                    $(Self::$Kind(light) => {
                        Some((Source::$Kind(light.place(path_m)), light.strength()))
                    })*
                    $(Self::$Sky(_) => None,)*
                }
            }

            /// The sky that it is, if it is no lamp.
            pub fn sky(&self) -> Option<&Environment> {
                match self {
                    $(Self::$Kind(_) => None,)*
                    $(Self::$Sky(sky) => Some(sky),)*
                }
            }
        }

        /// Where light comes from, per unit of its strength.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum Source { $($(#[$doc])* $Kind(<$Kind as LampKind>::Place)),* }

        impl Source {
            /// The same, seen from an origin that is not the world's.
            pub fn seen_from(self, origin: DVec3) -> Self {
                match self { $(Self::$Kind(place) => Self::$Kind(place.seen_from(origin))),* }
            }

            /// Where the ways of its light to anywhere begin.
            pub fn origin(self) -> Origin {
                match self { $(Self::$Kind(place) => place.origin()),* }
            }

            /// The same, if that is a place [m].
            pub fn apex(self) -> Option<DVec3> {
                match self.origin() {
                    Origin::At(apex) => Some(apex),
                    Origin::Beyond(_) => None,
                }
            }

            /// Where it stands, be it as far as the sun [m].
            pub fn place(self) -> DVec3 {
                match self.origin() {
                    Origin::At(apex) => apex,
                    Origin::Beyond(Beyond { toward, .. }) => toward * sun::DISTANCE_M,
                }
            }

            /// Where it stands relative to a ray from `start` in the unit `direction`.
            #[inline(always)]
            pub fn beside<N: Num>(self, start: V3<N>, direction: V3<N>) -> ToLight<N> {
                match self { $(Self::$Kind(place) => place.beside(start, direction)),* }
            }

            /// Its direct light at a point; no distance counts as less than `floor` [m].
            #[inline(always)]
            pub fn toward<N: Num>(self, point: V3<N>, floor: N) -> Toward<N> {
                match self { $(Self::$Kind(place) => place.toward(point, floor)),* }
            }

            /// The cone into which it shines, if it is one.
            pub fn beam(self) -> Option<Beam> {
                match self { $(Self::$Kind(place) => place.beam()),* }
            }

            /// How a ray from `start` in the unit `direction` passes that cone.
            #[inline(always)]
            pub fn crossed<N: Num>(self, start: V3<N>, direction: V3<N>) -> Option<Crossed<N>> {
                match self { $(Self::$Kind(place) => place.crossed(start, direction)),* }
            }
        }
    };
}

lights! {
    lamps {
        /// A lamp that shines the same in all directions.
        Point = "point",
        /// A lamp that shines into a cone.
        Spot = "spot",
        /// Parallel light from far away.
        Sun = "sun",
    }
    skies {
        /// The sky.
        Environment = "environment",
    }
}

impl Part for Light {}

/// A kind of light, as a scene says it.
pub trait LightKind {
    /// The name given to it, if any.
    fn id(&self) -> Option<&str>;

    /// Whether it shines.
    fn enabled(&self) -> bool;

    /// Whether surfaces hide its light.
    fn shadows(&self) -> bool;

    /// Looks at all of its numbers; `at` names its members.
    fn check(&self, check: &mut Checker, at: &dyn Fn(&str) -> String);
}

/// One whose light comes from a place, or side by side from beyond everything.
pub trait LampKind: LightKind {
    /// Where its light comes from.
    type Place: Shines;

    /// The same; fog without an end towards it counts so far [m].
    fn place(&self, path_m: f64) -> Self::Place;

    /// Colour and strength, in the unit of its kind.
    fn strength(&self) -> DVec3;
}

/// Where light of one kind comes from: what [`Source`] answers, which see.
pub trait Shines: Copy {
    /// See [`Source::seen_from`].
    #[must_use]
    fn seen_from(self, origin: DVec3) -> Self;

    /// See [`Source::origin`].
    fn origin(self) -> Origin;

    /// See [`Source::beside`].
    fn beside<N: Num>(self, start: V3<N>, direction: V3<N>) -> ToLight<N>;

    /// See [`Source::toward`].
    fn toward<N: Num>(self, point: V3<N>, floor: N) -> Toward<N>;

    /// See [`Source::beam`].
    fn beam(self) -> Option<Beam> {
        None
    }

    /// See [`Source::crossed`].
    #[inline(always)]
    fn crossed<N: Num>(self, _start: V3<N>, _direction: V3<N>) -> Option<Crossed<N>> {
        None
    }
}
