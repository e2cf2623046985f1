//! Vulkan fails under a session: every call that may fail does, one after the other, as SQLite is tested with every allocation.
//!
//! A program with a library before Vulkan runs the same short session again and again. Each time another call answers with an error. The
//! program repeats the refused action. Then everything must be as if nothing had failed: the same texels, no panic, no message of the
//! validation layer, no leaked Vulkan object. `RAXEL_FAULTS=all` tries every call with every error, and `RAXEL_FAULTS=DeviceLost` every
//! call with that error; else a few calls of each kind are tried.
#![cfg(target_os = "linux")]

mod common;

use std::collections::{BTreeMap, BTreeSet};
use std::fs::OpenOptions;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::Duration;

use common::{CALLS, Fault, Faults, Project, Run, output};
use raxel::edit::{Brush, Operation};
use raxel::{Options, ReloadEvent, Session, Validation, Value};

const GRAPH: &str = include_str!("fixtures/faults/faults.toml");

const PART: &str = include_str!("fixtures/faults/part.comp");

const RARE: &str = r"#version 460
layout(local_size_x = 1) in;
layout(std430) buffer Rare { uint ticks[16]; } rare;
void main() { rare.ticks[0] += 1u; }
";

const SUM: &str = include_str!("fixtures/faults/sum.comp");

const WORLD: &str = include_str!("fixtures/faults/box.toml");

/// The final state of a session.
#[derive(Debug, PartialEq)]
struct Outcome {
    /// The part that does not depend on earlier frames, bit by bit.
    part: Vec<u32>,
    /// The part that does.
    sum: Vec<u32>,
    presented: Vec<u8>,
    rare: Vec<u8>,
    /// The actions that were refused, and done once more.
    refused: Vec<String>,
}

/// A step of the session; one that is refused is done once more.
fn again<T, E: std::fmt::Display>(
    refused: &mut Vec<String>,
    what: &str,
    mut step: impl FnMut() -> Result<T, E>,
) -> Result<T, String> {
    step().or_else(|error| {
        refused.push(format!("{what}: {error}"));
        step().map_err(|error| format!("{what}, once more: {error}"))
    })
}

fn frames(session: &mut Session, refused: &mut Vec<String>, count: usize) -> Result<(), String> {
    (0..count).try_for_each(|_| again(refused, "frame", || session.frame()).map(drop))
}

/// Writes a file, and waits until it runs. An edit that Vulkan has refused is written once more.
fn edited(session: &mut Session, refused: &mut Vec<String>, path: &Path, text: &str) -> Result<(), String> {
    std::fs::write(path, text).unwrap();
    for _ in 0..2 {
        'wait: loop {
            let events = session.wait_reload(Duration::from_millis(500));
            if session.device().is_lost() {
                // The builder waits for another device, which a frame opens.
                again(refused, "frame", || session.frame())?;
            }
            for event in events {
                match event {
                    ReloadEvent::Reloaded(_) => return Ok(()),
                    ReloadEvent::Failed(failed) => {
                        refused.push(format!("edit: {:?}", failed.diagnostics));
                        break 'wait;
                    }
                    ReloadEvent::HistoryCleared { .. }
                    | ReloadEvent::DeviceRebuilt { .. }
                    | ReloadEvent::NotOpened(_)
                    | ReloadEvent::Opened => {}
                }
            }
        }
        std::fs::write(path, format!("{text}\n")).unwrap();
    }
    Err(format!("{} was refused twice", path.display()))
}

/// A step of a session that is open. A device that is lost can do nothing: the next frame opens another one.
fn on<T, E: std::fmt::Display>(
    session: &mut Session,
    refused: &mut Vec<String>,
    what: &str,
    mut step: impl FnMut(&mut Session) -> Result<T, E>,
) -> Result<T, String> {
    step(session).or_else(|error| {
        refused.push(format!("{what}: {error}"));
        if session.device().is_lost() {
            frames(session, refused, 1)?;
        }
        step(session).map_err(|error| format!("{what}, once more: {error}"))
    })
}

fn bits(session: &mut Session, refused: &mut Vec<String>, name: &str) -> Result<Vec<u32>, String> {
    let texels = on(session, refused, "read", |session| session.read_target(name))?;
    Ok(texels.floats().iter().flatten().map(|value| value.to_bits()).collect())
}

/// The session: open, frames, reads, edits of a shader, the graph and the world, another size, another target, a jump in time.
fn scenario(root: &Path) -> Result<Outcome, String> {
    let shader = |scale: &str| SUM.replace("SCALE", scale);
    let write = |path: &str, text: &str| std::fs::write(root.join(path), text).unwrap();
    write("graphs/faults.toml", GRAPH);
    write("shaders/part.comp", PART);
    write("shaders/rare.comp", RARE);
    write("shaders/sum.comp", &shader("1.0"));
    write("worlds/box.toml", WORLD);
    let options = || Options {
        project: Some(root.to_owned()),
        graph: Some("graphs/faults.toml".into()),
        world: Some("worlds/box.toml".into()),
        size: [16, 16],
        validation: Validation::Required,
        pinned: vec!["sum".to_owned(), "part".to_owned(), "rare".to_owned()],
        watch: true,
        ..Options::default()
    };
    let mut refused = Vec::new();
    let mut session = again(&mut refused, "open", || Session::open(options()))?;
    let refused = &mut refused;
    frames(&mut session, refused, 3)?;
    on(&mut session, refused, "read", Session::read_presented)?;
    session.set_param("gain", Value::F32(2.0)).unwrap();
    frames(&mut session, refused, 1)?;
    edited(&mut session, refused, &root.join("shaders/sum.comp"), &shader("2.0"))?;
    frames(&mut session, refused, 1)?;
    edited(&mut session, refused, &root.join("graphs/faults.toml"), &GRAPH.replace("size = 64", "size = 128"))?;
    frames(&mut session, refused, 1)?;
    let blue = session.scene().material("blue").unwrap();
    let ball = [Operation::sphere([6.0, 6.0, 0.0], 3.0, Brush::Add(blue))];
    on(&mut session, refused, "edit", |session| session.edit(&ball))?;
    frames(&mut session, refused, 2)?;
    session.resize(24, 16);
    frames(&mut session, refused, 2)?;
    session.set_debug_target_text("sum").unwrap();
    frames(&mut session, refused, 1)?;
    session.seek(2.0);
    frames(&mut session, refused, 1)?;
    let ticket = on(&mut session, refused, "read", |session| session.request_texels("part", 0, 0, 0))?;
    frames(&mut session, refused, 1)?;
    // A lost device loses its pending requests, too.
    if let Err(error) = session.redeem(&ticket) {
        refused.push(format!("ticket: {error}"));
    }
    frames(&mut session, refused, 2)?;
    let part = bits(&mut session, refused, "part")?;
    let sum = bits(&mut session, refused, "sum")?;
    let rare = on(&mut session, refused, "read", |session| session.read_buffer("rare", 0..64))?;
    let presented = on(&mut session, refused, "read", Session::read_presented)?.rgba;
    on(&mut session, refused, "wait", Session::wait)?;
    Ok(Outcome { part, sum, presented, rare, refused: std::mem::take(refused) })
}

/// Ends the process when a run takes too long: something waits for ever.
struct Limit(#[expect(dead_code, reason = "its drop ends the thread")] Sender<()>);

impl Limit {
    fn new(what: String) -> Self {
        let (sender, receiver) = channel();
        std::thread::spawn(move || {
            if receiver.recv_timeout(Duration::from_secs(120)) == Err(RecvTimeoutError::Timeout) {
                println!("WRONG {what}: it does not end");
                std::process::abort();
            }
        });
        Self(sender)
    }
}

static PANICKED: AtomicBool = AtomicBool::new(false);

/// The calls of each kind to try, out of `count`.
fn chosen(count: usize, all: bool) -> BTreeSet<usize> {
    let most = if all { usize::MAX } else { 3 };
    if count <= most { (0..count).collect() } else { (0..most).map(|i| i * (count - 1) / (most - 1)).collect() }
}

/// The report of the child process, in a file: layers print to stdout in the middle of lines.
struct Report(PathBuf);

impl Report {
    fn of(root: &Path) -> Self {
        Self(root.join("report.txt"))
    }

    fn say(&self, line: &str) {
        let mut file = OpenOptions::new().create(true).append(true).open(&self.0).expect("a file can be made");
        writeln!(file, "{line}").expect("a file can be written");
    }

    fn read(&self) -> String {
        std::fs::read_to_string(&self.0).unwrap_or_default()
    }
}

/// The child process; it reports each fault.
fn try_all(root: &Path) {
    let report = Report::of(root);
    std::panic::set_hook(Box::new(|info| {
        PANICKED.store(true, Ordering::Relaxed);
        println!("PANIC {info}");
    }));
    let said = root.join("validation.txt");
    let validation = || std::fs::read_to_string(&said).unwrap_or_default();
    let faults = Faults::in_folder(root);
    let which = std::env::var("RAXEL_FAULTS").unwrap_or_default();
    let is_fault = |fault: &Fault| format!("{fault:?}") == which;
    let all = which == "all" || CALLS.iter().any(|(_, faults)| faults.iter().any(is_fault));
    let is_wanted = |call: &str, fault: Fault| match which.as_str() {
        "" | "all" => true,
        which if which.starts_with("vk") => which == call,
        _ => is_fault(&fault),
    };
    // The first instance of a process is never destroyed, so that the counted run is the second.
    faults.disarm();
    scenario(root).expect("nothing fails");
    faults.disarm();
    let whole = scenario(root).expect("nothing fails");
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for (name, _) in faults.disarm() {
        *counts.entry(name).or_default() += 1;
    }
    let (mut tried, mut reached, mut known) = (0, 0, validation().len());
    report.say(&format!("CALLS {counts:?}"));
    for (call, answers) in CALLS {
        for (turn, skip) in chosen(counts.get(*call).copied().unwrap_or(0), all).into_iter().enumerate() {
            let turns = if all { (0..answers.len()).collect() } else { vec![turn % answers.len()] };
            for fault in turns.into_iter().map(|turn| answers[turn]).filter(|fault| is_wanted(call, *fault)) {
                let what = format!("{call} {skip} {fault:?}");
                let limit = Limit::new(what.clone());
                faults.arm(call, skip, fault);
                let result = std::panic::catch_unwind(|| scenario(root));
                let failed = faults.disarm().into_iter().any(|(_, answer)| answer == fault as i32);
                drop(limit);
                (tried, reached) = (tried + 1, reached + usize::from(failed));
                match result {
                    Err(_) => report.say(&format!("WRONG {what}: a panic")),
                    Ok(Err(error)) => report.say(&format!("WRONG {what}: {error}")),
                    Ok(Ok(outcome)) => {
                        let lost = fault == Fault::DeviceLost;
                        let same = outcome.part == whole.part
                            && (lost
                                || (outcome.sum == whole.sum
                                    && outcome.presented == whole.presented
                                    && outcome.rare == whole.rare));
                        // A driver that refuses a format has not failed: the session reports that, and keeps its picture.
                        let no = fault == Fault::FormatNotSupported
                            && outcome.refused.iter().any(|text| text.contains("RX0410"));
                        if !same && !no {
                            report.say(&format!("WRONG {what}: other texels; refused {:?}", outcome.refused));
                        }
                    }
                }
                if PANICKED.swap(false, Ordering::Relaxed) {
                    report.say(&format!("WRONG {what}: a panic on some thread"));
                }
                let messages = validation();
                if messages.len() > known {
                    report.say(&format!("WRONG {what}: the validation layer says {}", &messages[known..]));
                    known = messages.len();
                }
            }
        }
    }
    report.say(&format!("TRIED {tried} REACHED {reached}"));
}

#[test]
#[ignore = "the child process of the test below"]
fn child() {
    let Some(root) = std::env::var_os("FAULTS_ROOT") else { return };
    try_all(&PathBuf::from(root));
}

#[test]
fn a_session_goes_on_after_any_call_of_vulkan_has_failed() {
    let project = Project::empty();
    let faults = Faults::new(&project);
    let settings = project.path("vk_layer_settings.txt");
    let log = project.path("validation.txt");
    std::fs::write(
        &settings,
        format!(
            r"khronos_validation.debug_action = VK_DBG_LAYER_ACTION_LOG_MSG
khronos_validation.report_flags = error,warn
khronos_validation.log_filename = {}
",
            log.display()
        ),
    )
    .unwrap();
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args(["--exact", "child", "--ignored", "--nocapture"]);
    command.envs(faults.variables()).env("FAULTS_ROOT", project.root()).env("VK_LAYER_SETTINGS_PATH", &settings);
    command.env("RAXEL_CACHE", project.path("cache"));
    let run = Run::from(output(&mut command));
    let report = Report::of(project.root()).read();
    let wrong = report.lines().filter(|line| line.starts_with("WRONG")).count();
    assert!(wrong == 0 && run.code == 0, "{wrong}\n{report}\n{}\n{}", run.stdout, run.stderr);
    let done = report.lines().find(|line| line.starts_with("TRIED"));
    let done = done.unwrap_or_else(|| panic!("it does not come to its end\n{report}\n{}\n{}", run.stdout, run.stderr));
    println!("{done}");
}
