//! Patches of the picture over which fields are interpolated.

use super::control::Blob;
use crate::cpu::batch::{Rays, Row, SIZE, get3};
use crate::cpu::fog::Ends;
use crate::cpu::frame::{Context, Lamp};
use crate::request::{Quality, View};
use glam::{DVec2, Vec2, Vec3};

/// What a patch may miss.
#[derive(Clone, Copy, Debug)]
pub struct Tolerance {
    /// A patch is at most this share of its distance from a light's image.
    near: f32,
    /// Optical depth that quadratics may miss of blobs that stand between the rays looked at.
    hidden: f32,
    /// Half a patch's diagonal is at most this [rad].
    wide: f64,
    /// Relative error of the airlight at the place where it is checked.
    pub rough: f64,
    /// Relative difference of two rules that agree.
    pub agree: f64,
    /// Rays of a layer end within this share of each other's way through the fog.
    pub layer: f32,
    /// A larger patch of more layers than this is split.
    pub layers: usize,
}

impl Tolerance {
    /// Of a picture whose numbers are wanted, of one for the eye, or of one in motion.
    pub fn new(view: &View) -> Self {
        match view.quality {
            Quality::Full if !view.for_screen => Self {
                near: 0.4,
                hidden: 5e-3,
                wide: 0.06,
                rough: 5e-4,
                agree: 3e-4,
                layer: 0.12,
                layers: 3,
            },
            Quality::Full => Self {
                near: 0.7,
                hidden: 2e-2,
                wide: 0.1,
                rough: 2e-3,
                agree: 1e-3,
                layer: 0.2,
                layers: 4,
            },
            Quality::Draft => Self {
                near: 1.0,
                hidden: 0.1,
                wide: 0.2,
                rough: 0.03,
                agree: 5e-3,
                layer: 0.5,
                layers: 8,
            },
        }
    }
}

/// Blobs of which half a patch's diagonal covers less than this share of the radius are seen.
const COARSE: f32 = 0.4;
/// Radii from its centre at which a blob has ended aside of a ray: exp(−4.3²) is 1e-8.
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

/// Parts of a patch over which one set of nodes does not suffice for a light.
pub fn split(
    context: &Context,
    lamp: &Lamp,
    around: &Surroundings,
    places: &Places,
    patch: &Patch,
) -> Option<Vec<Patch>> {
    let Tolerance { near, wide, .. } = Tolerance::new(&context.view);
    let size = patch.size();
    let image = context.viewpoint.project(lamp.from_camera).map(DVec2::as_vec2);
    let near = image.is_some_and(|image| size > near * patch.middle().distance(image));
    let split = size > SMALLEST && (near || is_wide(context, patch, wide) || around.hides);
    split.then(|| patch.quarters(places))
}

/// Blobs around a patch's rays.
pub struct Surroundings {
    /// Those that some ray meets.
    pub blobs: Vec<Blob>,
    /// Whether some are so small in the picture that they may stand between the rays that are
    /// looked at.
    hides: bool,
}

impl Surroundings {
    /// Of the blobs around a larger patch.
    pub fn new(context: &Context, blobs: &[Blob], patch: &Patch) -> Self {
        let (middle, half) = (patch.middle(), patch.half());
        let (offset, axis) = context.viewpoint.ray(middle.as_dvec2());
        let (rim_offset, rim) = context.viewpoint.ray((middle + half).as_dvec2());
        let (axis, offset) = (axis.as_vec3(), offset.as_vec3());
        // Half the patch's diagonal: per metre of distance, else in metres.
        let spread = rim.as_vec3().distance(axis);
        let width = rim_offset.as_vec3().distance(offset);
        let mut hidden = 0.0;
        let meets = |blob: &&Blob| {
            let b = Vec3::from(blob.b) - offset * blob.a;
            let half = 1.01 * (b.length() * spread + width * blob.a);
            let miss = (b.cross(axis).length() - half).max(0.0);
            if half > COARSE && miss < FAR {
                let half = half.min(4.0);
                // The third derivative of a Gaussian, met over half a patch.
                hidden += 0.25 * blob.k * half * half * half * (-miss * miss).exp();
            }
            miss < FAR
        };
        let blobs = blobs.iter().filter(meets).copied().collect();
        Self { blobs, hides: hidden > Tolerance::new(&context.view).hidden }
    }
}

/// Whether a patch's rays spread so much that no field is a quadratic across them.
fn is_wide(context: &Context, patch: &Patch, wide: f64) -> bool {
    let direction = |place: Vec2| context.viewpoint.ray(place.as_dvec2()).1;
    let (middle, half) = (patch.middle(), patch.half());
    direction(middle).distance(direction(middle + half)) > wide
}
