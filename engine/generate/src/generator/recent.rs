//! Results that are kept while they are likely to be asked for again.

use std::collections::HashMap;
use std::hash::{BuildHasher, Hash, RandomState};
use std::sync::{Arc, Mutex, PoisonError};

/// Locks that threads spread over.
const SHARDS: usize = 16;

/// Values made for keys, in two generations: when the young one is full, the old one is dropped and takes its place. A value that is asked for
/// becomes young again. So at least the last `kept` results are there, and at most twice as many.
pub(super) struct Recent<K, V> {
    shards: [Mutex<Generations<K, V>>; SHARDS],
    hasher: RandomState,
    kept: usize,
}

struct Generations<K, V> {
    young: HashMap<K, Arc<V>>,
    old: HashMap<K, Arc<V>>,
}

impl<K: Copy + Eq + Hash, V> Recent<K, V> {
    pub(super) fn new(kept: usize) -> Self {
        let empty = || Mutex::new(Generations { young: HashMap::new(), old: HashMap::new() });
        Self { shards: std::array::from_fn(|_| empty()), hasher: RandomState::new(), kept: kept.div_ceil(SHARDS) }
    }

    /// The cached result of a key, or a new one. Two threads may make the same at once; both get one of two equal results.
    #[expect(clippy::cast_possible_truncation, reason = "the remainder of a hash is enough to choose a shard")]
    pub(super) fn get(&self, key: K, make: impl FnOnce() -> V) -> Arc<V> {
        let shard = &self.shards[self.hasher.hash_one(key) as usize % SHARDS];
        let lock = || shard.lock().unwrap_or_else(PoisonError::into_inner);
        let known = {
            let mut generations = lock();
            let old = generations.old.remove(&key);
            old.map(|value| generations.keep(key, value, self.kept)).or_else(|| generations.young.get(&key).cloned())
        };
        known.unwrap_or_else(|| {
            let made = Arc::new(make());
            lock().keep(key, made, self.kept)
        })
    }
}

impl<K: Copy + Eq + Hash, V> Generations<K, V> {
    fn keep(&mut self, key: K, value: Arc<V>, kept: usize) -> Arc<V> {
        if self.young.len() >= kept {
            self.old = std::mem::take(&mut self.young);
        }
        self.young.insert(key, value.clone());
        value
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
        let count = |generations: &Generations<_, _>| generations.young.len() + generations.old.len();
        let kept: usize = recent.shards.iter().map(|shard| count(&shard.lock().unwrap())).sum();
        assert!(kept <= 2 * SHARDS * 4, "{kept}");
    }
}
