//! One file a verb.

pub(crate) mod completions;
pub(crate) mod explain;

use crate::args::{Cli, Verb};
use crate::failure::Result;
use crate::talk::Talk;

/// Runs the verb of a command line.
pub(crate) fn run(cli: Cli, talk: &Talk) -> Result {
    match cli.verb {
        Verb::Explain(args) => explain::run(&args, talk),
        Verb::Completions(args) => {
            completions::run(&args);
            Ok(())
        }
    }
}
