//! What fills space. A medium answers β(x), the extinction [1/m], and T(a, b), the optical depth of a
//! segment, in closed form. All about one stands in its own file or folder: what a scene says of it,
//! its checks, its maths. The list below names them all, and nothing else does.
//!
//! A scene's fog is the [`Field`], the sum of its terms. It answers what a medium answers, so whoever
//! integrates light along a ray sees one medium. In f64 nothing is left out; for pictures, batches of
//! rays are the boundary: a call per medium and batch costs nothing beside what the batch does.

mod closed;
mod groups;
mod moment;
pub mod noise;
mod octaves;
mod outline;
mod places;
pub mod sign;
mod sum;
mod toward;
pub mod vertical;

pub use closed::hull;
pub use groups::{Bands, Scattering, in_channels, scatterings};
pub use moment::{Moment, Velocity, Wind, WindKey};
pub use octaves::{MultipleScattering, Octave};
pub use outline::Outline;
pub use places::Places;
pub use sum::{Field, Knotted, Profile, Sum};

use crate::geometry::batch::{Rays, Row};
use crate::geometry::bundle::Bundle;
use crate::geometry::control::{Control, Each};
use crate::geometry::{Beyond, Origin, Ray};
use crate::json::document::{Part, union_parts};
use crate::json::tagged::tagged;
use crate::json::{Albedo, Checker};
use crate::phase::Phase;
use crate::progress::Job;
use fearless_simd::Level;
use glam::{DVec3, Vec3, Vec4};
use std::fmt::Debug;
use std::hash::DefaultHasher;

/// Declares the media: the union of terms that a scene may hold, and the sum that they come to.
macro_rules! media {
    ($($(#[$doc:meta])* $Kind:ident = $kind:literal in $stem:ident),* $(,)?) => {
        $(pub mod $stem;)*
        $(use $stem::$Kind;)*

        tagged!(
            /// One part of the fog.
            Term { $($(#[$doc])* $Kind = $kind),* }
        );
        union_parts!(Term { $($Kind = $kind),* });

        impl Term {
            /// What it is, in a few words.
            pub fn what(&self) -> &'static str {
                match self { $(Self::$Kind(term) => term.what()),* }
            }

            /// What every term says besides what it is.
            pub fn common(&self) -> Common<'_> {
                match self {
                    $(Self::$Kind(term) => Common {
                        id: term.id.as_deref(),
                        enabled: term.enabled,
                        albedo: term.albedo,
                        phase: term.phase.as_ref(),
                        wind_response: term.wind_response,
                    }),*
                }
            }

            /// The name given to it.
            pub fn id_mut(&mut self) -> &mut Option<String> {
                match self { $(Self::$Kind(term) => &mut term.id),* }
            }

            /// Looks at all of its numbers; `at` names its members. No ray of a picture is longer than `far_m`.
            pub fn check(&self, check: &mut Checker, at: &dyn Fn(&str) -> String, far_m: f64) {
                match self { $(Self::$Kind(term) => term.check(check, at, far_m)),* }
            }

            /// Blobs that it counts as.
            pub fn blobs(&self) -> usize {
                match self { $(Self::$Kind(term) => term.blobs()),* }
            }

            /// What a ray of that length sums up of it at most: what it costs.
            pub fn cost(&self, length_m: f64) -> usize {
                match self { $(Self::$Kind(term) => term.cost(length_m)),* }
            }

            /// The member that says how many.
            pub fn counted_at(&self) -> &'static str {
                match self { $(Self::$Kind(term) => term.counted_at()),* }
            }

            /// The term of another kind that it stands for at a moment, if so.
            pub fn stands_for(&self, moment: &Moment) -> Option<Self> {
                match self { $(Self::$Kind(term) => term.stands_for(moment)),* }
            }

            /// The longest ray that it may be asked for [m].
            pub fn longest_m(&self) -> f64 {
                match self { $(Self::$Kind(term) => term.longest_m()),* }
            }

            /// Whether its field changes in calm air.
            pub fn changes(&self) -> bool {
                match self { $(Self::$Kind(term) => term.changes()),* }
            }

            /// Whether its extinction is the same in all channels.
            pub fn is_grey(&self) -> bool {
                match self { $(Self::$Kind(term) => term.is_grey()),* }
            }
        }

        /// Word, source and test scene of every kind: see [`TermKind`].
        pub const KINDS: &[(&str, &str, &str)] =
            &[$(($kind, <$Kind as TermKind>::SOURCE, <$Kind as TermKind>::TRIAL)),*];

        /// Terms of a fog as one channel meets them, each kind as one medium.
        #[derive(Clone, Debug, Default)]
        pub struct Media { $($(#[$doc])* pub $stem: <$Kind as TermKind>::Medium),* }

        impl Media {
            /// Of some terms.
            pub fn new(terms: &[&Term], channel: usize, moment: &Moment) -> Self {
                let others: Vec<_> = terms.iter().map(|term| term.stands_for(moment)).collect();
                let each = terms.iter().zip(&others);
                let terms: Vec<_> = each.map(|(own, other)| other.as_ref().unwrap_or(own)).collect();
                $(
                    let $stem = terms.iter().filter_map(|term| match term {
                        Term::$Kind(term) => Some(term),
                        _ => None,
                    });
                    let $stem = <$Kind as TermKind>::merge(&$stem.collect::<Vec<_>>(), channel, moment);
                )*
                Self { $($stem),* }
            }

            /// The names by which passes know those that stand in closed form in `shaders/media/`, and whether each is
            /// there.
            pub fn in_shaders(&self) -> impl Iterator<Item = (&'static str, bool)> {
                let all = [$((
                    concat!("MEDIUM_", stringify!($stem)),
                    self.$stem.is_in_shaders(),
                    !self.$stem.is_empty(),
                )),*];
                all.into_iter().filter_map(|(name, shaded, there)| shaded.then_some((name, there)))
            }

            /// Those that stand in closed form in `shaders/media/`; `numbers` is the list that they share.
            pub fn shaded(&self, camera: DVec3, numbers: &mut Vec<f32>) -> Vec<Shaded> {
                let shaded = [$(self.$stem.rows(camera, numbers).map(|rows| Shaded {
                    stem: stringify!($stem),
                    define: concat!("MEDIUM_", stringify!($stem)),
                    rows,
                })),*];
                shaded.into_iter().flatten().collect()
            }

            /// Each of them.
            pub fn each(&self) -> impl Iterator<Item = &dyn Medium> {
                [$(&self.$stem as &dyn Medium),*].into_iter()
            }
        }
    };
}

media! {
    /// The same extinction everywhere, or one that depends on height alone.
    Homogeneous = "homogeneous" in homogeneous,
    /// A sum of Gaussian blobs.
    Gaussians = "gaussians" in gaussians,
    /// A sum of waves, polynomials, and fog around objects.
    Functions = "functions" in functions,
    /// A map of B-splines.
    Fogmap = "fogmap" in fogmap,
    /// A source of particles.
    Emitter = "emitter" in emitter,
}

/// What every term says besides what it is.
#[derive(Clone, Copy, Debug)]
pub struct Common<'a> {
    /// The name given to it, if any.
    pub id: Option<&'a str>,
    /// Whether it is part of the fog.
    pub enabled: bool,
    /// Share of the extinguished light that it scatters, if it has one of its own.
    pub albedo: Option<Albedo>,
    /// Into which directions, if not as the fog.
    pub phase: Option<&'a Phase>,
    /// Which share of the wind moves it.
    pub wind_response: f64,
}

/// A kind of term, as a scene says it.
pub trait TermKind: Part {
    /// What terms of this kind come to.
    type Medium: Medium;

    /// Where it was published, with the equations.
    const SOURCE: &'static str;

    /// A small test scene: the terms of a fog, as JSON, that need all that this kind can do.
    const TRIAL: &'static str;

    /// What it is, in a few words: for whoever cannot take it.
    fn what(&self) -> &'static str;

    /// Looks at all of its numbers; `at` names its members. No ray of a picture is longer than `far_m`.
    fn check(&self, check: &mut Checker, at: &dyn Fn(&str) -> String, far_m: f64);

    /// Blobs that it counts as: what it takes in memory and in time.
    fn blobs(&self) -> usize {
        0
    }

    /// What a ray of that length sums up of it at most: what it costs.
    fn cost(&self, _length_m: f64) -> usize {
        self.blobs()
    }

    /// The member that says how many.
    fn counted_at(&self) -> &'static str {
        "blobs"
    }

    /// The term of another kind that it stands for at a moment, if so.
    fn stands_for(&self, _moment: &Moment) -> Option<Term> {
        None
    }

    /// The longest ray that it may be asked for [m].
    fn longest_m(&self) -> f64 {
        f64::INFINITY
    }

    /// Whether its field changes in calm air.
    fn changes(&self) -> bool {
        false
    }

    /// Whether its extinction is the same in all channels.
    fn is_grey(&self) -> bool;

    /// Terms of this kind as one medium, as a channel meets it at a moment: 0 is red, 2 blue.
    fn merge(terms: &[&Self], channel: usize, moment: &Moment) -> Self::Medium;
}

/// A medium that a shader sums up in closed form.
#[derive(Debug)]
pub struct Shaded {
    /// Its file in `shaders/media/`.
    pub stem: &'static str,
    /// The name by which passes are put together with it.
    pub define: &'static str,
    /// What it reads.
    pub rows: Vec<Words>,
}

/// A row of what a shader sums up, four numbers at a time.
pub type Words = Vec<Vec4>;

/// Whose ways rays are: details of a fog that the eye does not see still dim a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Legs {
    /// View rays.
    OfEyes,
    /// From a light.
    OfLights,
}

/// All terms of one kind, merged. What it says in f64 leaves nothing out.
pub trait Medium: Debug + Send + Sync {
    /// Whether it is nothing at all.
    fn is_empty(&self) -> bool;

    /// β [1/m] if it is the same everywhere.
    fn uniform_beta(&self) -> Option<f64> {
        self.is_empty().then_some(0.0)
    }

    /// β(x) [1/m].
    fn beta(&self, x: DVec3) -> f64;

    /// T along a ray of that length [m].
    fn depth(&self, ray: &Ray, length_m: f64) -> f64;

    /// T from a point to beyond everything; what has no end there counts so far.
    fn depth_beyond(&self, x: DVec3, beyond: &Beyond) -> f64;

    /// The medium along one ray.
    fn along(&self, ray: &Ray, length_m: f64) -> Box<dyn Along>;

    /// The medium between where light comes from and the points of a segment.
    fn ways(&self, origin: Origin, ends: [DVec3; 2]) -> Box<dyn Ways>;

    /// What matters of it to the rays of a bundle, for pictures.
    fn near(&self, level: Level, search: &Search) -> Box<dyn Near>;

    /// The medium for rays from an origin, if its closed form is cheaper than any table and smooth
    /// between its edges.
    fn smooth(&self, _origin: DVec3, _legs: Legs) -> Option<Box<dyn Smooth>> {
        None
    }

    /// The least that it weighs on any ray of that length [m].
    fn least(&self, _length_m: f64) -> f64 {
        0.0
    }

    /// No lump of it lies farther from a point than this [m].
    fn reach(&self, _from: DVec3) -> f64 {
        0.0
    }

    /// The most that a single lump of it weighs on any ray.
    fn heaviest(&self) -> f64 {
        0.0
    }

    /// Whether it changes in places so fast that only differences of T tell what is there.
    fn is_rippled(&self) -> bool {
        false
    }

    /// How many lumps it is made of; none if it is smooth.
    fn lumps(&self) -> usize {
        0
    }

    /// What a table of T around a light must resolve of its lumps.
    fn outline(&self, _apex: DVec3) -> Outline {
        Outline::default()
    }

    /// Tells where a table over space must resolve it; false where no table can.
    fn places(&self, places: &mut Places) -> bool;

    /// Whether its shader sums it up in closed form.
    fn is_in_shaders(&self) -> bool {
        false
    }

    /// What its shader reads, relative to a camera, if that sums it up in closed form: rows of as many
    /// numbers each, and what has no fixed length, appended to a list of numbers.
    fn rows(&self, _camera: DVec3, _numbers: &mut Vec<f32>) -> Option<Vec<Words>> {
        None
    }

    /// Bytes that it takes besides its own, near enough.
    fn bytes(&self) -> usize;
}

/// A medium along one ray in f64, to rounding.
pub trait Along: Debug {
    /// Terms that a sum has: what a call costs.
    fn terms(&self) -> usize;

    /// Whether it is smooth between its edges, whatever its size.
    fn is_smooth(&self) -> bool;

    /// β [1/m] at the ray parameter `t` [m].
    fn beta(&self, t: f64) -> f64;

    /// T from the origin to the ray parameter `t` [m].
    fn depth(&self, t: f64) -> f64;

    /// From where to where there is any of it [m].
    fn span(&self) -> Option<(f64, f64)>;

    /// The finest length over which it changes between two ray parameters [m].
    fn finest_m(&self, _from: f64, _to: f64) -> f64 {
        f64::INFINITY
    }

    /// Ray parameters where β, or its slope, jumps [m].
    fn edges(&self) -> Vec<f64> {
        Vec::new()
    }
}

/// A medium between where light comes from and the points of a segment, in f64, to rounding.
pub trait Ways: Debug {
    /// Terms that a sum has: what a call costs.
    fn terms(&self) -> usize;

    /// T from there to a point of the segment.
    fn depth_to(&self, point: DVec3) -> f64;
}

/// Optical depth that a picture's ray may lose to culling: this, or [`RELATIVE_LOSS`] of its own.
pub const PICTURE_LOSS: f64 = 1e-5;
/// See [`PICTURE_LOSS`].
pub const RELATIVE_LOSS: f64 = 1e-4;

/// Optical depth that hides all: less than half of the last bit of f32 is let through, 2⁻²⁵.
pub const OPAQUE_DEPTH: f64 = 17.4;

/// What the lumps around a bundle are wanted for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// Optical depth: what is lost may grow with a ray's own.
    Depth,
    /// The same for a picture: behind what hides all it need not be followed.
    Sight,
    /// How much light is left: where that is none, how little of it does not matter.
    Shade,
    /// Airlight too: it comes from where the ray begins, however thick the fog behind may be.
    Airlight,
    /// Fields that airlight is integrated over: where fog is thin, its share counts.
    Nodes,
}

/// What is looked for around a bundle of rays.
#[derive(Clone, Copy, Debug)]
pub struct Search {
    /// The rays.
    pub bundle: Bundle,
    /// None of them is shorter [m].
    pub shortest_m: f64,
    /// What for.
    pub purpose: Purpose,
    /// Whose ways they are.
    pub legs: Legs,
    /// Optical depth that other media surely add.
    pub sure: f64,
}

/// What matters of a medium to a bundle of rays.
pub trait Near: Debug + Send + Sync {
    /// Adds T along every ray. Rays start at the bundle's origin; at offsets from it if `parallel`.
    fn add_depth(&self, job: &Job, rays: &Rays, parallel: bool, length: &Row, depth: &mut Row);

    /// The same medium for the few rays that stand for a patch.
    fn patched(&self) -> Box<dyn Patched>;
}

/// What is smooth between its edges, for rays from one origin.
pub trait Smooth: Near {
    /// Adds the mean extinction, T(x, s)/d [1/m], between a light and points of rays; both relative to
    /// the origin.
    fn add_mean(&self, level: Level, apex: Vec3, rays: &Control, t: &[Each], mean: &mut [Each]);

    /// Adds T from points to beyond everything; they are given relative to the origin, a row a coordinate, as many
    /// as fill registers.
    fn add_beyond(&self, level: Level, beyond: &Beyond, points: [&[f32]; 3], depth: &mut [f32]);

    /// From where to where there is any of it on a ray from `start`, relative to the origin [m].
    fn span(&self, start: DVec3, direction: DVec3, length_m: f64) -> Option<(f64, f64)>;

    /// Appends where β, or its slope, jumps on a ray [m], in the order of [`OnRays::edges`]; what it does
    /// not pass lies behind its start.
    fn edges(&self, _start: Vec3, _direction: Vec3, _edges: &mut Vec<f32>) {}
}

/// The rays of a patch as a cone, relative to the viewpoint.
#[derive(Clone, Copy, Debug)]
pub struct PatchCone {
    /// Where the middle ray starts [m].
    pub offset: Vec3,
    /// Its unit direction.
    pub axis: Vec3,
    /// Half the patch's diagonal, per metre of distance.
    pub spread: f32,
    /// The same where rays are parallel [m].
    pub width: f32,
    /// The longest ray [m].
    pub longest: f32,
}

/// What lumps around a patch come to.
#[derive(Clone, Copy, Debug)]
pub struct Lumps {
    /// Optical depth along the middle ray.
    pub depth: f32,
    /// Where the first of them begins [m].
    pub begin: f32,
    /// Where the last of them ends [m].
    pub end: f32,
    /// Optical depth that quadratics across the patch may miss of those between the rays looked at,
    /// squared: what many hide has either sign.
    pub hidden_squared: f32,
}

impl Default for Lumps {
    fn default() -> Self {
        Self { depth: 0.0, begin: f32::INFINITY, end: 0.0, hidden_squared: 0.0 }
    }
}

/// What matters of a medium to a patch's rays.
pub trait Patched: Debug + Send + Sync {
    /// Terms that a sum has: what a place of a ray costs.
    fn terms(&self) -> usize;

    /// Tells all that depths along rays depend on; false where that cannot be told.
    fn tell(&self, _hasher: &mut DefaultHasher) -> bool {
        false
    }

    /// What its lumps around a smaller patch come to, added to `lumps`.
    fn weigh(&self, _cone: &PatchCone, _lumps: &mut Lumps) {}

    /// What the rays of a smaller patch meet of it; `lumps` gathers what that comes to.
    fn within(&self, cone: &PatchCone, lumps: &mut Lumps) -> Box<dyn Patched>;

    /// T along the middle ray of a patch, of what is smooth.
    fn haze(&self, _cone: &PatchCone, _length: f32) -> f32 {
        0.0
    }

    /// Follows rays from the origin, or from offsets if `parallel`; without the lumps of which all
    /// rays meet less than the share `least`.
    fn on_rays(&self, level: Level, rays: &Control, parallel: bool, least: f32) -> Box<dyn OnRays>;
}

/// A medium as the sixteen rays of a [`Control`] meet it.
pub trait OnRays: Debug + Send + Sync {
    /// Whether it is smooth between its edges.
    fn is_smooth(&self) -> bool;

    /// Adds β and T at ray parameters `t`, ascending from row to row; T alone if `beta` has no rows.
    fn add(&self, level: Level, t: &[Each], beta: &mut [Each], depth: &mut [Each]);

    /// The most that any ray meets between two ray parameters.
    fn most(&self, from: f32, to: f32) -> f32;

    /// From where to where there is any of it on the rays [m].
    fn span(&self) -> Option<(f32, f32)>;

    /// The smallest radius of the lumps between two ray parameters [m] that weigh more than `least`;
    /// infinite if none does: a sum of many is smoother than each.
    fn finest(&self, _from: f32, _to: f32, _least: f32) -> f32 {
        f32::INFINITY
    }

    /// Where it has surely added that much optical depth behind a ray parameter, on all rays [m].
    fn hides_from(&self, _from: f32, _depth: f32) -> f32 {
        f32::INFINITY
    }

    /// Ray parameters where β, or its slope, jumps, ray by ray [m]; what a ray does not pass lies behind
    /// its start.
    fn edges(&self) -> Vec<Each> {
        Vec::new()
    }
}
