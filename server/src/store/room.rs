//! A scene in use: what readers are shown, and what the next write begins with.
//!
//! A write is made in memory under the scene's lock and handed to the writer in that order; readers see it when it is
//! durable. So many writes of a scene are made durable together, and none is seen that could be lost.

use super::history::History;
use super::presets;
use super::record::{Change, Head, Record};
use fogbank_core::edit::Strokes;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::watch;

/// A scene in use.
pub struct Room {
    /// Its id.
    pub id: String,
    /// What is durable, or else the preset of that name; none once the scene is deleted.
    pub shown: watch::Sender<Option<Arc<Head>>>,
    /// What there is where nothing is stored.
    preset: Option<Arc<Head>>,
    /// How many look at it.
    pub viewers: watch::Sender<usize>,
    /// What the next write begins with; none where it must be read from the database first.
    state: Mutex<Option<State>>,
    /// Whether that is worth nothing any more.
    lost: AtomicBool,
}

/// Newest revisions that are kept at hand, and bytes of what they changed: as many as may wait to be durable.
const RECENT: usize = 512;
const RECENT_BYTES: usize = 32 << 20;

/// What a write begins with.
#[derive(Default)]
pub struct State {
    /// The newest revision, durable or not; none if there is no such scene.
    pub head: Option<Arc<Head>>,
    /// What can be undone, and done again.
    pub history: History,
    /// Strokes that may go on.
    pub strokes: Strokes,
    /// The newest revisions, some of which are not durable yet.
    pub recent: VecDeque<Recent>,
    /// The least revision that the scene may have if it comes anew.
    pub first: u64,
}

/// A revision that was made not long ago.
pub struct Recent {
    /// Its number.
    pub revision: u64,
    /// The key of the request that made it, and what a repeated one must agree in.
    pub key: Option<(String, u64)>,
    /// What it changed.
    pub change: Arc<Change>,
    /// Size of that as text.
    bytes: usize,
}

impl State {
    /// Goes on from a write that was made.
    pub fn accept(&mut self, record: &Record, change: Change) {
        self.head = Some(Arc::clone(&record.head));
        self.history.add(&record.heading);
        self.strokes = record.strokes.clone();
        self.recent.push_back(Recent {
            revision: record.head.revision,
            key: record.heading.key.clone().map(|key| (key, record.digest)),
            change: Arc::new(change),
            bytes: record.change.len(),
        });
        let bytes = |recent: &VecDeque<Recent>| recent.iter().map(|one| one.bytes).sum::<usize>();
        while self.recent.len() > 1
            && (self.recent.len() > RECENT || bytes(&self.recent) > RECENT_BYTES)
        {
            self.recent.pop_front();
        }
    }
}

impl Room {
    /// Of a scene as it is in the database.
    pub fn new(id: &str, state: State) -> Self {
        let preset = presets::head(id);
        let shown = watch::Sender::new(state.head.clone().or_else(|| preset.clone()));
        Self {
            id: id.to_owned(),
            shown,
            preset,
            viewers: watch::Sender::new(0),
            state: Mutex::new(Some(state)),
            lost: AtomicBool::new(false),
        }
    }

    /// What the next write begins with: nobody else writes meanwhile.
    pub fn state(&self) -> MutexGuard<'_, Option<State>> {
        // A write that panicked has not been put there.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What is durable.
    pub fn head(&self) -> Option<Arc<Head>> {
        self.shown.borrow().clone()
    }

    /// Whether a preset has this name.
    pub fn is_preset(&self) -> bool {
        self.preset.is_some()
    }

    /// What was made in memory could not be made durable: the next write reads what is. Nobody is waited for here,
    /// however long the present one takes.
    pub fn forget(&self) {
        self.lost.store(true, Ordering::SeqCst);
    }

    /// Whether it was to be forgotten since the last time.
    pub fn was_lost(&self) -> bool {
        self.lost.swap(false, Ordering::SeqCst)
    }

    /// Shows what is durable, if that is another revision: a write that failed may be there all the same.
    pub fn show(&self, head: Option<Arc<Head>>) {
        let head = head.or_else(|| self.preset.clone());
        let revision = |head: &Option<Arc<Head>>| head.as_ref().map(|head| head.revision);
        self.shown.send_if_modified(|shown| {
            let is_other = revision(shown) != revision(&head);
            if is_other {
                *shown = head;
            }
            is_other
        });
    }
}
