//! Follows the book like a reader: each page in a fresh folder, from the top. The test writes every file and runs every command.
//!
//! | fence | what the test does |
//! |---|---|
//! | `toml file=graphs/a.toml` | writes the file, below the folder that the commands have gone to |
//! | `toml append=graphs/a.toml` | adds to the end of the file |
//! | `sh` | runs each command; it must end with exit code 0 |
//! | `sh exits=3` | the last command must end with this exit code |
//! | `sh needs=ffmpeg` | runs the commands where this program is installed |
//! | `sh no-run=display` | leaves the commands out; [`REASONS`] has the reasons that count |
//! | `text said` | the commands before it have printed these lines; a line `…` stands for any |
//!
//! `tests/docs/pieces.rs` has pieces of files, and commands of other pages.
//!
//! Pictures of a page are what its commands have made: `RAXEL_WRITE_DOCS=1 cargo test --profile checked --test book` writes them beside the page.
//!
//! `raxel` is the tested binary, and `$RAXEL_HOME` the repository. `RAXEL_BOOK=film` runs only the pages whose paths have this text in them.

mod common;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use common::markdown::{self, Block, pages};
use common::{Run, output, repository};
use rayon::prelude::*;

/// The list of the book's contents. Its folder is the root of the book.
const SUMMARY: &str = "docs/SUMMARY.md";
/// The folder of the pages that only the book has.
const PAGES: &str = "docs/book";
/// Why a command of the book is not run here.
const REASONS: [&str; 6] = ["build", "display", "editor", "install", "network", "slow"];
/// Most seconds that a command may take.
const SECONDS: &str = "120";

type Faults = Vec<String>;

fn read(path: &str) -> String {
    std::fs::read_to_string(repository().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

#[track_caller]
fn fails_with(faults: &Faults) {
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// The pages that the contents list.
fn listed() -> Vec<String> {
    let summary = read(SUMMARY);
    summary.lines().flat_map(markdown::links).map(|link| format!("docs/{link}")).collect()
}

#[test]
fn the_contents_list_every_page_once() {
    let listed = listed();
    let mut faults = Faults::new();
    let mut seen = BTreeSet::new();
    faults.extend(listed.iter().filter(|page| !seen.insert(*page)).map(|page| format!("{page} is listed twice")));
    let wanted = pages(PAGES).into_iter().chain(pages("docs/errors"));
    faults.extend(wanted.filter(|page| !seen.contains(&page)).map(|page| format!("{SUMMARY} leaves out {page}")));
    fails_with(&faults);
}

#[test]
fn links_and_pictures_lead_somewhere() {
    let (mut faults, mut links) = (Faults::new(), 0);
    for page in [SUMMARY.to_owned()].into_iter().chain(listed()) {
        let (dead, count) = markdown::dead_links(&page);
        faults.extend(dead);
        links += count;
    }
    fails_with(&faults);
    assert!(links > 300, "{links} links");
}

/// Every recipe is found from the page that lists them.
#[test]
fn every_recipe_is_listed() {
    let index = format!("{PAGES}/do/README.md");
    let text = read(&index);
    let links: BTreeSet<&str> = text.lines().flat_map(markdown::links).collect();
    let (mut faults, mut recipes) = (Faults::new(), 0);
    for page in pages(&format!("{PAGES}/do")).into_iter().filter(|page| *page != index) {
        let name = page.rsplit('/').next().unwrap();
        for heading in markdown::headings(&read(&page)).skip(1) {
            recipes += 1;
            let link = format!("{name}#{}", markdown::anchor(&heading));
            if !links.contains(link.as_str()) {
                faults.push(format!("{index}: {link} is not listed"));
            }
        }
    }
    fails_with(&faults);
    assert!(recipes >= 40, "{recipes} recipes");
}

/// Files, commands and what these print.
#[test]
fn every_page_can_be_followed() {
    let only = std::env::var("RAXEL_BOOK").unwrap_or_default();
    let pages: Vec<String> = pages(PAGES).into_iter().filter(|page| page.contains(&only)).collect();
    // Shaders that one page or run has compiled, another need not compile again.
    let cache = Path::new(env!("CARGO_TARGET_TMPDIR")).join("book");
    let found: Vec<Followed> = pages.par_iter().map(|page| follow(page, &cache)).collect();
    let faults: Faults = found.iter().flat_map(|page| page.faults.clone()).collect();
    fails_with(&faults);
    let sum = |count: fn(&Followed) -> usize| found.iter().map(count).sum::<usize>();
    let (run, left) = (sum(|page| page.run), sum(|page| page.left));
    println!("{run} commands were run, {left} were left out");
    assert!(left * 4 <= run, "too much of the book is not run: {left} commands beside {run}");
}

/// The result of a page.
#[derive(Default)]
struct Followed {
    faults: Faults,
    run: usize,
    left: usize,
}

fn follow(page: &str, cache: &Path) -> Followed {
    let mut followed = Followed::default();
    let shell = Shell::new(cache);
    let mut said = String::new();
    let text = read(page);
    for block in markdown::blocks(&text) {
        let at = |line: usize| format!("{page}:{line}");
        if let Some(file) = block.value("file").or(block.value("append")) {
            // Readers do not see the words behind a fence.
            let above = text.lines().take(block.number - 1).filter(|line| !line.is_empty()).last().unwrap_or_default();
            if !above.contains(&format!("`{file}`")) {
                followed.faults.push(format!("{}: the line above does not name {file}", at(block.number)));
            }
            let path = shell.folder().join(file);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            let before = match block.value("append") {
                // An empty line stands between the old text and the added text.
                Some(_) => std::fs::read_to_string(&path).unwrap_or_default() + "\n",
                None => String::new(),
            };
            std::fs::write(path, before + &included(page, &block.text)).unwrap();
        } else if block.language() == "sh" {
            let commands = commands(&block);
            if let Some(reason) = block.value("no-run") {
                followed.left += commands.len();
                if !REASONS.contains(&reason) {
                    followed.faults.push(format!("{}: `{reason}` is none of {REASONS:?}", at(block.number)));
                }
                continue;
            }
            if block.value("needs").is_some_and(|program| !is_installed(program)) {
                followed.left += commands.len();
                continue;
            }
            said.clear();
            let last = commands.last().map(|command| command.0);
            for (line, command) in commands {
                let wanted = if Some(line) == last { block.value("exits").unwrap_or("0") } else { "0" };
                let run = shell.run(&command);
                followed.run += 1;
                said += &run.stdout;
                said += &run.stderr;
                if run.code.to_string() != wanted {
                    let (code, text) = (run.code, format!("{}{}", run.stdout, run.stderr));
                    let text = text.trim_end().replace('\n', "\n    ");
                    let place = at(line);
                    followed.faults.push(format!("{place}: exit code {code}, not {wanted}: {command}\n    {text}"));
                    // The rest of the page needs the result of this step.
                    return followed;
                }
            }
        } else if block.info.iter().any(|word| word == "said") {
            for (index, line) in block.text.lines().enumerate() {
                let line = line.trim();
                if line != "…" && !said.contains(line) {
                    let place = at(block.number + 1 + index);
                    followed
                        .faults
                        .push(format!("{place}: this was not printed: {line}\n    {}", said.replace('\n', "\n    ")));
                    break;
                }
            }
        }
    }
    followed.faults.extend(pictures(page, &text, &shell.folder(), followed.left > 0));
    followed
}

/// Pictures of a page that its commands have not made; the others are written beside the page where that is asked for. Where commands were left
/// out, a picture may be missing.
fn pictures(page: &str, text: &str, made: &Path, left_out: bool) -> Faults {
    let mut faults = Faults::new();
    for line in markdown::lines(text).into_iter().filter(|line| !line.fenced && line.text.starts_with("![")) {
        for picture in markdown::links(&line.text).filter(|picture| !picture.contains('/') && !is_figure(picture)) {
            let (from, to) = (made.join(picture), repository().join(page).with_file_name(picture));
            if !from.exists() {
                let fault = format!("{page}:{}: no command makes {picture}", line.number);
                faults.extend((!left_out).then_some(fault));
            } else if std::env::var_os("RAXEL_WRITE_DOCS").is_some() {
                std::fs::copy(from, to).unwrap();
            }
        }
    }
    faults
}

/// Figures are drawn by hand.
fn is_figure(picture: &str) -> bool {
    Path::new(picture).extension().is_some_and(|extension| extension == "svg")
}

/// A block with the files that it includes, as mdBook puts them in.
fn included(page: &str, text: &str) -> String {
    let Some(path) = text.trim().strip_prefix("{{#include ").and_then(|rest| rest.strip_suffix("}}")) else {
        return text.to_owned();
    };
    let path = Path::new(page).parent().unwrap().join(path);
    read(path.to_str().unwrap())
}

fn is_installed(program: &str) -> bool {
    let folders = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&folders).any(|folder| folder.join(program).is_file())
}

/// The commands of a block with their lines. A command goes on as long as the shell waits for its end.
fn commands(block: &Block) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    let mut open: Option<(usize, String)> = None;
    for (index, line) in block.text.lines().enumerate() {
        let (number, command) = match open.take() {
            Some((number, begun)) => (number, format!("{begun}\n{line}")),
            None if line.trim().is_empty() || line.trim_start().starts_with('#') => continue,
            None => (block.number + 1 + index, line.to_owned()),
        };
        let whole = !command.ends_with('\\') && {
            let mut check = Command::new("sh");
            check.args(["-n", "-c", &command]).stdin(Stdio::null());
            output(&mut check).status.success()
        };
        if whole {
            found.push((number, command));
        } else {
            open = Some((number, command));
        }
    }
    found.extend(open);
    found
}

/// A reader's terminal: folder and variables last from command to command.
struct Shell {
    /// Where the page begins.
    _home: tempfile::TempDir,
    /// Where folder and variables are kept between commands.
    state: tempfile::TempDir,
    cache: PathBuf,
}

impl Shell {
    fn new(cache: &Path) -> Self {
        let [home, state] = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
        std::fs::write(state.path().join("folder"), home.path().to_str().unwrap()).unwrap();
        std::fs::write(state.path().join("variables"), "").unwrap();
        Self { _home: home, state, cache: cache.to_owned() }
    }

    /// The folder that the commands have gone to.
    fn folder(&self) -> PathBuf {
        std::fs::read_to_string(self.state.path().join("folder")).unwrap().trim_end().into()
    }

    fn run(&self, command: &str) -> Run {
        let script = format!(
            ". \"$BOOK_STATE/variables\"\n{command}\ncode=$?\npwd >\"$BOOK_STATE/folder\"\n\
             export -p >\"$BOOK_STATE/variables\"\nexit $code\n"
        );
        // It ends all that the command has started, as well.
        let mut shell = Command::new("timeout");
        shell.args(["-k", "5", SECONDS, "sh", "-c", &script]).current_dir(self.folder()).stdin(Stdio::null());
        let binary = Path::new(env!("CARGO_BIN_EXE_raxel")).parent().unwrap().to_owned();
        let path = std::env::var_os("PATH").unwrap_or_default();
        let folders = [binary].into_iter().chain(std::env::split_paths(&path));
        shell.env("PATH", std::env::join_paths(folders).unwrap());
        shell.env("BOOK_STATE", self.state.path());
        shell.env("RAXEL_HOME", repository()).env("RAXEL_CACHE", &self.cache);
        shell.env("NO_COLOR", "1").env_remove("CLICOLOR_FORCE").env_remove("RUST_BACKTRACE").env_remove("DISPLAY");
        shell.env("PYTHONDONTWRITEBYTECODE", "1").env_remove("RAXEL");
        output(&mut shell).into()
    }
}
