//! `raxel world save`, `verify`, `compact` and `pack`: what is in the save of a world.

use std::path::PathBuf;

use raxel_diagnostics::names::grouped;
use raxel_diagnostics::{Diagnostic, SourceMap, codes};
use raxel_edit::save::{self, Compacted, Report, SaveError};
use raxel_output::{Pending, shown};
use raxel_runtime::Saves;
use raxel_runtime::project::Project;
use raxel_terminal::args::Messages;
use raxel_terminal::console::{self, Console, Format, To};
use raxel_terminal::failure::{Exit, Failure, Result};
use raxel_terminal::offline::OfflineProject;
use serde_json::json;

use super::info::bytes;

/// Writes the journals of a world's save into its chunks, and prints the sizes.
///
/// Opening the world then replays no journal.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: raxel world save worlds/quarry.toml")]
pub(crate) struct Save {
    #[command(flatten)]
    of: Of,
}

/// Reads every record of a world's save, and prints the sizes and all broken records.
///
/// The exit code is 1 if a record is broken.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: raxel world verify worlds/quarry.toml")]
pub(crate) struct Verify {
    #[command(flatten)]
    of: Of,
}

/// Rewrites a world's save, without replaced chunks and broken records.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: raxel world compact worlds/quarry.toml")]
pub(crate) struct Compact {
    #[command(flatten)]
    of: Of,
}

/// Packs a world's save into one file, to send it elsewhere.
///
/// To use it there, name it `chunks.log` and put it into the folder that `[save]` names.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: raxel world pack worlds/quarry.toml -o quarry.save")]
pub(crate) struct Pack {
    #[command(flatten)]
    of: Of,

    /// The file to write.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

/// A world that has a save.
#[derive(Debug, clap::Args)]
struct Of {
    /// A world file with [save]; the project's world by default.
    world: Option<PathBuf>,

    #[command(flatten)]
    messages: Messages,
}

impl Save {
    pub(crate) fn messages(&self) -> Messages {
        self.of.messages
    }

    pub(crate) fn run(&self, console: &Console) -> Result {
        let (offline, path, folder) = self.of.open(console)?;
        let mut saved = offline.saved_world(&path, Saves::Write, console)?;
        let found = saved.checkpoint();
        drop(saved);
        if !found.is_empty() {
            return Err(console.stop(&found));
        }
        print("saved", &path, &read(&folder, console)?, console);
        Ok(())
    }
}

impl Verify {
    pub(crate) fn messages(&self) -> Messages {
        self.of.messages
    }

    pub(crate) fn run(&self, console: &Console) -> Result {
        let (_, path, folder) = self.of.open(console)?;
        let report = read(&folder, console)?;
        print("verified", &path, &report, console);
        let broken: Vec<Diagnostic> = (report.damages.iter().filter(|damage| !damage.unfinished))
            .map(|damage| Diagnostic::error(codes::world::SAVE_DAMAGED, damage.to_string()))
            .collect();
        if broken.is_empty() {
            return Ok(());
        }
        let _ = console.stop(&broken);
        Err(Failure::printed(Exit::Check))
    }
}

impl Compact {
    pub(crate) fn messages(&self) -> Messages {
        self.of.messages
    }

    pub(crate) fn run(&self, console: &Console) -> Result {
        let (_, path, folder) = self.of.open(console)?;
        let report = read(&folder, console)?;
        let Compacted { before, after } = save::compact(&folder).map_err(|error| stop(&error, console))?;
        leaves_out(&report, console);
        match console.format() {
            Format::Json => {
                console::json(&json!({ "reason": "compacted", "world": path, "before": before, "after": after }));
            }
            _ => console.message(&format!("{path}: {} before, {} now", bytes(before), bytes(after))),
        }
        Ok(())
    }
}

impl Pack {
    pub(crate) fn messages(&self) -> Messages {
        self.of.messages
    }

    pub(crate) fn run(&self, console: &Console) -> Result {
        let pending = Pending::new(&self.output)?;
        let (_, path, folder) = self.of.open(console)?;
        let report = read(&folder, console)?;
        let packed = save::pack(&folder).map_err(|error| stop(&error, console))?;
        pending.finish(&packed)?;
        leaves_out(&report, console);
        match console.format() {
            Format::Json => {
                let size = packed.len();
                console::json(&json!({ "reason": "packed", "world": path, "file": self.output, "bytes": size }));
            }
            _ => console.message(&format!("wrote {} ({})", shown(&self.output), bytes(packed.len() as u64))),
        }
        Ok(())
    }
}

impl Of {
    /// The project, the path of the world in it, and the folder of its save.
    fn open(&self, console: &Console) -> Result<(OfflineProject, String, PathBuf)> {
        let (offline, path) = OfflineProject::of(self.world.as_deref(), Project::default_world, console)?;
        let world = offline.world(&path, console)?;
        let Some(settings) = &world.loaded().save else {
            return Err(
                Failure::usage(format!("`{path}` has no save")).help("[save] with a `path` in its file makes one")
            );
        };
        let folder = offline.project.on_disk(&settings.path.value);
        Ok((offline, path, folder))
    }
}

/// Reads a save that must exist.
fn read(folder: &std::path::Path, console: &Console) -> Result<Report> {
    let report = save::verify(folder).map_err(|error| stop(&error, console))?;
    if report.files.is_empty() {
        return Err(Failure::usage(format!("nothing was saved yet in `{}`", folder.display())));
    }
    Ok(report)
}

/// Reports the broken parts that a rewritten save leaves out.
fn leaves_out(report: &Report, console: &Console) {
    let broken: Vec<Diagnostic> = (report.damages.iter().filter(|damage| !damage.unfinished))
        .map(|damage| Diagnostic::warning(codes::world::SAVE_DAMAGED, format!("left out: {damage}")))
        .collect();
    console.diagnostics(&broken, &SourceMap::default(), To::Stderr);
}

fn stop(error: &SaveError, console: &Console) -> Failure {
    let code = match error {
        SaveError::Newer { .. } => codes::world::SAVE_NEWER,
        SaveError::Generator { .. } => codes::world::SAVE_GENERATOR,
        SaveError::Materials { .. } => codes::world::SAVE_MATERIALS,
        SaveError::ReadOnly { .. } => codes::world::SAVE_READ_ONLY,
        SaveError::Place { .. } => codes::world::SAVE_PLACE,
        SaveError::Io { .. } => codes::world::SAVE_UNREADABLE,
    };
    console.stop(&[Diagnostic::error(code, error.to_string())])
}

fn print(reason: &str, path: &str, report: &Report, console: &Console) {
    if console.format() == Format::Json {
        let files: Vec<_> = (report.files.iter())
            .map(|file| json!({ "name": file.name, "bytes": file.bytes, "records": file.records }))
            .collect();
        let damages: Vec<_> = (report.damages.iter())
            .map(|damage| {
                json!({
                    "file": damage.file,
                    "from": damage.bytes.start,
                    "to": damage.bytes.end,
                    "what": damage.what,
                    "unfinished": damage.unfinished,
                })
            })
            .collect();
        console::json(&json!({
            "reason": reason,
            "world": path,
            "bytes": report.bytes(),
            "chunks": report.chunks,
            "replaced": report.replaced,
            "applied": report.applied,
            "newest": report.newest,
            "files": files,
            "damages": damages,
        }));
        return;
    }
    let count = |n, what: &str| format!("{} {what}{}", grouped(n), if n == 1 { "" } else { "s" });
    let mut text = format!("{path}: {}, {}\n", count(report.newest, "edit"), bytes(report.bytes()));
    for file in &report.files {
        text += &format!("  {:<20} {} in {}\n", file.name, bytes(file.bytes), count(file.records, "record"));
    }
    text += &format!(
        "  {} with the edits up to {}, {} of chunks replaced by newer ones\n",
        count(report.chunks, "chunk"),
        grouped(report.applied),
        count(report.replaced, "record")
    );
    for damage in report.damages.iter().filter(|damage| damage.unfinished) {
        text += &format!(
            "  {}: {} bytes at the end were being written\n",
            damage.file,
            damage.bytes.end - damage.bytes.start
        );
    }
    console::data(&text);
}
