//! The renderer: what turns a checked scene into frames and numbers, on the GPU where there is one.

use crate::cpu::Cpu;
use crate::gpu::{Failure, Gpu, Wanted};
use crate::probe::RayAnswer;
use crate::request::{Layer, ProbeRay, View};
use crate::scene::CheckedScene;
use crate::selftest::{self, BackendReport};
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
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
    /// Where it was made: `cpu` or `gpu`.
    pub backend: &'static str,
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

/// Which backend frames are made on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Backend {
    /// A GPU, else the CPU.
    #[default]
    Auto,
    /// The CPU.
    Cpu,
    /// A GPU, be it one in software.
    Gpu,
}

/// Renders on one of the backends. One of it is enough for a process; it may be shared between
/// threads.
#[derive(Debug, Default)]
pub struct Renderer {
    cpu: Cpu,
    gpu: Option<Mutex<Slot>>,
}

/// A device that may have to be opened anew.
#[derive(Debug)]
struct Slot {
    gpu: Option<Gpu>,
    wanted: Wanted,
    /// When it was opened anew.
    reopened: VecDeque<Instant>,
    /// Whether the CPU has taken over.
    fallen_back: Arc<AtomicBool>,
}

/// How often a device is opened anew within [`PERIOD`]; after that the CPU takes over.
const REOPENINGS: usize = 3;
const PERIOD: Duration = Duration::from_secs(600);

impl Slot {
    /// What the device makes of a job, on a fresh one if this one fails; `None` leaves it to the CPU.
    fn run(&mut self, job: impl Fn(&Gpu) -> Result<Option<Frame>, Failure>) -> Option<Frame> {
        for _ in 0..2 {
            match job(self.gpu.as_ref()?) {
                Ok(frame) => return frame,
                // Less memory than the job takes is no fault of the device's, and an interruption
                // is noticed again by the CPU.
                Err(Failure::Memory(_) | Failure::Interrupted) => return None,
                Err(failure) => self.reopen(&failure),
            }
        }
        None
    }

    fn reopen(&mut self, failure: &Failure) {
        if let Some(gpu) = self.gpu.take() {
            tracing::warn!("{}: {failure}", gpu.name());
            gpu.abandon();
        }
        self.reopened.retain(|then| then.elapsed() < PERIOD);
        if self.reopened.len() < REOPENINGS {
            self.reopened.push_back(Instant::now());
            self.gpu = Gpu::open(self.wanted).ok();
        }
        self.fallen_back.store(self.gpu.is_none(), Ordering::Relaxed);
    }
}

impl Renderer {
    /// A renderer on that backend.
    ///
    /// # Errors
    /// Where a GPU is asked for and there is none.
    pub fn open(backend: Backend) -> Result<Self, Failure> {
        let wanted = match backend {
            Backend::Cpu => return Ok(Self::default()),
            Backend::Auto => Wanted::Hardware,
            Backend::Gpu => Wanted::Any,
        };
        match Gpu::open(wanted) {
            Ok(gpu) => Ok(Self::on(gpu, wanted)),
            Err(_) if backend == Backend::Auto => Ok(Self::default()),
            Err(failure) => Err(failure),
        }
    }

    /// A renderer on a device; where that fails, on another one that will do.
    pub fn on(gpu: Gpu, wanted: Wanted) -> Self {
        let reopened = VecDeque::new();
        let slot = Slot { gpu: Some(gpu), wanted, reopened, fallen_back: Arc::default() };
        Self { cpu: Cpu::default(), gpu: Some(Mutex::new(slot)) }
    }

    /// What frames are made on now.
    pub fn backend(&self) -> &'static str {
        let has_device = |slot: &Mutex<Slot>| Self::lock(slot).gpu.is_some();
        if self.gpu.as_ref().is_some_and(has_device) { "gpu" } else { "cpu" }
    }

    /// Becomes true when the CPU has to take over from a GPU that failed again and again.
    pub fn fallback(&self) -> Arc<AtomicBool> {
        let flag = |slot: &Mutex<Slot>| Arc::clone(&Self::lock(slot).fallen_back);
        self.gpu.as_ref().map(flag).unwrap_or_default()
    }

    /// What both backends make of a few scenes, against the f64 maths.
    ///
    /// # Errors
    /// [`Interrupted`] when `progress` says so.
    pub fn selftest(&self, progress: &Progress) -> Result<Vec<BackendReport>, Interrupted> {
        let mut reports = vec![selftest::of_cpu(&self.cpu, progress)?];
        if let Some(slot) = &self.gpu
            && let Some(gpu) = &Self::lock(slot).gpu
        {
            reports.push(selftest::of_gpu(gpu, &self.cpu, progress)?);
        }
        Ok(reports)
    }

    /// Does something to the device, if there is one.
    #[cfg(test)]
    pub(crate) fn with_gpu(&self, work: impl Fn(&Gpu)) {
        if let Some(slot) = &self.gpu {
            Self::lock(slot).gpu.iter().for_each(work);
        }
    }

    fn lock(slot: &Mutex<Slot>) -> std::sync::MutexGuard<'_, Slot> {
        slot.lock().unwrap_or_else(PoisonError::into_inner)
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
        let job = |gpu: &Gpu| gpu.render(&self.cpu.cache, scene, view, progress);
        let frame = self.gpu.as_ref().and_then(|slot| Self::lock(slot).run(job));
        match frame {
            Some(frame) => Ok(frame),
            None => self.cpu.render(scene, view, progress),
        }
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
