//! The one owner of the renderer, and the bounded queue in front of it.
//!
//! A job has a place from the moment it is accepted until its answer is dropped, so that waiting
//! and running jobs and finished frames that are being encoded are bounded together. A job whose
//! caller left, or whose deadline passed, is skipped when it waits and asked to stop when it runs.

use fogbank_core::{Interrupted, Progress};
use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tokio::sync::{OwnedSemaphorePermit, Semaphore, oneshot};

/// A queue in front of a worker `W` that lives on a thread of its own.
pub struct Queue<W> {
    shared: Arc<Shared<W>>,
    places: Arc<Semaphore>,
    owner: JoinHandle<()>,
}

/// What a job came to.
pub struct Done<T> {
    /// Its result.
    pub value: T,
    /// How long it waited before it ran.
    pub waited: Duration,
    /// Its place in the queue: given back when this is dropped.
    pub place: OwnedSemaphorePermit,
}

/// Why a job has no result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// All places are taken.
    Busy,
    /// The deadline passed.
    Late,
    /// The job panicked.
    Broken,
}

struct Shared<W> {
    line: Mutex<Line<W>>,
    changed: Condvar,
}

struct Line<W> {
    jobs: VecDeque<Job<W>>,
    closed: bool,
}

struct Job<W> {
    progress: Arc<Progress>,
    work: Box<dyn FnOnce(&W) + Send>,
}

/// Cancels a job when its caller is gone.
struct Caller(Arc<Progress>);

impl Drop for Caller {
    fn drop(&mut self) {
        self.0.cancel();
    }
}

impl<W: Send + 'static> Queue<W> {
    /// Starts the thread that owns `worker`; `waiting` jobs may wait while one runs.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn start(waiting: usize, worker: W) -> std::io::Result<Self> {
        let line = Mutex::new(Line { jobs: VecDeque::new(), closed: false });
        let shared = Arc::new(Shared { line, changed: Condvar::new() });
        let owner = Arc::clone(&shared);
        let owner = std::thread::Builder::new().name("renderer".into()).spawn(move || {
            while let Some(job) = owner.next() {
                (job.work)(&worker);
            }
        })?;
        Ok(Self { shared, places: Arc::new(Semaphore::new(waiting + 1)), owner })
    }

    /// Whether the worker's thread still takes jobs.
    pub fn is_alive(&self) -> bool {
        !self.owner.is_finished()
    }

    /// Runs `work` when its turn comes.
    ///
    /// # Errors
    /// [`Refusal`] when there is no place, the deadline passes or the work panics.
    pub async fn run<T: Send + 'static>(
        &self,
        deadline: Instant,
        work: impl FnOnce(&W, &Progress) -> Result<T, Interrupted> + Send + 'static,
    ) -> Result<Done<T>, Refusal> {
        self.run_watched(Arc::new(Progress::until(deadline)), deadline, work).await
    }

    /// The same, for a job with the same deadline that others watch.
    ///
    /// # Errors
    /// Those of [`Self::run`].
    pub async fn run_watched<T: Send + 'static>(
        &self,
        progress: Arc<Progress>,
        deadline: Instant,
        work: impl FnOnce(&W, &Progress) -> Result<T, Interrupted> + Send + 'static,
    ) -> Result<Done<T>, Refusal> {
        let place = Arc::clone(&self.places).try_acquire_owned().map_err(|_| Refusal::Busy)?;
        let _caller = Caller(Arc::clone(&progress));
        let (reply, answer) = oneshot::channel();
        let (accepted, running) = (Instant::now(), Arc::clone(&progress));
        let work = Box::new(move |worker: &W| {
            let waited = accepted.elapsed();
            running.begin();
            let result = catch_unwind(AssertUnwindSafe(|| work(worker, &running)));
            // Nobody listens any more when the caller left; that is fine.
            let _ = reply.send((result, waited));
        });
        self.shared.push(Job { progress, work });
        match tokio::time::timeout_at(deadline.into(), answer).await {
            Ok(Ok((Ok(Ok(value)), waited))) => Ok(Done { value, waited, place }),
            Ok(Ok((Err(_panic), _))) => Err(Refusal::Broken),
            // Interrupted, skipped or still running: the caller is here, so it was the deadline.
            Ok(Ok((Ok(Err(Interrupted)), _)) | Err(_)) | Err(_) => Err(Refusal::Late),
        }
    }
}

impl<W> Drop for Queue<W> {
    fn drop(&mut self) {
        self.shared.lock().closed = true;
        self.shared.changed.notify_all();
    }
}

impl<W> Shared<W> {
    fn lock(&self) -> MutexGuard<'_, Line<W>> {
        // No job runs under the lock, so a poisoned line is still in order.
        self.line.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a job, and forgets those that nobody waits for: they must not hold their scenes.
    fn push(&self, job: Job<W>) {
        let mut line = self.lock();
        line.jobs.retain(|job| !job.progress.is_over());
        line.jobs.push_back(job);
        drop(line);
        self.changed.notify_one();
    }

    /// Waits for a job that somebody still wants; `None` when the queue is gone.
    fn next(&self) -> Option<Job<W>> {
        let mut line = self.lock();
        loop {
            while let Some(job) = line.jobs.pop_front() {
                if !job.progress.is_over() {
                    return Some(job);
                }
            }
            if line.closed {
                return None;
            }
            line = self.changed.wait(line).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::sync::mpsc;

    fn queue(waiting: usize) -> Arc<Queue<u32>> {
        Arc::new(Queue::start(waiting, 7).unwrap())
    }

    fn later() -> Instant {
        Instant::now() + Duration::from_secs(60)
    }

    /// A job that runs until the returned sender is used or dropped; it has begun already.
    async fn occupy(queue: &Arc<Queue<u32>>) -> (mpsc::Sender<()>, tokio::task::JoinHandle<()>) {
        let (release, gate) = mpsc::channel::<()>();
        let (began, begun) = oneshot::channel();
        let queue = Arc::clone(queue);
        let running = tokio::spawn(async move {
            let work = move |_: &u32, _: &Progress| {
                began.send(()).unwrap();
                let _ = gate.recv();
                Ok(())
            };
            queue.run(later(), work).await.map(drop).unwrap();
        });
        begun.await.unwrap();
        (release, running)
    }

    #[tokio::test]
    async fn a_job_sees_the_worker() {
        let done = queue(1).run(later(), |worker, _| Ok(*worker + 1)).await;
        assert_eq!(done.ok().map(|done| done.value), Some(8));
    }

    #[tokio::test]
    async fn a_full_queue_is_busy_until_a_place_is_given_back() {
        let queue = queue(1);
        let (release, running) = occupy(&queue).await;
        let mut waiting = Box::pin(queue.run(later(), |_, _| Ok(())));
        let poll = std::future::poll_fn(|cx| std::task::Poll::Ready(waiting.as_mut().poll(cx)));
        assert!(poll.await.is_pending());
        let refused = queue.run(later(), |_, _| Ok(())).await.map(|done| done.value);
        assert_eq!(refused, Err(Refusal::Busy));
        drop(release);
        running.await.unwrap();
        let held = waiting.await.ok().map(|done| done.place);
        assert!(held.is_some());
        assert!(queue.run(later(), |_, _| Ok(())).await.is_ok());
    }

    #[tokio::test]
    async fn a_job_whose_caller_left_is_skipped() {
        let queue = queue(4);
        let (release, running) = occupy(&queue).await;
        let ran = Arc::new(AtomicBool::new(false));
        let witness = Arc::clone(&ran);
        let mut left = Box::pin(queue.run(later(), move |_, _| {
            witness.store(true, Ordering::SeqCst);
            Ok(())
        }));
        let poll = std::future::poll_fn(|cx| std::task::Poll::Ready(left.as_mut().poll(cx)));
        assert!(poll.await.is_pending());
        drop(left);
        drop(release);
        running.await.unwrap();
        // One owner, one line: when a later job is done, an earlier one is behind us.
        assert!(queue.run(later(), |_, _| Ok(())).await.is_ok());
        assert!(!ran.load(Ordering::SeqCst));
    }

    #[tokio::test]
    async fn a_running_job_hears_that_its_caller_left() {
        let queue = queue(1);
        let (began, begun) = oneshot::channel();
        let (stopped, has_stopped) = oneshot::channel();
        let work = move |_: &u32, progress: &Progress| -> Result<(), Interrupted> {
            began.send(()).unwrap();
            while !progress.is_over() {
                std::thread::yield_now();
            }
            stopped.send(()).unwrap();
            Err(Interrupted)
        };
        let runner = Arc::clone(&queue);
        let job = tokio::spawn(async move { runner.run(later(), work).await.map(drop) });
        begun.await.unwrap();
        job.abort();
        assert!(has_stopped.await.is_ok());
    }

    #[tokio::test]
    async fn the_deadline_holds_for_waiting_and_for_running_jobs() {
        let queue = queue(2);
        let late = queue.run(Instant::now(), |_, _| Ok(())).await.map(|done| done.value);
        assert_eq!(late, Err(Refusal::Late));
        let endless = |_: &u32, progress: &Progress| -> Result<(), Interrupted> {
            while !progress.is_over() {
                std::thread::yield_now();
            }
            Err(Interrupted)
        };
        let soon = Instant::now() + Duration::from_millis(20);
        let late = queue.run(soon, endless).await.map(|done| done.value);
        assert_eq!(late, Err(Refusal::Late));
    }

    #[tokio::test]
    async fn a_panic_breaks_one_job_and_no_other() {
        let queue = queue(1);
        let work = |_: &u32, _: &Progress| -> Result<(), Interrupted> { panic!("on purpose") };
        let broken = queue.run(later(), work).await.map(|done| done.value);
        assert_eq!(broken, Err(Refusal::Broken));
        assert!(queue.run(later(), |_, _| Ok(())).await.is_ok());
    }
}
