//! A file of appended records. A record is written whole or not at all.

use std::io;
use std::path::Path;
use std::sync::Arc;

use super::disk::{Disk, Storage};

/// An append log.
pub(super) struct Log {
    storage: Arc<dyn Storage>,
    bytes: u64,
    /// The rest of a failed write must still be cut off.
    torn: bool,
}

impl Log {
    /// Opens a file for appending, made if there is none, and cuts it to `bytes` bytes.
    pub(super) fn open(disk: &dyn Disk, path: &Path, bytes: u64) -> io::Result<Self> {
        let (storage, there) = disk.open(path)?;
        // A file that is shorter than it was read a moment ago goes on where it ends.
        let mut log = Self { storage, bytes: bytes.min(there), torn: there > bytes };
        log.mend()?;
        Ok(log)
    }

    #[cfg(test)]
    fn on(storage: Arc<dyn Storage>, bytes: u64) -> Self {
        Self { storage, bytes, torn: false }
    }

    /// Appends bytes by one write. When it fails, the log ends where it did before.
    pub(super) fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.mend()?;
        let written = self.storage.append(bytes);
        if written.is_ok() {
            self.bytes += bytes.len() as u64;
        } else {
            self.torn = true;
            // If that fails too, it is done before the next write.
            let _ = self.mend();
        }
        written
    }

    /// Cuts off everything from a byte on.
    pub(super) fn truncate(&mut self, bytes: u64) -> io::Result<()> {
        self.bytes = bytes;
        self.torn = true;
        self.mend()
    }

    fn mend(&mut self) -> io::Result<()> {
        if self.torn {
            self.storage.truncate(self.bytes)?;
            self.torn = false;
        }
        Ok(())
    }

    pub(super) fn bytes(&self) -> u64 {
        self.bytes
    }

    pub(super) fn storage(&self) -> &Arc<dyn Storage> {
        &self.storage
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    /// A disk with room for a number of bytes.
    struct Small {
        bytes: Mutex<Vec<u8>>,
        room: AtomicUsize,
    }

    impl Storage for Small {
        fn append(&self, bytes: &[u8]) -> io::Result<()> {
            let mut here = self.bytes.lock().unwrap();
            let fits = bytes.len().min(self.room.load(Ordering::Relaxed).saturating_sub(here.len()));
            here.extend(&bytes[..fits]);
            if fits == bytes.len() { Ok(()) } else { Err(io::ErrorKind::StorageFull.into()) }
        }

        fn write_at(&self, _: u64, _: &[u8]) -> io::Result<()> {
            unreachable!("logs are appended to")
        }

        fn truncate(&self, bytes: u64) -> io::Result<()> {
            self.bytes.lock().unwrap().truncate(bytes as usize);
            Ok(())
        }

        fn sync(&self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_write_that_does_not_fit_leaves_nothing_behind() {
        let disk = Arc::new(Small { bytes: Mutex::default(), room: AtomicUsize::new(10) });
        let mut log = Log::on(disk.clone(), 0);
        log.append(b"abcd").unwrap();
        assert_eq!(log.append(b"efghijklm").unwrap_err().kind(), io::ErrorKind::StorageFull);
        assert_eq!((log.bytes(), &disk.bytes.lock().unwrap()[..]), (4, &b"abcd"[..]));
        disk.room.store(100, Ordering::Relaxed);
        log.append(b"efghijklm").unwrap();
        assert_eq!(&disk.bytes.lock().unwrap()[..], b"abcdefghijklm");
    }
}
