//! Random graphs in a session on a real device, under validation, against a slow interpreter of docs/graph-file.md: every frame, what is
//! shown and what can be read are what the interpreter says, through resizes, seeks, resets, params, other debug targets, and reloads of
//! the graph and its shaders.
//!
//! `RAXEL_REFERENCE_GRAPHS=N` runs N graphs, from `RAXEL_REFERENCE_SEED` on (0 when left out).

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

use std::ops::Range;

#[path = "../project/mod.rs"]
mod project;

mod drive;
mod generate;
mod interpreter;
mod model;
mod shaders;
mod write;

/// Graphs of the normal test run, in two threads, beside [`FOUND`].
const GRAPHS: u64 = 140;

/// Graphs that once failed: after a resize, raxel skipped a pass that asks for the size of its input.
const FOUND: Range<u64> = 520..540;

/// Graphs that one session runs, one after the other.
const A_SESSION: u64 = 20;

fn number(variable: &str, otherwise: u64) -> u64 {
    std::env::var(variable).ok().map_or(otherwise, |text| text.parse().expect("a number"))
}

#[test]
fn random_graphs_are_as_written() {
    let first = number("RAXEL_REFERENCE_SEED", 0);
    let end = first + number("RAXEL_REFERENCE_GRAPHS", GRAPHS);
    let middle = first + (end - first) / 2;
    std::thread::scope(|scope| {
        for part in [first..middle, middle..end, FOUND] {
            scope.spawn(move || {
                let mut seed = part.start;
                while seed < part.end {
                    let next = part.end.min(seed + A_SESSION);
                    drive::run(seed..next);
                    seed = next;
                }
            });
        }
    });
}
