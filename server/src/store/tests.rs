//! What the store promises: what it answered is there, whole, whatever happened to what it writes on.

use super::memory::Memory;
use super::*;
use fogbank_core::scene::Scene;
use redb::StorageBackend;
use std::io::{self, ErrorKind};
use std::sync::atomic::AtomicU64;

fn scene(value: &serde_json::Value) -> CheckedScene {
    let mut scene = fogbank_core::scene::read::<Scene>(value.to_string().as_bytes()).unwrap();
    scene.name_all();
    scene.check().unwrap()
}

/// A scene that says which write it was.
fn numbered(number: u64) -> CheckedScene {
    scene(&serde_json::json!({"far_m": number + 1, "lights": [{"kind": "point"}]}))
}

fn number(scene: &CheckedScene) -> u64 {
    scene.far_m as u64 - 1
}

fn put(store: &Store, id: &str, number: u64) -> Result<Written, Refusal> {
    put_if(store, id, number, &Condition::default(), None)
}

fn put_if(
    store: &Store,
    id: &str,
    number: u64,
    condition: &Condition,
    key: Option<Key>,
) -> Result<Written, Refusal> {
    let make = |_: Option<&Head>, _| Ok(Made::whole(numbered(number), Kind::Put));
    wait(store.write(id, condition, key, make)?)
}

fn wait(writing: Writing) -> Result<Written, Refusal> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build().unwrap();
    runtime.block_on(writing.durable())
}

/// Adds a light of that brightness, as an edit of a scene that may be large.
fn add_light(store: &Store, id: &str, stroke: Option<&str>) -> Result<Written, Refusal> {
    let make = |head: Option<&Head>, strokes| {
        let head = head.ok_or(Refusal::Missing)?;
        let mut after = (*head.scene).clone();
        after.far_m += 1.0;
        let after = after.check_after(&head.scene).unwrap();
        Ok(Made::edited(after, vec!["patch".into()], stroke.map(str::to_owned), strokes))
    };
    wait(store.write(id, &Condition::default(), None, make)?)
}

/// Bytes that were written at a place.
type Piece = (u64, Vec<u8>);

/// Bytes that fail from some write on: that one is torn in the middle, and nothing comes through behind it. What was not
/// synced is lost but for every other write, as after a power cut.
#[derive(Clone, Debug)]
struct Faulty {
    durable: Memory,
    seen: Memory,
    left: Arc<AtomicU64>,
    unsynced: Arc<Mutex<Vec<Piece>>>,
}

impl Faulty {
    fn new(durable: Memory, left: u64) -> Self {
        let seen = durable.copied();
        Self { durable, seen, left: Arc::new(left.into()), unsynced: Arc::default() }
    }

    fn step(&self) -> io::Result<()> {
        let left = self.left.load(Ordering::SeqCst);
        if left == 0 {
            return Err(ErrorKind::StorageFull.into());
        }
        self.left.store(left - 1, Ordering::SeqCst);
        Ok(())
    }

    /// What is found after the power is back.
    fn after_the_cut(&self) -> Memory {
        for (i, (offset, data)) in self.unsynced.lock().unwrap().iter().enumerate() {
            if i % 2 == 0 {
                // Disks write sectors whole.
                let torn = &data[..(data.len() / 2) & !511];
                let _ = self.durable.write(*offset, torn);
            }
        }
        self.durable.clone()
    }
}

impl StorageBackend for Faulty {
    fn len(&self) -> io::Result<u64> {
        self.seen.len()
    }

    fn read(&self, offset: u64, out: &mut [u8]) -> io::Result<()> {
        self.seen.read(offset, out)
    }

    fn set_len(&self, length: u64) -> io::Result<()> {
        self.step()?;
        self.seen.set_len(length)?;
        // A longer file is longer at once; a shorter one would lose what was not synced.
        if length > self.durable.len()? { self.durable.set_len(length) } else { Ok(()) }
    }

    fn sync_data(&self) -> io::Result<()> {
        self.step()?;
        for (offset, data) in self.unsynced.lock().unwrap().drain(..) {
            self.durable.write(offset, &data)?;
        }
        self.durable.set_len(self.seen.len()?)
    }

    fn write(&self, offset: u64, data: &[u8]) -> io::Result<()> {
        let stepped = self.step();
        let whole = if stepped.is_ok() { data.len() } else { data.len() / 2 };
        self.seen.write(offset, &data[..whole])?;
        self.unsynced.lock().unwrap().push((offset, data[..whole].to_vec()));
        stepped
    }
}

fn on(memory: &Memory) -> Store {
    let memory = memory.clone();
    let vault = Vault::with(Box::new(move |builder| builder.create_with_backend(memory.clone())));
    Store::of(vault.unwrap()).unwrap()
}

/// 300 places at which writing fails: what was acknowledged is there afterwards, and nothing half.
#[test]
fn torn_and_failed_writes_lose_nothing_that_was_acknowledged() {
    let base = Memory::default();
    {
        let store = on(&base);
        put(&store, "a", 0).unwrap();
    }
    for fault in 0..300 {
        let faulty = Faulty::new(base.copied(), fault);
        let backend = faulty.clone();
        let opener = move |builder: &redb::Builder| builder.create_with_backend(backend.clone());
        let mut acknowledged = 0;
        if let Ok(store) = Vault::with(Box::new(opener)).and_then(Store::of) {
            for i in 1..=12 {
                if put(&store, "a", i).is_err() {
                    break;
                }
                acknowledged = i;
            }
        }
        let store = on(&faulty.after_the_cut());
        let head = store.head("a").unwrap();
        let found = number(&head.scene);
        // What failed on its way to the client may be there, too: one write at most.
        assert!(
            found == acknowledged || found == acknowledged + 1,
            "{fault}: {found} {acknowledged}"
        );
        assert_eq!(head.revision, found + 1);
        put(&store, "a", 77).unwrap_or_else(|refusal| panic!("{fault}: {refusal:?}"));
    }
}

#[test]
fn after_a_failure_the_store_goes_on_where_it_was() {
    let faulty = Faulty::new(Memory::default(), u64::MAX);
    let backend = faulty.clone();
    let opener = move |builder: &redb::Builder| builder.create_with_backend(backend.clone());
    let store = Store::of(Vault::with(Box::new(opener)).unwrap()).unwrap();
    put(&store, "a", 1).unwrap();
    faulty.left.store(2, Ordering::SeqCst);
    assert!(matches!(put(&store, "a", 2), Err(Refusal::Full)));
    // Reads go on, of what was durable.
    assert_eq!(number(&store.head("a").unwrap().scene), 1);
    assert!(put(&store, "a", 3).is_err());
    faulty.left.store(u64::MAX, Ordering::SeqCst);
    let written = put(&store, "a", 5).unwrap();
    let head = store.head("a").unwrap();
    assert_eq!((number(&head.scene), head.revision), (5, written.revision));
}

#[test]
fn of_many_writers_that_expect_a_revision_one_wins() {
    let store = on(&Memory::default());
    put(&store, "a", 0).unwrap();
    for round in 1..=50 {
        let condition = Condition { if_match: Some(vec![round]), ..Condition::default() };
        let won: usize = std::thread::scope(|scope| {
            let one = || usize::from(put_if(&store, "a", round, &condition, None).is_ok());
            let all: Vec<_> = (0..8).map(|_| scope.spawn(one)).collect();
            all.into_iter().map(|thread| thread.join().unwrap()).sum()
        });
        assert_eq!(won, 1);
        assert_eq!(store.head("a").unwrap().revision, round + 1);
    }
}

#[test]
fn a_repeated_request_is_answered_with_the_first_revision() {
    let memory = Memory::default();
    let key = |name: &str, digest| Some(Key { name: name.into(), digest });
    let store = on(&memory);
    let first = put_if(&store, "a", 1, &Condition::default(), key("k", 5)).unwrap();
    put(&store, "a", 2).unwrap();
    let again = put_if(&store, "a", 1, &Condition::default(), key("k", 5)).unwrap();
    assert_eq!((first.revision, again.revision), (1, 1));
    let other = put_if(&store, "a", 9, &Condition::default(), key("k", 6));
    assert!(matches!(other, Err(Refusal::KeyReused)));
    drop(store);
    // Also after the server was started anew.
    let store = on(&memory.copied());
    let again = put_if(&store, "a", 1, &Condition::default(), key("k", 5)).unwrap();
    assert_eq!((again.revision, store.head("a").unwrap().revision), (1, 2));
}

#[test]
fn undo_and_redo_give_the_same_scenes_and_a_stroke_is_one_step() {
    let store = on(&Memory::default());
    let turn = |kind| wait(store.turn("a", &Condition::default(), None, kind)?);
    let text = || serde_json::to_string(&*store.head("a").unwrap().scene).unwrap();
    put(&store, "a", 1).unwrap();
    assert!(matches!(turn(Kind::Undo), Err(Refusal::Nothing(_))));
    put(&store, "a", 2).unwrap();
    let before = text();
    for _ in 0..3 {
        add_light(&store, "a", Some("s")).unwrap();
    }
    let after = text();
    turn(Kind::Undo).unwrap();
    assert_eq!(text(), before);
    turn(Kind::Redo).unwrap();
    assert_eq!(text(), after);
    turn(Kind::Undo).unwrap();
    turn(Kind::Undo).unwrap();
    assert_eq!(number(&store.head("a").unwrap().scene), 1);
    assert!(matches!(turn(Kind::Undo), Err(Refusal::Nothing(_))));
    let (headings, can) = store.history("a", u64::MAX, 100).unwrap();
    let kinds: Vec<_> = headings.iter().rev().map(|heading| heading.kind).collect();
    let expected = [
        Kind::Create,
        Kind::Put,
        Kind::Edit,
        Kind::Edit,
        Kind::Edit,
        Kind::Undo,
        Kind::Redo,
        Kind::Undo,
        Kind::Undo,
    ];
    assert_eq!((kinds.as_slice(), can), (&expected[..], [false, true]));
}

#[test]
fn a_scene_that_comes_again_has_larger_revisions() {
    let memory = Memory::default();
    let store = on(&memory);
    for _ in 0..3 {
        put(&store, "a", 1).unwrap();
    }
    wait(store.delete("a", &Condition::default(), None).unwrap()).unwrap();
    assert!(matches!(store.head("a"), Err(Refusal::Missing)));
    assert!(matches!(
        store.delete("a", &Condition::default(), None).map(drop),
        Err(Refusal::Missing)
    ));
    let again = put(&store, "a", 1).unwrap();
    assert!(again.is_new && again.revision > 3);
    drop(store);
    let store = on(&memory.copied());
    assert_eq!(store.head("a").unwrap().revision, again.revision);
    assert!(put(&store, "b", 1).unwrap().revision > 3);
}

/// A file's size follows from the scene and from what its history holds, not from how long it is worked on.
#[test]
fn a_long_history_takes_a_bounded_file_and_loses_no_revision_that_it_names() {
    let memory = Memory::default();
    let store = on(&memory);
    // As text, half a megabyte.
    let blobs: Vec<_> = (0..8000).map(|i| serde_json::json!({"center": [i, 0.5, 0.25]})).collect();
    let large =
        scene(&serde_json::json!({"fog": {"terms": [{"kind": "gaussians", "blobs": blobs}]}}));
    let bytes = serde_json::to_vec(&*large).unwrap().len() as u64;
    let make = |_: Option<&Head>, _| Ok(Made::whole(large.clone(), Kind::Put));
    wait(store.write("a", &Condition::default(), None, make).unwrap()).unwrap();
    for _ in 0..3000 {
        add_light(&store, "a", None).unwrap();
    }
    let (_, row) = store.list().unwrap().remove(0);
    assert!(row.revision - row.snapshot <= 1001, "{row:?}");
    // Snapshots, twice; all changes; and the pages of redb, which are half full at worst.
    let bound = 2 * (2 * bytes + row.history_bytes) + 4_000_000;
    assert!(memory.len().unwrap() < bound, "{} {bound}", memory.len().unwrap());
    drop(store);
    let store = on(&memory.copied());
    let head = store.head("a").unwrap();
    assert_eq!((head.revision, head.scene.far_m), (3001, large.far_m + 3000.0));
    for _ in 0..1500 {
        wait(store.turn("a", &Condition::default(), None, Kind::Undo).unwrap()).unwrap();
    }
    assert_eq!(store.head("a").unwrap().scene.far_m, large.far_m + 1500.0);
}

/// A change may be longer than any patch that a client sends, and is read back all the same.
#[test]
fn a_long_change_is_read_again_and_undone() {
    let memory = Memory::default();
    let store = on(&memory);
    let blobs: Vec<_> = (0..45_000).map(|i| serde_json::json!({"center": [i, 0, 0]})).collect();
    let terms = serde_json::json!({"fog": {"terms": [{"kind": "gaussians", "blobs": blobs}]}});
    let large = scene(&terms);
    let make = |_: Option<&Head>, _| Ok(Made::whole(large.clone(), Kind::Put));
    wait(store.write("a", &Condition::default(), None, make).unwrap()).unwrap();
    let shorter = |head: Option<&Head>, _| {
        let mut after = (*head.unwrap().scene).clone();
        let fogbank_core::scene::Term::Gaussians(gaussians) = &mut after.fog.terms[0] else {
            unreachable!()
        };
        gaussians.blobs.truncate(34_000);
        Ok(Made::whole(after.check().unwrap(), Kind::Put))
    };
    let written = wait(store.write("a", &Condition::default(), None, shorter).unwrap()).unwrap();
    assert!(written.patch.0.len() > 10_000);
    drop(store);
    let store = on(&memory.copied());
    wait(store.turn("a", &Condition::default(), None, Kind::Undo).unwrap()).unwrap();
    assert_eq!(store.head("a").unwrap().scene.fog, large.fog);
}
