//! Vulkan fails under `raxel render`, `raxel control` and `raxel stress`: one call of one run fails, with each error that it may answer. A run goes
//! on and gives the same results, or ends with one error and its exit code. It never panics, hangs, or makes the validation layer speak.
//!
//! The suite tries a few calls, chosen by the seed `RAXEL_FAULTS_SEED`. `-- --ignored` tries all calls with all
//! errors, up to [`MOST`] calls of one name.
#![cfg(target_os = "linux")]

mod common;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::Write;
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::time::Duration;

use common::{CALLS, Fault, Faults, Project, Run, Running, Said, chosen, command, line, read_all};
use serde_json::{Value, json};
use wait_timeout::ChildExt;

/// Many times what the longest run takes.
const LIMIT: Duration = Duration::from_secs(120);

/// As many calls of one name fail, each in a run of its own.
const MOST: usize = 12;

const SCENE: [&str; 5] = ["graphs/inspect.toml", "--world", "worlds/menger.toml", "--size", "32x18"];

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Verb {
    /// Two frames, to files.
    Render,
    /// A frame, a read, an edit of the graph, a frame, a read. A request that is refused is sent again.
    Control,
    /// A few rays through one layout of two scenes.
    Stress,
}

const VERBS: [Verb; 3] = [Verb::Render, Verb::Control, Verb::Stress];

/// One call that fails: which of its name, from 0, with what.
#[derive(Clone, Copy, Debug)]
struct Case {
    verb: Verb,
    call: &'static str,
    skip: usize,
    fault: Fault,
}

/// The output of a run besides its exit code.
#[derive(Debug, Default, PartialEq)]
struct Results(Vec<Vec<u8>>);

impl Results {
    /// Whether these are some of the whole, in their order.
    fn is_part_of(&self, whole: &Self) -> bool {
        let mut rest = whole.0.iter();
        self.0.iter().all(|now| rest.any(|other| other == now))
    }
}

/// A project behind the library, for one run at a time.
struct Stage {
    project: Project,
    faults: Faults,
    graph: String,
}

impl Stage {
    fn new() -> Self {
        let project = Project::shipped();
        let faults = Faults::new(&project);
        let graph = fs::read_to_string(project.path(SCENE[0])).unwrap();
        Self { project, faults, graph }
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = command(self.project.root(), &[arguments, &["--validate"]].concat());
        command.envs(self.faults.variables()).env("RAXEL_CACHE", self.project.path("cache"));
        command
    }

    /// Runs the verb; a run that does not end is an error.
    fn run(&self, verb: Verb) -> Result<(Run, Results), String> {
        match verb {
            Verb::Render => self.render(),
            Verb::Control => self.control(),
            Verb::Stress => self.stress(),
        }
    }

    fn render(&self) -> Result<(Run, Results), String> {
        let out = self.project.path("out");
        let _ = fs::remove_dir_all(&out);
        fs::create_dir(&out).unwrap();
        let run =
            finish(&mut self.command(&[&["render"], &SCENE[..], &["--frames", "2", "-o", "out/%d.png"]].concat()))?;
        // Frames that were done before the fault stay, and are whole; nothing else is left.
        let mut names: Vec<_> = fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        names.sort();
        let whole = ["0.png", "1.png"];
        if !whole[..names.len().min(2)].iter().eq(names.iter()) || (run.code == 0 && names.len() < 2) {
            return Err(format!("exit code {} leaves {names:?}\n{}", run.code, run.stderr));
        }
        Ok((run, Results(names.iter().map(|name| fs::read(out.join(name)).unwrap()).collect())))
    }

    fn stress(&self) -> Result<(Run, Results), String> {
        let rays = ["--scenes", "menger@near,dust@far", "--rays", "4000"];
        let arguments = [&["stress", "--layouts", "tree64"], &rays[..], &["-o", "counts.csv"]].concat();
        let counts = self.project.path("counts.csv");
        let _ = fs::remove_file(&counts);
        let run = finish(&mut self.command(&arguments))?;
        // Times are the only thing that differs between runs.
        let text = fs::read_to_string(&counts).unwrap_or_default();
        let columns: Vec<usize> = text
            .lines()
            .take(1)
            .flat_map(|head| head.split(',').enumerate())
            .filter(|(_, name)| !["seconds", "mrays", "device", "driver"].iter().any(|word| name.contains(word)))
            .map(|(column, _)| column)
            .collect();
        let line = |line: &str| {
            let cells: Vec<&str> = line.split(',').collect();
            columns.iter().map(|column| cells[*column]).collect::<Vec<_>>().join(",").into_bytes()
        };
        let lines = text.lines().map(line).collect();
        Ok((run, Results(lines)))
    }

    fn control(&self) -> Result<(Run, Results), String> {
        fs::write(self.project.path(SCENE[0]), &self.graph).unwrap();
        let mut command = self.command(&[&["control"], &SCENE[..]].concat());
        let mut child = Running::start(command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()));
        let said = read_all(child.0.stderr.take());
        let answers = Said::by(child.0.stdout.take().unwrap(), line);
        let talk = talk(&mut child, &answers, &mut |turn| {
            // Another image, and another text each time.
            let edited = self.graph.replacen("[targets.depth]", "[targets.depth]\nhistory = 1", 1) + &"\n".repeat(turn);
            fs::write(self.project.path(SCENE[0]), edited).unwrap();
        });
        let status = child.0.wait_timeout(LIMIT).unwrap();
        let code = status.map(|status| status.code().unwrap_or(-1));
        drop(child);
        let stderr = String::from_utf8(said.join().unwrap()).unwrap();
        let code = code.ok_or_else(|| format!("it does not end\n{stderr}"))?;
        let run = Run { code, stdout: String::new(), stderr };
        match talk {
            Ok(values) => Ok((run, Results(values))),
            // It ended before it was asked to.
            Err(None) if run.code != 0 => Ok((run, Results::default())),
            Err(reason) => Err(format!("exit code {}, {reason:?}\n{}", run.code, run.stderr)),
        }
    }
}

/// The requests of a session that a program drives; the values of its reads. `Err(None)` when the program ends before `quit`.
fn talk(
    child: &mut Running,
    answers: &Said<String>,
    edit: &mut dyn FnMut(usize),
) -> Result<Vec<Vec<u8>>, Option<String>> {
    let mut requests = child.0.stdin.take().unwrap();
    let next = || -> Result<Value, Option<String>> {
        loop {
            let line = answers.within(LIMIT).map_err(|silent| silent.then(|| "no answer".to_owned()))?;
            let line: Value = serde_json::from_str(&line).map_err(|error| Some(format!("{error}: {line}")))?;
            if line.get("event").is_none_or(|event| event == "ready") {
                return Ok(line);
            }
        }
    };
    next()?;
    let mut values = Vec::new();
    for (what, request) in [
        ("step", json!({ "do": "step" })),
        ("pixel", json!({ "do": "pixel", "target": "depth", "x": 16, "y": 9 })),
        ("edit", json!({ "do": "wait_reload", "seconds": 60 })),
        ("step", json!({ "do": "step" })),
        ("pixel", json!({ "do": "pixel", "target": "depth", "x": 16, "y": 9 })),
        ("quit", json!({ "do": "quit" })),
    ] {
        let mut refused = Vec::new();
        loop {
            if writeln!(requests, "{request}").is_err() {
                return Err(None);
            }
            if what == "edit" {
                edit(refused.len());
            }
            let answer = next()?;
            if answer["ok"] == json!(true) && (what != "edit" || answer["reloaded"] == json!(true)) {
                values.extend(answer.get("bits").map(|bits| bits.to_string().into_bytes()));
                break;
            }
            refused.push(answer.to_string());
            if refused.len() == 3 {
                return Err(Some(format!("{what} is refused each time: {refused:?}")));
            }
            // A device that is lost is opened again by the next frame.
            if what == "pixel" && refused.len() == 1 {
                let _ = writeln!(requests, "{}", json!({ "do": "step" }));
                next()?;
            }
        }
    }
    Ok(values)
}

fn finish(command: &mut Command) -> Result<Run, String> {
    let mut child = Running::start(command.stdout(Stdio::piped()).stderr(Stdio::piped()));
    let (stdout, stderr) = (read_all(child.0.stdout.take()), read_all(child.0.stderr.take()));
    let status = child.0.wait_timeout(LIMIT).unwrap();
    drop(child);
    let [stdout, stderr] = [stdout, stderr].map(|pipe| String::from_utf8(pipe.join().unwrap()).unwrap());
    let status = status.ok_or_else(|| format!("it does not end\n{stderr}"))?;
    Ok(Run { code: status.code().unwrap_or(-1), stdout, stderr })
}

/// The fault in how a run ended.
fn judge(run: &Run, results: &Results, whole: &Results) -> Option<String> {
    let errors = run.stderr.lines().filter(|line| line.starts_with("error")).count();
    let wrong = if run.stderr.contains("panicked") || run.stderr.contains("bug in raxel") {
        "it panics"
    } else if run.stderr.contains("validation ") {
        "the validation layer speaks"
    } else if !results.is_part_of(whole) {
        "the results are others"
    } else {
        match run.code {
            0 if results.0.len() == whole.0.len() => return None,
            0 => "results are missing",
            3..=5 if errors == 1 => return None,
            3..=5 => "it says not one error",
            _ => "another exit code",
        }
    };
    Some(format!("{wrong}: exit code {}\n{}", run.code, run.stderr))
}

/// Every case of these verbs, from a run of each without failures.
fn every_case(stage: &Stage) -> (Vec<Case>, BTreeMap<&'static str, Results>) {
    let (mut cases, mut whole) = (Vec::new(), BTreeMap::new());
    for verb in VERBS {
        let right = |(run, results): (Run, Results)| {
            assert_eq!(run.code, 0, "{verb:?}: {}", run.stderr);
            results
        };
        // The first run fills the cache.
        right(stage.run(verb).unwrap());
        stage.faults.disarm();
        whole.insert(name(verb), right(stage.run(verb).unwrap()));
        let mut counts: BTreeMap<String, usize> = BTreeMap::new();
        for (call, _) in stage.faults.disarm() {
            *counts.entry(call).or_default() += 1;
        }
        let before = cases.len();
        for (call, answers) in CALLS {
            let count = counts.get(*call).copied().unwrap_or(0);
            // The first and the last, and others in equal steps.
            let most = count.min(MOST);
            for skip in (0..most).map(|turn| if most < 2 { 0 } else { turn * (count - 1) / (most - 1) }) {
                cases.extend(answers.iter().map(|fault| Case { verb, call, skip, fault: *fault }));
            }
        }
        println!("{verb:?}: {} cases of {counts:?}", cases.len() - before);
    }
    (cases, whole)
}

fn name(verb: Verb) -> &'static str {
    match verb {
        Verb::Render => "render",
        Verb::Control => "control",
        Verb::Stress => "stress",
    }
}

/// Tries cases on all cores, and returns the defects.
fn try_each(first: Stage, cases: Vec<Case>, whole: &BTreeMap<&'static str, Results>) {
    let count = cases.len();
    let threads = std::thread::available_parallelism().map_or(2, |cores| cores.get().max(2));
    let stages: Vec<Stage> = std::iter::once(first).chain((1..threads.min(count)).map(|_| Stage::new())).collect();
    let (cases, wrong) = (Mutex::new(cases), Mutex::new(Vec::new()));
    let ends: Mutex<BTreeMap<String, usize>> = Mutex::default();
    let said: Mutex<BTreeSet<String>> = Mutex::default();
    let try_case = |stage: &Stage, case: Case| {
        stage.faults.arm(case.call, case.skip, case.fault);
        let ran = stage.run(case.verb);
        let reached = stage.faults.disarm().into_iter().any(|(_, answer)| answer == case.fault as i32);
        let end = match &ran {
            Ok((run, _)) => format!("{:?} ends with {}", case.verb, run.code),
            Err(_) => format!("{:?} is wrong", case.verb),
        };
        *ends.lock().unwrap().entry(if reached { end } else { "not reached".to_owned() }).or_default() += 1;
        if let Ok((run, _)) = &ran {
            let errors = run.stderr.lines().filter(|line| line.starts_with("error")).map(str::to_owned);
            said.lock().unwrap().extend(errors);
        }
        let found = match ran {
            Ok((run, results)) => judge(&run, &results, &whole[name(case.verb)]),
            Err(reason) => Some(reason),
        };
        if let Some(found) = found {
            let found = format!("{case:?} (reached: {reached}): {found}");
            // At once: a long run may be cut off.
            println!("{found}");
            wrong.lock().unwrap().push(found);
        }
    };
    std::thread::scope(|scope| {
        for stage in stages {
            let (cases, try_case) = (&cases, &try_case);
            scope.spawn(move || {
                while let Some(case) = { cases.lock().unwrap().pop() } {
                    try_case(&stage, case);
                }
            });
        }
    });
    let (wrong, ends) = (wrong.into_inner().unwrap(), ends.into_inner().unwrap());
    println!("{count} cases: {ends:?}\n{}", Vec::from_iter(said.into_inner().unwrap()).join("\n"));
    // The number of waits depends on time, so another run may lack the last call of one run.
    let missed = ends.get("not reached").copied().unwrap_or(0);
    assert!(wrong.is_empty(), "{} are wrong\n{}", wrong.len(), wrong.join("\n"));
    assert!(10 * missed < count, "{missed} of {count} calls were not made");
}

/// The rays of one row that a run of `raxel stress` has printed, and how many of them were wrong; none if it has printed no row.
fn judged(run: &Run) -> Option<(u64, u64)> {
    let mut words = run.stdout.lines().find_map(|line| line.strip_prefix("tree64: "))?.split(' ');
    Some((words.next()?.parse().ok()?, words.nth(1)?.parse().ok()?))
}

#[test]
fn what_was_judged_before_the_device_is_lost_is_printed() {
    let stage = Stage::new();
    let stress =
        ["stress", "--layouts", "tree64", "--scenes", "menger@near,dust@far", "--rays", "4000", "--format", "short"];
    let run = || finish(&mut stage.command(&stress)).unwrap();
    stage.faults.disarm();
    let whole = run();
    let submits = stage.faults.disarm().iter().filter(|(call, _)| call == "vkQueueSubmit2").count();
    let (all, wrong) = judged(&whole).unwrap();
    assert!(whole.code == 0 && all > 2000 && wrong == 0 && submits > 10, "{submits} {}", whole.stdout);
    let after = |submits| {
        stage.faults.arm("vkQueueSubmit2", submits, Fault::DeviceLost);
        let run = run();
        let errors = run.stderr.lines().filter(|line| line.starts_with("error")).count();
        assert!(run.code == 5 && errors == 1, "{}: {}", run.code, run.stderr);
        assert_eq!(judged(&run).is_some(), run.stderr.contains("the run ended early"), "{}", run.stderr);
        judged(&run)
    };
    // Moved, turned and mirrored scenes are the last step: by then all rays are judged.
    assert_eq!(after(submits - 1), Some((all, 0)));
    // While they are traced, some.
    let some: Vec<u64> = (0..submits).step_by(submits / 8 + 1).filter_map(|n| Some(after(n)?.0)).collect();
    assert!(some.is_sorted() && some.contains(&all), "{some:?} of {all}");
    assert_eq!(after(0), None);
}

#[test]
fn a_verb_goes_on_or_ends_with_one_error_after_some_call_has_failed() {
    let stage = Stage::new();
    let (cases, whole) = every_case(&stage);
    assert!(cases.len() > 1000, "calls are made: {}", cases.len());
    try_each(stage, chosen(cases, 60), &whole);
}

/// A driver without memory for an answer has not refused the format.
#[test]
fn a_format_is_refused_only_by_a_driver_that_refuses_it() {
    let stage = Stage::new();
    for (fault, code, refused) in
        [(Fault::HostMemory, 4, false), (Fault::Unknown, 4, false), (Fault::FormatNotSupported, 3, true)]
    {
        stage.faults.arm_always("vkGetPhysicalDeviceImageFormatProperties", fault);
        let (run, _) = stage.render().unwrap();
        stage.faults.disarm();
        assert_eq!((run.code, run.stderr.contains("RX0410")), (code, refused), "{fault:?}: {}", run.stderr);
        assert_eq!(run.stderr.contains("vkGetPhysicalDeviceImageFormatProperties"), !refused, "{}", run.stderr);
    }
}

/// `RAXEL_FAULTS` chooses cases by a part of their text, such as `Render`, `vkQueueSubmit2` or `DeviceLost`.
#[test]
#[ignore = "an hour of processor time at most: every call with every error"]
fn a_verb_goes_on_or_ends_with_one_error_after_any_call_has_failed() {
    let stage = Stage::new();
    let (mut cases, whole) = every_case(&stage);
    if let Ok(part) = std::env::var("RAXEL_FAULTS") {
        cases.retain(|case| format!("{case:?}").contains(&part));
    }
    try_each(stage, cases, &whole);
}
