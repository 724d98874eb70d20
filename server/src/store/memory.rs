//! Bytes of a database in memory, bounded, that outlive the database which is opened on them.

use redb::StorageBackend;
use std::io::{Error, ErrorKind, Result};
use std::sync::{Arc, PoisonError, RwLock};

/// What scenes without a directory may take [bytes].
const MOST_BYTES: u64 = 1 << 30;

/// Bytes in memory.
#[derive(Clone, Debug, Default)]
pub struct Memory(Arc<RwLock<Vec<u8>>>);

impl Memory {
    /// A copy of what it holds by now.
    #[cfg(test)]
    pub fn copied(&self) -> Self {
        let bytes = self.0.read().unwrap_or_else(PoisonError::into_inner);
        Self(Arc::new(RwLock::new(bytes.clone())))
    }
}

/// The range of some bytes, if they are there.
fn range(bytes: &[u8], offset: u64, length: usize) -> Result<std::ops::Range<usize>> {
    let begin = usize::try_from(offset).ok();
    let range = begin.and_then(|begin| Some(begin..begin.checked_add(length)?));
    range.filter(|range| range.end <= bytes.len()).ok_or_else(|| ErrorKind::UnexpectedEof.into())
}

impl StorageBackend for Memory {
    fn len(&self) -> Result<u64> {
        Ok(self.0.read().unwrap_or_else(PoisonError::into_inner).len() as u64)
    }

    fn read(&self, offset: u64, out: &mut [u8]) -> Result<()> {
        let bytes = self.0.read().unwrap_or_else(PoisonError::into_inner);
        out.copy_from_slice(&bytes[range(&bytes, offset, out.len())?]);
        Ok(())
    }

    fn set_len(&self, length: u64) -> Result<()> {
        if length > MOST_BYTES {
            return Err(Error::from(ErrorKind::StorageFull));
        }
        self.0.write().unwrap_or_else(PoisonError::into_inner).resize(length as usize, 0);
        Ok(())
    }

    fn sync_data(&self) -> Result<()> {
        Ok(())
    }

    fn write(&self, offset: u64, data: &[u8]) -> Result<()> {
        // As a file does, it grows with what is written behind its end.
        let end = offset.saturating_add(data.len() as u64);
        if end > self.len()? {
            self.set_len(end)?;
        }
        let mut bytes = self.0.write().unwrap_or_else(PoisonError::into_inner);
        let range = range(&bytes, offset, data.len())?;
        bytes[range].copy_from_slice(data);
        Ok(())
    }
}
