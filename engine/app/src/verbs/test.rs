//! `raxel test`: demos as tests. A failed check makes the exit code 1.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use raxel_diagnostics::{Diagnostic, SourceMap, Span, codes};
use raxel_execute::Picture;
use raxel_gpu::DeviceOptions;
use raxel_measure::demo::FrameTimes;
use raxel_output::{Folders, Pending, write_picture};
use raxel_picture::Encoding;
use raxel_runtime::debug_target::DebugTarget;
use raxel_runtime::timeline::{Claim, Demo};
use raxel_runtime::{Observe, Options, Session};
use raxel_terminal::args::{Messages, OnDevice, each_once};
use raxel_terminal::console::{self, Console, Format, To};
use raxel_terminal::failure::{Exit, Failure, Result};
use raxel_terminal::offline::OfflineProject;
use raxel_terminal::session::{frame_failure, open_failure, print_messages, print_validation, validated};
use serde_json::json;

/// Runs the `[[check]]`s of demos: pictures against references by FLIP, GPU times of passes.
///
/// The demos run without a window, at their own size and frame rate. The exit code is 1 if a check fails.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  raxel test --write worlds/valley.demo.toml    look at the references that it wrote\n  \
                        raxel test                                    all demos of the project"
)]
pub(crate) struct Args {
    /// Demos; all of the project's that have checks by default.
    #[arg(value_name = "DEMO")]
    demos: Vec<PathBuf>,

    /// Write the references rather than compare with them.
    #[arg(long)]
    write: bool,

    #[command(flatten)]
    pub messages: Messages,

    #[command(flatten)]
    pub on: OnDevice,
}

pub(crate) fn run(args: &Args, device: &DeviceOptions, console: &Console) -> Result {
    let around = args.demos.first().map_or(Path::new("."), PathBuf::as_path);
    let offline = OfflineProject::around(around).map_err(|diagnostic| console.stop(&[*diagnostic]))?;
    let named = |path: &PathBuf| offline.project.path_of(path).map_err(|diagnostic| console.stop(&[*diagnostic]));
    let mut paths = args.demos.iter().map(named).collect::<Result<Vec<_>>>()?;
    if paths.is_empty() {
        paths = offline.project.demos();
    }
    let (mut checks, mut failed, mut complaints, mut asserted) = (0, 0, false, Ok(()));
    for path in each_once(paths) {
        let part = offline.loader.demo(&path);
        let texts = part.texts.clone();
        let demo = OfflineProject::good(part, console)?;
        if demo.checks.is_empty() {
            if !args.demos.is_empty() {
                return Err(Failure::usage(format!("`{path}` checks nothing")).help("[[check]] in it makes one"));
            }
            continue;
        }
        let mut test = Test {
            args,
            console,
            offline: &offline,
            texts: &texts,
            demo,
            found: Vec::new(),
            complaints: false,
            asserted: Ok(()),
        };
        test.run(device)?;
        checks += test.demo.checks.len();
        failed += test.found.len();
        complaints |= test.complaints;
        asserted = asserted.and(test.asserted);
    }
    match (checks, failed) {
        (0, _) => Err(Failure::usage("no demo of the project checks anything").help("[[check]] in a demo makes one")),
        (_, 0) if args.write => validated(complaints).and(asserted),
        (_, 0) => {
            console.message(&format!("{checks} check{} held", if checks == 1 { "" } else { "s" }));
            validated(complaints).and(asserted)
        }
        _ => Err(Failure::new(Exit::Check, format!("{failed} of {checks} checks do not hold"))),
    }
}

/// One demo under test.
struct Test<'a> {
    args: &'a Args,
    console: &'a Console,
    offline: &'a OfflineProject,
    texts: &'a SourceMap,
    demo: Arc<Demo>,
    found: Vec<Diagnostic>,
    complaints: bool,
    /// Whether all assertions of shaders have held.
    asserted: Result,
}

/// A picture that is looked at: index of the check, and the frame.
type Look = (usize, u64);

impl Test<'_> {
    /// A run for the passes and what the demo shows, and one for each other target.
    fn run(&mut self, device: &DeviceOptions) -> Result {
        let demo = self.demo.clone();
        let mut looks: BTreeMap<Option<String>, (Option<DebugTarget>, Vec<Look>)> = BTreeMap::new();
        let times_passes = demo.checks.iter().any(|check| matches!(check.claim, Claim::Pass { .. }));
        if times_passes {
            looks.insert(None, (None, Vec::new()));
        }
        for (index, check) in demo.checks.iter().enumerate() {
            if let Claim::Picture { frame, target, .. } = &check.claim {
                let target = target.as_ref().map(|target| target.value.clone());
                let key = target.as_ref().map(ToString::to_string);
                looks.entry(key).or_insert_with(|| (target, Vec::new())).1.push((index, frame.number()));
            }
        }
        for (target, mut looks) in looks.into_values() {
            looks.sort_by_key(|(_, frame)| *frame);
            let timed = target.is_none() && times_passes;
            self.shoot(device, target, &looks, timed)?;
        }
        // One by one, in the order of the file.
        self.found.sort_by_key(|diagnostic| diagnostic.labels.first().map(|label| label.span.range.start));
        self.console.diagnostics(&self.found, self.texts, To::Stderr);
        Ok(())
    }

    /// Runs the demo, as far as it is needed, and looks at the frames of checks.
    fn shoot(&mut self, device: &DeviceOptions, target: Option<DebugTarget>, looks: &[Look], timed: bool) -> Result {
        let demo = self.demo.clone();
        let options = Options {
            project: Some(self.offline.project.root().to_owned()),
            demo: Some(self.offline.project.on_disk(&console::word(Path::new(&demo.file)))),
            size: demo.size,
            step: Some(1.0 / demo.fps),
            device: device.device.clone(),
            validation: device.validation,
            observe: Observe::Shown,
            ..Options::default()
        };
        let mut session = Session::open(options).map_err(|error| open_failure(error, self.console))?;
        if let Some(target) = target {
            session.hold_debug_target(target).map_err(|error| Failure::usage(error.to_string()))?;
        }
        let end = if timed { demo.frames() } else { looks.last().map_or(0, |(_, frame)| frame + 1) };
        let mut times = FrameTimes::default();
        for frame in 0..end {
            let ran = if timed { times.frame(&mut session) } else { session.frame().map(drop) };
            ran.map_err(|error| frame_failure(error, self.console))?;
            for (index, _) in looks.iter().filter(|(_, of)| *of == frame) {
                let picture = session.read_presented()?;
                self.look(*index, picture)?;
            }
        }
        if timed {
            self.judge_passes(&times);
        }
        let asserted = print_messages(&mut session, self.console);
        self.asserted = std::mem::replace(&mut self.asserted, Ok(())).and(asserted);
        self.complaints |= print_validation(&session, self.console);
        Ok(())
    }

    /// Compares a picture with its reference, or makes it the reference.
    #[allow(clippy::needless_pass_by_value, reason = "nobody looks at it afterwards")]
    fn look(&mut self, index: usize, picture: Picture) -> Result {
        let demo = self.demo.clone();
        let check = &demo.checks[index];
        let Claim::Picture { frame, target, reference, flip } = &check.claim else { return Ok(()) };
        let frame = frame.number();
        let path = self.offline.project.on_disk(&reference.value);
        if self.args.write {
            if let Some(folder) = path.parent() {
                Folders::make(folder)?.keep();
            }
            write_picture(Pending::new(&path)?, &picture)?;
            self.console.message(&format!("wrote {}", reference.value));
            return Ok(());
        }
        let missing = |message: String| {
            Diagnostic::error(codes::session::NO_REFERENCE, message)
                .label(reference.span.clone(), "named here")
                .help(format!("`raxel test --write {}` writes it", demo.file))
        };
        let expected = match raxel_picture::read(&path, None) {
            Ok(expected) => expected,
            Err(error) => {
                self.found.push(missing(format!("`{}` cannot be read: {error}", reference.value)));
                return Ok(());
            }
        };
        let shown = raxel_picture::Picture {
            width: picture.width,
            height: picture.height,
            pixels: picture.rgba.chunks_exact(4).map(|p| [p[0], p[1], p[2]].map(|v| f32::from(v) / 255.0)).collect(),
            encoding: Encoding::Display,
        };
        let found = match raxel_picture::compare(&expected, &shown) {
            Ok(found) => found,
            Err(error) => {
                self.found.push(missing(format!("`{}` is not a reference of this demo: {error}", reference.value)));
                return Ok(());
            }
        };
        let holds = found.flip <= *flip;
        let name = target.as_ref().map_or("the picture".to_owned(), |target| format!("`{}`", target.value));
        self.say(&check.span, holds, &format!("{name} at frame {frame}: FLIP {:.6} of {flip}", found.flip), found.flip);
        if !holds {
            let beside = |what: &str| path.with_extension(format!("{what}.png"));
            write_picture(Pending::new(&beside("new"))?, &picture)?;
            let rgba = found.heat.chunks_exact(3).flat_map(|pixel| [pixel[0], pixel[1], pixel[2], 255]).collect();
            write_picture(Pending::new(&beside("diff"))?, &Picture { rgba, ..picture })?;
            let message =
                format!("{name} at frame {frame} is {:.4} from its reference by FLIP; {flip} is allowed", found.flip);
            self.found.push(
                Diagnostic::error(codes::session::PICTURE_DIFFERS, message)
                    .label(reference.span.clone(), "the reference")
                    .note(format!("the picture is beside it as {}", beside("new").display())),
            );
        }
        Ok(())
    }

    fn judge_passes(&mut self, times: &FrameTimes) {
        let demo = self.demo.clone();
        for verdict in times.judge(&demo) {
            let check = &demo.checks[verdict.index];
            let Claim::Pass { pass, below_ms } = &check.claim else { continue };
            let Some(median) = verdict.median_ms else {
                let message = format!("pass `{}` never ran, or the device has no clock", pass.value);
                self.found.push(
                    Diagnostic::error(codes::session::PASS_TOO_SLOW, message).label(pass.span.clone(), "this pass"),
                );
                continue;
            };
            let text = format!("pass `{}`: {median:.3} ms of {below_ms}", pass.value);
            self.say(&check.span, verdict.holds, &text, median);
            if !verdict.holds {
                let message = format!("pass `{}` takes {median:.3} ms; {below_ms} ms is allowed", pass.value);
                self.found.push(
                    Diagnostic::error(codes::session::PASS_TOO_SLOW, message)
                        .label(pass.span.clone(), "the median of all frames"),
                );
            }
        }
    }

    fn say(&self, span: &Span, holds: bool, text: &str, measured: f64) {
        if self.console.format() == Format::Json {
            console::json(&json!({
                "reason": "check",
                "demo": self.demo.file,
                "byte": span.range.start,
                "ok": holds,
                "measured": measured,
                "message": text,
            }));
        } else {
            console::data(&format!("{}: {} {text}\n", self.demo.file, if holds { "ok" } else { "FAILED" }));
        }
    }
}
