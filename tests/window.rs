//! One real window, under Xvfb: what it shows is what `render` writes, edits show, keys work, and it leaves in order.

mod common;

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use common::{Project, Run, Running, command, output};

/// A display with no window manager: the window is at the top left.
struct Display {
    _xvfb: Running,
    name: String,
    frame_buffer: tempfile::TempDir,
}

impl Display {
    fn start() -> Self {
        let frame_buffer = tempfile::tempdir().unwrap();
        // ./raxel test installs it.
        let mut xvfb = Running::start(
            Command::new("Xvfb")
                .args(["-displayfd", "1", "-screen", "0", "640x480x24", "-nolisten", "tcp", "-fbdir"])
                .arg(frame_buffer.path())
                .stdout(Stdio::piped())
                .stderr(Stdio::null()),
        );
        // It writes its number when it is ready.
        let mut number = String::new();
        let mut stdout = std::io::BufReader::new(xvfb.0.stdout.take().unwrap());
        std::io::BufRead::read_line(&mut stdout, &mut number).unwrap();
        Self { _xvfb: xvfb, name: format!(":{}", number.trim()), frame_buffer }
    }

    /// The top left of the screen: red, green, blue of each pixel. The file has the format of xwd.
    fn pixels(&self, width: usize, height: usize) -> Vec<[u8; 3]> {
        let file = fs::read(self.frame_buffer.path().join("Xvfb_screen0")).unwrap();
        let word = |i: usize| u32::from_be_bytes(file[i * 4..i * 4 + 4].try_into().unwrap()) as usize;
        let (header, bits, line, colors) = (word(0), word(11), word(12), word(19));
        assert_eq!(bits, 32);
        let start = header + colors * 12;
        let pixel = |x: usize, y: usize| {
            let at = start + y * line + x * 4;
            [file[at + 2], file[at + 1], file[at]]
        };
        (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect()
    }

    fn xdotool(&self, arguments: &[&str]) -> String {
        // ./raxel test installs it.
        let output = output(Command::new("xdotool").args(arguments).env("DISPLAY", &self.name));
        String::from_utf8(output.stdout).unwrap()
    }
}

/// Waits until something holds.
#[track_caller]
fn eventually(what: &str, mut holds: impl FnMut() -> bool) {
    let start = Instant::now();
    while !holds() {
        assert!(start.elapsed() < Duration::from_secs(60), "{what}: not within a minute");
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// Presses a key, and again when nothing came of it: a busy machine may lose one while the window takes the focus.
#[track_caller]
fn press(display: &Display, key: &str, what: &str, mut holds: impl FnMut() -> bool) {
    let mut pressed: Option<Instant> = None;
    eventually(what, || {
        if pressed.is_none_or(|at| at.elapsed() > Duration::from_secs(5)) {
            display.xdotool(&["key", key]);
            pressed = Some(Instant::now());
        }
        holds()
    });
}

/// The picture that `render` writes.
fn rendered(project: &Project, target: &str) -> Vec<[u8; 3]> {
    project
        .raxel(&[
            "render",
            "graphs/inspect.toml",
            "--world",
            "worlds/menger.toml",
            "--size",
            "320x180",
            "--target",
            target,
            "-o",
            "r.png",
        ])
        .exits(0);
    let image = image::open(project.path("r.png")).unwrap().into_rgb8();
    fs::remove_file(project.path("r.png")).unwrap();
    image.pixels().map(|pixel| pixel.0).collect()
}

fn log(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_default()
}

#[test]
fn a_window_shows_pictures_edits_and_debug_targets() {
    let display = Display::start();
    let project = Project::shipped();
    let log_path = project.path("log");
    let screen = || display.pixels(320, 180);

    let mut child = Running::start(
        command(
            project.root(),
            &["run", "graphs/inspect.toml", "--world", "worlds/menger.toml", "--size", "320x180", "--validate"],
        )
        .env("DISPLAY", &display.name)
        .env_remove("WAYLAND_DISPLAY")
        .stderr(fs::File::create(&log_path).unwrap()),
    );

    let normal = rendered(&project, "normal");
    eventually("the first picture", || screen() == normal);
    let window = display.xdotool(&["search", "--name", "raxel"]).trim().to_owned();
    assert!(!window.is_empty());
    let title = || display.xdotool(&["getwindowname", &window]);
    eventually("the title", || title().starts_with("inspect · normal · "));

    // A key: the next debug target in the order of the file, after `normal`.
    display.xdotool(&["windowfocus", "--sync", &window]);
    let steps = rendered(&project, "steps");
    press(&display, "Tab", "the next target", || screen() == steps);
    press(&display, "shift+Tab", "the target before", || screen() == normal);

    // An edit shows; a mistake does not, and is said.
    project.edit("graphs/inspect.toml", "present = \"normal\"", "present = \"depth\"");
    eventually("the reload is told", || log(&log_path).contains("reloaded graphs/inspect.toml"));
    project.edit("graphs/inspect.toml", "outDepth = \"depth\"", "outDepth = \"dept\"");
    eventually("the mistake is told", || log(&log_path).contains("gen 2 failed: showing gen 1"));
    assert!(log(&log_path).contains("did you mean `depth`?"));
    eventually("the title tells", || title().contains("gen 2 failed: showing gen 1"));
    assert!(screen() == normal, "the last good picture stays");
    project.edit("graphs/inspect.toml", "outDepth = \"dept\"", "outDepth = \"depth\"");
    eventually("it is right again", || log(&log_path).contains("gen 3"));

    press(&display, "space", "a pause", || title().contains("· paused"));
    press(&display, "F12", "a screenshot", || log(&log_path).contains("wrote "));
    let shot = project.files().into_iter().find(|file| file.starts_with("inspect-normal-")).unwrap();
    let shot = image::open(project.path(&shot)).unwrap().into_rgb8();
    assert!(shot.pixels().map(|pixel| pixel.0).eq(normal.iter().copied()));

    display.xdotool(&["windowsize", "--sync", &window, "200", "150"]);
    display.xdotool(&["keydown", "w"]);
    std::thread::sleep(Duration::from_millis(300));
    display.xdotool(&["keyup", "w"]);
    press(&display, "Escape", "it leaves", || child.ended());
    // Exit code 6 would mean that the validation layer has said something.
    assert_eq!(child.finish().code(), Some(0), "{}", log(&log_path));
}

#[test]
fn frames_of_a_demo_are_counted() {
    let display = Display::start();
    let arguments = ["run", "worlds/valley.demo.toml", "--size", "160x90", "--frames", "5", "--validate", "-v"];
    let mut command = command(common::repository(), &arguments);
    Run::from(output(command.env("DISPLAY", &display.name).env_remove("WAYLAND_DISPLAY"))).exits(0);
}

#[test]
fn without_a_display_the_way_out_is_said() {
    let mut command = command(common::repository(), &["run"]);
    let command = command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
    let said = Run::from(output(command)).exits(4).stderr;
    assert!(said.contains("raxel render") && !said.contains(".rs:"), "{said}");
}
