//! `raxel.toml`.

use raxel_diagnostics::{MemoryFiles, SourceMap};
use raxel_runtime::manifest;

use crate::bounds::Bounds;
use crate::{Mutation, Target, check, projects};

pub(crate) const TARGET: Target = Target {
    name: "project",
    run,
    bounds: Bounds::PARSER,
    mutation: Mutation::Toml(manifest::schema),
    seeds: &["raxel.toml"],
    longest: 4 << 10,
    quick: 4000,
};

fn run(input: &[u8]) {
    let there = ["graphs/primary.toml", "graphs/a.toml", "worlds/valley.toml", "worlds/a.toml", "worlds/a.demo.toml"];
    let files = MemoryFiles::new(there.map(|path| (path, "")));
    projects::add(&files, manifest::PATH, input);
    let mut texts = SourceMap::default();
    let Some(read) = check::outcome(manifest::read(&files, &mut texts), &texts) else { return };
    // A setting that is accepted can be used as it is.
    assert!(read.size.is_none_or(|size| size.iter().all(|side| (1..=16384).contains(side))));
    assert!(read.scale.is_none_or(|scale| scale.is_finite() && scale > 0.0));
    assert!(read.fps.is_none_or(|fps| (1e-3..=1000.0).contains(&fps)));
    for (path, folder) in [(read.graph, "graphs/"), (read.world, "worlds/"), (read.demo, "worlds/")] {
        assert!(path.is_none_or(|path| path.starts_with(folder) || there.contains(&path.as_str())));
    }
}
