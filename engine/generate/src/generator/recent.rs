//! Results that are kept while they are likely to be asked for again.

use std::hash::{BuildHasher, Hash, RandomState};
use std::num::NonZeroUsize;
use std::sync::{Arc, Mutex, PoisonError};

use lru::LruCache;

/// Locks that threads spread over.
const SHARDS: usize = 16;

/// Values made for keys. Each shard evicts the value that was asked for least recently.
pub(super) struct Recent<K: Hash + Eq, V> {
    shards: [Mutex<LruCache<K, Arc<V>>>; SHARDS],
    hasher: RandomState,
}

impl<K: Copy + Eq + Hash, V> Recent<K, V> {
    /// Room for `kept` values.
    pub(super) fn new(kept: usize) -> Self {
        let each = NonZeroUsize::new(kept.div_ceil(SHARDS)).unwrap_or(NonZeroUsize::MIN);
        Self { shards: std::array::from_fn(|_| Mutex::new(LruCache::new(each))), hasher: RandomState::new() }
    }

    /// The cached result of a key, or a new one. Two threads may make the same at once; both get one of two equal results.
    #[expect(clippy::cast_possible_truncation, reason = "the remainder of a hash is enough to choose a shard")]
    pub(super) fn get(&self, key: K, make: impl FnOnce() -> V) -> Arc<V> {
        let shard = &self.shards[self.hasher.hash_one(key) as usize % SHARDS];
        let lock = || shard.lock().unwrap_or_else(PoisonError::into_inner);
        let known = lock().get(&key).cloned();
        known.unwrap_or_else(|| {
            let made = Arc::new(make());
            lock().put(key, made.clone());
            made
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_used_stays_and_the_rest_goes() {
        let recent = Recent::new(SHARDS * 4);
        let mut made = 0;
        for round in 0..100 {
            for key in [0, 1000 + round] {
                let value = recent.get(key, || {
                    made += 1;
                    key
                });
                assert_eq!(*value, key);
            }
        }
        assert_eq!(made, 101, "0 is made once");
        let kept: usize = recent.shards.iter().map(|shard| shard.lock().unwrap().len()).sum();
        assert!(kept <= SHARDS * 4, "{kept}");
    }
}
