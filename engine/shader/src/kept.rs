//! Modules on disk: what the front end made of a text, with the includes that it asked for on the way. As long as each of them has the
//! same answer, it would ask for the same ones again and make the same module.

use std::sync::Arc;

use raxel_cache::Cache;
use serde::{Deserialize, Serialize};

use crate::front_end::{self, Include, Included, Job};
use crate::messages;
use crate::sources::Sources;

/// What the front end made.
#[derive(Serialize, Deserialize)]
struct Kept {
    /// In the order in which they were asked for, with the hash of each answer.
    includes: Vec<(Include, [u8; 32])>,
    words: Vec<u32>,
    /// The warnings as the compiler prints them.
    warnings: String,
}

/// The module of a text, if it is kept and none of its includes has changed. Warnings go to `sources.diagnostics`.
pub(crate) fn find(cache: &Cache, job: &Job, sources: &mut Sources<'_>) -> Option<Vec<u32>> {
    let name = name(job)?;
    let bytes = cache.read(&name)?;
    let Ok(kept) = postcard::from_bytes::<Kept>(&bytes) else {
        cache.discard(&name, "it holds no module");
        return None;
    };
    if !kept.includes.iter().all(|(include, answer)| hash(&sources.include(include)) == *answer) {
        return None;
    }
    let found = messages::diagnostics(&kept.warnings, sources);
    sources.diagnostics.extend(found);
    Some(kept.words)
}

/// Listens to what the front end asks, and keeps what it makes.
pub(crate) struct Keeper<'c> {
    cache: &'c Cache,
    includes: Vec<(Include, [u8; 32])>,
}

impl<'c> Keeper<'c> {
    pub fn new(cache: &'c Cache) -> Self {
        Self { cache, includes: Vec::new() }
    }

    /// An include was asked for, and answered.
    pub fn asked(&mut self, include: Include, answer: &Included) {
        self.includes.push((include, hash(answer)));
    }

    /// The front end is done.
    pub fn keep(self, job: &Job, words: &[u32], warnings: &str) {
        let kept = Kept { includes: self.includes, words: words.to_vec(), warnings: warnings.to_owned() };
        if let (Some(name), Ok(bytes)) = (name(job), postcard::to_stdvec(&kept)) {
            self.cache.write(&name, &bytes);
        }
    }
}

/// The words that `make` gives for a text that includes nothing, from disk if they are there.
pub(crate) fn words<E>(
    cache: Option<Arc<Cache>>,
    follows_from: &[&str],
    make: impl FnOnce() -> Result<Vec<u32>, E>,
) -> Result<Vec<u32>, E> {
    let Some(cache) = cache else { return make() };
    let name = format!("graphics-{}", key(follows_from.iter().map(|text| text.as_bytes())));
    if let Some(words) = cache.read(&name).and_then(|bytes| raxel_spirv::words_of(&bytes).ok()) {
        return Ok(words);
    }
    let words = make()?;
    cache.write(&name, &raxel_spirv::bytes_of(&words));
    Ok(words)
}

/// What the module of a text follows from, but for its includes.
fn name(job: &Job) -> Option<String> {
    let job = postcard::to_stdvec(job).ok()?;
    Some(format!("shader-{}", key([&job[..]].into_iter())))
}

fn key<'b>(parts: impl Iterator<Item = &'b [u8]>) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    for part in [front_end::VERSION.as_bytes()].into_iter().chain(parts) {
        hasher.update(&(part.len() as u64).to_le_bytes());
        hasher.update(part);
    }
    hasher.finalize()
}

fn hash(answer: &Included) -> [u8; 32] {
    let Some((name, text)) = answer else { return [0; 32] };
    *key([name.as_bytes(), text.as_bytes()].into_iter()).as_bytes()
}
