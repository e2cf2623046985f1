//! `raxel check`: everything that is wrong in graphs, worlds and demos, without a GPU.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use raxel_diagnostics::{Code, Diagnostic, Span};
use raxel_gpu::known::{self, KnownDevice};
use raxel_runtime::manifest;
use raxel_terminal::args::{Messages, each_once};
use raxel_terminal::console::{self, Console, Format, To};
use raxel_terminal::failure::{Exit, Failure, Result};
use raxel_terminal::offline::{Checked, FileKind, OfflineProject, PlannedOver};
use serde_json::json;

/// Reports every mistake in graphs, worlds, demos and the project's manifest (with the shaders and models they use), without a GPU.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Diagnostics go to stdout; with --format json one object a line, and one with \"reason\":\"checked\" \
                        after each file.\n\nExamples:\n  raxel check graphs/*.toml --format json\n  raxel check --device \"Raspberry Pi 5\""
)]
pub(crate) struct Args {
    /// Graphs, worlds, demos and manifests; all of the project's by default.
    #[arg(value_name = "FILE")]
    files: Vec<PathBuf>,

    /// The world that graphs are checked over (its bounds and materials); the project's by default, a demo's for its graph.
    #[arg(long, value_name = "WORLD")]
    world: Option<PathBuf>,

    /// Also refuse what this device cannot run, by its name or a part of it. It need not be here, and its memory is not known. An unknown name
    /// lists the known ones.
    #[arg(id = "known_device", long = "device", value_name = "NAME")]
    device: Option<String>,

    #[command(flatten)]
    pub messages: Messages,
}

pub(crate) fn run(args: &Args, console: &Console) -> Result {
    let mut bad = 0;
    let total;
    let mut told = Told::default();
    let device = args.device.as_deref().map(known).transpose()?;
    if args.files.is_empty() {
        let offline = OfflineProject::around(Path::new(".")).map_err(|diagnostic| console.stop(&[*diagnostic]))?;
        let offline = offline.for_checks().for_device(device);
        let project = &offline.project;
        let manifest = project.on_disk(manifest::PATH).exists().then(|| manifest::PATH.to_owned());
        let all: Vec<String> =
            [manifest.into_iter().collect(), project.graphs(), project.worlds(), project.demos()].concat();
        total = all.len();
        for path in &all {
            bad += u32::from(!check(&offline, path, args.world.as_deref(), (&mut told, console))?);
        }
    } else {
        let files = each_once(args.files.clone());
        total = files.len();
        let mut offline: Option<OfflineProject> = None;
        for named in &files {
            bad += u32::from(!check_named((&mut offline, device), named, args.world.as_deref(), (&mut told, console))?);
        }
    }
    if total == 0 {
        return Err(Failure::usage("the project has nothing to check: no graph, no world, no demo"));
    }
    if bad == 0 {
        return Ok(());
    }
    if console.format() == Format::Human && total > 1 {
        console.message(&format!("{bad} of {total} files have errors"));
    }
    Err(Failure::printed(Exit::Project))
}

/// The known device that somebody means.
fn known(name: &str) -> Result<&'static KnownDevice> {
    let found = known::named(name);
    let lines = |devices: &[&KnownDevice]| {
        devices.iter().fold(String::new(), |lines, device| format!("{lines}\n  {}", device.name))
    };
    match found[..] {
        [device] => Ok(device),
        [] => {
            let all = lines(&known::DEVICES.iter().collect::<Vec<_>>());
            Err(Failure::usage(format!("raxel knows no device `{name}`; it knows{all}")))
        }
        _ => Err(Failure::usage(format!("`{name}` is in the names of several devices:{}", lines(&found)))),
    }
}

/// Checks one file that the command line names; a project is opened again only when the file is in another one. True when it has
/// no error.
fn check_named(
    (offline, device): (&mut Option<OfflineProject>, Option<&KnownDevice>),
    named: &Path,
    world: Option<&Path>,
    (told, console): (&mut Told, &Console),
) -> Result<bool> {
    let opened = match offline.take() {
        Some(offline) if offline.project.path_of(named).is_ok() => Ok(offline),
        _ => OfflineProject::around(named).map(|opened| opened.for_checks().for_device(device)),
    };
    match opened.and_then(|opened| Ok((opened.project.path_of(named)?, opened))) {
        Ok((path, opened)) => check(offline.insert(opened), &path, world, (told, console)),
        Err(diagnostic) => {
            let found = vec![*diagnostic];
            let checked = Checked { found, ..Checked::default() };
            console.diagnostics(&checked.found, &checked.texts, To::Stdout);
            summary(&named.display().to_string(), None, (&checked, false), console);
            Ok(false)
        }
    }
}

/// Checks one file of a project. True when it has no error.
fn check(
    offline: &OfflineProject,
    path: &str,
    world: Option<&Path>,
    (told, console): (&mut Told, &Console),
) -> Result<bool> {
    let world = world.map(|named| offline.named_world(named, console)).transpose()?;
    let checked = offline.check(path, world.as_ref());
    // A program that reads JSON asks for the mistakes of each file.
    let whole = console.format() == Format::Json;
    let fresh: Vec<Diagnostic> = checked.found.iter().filter(|found| whole || told.is_new(found)).cloned().collect();
    console.diagnostics(&fresh, &checked.texts, To::Stdout);
    summary(path, Some(FileKind::of(path)), (&checked, !checked.found.is_empty() && fresh.is_empty()), console);
    Ok(checked.errors() == 0)
}

/// The mistakes that were reported already. Files share others (`extends`, includes, the graph of a demo), whose mistakes are reported once.
#[derive(Default)]
struct Told(HashSet<(Code, String, Span)>);

impl Told {
    /// Whether it was not printed yet. A diagnostic without a place is printed each time.
    fn is_new(&mut self, found: &Diagnostic) -> bool {
        let place = found.labels.first().map(|label| label.span.clone());
        place.is_none_or(|place| self.0.insert((found.code, found.message.clone(), place)))
    }
}

fn summary(path: &str, kind: Option<FileKind>, (checked, repeated): (&Checked, bool), console: &Console) {
    let errors = checked.errors();
    let warnings = checked.found.len() - errors;
    let over = checked.over.as_ref();
    let unbuilt = checked.unbuilt.map(|reach| reach.chunks);
    if console.format() == Format::Json {
        let mut summary = json!({ "reason": "checked", "file": path, "errors": errors, "warnings": warnings });
        let kind = kind.map(|kind| ("kind", json!(kind.name())));
        let world = over.and_then(PlannedOver::path).map(|world| ("world", json!(world)));
        let unbuilt = unbuilt.map(|chunks| ("unbuilt_chunks", json!(chunks)));
        let device = checked.device.as_ref().map(|device| ("device", json!(device)));
        for (key, value) in [kind, world, unbuilt, device].into_iter().flatten() {
            summary[key] = value;
        }
        console::json(&summary);
        return;
    }
    let count = |n: usize, what: &str| format!("{n} {what}{}", if n == 1 { "" } else { "s" });
    let result = match (errors, warnings) {
        (0, 0) => "ok".to_owned(),
        (0, _) => format!("ok, {}", count(warnings, "warning")),
        (_, 0) => count(errors, "error"),
        _ => format!("{}, {}", count(errors, "error"), count(warnings, "warning")),
    };
    let device = checked.device.as_ref().map_or(String::new(), |device| format!(" on {device}"));
    let assumed = over.and_then(PlannedOver::assumed).map_or(String::new(), |assumed| format!(" ({assumed})"));
    let above = if repeated { ", shown above" } else { "" };
    let unbuilt = unbuilt.map_or(String::new(), |chunks| {
        format!(
            "; its {chunks} chunks were not built: `raxel world info` builds them, and says how much memory they take"
        )
    });
    console.message(&format!("{path}: {result}{device}{above}{assumed}{unbuilt}"));
}
