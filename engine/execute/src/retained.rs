//! Keeps objects after their last use, because an edit that is taken back needs them again. Within a budget of bytes, the most recently
//! used objects stay.

use std::collections::HashMap;
use std::hash::Hash;
use std::sync::Arc;

/// Shared things by key, each with an estimate of its bytes. One that somebody else holds is in use, and is always kept.
pub(super) struct Retained<K, T> {
    entries: HashMap<K, Entry<T>>,
    /// Bytes of things that are kept without being in use.
    budget: u64,
    /// Counts uses.
    uses: u64,
}

struct Entry<T> {
    thing: Arc<T>,
    bytes: u64,
    last_use: u64,
    /// It was in use when a plan was swapped in.
    ran: bool,
}

impl<K: Eq + Hash, T> Retained<K, T> {
    pub(super) fn new(budget: u64) -> Self {
        Self { entries: HashMap::new(), budget, uses: 0 }
    }

    /// The thing, which counts as used now.
    pub(super) fn get(&mut self, key: &K) -> Option<Arc<T>> {
        self.uses += 1;
        let entry = self.entries.get_mut(key)?;
        entry.last_use = self.uses;
        Some(entry.thing.clone())
    }

    /// Whether it is there; no use of it.
    pub(super) fn has(&self, key: &K) -> bool {
        self.entries.contains_key(key)
    }

    /// Keeps a thing.
    pub(super) fn insert(&mut self, key: K, thing: Arc<T>, bytes: u64) {
        self.uses += 1;
        self.entries.insert(key, Entry { thing, bytes, last_use: self.uses, ran: false });
        self.keep_to_budget();
    }

    /// A plan was swapped in, and the one before is gone. Objects made for plans that never ran are dropped at once: a superseded edit is
    /// not restored.
    pub(super) fn swapped(&mut self) {
        self.entries.retain(|_, entry| {
            let in_use = Arc::strong_count(&entry.thing) > 1;
            entry.ran |= in_use;
            entry.ran
        });
        self.keep_to_budget();
    }

    /// Evicts the least recently used entries, until the unused ones fit the budget.
    fn keep_to_budget(&mut self) {
        let unused = |entry: &Entry<T>| Arc::strong_count(&entry.thing) == 1;
        let mut idle: Vec<(u64, u64)> =
            self.entries.values().filter(|entry| unused(entry)).map(|entry| (entry.last_use, entry.bytes)).collect();
        idle.sort_unstable_by_key(|(last_use, _)| std::cmp::Reverse(*last_use));
        let mut bytes = 0;
        let kept = idle.iter().take_while(|(_, size)| {
            bytes += size;
            bytes <= self.budget
        });
        let Some((oldest_kept, _)) = idle.get(kept.count()).copied() else { return };
        self.entries.retain(|_, entry| !unused(entry) || entry.last_use > oldest_kept);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys(retained: &Retained<u32, u32>) -> Vec<u32> {
        let mut keys: Vec<u32> = retained.entries.keys().copied().collect();
        keys.sort_unstable();
        keys
    }

    /// Makes a thing and lets a plan run that uses it alone.
    fn run(retained: &mut Retained<u32, u32>, key: u32, bytes: u64) {
        let thing = retained.get(&key).unwrap_or_else(|| {
            let thing = Arc::new(key);
            retained.insert(key, thing.clone(), bytes);
            thing
        });
        retained.swapped();
        drop(thing);
    }

    #[test]
    fn the_oldest_go_first_when_the_budget_is_spent() {
        let mut retained = Retained::new(100);
        for key in 0..5 {
            run(&mut retained, key, 30);
        }
        // The last one is still counted as used when it was swapped in; three of the others fit.
        assert_eq!(keys(&retained), [1, 2, 3, 4]);
        // An edit that is taken back is young again.
        run(&mut retained, 1, 30);
        run(&mut retained, 9, 30);
        assert_eq!(keys(&retained), [1, 3, 4, 9]);
        // One that is larger than the budget goes when it is not used any more.
        run(&mut retained, 10, 1000);
        run(&mut retained, 11, 10);
        assert!(!keys(&retained).contains(&10));
    }

    #[test]
    fn what_never_ran_goes_at_once() {
        let mut retained = Retained::new(1000);
        let overtaken = Arc::new(1);
        retained.insert(1, overtaken.clone(), 10);
        drop(overtaken);
        run(&mut retained, 2, 10);
        assert_eq!(keys(&retained), [2]);
    }

    #[test]
    fn what_is_in_use_stays_whatever_its_size() {
        let mut retained = Retained::new(10);
        let used = Arc::new(7);
        retained.insert(7, used.clone(), 1000);
        for key in 0..4 {
            run(&mut retained, key, 10);
        }
        assert!(keys(&retained).contains(&7));
        drop(used);
    }
}
