//! `raxel man`: manual pages, made of the command line itself.

use std::path::{Path, PathBuf};

use clap_mangen::Man;
use raxel_output::{Folders, Pending, shown};
use raxel_terminal::console::{self, Console};
use raxel_terminal::failure::{Exit, Failure, Result};

/// Writes the manual pages into a folder, or prints that of raxel.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  raxel man ~/.local/share/man/man1 && man raxel-render\n  raxel man | man -l -")]
pub(crate) struct Args {
    /// Where raxel.1 and a page for each verb go, e.g. raxel-render.1.
    #[arg(value_name = "FOLDER")]
    folder: Option<PathBuf>,
}

pub(crate) fn run(args: &Args, mut command: clap::Command, console: &Console) -> Result {
    // Names of subcommands are known after this.
    command.build();
    let Some(folder) = &args.folder else {
        console::data(&String::from_utf8_lossy(&page(&command)?));
        return Ok(());
    };
    let made = Folders::make(folder)?;
    let count = write(&command, folder)?;
    made.keep();
    console.message(&format!("wrote {count} pages to {}", shown(folder)));
    Ok(())
}

/// Writes the pages of a command and of those below it, and says how many.
fn write(command: &clap::Command, folder: &Path) -> Result<usize> {
    let name = command.get_display_name().unwrap_or(command.get_name());
    Pending::new(&folder.join(format!("{name}.1")))?.finish(&page(command)?)?;
    let mut count = 1;
    for below in command.get_subcommands().filter(|below| below.get_name() != "help") {
        count += write(below, folder)?;
    }
    Ok(count)
}

fn page(command: &clap::Command) -> Result<Vec<u8>> {
    let mut page = Vec::new();
    let man = Man::new(command.clone());
    man.render(&mut page).map_err(|error| Failure::new(Exit::Usage, format!("no manual page can be made: {error}")))?;
    Ok(page)
}
