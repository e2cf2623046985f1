//! A driver with false claims: every pipeline, every image or every submission fails, each time. A run without a window ends with one error that
//! names the failed object. A window stays open, and shows the error.
#![cfg(target_os = "linux")]

mod common;

use std::fs;
use std::path::Path;

use common::{Display, Fault, Faults, Project, Run, Running, command, eventually, output};

const SCENE: [&str; 5] = ["graphs/inspect.toml", "--world", "worlds/menger.toml", "--size", "160x90"];

/// The calls that always fail.
const LIES: [(&str, Fault); 5] = [
    ("vkCreateComputePipelines", Fault::Initialization),
    ("vkCreateComputePipelines", Fault::Unknown),
    ("vkCreateShaderModule", Fault::HostMemory),
    ("vkCreateImage", Fault::DeviceMemory),
    ("vkQueueSubmit2", Fault::DeviceLost),
];

/// Lines of errors, without panics.
fn errors(said: &str) -> Vec<&str> {
    assert!(!said.contains("panicked") && !said.contains("bug in raxel"), "{said}");
    said.lines().filter(|line| line.starts_with("error")).collect()
}

#[test]
fn without_a_window_it_is_one_error() {
    let project = Project::shipped();
    let faults = Faults::new(&project);
    for (call, fault) in LIES {
        faults.arm_always(call, fault);
        let stress = ["stress", "--layouts", "tree64", "--scenes", "menger@near", "--rays", "1000"];
        let render = [&["render"], &SCENE[..], &["-o", "out.png"]].concat();
        let control = [&["control"], &SCENE[..]].concat();
        for arguments in [&render[..], &control, &stress] {
            let run = Run::from(output(command(project.root(), arguments).envs(faults.variables())));
            let errors = errors(&run.stderr);
            // Tracers make no images.
            let unhurt = arguments[0] == "stress" && call == "vkCreateImage" && run.code == 0;
            // A session that is only opened submits nothing yet.
            let unhurt = unhurt || (arguments[0] == "control" && call == "vkQueueSubmit2" && run.code == 0);
            let expected = if fault == Fault::DeviceLost { 5 } else { 4 };
            assert!(unhurt || (run.code == expected && errors.len() == 1), "{arguments:?} {}", run.stderr);
            if call == "vkCreateComputePipelines" {
                let pipeline = if arguments[0] == "stress" { "`tree64`" } else { "`inspect`" };
                assert!(errors[0].contains(pipeline) && run.stderr.contains("help: "), "{arguments:?} {}", run.stderr);
            }
            assert!(!project.path("out.png").exists(), "{call}");
        }
        faults.disarm();
    }
}

/// The whole window in black.
fn is_black(display: &Display) -> bool {
    display.pixels(160, 90).iter().all(|pixel| *pixel == [0; 3])
}

fn read(log: &Path) -> String {
    fs::read_to_string(log).unwrap()
}

#[test]
fn a_window_says_it() {
    let (project, display) = (Project::shipped(), Display::start());
    let faults = Faults::new(&project);
    let log = project.path("log");
    for (call, fault) in LIES {
        faults.arm_always(call, fault);
        let mut command = command(project.root(), &[&["run"], &SCENE[..]].concat());
        command.envs(faults.variables()).env("DISPLAY", &display.name).env_remove("WAYLAND_DISPLAY");
        let mut child = Running::start(command.stderr(fs::File::create(&log).unwrap()));
        eventually("an error", || !errors(&read(&log)).is_empty() || child.ended());
        std::thread::sleep(std::time::Duration::from_secs(3));
        let ended = child.ended();
        let black = is_black(&display);
        if ended {
            let code = child.finish().code().unwrap_or(-1);
            assert!((3..=5).contains(&code) && errors(&read(&log)).len() == 1, "{call}: {code} {}", read(&log));
        } else {
            assert!(!black, "{call} {fault:?}: a black window, and {}", read(&log));
        }
    }
}

/// The driver never has an image for the window, takes none back, or loses the device that presents, each time. The window says so, with the way out,
/// or ends with the loss.
#[test]
fn a_window_that_takes_no_picture_says_it() {
    let (project, display) = (Project::shipped(), Display::start());
    let faults = Faults::new(&project);
    let log = project.path("log");
    for (call, fault) in [
        ("vkAcquireNextImageKHR", Fault::OutOfDate),
        ("vkAcquireNextImageKHR", Fault::SurfaceLost),
        ("vkQueuePresentKHR", Fault::OutOfDate),
        ("vkQueuePresentKHR", Fault::DeviceLost),
    ] {
        faults.arm_always(call, fault);
        let mut command = command(project.root(), &[&["run"], &SCENE[..]].concat());
        command.envs(faults.variables()).env("DISPLAY", &display.name).env_remove("WAYLAND_DISPLAY");
        let mut child = Running::start(command.stderr(fs::File::create(&log).unwrap()));
        let said = || read(&log).contains("the window has taken no picture for 10 s: llvmpipe");
        eventually("a report", || said() || child.ended());
        if fault == Fault::DeviceLost && child.ended() {
            assert_eq!((child.finish().code(), errors(&read(&log)).len()), (Some(5), 1), "{}", read(&log));
            continue;
        }
        assert!(said(), "{call} {fault:?}: {}", read(&log));
        assert!(read(&log).contains("help: `--present-with DEVICE`"), "{}", read(&log));
        assert!(errors(&read(&log)).is_empty(), "{}", read(&log));
    }
}
