//! The corpus, and mutations of it with fixed seeds. `RAXEL_FUZZ_INPUTS` sets the number of mutations of each target. `RAXEL_FUZZ_TIMES`
//! multiplies a target's own number instead. `RAXEL_FUZZ_SEED` is the first seed.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

use std::io::{Seek, Write};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::{Path, PathBuf};

use raxel_fuzz::{TARGETS, Target};
use raxel_world::random::SplitMix64;

fn number(variable: &str) -> Option<u64> {
    std::env::var(variable).ok()?.parse().ok()
}

/// Keeps an input that breaks a promise, and says where.
fn tried(target: &Target, name: &str, input: &[u8]) {
    if let Err(panic) = catch_unwind(AssertUnwindSafe(|| target.run(input))) {
        let kept = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("{}-found", target.name));
        let written = std::fs::write(&kept, input);
        eprintln!("{name} breaks a promise of `{}`; the input is in {} ({written:?})", target.name, kept.display());
        resume_unwind(panic);
    }
}

fn replay(name: &str) {
    raxel_fuzz::alone();
    let target = raxel_fuzz::find(name).expect("the target is in the list");
    let inputs = target.inputs();
    assert!(!inputs.is_empty(), "`{name}` has no inputs");
    for (path, input) in &inputs {
        tried(target, &path.display().to_string(), input);
    }
    let begin = number("RAXEL_FUZZ_SEED").unwrap_or(0);
    let own = u64::from(target.quick) * number("RAXEL_FUZZ_TIMES").unwrap_or(1);
    let count = number("RAXEL_FUZZ_INPUTS").unwrap_or(own);
    let mut running = Running::new(name);
    println!("{name}: {} inputs of the corpus, then seeds {begin} to {}", inputs.len(), begin + count);
    for seed in begin..begin + count {
        running.note(seed);
        let mut random = SplitMix64::new(seed);
        let mut pick = || &inputs[random.below(inputs.len() as u64) as usize].1;
        let (input, other) = (pick(), pick());
        let mutated = target.mutated(input, other, &mut random);
        tried(target, &format!("seed {seed}"), &mutated);
    }
}

/// A file with the seed that is being tried: an input that ends the process leaves it behind.
struct Running {
    file: std::fs::File,
    path: PathBuf,
}

impl Running {
    fn new(target: &str) -> Self {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{target}-seed"));
        let file = std::fs::File::create(&path).expect("the folder of the tests can be written");
        Self { file, path }
    }

    fn note(&mut self, seed: u64) {
        let written = self.file.rewind().and_then(|()| writeln!(self.file, "{seed:020}"));
        written.expect("the folder of the tests can be written");
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // A file that stays only names a seed that did no harm.
        let _ = std::fs::remove_file(&self.path);
    }
}

macro_rules! replays {
    ($($name:ident),* $(,)?) => {
        $(#[test]
        fn $name() {
            replay(stringify!($name));
        })*

        #[test]
        fn every_target_is_replayed() {
            let named: Vec<&str> = TARGETS.iter().map(|target| target.name).collect();
            assert_eq!(named, [$(stringify!($name)),*]);
        }
    };
}

replays!(demo, exr, graph, png, project, save, shader_text, spirv, vox, world, world_whole, zarr);

/// No target would run the corpus in a folder without a target.
#[test]
fn every_corpus_has_a_target() {
    let corpora = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus");
    for entry in std::fs::read_dir(corpora).expect("there are corpora") {
        let name = entry.expect("it can be listed").file_name().into_string().expect("its name is text");
        assert!(raxel_fuzz::find(&name).is_some(), "no target is called `{name}`");
    }
}
