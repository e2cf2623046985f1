//! Modules on disk: the front end's module of a text, with the includes that it asked for on the way. As long as each of them has the same
//! answer, it would ask for the same ones again and make the same module. An answer counts as the same when comments or white space differ.

use std::borrow::Cow;
use std::sync::Arc;

use raxel_cache::Cache;
use serde::{Deserialize, Serialize};

use crate::front_end::{self, Include, Included, Job};
use crate::messages;
use crate::sources::Sources;
use crate::stripped::stripped;

/// The output of the front end.
#[derive(Serialize, Deserialize)]
struct Kept {
    /// In the order of the requests, with the hash of each answer.
    includes: Vec<(Include, [u8; 32])>,
    words: Vec<u32>,
    /// The warnings as the compiler prints them.
    warnings: String,
}

/// The part of a text that a module follows from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum TextForm {
    /// All but comments and white space.
    Stripped,
    /// All of it: the text, or a message about it, has numbers of lines.
    Exact,
}

impl TextForm {
    fn text(self, text: &str) -> Cow<'_, str> {
        match self {
            TextForm::Stripped => Cow::Owned(stripped(text)),
            TextForm::Exact => Cow::Borrowed(text),
        }
    }
}

/// The module of a text, if it is kept and its includes are unchanged. If it is `checked`, the numbers of its lines are right.
/// Warnings go to `sources.diagnostics`. `afresh` forgets the includes.
pub(crate) fn find<'f>(
    cache: &Cache,
    job: &Job,
    checked: bool,
    sources: &mut Sources<'f>,
    afresh: impl Fn(&mut Sources<'f>) -> Option<Arc<str>>,
) -> Option<Vec<u32>> {
    let forms = [TextForm::Stripped, TextForm::Exact];
    for form in forms.into_iter().filter(|form| !checked || *form == TextForm::Exact) {
        let Some(kept) = read(cache, job, form) else { continue };
        if kept.includes.iter().all(|(include, answer)| hash(&sources.include(include), form) == *answer) {
            let found = messages::diagnostics(&kept.warnings, sources);
            sources.diagnostics.extend(found);
            return Some(kept.words);
        }
        // Its includes were asked for in vain.
        afresh(sources)?;
    }
    None
}

fn read(cache: &Cache, job: &Job, form: TextForm) -> Option<Kept> {
    let name = name(job, form)?;
    let kept = postcard::from_bytes(&cache.read(&name)?);
    if kept.is_err() {
        cache.discard(&name, "it holds no module");
    }
    kept.ok()
}

/// Listens to the front end's requests, and keeps its module.
pub(crate) struct Keeper<'c> {
    cache: &'c Cache,
    /// The module is to be checked: its lines count.
    checked: bool,
    includes: Vec<(Include, Included)>,
}

impl<'c> Keeper<'c> {
    pub(crate) fn new(cache: &'c Cache, checked: bool) -> Self {
        Self { cache, checked, includes: Vec::new() }
    }

    /// An include was asked for, and answered.
    pub(crate) fn asked(&mut self, include: Include, answer: &Included) {
        self.includes.push((include, answer.clone()));
    }

    /// The front end is done.
    pub(crate) fn keep(self, job: &Job, words: &[u32], warnings: &str) {
        let texts = self.includes.iter().filter_map(|(_, answer)| Some(&*answer.as_ref()?.1)).chain([&*job.text]);
        let defines = job.request.defines.iter().map(|(_, value)| &**value);
        let has_lines = self.checked || !warnings.is_empty() || raxel_spirv::prints(words);
        let counts_lines = has_lines || texts.chain(defines).any(|text| text.contains("__LINE__"));
        let form = if counts_lines { TextForm::Exact } else { TextForm::Stripped };
        let includes = self.includes.iter().map(|(include, answer)| (include.clone(), hash(answer, form))).collect();
        let kept = Kept { includes, words: words.to_vec(), warnings: warnings.to_owned() };
        if let (Some(name), Ok(bytes)) = (name(job, form), postcard::to_stdvec(&kept)) {
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

/// The inputs of the module of a text, without its includes.
fn name(job: &Job, form: TextForm) -> Option<String> {
    let request = postcard::to_stdvec(&job.request).ok()?;
    let (word, text) = (format!("{form:?}"), form.text(&job.text));
    Some(format!("shader-{}", key([word.as_bytes(), &request, text.as_bytes()].into_iter())))
}

fn key<'b>(parts: impl Iterator<Item = &'b [u8]>) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    for part in [front_end::VERSION.as_bytes()].into_iter().chain(parts) {
        hasher.update(&(part.len() as u64).to_le_bytes());
        hasher.update(part);
    }
    hasher.finalize()
}

fn hash(answer: &Included, form: TextForm) -> [u8; 32] {
    let Some((name, text)) = answer else { return [0; 32] };
    *key([name.as_bytes(), form.text(text).as_bytes()].into_iter()).as_bytes()
}
