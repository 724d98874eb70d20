//! The database under the stored scenes (redb): its tables, and one way in for reading and for writing.
//!
//! A transaction that fails leaves nothing behind; the database is opened anew then, because it refuses everything
//! after a failed write. Until that succeeds reads fail too, but for what is in memory.

use super::memory::Memory;
use redb::{
    Builder, Database, DatabaseError, ReadTransaction, ReadableDatabase, ReadableTable,
    TableDefinition, WriteTransaction,
};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::{PoisonError, RwLock, RwLockReadGuard};

/// A number for the whole database, by name.
pub const NUMBERS: TableDefinition<&str, u64> = TableDefinition::new("numbers");
/// What is known of a scene: [`Row`](super::record::Row).
pub const SCENES: TableDefinition<&str, &[u8]> = TableDefinition::new("scenes");
/// A whole scene, as JSON, at the revision that its row names.
pub const SNAPSHOTS: TableDefinition<&str, &[u8]> = TableDefinition::new("snapshots");
/// What a revision is: [`Heading`](super::record::Heading).
pub const REVISIONS: TableDefinition<(&str, u64), &[u8]> = TableDefinition::new("revisions");
/// What it changed, there and back: [`Change`](super::record::Change).
pub const CHANGES: TableDefinition<(&str, u64), &[u8]> = TableDefinition::new("changes");
/// The revision that a request with a key of its own made.
pub const KEYS: TableDefinition<(&str, &str), (u64, u64)> = TableDefinition::new("keys");
/// Strokes that may go on, of a scene.
pub const STROKES: TableDefinition<&str, &[u8]> = TableDefinition::new("strokes");

/// The form of these tables. A database of another one is not touched.
const SCHEMA: u64 = 1;

/// Where the number of that form stands.
const SCHEMA_NUMBER: &str = "schema";

/// The least revision of scenes to come: above those of all that were deleted, so that no tag comes again.
pub const FIRST_REVISION: &str = "first_revision";

/// What the database may keep of its pages [bytes]: scenes in use are in memory anyway.
const CACHE_BYTES: usize = 32 << 20;

/// Why the store failed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Failure {
    /// There is no room for more.
    Full,
    /// Another process uses it.
    InUse,
    /// A database of another version.
    Schema(u64),
    /// Anything else.
    Other(String),
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Full => f.write_str("there is no room for more scenes"),
            Self::InUse => f.write_str("another process uses this directory"),
            Self::Schema(found) => {
                write!(
                    f,
                    "its scenes are kept in form {found}, and this program knows form {SCHEMA}"
                )
            }
            Self::Other(detail) => f.write_str(detail),
        }
    }
}

impl From<redb::Error> for Failure {
    fn from(error: redb::Error) -> Self {
        match error {
            redb::Error::DatabaseAlreadyOpen => Self::InUse,
            redb::Error::Io(error) if is_full(error.kind()) => Self::Full,
            other => Self::Other(other.to_string()),
        }
    }
}

/// A file may also be too large for the system, or for whoever started this process.
fn is_full(kind: ErrorKind) -> bool {
    matches!(kind, ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge)
}

/// Another thread has just closed it.
fn closed() -> Failure {
    Failure::Other("the database is being opened again".into())
}

/// Opens a database.
type Opener = Box<dyn Fn(&Builder) -> Result<Database, DatabaseError> + Send + Sync>;

/// The database.
pub struct Vault {
    opener: Opener,
    open: RwLock<Option<Database>>,
}

impl Vault {
    /// In a directory, which is made if need be; without one in memory.
    ///
    /// # Errors
    /// When it cannot be used.
    pub fn open(directory: Option<&Path>) -> Result<Self, Failure> {
        match directory {
            None => {
                let memory = Memory::default();
                Self::with(Box::new(move |builder| builder.create_with_backend(memory.clone())))
            }
            Some(directory) => {
                let other = |error: std::io::Error| Failure::from(redb::Error::Io(error));
                std::fs::create_dir_all(directory).map_err(other)?;
                let file: PathBuf = directory.join("fogbank.redb");
                Self::with(Box::new(move |builder| builder.create(&file)))
            }
        }
    }

    /// With a database that is opened so.
    ///
    /// # Errors
    /// When it cannot be opened, or has another form.
    pub fn with(opener: Opener) -> Result<Self, Failure> {
        let vault = Self { opener, open: RwLock::new(None) };
        vault.reopen()?;
        vault
            .write(|transaction| {
                let mut numbers = transaction.open_table(NUMBERS)?;
                let found = numbers.get(SCHEMA_NUMBER)?.map(|number| number.value());
                if found.is_none() {
                    numbers.insert(SCHEMA_NUMBER, SCHEMA)?;
                }
                // Readers expect them.
                transaction.open_table(SCENES)?;
                transaction.open_table(SNAPSHOTS)?;
                transaction.open_table(REVISIONS)?;
                transaction.open_table(CHANGES)?;
                transaction.open_table(KEYS)?;
                transaction.open_table(STROKES)?;
                Ok(found.unwrap_or(SCHEMA))
            })
            .and_then(|found| if found == SCHEMA { Ok(()) } else { Err(Failure::Schema(found)) })?;
        Ok(vault)
    }

    fn reopen(&self) -> Result<(), Failure> {
        let mut open = self.open.write().unwrap_or_else(PoisonError::into_inner);
        // Its lock on the file goes with it.
        *open = None;
        let mut builder = Builder::new();
        builder.set_cache_size(CACHE_BYTES);
        let database = (self.opener)(&builder).map_err(redb::Error::from)?;
        *open = Some(database);
        Ok(())
    }

    /// What a transaction reads, which sees one state of everything.
    ///
    /// # Errors
    /// When the database cannot be read.
    pub fn read<T>(
        &self,
        look: impl FnOnce(&ReadTransaction) -> Result<T, redb::Error>,
    ) -> Result<T, Failure> {
        let open = self.opened()?;
        let database = open.as_ref().ok_or_else(closed)?;
        let transaction = database.begin_read().map_err(redb::Error::from)?;
        Ok(look(&transaction)?)
    }

    /// The database, opened again if that failed before.
    fn opened(&self) -> Result<RwLockReadGuard<'_, Option<Database>>, Failure> {
        let open = self.open.read().unwrap_or_else(PoisonError::into_inner);
        if open.is_some() {
            return Ok(open);
        }
        drop(open);
        self.reopen()?;
        Ok(self.open.read().unwrap_or_else(PoisonError::into_inner))
    }

    /// Changes everything that `change` does, or nothing. What it returns is on disk then.
    ///
    /// # Errors
    /// When it could not be written.
    pub fn write<T>(
        &self,
        change: impl FnOnce(&WriteTransaction) -> Result<T, redb::Error>,
    ) -> Result<T, Failure> {
        let result = self.try_write(change);
        if let Err(failure) = &result {
            tracing::error!("store: {failure}");
            if let Err(failure) = self.reopen() {
                tracing::error!("store: opening it again: {failure}");
            }
        }
        result
    }

    fn try_write<T>(
        &self,
        change: impl FnOnce(&WriteTransaction) -> Result<T, redb::Error>,
    ) -> Result<T, Failure> {
        let open = self.opened()?;
        let database = open.as_ref().ok_or_else(closed)?;
        let transaction = database.begin_write().map_err(redb::Error::from)?;
        let value = change(&transaction)?;
        transaction.commit().map_err(redb::Error::from)?;
        Ok(value)
    }
}
