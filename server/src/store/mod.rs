//! Scenes that live on the server: revisions, history, and what makes both durable.
//!
//! `record` says what is written, `tables` how, `vault` where; `room` is a scene in use, `history` what of it can be
//! undone; `writer` is the one thread that writes.

mod history;
mod memory;
pub mod presets;
pub mod record;
mod room;
mod tables;
#[cfg(test)]
mod tests;
mod vault;
mod writer;

pub use room::Room;
pub use vault::Failure;

use fogbank_core::edit::Strokes;
use fogbank_core::json::document::{Node, Patch, closed, difference};
use fogbank_core::scene::{CheckedScene, Problem as Wrong, Scene};
use record::{Change, Head, Heading, Kind, Record, Row};
use room::State;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use tokio::sync::oneshot;
use vault::Vault;
use writer::{Order, Task, Writer};

/// Scenes in use that are kept in memory; whoever comes back to an older one waits until it is read again.
const ROOMS: usize = 64;

/// How long a repeated request waits for the first one to be durable.
const TO_BE_SHOWN: Duration = Duration::from_secs(10);

/// Bytes of changes that may wait to be written.
const WAITING_BYTES: usize = 256 << 20;

/// Scenes that may be stored: their rows are listed as a whole.
const SCENES: u64 = 10_000;

/// Why a write was not made, or a read.
#[derive(Clone, Debug)]
pub enum Refusal {
    /// There is no such scene.
    Missing,
    /// It is a preset, which stays as it is.
    Preset,
    /// It is not at the revision that the client expects.
    Precondition {
        /// What it is at, if it exists.
        revision: Option<u64>,
    },
    /// The scene has moved on from the revision that blobs are named at.
    MovedOn(u64),
    /// What would come of it is not valid.
    Invalid(Vec<Wrong>),
    /// There is nothing to undo, or to do again.
    Nothing(&'static str),
    /// Another request had this key.
    KeyReused,
    /// There is no room for more.
    Full,
    /// There are as many scenes as may be.
    TooMany,
    /// A write that this one was made from was lost.
    Lost,
    /// Too much waits to be written.
    Busy,
    /// It took too long.
    Late,
    /// Something broke.
    Failed(String),
}

/// What a client expects of a scene before it writes.
#[derive(Clone, Debug, Default)]
pub struct Condition {
    /// One of these revisions; none if any will do.
    pub if_match: Option<Vec<u64>>,
    /// That it exists.
    pub must_exist: bool,
    /// That it does not exist.
    pub must_be_new: bool,
}

/// Which request it is, if it may be repeated.
#[derive(Clone, Debug)]
pub struct Key {
    /// The client's name for it.
    pub name: String,
    /// What a repeated one must agree in.
    pub digest: u64,
}

/// What a write came to.
#[derive(Clone, Debug)]
pub struct Written {
    /// The revision that it made.
    pub revision: u64,
    /// What it changed.
    pub patch: Patch,
    /// Whether the scene is new.
    pub is_new: bool,
}

/// What a write makes of a scene.
pub struct Made {
    /// The scene.
    pub scene: CheckedScene,
    /// What kind of write it is.
    pub kind: Kind,
    /// The operations of its edits.
    pub ops: Vec<String>,
    /// The stroke that it belongs to.
    pub stroke: Option<String>,
    /// Strokes that may go on then.
    pub strokes: Strokes,
    /// What it reverts, or does again.
    of: Option<[u64; 2]>,
}

impl Made {
    /// A scene that was put, or patched.
    pub fn whole(scene: CheckedScene, kind: Kind) -> Self {
        Self { scene, kind, ops: Vec::new(), stroke: None, strokes: Strokes::default(), of: None }
    }

    /// What edits made.
    pub fn edited(
        scene: CheckedScene,
        ops: Vec<String>,
        stroke: Option<String>,
        strokes: Strokes,
    ) -> Self {
        Self { scene, kind: Kind::Edit, ops, stroke, strokes, of: None }
    }
}

/// All stored scenes.
pub struct Store {
    vault: Arc<Vault>,
    /// The one used last stands at the end.
    rooms: Mutex<Vec<Arc<Room>>>,
    writer: Writer,
    /// Bytes that wait to be written.
    waiting: Arc<AtomicUsize>,
}

impl Store {
    /// Those in a directory, or new ones in memory.
    ///
    /// # Errors
    /// When the directory cannot be used.
    pub fn open(directory: Option<&Path>) -> Result<Self, Failure> {
        Self::of(Vault::open(directory)?)
    }

    fn of(vault: Vault) -> Result<Self, Failure> {
        let vault = Arc::new(vault);
        let waiting = Arc::new(AtomicUsize::new(0));
        let writer = Writer::start(Arc::clone(&vault), Arc::clone(&waiting));
        let writer = writer.map_err(|error| Failure::Other(error.to_string()))?;
        Ok(Self { vault, rooms: Mutex::default(), writer, waiting })
    }

    /// A scene, durable or just being made; it may not exist.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn room(&self, id: &str) -> Result<Arc<Room>, Refusal> {
        if let Some(room) = self.open_room(id, None) {
            return Ok(room);
        }
        // Read without the lock: others go on meanwhile.
        let state = self.vault.read(|transaction| tables::state(transaction, id))?;
        let room = self.open_room(id, Some(Arc::new(Room::new(id, state))));
        room.ok_or_else(|| Refusal::Failed("a scene was not kept".into()))
    }

    /// The room that is open, or else `new`.
    fn open_room(&self, id: &str, new: Option<Arc<Room>>) -> Option<Arc<Room>> {
        let mut rooms = self.rooms.lock().unwrap_or_else(PoisonError::into_inner);
        let room = match rooms.iter().position(|room| room.id == id) {
            Some(at) => rooms.remove(at),
            None => new?,
        };
        rooms.push(Arc::clone(&room));
        // Whoever is used elsewhere must stay the only one of its scene.
        let is_idle = |room: &Arc<Room>| Arc::strong_count(room) == 1;
        while rooms.len() > ROOMS
            && let Some(at) = rooms.iter().position(is_idle)
        {
            rooms.remove(at);
        }
        Some(room)
    }

    /// The scene as it is durable.
    ///
    /// # Errors
    /// When there is none, or it cannot be read.
    pub fn head(&self, id: &str) -> Result<Arc<Head>, Refusal> {
        self.room(id)?.head().ok_or(Refusal::Missing)
    }

    /// All scenes, by id.
    ///
    /// # Errors
    /// When they cannot be read.
    pub fn list(&self) -> Result<Vec<(String, Row)>, Refusal> {
        Ok(self.vault.read(tables::list)?)
    }

    /// Headings of a scene's newest revisions before one, the newest first; and what can be undone and done again.
    ///
    /// # Errors
    /// When there is none, or it cannot be read.
    pub fn history(
        &self,
        id: &str,
        before: u64,
        most: u64,
    ) -> Result<(Vec<Heading>, [bool; 2]), Refusal> {
        let read = self.vault.read(|transaction| {
            let Some(row) = tables::row(transaction, id)? else { return Ok(None) };
            let last = row.revision.min(before.saturating_sub(1));
            let first = row.oldest.max((last + 1).saturating_sub(most));
            let mut headings = Vec::new();
            if first <= last {
                headings = tables::headings(transaction, id, first..=last)?;
            }
            headings.reverse();
            Ok(Some(headings))
        })?;
        let room = self.room(id)?;
        // Of a preset there is none.
        room.head().ok_or(Refusal::Missing)?;
        let headings = read.unwrap_or_default();
        let mut guard = room.state();
        let state = self.state(&room, &mut guard)?;
        let can = [state.history.to_undo().is_some(), state.history.to_redo().is_some()];
        Ok((headings, can))
    }

    /// What a scene's revisions behind one changed, in one patch.
    ///
    /// # Errors
    /// When history does not reach back so far, or cannot be read.
    pub fn changes_since(&self, id: &str, revision: u64, to: u64) -> Result<Patch, Refusal> {
        let revisions = revision + 1..=to;
        let changes = self.vault.read(|transaction| tables::changes(transaction, id, revisions))?;
        if changes.len() as u64 != to - revision {
            return Err(Refusal::Missing);
        }
        Ok(Patch(changes.into_iter().flat_map(|change| change.patch.0).collect()))
    }

    /// What the next write begins with, read again where it was forgotten.
    fn state<'a>(
        &self,
        room: &Room,
        state: &'a mut Option<State>,
    ) -> Result<&'a mut State, Refusal> {
        if room.was_lost() {
            *state = None;
        }
        if state.is_none() {
            let read = self.vault.read(|transaction| tables::state(transaction, &room.id))?;
            room.show(read.head.clone());
            *state = Some(read);
        }
        state.as_mut().ok_or_else(|| Refusal::Failed("a scene was not read".into()))
    }

    /// Makes a write: in memory now, durable when what is returned ends.
    ///
    /// # Errors
    /// Why it is not made.
    pub fn write(
        &self,
        id: &str,
        condition: &Condition,
        key: Option<Key>,
        make: impl FnOnce(Option<&Head>, Strokes) -> Result<Made, Refusal>,
    ) -> Result<Writing, Refusal> {
        self.write_with(id, condition, key, |state| {
            make(state.head.as_deref(), state.strokes.clone())
        })
    }

    /// Reverts the newest revision that is not reverted yet, with all of its stroke; or does again what was
    /// reverted last.
    ///
    /// # Errors
    /// That there is none, or why it is not made.
    pub fn turn(
        &self,
        id: &str,
        condition: &Condition,
        key: Option<Key>,
        kind: Kind,
    ) -> Result<Writing, Refusal> {
        let is_undo = kind == Kind::Undo;
        self.write_with(id, condition, key, |state| {
            let head = state.head.as_ref().ok_or(Refusal::Missing)?;
            let group = if is_undo { state.history.to_undo() } else { state.history.to_redo() };
            let what =
                if is_undo { "there is nothing to undo" } else { "there is nothing to do again" };
            let [first, last] = group.ok_or(Refusal::Nothing(what))?;
            let mut changes = self.changes(id, state, first, last)?;
            let mut document = Node::kept(&*head.scene);
            if is_undo {
                changes.reverse();
            }
            for change in changes {
                let patch = if is_undo { change.inverse } else { change.patch };
                let wrong = |problem: Wrong| Refusal::Failed(problem.detail);
                patch.apply(&mut document).map_err(wrong)?;
            }
            let scene = closed(document).and_then(|scene: Scene| scene.check_after(&head.scene));
            let scene = scene.map_err(Refusal::Invalid)?;
            Ok(Made { of: Some([first, last]), ..Made::whole(scene, kind) })
        })
    }

    /// Changes of some revisions, the newest of which may not be durable yet.
    fn changes(
        &self,
        id: &str,
        state: &State,
        first: u64,
        last: u64,
    ) -> Result<Vec<Change>, Refusal> {
        let gone = Refusal::Nothing("history does not reach back so far");
        let (oldest, durable) = self.vault.read(|transaction| {
            let row = tables::row(transaction, id)?;
            let changes = tables::changes(transaction, id, first..=last)?;
            Ok((row.map_or(0, |row| row.oldest), changes))
        })?;
        if first < oldest {
            return Err(gone);
        }
        let known = durable.len() as u64;
        let missing = first + known..=last;
        let rest = state.recent.iter().filter(|recent| missing.contains(&recent.revision));
        let rest = rest.map(|recent| (*recent.change).clone());
        let changes: Vec<_> = durable.into_iter().chain(rest).collect();
        let is_whole = changes.len() as u64 == last + 1 - first;
        if is_whole { Ok(changes) } else { Err(gone) }
    }

    fn write_with(
        &self,
        id: &str,
        condition: &Condition,
        key: Option<Key>,
        make: impl FnOnce(&State) -> Result<Made, Refusal>,
    ) -> Result<Writing, Refusal> {
        let room = self.room(id)?;
        let mut guard = room.state();
        let state = self.state(&room, &mut guard)?;
        if let Some(repeated) = self.repeated(&room, state, key.as_ref())? {
            return Ok(repeated);
        }
        let revision = state.head.as_ref().map(|head| head.revision);
        condition.check(revision)?;
        if self.waiting.load(Ordering::Relaxed) > WAITING_BYTES {
            return Err(Refusal::Busy);
        }
        let made = make(state).map_err(|refusal| match refusal {
            Refusal::Missing if room.is_preset() => Refusal::Preset,
            other => other,
        })?;
        let (before, revision) = match &state.head {
            Some(head) => (Some(&head.scene), head.revision + 1),
            None => (None, self.new_revision()?.max(state.first)),
        };
        let change = match before {
            Some(before) => Change {
                patch: difference(&**before, &*made.scene),
                inverse: difference(&*made.scene, &**before),
            },
            // A new scene comes from nowhere, and cannot be undone.
            None => Change::default(),
        };
        let record = record(&room, state, made, (revision, &change), key);
        let written = Written { revision, patch: change.patch.clone(), is_new: before.is_none() };
        state.accept(&record, change);
        self.waiting.fetch_add(record.change.len(), Ordering::Relaxed);
        let (done, is_done) = oneshot::channel();
        let order = Order { room: Arc::clone(&room), task: Task::Write(Box::new(record)), done };
        self.writer.take(order)?;
        drop(guard);
        Ok(Writing { written, room, wait: Wait::Done(is_done) })
    }

    /// What a request with this key made before.
    fn repeated(
        &self,
        room: &Arc<Room>,
        state: &State,
        key: Option<&Key>,
    ) -> Result<Option<Writing>, Refusal> {
        let Some(Key { name, digest }) = key else { return Ok(None) };
        let has_it =
            |recent: &&room::Recent| recent.key.as_ref().is_some_and(|(key, _)| key == name);
        let known = match state.recent.iter().find(has_it) {
            // It may not be durable yet.
            Some(room::Recent { revision, key: Some((_, digest)), .. }) => {
                Some((*revision, *digest, Wait::Shown))
            }
            _ => {
                let keyed = self.vault.read(|read| tables::keyed(read, &room.id, name))?;
                keyed.map(|(revision, digest)| (revision, digest, Wait::Nothing))
            }
        };
        let Some((revision, known, wait)) = known else { return Ok(None) };
        if known != *digest {
            return Err(Refusal::KeyReused);
        }
        let patch = self.changes(&room.id, state, revision, revision)?;
        let patch = patch.into_iter().next().map(|change| change.patch).unwrap_or_default();
        let written = Written { revision, patch, is_new: false };
        Ok(Some(Writing { written, room: Arc::clone(room), wait }))
    }

    fn new_revision(&self) -> Result<u64, Refusal> {
        let (count, first) = self.vault.read(|transaction| {
            Ok((tables::count(transaction)?, tables::first_revision(transaction)?))
        })?;
        if count < SCENES { Ok(first) } else { Err(Refusal::TooMany) }
    }

    /// Takes a scene away.
    ///
    /// # Errors
    /// Why it stays.
    pub fn delete(
        &self,
        id: &str,
        condition: &Condition,
        key: Option<Key>,
    ) -> Result<Writing, Refusal> {
        let room = self.room(id)?;
        let mut guard = room.state();
        let state = self.state(&room, &mut guard)?;
        if let Some(Key { name, digest }) = &key
            && let Some((revision, known)) =
                self.vault.read(|read| tables::keyed(read, id, name))?
        {
            if known != *digest {
                return Err(Refusal::KeyReused);
            }
            let written = Written { revision, patch: Patch::default(), is_new: false };
            drop(guard);
            return Ok(Writing { written, room, wait: Wait::Nothing });
        }
        let revision = state.head.as_ref().map(|head| head.revision);
        condition.check(revision)?;
        let base = revision.ok_or(Refusal::Missing)?;
        // A scene that comes again begins behind this one, also before that is written; and one revision is left out, so
        // that nobody takes what it begins with for a change of this one.
        *state = State { first: base + 2, ..State::default() };
        let (done, is_done) = oneshot::channel();
        let key = key.map(|Key { name, digest }| (name, digest));
        let order = Order { room: Arc::clone(&room), task: Task::Delete(base, key), done };
        self.writer.take(order)?;
        drop(guard);
        let written = Written { revision: base, patch: Patch::default(), is_new: false };
        Ok(Writing { written, room, wait: Wait::Done(is_done) })
    }
}

/// The record of a write.
fn record(
    room: &Room,
    state: &State,
    made: Made,
    (revision, change): (u64, &Change),
    key: Option<Key>,
) -> Record {
    let is_new = state.head.is_none();
    let (name, digest) = key.map_or((None, 0), |key| (Some(key.name), key.digest));
    let heading = Heading {
        revision,
        at_ms: now_ms(),
        kind: if is_new { Kind::Create } else { made.kind },
        ops: made.ops,
        stroke: made.stroke,
        of: made.of,
        key: name,
    };
    Record {
        id: room.id.clone(),
        base: state.head.as_ref().map(|head| head.revision),
        head: Arc::new(Head { revision, scene: made.scene }),
        heading,
        change: serde_json::to_vec(change).unwrap_or_default(),
        digest,
        strokes: made.strokes,
    }
}

fn now_ms() -> u64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    since.as_millis() as u64
}

impl Condition {
    fn check(&self, revision: Option<u64>) -> Result<(), Refusal> {
        let unmet = Err(Refusal::Precondition { revision });
        match revision {
            Some(_) if self.must_be_new => unmet,
            Some(own) if self.if_match.as_ref().is_some_and(|all| !all.contains(&own)) => unmet,
            None if self.must_exist || self.if_match.is_some() => unmet,
            _ => Ok(()),
        }
    }
}

/// A write that was made in memory.
pub struct Writing {
    written: Written,
    room: Arc<Room>,
    wait: Wait,
}

/// What tells that a write is durable.
enum Wait {
    /// The writer says so.
    Done(oneshot::Receiver<Result<(), Refusal>>),
    /// It is shown.
    Shown,
    /// It was durable before.
    Nothing,
}

impl Writing {
    /// Waits until it is durable.
    ///
    /// # Errors
    /// Why it never will be.
    pub async fn durable(self) -> Result<Written, Refusal> {
        match self.wait {
            Wait::Done(done) => match done.await {
                Ok(result) => result.map(|()| self.written),
                Err(_) => Err(Refusal::Failed("the writer is gone".into())),
            },
            Wait::Shown => {
                let mut shown = self.room.shown.subscribe();
                let revision = self.written.revision;
                let is_there = |head: &Option<Arc<Head>>| {
                    head.as_ref().is_some_and(|head| head.revision >= revision)
                };
                match tokio::time::timeout(TO_BE_SHOWN, shown.wait_for(is_there)).await {
                    Ok(Ok(_)) => Ok(self.written),
                    // The first one was lost: its client was told so, and this one may come again.
                    _ => Err(Refusal::Lost),
                }
            }
            Wait::Nothing => Ok(self.written),
        }
    }
}
