//! `raxel schema`: the JSON schemas that editors complete and check TOML files with (`#:schema` on a file's first line).

use std::path::{Path, PathBuf};

use raxel_output::{Folders, Pending, shown};
use raxel_runtime::project::Project;
use raxel_runtime::{manifest, timeline};
use raxel_terminal::console::{self, Console};
use raxel_terminal::failure::Result;
use serde_json::Value;

/// Writes the JSON schemas of graphs, worlds, demos and manifests to .raxel/, or prints one.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "A file whose first line is `#:schema ../.raxel/graph.schema.json` is completed and checked by editors \
                        that know Taplo, e.g. VS Code with Even Better TOML."
)]
pub(crate) struct Args {
    /// Print this one to stdout instead.
    #[arg(value_enum)]
    kind: Option<Kind>,

    /// The project to write to; the one around the current folder by default.
    #[arg(long, value_name = "DIR")]
    project: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Kind {
    Graph,
    World,
    Demo,
    Project,
}

impl Kind {
    const ALL: [(Kind, &str); 4] =
        [(Kind::Graph, "graph"), (Kind::World, "world"), (Kind::Demo, "demo"), (Kind::Project, "project")];

    fn schema(self) -> Value {
        match self {
            Kind::Graph => raxel_graphfile::schema(),
            Kind::World => raxel_worldfile::schema(),
            Kind::Demo => timeline::schema(),
            Kind::Project => manifest::schema(),
        }
    }
}

pub(crate) fn run(args: &Args, console: &Console) -> Result {
    if let Some(kind) = args.kind {
        console::data(&format!("{:#}\n", kind.schema()));
        return Ok(());
    }
    let place = args.project.as_deref().unwrap_or(Path::new("."));
    let project = Project::around(place).map_err(|diagnostic| console.stop(&[*diagnostic]))?;
    let _folder = Folders::make(&project.on_disk(".raxel"))?;
    for (path, text) in files() {
        Pending::new(&project.on_disk(&path))?.finish(text.as_bytes())?;
    }
    console.message(&format!("wrote the schemas to {}", shown(&project.root().join(".raxel"))));
    Ok(())
}

/// Every schema: its path in a project, and its text.
pub(crate) fn files() -> impl Iterator<Item = (String, String)> {
    Kind::ALL.into_iter().map(|(kind, name)| (format!(".raxel/{name}.schema.json"), format!("{:#}\n", kind.schema())))
}
