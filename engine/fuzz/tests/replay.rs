//! The corpus, and mutations of it with fixed seeds. `RAXEL_FUZZ_INPUTS` is how many mutations each target gets instead of its own number, and
//! `RAXEL_FUZZ_SEED` where their seeds begin.

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
    for seed in begin..begin + number("RAXEL_FUZZ_INPUTS").unwrap_or(target.quick.into()) {
        let mut random = SplitMix64::new(seed);
        let mut pick = || &inputs[random.below(inputs.len() as u64) as usize].1;
        let (input, other) = (pick(), pick());
        let mutated = target.mutated(input, other, &mut random);
        tried(target, &format!("seed {seed}"), &mutated);
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

replays!(demo, graph, project, vox, world, world_whole);

/// A folder that belongs to no target is a corpus that nobody runs.
#[test]
fn every_corpus_has_a_target() {
    let corpora = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus");
    for entry in std::fs::read_dir(corpora).expect("there are corpora") {
        let name = entry.expect("it can be listed").file_name().into_string().expect("its name is text");
        assert!(raxel_fuzz::find(&name).is_some(), "no target is called `{name}`");
    }
}
