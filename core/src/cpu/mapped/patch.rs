//! Patches of the picture over which fields are interpolated.

use crate::cpu::places::{Member, Places, cone};
use crate::frame::context::{Context, Lamp};
use crate::frame::tolerance::Tolerance;
use crate::geometry::batch::Ends;
use crate::media::{Patched, Sum};
use glam::{DVec2, Vec2};

/// No patch is split below this [px].
pub const SMALLEST: f32 = 0.5;

/// Some rays and the rectangle of the picture that they pass through.
#[derive(Clone, Debug)]
pub struct Patch {
    /// The rays, by where they end.
    pub members: Vec<Member>,
    /// Upper left corner [px].
    pub min: Vec2,
    /// Lower right corner [px].
    pub max: Vec2,
}

impl Patch {
    /// All rays of some batches.
    pub fn whole(block: &[Ends<'_>], places: &Places) -> Self {
        let mut rays = Vec::new();
        for (batch, ends) in block.iter().enumerate() {
            let ray = |at: usize| (ends.hits.length[at], Member::new(batch, at));
            rays.extend((0..ends.rays.count).map(ray));
        }
        rays.sort_unstable_by(|(a, _), (b, _)| a.total_cmp(b));
        Self::new(rays.into_iter().map(|(_, ray)| ray).collect(), places)
    }

    fn new(members: Vec<Member>, places: &Places) -> Self {
        let (mut min, mut max) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        for at in &members {
            let place = places.get(*at);
            (min, max) = (min.min(place), max.max(place));
        }
        Self { members, min, max }
    }

    /// The longer side [px].
    pub fn size(&self) -> f32 {
        (self.max - self.min).max_element()
    }

    /// Its middle [px].
    pub fn middle(&self) -> Vec2 {
        0.5 * (self.min + self.max)
    }

    /// Half its sides, never quite nothing [px].
    pub fn half(&self) -> Vec2 {
        // One ray is its own middle; several in a row differ by the rounding of their places.
        let least = if self.members.len() == 1 { 1e-5 } else { 1e-2 };
        (0.5 * (self.max - self.min)).max(Vec2::splat(least))
    }

    /// Its rays, by the quarter that they pass through.
    pub fn quarters(&self, places: &Places) -> Vec<Self> {
        let middle = self.middle();
        let mut parts: [Vec<Member>; 4] = Default::default();
        for at in &self.members {
            let place = places.get(*at);
            parts[usize::from(place.x > middle.x) + 2 * usize::from(place.y > middle.y)].push(*at);
        }
        let filled = parts.into_iter().filter(|part| !part.is_empty());
        filled.map(|part| Self::new(part, places)).collect()
    }
}

/// Whether one set of nodes does not suffice for what a patch's rays see of a light.
pub fn is_near(context: &Context, near: f32, lamp: &Lamp, patch: &Patch) -> bool {
    let image = lamp.image(&context.viewpoint).map(DVec2::as_vec2);
    let size = patch.size();
    size > SMALLEST && image.is_some_and(|image| size > near * patch.middle().distance(image))
}

/// The fog around a patch's rays.
pub struct Surroundings {
    /// What some ray meets.
    pub fog: Sum<dyn Patched>,
    /// Whether the patch is too large for it: some lumps are so small in the picture that they may
    /// stand between the rays that are looked at, or the rays spread so much that no field is a
    /// quadratic across them.
    pub is_coarse: bool,
}

impl Surroundings {
    /// Of the fog around a larger patch, whose rays are at most so long [m].
    pub fn new(
        context: &Context,
        tolerance: &Tolerance,
        fog: &Sum<dyn Patched>,
        patch: &Patch,
        longest: f32,
    ) -> Self {
        let cone = cone(context, patch.middle(), &[patch.half()], longest);
        let (fog, lumps) = fog.within(&cone);
        // In thin fog a lump stands out by what it adds.
        let hides = lumps.hidden_squared.sqrt() > tolerance.hidden * lumps.depth.min(1.0);
        let is_coarse = patch.size() > SMALLEST && (hides || cone.spread > tolerance.wide);
        Self { fog, is_coarse }
    }
}
