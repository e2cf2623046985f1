//! `raxel new DIR` and `raxel init`: a project that runs with this binary alone. The binary contains its files, which raxel also ships.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use raxel_output::{Folders, Listed, on_stop, shown};
use raxel_terminal::args::Messages;
use raxel_terminal::console::{self, Console};
use raxel_terminal::failure::{Failure, Result};

use crate::own_model::OwnModel;
use crate::templates::Template;
use crate::verbs::schema;

/// Makes a project: graphs, shaders, worlds and the schemas that editors complete them with.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples: raxel new my-voxels && cd my-voxels && raxel run\n          \
                        raxel new castle --template beauty --model castle.vox")]
pub(crate) struct Args {
    /// The folder; it must be empty or not exist.
    #[arg(value_name = "DIR")]
    folder: PathBuf,

    /// The starting point.
    #[arg(long, value_enum, default_value_t = Template::Voxel)]
    template: Template,

    /// A MagicaVoxel scene of your own: it becomes the project's world, on a floor.
    #[arg(long, value_name = "FILE.vox")]
    model: Option<PathBuf>,

    #[command(flatten)]
    pub messages: Messages,
}

/// Makes a project of the current folder, and changes no file that is there.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: cd my-voxels && raxel init && raxel run")]
pub(crate) struct InitArgs {
    /// The starting point.
    #[arg(long, value_enum, default_value_t = Template::Voxel)]
    template: Template,

    #[command(flatten)]
    pub messages: Messages,
}

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
    let model = match &args.model {
        Some(model) if args.template.has_world() => Some(OwnModel::read(model, console)?),
        Some(_) => return Err(Failure::usage("`--model`: the template shows no world").help("--template beauty")),
        None => None,
    };
    fill(folder, args.template, model.as_ref(), &[])?;
    console.message(&format!("made a project in {}; next: cd {} && raxel run", shown(folder), console::word(folder)));
    Ok(())
}

/// Makes a project of the current folder.
pub(crate) fn init(args: &InitArgs, console: &Console) -> Result {
    let folder = Path::new(".");
    // A folder with a history of its own has these already; they are not needed.
    let own: Vec<&str> = ["README.md", ".gitignore"].into_iter().filter(|file| folder.join(file).exists()).collect();
    fill(folder, args.template, None, &own)?;
    console.message("made a project of this folder; next: raxel run");
    Ok(())
}

/// Writes the files of a template, except those that are left out. It writes all or none, and replaces no existing file.
fn fill(folder: &Path, template: Template, model: Option<&OwnModel>, left_out: &[&str]) -> Result {
    let mut files: BTreeMap<String, Cow<[u8]>> =
        template.files().into_iter().map(|(path, bytes)| (path.to_owned(), bytes.into())).collect();
    if let Some(model) = model {
        let manifest = String::from_utf8_lossy(&files["raxel.toml"]).into_owned();
        files.extend(model.files(&manifest).map(|(path, bytes)| (path, bytes.into())));
    }
    let mut made = Made::default();
    for (path, bytes) in files.iter().filter(|(path, _)| !left_out.contains(&path.as_str())) {
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

/// Files and folders that were made, in order. If the project is not completed, or a signal ends the process, raxel removes them:
/// half a project would block the next try.
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
                .help("`raxel new` replaces no file, and has written nothing"),
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
