//! raxel's own graphs, shaders and worlds need nothing of the folders `rivals`, but for the places in a list.

use std::collections::BTreeSet;

use raxel_rivals::RIVALS;

use crate::common::{Project, repository};

/// The files that name something of the rivals, each with the reason.
const EXCEPTIONS: [(&str, &str); 6] = [
    ("graphs/examples/model.toml", "shows that a model has a layout of its own"),
    ("graphs/examples/two_layouts.toml", "shows that two layouts agree, and the second is not raxel's own"),
    ("shaders/bench/first_hit.comp", "measures the marchers"),
    ("shaders/include/raxel/internal/trace.glsl", "runs the marcher `raymask` inside of its own walk"),
    ("shaders/include/raxel/world.glsl", "has a branch for every layout"),
    ("shaders/include/raxel/world/NAME.glsl", "has a branch for every layout"),
];

/// The names of files and sources in a line: between quotes, or behind `#include`.
fn names(line: &str) -> impl Iterator<Item = &str> {
    let included = line.strip_prefix("#include <").and_then(|rest| rest.split('>').next());
    line.split('"').skip(1).step_by(2).chain(included)
}

/// Whether a name leads to a folder of the rivals, or is a source with the layout of one.
fn is_rival(name: &str) -> bool {
    let source = name.starts_with("world.") || name.starts_with("model.");
    let layout = name.rsplit('.').next().filter(|_| source);
    name.split('/').any(|part| part == "rivals") || RIVALS.iter().any(|rival| layout == Some(rival.name()))
}

#[test]
fn the_product_needs_no_rival() {
    let files = Project::shipped().files().into_iter().filter(|path| !path.contains("rivals/"));
    let names_a_rival = |path: &String| {
        let text = std::fs::read_to_string(repository().join(path)).unwrap_or_default();
        text.lines().flat_map(names).any(is_rival)
    };
    let found: BTreeSet<String> = files.filter(names_a_rival).collect();
    let allowed: BTreeSet<String> = EXCEPTIONS.iter().map(|(path, _)| (*path).to_owned()).collect();
    let [needs, stale] = [found.difference(&allowed), allowed.difference(&found)].map(Iterator::collect::<Vec<_>>);
    assert!(needs.is_empty(), "these files name something of the rivals: {needs:?}");
    assert!(stale.is_empty(), "these files name nothing of the rivals any more: {stale:?}");
}

#[test]
fn rivals_are_known_by_folder_and_by_layout() {
    let is = |line: &str| names(line).any(is_rival);
    assert!(is("#include \"../rivals/march/raymask.glsl\"") && is("#include <raxel/rivals/march.glsl>"));
    assert!(
        is("source = \"world.svdag\"")
            && is("source = \"model.tree.bvh\"")
            && is("graph = \"graphs/rivals/naive.toml\"")
    );
    assert!(!is("source = \"world.tree64\"   # or svdag") && !is("// as rivals/march/pyramid.glsl does"));
}
