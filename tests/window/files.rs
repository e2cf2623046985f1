//! Files with mistakes, and another graph in place of the one that runs.

use std::fs;
use std::time::{Duration, Instant};

use crate::common::{Display, Project, Run, Running, command, eventually, output};
use crate::{BARE, Bare, log, press, rendered};

#[test]
fn a_window_over_broken_files_says_so_and_waits_for_the_mend() {
    let display = Display::start();
    let project = Project::shipped();
    let normal = rendered(&project, "normal");
    project.edit("graphs/inspect.toml", "outDepth = \"depth\"", "outDepth = \"dept\"");
    let log_path = project.path("log");
    let arguments = ["run", "graphs/inspect.toml", "--world", "worlds/menger.toml", "--size", "320x180", "--validate"];
    let mut child = Running::start(
        command(project.root(), &arguments)
            .arg("--no-panels")
            .env("DISPLAY", &display.name)
            .env_remove("WAYLAND_DISPLAY")
            .stderr(fs::File::create(&log_path).unwrap()),
    );
    eventually("the mistake is told", || log(&log_path).contains("the window waits for the files to be mended"));
    assert!(log(&log_path).contains("did you mean `depth`?"));
    // Text over a plain ground.
    eventually("the mistake is shown", || {
        let screen = display.pixels(320, 180);
        screen.iter().any(|pixel| pixel.iter().all(|part| *part > 128)) && screen.contains(&[20; 3])
    });
    project.edit("graphs/inspect.toml", "outDepth = \"dept\"", "outDepth = \"depth\"");
    eventually("the picture", || display.pixels(320, 180) == normal);
    let window = display.xdotool(&["search", "--name", "raxel"]).trim().to_owned();
    display.xdotool(&["windowfocus", "--sync", &window]);
    press(&display, "Escape", "it leaves", || child.ended());
    assert_eq!(child.finish().code(), Some(0), "{}", log(&log_path));
    // With a number of frames, the window waits for no edit.
    project.edit("graphs/inspect.toml", "outDepth = \"depth\"", "outDepth = \"dept\"");
    let mut counted = command(project.root(), &arguments);
    counted.args(["--frames", "2"]).env("DISPLAY", &display.name).env_remove("WAYLAND_DISPLAY");
    Run::from(output(&mut counted)).exits(3);
}

#[test]
fn a_window_waits_for_the_mend_of_the_manifest_and_opens_what_it_says_then() {
    let display = Display::start();
    let project = Project::shipped();
    let normal = rendered(&project, "normal");
    project.write("raxel.toml", "graph = \"inspect.toml\"\nworld = \"menger.tml\"\n");
    let log_path = project.path("log");
    let arguments = ["run", "--size", "320x180", "--validate", "--no-panels"];
    let in_window = || {
        let mut command = command(project.root(), &arguments);
        command.env("DISPLAY", &display.name).env_remove("WAYLAND_DISPLAY");
        command
    };
    // With a number of frames, the window waits for no edit.
    let counted: Run = output(in_window().args(["--frames", "2"])).into();
    assert!(counted.exits(3).stderr.contains("raxel.toml:2:"));
    let mut child = Running::start(in_window().stderr(fs::File::create(&log_path).unwrap()));
    eventually("the mistake is told", || log(&log_path).contains("the window waits for the files to be mended"));
    assert!(log(&log_path).contains("raxel.toml:2:"), "{}", log(&log_path));
    // Like an editor that truncates and then writes: the empty file in between opens nothing.
    project.write("raxel.toml", "");
    std::thread::sleep(Duration::from_millis(1500));
    project.write("mended", "graph = \"inspect.toml\"\nworld = \"menger.toml\"\n");
    fs::rename(project.path("mended"), project.path("raxel.toml")).unwrap();
    eventually("the picture", || display.pixels(320, 180) == normal);
    let window = display.xdotool(&["search", "--name", "raxel"]).trim().to_owned();
    display.xdotool(&["windowfocus", "--sync", &window]);
    press(&display, "Escape", "it leaves", || child.ended());
    assert_eq!(child.finish().code(), Some(0), "{}", log(&log_path));
}

#[test]
fn another_graph_takes_the_place_of_what_runs_and_a_broken_one_does_not() {
    let bare = Bare::open("rgba8", "vec4(1, 0, 0, 1)");
    let filled = |color: [u8; 3]| bare.shows(|_, _| color);
    eventually("the first picture", || filled([255, 0, 0]));
    let graph = fs::read_to_string(bare.project.path("graphs/bare.toml")).unwrap();
    let shader = BARE.replace("FORMAT", "rgba8");
    bare.project.write("shaders/green.comp", shader.replace("VALUE", "vec4(0, 1, 0, 1)"));
    let other = graph.replace("\"bare\"", "\"other\"").replace("fill.comp", "green.comp");
    bare.project.write("graphs/other.toml", &other);
    bare.project.write("graphs/wrong.toml", graph.replace("outColor = ", "outColour = "));
    let title = || bare.display.xdotool(&["getwindowname", &bare.window]);
    let open = |words: &str| {
        press(&bare.display, "o", "the list of files", || !filled([255, 0, 0]) && !filled([0, 255, 0]));
        bare.display.xdotool(&["type", "--delay", "60", words]);
        std::thread::sleep(Duration::from_millis(300));
        bare.display.xdotool(&["key", "Return"]);
    };
    open("wrong");
    eventually("the mistake is told", || log(&bare.project.path("log")).contains("gen 1 failed: showing gen 0"));
    eventually("the last good picture stays", || filled([255, 0, 0]));
    assert!(title().starts_with("bare · "), "{}", title());
    // It runs as soon as it is right.
    bare.project.write("graphs/wrong.toml", &other);
    eventually("the mended graph", || filled([0, 255, 0]));
    assert!(log(&bare.project.path("log")).contains("opened graphs/wrong.toml"));
    open("bare graphs");
    eventually("the graph before", || filled([255, 0, 0]));
    // Escape ends the list, and then the window.
    press(&bare.display, "o", "the list of files", || !filled([255, 0, 0]));
    press(&bare.display, "Escape", "the bare picture", || filled([255, 0, 0]));
    bare.leave();
}

/// The table waits for its buffer, and the user shows something else.
#[test]
fn a_table_is_written_whatever_is_shown_next() {
    let (display, project) = (Display::start(), Project::empty());
    project.write("graphs/words.toml", include_str!("../fixtures/window/words.toml"));
    project.write("shaders/count.comp", include_str!("../fixtures/window/count.comp"));
    let words = "layout(std430) readonly buffer Words { uint word[]; } words;\nvoid main()";
    let shader = BARE.replace("FORMAT", "rgba8").replace("VALUE", "vec4(words.word[1] / 3u, 0, 0, 1)");
    project.write("shaders/fill.comp", shader.replace("void main()", words));
    let docks =
        "docks = { across = { share = 0.5, left = { tabs = [\"picture\"] }, right = { tabs = [\"inspect\"] } } }\n";
    project.write(".raxel/window.toml", docks);
    let log_path = project.path("log");
    let arguments = ["run", "graphs/words.toml", "--target", "words", "--size", "600x400", "--validate"];
    let mut child = Running::start(
        command(project.root(), &arguments)
            .env("DISPLAY", &display.name)
            .env_remove("WAYLAND_DISPLAY")
            .stderr(fs::File::create(&log_path).unwrap()),
    );
    // The button behind the number of elements, which is drawn once the buffer was read.
    let button = || display.pixels(600, 400)[103 * 600 + 559][0] > 50;
    let red = || display.pixels(600, 400)[330 * 600 + 40] == [255, 0, 0];
    eventually("the table", button);
    let window = display.xdotool(&["search", "--name", "words"]).trim().to_owned();
    display.xdotool(&["windowfocus", "--sync", &window]);
    let written = || log(&log_path).contains("words.csv");
    let mut pressed: Option<Instant> = None;
    eventually("the table is written", || {
        // A busy machine may lose a click. The key shows the other target, so it has to be pressed again.
        if pressed.is_none_or(|at| at.elapsed() > Duration::from_secs(8)) {
            if pressed.is_some() && red() {
                display.xdotool(&["key", "Tab"]);
                std::thread::sleep(Duration::from_secs(2));
            }
            display.xdotool(&["mousemove", "546", "103"]);
            std::thread::sleep(Duration::from_millis(500));
            display.xdotool(&["click", "1", "mousemove", "100", "200", "key", "Tab"]);
            pressed = Some(Instant::now());
        }
        written()
    });
    eventually("another target is shown", red);
    let text = fs::read_to_string(project.path("words.csv")).unwrap();
    assert!(text.starts_with("u32\n0\n3\n6\n") && text.ends_with("\n299997\n"), "{}", &text[..40]);
    press(&display, "Escape", "it leaves", || child.ended());
    assert_eq!(child.finish().code(), Some(0), "{}", log(&log_path));
}
