//! Haze along batches of rays, and along the few that stand for a patch.

use super::Haze;
use crate::geometry::batch::{Rays, Row, SIZE};
use crate::geometry::control::{Control, Each, PADDED};
use crate::media::{Lumps, Near, OnRays, PatchCone, Patched, Smooth};
use crate::num::{Lanes, Num};
use crate::progress::Job;
use fearless_simd::{Level, Simd, dispatch};
use glam::Vec3;

impl Near for Haze {
    fn add_depth(&self, job: &Job, rays: &Rays, _parallel: bool, length: &Row, depth: &mut Row) {
        dispatch!(job.level, simd => add_depth(simd, self, rays, length, depth));
    }

    fn patched(&self) -> Box<dyn Patched> {
        Box::new(self.clone())
    }
}

impl Smooth for Haze {
    fn add_mean(&self, level: Level, apex: Vec3, rays: &Control, t: &[Each], mean: &mut [Each]) {
        dispatch!(level, simd => add_mean(simd, self, apex.y, rays, t, mean));
    }

    fn edges(&self, start: Vec3, direction: Vec3, edges: &mut Vec<f32>) {
        edges.extend(self.edges().map(|height| crossing(height as f32, start.y, direction.y)));
    }
}

impl Patched for Haze {
    fn terms(&self) -> usize {
        1 + self.layers.len()
    }

    fn within(&self, _cone: &PatchCone, _lumps: &mut Lumps) -> Box<dyn Patched> {
        Box::new(self.clone())
    }

    fn haze(&self, cone: &PatchCone, length: f32) -> f32 {
        let (start, climb) = (f64::from(cone.offset.y), f64::from(length * cone.axis.y));
        length * self.mean(start, start + climb) as f32
    }

    fn on_rays(&self, _: Level, rays: &Control, _parallel: bool, _: f32) -> Box<dyn OnRays> {
        let Control { direction: [_, climb, _], offset: [_, start, _] } = rays;
        Box::new(HazeOnRays { haze: self.clone(), climb: *climb, start: *start })
    }
}

/// On sixteen rays.
#[derive(Debug)]
struct HazeOnRays {
    haze: Haze,
    /// Height gained per metre.
    climb: Each,
    /// Where each starts [m].
    start: Each,
}

impl OnRays for HazeOnRays {
    fn is_smooth(&self) -> bool {
        true
    }

    fn add(&self, level: Level, t: &[Each], beta: &mut [Each], depth: &mut [Each]) {
        dispatch!(level, simd => add_fields(simd, self, t, beta, depth));
    }

    fn most(&self, from: f32, to: f32) -> f32 {
        self.haze.most() as f32 * (to - from)
    }

    fn span(&self) -> Option<(f32, f32)> {
        Some((0.0, f32::INFINITY))
    }

    fn hides_from(&self, from: f32, depth: f32) -> f32 {
        from + depth / self.haze.uniform as f32
    }

    fn edges(&self) -> Vec<Each> {
        let on_ray = |height: f64, c: usize| {
            crossing(height as f32, self.start[c], self.climb[c])
        };
        self.haze.edges().map(|height| std::array::from_fn(|c| on_ray(height, c))).collect()
    }
}

/// Where a ray passes a height [m]; behind its start if it does not.
fn crossing(height: f32, start: f32, climb: f32) -> f32 {
    let t = (height - start) / climb;
    // A level ray passes none.
    if t.is_finite() { t } else { -1.0 }
}

/// Adds T along a batch of rays.
#[inline(always)]
fn add_depth<S: Simd>(simd: S, haze: &Haze, rays: &Rays, length: &Row, depth: &mut Row) {
    for at in (0..SIZE).step_by(Lanes::<S>::COUNT) {
        let (start, length) =
            (Lanes::load(simd, &rays.offset[1][at..]), Lanes::load(simd, &length[at..]));
        let end = length.mul_add(Lanes::load(simd, &rays.direction[1][at..]), start);
        let before = Lanes::load(simd, &depth[at..]);
        length.mul_add(haze.mean(start, end), before).store(&mut depth[at..]);
    }
}

/// Adds the mean of β between a height and points of rays.
#[inline(always)]
fn add_mean<S: Simd>(
    simd: S,
    haze: &Haze,
    height: f32,
    rays: &Control,
    t: &[Each],
    mean: &mut [Each],
) {
    let height = Lanes::splat(simd, height);
    for (mean, t) in mean.iter_mut().zip(t) {
        for at in (0..PADDED).step_by(Lanes::<S>::COUNT) {
            let start = Lanes::load(simd, &rays.offset[1][at..]);
            let climb = Lanes::load(simd, &rays.direction[1][at..]);
            let y = climb.mul_add(Lanes::load(simd, &t[at..]), start);
            let before = Lanes::load(simd, &mean[at..]);
            (haze.mean(height, y) + before).store(&mut mean[at..]);
        }
    }
}

/// Adds β, if there are rows for it, and T at ray parameters `t`.
#[inline(always)]
fn add_fields<S: Simd>(
    simd: S,
    on_rays: &HazeOnRays,
    t: &[Each],
    beta: &mut [Each],
    depth: &mut [Each],
) {
    let HazeOnRays { haze, climb, start } = on_rays;
    for (k, (t, depth)) in t.iter().zip(depth).enumerate() {
        for at in (0..PADDED).step_by(Lanes::<S>::COUNT) {
            let (t, start) = (Lanes::load(simd, &t[at..]), Lanes::load(simd, &start[at..]));
            let y = Lanes::load(simd, &climb[at..]).mul_add(t, start);
            if let Some(beta) = beta.get_mut(k) {
                (haze.at(y) + Lanes::load(simd, &beta[at..])).store(&mut beta[at..]);
            }
            let before = Lanes::load(simd, &depth[at..]);
            t.mul_add(haze.mean(start, y), before).store(&mut depth[at..]);
        }
    }
}
