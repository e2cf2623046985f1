//! Where shards are kept: named objects of bytes.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use crate::folder_store::FolderStore;

/// Most bytes of a JSON document: that of a world with all materials that there may be has a quarter of it.
pub(crate) const DOCUMENT: u64 = 64 << 20;

/// The pauses of a store that names no others.
pub(crate) const PAUSES: [Duration; 2] = [Duration::from_millis(50), Duration::from_millis(250)];

/// A place for objects. Keys are paths with `/`, without `.` and `..`.
pub trait Store: Send + Sync {
    /// All wanted bytes of an object; `None` if the object does not exist.
    fn get(&self, key: &str, wanted: Wanted) -> Result<Option<Vec<u8>>, StoreError>;

    /// Writes an object, in place of an older one. A reader never sees half of it.
    fn put(&self, key: &str, bytes: &[u8]) -> Result<(), StoreError>;

    /// Pauses after which something that could not be read is read again, before somebody hears of it.
    fn pauses(&self) -> &[Duration] {
        &PAUSES
    }
}

/// A part of an object.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// All of it.
    Whole,
    /// The whole object, or an error if it has more than `DOCUMENT` bytes. So no server and no damaged file can fill the memory.
    Document,
    /// These bytes.
    Bytes(Range<u64>),
    /// So many bytes at its end, or all that it has if these are fewer.
    Last(u64),
}

/// A store has failed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{key}`: {reason}")]
pub struct StoreError {
    /// The object.
    pub key: String,
    /// The message of the system or the server.
    pub reason: String,
    /// Whether it may go away by itself: a server that is busy, a connection that broke.
    pub passing: bool,
}

/// An address that no store can be opened at.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OpenError {
    /// This program was built without the stores that are reached over the network.
    #[error("`{0}` is reached over the network, and this raxel was built without that")]
    NeedsCloud(String),
    /// The address is of no known kind.
    #[error("`{0}` is not an address of a store: a folder, `file:///…`, `s3://BUCKET/…`, `http://…` or `https://…`")]
    Unknown(String),
    /// Something that is needed to reach it is missing or wrong.
    #[error("the store `{address}` cannot be opened: {reason}")]
    Failed {
        /// The address.
        address: String,
        /// The missing or wrong thing.
        reason: String,
    },
}

/// Opens the store at an address: a folder, relative to `root`, or a URL.
pub fn open(address: &str, root: &Path) -> Result<Arc<dyn Store>, OpenError> {
    let Some((scheme, rest)) = address.split_once("://") else {
        if address.is_empty() || address.contains('\0') {
            return Err(OpenError::Unknown(address.to_owned()));
        }
        return Ok(Arc::new(FolderStore::new(root.join(address))));
    };
    match scheme {
        "file" if rest.starts_with('/') => Ok(Arc::new(FolderStore::new(Path::new(rest).to_owned()))),
        "s3" | "http" | "https" => open_remote(address),
        _ => Err(OpenError::Unknown(address.to_owned())),
    }
}

#[cfg(feature = "cloud")]
fn open_remote(address: &str) -> Result<Arc<dyn Store>, OpenError> {
    let opened = crate::object::ObjectStore::open(address);
    opened.map(|store| Arc::new(store) as _).map_err(|reason| OpenError::Failed { address: address.to_owned(), reason })
}

#[cfg(not(feature = "cloud"))]
fn open_remote(address: &str) -> Result<Arc<dyn Store>, OpenError> {
    Err(OpenError::NeedsCloud(address.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_that_are_none_are_refused() {
        let error = |address: &str| open(address, Path::new("/")).err();
        for wrong in ["", "a\0b", "ftp://x/y", "file://relative", "://"] {
            assert!(matches!(error(wrong), Some(OpenError::Unknown(_))), "{wrong:?}");
        }
        #[cfg(not(feature = "cloud"))]
        assert!(matches!(error("s3://bucket/world"), Some(OpenError::NeedsCloud(_))));
        assert!(error("some/folder").is_none() && error("file:///some/folder").is_none());
    }
}
