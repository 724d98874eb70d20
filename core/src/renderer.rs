//! The renderer: what turns a checked scene into frames and numbers, on the GPU where there is one.

use crate::cpu::Cpu;
use crate::gpu::{Failure, Gpu, Wanted};
use crate::probe::RayAnswer;
use crate::request::{Layer, ProbeRay, View};
use crate::scene::{Camera, CheckedScene};
use crate::selftest::{self, BackendReport};
use std::collections::VecDeque;
use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
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
    /// Where it is seen from.
    pub camera: Camera,
    /// `[height][width][layer.channels()]`, top row first; empty if the frame is `shown`.
    pub pixels: Vec<f32>,
    /// What a screen shows, `[height][width][3]` in sRGB, where the backend has formed that.
    pub shown: Option<Vec<u8>>,
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
    begun: AtomicBool,
    course: Mutex<Course>,
}

/// A job's way from 0 to 1: a stretch of it for each frame, and in that a part for each slow pass.
#[derive(Debug)]
struct Course {
    /// Where the frame begins and ends.
    stretch: [f64; 2],
    /// Where its present pass begins and ends.
    pass: [f64; 2],
    /// Steps of that pass, done and in all.
    steps: [usize; 2],
}

impl Default for Course {
    fn default() -> Self {
        Self { stretch: [0.0, 1.0], pass: [0.0; 2], steps: [0; 2] }
    }
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

    /// Says that the job no longer waits.
    pub fn begin(&self) {
        self.begun.store(true, Ordering::Relaxed);
    }

    /// Whether the job no longer waits.
    pub fn has_begun(&self) -> bool {
        self.begun.load(Ordering::Relaxed)
    }

    /// Share of the slow work that is done, in [0, 1].
    pub fn fraction(&self) -> f64 {
        let Course { pass: [from, to], steps: [done, all], .. } = *self.course();
        from + (to - from) * (done as f64 / all.max(1) as f64).min(1.0)
    }

    /// The next frame takes the job from one fraction to another.
    pub(crate) fn stretch(&self, from: f64, to: f64) {
        *self.course() = Course { stretch: [from, to], pass: [from; 2], steps: [0; 2] };
    }

    /// A pass of so many steps begins, that `share` of what the frame has still to do.
    pub(crate) fn start(&self, steps: usize, share: f64) {
        let mut course = self.course();
        let ([begin, end], [_, reached]) = (course.stretch, course.pass);
        // Frames that nobody gave a stretch, as in a self-test, each take the whole.
        let from = if reached < end { reached } else { begin };
        course.pass = [from, from + share * (end - from)];
        course.steps = [0, steps];
    }

    pub(crate) fn advance(&self) {
        self.course().steps[0] += 1;
    }

    fn course(&self) -> MutexGuard<'_, Course> {
        // Numbers are never left half written.
        self.course.lock().unwrap_or_else(PoisonError::into_inner)
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
/// threads, whose frames do not wait for each other.
#[derive(Debug, Default)]
pub struct Renderer {
    cpu: Cpu,
    gpu: Option<Slot>,
}

/// A device that may have to be opened anew.
#[derive(Debug)]
struct Slot {
    open: Opener,
    device: Mutex<Opened>,
    /// Whether the CPU has taken over.
    fallen_back: Arc<AtomicBool>,
}

#[derive(Debug)]
struct Opened {
    gpu: Option<Arc<Gpu>>,
    /// When it was opened anew.
    reopened: VecDeque<Instant>,
}

/// Opens a device.
struct Opener(Box<dyn Fn() -> Result<Gpu, Failure> + Send + Sync>);

impl fmt::Debug for Opener {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Opener")
    }
}

/// How often a device is opened anew within [`PERIOD`]; after that the CPU takes over.
const REOPENINGS: usize = 3;
const PERIOD: Duration = Duration::from_secs(600);

impl Slot {
    fn opened(&self) -> MutexGuard<'_, Opened> {
        self.device.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn gpu(&self) -> Option<Arc<Gpu>> {
        self.opened().gpu.clone()
    }

    /// What the device makes of a job, on a fresh one if this one fails; `None` leaves it to the CPU.
    fn run(&self, job: impl Fn(&Gpu) -> Result<Option<Frame>, Failure>) -> Option<Frame> {
        for _ in 0..2 {
            let gpu = self.gpu()?;
            match job(&gpu) {
                Ok(frame) => return frame,
                // Less memory than the job takes is no fault of the device's, and an interruption
                // is noticed again by the CPU.
                Err(Failure::Memory(_) | Failure::Interrupted) => return None,
                Err(failure) => self.replace(&gpu, &failure),
            }
        }
        None
    }

    /// Opens the device anew, unless another thread has done so.
    fn replace(&self, failed: &Arc<Gpu>, failure: &Failure) {
        if *failure == Failure::Silent {
            failed.abandon();
        }
        let mut opened = self.opened();
        if !opened.gpu.as_ref().is_some_and(|gpu| Arc::ptr_eq(gpu, failed)) {
            return;
        }
        tracing::warn!("{}: {failure}", failed.name());
        opened.gpu = None;
        opened.reopened.retain(|then| then.elapsed() < PERIOD);
        if opened.reopened.len() < REOPENINGS {
            opened.reopened.push_back(Instant::now());
            opened.gpu = (self.open.0)().ok().map(Arc::new);
        }
        self.fallen_back.store(opened.gpu.is_none(), Ordering::Relaxed);
    }
}

impl Renderer {
    /// A renderer on that backend.
    ///
    /// # Errors
    /// Where a GPU is asked for and there is none.
    pub fn open(backend: Backend) -> Result<Self, Failure> {
        match backend {
            Backend::Cpu => Ok(Self::default()),
            Backend::Gpu => Self::on(|| Gpu::open(Wanted::Any)),
            Backend::Auto => Ok(Self::on(|| Gpu::open(Wanted::Hardware)).unwrap_or_default()),
        }
    }

    /// A renderer on a device, which is opened anew where it fails.
    ///
    /// # Errors
    /// Where it cannot be opened.
    pub fn on(
        open: impl Fn() -> Result<Gpu, Failure> + Send + Sync + 'static,
    ) -> Result<Self, Failure> {
        let opened = Opened { gpu: Some(Arc::new(open()?)), reopened: VecDeque::new() };
        let slot = Slot {
            open: Opener(Box::new(open)),
            device: Mutex::new(opened),
            fallen_back: Arc::default(),
        };
        Ok(Self { cpu: Cpu::default(), gpu: Some(slot) })
    }

    /// What frames are made on now.
    pub fn backend(&self) -> &'static str {
        if self.gpu().is_some() { "gpu" } else { "cpu" }
    }

    /// Makes the device ready for frames, so that the first does not wait for its shaders.
    pub fn warm_up(&self) {
        let Some(gpu) = self.gpu() else { return };
        if let Err(failure) = gpu.warm_up() {
            // The frame that needs it will find that out, too, and get another device.
            tracing::warn!("{}: {failure}", gpu.name());
        }
    }

    /// Becomes true when the CPU has to take over from a GPU that failed again and again.
    pub fn fallback(&self) -> Arc<AtomicBool> {
        self.gpu.as_ref().map(|slot| Arc::clone(&slot.fallen_back)).unwrap_or_default()
    }

    /// What both backends make of a few scenes, against the f64 maths.
    ///
    /// # Errors
    /// [`Interrupted`] when `progress` says so.
    pub fn selftest(&self, progress: &Progress) -> Result<Vec<BackendReport>, Interrupted> {
        let mut reports = vec![selftest::of_cpu(&self.cpu, progress)?];
        if let Some(gpu) = self.gpu() {
            reports.push(selftest::of_gpu(&gpu, &self.cpu, progress)?);
        }
        Ok(reports)
    }

    /// The device, if there is one.
    pub(crate) fn gpu(&self) -> Option<Arc<Gpu>> {
        self.gpu.as_ref().and_then(Slot::gpu)
    }

    /// Forgets how often the device was opened anew.
    #[cfg(test)]
    pub(crate) fn forgive(&self) {
        self.gpu.iter().for_each(|slot| slot.opened().reopened.clear());
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
        let frame = self.gpu.as_ref().and_then(|slot| slot.run(job));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_job_of_two_frames_goes_from_0_to_1_and_never_back() {
        let progress = Progress::default();
        let mut seen = vec![progress.fraction()];
        let mut pass = |steps: usize, share: f64| {
            progress.start(steps, share);
            for _ in 0..steps {
                progress.advance();
                seen.push(progress.fraction());
            }
        };
        progress.stretch(0.0, 0.25);
        pass(5, 1.0);
        progress.stretch(0.25, 1.0);
        pass(4, 0.5);
        pass(10, 1.0);
        assert!(seen.is_sorted_by(|a, b| a < b), "{seen:?}");
        assert_eq!([seen[0], seen[5], seen[9], seen[19]], [0.0, 0.25, 0.625, 1.0]);
    }
}
