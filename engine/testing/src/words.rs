//! Memory of the host in place of a device's.

use std::sync::{Arc, Mutex};

use raxel_stream::{PoolMemory, Publication};

/// The words of a pool.
pub struct Words(Mutex<Vec<u32>>);

impl Words {
    /// `count` words, with a value that marks unwritten ones.
    pub fn new(count: u32) -> Arc<Self> {
        Arc::new(Self(Mutex::new(vec![0xdead_beef; count as usize])))
    }

    /// Its present contents.
    pub fn all(&self) -> Vec<u32> {
        self.0.lock().expect("no writer panics").clone()
    }

    /// The words that a frame sees of a publication, from its header on.
    pub fn frame(&self, publication: &Publication) -> Vec<u32> {
        let mut words = self.all();
        words[..publication.words().len()].copy_from_slice(publication.words());
        words
    }
}

impl PoolMemory for Words {
    fn write(&self, at: u32, words: &[u32]) {
        self.0.lock().expect("no writer panics")[at as usize..][..words.len()].copy_from_slice(words);
    }
}
