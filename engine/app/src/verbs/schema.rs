//! `raxel schema`: the JSON schemas that editors complete and check TOML files with (`#:schema` on a file's first line).

use std::fs;
use std::path::{Path, PathBuf};

use raxel_runtime::project::Project;
use raxel_runtime::timeline;
use serde_json::Value;

use crate::failure::{Failure, Result};
use crate::output::{Pending, shown};
use crate::talk::{self, Talk};

/// Writes the JSON schemas of graphs, worlds and demos to .raxel/, or prints one.
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
}

impl Kind {
    const ALL: [(Kind, &str); 3] = [(Kind::Graph, "graph"), (Kind::World, "world"), (Kind::Demo, "demo")];

    fn schema(self) -> Value {
        match self {
            Kind::Graph => raxel_graph::schema(),
            Kind::World => raxel_world::file::schema(),
            Kind::Demo => timeline::schema(),
        }
    }
}

pub(crate) fn run(args: &Args, talk: &Talk) -> Result {
    if let Some(kind) = args.kind {
        talk::data(&format!("{:#}\n", kind.schema()));
        return Ok(());
    }
    let place = args.project.as_deref().unwrap_or(Path::new("."));
    let project = Project::around(place).map_err(|diagnostic| talk.stop(&[*diagnostic]))?;
    write_all(project.root())?;
    talk.say(&format!("wrote the schemas to {}", shown(&project.root().join(".raxel"))));
    Ok(())
}

/// Writes every schema into a project.
pub(crate) fn write_all(root: &Path) -> Result {
    let folder = root.join(".raxel");
    fs::create_dir_all(&folder)
        .map_err(|error| Failure::usage(format!("the folder `{}` cannot be made: {error}", folder.display())))?;
    for (kind, name) in Kind::ALL {
        let path = folder.join(format!("{name}.schema.json"));
        Pending::new(&path)?.finish(format!("{:#}\n", kind.schema()).as_bytes())?;
    }
    Ok(())
}
