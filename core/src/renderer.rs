//! The renderer: what turns a checked scene into frames and numbers.

use crate::probe::RayAnswer;
use crate::request::{Layer, ProbeRay, View};
use crate::scene::CheckedScene;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// A finished image: linear radiance, optical depths or distances, before any encoding.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Pixels along a row.
    pub width: usize,
    /// Rows of pixels.
    pub height: usize,
    /// What the numbers are.
    pub layer: Layer,
    /// `[height][width][layer.channels()]`, top row first.
    pub pixels: Vec<f32>,
    /// What each pass took, in order.
    pub timings: Vec<(&'static str, Duration)>,
}

/// How far a job is, and whether it should go on: shared between who waits and who works.
#[derive(Debug, Default)]
pub struct Progress {
    cancelled: AtomicBool,
    deadline: Option<Instant>,
    done: AtomicUsize,
    total: AtomicUsize,
}

/// The job was cancelled or its deadline passed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the job was stopped before its end")]
pub struct Interrupted;

impl Progress {
    /// A job that must end by `deadline`.
    pub fn until(deadline: Instant) -> Self {
        Self { deadline: Some(deadline), ..Self::default() }
    }

    /// Asks the job to stop soon.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Whether the job should stop.
    pub fn is_over(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed) || self.deadline.is_some_and(|d| Instant::now() > d)
    }

    /// Share of the slow work that is done, in [0, 1].
    pub fn fraction(&self) -> f64 {
        let total = self.total.load(Ordering::Relaxed).max(1);
        (self.done.load(Ordering::Relaxed) as f64 / total as f64).min(1.0)
    }

    pub(crate) fn start(&self, total: usize) {
        self.done.store(0, Ordering::Relaxed);
        self.total.store(total, Ordering::Relaxed);
    }

    pub(crate) fn advance(&self) {
        self.done.fetch_add(1, Ordering::Relaxed);
    }
}

/// Renders on the CPU. One of it is enough for a process; it may be shared between threads.
#[derive(Debug, Default)]
pub struct Renderer {
    cpu: crate::cpu::Cpu,
}

impl Renderer {
    /// Where frames are made, for the header `Fog-Backend`.
    pub fn backend(&self) -> &'static str {
        "cpu"
    }

    /// Renders one layer of a frame. `samples` of 1 or `None` traces pixel centres only.
    ///
    /// # Errors
    /// [`Interrupted`] when `progress` says so.
    pub fn render(
        &self,
        scene: &CheckedScene,
        view: &View,
        progress: &Progress,
    ) -> Result<Frame, Interrupted> {
        self.cpu.render(scene, view, progress)
    }

    /// Evaluates rays in f64, no blob left out.
    ///
    /// # Errors
    /// [`Interrupted`] when `progress` says so.
    pub fn probe(
        &self,
        scene: &CheckedScene,
        rays: &[ProbeRay],
        progress: &Progress,
    ) -> Result<Vec<RayAnswer>, Interrupted> {
        self.cpu.probe(scene, rays, progress)
    }
}
