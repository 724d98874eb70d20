//! The renderer: what turns a checked scene into frames and numbers, on the GPU where there is one.

use crate::cpu::Cpu;
pub use crate::frame::Frame;
use crate::gpu::{Failure, Gpu, Wanted};
use crate::probe::RayAnswer;
pub use crate::progress::{Interrupted, Progress};
use crate::request::{ProbeRay, View};
use crate::scene::CheckedScene;
use crate::selftest::{self, BackendReport};
use crate::shapes::Geometry;
use std::collections::VecDeque;
use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

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
    /// What works on the processor.
    pub(crate) fn cpu(&self) -> &Cpu {
        &self.cpu
    }

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

    /// The surfaces of a scene, as frames and probes meet them.
    ///
    /// # Errors
    /// [`Interrupted`] when `progress` says so.
    pub fn surfaces(
        &self,
        scene: &CheckedScene,
        progress: &Progress,
    ) -> Result<Arc<Geometry>, Interrupted> {
        self.cpu.cache.geometry(scene, progress)
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
