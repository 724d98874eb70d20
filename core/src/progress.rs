//! How far a job is, and whether it should go on: below everything that takes its time.

use fearless_simd::Level;
use std::cell::Cell;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// What work is done with.
#[derive(Clone, Copy, Debug)]
pub struct Job<'a> {
    /// SIMD of this machine.
    pub level: Level,
    /// Whether to go on.
    pub progress: &'a Progress,
}

impl<'a> Job<'a> {
    /// A job on this machine.
    pub fn new(progress: &'a Progress) -> Self {
        Self { level: Level::new(), progress }
    }
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

    /// Whether the job should stop; once it should, it always should.
    pub fn is_over(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed) || self.deadline.is_some_and(|d| Instant::now() > d)
    }

    /// Whether the job may go on.
    ///
    /// # Errors
    /// [`Interrupted`] when it should stop.
    pub fn check(&self) -> Result<(), Interrupted> {
        if self.is_over() { Err(Interrupted) } else { Ok(()) }
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

    /// From where to where the present frame takes the job.
    pub(crate) fn frame(&self) -> [f64; 2] {
        self.course().stretch
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

/// Looks at a job's progress every so many steps, where a step takes less than the look.
#[derive(Debug)]
pub(crate) struct Watch<'a> {
    progress: &'a Progress,
    /// Steps until the next look.
    left: Cell<usize>,
    over: Cell<bool>,
}

impl<'a> Watch<'a> {
    /// Steps between two looks: a step takes up to 100 ns, so a millisecond or two.
    const STEPS: usize = 1 << 14;

    /// Of a job.
    pub fn new(progress: &'a Progress) -> Self {
        Self { progress, left: Cell::new(0), over: Cell::new(false) }
    }

    /// Whether so many more steps may be taken.
    #[inline]
    pub fn allows(&self, steps: usize) -> bool {
        match self.left.get().checked_sub(steps) {
            Some(left) => self.left.set(left),
            None => {
                self.left.set(Self::STEPS);
                self.over.set(self.progress.is_over());
            }
        }
        !self.over.get()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Between two looks nothing is noticed; from the next one on the job stays over.
    #[test]
    fn a_watch_notices_the_end_at_its_next_look() {
        let progress = Progress::default();
        let watch = Watch::new(&progress);
        assert!(watch.allows(1));
        progress.cancel();
        assert!(watch.allows(Watch::STEPS));
        assert!(!watch.allows(1) && !watch.allows(1));
    }

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
