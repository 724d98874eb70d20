//! Patches of the picture over which fields are interpolated.

use super::control::Blob;
use crate::airlight::ENDS;
use crate::cpu::batch::{Rays, Row, SIZE, get3};
use crate::cpu::fog::Ends;
use crate::cpu::frame::{Context, Lamp};
use crate::request::{Quality, View};
use glam::{DVec2, Vec2, Vec3};

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

/// Up to so many blobs, each casts a shadow of its own along a ray: its edges are sharper than what a
/// rule's terms can tell, so the rule must be this many times better. The shadows of more lie over
/// each other.
const FEW: usize = 16;
const SHARP: f64 = 8.0;

/// The closest agreement that f32 can show.
const CLOSEST: f64 = 3e-4;

impl Tolerance {
    /// Of a frame.
    pub fn new(context: &Context) -> Self {
        let usual = Self::of(&context.view);
        let few = context.field.blobs.len() <= FEW;
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
                agree: 2e-2,
                unmet: 0.03,
                layer: 0.5,
                layers: 8,
            },
        }
    }
}

/// Blobs of which half a patch's diagonal covers less than this share of the radius are seen.
const COARSE: f32 = 0.4;
/// Radii from its centre at which a blob has ended aside of a ray: exp(−4.3²) is 1e-8. Where there is
/// nothing but the tails of blobs, they are what is seen.
const FAR: f32 = 4.3;
/// No patch is split below this [px].
pub const SMALLEST: f32 = 0.5;

/// Where rays pass through the picture [px], batch by batch.
pub struct Places(Vec<[Row; 2]>);

impl Places {
    /// Of some batches' rays.
    pub fn new(context: &Context, block: &[Ends<'_>]) -> Self {
        Self(block.iter().map(|ends| places(context, ends.rays)).collect())
    }

    /// Of one ray.
    pub fn get(&self, ray: Ray) -> Vec2 {
        let [x, y] = &self.0[ray.batch()];
        Vec2::new(x[ray.at()], y[ray.at()])
    }
}

fn places(context: &Context, rays: &Rays) -> [Row; 2] {
    let viewpoint = &context.viewpoint;
    let (across, down) = viewpoint.picture_axes();
    let forward = viewpoint.forward.as_vec3();
    let half = 0.5 * viewpoint.size().as_vec2();
    let (mut x, mut y) = ([0.0; SIZE], [0.0; SIZE]);
    for (at, (x, y)) in x.iter_mut().zip(&mut y).enumerate().take(rays.count) {
        let point = if viewpoint.parallel {
            get3(&rays.offset, at)
        } else {
            let direction = get3(&rays.direction, at);
            direction / direction.dot(forward)
        };
        *x = (point.dot(across) + 1.0) * half.x;
        *y = (point.dot(down) + 1.0) * half.y;
    }
    [x, y]
}

/// A ray of some batches.
#[derive(Clone, Copy, Debug)]
pub struct Ray(u32);

impl Ray {
    /// From the batch and the place in it.
    pub fn new(batch: usize, at: usize) -> Self {
        Self((batch * SIZE + at) as u32)
    }

    /// Its batch.
    pub fn batch(self) -> usize {
        self.0 as usize / SIZE
    }

    /// Its place in the batch.
    pub fn at(self) -> usize {
        self.0 as usize % SIZE
    }

    /// Where it ends [m].
    pub fn length(self, block: &[Ends<'_>]) -> f32 {
        block[self.batch()].hits.length[self.at()]
    }
}

/// Some rays and the rectangle of the picture that they pass through.
#[derive(Clone, Debug)]
pub struct Patch {
    /// The rays, by where they end.
    pub members: Vec<Ray>,
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
            let ray = |at: usize| (ends.hits.length[at], Ray::new(batch, at));
            rays.extend((0..ends.rays.count).map(ray));
        }
        rays.sort_unstable_by(|(a, _), (b, _)| a.total_cmp(b));
        Self::new(rays.into_iter().map(|(_, ray)| ray).collect(), places)
    }

    fn new(members: Vec<Ray>, places: &Places) -> Self {
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
        let mut parts: [Vec<Ray>; 4] = Default::default();
        for at in &self.members {
            let place = places.get(*at);
            parts[usize::from(place.x > middle.x) + 2 * usize::from(place.y > middle.y)].push(*at);
        }
        let filled = parts.into_iter().filter(|part| !part.is_empty());
        filled.map(|part| Self::new(part, places)).collect()
    }
}

/// Whether one set of nodes does not suffice for what a patch's rays see of a light.
pub fn is_near(context: &Context, lamp: &Lamp, patch: &Patch) -> bool {
    let image = context.viewpoint.project(lamp.from_camera).map(DVec2::as_vec2);
    let near = Tolerance::new(context).near;
    let size = patch.size();
    size > SMALLEST && image.is_some_and(|image| size > near * patch.middle().distance(image))
}

/// Blobs around a patch's rays.
pub struct Surroundings {
    /// Those that some ray meets.
    pub blobs: Vec<Blob>,
    /// Whether the patch is too large for them: some are so small in the picture that they may
    /// stand between the rays that are looked at, or the rays spread so much that no field is a
    /// quadratic across them.
    pub is_coarse: bool,
}

impl Surroundings {
    /// Of the blobs around a larger patch, whose rays are at most so long [m].
    pub fn new(context: &Context, blobs: &[Blob], patch: &Patch, longest: f32) -> Self {
        let (middle, half) = (patch.middle(), patch.half());
        let (offset, axis) = context.viewpoint.ray(middle.as_dvec2());
        let (rim_offset, rim) = context.viewpoint.ray((middle + half).as_dvec2());
        let (axis, offset) = (axis.as_vec3(), offset.as_vec3());
        // Half the patch's diagonal: per metre of distance, else in metres.
        let spread = rim.as_vec3().distance(axis);
        let width = rim_offset.as_vec3().distance(offset);
        let Tolerance { hidden: most, wide, .. } = Tolerance::new(context);
        let (mut hidden, mut depth, mut end) = (0.0, 0.0, 0.0f32);
        let meets = |blob: &&Blob| {
            let b = Vec3::from(blob.b) - offset * blob.a;
            let half = 1.01 * (b.length() * spread + width * blob.a);
            let aside = b.cross(axis).length();
            let miss = (aside - half).max(0.0);
            if miss >= FAR {
                return false;
            }
            depth += 2.0 * blob.k * (-aside * aside).exp();
            end = end.max((b.dot(axis) + ENDS as f32) / blob.a);
            if half > COARSE {
                let half = half.min(4.0);
                // The third derivative of a Gaussian, met over half a patch. What many blobs hide has
                // either sign.
                let missed = 0.25 * blob.k * half * half * half * (-miss * miss).exp();
                hidden += missed * missed;
            }
            true
        };
        let blobs = blobs.iter().filter(meets).copied().collect();
        // Homogeneous fog hides what is missed, but not that behind the blobs.
        depth += context.field.homogeneous.beta as f32 * end.min(longest);
        // In thin fog a blob stands out by what it adds.
        let hides = hidden.sqrt() > most * depth.min(1.0);
        let is_coarse = patch.size() > SMALLEST && (hides || spread > wide);
        Self { blobs, is_coarse }
    }
}
