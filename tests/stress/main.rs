//! `raxel stress`: every tracer is held to the exact one, a broken one is caught, and the same command counts the same.

#[path = "../common/mod.rs"]
mod common;

mod runs;
mod scenes;
mod tracers;

use std::collections::BTreeMap;

use common::{Project, Run, repository};
use serde_json::Value;

/// The rows of a run, by name.
fn rows(run: &Run) -> BTreeMap<String, Value> {
    let named = |value: Value| Some((value["row"].as_str()?.to_owned(), value));
    run.json().into_iter().filter(|value| value["reason"] == "stressed").filter_map(named).collect()
}

/// A project whose tracer never asks integers when floating point cannot decide.
fn broken() -> Project {
    let project = Project::empty();
    let walk = std::fs::read_to_string(repository().join("shaders/include/raxel/internal/walk.glsl")).unwrap();
    let (before, rest) = walk.split_once("const float RX_WALK_ERROR = ").expect("the bound of the tracer's error");
    let (_, after) = rest.split_once(';').unwrap();
    project
        .write("shaders/include/raxel/internal/walk.glsl", format!("{before}const float RX_WALK_ERROR = 0.0;{after}"));
    project
}
