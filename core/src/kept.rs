//! Values that outlive the job that made them, found by what they were made from.
//!
//! A key holds all that its value depends on and compares equal exactly where the value would be the
//! same: large inputs by their address ([`Same`]), the rest by value. So a cache never changes what
//! it caches.

use crate::progress::{Interrupted, Progress};
use std::borrow::Borrow;
use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, Weak};
use std::time::Duration;

/// Names a value by its address. It does not keep the value alive, but no other value gets the
/// address while the name is known.
#[derive(Debug)]
pub struct Same<T>(Weak<T>);

impl<T> Same<T> {
    /// The name of a value.
    pub fn new(value: &Arc<T>) -> Self {
        Self(Arc::downgrade(value))
    }

    /// Whether the value is gone: nothing will ever be named so again.
    pub fn is_gone(&self) -> bool {
        self.0.strong_count() == 0
    }
}

impl<T> Clone for Same<T> {
    fn clone(&self) -> Self {
        Self(Weak::clone(&self.0))
    }
}

impl<T> PartialEq for Same<T> {
    fn eq(&self, other: &Self) -> bool {
        Weak::ptr_eq(&self.0, &other.0)
    }
}

/// The most that is kept; the newest value always is.
#[derive(Clone, Copy, Debug)]
pub struct Most {
    /// Values.
    pub entries: usize,
    /// Bytes of all values and keys together.
    pub bytes: usize,
}

/// The values used last, by key.
#[derive(Debug)]
pub struct Kept<K, V> {
    most: Most,
    bytes: fn(&K, &V) -> usize,
    /// The one used last stands in front.
    entries: Mutex<VecDeque<Entry<K, V>>>,
}

#[derive(Debug)]
struct Entry<K, V> {
    key: K,
    bytes: usize,
    cell: Arc<Making<V>>,
}

impl<K, V> Kept<K, V> {
    /// Keeps at most so much; `bytes` is what a key and its value take and hold.
    pub fn new(most: Most, bytes: fn(&K, &V) -> usize) -> Self {
        Self { most, bytes, entries: Mutex::default() }
    }

    /// The value of a key, made now if it is not there. No lock is held meanwhile: who asks for
    /// other keys goes on, and who asks for this one waits, or makes it if the first is interrupted.
    ///
    /// # Errors
    /// What `make` fails with, or [`Interrupted`] if `progress` ends while another thread makes it.
    pub fn get<Q, E>(
        &self,
        key: &Q,
        progress: &Progress,
        make: impl FnOnce() -> Result<V, E>,
    ) -> Result<Arc<V>, E>
    where
        Q: PartialEq + ToOwned<Owned = K> + ?Sized,
        K: Borrow<Q>,
        E: From<Interrupted>,
    {
        let cell = self.cell(key);
        let (value, is_new) = cell.get(progress, make)?;
        if is_new {
            self.weigh(&cell, &value);
        }
        Ok(value)
    }

    /// The value of a key, if it is there.
    pub fn find(&self, key: &K) -> Option<Arc<V>>
    where
        K: PartialEq,
    {
        let mut entries = lock(&self.entries);
        let at = entries.iter().position(|entry| entry.key == *key)?;
        let value = match &*lock(&entries[at].cell.state) {
            State::Made(value) => Arc::clone(value),
            State::Absent | State::Begun => return None,
        };
        let entry = entries.remove(at)?;
        entries.push_front(entry);
        Some(value)
    }

    /// The value used last of those whose keys are like that.
    pub fn newest(&self, is_like: impl Fn(&K) -> bool) -> Option<Arc<V>> {
        let entries = lock(&self.entries);
        entries.iter().filter(|entry| is_like(&entry.key)).find_map(|entry| {
            match &*lock(&entry.cell.state) {
                State::Made(value) => Some(Arc::clone(value)),
                State::Absent | State::Begun => None,
            }
        })
    }

    /// Keeps a value that was made together with others.
    pub fn put(&self, key: K, value: V) -> Arc<V>
    where
        K: PartialEq + Clone,
    {
        let (cell, value) = (self.cell(&key), Arc::new(value));
        *lock(&cell.state) = State::Made(Arc::clone(&value));
        cell.changed.notify_all();
        self.weigh(&cell, &value);
        value
    }

    /// The place of a key, which is the one used last from now on.
    fn cell<Q>(&self, key: &Q) -> Arc<Making<V>>
    where
        Q: PartialEq + ToOwned<Owned = K> + ?Sized,
        K: Borrow<Q>,
    {
        let mut entries = lock(&self.entries);
        let found = entries.iter().position(|entry| entry.key.borrow() == key);
        let entry = found.and_then(|at| entries.remove(at)).unwrap_or_else(|| Entry {
            key: key.to_owned(),
            bytes: 0,
            cell: Arc::default(),
        });
        let cell = Arc::clone(&entry.cell);
        entries.push_front(entry);
        entries.truncate(self.most.entries);
        cell
    }

    /// Counts what a new value takes, and lets go of those unused for longest that leave no room.
    fn weigh(&self, cell: &Arc<Making<V>>, value: &V) {
        let mut entries = lock(&self.entries);
        if let Some(entry) = entries.iter_mut().find(|entry| Arc::ptr_eq(&entry.cell, cell)) {
            entry.bytes = (self.bytes)(&entry.key, value);
        }
        let mut sum: usize = entries.iter().map(|entry| entry.bytes).sum();
        while sum > self.most.bytes && entries.len() > 1 {
            sum -= entries.pop_back().map_or(0, |entry| entry.bytes);
        }
    }

    /// Lets go of what nobody will ask for any more.
    pub fn forget(&self, is_over: impl Fn(&K) -> bool) {
        lock(&self.entries).retain(|entry| !is_over(&entry.key));
    }

    /// Lets go of all.
    pub fn clear(&self) {
        lock(&self.entries).clear();
    }
}

/// A value that is made by one thread at a time, if any.
#[derive(Debug)]
struct Making<V> {
    state: Mutex<State<V>>,
    changed: Condvar,
}

#[derive(Debug)]
enum State<V> {
    Absent,
    /// Somebody is at it.
    Begun,
    Made(Arc<V>),
}

impl<V> Default for Making<V> {
    fn default() -> Self {
        Self { state: Mutex::new(State::Absent), changed: Condvar::new() }
    }
}

impl<V> Making<V> {
    /// The value, and whether it was made now.
    fn get<E: From<Interrupted>>(
        &self,
        progress: &Progress,
        make: impl FnOnce() -> Result<V, E>,
    ) -> Result<(Arc<V>, bool), E> {
        if let Some(value) = self.wait(progress)? {
            return Ok((value, false));
        }
        // Whatever ends the making, a panic included, somebody else may begin then.
        let mut turn = Turn { cell: self, made: None };
        let value = Arc::new(make()?);
        turn.made = Some(Arc::clone(&value));
        Ok((value, true))
    }

    /// The value when it is made; `None` if it is the caller's turn to make it.
    fn wait(&self, progress: &Progress) -> Result<Option<Arc<V>>, Interrupted> {
        /// How often who waits looks at its own job.
        const LOOK: Duration = Duration::from_millis(20);
        let mut state = lock(&self.state);
        loop {
            match &*state {
                State::Made(value) => return Ok(Some(Arc::clone(value))),
                // A thread of the pool may be the one that makes it, in the midst of other work.
                State::Begun if rayon::current_thread_index().is_none() => {}
                State::Begun | State::Absent => {
                    *state = State::Begun;
                    return Ok(None);
                }
            }
            progress.check()?;
            let waited = self.changed.wait_timeout(state, LOOK);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }
}

/// The right to make a value, given back at the end.
struct Turn<'a, V> {
    cell: &'a Making<V>,
    made: Option<Arc<V>>,
}

impl<V> Drop for Turn<'_, V> {
    fn drop(&mut self) {
        *lock(&self.cell.state) = self.made.take().map_or(State::Absent, State::Made);
        self.cell.changed.notify_all();
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::sync::mpsc;

    type Result<T> = std::result::Result<T, Interrupted>;

    fn kept(entries: usize, bytes: usize) -> Kept<u32, usize> {
        Kept::new(Most { entries, bytes }, |_, value| *value)
    }

    /// The value of a key of that many bytes, and whether it had to be made.
    fn ask(kept: &Kept<u32, usize>, key: u32, bytes: usize) -> bool {
        let mut made = false;
        let make = || -> Result<usize> {
            made = true;
            Ok(bytes)
        };
        kept.get(&key, &Progress::default(), make).unwrap();
        made
    }

    /// What is used stays, however many others come and go.
    #[test]
    fn the_one_unused_for_longest_goes_first() {
        for kept in [kept(3, usize::MAX), kept(usize::MAX, 30)] {
            assert!(ask(&kept, 0, 10));
            for key in 1..20 {
                assert!(ask(&kept, key, 10));
                assert!(!ask(&kept, 0, 10), "0 went when {key} came");
            }
            assert!(ask(&kept, 1, 10), "1 is long gone");
        }
    }

    /// One that alone is too large is kept until the next.
    #[test]
    fn the_newest_is_always_kept() {
        let kept = kept(3, 30);
        assert!(ask(&kept, 0, 100) && !ask(&kept, 0, 100));
        assert!(ask(&kept, 1, 1) && !ask(&kept, 1, 1));
        assert!(ask(&kept, 0, 100));
    }

    /// An interrupted making leaves nothing behind, and nobody waits for it.
    #[test]
    fn what_was_interrupted_is_made_anew() {
        let kept = kept(3, 30);
        let interrupted = kept.get(&0, &Progress::default(), || Err(Interrupted));
        assert_eq!(interrupted, Err(Interrupted));
        assert!(ask(&kept, 0, 10));
    }

    /// A panic neither.
    #[test]
    fn what_panicked_is_made_anew() {
        let kept = kept(3, 30);
        let make = || -> Result<usize> { panic!("on purpose") };
        let panics = || drop(kept.get(&0, &Progress::default(), make));
        assert!(std::panic::catch_unwind(std::panic::AssertUnwindSafe(panics)).is_err());
        assert!(ask(&kept, 0, 10));
    }

    /// While one value is made others are asked for, even by its maker.
    #[test]
    fn no_lock_is_held_meanwhile() {
        let kept = kept(3, 30);
        let make = || -> Result<usize> {
            assert!(ask(&kept, 1, 10));
            Ok(5)
        };
        assert_eq!(kept.get(&0, &Progress::default(), make).map(|value| *value), Ok(5));
    }

    /// Who comes second waits for the first; when that one gives up it is the second's turn; and a
    /// job that is over does not wait any longer.
    #[test]
    fn only_one_makes_a_value_at_a_time() {
        let (kept, made) = (kept(3, 30), AtomicUsize::new(0));
        let (begun, is_begun) = mpsc::channel();
        let (finish, is_finished) = mpsc::channel::<()>();
        std::thread::scope(|scope| {
            let (kept, made) = (&kept, &made);
            scope.spawn(move || {
                let make = || -> Result<usize> {
                    begun.send(()).unwrap();
                    is_finished.recv().unwrap();
                    Err(Interrupted)
                };
                assert_eq!(kept.get(&0, &Progress::default(), make), Err(Interrupted));
            });
            is_begun.recv().unwrap();
            let over = Progress::default();
            over.cancel();
            assert_eq!(kept.get(&0, &over, || Ok(7)), Err(Interrupted));
            let second = scope.spawn(move || {
                let make = || -> Result<usize> { Ok(made.fetch_add(1, Ordering::Relaxed) + 1) };
                kept.get(&0, &Progress::default(), make).map(|value| *value)
            });
            finish.send(()).unwrap();
            assert_eq!(second.join().unwrap(), Ok(1));
        });
        assert!(!ask(&kept, 0, 1));
    }

    /// Equal values at two places are two names; a name outlives its value and is never reused.
    #[test]
    fn names_are_addresses() {
        let (a, b) = (Arc::new(1), Arc::new(1));
        assert!(Same::new(&a) == Same::new(&a) && Same::new(&a) != Same::new(&b));
        let name = Same::new(&a);
        drop(a);
        assert!((0..100).all(|_| Same::new(&Arc::new(1)) != name));
    }
}
