//! A store as the source of a streamed world.

use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use lru::LruCache;
use raxel_world::{Bounds, Cause, ChunkPos, ChunkProvider, Content, Material, Unavailable};

use crate::metadata::{self, Baked, Unreadable};
use crate::plan::{BakedLevel, CHUNK, ShardKey};
use crate::retry::retried;
use crate::seal::Seals;
use crate::shard::{self, Damage, Index};
use crate::store::{self, OpenError, Store, StoreError, Wanted};

/// Entries of indices that are kept, 16 bytes each.
const KEPT_ENTRIES: usize = 1 << 20;

/// A baked world. A tile outside of the baked region is empty. A missing or damaged tile is unavailable, and never counts as
/// empty.
pub struct ZarrSource {
    store: Arc<dyn Store>,
    address: String,
    baked: Baked,
    levels: Vec<BakedLevel>,
    seals: Seals,
    indices: Mutex<Indices>,
}

/// Indices of shards that were used last.
type Indices = LruCache<ShardKey, Arc<Index>>;

/// Why a store is no source.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SourceError {
    /// There is no store at the address.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// Nothing was baked to the address.
    #[error("no world was baked to `{address}`: there is no `zarr.json`")]
    Nothing {
        /// Where it was looked for.
        address: String,
    },
    /// The store fails.
    #[error("the store `{address}` has failed at {error}")]
    Store {
        /// Its address.
        address: String,
        /// The store's error.
        error: StoreError,
    },
    /// The document is wrong.
    #[error("the store `{address}` cannot be read: {error}")]
    Unreadable {
        /// Its address.
        address: String,
        /// The reason.
        error: Unreadable,
    },
}

/// Why one read has failed.
enum Failure {
    Store(StoreError),
    Missing,
    Damaged(Damage),
}

impl ZarrSource {
    /// Opens the store at an address: a folder, relative to `root`, or a URL.
    pub fn open(address: &str, root: &Path) -> Result<Self, SourceError> {
        Self::of(store::open(address, root)?, address)
    }

    /// A store that is open. Messages use the address as its name.
    pub fn of(store: Arc<dyn Store>, address: &str) -> Result<Self, SourceError> {
        let address = address.to_owned();
        let again = |error: &SourceError| match error {
            SourceError::Store { error, .. } => error.passing,
            // It may have arrived cut off, or another process may have just replaced it.
            SourceError::Unreadable { .. } => true,
            SourceError::Nothing { .. } | SourceError::Open(_) => false,
        };
        let baked = retried(store.pauses(), again, || match store.get(metadata::GROUP, Wanted::Document) {
            Ok(Some(document)) => {
                Baked::read(&document).map_err(|error| SourceError::Unreadable { address: address.clone(), error })
            }
            Ok(None) => Err(SourceError::Nothing { address: address.clone() }),
            Err(error) => Err(SourceError::Store { address: address.clone(), error }),
        })?;
        let (levels, seals) = (baked.baked_levels(), Seals::of(&baked));
        let most = NonZeroUsize::new(KEPT_ENTRIES / chunks(&baked)).unwrap_or(NonZeroUsize::MIN);
        // One of a given size takes all of its memory at once.
        let mut indices = LruCache::unbounded();
        indices.resize(most);
        Ok(Self { store, address, baked, levels, seals, indices: Mutex::new(indices) })
    }

    /// The box of voxels that was baked.
    pub fn region(&self) -> Bounds {
        let (level, edge) = (&self.levels[0], i64::from(self.baked.edge));
        let min = level.origin(self.baked.edge);
        Bounds { min, max: std::array::from_fn(|axis| min[axis] + i64::from(level.shards[axis]) * edge) }
    }

    #[expect(clippy::cast_possible_truncation, reason = "a place has at most `most_bytes`")]
    fn read(&self, key: ShardKey, chunk: usize) -> Result<Content, Failure> {
        let object = key.object();
        let index = self.index(key, &object)?;
        let Some(place) = index.place(chunk).map_err(Failure::Damaged)? else { return Ok(Content::Empty) };
        let wanted = (place.end - place.start) as usize;
        let bytes = self.store.get(&object, Wanted::Bytes(place)).map_err(Failure::Store)?.ok_or(Failure::Missing)?;
        if bytes.len() != wanted {
            return Err(Failure::Damaged(Damage::Short { found: bytes.len(), needed: wanted }));
        }
        shard::decode(&bytes, chunk, self.baked.materials.len()).map_err(Failure::Damaged)
    }

    fn index(&self, key: ShardKey, object: &str) -> Result<Arc<Index>, Failure> {
        if let Some(index) = self.indices().get(&key) {
            return Ok(index.clone());
        }
        let chunks = chunks(&self.baked);
        let last = Wanted::Last(Index::bytes(chunks) as u64);
        let tail = self.store.get(object, last).map_err(Failure::Store)?.ok_or(Failure::Missing)?;
        let index = Arc::new(Index::read(&tail, chunks, self.seals.of_shard(key)).map_err(Failure::Damaged)?);
        self.indices().put(key, index.clone());
        Ok(index)
    }

    fn indices(&self) -> std::sync::MutexGuard<'_, Indices> {
        self.indices.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn explain(&self, key: ShardKey, failure: &Failure) -> (Cause, String) {
        let (address, object) = (&self.address, key.object());
        match failure {
            Failure::Store(error) => (Cause::Failing, format!("the store `{address}` has failed at {error}")),
            Failure::Missing => {
                let reason = "that shard was not baked yet, or was removed";
                (Cause::Missing, format!("the store `{address}` has no `{object}`: {reason}"))
            }
            Failure::Damaged(damage) => {
                (Cause::Damaged, format!("`{object}` in the store `{address}` is damaged: {damage}"))
            }
        }
    }
}

/// Chunks of a shard.
fn chunks(baked: &Baked) -> usize {
    (baked.edge / CHUNK).pow(3) as usize
}

impl ChunkProvider for ZarrSource {
    fn materials(&self) -> &[Material] {
        &self.baked.materials
    }

    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the chunk lies in the level, whose numbers of shards have 32 bits"
    )]
    fn try_chunk(&self, level: u32, pos: ChunkPos) -> Result<Content, Unavailable> {
        let Some(of) = self.levels.get(level as usize) else {
            let (address, levels) = (&self.address, self.levels.len());
            let reason = format!("the store `{address}` has {levels} levels of detail, and no level {level}");
            return Err(Unavailable::new(level, pos, Cause::Missing, reason));
        };
        let edge = i64::from(self.baked.edge / CHUNK);
        let at: [i64; 3] =
            std::array::from_fn(|axis| i64::from([pos.x, pos.y, pos.z][axis]) - i64::from(of.first[axis]) * edge);
        if (0..3).any(|axis| !(0..i64::from(of.shards[axis]) * edge).contains(&at[axis])) {
            return Ok(Content::Empty);
        }
        let key = ShardKey { level, at: at.map(|c| (c / edge) as u32) };
        let [x, y, z] = at.map(|c| (c % edge) as usize);
        let chunk = (z * edge as usize + y) * edge as usize + x;
        let again = |failure: &Failure| match failure {
            Failure::Store(error) => error.passing,
            Failure::Missing => false,
            Failure::Damaged(_) => {
                // Another process may have just replaced it, or it arrived cut off.
                self.indices().pop(&key);
                true
            }
        };
        retried(self.store.pauses(), again, || self.read(key, chunk)).map_err(|failure| {
            self.indices().pop(&key);
            let (cause, reason) = self.explain(key, &failure);
            Unavailable::new(level, pos, cause, reason)
        })
    }

    fn height_range(&self) -> Option<[i64; 2]> {
        let Bounds { min, max } = self.region();
        Some([min[1], max[1]])
    }

    fn fingerprint(&self) -> Option<&str> {
        Some(&self.baked.fingerprint)
    }

    #[expect(clippy::cast_possible_truncation, reason = "a store has at most `MAX_LEVEL` + 1 levels")]
    fn top_level(&self) -> u32 {
        self.levels.len() as u32 - 1
    }
}

impl std::fmt::Debug for ZarrSource {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ZarrSource").field("address", &self.address).finish_non_exhaustive()
    }
}
