//! A target: the code under test, its limits, and the origin of its inputs.

use std::path::{Path, PathBuf};

use raxel_world::random::SplitMix64;

use crate::bounds::{self, Bounds};
use crate::mutate::Mutation;

/// A function that takes any bytes, and how it is fuzzed.
#[derive(Debug)]
pub struct Target {
    /// Its name on the command line, and the name of its folder in `corpus/`.
    pub name: &'static str,
    /// Reads an input. It panics when something is not as it is promised.
    pub(crate) run: fn(&[u8]),
    /// The limits of one input.
    pub(crate) bounds: Bounds,
    /// How inputs are changed.
    pub(crate) mutation: Mutation,
    /// Files and folders of the project that are inputs too, beside the corpus.
    pub(crate) seeds: &'static [&'static str],
    /// Longest input, in bytes.
    pub longest: usize,
    /// Mutations in the quick test: about half a second of one core.
    pub quick: u32,
}

impl Target {
    /// Runs an input. Panics when it breaks a promise, or uses more memory or time than the target allows.
    pub fn run(&self, input: &[u8]) {
        bounds::within(&self.bounds, input.len(), || bounds::without_panics(|| (self.run)(input)));
    }

    /// The folder of its corpus.
    pub fn corpus(&self) -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(self.name)
    }

    /// The inputs that others are made from, in order of their paths: the corpus, then the seeds.
    pub fn inputs(&self) -> Vec<(PathBuf, Vec<u8>)> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let mut paths = files(&self.corpus());
        paths.extend(self.seeds.iter().flat_map(|seed| files(&root.join(seed))));
        let read = |path: PathBuf| std::fs::read(&path).ok().map(|bytes| (path, bytes));
        paths.into_iter().filter_map(read).filter(|(_, bytes)| bytes.len() <= self.longest).collect()
    }

    /// Another input like `input`, with parts of `other`.
    pub fn mutated(&self, input: &[u8], other: &[u8], random: &mut SplitMix64) -> Vec<u8> {
        let mut mutated = self.mutation.apply(input, other, random);
        mutated.truncate(self.longest);
        mutated
    }
}

/// The file at a path, or all files in a folder, but not in the folders in it.
fn files(path: &Path) -> Vec<PathBuf> {
    if path.is_file() {
        return vec![path.to_owned()];
    }
    let Ok(entries) = std::fs::read_dir(path) else { return Vec::new() };
    let mut found: Vec<PathBuf> =
        entries.filter_map(|entry| Some(entry.ok()?.path())).filter(|path| path.is_file()).collect();
    found.sort();
    found
}
