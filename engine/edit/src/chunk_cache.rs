//! Caches packed tiles, so that a camera that goes back finds them.

use std::sync::{Arc, Mutex, PoisonError};

use lru::LruCache;
use raxel_world::{ChunkPos, ChunkProvider, Content, Material, MaterialIndex, Unavailable};

use crate::packed::PackedChunk;

/// Bytes of a tile beside those of its packed cells: its place in the cache, about.
const ENTRY: u64 = 160;

/// A source with a cache: keeps requested tiles packed, within a number of bytes, and evicts the least recently used. A source always gives
/// the same tile, so nothing in the cache becomes stale.
pub struct ChunkCache {
    source: Arc<dyn ChunkProvider>,
    kept: Mutex<Kept>,
}

/// Statistics of a [`ChunkCache`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ChunkCacheStats {
    /// Number of cached tiles.
    pub tiles: usize,
    /// Bytes that they take.
    pub bytes: u64,
    /// The most bytes that they may take.
    pub capacity: u64,
    /// How often a tile was in the cache.
    pub hits: u64,
    /// How often a tile had to be made.
    pub misses: u64,
}

type Key = (u32, ChunkPos);

struct Kept {
    most: u64,
    bytes: u64,
    /// In the order in which they were last made, found or evicted.
    entries: LruCache<Key, Packed>,
    hits: u64,
    misses: u64,
}

#[derive(Clone)]
enum Packed {
    Empty,
    Full(MaterialIndex),
    Cells(PackedChunk),
}

impl ChunkCache {
    /// A cache of at most `bytes` bytes over a source. With 0, it keeps nothing.
    pub fn new(source: Arc<dyn ChunkProvider>, bytes: u64) -> Self {
        let kept = Kept { most: bytes, bytes: 0, entries: LruCache::unbounded(), hits: 0, misses: 0 };
        Self { source, kept: Mutex::new(kept) }
    }

    /// Bytes that a tile takes in the cache.
    pub fn bytes_of(content: &Content) -> u64 {
        Packed::of(content).bytes()
    }

    /// The statistics of the cache.
    pub fn stats(&self) -> ChunkCacheStats {
        let kept = self.kept();
        ChunkCacheStats {
            tiles: kept.entries.len(),
            bytes: kept.bytes,
            capacity: kept.most,
            hits: kept.hits,
            misses: kept.misses,
        }
    }

    fn find(&self, key: Key) -> Option<Content> {
        let packed = self.kept().entries.get(&key)?.clone();
        let content = packed.unpack(self.source.materials().len())?;
        self.kept().hits += 1;
        Some(content)
    }

    fn make(&self, key: Key) -> Result<Content, Unavailable> {
        let (level, pos) = key;
        let made = self.source.try_chunk(level, pos);
        let keeps = self.kept().most > 0;
        let packed = made.as_ref().ok().filter(|_| keeps).map(Packed::of);
        let mut kept = self.kept();
        kept.misses += u64::from(made.is_ok());
        if let Some(packed) = packed {
            kept.insert(key, packed);
        }
        made
    }

    fn kept(&self) -> std::sync::MutexGuard<'_, Kept> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl ChunkProvider for ChunkCache {
    fn materials(&self) -> &[Material] {
        self.source.materials()
    }

    /// Failures are not kept: the next call asks the source again.
    fn try_chunk(&self, level: u32, pos: ChunkPos) -> Result<Content, Unavailable> {
        match self.find((level, pos)) {
            Some(content) => Ok(content),
            None => self.make((level, pos)),
        }
    }

    fn height_range(&self) -> Option<[i64; 2]> {
        self.source.height_range()
    }

    fn fingerprint(&self) -> Option<&str> {
        self.source.fingerprint()
    }

    fn top_level(&self) -> u32 {
        self.source.top_level()
    }

    fn on_evicted(&self, level: u32, pos: ChunkPos) {
        self.kept().entries.promote(&(level, pos));
    }
}

impl std::fmt::Debug for ChunkCache {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "ChunkCache({:?})", self.stats())
    }
}

impl Kept {
    fn insert(&mut self, key: Key, packed: Packed) {
        let bytes = packed.bytes();
        // Two threads may have made the same tile.
        if bytes > self.most || self.entries.contains(&key) {
            return;
        }
        while self.bytes + bytes > self.most {
            let Some((_, oldest)) = self.entries.pop_lru() else { return };
            self.bytes -= oldest.bytes();
        }
        self.bytes += bytes;
        self.entries.put(key, packed);
    }
}

impl Packed {
    fn of(content: &Content) -> Self {
        match content {
            Content::Empty => Self::Empty,
            Content::Full(material) => Self::Full(*material),
            Content::Chunk(chunk) => Self::Cells(PackedChunk::pack(Some(chunk))),
        }
    }

    fn bytes(&self) -> u64 {
        match self {
            Self::Empty | Self::Full(_) => ENTRY,
            Self::Cells(packed) => ENTRY + packed.bytes().len() as u64,
        }
    }

    fn unpack(&self, materials: usize) -> Option<Content> {
        match self {
            Self::Empty => Some(Content::Empty),
            Self::Full(material) => Some(Content::Full(*material)),
            Self::Cells(packed) => Some(Content::Chunk(Arc::new(packed.unpack(materials)??))),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU64, Ordering};

    use raxel_world::random::mix;
    use raxel_world::{Cause, DenseChunk};

    use super::*;

    /// Tiles of noise, some empty, some full, and how many of them were made.
    struct Noise(Vec<Material>, AtomicU64);

    impl ChunkProvider for Noise {
        fn materials(&self) -> &[Material] {
            &self.0
        }

        fn try_chunk(&self, level: u32, pos: ChunkPos) -> Result<Content, Unavailable> {
            self.1.fetch_add(1, Ordering::Relaxed);
            let seed = mix(u64::from(level) << 40 | u64::from(pos.x.cast_unsigned()));
            let mut dense = DenseChunk::default();
            match seed % 5 {
                0 => return Ok(Content::Empty),
                1 => return Ok(Content::Full(2)),
                _ => (0..400).for_each(|n| {
                    let at = mix(seed + n);
                    let [x, y, z] = [at & 63, at >> 6 & 63, at >> 12 & 63].map(|c| c as u32);
                    dense.set(x, y, z, 1 + (at >> 20 & 3) as u16);
                }),
            }
            Ok(Content::pack(&dense))
        }
    }

    fn noise() -> Arc<Noise> {
        Arc::new(Noise(vec![Material::air(); 5], AtomicU64::new(0)))
    }

    fn tile(n: i32) -> Key {
        ((n & 3).cast_unsigned(), ChunkPos::new(n, 0, 0))
    }

    #[test]
    fn tiles_come_back_as_they_were_made_and_never_take_more_than_their_bytes() {
        let noise = noise();
        let kept = ChunkCache::new(noise.clone(), 60_000);
        let mut most = 0;
        for round in 0..2000 {
            let (level, pos) = tile((mix(round) % 120) as i32);
            assert_eq!(kept.try_chunk(level, pos), noise.try_chunk(level, pos), "{round}");
            if mix(round) & 64 == 0 {
                kept.on_evicted(level, pos);
            }
            let ChunkCacheStats { tiles, bytes, capacity, .. } = kept.stats();
            assert!(bytes <= capacity && tiles as u64 * ENTRY <= bytes, "{:?}", kept.stats());
            most = most.max(bytes);
        }
        let ChunkCacheStats { hits: found, misses: made, .. } = kept.stats();
        assert!(found > 200 && made > 200 && found + made == 2000, "{found} {made}");
        assert!(most > 50_000, "{most}");
        // The bytes that are there were counted.
        let kept = kept.kept();
        assert_eq!(kept.bytes, kept.entries.iter().map(|(_, packed)| packed.bytes()).sum::<u64>());
    }

    #[test]
    fn a_camera_that_goes_back_makes_nothing_again_and_what_was_given_up_last_is_kept_longest() {
        let noise = noise();
        let made = || noise.1.load(Ordering::Relaxed);
        let ask = |kept: &ChunkCache, n| drop(kept.try_chunk(tile(n).0, tile(n).1));
        let kept = ChunkCache::new(noise.clone(), 1 << 30);
        (0..100).chain((0..100).rev()).for_each(|n| ask(&kept, n));
        assert_eq!(made(), 100);
        // Room for about a third of them: given up in the order 0, 1, 2, …, after all were made.
        let all = kept.stats().bytes;
        let kept = ChunkCache::new(noise.clone(), all / 3);
        for n in 0..100 {
            ask(&kept, n);
            // 30 tiles are held at a time.
            if n >= 30 {
                kept.on_evicted(tile(n - 30).0, tile(n - 30).1);
            }
        }
        let before = made();
        (90..100).rev().for_each(|n| ask(&kept, n));
        assert_eq!(made(), before);
    }

    #[test]
    fn without_bytes_nothing_is_kept() {
        let noise = noise();
        let kept = ChunkCache::new(noise.clone(), 0);
        (0..10).chain(0..10).for_each(|n| drop(kept.try_chunk(tile(n).0, tile(n).1)));
        assert_eq!(noise.1.load(Ordering::Relaxed), 20);
        assert_eq!(kept.stats(), ChunkCacheStats { misses: 20, ..ChunkCacheStats::default() });
    }

    /// A source that fails on request.
    struct Failing(Vec<Material>, Mutex<bool>);

    impl ChunkProvider for Failing {
        fn materials(&self) -> &[Material] {
            &self.0
        }

        fn try_chunk(&self, level: u32, pos: ChunkPos) -> Result<Content, Unavailable> {
            let failing = *self.1.lock().unwrap();
            if failing { Err(Unavailable::new(level, pos, Cause::Failing, "busy")) } else { Ok(Content::Full(1)) }
        }
    }

    #[test]
    fn what_could_not_be_had_is_not_kept() {
        let failing = Arc::new(Failing(vec![Material::air(); 2], Mutex::new(true)));
        let kept = ChunkCache::new(failing.clone(), 1 << 20);
        let (level, pos) = tile(0);
        assert!(kept.try_chunk(level, pos).is_err() && kept.stats().tiles == 0);
        *failing.1.lock().unwrap() = false;
        assert_eq!(kept.try_chunk(level, pos), Ok(Content::Full(1)));
        *failing.1.lock().unwrap() = true;
        assert_eq!(kept.try_chunk(level, pos), Ok(Content::Full(1)));
        // A failed tile does not fail the other tiles.
        assert!(kept.try_chunk(level, ChunkPos::new(9, 9, 9)).is_err());
        assert_eq!(kept.try_chunk(level, pos), Ok(Content::Full(1)));
    }
}
