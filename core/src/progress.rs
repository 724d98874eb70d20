//! How far a job is, and whether it should go on: below everything that takes its time.

use std::cell::Cell;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Instant;

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
}
