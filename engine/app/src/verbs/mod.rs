//! One file a verb.

pub(crate) mod bench;
pub(crate) mod check;
pub(crate) mod clean;
pub(crate) mod completions;
pub(crate) mod doctor;
pub(crate) mod explain;
pub(crate) mod graph;
pub(crate) mod new;
pub(crate) mod render;
pub(crate) mod run;
pub(crate) mod schema;
pub(crate) mod shaders;
pub(crate) mod stress;
pub(crate) mod world;

use raxel_gpu::{DeviceOptions, Validation};

use crate::args::{Cli, Verb};
use crate::failure::Result;
use crate::talk::Talk;

/// Runs the verb of a command line.
pub(crate) fn run(cli: Cli, talk: &Talk) -> Result {
    let validation = if cli.validate { Validation::Required } else { Validation::Off };
    let device = DeviceOptions { device: cli.device, validation };
    match cli.verb {
        Verb::Run(args) => run::run(&args, &device, talk),
        Verb::Render(args) => render::run(&args, &device, talk),
        Verb::Check(args) => check::run(&args, talk),
        Verb::Graph(args) => graph::run(&args, talk),
        Verb::World(args) => world::run(&args, talk),
        Verb::Shaders(args) => shaders::run(&args, talk),
        Verb::New(args) => new::run(&args, talk),
        Verb::Schema(args) => schema::run(&args, talk),
        Verb::Bench(args) => bench::run(&args, &device, talk),
        Verb::Stress(args) => stress::run(&args, &device, talk),
        Verb::Doctor(args) => doctor::run(&args, &device, talk),
        Verb::Explain(args) => explain::run(&args, talk),
        Verb::Clean(args) => clean::run(&args, talk),
        Verb::Completions(args) => {
            completions::run(&args);
            Ok(())
        }
    }
}
