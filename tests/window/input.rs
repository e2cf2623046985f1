//! Mouse and keyboard reach the panels, the camera and the graph.

use std::fs;
use std::time::Duration;

use crate::common::{Display, Project, RunRaxel, Running, command, eventually};
use crate::{log, press, press_button, rendered};

#[test]
fn a_window_shows_pictures_edits_and_debug_targets() {
    let display = Display::start();
    let project = Project::shipped();
    let log_path = project.path("log");
    let screen = || display.pixels(320, 180);

    let mut child = Running::start(
        command(
            project.root(),
            &[
                "run",
                "graphs/inspect.toml",
                "--world",
                "worlds/menger.toml",
                "--size",
                "320x180",
                "--validate",
                "--no-panels",
            ],
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

    // The brush digs a ball out of the centre, and undo puts it back.
    press_button(&display, "3", "a ball is dug out", || screen() != normal);
    press(&display, "ctrl+z", "the ball is back", || screen() == normal);

    // An edit shows; a mistake does not, and is reported.
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

    // The panels lie over the picture, and leave it as it was.
    press(&display, "F1", "the panels", || screen() != normal);
    press(&display, "F1", "the bare picture", || screen() == normal);

    display.xdotool(&["windowsize", "--sync", &window, "200", "150"]);
    display.xdotool(&["keydown", "w"]);
    std::thread::sleep(Duration::from_millis(300));
    display.xdotool(&["keyup", "w"]);
    press(&display, "Escape", "it leaves", || child.ended());
    // Exit code 6 would mean a message of the validation layer.
    assert_eq!(child.finish().code(), Some(0), "{}", log(&log_path));
}

/// A graph reads the mouse and the keyboard of the window, which notes them as a take.
#[test]
fn a_graph_has_mouse_and_keyboard() {
    let display = Display::start();
    let project = Project::shipped();
    let log_path = project.path("log");
    let graph = ["run", "graphs/examples/paint.toml", "--world", "worlds/menger.toml"];
    let options = ["--size", "320x180", "--validate", "--no-panels"];
    let mut child = Running::start(
        command(project.root(), &[&graph[..], &options].concat())
            .env("DISPLAY", &display.name)
            .env_remove("WAYLAND_DISPLAY")
            .stderr(fs::File::create(&log_path).unwrap()),
    );
    let paper = |pixels: Vec<[u8; 3]>| pixels.iter().all(|pixel| *pixel == pixels[0]);
    let screen = || display.pixels(320, 180);
    eventually("the empty canvas", || screen()[0].iter().all(|channel| *channel > 200));
    let window = display.xdotool(&["search", "--name", "raxel"]).trim().to_owned();
    let title = || display.xdotool(&["getwindowname", &window]);
    display.xdotool(&["windowfocus", "--sync", &window]);
    press(&display, "F9", "a take begins", || title().contains("· recording"));
    eventually("a stroke", || {
        display.xdotool(&["mousemove", "60", "90", "mousedown", "1", "mousemove", "200", "100"]);
        std::thread::sleep(Duration::from_millis(200));
        display.xdotool(&["mouseup", "1"]);
        !paper(screen())
    });
    press(&display, "F9", "the take is written", || log(&log_path).contains("wrote a take"));
    let take = fs::read_to_string(project.path("worlds/take.demo.toml")).unwrap();
    assert!(take.contains("[\"left\"]") && take.contains("size     = [320, 180]"), "{take}");

    // Backspace clears the canvas, and Space pauses: the second one only while the window has the keys.
    press(&display, "BackSpace", "an empty canvas", || paper(screen()));
    press(&display, "F2", "the graph has them", || log(&log_path).contains("the graph alone has mouse and keyboard"));
    display.xdotool(&["key", "space"]);
    press(&display, "F2", "the window has them", || log(&log_path).contains("the window has mouse and keyboard again"));
    assert!(!title().contains("· paused"), "{}", title());
    press(&display, "space", "a pause", || title().contains("· paused"));
    press(&display, "Escape", "it leaves", || child.ended());
    assert_eq!(child.finish().code(), Some(0), "{}", log(&log_path));
    project.raxel(&["check", "worlds/take.demo.toml"]).exits(0);
}

#[test]
fn a_drag_of_a_panels_edge_leaves_the_camera_where_it_is() {
    let display = Display::start();
    let project = Project::shipped();
    project.write(
        ".raxel/window.toml",
        "docks = { across = { share = 0.5, left = { tabs = [\"picture\"] }, right = { tabs = [\"inspect\"] } } }\n",
    );
    let log_path = project.path("log");
    let mut child = Running::start(
        command(
            project.root(),
            &["run", "graphs/inspect.toml", "--world", "worlds/menger.toml", "--size", "320x180", "--validate"],
        )
        .env("DISPLAY", &display.name)
        .env_remove("WAYLAND_DISPLAY")
        .stderr(fs::File::create(&log_path).unwrap()),
    );
    // Left of all that a panel covers here, and below the bar and the tabs.
    let picture = |pixels: Vec<[u8; 3]>| -> Vec<[u8; 3]> {
        (56..180).flat_map(|y| pixels[y * 320..y * 320 + 100].to_vec()).collect()
    };
    let expected = picture(rendered(&project, "normal"));
    let shown = || picture(display.pixels(320, 180));
    eventually("the first picture", || shown() == expected);
    let window = display.xdotool(&["search", "--name", "raxel"]).trim().to_owned();
    display.xdotool(&["windowfocus", "--sync", &window]);
    let drag = |from: &str, by: &[&str]| {
        display.xdotool(&["mousemove", from, "120", "mousedown", "1"]);
        for to in by {
            std::thread::sleep(Duration::from_millis(200));
            display.xdotool(&["mousemove", to, "120"]);
        }
        std::thread::sleep(Duration::from_millis(200));
        display.xdotool(&["mouseup", "1"]);
    };
    // The ground of a panel is dark, and hides the picture nearly.
    let covered = |x: usize| display.pixels(320, 180)[150 * 320 + x].iter().all(|part| *part < 60);
    eventually("the panel", || covered(300) && !covered(160));
    // A press just outside of the panel takes hold of its edge.
    drag("173", &["160", "130"]);
    eventually("the panel is wider", || covered(160));
    assert!(shown() == expected, "the camera stays");
    drag("60", &["50", "40"]);
    eventually("a drag in the picture turns the camera", || shown() != expected);
    press(&display, "Escape", "it leaves", || child.ended());
    assert_eq!(child.finish().code(), Some(0), "{}", log(&log_path));
}
