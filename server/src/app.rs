//! What all requests share.

use crate::answer::Answers;
use crate::cli::ServeArgs;
use crate::extract::Intake;
use crate::origin::Names;
use crate::queue::Queue;
use crate::store::Store;
use crate::watch::Watch;
use fogbank_core::Renderer;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};
use tokio::sync::{Semaphore, watch};

/// Viewers' frames at a time: while one is encoded another is rendered.
const VIEWERS_TURNS: usize = 2;

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
    /// Makes pictures and numbers, one after the other.
    pub queue: Arc<Queue<Renderer>>,
    /// The renderer, for what takes no turn.
    pub renderer: Arc<Renderer>,
    /// Scenes that live here.
    pub store: Arc<Store>,
    /// Turns of viewers, who wait for them in the order in which they came: so all have the same share of it.
    pub turns: Arc<Semaphore>,
    /// The same for frames that take their time.
    pub long_turns: Arc<Semaphore>,
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
    pub fn start(
        options: ServeArgs,
        store: Store,
        phase: watch::Receiver<Phase>,
    ) -> std::io::Result<Self> {
        let renderer = Renderer::open(options.backend.into()).map_err(std::io::Error::other)?;
        renderer.warm_up();
        let renderer = Arc::new(renderer);
        let parsers = std::thread::available_parallelism().map_or(1, usize::from);
        Ok(Self {
            has_fallen_back: renderer.fallback(),
            queue: Arc::new(Queue::start(options.queue, Arc::clone(&renderer))?),
            renderer,
            turns: Arc::new(Semaphore::new(VIEWERS_TURNS)),
            long_turns: Arc::new(Semaphore::new(1)),
            store: Arc::new(store),
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
