//! Two lanes of jobs in front of one renderer, each with its own bounded line and its own threads.
//!
//! Jobs that look short never wait for those that look long. A job has a place in its lane from
//! the moment it is accepted until its answer is dropped, so that waiting and running jobs and
//! finished frames that are being encoded are bounded together. A job whose caller left, or whose
//! deadline passed, is skipped when it waits and asked to stop when it runs.

use crate::budget::{Budget, Client, Held};
use fogbank_core::{Interrupted, Progress};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::collections::VecDeque;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tokio::sync::oneshot;

/// How long a job that is over may take to notice; longer is a fault that `/readyz` tells.
const TIME_TO_STOP: Duration = Duration::from_secs(2);

/// Workers of the lane for short jobs: a job that takes longer than it looked must not stop the
/// next one.
const SHORT_WORKERS: usize = 2;

/// How long a job looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lane {
    /// A few seconds at most.
    Short,
    /// Perhaps minutes.
    Long,
}

/// Who wants a job done, where and until when.
#[derive(Clone, Debug)]
pub struct Order {
    /// Which lane it takes.
    pub lane: Lane,
    /// Who asks.
    pub client: Client,
    /// When it must be done.
    pub deadline: Instant,
    /// How far it is: whoever keeps a copy can follow it.
    pub progress: Arc<Progress>,
}

impl Order {
    /// An order that nobody follows yet.
    pub fn new(lane: Lane, client: Client, deadline: Instant) -> Self {
        Self { lane, client, deadline, progress: Arc::new(Progress::until(deadline)) }
    }
}

/// Both lanes in front of a worker `W` that their threads share.
pub struct Queue<W> {
    short: Arc<Line<W>>,
    long: Arc<Line<W>>,
    threads: Vec<JoinHandle<()>>,
}

/// What a job came to.
pub struct Done<T> {
    /// Its result.
    pub value: T,
    /// How long it waited before it ran.
    pub waited: Duration,
    /// Its place in the lane: given back when this is dropped.
    pub place: Held,
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

/// The jobs of one lane.
struct Line<W> {
    jobs: Mutex<Jobs<W>>,
    changed: Condvar,
    places: Budget,
}

struct Jobs<W> {
    waiting: VecDeque<Job<W>>,
    /// One a worker.
    running: Vec<Option<Watched>>,
    /// Whose job was begun last.
    served: Option<Client>,
    closed: bool,
}

type Work<W> = Box<dyn FnOnce(&W) + Send>;

struct Job<W> {
    client: Client,
    watched: Watched,
    work: Work<W>,
}

/// What tells whether a job is still wanted, and since when not.
#[derive(Clone)]
struct Watched {
    progress: Arc<Progress>,
    deadline: Instant,
    left: Arc<OnceLock<Instant>>,
}

impl Watched {
    /// How long nobody has wanted it.
    fn overdue(&self) -> Duration {
        let end = self.left.get().map_or(self.deadline, |left| self.deadline.min(*left));
        end.elapsed()
    }
}

/// Cancels a job when its caller is gone.
struct Caller(Watched);

impl Drop for Caller {
    fn drop(&mut self) {
        self.0.left.get_or_init(Instant::now);
        self.0.progress.cancel();
    }
}

impl<W: Send + Sync + 'static> Queue<W> {
    /// Starts the threads that share `worker`; in each lane `waiting` jobs may wait while one runs.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn start(waiting: usize, worker: Arc<W>) -> io::Result<Self> {
        Self::with_workers(waiting, SHORT_WORKERS, worker)
    }

    fn with_workers(waiting: usize, short_workers: usize, worker: Arc<W>) -> io::Result<Self> {
        let (short, long) = (Line::new(waiting, short_workers), Line::new(waiting, 1));
        let mut threads = Vec::new();
        for (line, name, workers) in [(&short, "short", short_workers), (&long, "long", 1)] {
            for seat in 0..workers {
                threads.push(begin(Arc::clone(line), seat, name, Arc::clone(&worker))?);
            }
        }
        Ok(Self { short, long, threads })
    }

    /// Whether all workers still take jobs.
    pub fn is_alive(&self) -> bool {
        self.threads.iter().all(|thread| !thread.is_finished())
    }

    /// For how long the longest overdue job has been over and still runs, if that is too long.
    pub fn overdue(&self) -> Option<Duration> {
        let longest = self.short.overdue().max(self.long.overdue());
        longest.filter(|overdue| *overdue > TIME_TO_STOP)
    }

    /// Runs `work` when its turn comes.
    ///
    /// # Errors
    /// [`Refusal`] when there is no place, the deadline passes or the work panics.
    pub async fn run<T: Send + 'static>(
        &self,
        order: Order,
        work: impl FnOnce(&W, &Progress) -> Result<T, Interrupted> + Send + 'static,
    ) -> Result<Done<T>, Refusal> {
        let Order { lane, client, deadline, progress } = order;
        let line = match lane {
            Lane::Short => &self.short,
            Lane::Long => &self.long,
        };
        let place = line.places.take(client, 1).map_err(|_| Refusal::Busy)?;
        let watched = Watched { progress, deadline, left: Arc::default() };
        let _caller = Caller(watched.clone());
        let (reply, answer) = oneshot::channel();
        let (accepted, running) = (Instant::now(), Arc::clone(&watched.progress));
        let work = Box::new(move |worker: &W| {
            let waited = accepted.elapsed();
            running.begin();
            let result = catch_unwind(AssertUnwindSafe(|| work(worker, &running)));
            // Nobody listens any more when the caller left; that is fine.
            let _ = reply.send((result, waited));
        });
        line.push(Job { client, watched, work });
        match tokio::time::timeout_at(deadline.into(), answer).await {
            Ok(Ok((Ok(Ok(value)), waited))) => Ok(Done { value, waited, place }),
            Ok(Ok((Err(_panic), _))) => Err(Refusal::Broken),
            // Interrupted, skipped or still running: the caller is here, so it was the deadline.
            Ok(Ok((Ok(Err(Interrupted)), _)) | Err(_)) | Err(_) => Err(Refusal::Late),
        }
    }
}

/// Starts a worker's thread. Its jobs spread over a pool of its own: in a pool that lanes share, a
/// job's pieces would wait until those of a longer one run out.
fn begin<W: Send + Sync + 'static>(
    line: Arc<Line<W>>,
    seat: usize,
    name: &str,
    worker: Arc<W>,
) -> io::Result<JoinHandle<()>> {
    let pool_name = name.to_owned();
    let pool = ThreadPoolBuilder::new().thread_name(move |i| format!("{pool_name}-{seat}-{i}"));
    let pool = pool.build().map_err(io::Error::other)?;
    let work = move || line.serve(seat, &worker, &pool);
    std::thread::Builder::new().name(format!("{name}-{seat}")).spawn(work)
}

impl<W> Drop for Queue<W> {
    fn drop(&mut self) {
        for line in [&self.short, &self.long] {
            line.lock().closed = true;
            line.changed.notify_all();
        }
    }
}

impl<W> Line<W> {
    /// One client may hold all places but one.
    fn new(waiting: usize, workers: usize) -> Arc<Self> {
        let jobs = Jobs {
            waiting: VecDeque::new(),
            running: vec![None; workers],
            served: None,
            closed: false,
        };
        let places = Budget::new(waiting + workers, waiting + workers - 1);
        Arc::new(Self { jobs: Mutex::new(jobs), changed: Condvar::new(), places })
    }

    fn lock(&self) -> MutexGuard<'_, Jobs<W>> {
        // No job runs under the lock, so a poisoned line is still in order.
        self.jobs.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a job, and forgets those that nobody waits for: they must not hold their scenes.
    fn push(&self, job: Job<W>) {
        let mut jobs = self.lock();
        jobs.waiting.retain(|job| !job.watched.progress.is_over());
        jobs.waiting.push_back(job);
        drop(jobs);
        self.changed.notify_one();
    }

    /// Does job after job until the queue is gone.
    fn serve(&self, seat: usize, worker: &W, pool: &ThreadPool)
    where
        W: Sync,
    {
        while let Some(work) = self.next(seat) {
            pool.install(|| work(worker));
            self.lock().running[seat] = None;
        }
    }

    /// Waits for a job that somebody still wants; `None` when the queue is gone.
    fn next(&self, seat: usize) -> Option<Work<W>> {
        let mut jobs = self.lock();
        loop {
            while let Some(job) = jobs.pop() {
                if !job.watched.progress.is_over() {
                    jobs.running[seat] = Some(job.watched);
                    jobs.served = Some(job.client);
                    return Some(job.work);
                }
            }
            if jobs.closed {
                return None;
            }
            jobs = self.changed.wait(jobs).unwrap_or_else(PoisonError::into_inner);
        }
    }

    fn overdue(&self) -> Option<Duration> {
        let jobs = self.lock();
        jobs.running.iter().flatten().map(Watched::overdue).max()
    }
}

impl<W> Jobs<W> {
    /// The oldest job of another client than the one served last, else the oldest: whoever asks
    /// for much gets every other turn at most.
    fn pop(&mut self) -> Option<Job<W>> {
        let other = self.waiting.iter().position(|job| Some(job.client) != self.served);
        self.waiting.remove(other.unwrap_or(0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::IpAddr;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::sync::mpsc;
    use std::task::Poll;

    fn queue(waiting: usize) -> Arc<Queue<u32>> {
        Arc::new(Queue::with_workers(waiting, 1, Arc::new(7)).unwrap())
    }

    fn client(number: u8) -> Client {
        IpAddr::from([10, 0, 0, number]).into()
    }

    fn order(number: u8) -> Order {
        let later = Instant::now() + Duration::from_secs(60);
        Order::new(Lane::Short, client(number), later)
    }

    fn until(deadline: Instant) -> Order {
        Order::new(Lane::Short, Client::default(), deadline)
    }

    async fn is_pending(future: &mut std::pin::Pin<Box<impl Future>>) -> bool {
        std::future::poll_fn(|cx| Poll::Ready(future.as_mut().poll(cx).is_pending())).await
    }

    /// A job that runs until the returned sender is used or dropped; it has begun already.
    async fn occupy(
        queue: &Arc<Queue<u32>>,
        order: Order,
    ) -> (mpsc::Sender<()>, tokio::task::JoinHandle<()>) {
        let (release, gate) = mpsc::channel::<()>();
        let (began, begun) = oneshot::channel();
        let queue = Arc::clone(queue);
        let running = tokio::spawn(async move {
            let work = move |_: &u32, _: &Progress| {
                began.send(()).unwrap();
                let _ = gate.recv();
                Ok(())
            };
            queue.run(order, work).await.map(drop).unwrap();
        });
        begun.await.unwrap();
        (release, running)
    }

    #[tokio::test]
    async fn a_job_sees_the_worker() {
        let done = queue(1).run(order(1), |worker, _| Ok(*worker + 1)).await;
        assert_eq!(done.ok().map(|done| done.value), Some(8));
    }

    #[tokio::test]
    async fn a_full_queue_is_busy_until_a_place_is_given_back() {
        let queue = queue(1);
        let (release, running) = occupy(&queue, order(1)).await;
        let mut waiting = Box::pin(queue.run(order(2), |_, _| Ok(())));
        assert!(is_pending(&mut waiting).await);
        let refused = queue.run(order(3), |_, _| Ok(())).await.map(|done| done.value);
        assert_eq!(refused, Err(Refusal::Busy));
        drop(release);
        running.await.unwrap();
        let held = waiting.await.ok().map(|done| done.place);
        assert!(held.is_some());
        assert!(queue.run(order(4), |_, _| Ok(())).await.is_ok());
    }

    #[tokio::test]
    async fn one_client_leaves_a_place_to_others() {
        let queue = queue(2);
        let (release, running) = occupy(&queue, order(1)).await;
        let mut waiting = Box::pin(queue.run(order(1), |_, _| Ok(())));
        assert!(is_pending(&mut waiting).await);
        let refused = queue.run(order(1), |_, _| Ok(())).await.map(|done| done.value);
        assert_eq!(refused, Err(Refusal::Busy));
        let mut other = Box::pin(queue.run(order(2), |_, _| Ok(())));
        assert!(is_pending(&mut other).await);
        drop(release);
        running.await.unwrap();
        assert!(other.await.is_ok());
    }

    #[tokio::test]
    async fn clients_take_turns() {
        let queue = queue(8);
        let (release, running) = occupy(&queue, order(1)).await;
        let ran = Arc::new(Mutex::new(Vec::new()));
        let mut jobs = Vec::new();
        for number in [1, 1, 1, 2, 3] {
            let ran = Arc::clone(&ran);
            let work = move |_: &u32, _: &Progress| {
                ran.lock().unwrap().push(number);
                Ok(())
            };
            let mut job = Box::pin(queue.run(order(number), work));
            assert!(is_pending(&mut job).await);
            jobs.push(job);
        }
        drop(release);
        running.await.unwrap();
        for job in jobs {
            assert!(job.await.is_ok());
        }
        assert_eq!(*ran.lock().unwrap(), [2, 1, 3, 1, 1]);
    }

    #[tokio::test]
    async fn short_jobs_do_not_wait_for_long_ones() {
        let queue = queue(1);
        let long = Order { lane: Lane::Long, ..order(1) };
        let (release, running) = occupy(&queue, long).await;
        assert!(queue.run(order(1), |_, _| Ok(())).await.is_ok());
        drop(release);
        running.await.unwrap();
    }

    #[tokio::test]
    async fn a_job_whose_caller_left_is_skipped() {
        let queue = queue(4);
        let (release, running) = occupy(&queue, order(1)).await;
        let ran = Arc::new(AtomicBool::new(false));
        let witness = Arc::clone(&ran);
        let mut left = Box::pin(queue.run(order(1), move |_, _| {
            witness.store(true, Ordering::SeqCst);
            Ok(())
        }));
        assert!(is_pending(&mut left).await);
        drop(left);
        drop(release);
        running.await.unwrap();
        // One worker, one line: when a later job is done, an earlier one is behind us.
        assert!(queue.run(order(1), |_, _| Ok(())).await.is_ok());
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
        let job = tokio::spawn(async move { runner.run(order(1), work).await.map(drop) });
        begun.await.unwrap();
        job.abort();
        assert!(has_stopped.await.is_ok());
    }

    #[tokio::test]
    async fn the_deadline_holds_for_waiting_and_for_running_jobs() {
        let queue = queue(2);
        let late = queue.run(until(Instant::now()), |_, _| Ok(())).await.map(|done| done.value);
        assert_eq!(late, Err(Refusal::Late));
        let endless = |_: &u32, progress: &Progress| -> Result<(), Interrupted> {
            while !progress.is_over() {
                std::thread::yield_now();
            }
            Err(Interrupted)
        };
        let soon = until(Instant::now() + Duration::from_millis(20));
        let late = queue.run(soon, endless).await.map(|done| done.value);
        assert_eq!(late, Err(Refusal::Late));
    }

    #[tokio::test]
    async fn a_job_that_runs_on_when_it_is_over_is_told_of() {
        let queue = queue(1);
        assert_eq!(queue.overdue(), None);
        let (release, gate) = mpsc::channel::<()>();
        let (began, begun) = oneshot::channel();
        let runner = Arc::clone(&queue);
        let deaf = tokio::spawn(async move {
            let work = move |_: &u32, _: &Progress| {
                began.send(()).unwrap();
                let _ = gate.recv();
                Ok(())
            };
            runner.run(order(1), work).await.map(drop)
        });
        begun.await.unwrap();
        assert_eq!(queue.overdue(), None);
        deaf.abort();
        while queue.overdue().is_none() {
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
        assert!(queue.overdue().unwrap() > TIME_TO_STOP);
        drop(release);
        assert!(queue.run(order(1), |_, _| Ok(())).await.is_ok());
        assert_eq!(queue.overdue(), None);
    }

    #[tokio::test]
    async fn a_panic_breaks_one_job_and_no_other() {
        let queue = queue(2);
        let work = |_: &u32, _: &Progress| -> Result<(), Interrupted> { panic!("on purpose") };
        let broken = queue.run(order(1), work).await.map(|done| done.value);
        assert_eq!(broken, Err(Refusal::Broken));
        assert!(queue.run(order(1), |_, _| Ok(())).await.is_ok());
    }
}
