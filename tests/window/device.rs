//! The device that presents, the loss of a device, and the loss of the display.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::common::{Display, Project, Run, RunRaxel, Running, before_vulkan, command, eventually, output, repository};
use crate::{log, press, press_button, rendered};

#[test]
fn the_device_that_presents_may_be_named() {
    let display = Display::start();
    let project = Project::shipped();
    let expected = rendered(&project, "normal");
    let doctor = project.raxel(&["doctor"]).stdout;
    let index = doctor.split_once("* ").and_then(|(_, chosen)| chosen.split_once(':')).unwrap().0;
    let run = |with: &str, log_path: &Path| {
        let arguments = ["run", "graphs/inspect.toml", "--world", "worlds/menger.toml", "--size", "320x180"];
        let mut command = command(project.root(), &arguments);
        command.args(["--no-panels", "--validate", "--present-with", with]).env("DISPLAY", &display.name);
        Running::start(command.env_remove("WAYLAND_DISPLAY").stderr(fs::File::create(log_path).unwrap()))
    };
    let log_path = project.path("log");
    // The device that makes the pictures, and the same hardware by its number, opened once more.
    for with in ["own", index] {
        let mut child = run(with, &log_path);
        eventually("the picture that render writes", || display.pixels(320, 180) == expected || child.ended());
        let window = display.xdotool(&["search", "--name", "raxel"]).trim().to_owned();
        display.xdotool(&["windowfocus", "--sync", &window]);
        press(&display, "Tab", "another target", || display.pixels(320, 180) != expected);
        press(&display, "Escape", "it leaves", || child.ended());
        assert_eq!(child.finish().code(), Some(0), "{with}: {}", log(&log_path));
    }
    let mut child = run("Voodoo 5", &log_path);
    assert_eq!(child.finish().code(), Some(4));
    assert!(log(&log_path).contains("no suitable Vulkan device `Voodoo 5`"), "{}", log(&log_path));
    let refused = project.raxel(&["run", "--present-with", ""]).exits(2);
    assert!(refused.stderr.contains("`own`, a part of a device's name"), "{}", refused.stderr);
}

/// Lists the first device twice, and says that the first of both is a GPU; and if so, that none can present.
const NO_DISPLAY: &str = include_str!("../fixtures/window/no_display.c");

#[test]
#[cfg(target_os = "linux")]
fn where_a_gpu_cannot_present_another_device_does() {
    let display = Display::start();
    let project = Project::shipped();
    let expected = rendered(&project, "normal");
    let library = before_vulkan(&project, NO_DISPLAY);
    let log_path = project.path("log");
    let shown = ["run", "graphs/inspect.toml", "--world", "worlds/menger.toml", "--size", "320x180", "--no-panels"];
    let run = |command: &mut Command| {
        command.env("LD_PRELOAD", &library).env("DISPLAY", &display.name).env_remove("WAYLAND_DISPLAY");
        Running::start(command.stderr(fs::File::create(&log_path).unwrap()))
    };
    let mut child = run(&mut command(project.root(), &shown));
    eventually("the picture that render writes", || display.pixels(320, 180) == expected || child.ended());
    let why = "cannot present to this window: its X server works with no GPU";
    assert!(log(&log_path).contains(" presents the window: ") && log(&log_path).contains(why), "{}", log(&log_path));
    let window = display.xdotool(&["search", "--name", "raxel"]).trim().to_owned();
    display.xdotool(&["windowfocus", "--sync", &window]);
    press(&display, "Tab", "another target", || display.pixels(320, 180) != expected);
    press(&display, "Escape", "it leaves", || child.ended());
    assert_eq!(child.finish().code(), Some(0), "{}", log(&log_path));
    // Unless that is not wanted: then the driver is asked.
    let mut own = command(project.root(), &shown);
    let mut child = run(own.args(["--present-with", "own"]).env("CANNOT_PRESENT", "1"));
    assert_eq!(child.finish().code(), Some(4), "{}", log(&log_path));
    let why = "cannot present to this window: its queue cannot present there";
    assert!(log(&log_path).contains(why), "{}", log(&log_path));
}

/// The next submission after a file has appeared is answered with the loss of the device, once; nothing that could be blamed runs then.
const LOSS: &str = include_str!("../fixtures/window/loss.c");

#[test]
#[cfg(target_os = "linux")]
fn a_window_goes_on_after_the_loss_of_a_device() {
    let display = Display::start();
    let project = Project::shipped();
    let expected = rendered(&project, "normal");
    let (library, log_path, lose) = (before_vulkan(&project, LOSS), project.path("log"), project.path("lose"));
    // First two devices, either of which may be lost; then one device for both.
    for arguments in [&[][..], &["--present-with", "own"]] {
        let shown = ["run", "graphs/inspect.toml", "--world", "worlds/menger.toml", "--size", "320x180", "--no-panels"];
        let mut command = command(project.root(), &shown);
        command.args(arguments).env("LD_PRELOAD", &library).env("LOSE_THE_DEVICE", &lose);
        command.env("DISPLAY", &display.name).env_remove("WAYLAND_DISPLAY");
        let mut child = Running::start(command.stderr(fs::File::create(&log_path).unwrap()));
        eventually("the picture that render writes", || display.pixels(320, 180) == expected || child.ended());
        let window = display.xdotool(&["search", "--name", "raxel"]).trim().to_owned();
        display.xdotool(&["windowfocus", "--sync", &window]);
        // Three short lives in a row would end it.
        for target in ["Tab", "shift+Tab"] {
            let before = display.pixels(320, 180);
            fs::write(&lose, "").unwrap();
            eventually("it is lost", || !lose.exists() || child.ended());
            press(&display, target, "another target", || display.pixels(320, 180) != before || child.ended());
        }
        press(&display, "Escape", "it leaves", || child.ended());
        assert_eq!(child.finish().code(), Some(0), "{}", log(&log_path));
    }
    let said = log(&log_path);
    assert!(said.contains("the device was lost and is open again") && said.contains("start over at `init`"), "{said}");
}

/// The ways in which a window loses its server.
#[cfg(target_os = "linux")]
enum Loss {
    /// The server ends under a picture that does not change.
    Still,
    /// The server closes the connection.
    Closed,
    /// The server ends while the window draws.
    Moving,
}

#[test]
#[cfg(target_os = "linux")]
fn an_x_server_that_goes_away_is_one_error_and_loses_no_edit() {
    for loss in [Loss::Still, Loss::Closed, Loss::Moving] {
        let mut display = Display::start();
        let project = Project::shipped();
        let world = fs::read_to_string(project.path("worlds/menger.toml")).unwrap();
        project.write("worlds/menger.toml", format!("{world}\n[save]\npath = \"saves/edits\"\n"));
        let log_path = project.path("log");
        let shown = ["run", "graphs/inspect.toml", "--world", "worlds/menger.toml", "--size", "320x180", "--no-panels"];
        let mut child = Running::start(
            command(project.root(), &shown)
                .env("DISPLAY", &display.name)
                .env_remove("WAYLAND_DISPLAY")
                .stderr(fs::File::create(&log_path).unwrap()),
        );
        let first = rendered(&project, "normal");
        eventually("the first picture", || display.pixels(320, 180) == first || child.ended());
        let window = display.xdotool(&["search", "--name", "raxel"]).trim().to_owned();
        display.xdotool(&["windowfocus", "--sync", &window]);
        press_button(&display, "3", "a ball is dug out", || display.pixels(320, 180) != first);
        match loss {
            Loss::Still => display.end(),
            Loss::Closed => drop(display.xdotool(&["windowkill", &window])),
            Loss::Moving => {
                display.xdotool(&["keydown", "w"]);
                display.end();
            }
        }
        let code = child.finish().code();
        let said = log(&log_path);
        assert_eq!(code, Some(5), "{said}");
        assert!(said.contains("error: the window system went away: "), "{said}");
        let errors = said.lines().filter(|line| line.starts_with("error")).count();
        assert!(!said.contains("bug in raxel") && errors == 1, "{said}");
        // The edit is there when the world is opened again.
        assert_ne!(rendered(&project, "normal"), first);
    }
}

#[test]
fn without_a_display_the_way_out_is_said() {
    let mut command = command(repository(), &["run"]);
    let command = command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
    let said = Run::from(output(command)).exits(4).stderr;
    assert!(said.contains("raxel render") && !said.contains(".rs:"), "{said}");
}
