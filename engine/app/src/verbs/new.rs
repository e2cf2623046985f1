//! `raxel new DIR` and `raxel init`: a project that runs with this binary alone. Its files are those that raxel ships, compiled in.

use std::fs;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use crate::args::Messages;
use crate::console::Console;
use crate::failure::{Failure, Result};
use crate::verbs::schema;
use raxel_output::{Folders, Listed, on_stop, shown};

/// What a new project starts from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Template {
    /// A traced voxel world with sun, shadow and sky.
    Voxel,
    /// One pass that paints the screen; no world.
    Minimal,
}

/// Makes a project: graphs, shaders, worlds and the schemas that editors complete them with.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: raxel new my-voxels && cd my-voxels && raxel run")]
pub(crate) struct Args {
    /// The folder; it must be empty or not exist.
    #[arg(value_name = "DIR")]
    folder: PathBuf,

    /// What to start from.
    #[arg(long, value_enum, default_value_t = Template::Voxel)]
    template: Template,

    #[command(flatten)]
    pub messages: Messages,
}

/// Makes a project of the current folder, beside the files that are there. None of them is changed.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: cd my-voxels && raxel init && raxel run")]
pub(crate) struct InitArgs {
    /// What to start from.
    #[arg(long, value_enum, default_value_t = Template::Voxel)]
    template: Template,

    #[command(flatten)]
    pub messages: Messages,
}

/// A file of a template: its path in the project and its bytes.
type TemplateFile = (&'static str, &'static [u8]);

macro_rules! shipped {
    ($($path:literal),* $(,)?) => { &[$(($path, include_bytes!(concat!("../../../../", $path)).as_slice())),*] };
}

const VOXEL: &[TemplateFile] = shipped![
    "graphs/primary.toml",
    "shaders/packet.comp",
    "shaders/packet_rest.comp",
    "shaders/primary.comp",
    "shaders/trace.comp",
    "worlds/valley.toml",
    "worlds/models/tree.vox",
    "worlds/models/pine.vox",
    "raxel.toml",
];

const VOXEL_OWN: &[TemplateFile] = &[("README.md", include_bytes!("../../templates/voxel/README.md").as_slice())];

const MINIMAL: &[TemplateFile] = &[
    ("README.md", include_bytes!("../../templates/minimal/README.md").as_slice()),
    ("graphs/primary.toml", include_bytes!("../../templates/minimal/graphs/primary.toml").as_slice()),
    ("shaders/paint.comp", include_bytes!("../../templates/minimal/shaders/paint.comp").as_slice()),
    ("raxel.toml", include_bytes!("../../templates/minimal/raxel.toml").as_slice()),
];

const EVERY: &[TemplateFile] = &[(".gitignore", include_bytes!("../../templates/gitignore").as_slice())];

pub(crate) fn run(args: &Args, console: &Console) -> Result {
    let folder = &args.folder;
    match fs::read_dir(folder) {
        Ok(mut entries) => {
            if entries.next().is_some() {
                return Err(Failure::usage(format!("`{}` is not empty", folder.display()))
                    .help("raxel new only fills a folder that is empty or does not exist"));
            }
        }
        Err(error) if error.kind() == ErrorKind::NotFound => {}
        Err(error) => return Err(Failure::usage(format!("`{}` cannot be used: {error}", folder.display()))),
    }
    fill(folder, args.template, &[])?;
    console.message(&format!("made a project in {}; next: cd {} && raxel run", shown(folder), folder.display()));
    Ok(())
}

/// Makes a project of the current folder.
pub(crate) fn init(args: &InitArgs, console: &Console) -> Result {
    let folder = Path::new(".");
    // A folder with a history of its own has these already; they are not needed.
    let own: Vec<&str> = ["README.md", ".gitignore"].into_iter().filter(|file| folder.join(file).exists()).collect();
    fill(folder, args.template, &own)?;
    console.message("made a project of this folder; next: raxel run");
    Ok(())
}

/// Writes the files of a template but those that are left out. All or none: no file that is there is replaced.
fn fill(folder: &Path, template: Template, left_out: &[&str]) -> Result {
    let files: Vec<&TemplateFile> = match template {
        Template::Voxel => VOXEL.iter().chain(VOXEL_OWN).chain(EVERY).collect(),
        Template::Minimal => MINIMAL.iter().chain(EVERY).collect(),
    };
    let mut made = Made::default();
    for (path, bytes) in files.into_iter().filter(|(path, _)| !left_out.contains(path)) {
        made.write(&folder.join(path), bytes)?;
    }
    for (path, text) in schema::files() {
        made.write(&folder.join(path), text.as_bytes())?;
    }
    for sub in ["worlds", "shaders"] {
        made.folder(&folder.join(sub))?;
    }
    made.keep();
    Ok(())
}

/// Files and folders that were made, in order. If they are not kept, or a signal ends the process, they are removed again: half a
/// project is of no use, and in the way of the next try.
#[derive(Default)]
struct Made(Vec<Entry>);

enum Entry {
    File { path: PathBuf, _listed: Listed },
    Folders(Folders),
}

impl Made {
    fn write(&mut self, path: &Path, bytes: &[u8]) -> Result {
        if let Some(folder) = path.parent() {
            self.folder(folder)?;
        }
        let fail = |error: std::io::Error| Failure::usage(format!("`{}` cannot be written: {error}", path.display()));
        let mut file = fs::File::create_new(path).map_err(|error| match error.kind() {
            ErrorKind::AlreadyExists => Failure::usage(format!("`{}` is there already", shown(path)))
                .help("the files of a project replace none; nothing was made"),
            _ => fail(error),
        })?;
        let leftover = path.to_owned();
        let listed = on_stop(move || drop(fs::remove_file(leftover)));
        self.0.push(Entry::File { path: path.to_owned(), _listed: listed });
        file.write_all(bytes).map_err(fail)
    }

    fn folder(&mut self, folder: &Path) -> Result {
        self.0.push(Entry::Folders(Folders::make(folder)?));
        Ok(())
    }

    /// All is well.
    fn keep(mut self) {
        for entry in self.0.drain(..) {
            if let Entry::Folders(folders) = entry {
                folders.keep();
            }
        }
    }
}

impl Drop for Made {
    fn drop(&mut self) {
        // The last first, so that folders are empty when it is their turn.
        while let Some(entry) = self.0.pop() {
            if let Entry::File { path, .. } = &entry {
                let _ = fs::remove_file(path);
            }
        }
    }
}
