//! The command line as a whole: its help, and the verb that it runs.

use std::path::PathBuf;

use clap::CommandFactory;
use raxel_terminal::cache;
use raxel_terminal::console::{Color, Console, Format};
use raxel_terminal::failure::Result;
use raxel_terminal::program::Program;
use raxel_terminal::trace::TraceWriter;

use crate::verbs;

/// A live, data-driven Vulkan render graph over voxel worlds.
#[derive(Debug, clap::Parser)]
#[command(
    name = "raxel",
    version,
    arg_required_else_help = true,
    disable_help_subcommand = false,
    after_help = "Examples:\n  raxel demo                                       a flight through a voxel valley, without a project\n  \
                  raxel run                                        the project's graph and world in a window\n  \
                  raxel run worlds/valley.demo.toml                a demo\n  \
                  raxel render graphs/primary.toml -o a.png        one picture, without a window\n  \
                  raxel check graphs/*.toml                        every mistake in every graph, without a GPU\n\n\
                  Exit codes: 0 ok, 1 a check failed, 2 usage, 3 graph, shader or world error, 4 no suitable device,\n\
                  5 device lost or timed out, 6 a validation message, 101 a bug in raxel"
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub verb: Verb,

    /// When to colour messages; NO_COLOR and CLICOLOR_FORCE are honoured.
    #[arg(long, global = true, value_enum, default_value_t = Color::Auto, value_name = "WHEN")]
    pub color: Color,

    /// Write a trace of the CPU's threads and the GPU's passes; ui.perfetto.dev shows it.
    #[arg(long, global = true, value_name = "FILE.json")]
    pub trace: Option<PathBuf>,

    /// Print more: which device was chosen and why, what is compiled, what comes from the cache.
    #[arg(long, short, global = true)]
    pub verbose: bool,
}

/// The verb, with its arguments.
#[derive(Debug, clap::Subcommand)]
pub(crate) enum Verb {
    Demo(verbs::demo::Args),
    Run(verbs::run::Args),
    Render(verbs::render::Args),
    Control(verbs::control::Args),
    Lsp(raxel_lsp::Args),
    Film(verbs::film::Args),
    Compare(verbs::compare::Args),
    Test(verbs::test::Args),
    Check(verbs::check::Args),
    Graph(verbs::graph::Args),
    List(verbs::list::Args),
    World(verbs::world::Args),
    Shaders(verbs::shaders::Args),
    New(verbs::new::Args),
    Init(verbs::new::InitArgs),
    Schema(verbs::schema::Args),
    Bench(Box<raxel_reports::bench::Args>),
    Stress(raxel_reports::stress::Args),
    Doctor(verbs::doctor::Args),
    Explain(verbs::explain::Args),
    Clean(verbs::clean::Args),
    Completions(verbs::completions::Args),
    Man(verbs::man::Args),
}

impl Verb {
    /// The form of messages that the verb was asked for.
    pub(crate) fn format(&self) -> Format {
        match self {
            Verb::Demo(args) => args.messages.format,
            Verb::Run(args) => args.messages.format,
            Verb::Render(args) => args.messages.format,
            Verb::Film(args) => args.messages.format,
            Verb::Compare(args) => args.messages.format,
            Verb::Test(args) => args.messages.format,
            Verb::Check(args) => args.messages.format,
            Verb::Graph(args) if args.format == verbs::graph::Form::Json => Format::Json,
            Verb::World(args) => args.format(),
            Verb::Shaders(args) => args.messages.format,
            Verb::New(args) => args.messages.format,
            Verb::Init(args) => args.messages.format,
            Verb::List(args) => args.messages.format,
            Verb::Bench(args) => args.format(),
            Verb::Stress(args) => args.format(),
            Verb::Doctor(args) => args.messages.format,
            Verb::Explain(args) => args.messages.format,
            Verb::Clean(args) => args.messages.format,
            Verb::Graph(_)
            | Verb::Schema(_)
            | Verb::Completions(_)
            | Verb::Man(_)
            | Verb::Control(_)
            | Verb::Lsp(_) => Format::Human,
        }
    }

    /// The program that drives it by lines of JSON.
    fn program(&self) -> Option<Program> {
        match self {
            // No frame runs without a request, so it may wait for the program.
            Verb::Control(_) => Some(Program::AtOnce),
            Verb::Run(args) => args.is_driven().then(Program::queued),
            _ => None,
        }
    }

    /// Whether its compiled shaders are kept for the next run.
    fn keeps_results(&self) -> bool {
        match self {
            // Its texts change with every key.
            Verb::Lsp(_) => false,
            Verb::Bench(args) => !args.measures_compilers(),
            _ => true,
        }
    }
}

impl Cli {
    /// Where messages go, and in what form.
    pub(crate) fn console(&self) -> Console {
        Console::new(self.verb.format(), self.color, self.verbose).driven(self.verb.program())
    }

    /// Runs its verb.
    pub(crate) fn run(self, console: &Console) -> Result {
        let trace = TraceWriter::listen(self.trace.as_deref(), console)?;
        if self.verb.keeps_results() {
            cache::open(console);
        }
        // A run that failed reports slow steps, too.
        let result = self.run_verb(console);
        result.and(trace.finish())
    }

    fn run_verb(self, console: &Console) -> Result {
        match self.verb {
            Verb::Demo(args) => verbs::demo::run(&args, &args.on.options(), console),
            Verb::Run(args) => verbs::run::run(&args, &args.on.options(), console),
            Verb::Render(args) => verbs::render::run(&args, &args.on.options(), console),
            Verb::Control(args) => verbs::control::run(&args, &args.on.options(), console),
            Verb::Lsp(args) => raxel_lsp::run(&args, console),
            Verb::Film(args) => verbs::film::run(&args, console),
            Verb::Compare(args) => verbs::compare::run(&args, console),
            Verb::Test(args) => verbs::test::run(&args, &args.on.options(), console),
            Verb::Check(args) => verbs::check::run(&args, console),
            Verb::Graph(args) => verbs::graph::run(&args, console),
            Verb::World(args) => verbs::world::run(&args, console),
            Verb::Shaders(args) => verbs::shaders::run(&args, console),
            Verb::New(args) => verbs::new::run(&args, console),
            Verb::Init(args) => verbs::new::init(&args, console),
            Verb::List(args) => verbs::list::run(&args, console),
            Verb::Schema(args) => verbs::schema::run(&args, console),
            Verb::Bench(args) => raxel_reports::bench::run(&args, &args.on.options(), console),
            Verb::Stress(args) => raxel_reports::stress::run(&args, &args.on.options(), console),
            Verb::Doctor(args) => verbs::doctor::run(&args, &args.on.options(), console),
            Verb::Explain(args) => verbs::explain::run(&args, console),
            Verb::Clean(args) => verbs::clean::run(&args, console),
            Verb::Completions(args) => {
                verbs::completions::run(&args, &mut Self::command());
                Ok(())
            }
            Verb::Man(args) => verbs::man::run(&args, Self::command(), console),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    /// `raxel check --device` names one that need not be here.
    #[test]
    fn only_verbs_that_open_a_device_have_its_options() {
        let mut with: Vec<String> = Vec::new();
        let command = Cli::command();
        for verb in command.get_subcommands() {
            let has = |name: &str| verb.get_arguments().any(|argument| argument.get_id() == name);
            assert_eq!(has("device"), has("validate"), "{}", verb.get_name());
            with.extend(has("device").then(|| verb.get_name().to_owned()));
        }
        assert_eq!(with, ["demo", "run", "render", "control", "test", "bench", "stress", "doctor"]);
    }
}
