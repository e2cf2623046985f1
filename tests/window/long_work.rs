//! Passes that do not end, and prints without end.

use std::fs;
use std::time::{Duration, Instant};

use crate::common::{Display, Project, Run, Running, command, eventually, output};
use crate::{log, press};

/// Resident memory of a process, in MiB.
#[cfg(target_os = "linux")]
fn resident(process: u32) -> Option<u64> {
    let status = fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    line.trim().trim_end_matches(" kB").parse::<u64>().ok().map(|kib| kib >> 10)
}

/// A million invocations print another text in each frame. The terminal gets what a person can read, memory does not grow, and frames go on.
#[test]
#[cfg(target_os = "linux")]
fn a_million_prints_a_frame_are_bounded_and_stall_nothing() {
    const FRAMES: u32 = 60;
    let display = Display::start();
    let run = |prints: bool| {
        let project = Project::empty();
        let graph = include_str!("../fixtures/window/flood.toml");
        let shader = r#"#version 460
#extension GL_EXT_debug_printf : require
layout(local_size_x = 8, local_size_y = 8) in;
layout(r32f) writeonly uniform image2D to;
layout(push_constant) uniform Push { uint frame; } push;
void main() { ivec2 at = ivec2(gl_GlobalInvocationID.xy); imageStore(to, at, vec4(push.frame));
if (push.frame < LAST) debugPrintfEXT("%v2d in frame %u", at, push.frame); }
"#;
        let shader = shader.replace("LAST", if prints { "1000000u" } else { "0u" });
        project.write("graphs/flood.toml", graph).write("shaders/flood.comp", shader);
        let frames = FRAMES.to_string();
        let arguments = ["run", "graphs/flood.toml", "--size", "320x180", "--frames", &frames];
        let mut child = Running::start(
            command(project.root(), &arguments)
                .env("DISPLAY", &display.name)
                .env_remove("WAYLAND_DISPLAY")
                .stderr(fs::File::create(project.path("log")).unwrap()),
        );
        let (began, mut memory) = (Instant::now(), Vec::new());
        while !child.ended() {
            memory.extend(resident(child.0.id()));
            std::thread::sleep(Duration::from_millis(50));
        }
        let log = log(&project.path("log"));
        assert_eq!(child.finish().code(), Some(0), "{log}");
        (began.elapsed(), memory, log)
    };
    let (quiet, plain, _) = run(false);
    let (loud, flooded, log) = run(true);
    let printed = log.lines().filter(|line| line.contains(" in frame ")).count() as u64;
    assert!((1..=200 * (loud.as_secs() + 2)).contains(&printed), "{printed} lines in {loud:?}");
    assert!(log.contains(" more"), "it says that there were more");
    let most = |memory: &[u64]| memory.iter().copied().max().unwrap_or_default();
    assert!(most(&flooded) < most(&plain) + 256, "{plain:?} and {flooded:?} MiB");
    // To read a million lines would take seconds a frame.
    assert!(loud < quiet + Duration::from_millis(500) * FRAMES, "{loud:?} instead of {quiet:?}");
}

/// Works for minutes on the software driver: it leaves a loop after 65535 rounds, so a round is long and the groups are many.
const SPIN: &str = include_str!("../fixtures/window/spin.comp");

#[test]
fn a_dispatch_that_does_not_end_is_named_and_keeps_neither_edits_nor_escape() {
    let display = Display::start();
    let project = Project::empty();
    project.write("graphs/spin.toml", include_str!("../fixtures/window/spin.toml"));
    project.write("shaders/spin.comp", SPIN);
    let log_path = project.path("log");
    let mut child = Running::start(
        command(project.root(), &["run", "graphs/spin.toml", "--size", "320x180"])
            .env("DISPLAY", &display.name)
            .env_remove("WAYLAND_DISPLAY")
            .stderr(fs::File::create(&log_path).unwrap()),
    );
    eventually("the pass is named", || log(&log_path).contains("the device has worked on pass `spin`"));
    let window = display.xdotool(&["search", "--name", "raxel"]).trim().to_owned();
    eventually("the title names it", || display.xdotool(&["getwindowname", &window]).contains("working on `spin`"));
    // There is no picture yet, and the panels answer all the same.
    display.xdotool(&["windowfocus", "--sync", &window]);
    let panels = || display.pixels(320, 180).iter().any(|pixel| *pixel != [20; 3]);
    eventually("the panels are there", panels);
    press(&display, "F1", "the panels go", || !panels());
    press(&display, "F1", "the panels come back", panels);
    project.edit("shaders/spin.comp", "vec4(x)", "vec4(colour)");
    eventually("a mistake is told", || log(&log_path).contains("gen 1 failed"));
    project.edit("shaders/spin.comp", "vec4(colour)", "vec4(0.5)");
    // Newer ones (Mesa 25) make no pipeline before the dispatch that was given up has ended, which takes hours here.
    let doctor = Run::from(output(&mut command(project.root(), &["doctor"])));
    if doctor.stdout.contains("llvmpipe Mesa 22.") {
        eventually("an edit is taken", || log(&log_path).contains("reloaded shaders/spin.comp"));
    }
    press(&display, "Escape", "it leaves", || child.ended());
    assert_eq!(child.finish().code(), Some(0), "{}", log(&log_path));
}

#[test]
fn a_pass_that_does_not_end_is_given_up_by_a_key_and_the_last_whole_picture_stays() {
    let display = Display::start();
    let project = Project::empty();
    project.write("graphs/spin.toml", include_str!("../fixtures/window/spin.toml"));
    project.write("shaders/spin.comp", SPIN);
    let log_path = project.path("log");
    let mut child = Running::start(
        command(project.root(), &["run", "graphs/spin.toml", "--size", "320x180", "--no-panels"])
            .env("DISPLAY", &display.name)
            .env_remove("WAYLAND_DISPLAY")
            .stderr(fs::File::create(&log_path).unwrap()),
    );
    eventually("the pass is named", || log(&log_path).contains("the device has worked on pass `spin`"));
    let window = display.xdotool(&["search", "--name", "raxel"]).trim().to_owned();
    display.xdotool(&["windowfocus", "--sync", &window]);
    press(&display, "Delete", "it is given up", || log(&log_path).contains("pass `spin` is switched off"));
    let shows = |color: u8| display.pixels(320, 180).iter().all(|pixel| *pixel == [color; 3]);
    let titled = || display.xdotool(&["getwindowname", &window]);
    eventually("the title says so", || titled().contains("`spin` is off"));
    // There never was a picture.
    eventually("the ground of the window", || shows(20));
    let constant = |color: &str| SPIN.replace("60000", "1").replace("vec4(x)", color);
    project.write("shaders/spin.comp", constant("vec4(1.0)"));
    eventually("mended, it runs again", || shows(255));
    assert!(!titled().contains("is off"), "{}", titled());
    // The last whole picture stays while the pass works, and when it is given up.
    project.write("shaders/spin.comp", SPIN);
    eventually("it works again", || titled().contains("working on `spin`"));
    press(&display, "Delete", "it is given up again", || titled().contains("`spin` is off"));
    assert!(shows(255));
    project.write("shaders/spin.comp", constant("vec4(0.0)"));
    eventually("mended again", || shows(0));
    press(&display, "Escape", "it leaves", || child.ended());
    assert_eq!(child.finish().code(), Some(0), "{}", log(&log_path));
}
