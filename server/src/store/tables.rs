//! What one transaction does for a record, and what is read back of a scene.

use super::history::History;
use super::record::{Change, Head, Heading, Record, Row};
use super::room::State;
use super::vault::{CHANGES, FIRST_REVISION, KEYS, NUMBERS, REVISIONS, SCENES, SNAPSHOTS, STROKES};
use fogbank_core::json::document::{Node, closed};
use fogbank_core::scene::{self, Scene};
use redb::{
    ReadTransaction, ReadableTable, ReadableTableMetadata, TableDefinition, WriteTransaction,
};
use serde::de::DeserializeOwned;
use std::ops::RangeInclusive;
use std::sync::Arc;

/// Revisions that a scene's history names.
const HISTORY: u64 = 10_000;

/// Bytes of changes that it names; the newest one is always there.
const HISTORY_BYTES: u64 = 128 << 20;

/// Changes since a snapshot that are applied when a scene is read: so many that a snapshot is rarely written, so
/// few that reading them takes no longer than reading it.
const CHANGES_SINCE: u64 = 1000;
const BYTES_SINCE: u64 = 1 << 20;

/// A whole scene as it was read, or why it could not be.
type Read<T> = Result<T, redb::Error>;

/// Reads JSON that this program wrote.
fn parsed<T: DeserializeOwned>(bytes: &[u8]) -> Read<T> {
    serde_json::from_slice(bytes).map_err(|error| redb::Error::Corrupted(error.to_string()))
}

fn text(value: &impl serde::Serialize) -> Vec<u8> {
    serde_json::to_vec(value).unwrap_or_default()
}

/// What became of a record in its transaction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It is written.
    Written,
    /// It was made from a revision that was lost: nothing is written of it.
    Stale,
}

/// Writes a record.
pub fn write(transaction: &WriteTransaction, record: &Record) -> Read<Outcome> {
    let id = record.id.as_str();
    let mut scenes = transaction.open_table(SCENES)?;
    let row = row_in(&scenes, id)?;
    if row.map(|row| row.revision) != record.base {
        return Ok(Outcome::Stale);
    }
    let (revision, bytes) = (record.head.revision, record.change.len() as u64);
    let mut row = row.unwrap_or(Row { oldest: revision, ..Row::default() });
    row.revision = revision;
    row.at_ms = record.heading.at_ms;
    row.history_bytes += bytes;
    row.bytes_since += bytes;
    transaction.open_table(REVISIONS)?.insert((id, revision), text(&record.heading).as_slice())?;
    transaction.open_table(CHANGES)?.insert((id, revision), record.change.as_slice())?;
    if let Some(key) = &record.heading.key {
        transaction.open_table(KEYS)?.insert((id, key.as_str()), (revision, record.digest))?;
    }
    transaction.open_table(STROKES)?.insert(id, text(&record.strokes).as_slice())?;
    let is_far = revision - row.snapshot > CHANGES_SINCE
        || row.bytes_since > row.snapshot_bytes.max(BYTES_SINCE);
    if record.base.is_none() || is_far {
        let snapshot = text(&*record.head.scene);
        transaction.open_table(SNAPSHOTS)?.insert(id, snapshot.as_slice())?;
        row.snapshot = revision;
        row.snapshot_bytes = snapshot.len() as u64;
        row.bytes_since = 0;
    }
    trim(transaction, id, &mut row)?;
    scenes.insert(id, text(&row).as_slice())?;
    Ok(Outcome::Written)
}

/// Lets go of the oldest revisions of a history that is too long, but for what the snapshot still needs.
fn trim(transaction: &WriteTransaction, id: &str, row: &mut Row) -> Read<()> {
    let (mut revisions, mut changes, mut keys) = (
        transaction.open_table(REVISIONS)?,
        transaction.open_table(CHANGES)?,
        transaction.open_table(KEYS)?,
    );
    let is_long =
        |row: &Row| row.revision - row.oldest >= HISTORY || row.history_bytes > HISTORY_BYTES;
    while is_long(row) && row.oldest < row.revision && row.oldest <= row.snapshot {
        if let Some(heading) = revisions.remove((id, row.oldest))?
            && let Some(key) = parsed::<Heading>(heading.value())?.key
        {
            keys.remove((id, key.as_str()))?;
        }
        if let Some(change) = changes.remove((id, row.oldest))? {
            row.history_bytes = row.history_bytes.saturating_sub(change.value().len() as u64);
        }
        row.oldest += 1;
    }
    Ok(())
}

/// Takes a scene away, if its newest revision is that one. Of its keys that of this request stays, until the next scene of
/// that id goes.
pub fn delete(
    transaction: &WriteTransaction,
    id: &str,
    base: u64,
    key: Option<&(String, u64)>,
) -> Read<Outcome> {
    let mut scenes = transaction.open_table(SCENES)?;
    if row_in(&scenes, id)?.map(|row| row.revision) != Some(base) {
        return Ok(Outcome::Stale);
    }
    scenes.remove(id)?;
    transaction.open_table(SNAPSHOTS)?.remove(id)?;
    transaction.open_table(STROKES)?.remove(id)?;
    transaction.open_table(REVISIONS)?.retain_in((id, 0)..=(id, u64::MAX), |_, _| false)?;
    transaction.open_table(CHANGES)?.retain_in((id, 0)..=(id, u64::MAX), |_, _| false)?;
    let after = format!("{id}\0");
    let mut keys = transaction.open_table(KEYS)?;
    keys.retain_in((id, "")..(after.as_str(), ""), |_, _| false)?;
    if let Some((name, digest)) = key {
        keys.insert((id, name.as_str()), (base, *digest))?;
    }
    let mut numbers = transaction.open_table(NUMBERS)?;
    let first = numbers.get(FIRST_REVISION)?.map_or(1, |number| number.value());
    numbers.insert(FIRST_REVISION, first.max(base + 2))?;
    Ok(Outcome::Written)
}

/// The first revision of a scene that is new.
pub fn first_revision(transaction: &ReadTransaction) -> Read<u64> {
    let numbers = transaction.open_table(NUMBERS)?;
    Ok(numbers.get(FIRST_REVISION)?.map_or(1, |number| number.value()))
}

/// What is known of all scenes, by id.
pub fn list(transaction: &ReadTransaction) -> Read<Vec<(String, Row)>> {
    let scenes = transaction.open_table(SCENES)?;
    let each = scenes.iter()?.map(|entry| {
        let (id, row) = entry?;
        Ok((id.value().to_owned(), parsed(row.value())?))
    });
    each.collect()
}

/// How many scenes there are.
pub fn count(transaction: &ReadTransaction) -> Read<u64> {
    Ok(transaction.open_table(SCENES)?.len()?)
}

/// What is known of a scene.
pub fn row(transaction: &ReadTransaction, id: &str) -> Read<Option<Row>> {
    row_in(&transaction.open_table(SCENES)?, id)
}

fn row_in(scenes: &impl ReadableTable<&'static str, &'static [u8]>, id: &str) -> Read<Option<Row>> {
    let row = scenes.get(id)?;
    row.map(|row| parsed(row.value())).transpose()
}

/// Headings of a scene's revisions from one to another, in order.
pub fn headings(
    transaction: &ReadTransaction,
    id: &str,
    revisions: RangeInclusive<u64>,
) -> Read<Vec<Heading>> {
    of_revisions(transaction, REVISIONS, id, revisions)
}

/// Changes of a scene's revisions from one to another, in order.
pub fn changes(
    transaction: &ReadTransaction,
    id: &str,
    revisions: RangeInclusive<u64>,
) -> Read<Vec<Change>> {
    of_revisions(transaction, CHANGES, id, revisions)
}

fn of_revisions<T: DeserializeOwned>(
    transaction: &ReadTransaction,
    table: TableDefinition<(&'static str, u64), &'static [u8]>,
    id: &str,
    revisions: RangeInclusive<u64>,
) -> Read<Vec<T>> {
    let (first, last) = revisions.into_inner();
    let range = transaction.open_table(table)?.range((id, first)..=(id, last))?;
    range.map(|entry| parsed(entry?.1.value())).collect()
}

/// The revision that a request with this key made, and the digest of that request.
pub fn keyed(transaction: &ReadTransaction, id: &str, key: &str) -> Read<Option<(u64, u64)>> {
    let keys = transaction.open_table(KEYS)?;
    Ok(keys.get((id, key))?.map(|entry| entry.value()))
}

/// All that the next write of a scene begins with.
pub fn state(transaction: &ReadTransaction, id: &str) -> Read<State> {
    let mut state = State::default();
    let Some(row) = row(transaction, id)? else { return Ok(state) };
    state.head =
        Some(Arc::new(Head { revision: row.revision, scene: scene(transaction, id, &row)? }));
    state.history = History::of(&headings(transaction, id, row.oldest..=row.revision)?);
    state.history.forget_before(row.oldest);
    if let Some(strokes) = transaction.open_table(STROKES)?.get(id)? {
        state.strokes = parsed(strokes.value())?;
    }
    Ok(state)
}

/// The snapshot, and what changed since.
fn scene(transaction: &ReadTransaction, id: &str, row: &Row) -> Read<scene::CheckedScene> {
    let wrong = |what: &str| redb::Error::Corrupted(format!("scene {id}: {what}"));
    let snapshots = transaction.open_table(SNAPSHOTS)?;
    let snapshot = snapshots.get(id)?.ok_or_else(|| wrong("its snapshot is missing"))?;
    let snapshot = scene::read::<Scene>(snapshot.value()).map_err(|e| wrong(&e.to_string()))?;
    let mut document = Node::kept(&snapshot);
    for change in changes(transaction, id, row.snapshot + 1..=row.revision)? {
        change.patch.apply(&mut document).map_err(|problem| wrong(&problem.detail))?;
    }
    let first = |problems: Vec<scene::Problem>| {
        let problem = problems.first();
        wrong(&problem.map_or_else(String::new, |p| format!("{}: {}", p.pointer, p.detail)))
    };
    closed::<Scene>(document).map_err(first)?.check().map_err(first)
}
