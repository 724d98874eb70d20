//! What all requests share.

use crate::answer::Answers;
use crate::cli::ServeArgs;
use crate::extract::Intake;
use crate::origin::Names;
use crate::queue::Queue;
use crate::watch::Watch;
use fogbank_core::Renderer;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};
use tokio::sync::watch;

/// Where the server is in its life.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd)]
pub enum Phase {
    /// It takes requests.
    Serving,
    /// It takes no new ones, and ends those that it has.
    Draining,
    /// What is not answered now never will be.
    Over,
}

impl Phase {
    /// Waits until this phase has begun.
    pub async fn begun(self, mut told: watch::Receiver<Self>) {
        // Also when the sender is gone: then nobody else will say so.
        let _ = told.wait_for(|now| *now >= self).await;
    }
}

/// What all requests share.
#[derive(Clone)]
pub struct App {
    /// The renderer.
    pub queue: Arc<Queue<Renderer>>,
    /// Jobs that clients may ask about.
    pub watch: Watch,
    /// Reads bodies.
    pub intake: Intake,
    /// What answers may take.
    pub answers: Answers,
    /// By which names clients may call it.
    pub names: Arc<Names>,
    /// Where it is in its life.
    pub phase: watch::Receiver<Phase>,
    /// Whether the CPU had to take over from a GPU.
    pub has_fallen_back: Arc<AtomicBool>,
    /// What the command line chose.
    pub options: Arc<ServeArgs>,
}

impl App {
    /// Starts the renderer; `phase` will tell when to stop.
    ///
    /// # Errors
    /// When there is no such backend, or the system gives it no thread.
    pub fn start(options: ServeArgs, phase: watch::Receiver<Phase>) -> std::io::Result<Self> {
        let renderer = Renderer::open(options.backend.into()).map_err(std::io::Error::other)?;
        renderer.warm_up();
        let parsers = std::thread::available_parallelism().map_or(1, usize::from);
        Ok(Self {
            has_fallen_back: renderer.fallback(),
            queue: Arc::new(Queue::start(options.queue, renderer)?),
            watch: Watch::default(),
            intake: Intake::new(parsers),
            answers: Answers::new(),
            names: Arc::new(Names::new(&options.listen, &options.allow_host)),
            phase,
            options: Arc::new(options),
        })
    }

    /// When a request, accepted now, must be answered; the reference has more time than the others.
    pub fn deadline(&self, is_reference: bool) -> Instant {
        let seconds =
            if is_reference { self.options.reference_deadline_s } else { self.options.deadline_s };
        Instant::now() + Duration::from_secs_f64(seconds)
    }
}
