//! What stands in a countryside: houses, a church, trees.

use super::geometry::{MeshBuilder, lathe_with, rod};
use super::stage::{glossy, matte, mesh};
use crate::random::{Random, value_noise};
use crate::scene::{Shape, Surface};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// The parts of a village, one material each.
#[derive(Default)]
pub struct Village {
    walls: MeshBuilder,
    roofs: MeshBuilder,
    panes: MeshBuilder,
    trunks: MeshBuilder,
    crowns: MeshBuilder,
    conifers: MeshBuilder,
}

impl Village {
    /// Its surfaces, of what there is any.
    pub fn surfaces(self) -> Vec<Surface> {
        let all = [
            mesh("walls", self.walls.flat(), matte([0.62, 0.56, 0.46])),
            mesh("roofs", self.roofs.flat(), matte([0.34, 0.13, 0.075])),
            mesh("windows", self.panes.flat(), glossy([0.04, 0.05, 0.07], 0.2, 40.0)),
            mesh("trunks", self.trunks.flat(), matte([0.12, 0.08, 0.05])),
            mesh("crowns", self.crowns.rounded(100.0).flat(), matte([0.16, 0.15, 0.045])),
            mesh("conifers", self.conifers.rounded(10.0).flat(), matte([0.06, 0.1, 0.05])),
        ];
        let is_empty = |surface: &Surface| match &surface.shape {
            Shape::Mesh(mesh) => mesh.indices.is_empty(),
            _ => false,
        };
        all.into_iter().filter(|surface| !is_empty(surface)).collect()
    }

    /// A house of two storeys, its long sides towards ±z: where it stands and its length [m].
    pub fn house(&mut self, foot: DVec3, length: f64) {
        /// Half of what it measures along z [m].
        const DEPTH: f64 = 4.5;
        /// Height of the walls, and of the roof above them [m].
        const EAVES: f64 = 6.2;
        const ROOF: f64 = 5.0;
        let half = length / 2.0;
        let at = |x: f64, y: f64, z: f64| foot + DVec3::new(x, y, z);
        // The ground may fall away below it.
        self.walls.block(at(-half, -3.0, -DEPTH), at(half, EAVES, DEPTH));
        let (low, high) =
            (at(-half - 0.6, EAVES, -DEPTH - 0.7), at(half + 0.6, EAVES + ROOF, DEPTH + 0.7));
        self.roofs.frustum([low, high], DVec3::new(2.2, 0.0, DEPTH + 0.65));
        self.walls
            .block(at(half * 0.4, EAVES, -0.6), at(half * 0.4 + 1.3, EAVES + ROOF + 1.2, 0.6));
        let windows = (length / 3.2).floor();
        self.panes.block(at(-0.7, -0.5, 0.0), at(0.7, 2.3, DEPTH + 0.08));
        for k in 0..windows as u32 {
            let x = (f64::from(k) + 0.5) * length / windows - half;
            for (low, high) in [(1.0, 2.4), (3.9, 5.2)] {
                self.panes
                    .block(at(x - 0.55, low, -DEPTH - 0.05), at(x + 0.55, high, DEPTH + 0.05));
            }
        }
    }

    /// A church whose tower stands towards +z.
    pub fn church(&mut self, foot: DVec3) {
        let at = |x: f64, y: f64, z: f64| foot + DVec3::new(x, y, z);
        self.walls.block(at(-5.0, -4.0, -16.0), at(5.0, 8.0, 5.0));
        self.roofs.frustum([at(-5.7, 8.0, -16.5), at(5.7, 14.5, 5.5)], DVec3::new(5.6, 0.0, 0.6));
        self.walls.block(at(-3.2, -4.0, 5.0), at(3.2, 19.0, 11.4));
        self.roofs.frustum([at(-3.7, 19.0, 4.5), at(3.7, 38.0, 11.9)], DVec3::new(3.65, 0.0, 3.65));
        for z in [-13.0, -8.5, -4.0, 0.5] {
            self.panes.block(at(-5.1, 2.0, z), at(5.1, 6.0, z + 1.4));
        }
        for y in [7.0, 14.5] {
            self.panes.block(at(-0.8, y, 11.3), at(0.8, y + 2.6, 11.5));
        }
    }

    /// A broad tree: its foot, its height [m], and which one it is.
    pub fn tree(&mut self, foot: DVec3, tall: f64, seed: u64) {
        /// Lobes of a crown: out from the middle, up, and radius, as shares of the height.
        const LOBES: [[f64; 3]; 9] = [
            [0.02, 0.8, 0.17],
            [0.15, 0.7, 0.17],
            [0.15, 0.68, 0.18],
            [0.15, 0.66, 0.16],
            [0.22, 0.52, 0.16],
            [0.22, 0.5, 0.17],
            [0.22, 0.54, 0.15],
            [0.22, 0.48, 0.16],
            [0.0, 0.54, 0.22],
        ];
        let mut random = Random::new(seed);
        let top = foot + DVec3::Y * tall * 0.5;
        self.trunks.add_at(&rod(foot - DVec3::Y, top, tall * 0.028, 7), DVec3::ZERO);
        let first = random.angle();
        for (k, [out, up, radius]) in LOBES.into_iter().enumerate() {
            // A quarter of the circle and a bit from one to the next.
            let angle = first + 1.75 * k as f64;
            let place = DVec3::new(out * angle.cos(), up, out * angle.sin()) * tall;
            let radius = tall * radius * random.between(0.9, 1.12);
            self.crowns.add_at(&foliage(radius, &mut random), foot + place);
        }
    }

    /// A conifer: its foot, its height [m], its turn [rad], and of how many cones it is.
    pub fn conifer(&mut self, foot: DVec3, tall: f64, turn: f64, tiers: u32) {
        for tier in 0..tiers {
            let up = f64::from(tier) / f64::from(tiers);
            let low = 0.8 * up - 0.04;
            let high = low + 0.5 + 0.3 / f64::from(tiers);
            let ends = [tall * low, tall * high.min(1.0)];
            self.conifers.cone(foot, ends, tall * 0.22 * (1.0 - 0.62 * up), turn + up, 6);
        }
    }

    /// A bush: its foot, its radius [m], and which one it is.
    pub fn bush(&mut self, foot: DVec3, radius: f64, seed: u64) {
        let mut random = Random::new(seed);
        self.crowns.add_at(&foliage(radius, &mut random), foot + DVec3::Y * radius * 0.6);
    }

    /// Conifers in groves, where the ground is as they like it: how many, over which square [m].
    pub fn grove(
        &mut self,
        count: usize,
        size: f64,
        random: &mut Random,
        height: impl Fn(f64, f64) -> f64,
        grows: impl Fn(DVec3) -> bool,
    ) {
        let mut planted = 0;
        while planted < count {
            let [x, z] = [0; 2].map(|_| random.between(-0.49, 0.49) * size);
            let foot = DVec3::new(x, height(x, z), z);
            if value_noise(x / 70.0, z / 70.0, 44) > 0.52 && grows(foot) {
                self.conifer(foot, random.between(9.0, 17.0), random.angle(), 2);
                planted += 1;
            }
        }
    }
}

/// A ball of leaves about the origin, nowhere quite round.
fn foliage(radius: f64, random: &mut Random) -> MeshBuilder {
    const SEGMENTS: usize = 10;
    const RINGS: usize = 5;
    let profile: Vec<DVec2> = (0..=RINGS)
        .map(|k| radius * DVec2::from_angle(PI * (k as f64 / RINGS as f64 - 0.5)))
        .collect();
    let bumps = random.angle();
    lathe_with(&profile, SEGMENTS, |angle, k| {
        // Bumps that turn from ring to ring.
        1.0 + 0.12 * (3.0 * angle + bumps + 2.4 * k as f64).sin()
    })
}
