//! One real window, under Xvfb. It shows the picture that `render` writes, shows edits, takes keys, and closes in order.

mod common;

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use common::{Display, Project, Run, Running, before_vulkan, command, eventually, output};

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

/// Presses a mouse button at the centre of a window of 320 × 180, and again if that had no effect.
#[track_caller]
fn press_button(display: &Display, button: &str, what: &str, mut holds: impl FnMut() -> bool) {
    let mut pressed: Option<Instant> = None;
    eventually(what, || {
        if pressed.is_none_or(|at| at.elapsed() > Duration::from_secs(5)) {
            display.xdotool(&["mousemove", "160", "90", "click", button]);
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

/// A window of 320 × 180 without panels over a graph whose one pass writes a target by this expression of `at`, its place in texels.
struct Bare {
    display: Display,
    project: Project,
    child: Running,
    window: String,
}

const BARE: &str = r"#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(FORMAT) uniform writeonly image2D outColor;
void main() { ivec2 at = ivec2(gl_GlobalInvocationID.xy); imageStore(outColor, at, VALUE); }
";

impl Bare {
    fn open(format: &str, value: &str) -> Self {
        let (display, project) = (Display::start(), Project::empty());
        project.write(
            "graphs/bare.toml",
            format!(
                r#"name = "bare"
present = "color"
[targets.color]
format = "{format}"
display = {{ map = "raw" }}
[[passes]]
name = "fill"
shader = "fill.comp"
dispatch = {{ threads = "color" }}
bind = {{ outColor = "color" }}
"#
            ),
        );
        project.write("shaders/fill.comp", BARE.replace("FORMAT", format).replace("VALUE", value));
        let child = Running::start(
            command(project.root(), &["run", "graphs/bare.toml", "--size", "320x180", "--validate", "--no-panels"])
                .env("DISPLAY", &display.name)
                .env_remove("WAYLAND_DISPLAY")
                .stderr(fs::File::create(project.path("log")).unwrap()),
        );
        let mut window = String::new();
        eventually("the window", || {
            display.xdotool(&["search", "--name", "bare"]).trim().clone_into(&mut window);
            !window.is_empty()
        });
        display.xdotool(&["windowfocus", "--sync", &window]);
        Self { display, project, child, window }
    }

    /// Whether each pixel shows the expected colour.
    fn shows(&self, expected: impl Fn(usize, usize) -> [u8; 3]) -> bool {
        let pixels = self.display.pixels(320, 180);
        pixels.iter().enumerate().all(|(index, pixel)| *pixel == expected(index % 320, index / 320))
    }

    fn drag(&self, from: [i32; 2], by: [i32; 2]) {
        let at = |share: i32| [0, 1].map(|axis| (from[axis] + by[axis] * share / 4).to_string());
        let go = |[x, y]: [String; 2]| self.display.xdotool(&["mousemove", &x, &y]);
        go(at(0));
        self.display.xdotool(&["mousedown", "1"]);
        for share in 0..=4 {
            std::thread::sleep(Duration::from_millis(100));
            go(at(share));
        }
        self.display.xdotool(&["mouseup", "1"]);
    }

    fn leave(mut self) {
        press(&self.display, "Escape", "it leaves", || self.child.ended());
        let log = log(&self.project.path("log"));
        assert_eq!(self.child.finish().code(), Some(0), "{log}");
    }
}

#[test]
fn a_picture_is_magnified_texel_by_texel_and_moved() {
    // Each texel has a colour of its own.
    let bare = Bare::open("rgba8", "vec4(at.x & 255, at.y, (at.x >> 8) * 255, 255) / 255.0");
    let byte = |place: usize| u8::try_from(place & 255).unwrap();
    let texel = |x: usize, y: usize| [byte(x), byte(y), if x > 255 { 255 } else { 0 }];
    eventually("the first picture", || bare.shows(texel));
    // Twice as large about a cursor at the centre, and once more by the wheel with Ctrl.
    bare.display.xdotool(&["mousemove", "160", "90"]);
    let twice = |x, y| texel(80 + x / 2, 45 + y / 2);
    bare.display.xdotool(&["key", "plus"]);
    eventually("it is magnified", || bare.shows(twice));
    // A drag moves it, as far as there is something to be seen; arrows, too.
    bare.drag([200, 120], [-40, 20]);
    eventually("it has moved", || bare.shows(|x, y| texel(100 + x / 2, 35 + y / 2)));
    bare.display.xdotool(&["key", "Right"]);
    eventually("it has moved on", || bare.shows(|x, y| texel(120 + x / 2, 35 + y / 2)));
    bare.drag([60, 90], [200, 0]);
    bare.drag([60, 90], [200, 0]);
    eventually("it stops at its edge", || bare.shows(|x, y| texel(x / 2, 35 + y / 2)));
    bare.display.xdotool(&["key", "minus"]);
    eventually("the whole", || bare.shows(texel));
    // The wheel with Ctrl, about the cursor.
    bare.display.xdotool(&["mousemove", "0", "0", "keydown", "ctrl", "click", "4", "keyup", "ctrl"]);
    // A click of xdotool's is one line of the wheel or two.
    eventually("the wheel magnifies", || {
        let pixels = bare.display.pixels(320, 180);
        let middle = pixels[90 * 320 + 160];
        pixels[0] == texel(0, 0) && (middle == texel(128, 72) || middle == texel(102, 57))
    });
    bare.display.xdotool(&["key", "0"]);
    eventually("the whole again", || bare.shows(texel));
    bare.leave();
}

#[test]
fn what_is_shown_is_compared_with_what_was_kept() {
    let bare = Bare::open("r32f", "vec4(0.25)");
    eventually("the first picture", || bare.shows(|_, _| [64; 3]));
    bare.display.xdotool(&["key", "b"]);
    // Kept, it is compared: x goes from a wipe to the difference, which is nothing.
    press(&bare.display, "x", "it is kept", || bare.shows(|_, _| [0; 3]));
    bare.project.write("shaders/fill.comp", BARE.replace("FORMAT", "r32f").replace("VALUE", "vec4(0.5)"));
    // A quarter more.
    eventually("the difference", || bare.shows(|_, _| [64, 38, 6]));
    press(&bare.display, "v", "the kept picture", || bare.shows(|_, _| [64; 3]));
    press(&bare.display, "x", "the picture alone", || bare.shows(|_, _| [128; 3]));
    let wipe = |edge: usize| move |x: usize, _: usize| if x < edge { [128; 3] } else { [64; 3] };
    press(&bare.display, "x", "both at an edge", || bare.shows(wipe(160)));
    bare.drag([160, 60], [-80, 0]);
    eventually("the edge has moved", || bare.shows(wipe(80)));
    // A picture of another size is compared with nothing, and nothing is stretched.
    bare.display.xdotool(&["windowsize", "--sync", &bare.window, "320", "160"]);
    let at =
        |y: usize, expected: [u8; 3]| bare.display.pixels(320, 180)[y * 320..][..320].iter().all(|p| *p == expected);
    eventually("the picture alone in another size", || at(100, [128; 3]));
    bare.display.xdotool(&["windowsize", "--sync", &bare.window, "320", "180"]);
    eventually("both in the first size", || bare.shows(wipe(80)));
    bare.leave();
}

/// A target that is kept live has the contents of each frame: an edit of its shader shows in the difference.
#[test]
fn what_is_shown_is_compared_with_another_target_as_it_goes_on() {
    let bare = Bare::open("r32f", "vec4(0.25)");
    eventually("the first picture", || bare.shows(|_, _| [64; 3]));
    let fill = |value: &str| BARE.replace("FORMAT", "r32f").replace("VALUE", value);
    bare.project.write("shaders/other.comp", fill("vec4(0.5)"));
    let graph = fs::read_to_string(bare.project.path("graphs/bare.toml")).unwrap();
    let more = r#"[targets.other]
format = "r32f"
display = { map = "raw" }
[[passes]]
name = "other"
shader = "other.comp"
dispatch = { threads = "other" }
bind = { outColor = "other" }
"#;
    bare.project.write("graphs/bare.toml", graph + more);
    bare.display.xdotool(&["key", "shift+b"]);
    // The shown target is left of the edge, the live target right of it. After Tab, the two differ.
    press(&bare.display, "Tab", "both targets at an edge", || {
        bare.shows(|x, _| if x < 160 { [128; 3] } else { [64; 3] })
    });
    press(&bare.display, "x", "the difference", || bare.shows(|_, _| [64, 38, 6]));
    bare.project.write("shaders/fill.comp", fill("vec4(0.5)"));
    eventually("the live target has changed", || bare.shows(|_, _| [0; 3]));
    bare.leave();
}

/// Each texel has the colour of its place: beside the panels, the picture begins below the bar, and has a texel for each pixel.
#[test]
fn the_picture_goes_beside_the_panels_and_back() {
    let bare = Bare::open("rgba8", "vec4(at.x & 255, at.y, 200, 255) / 255.0");
    let byte = |place: usize| u8::try_from(place & 255).unwrap();
    eventually("the first picture", || bare.shows(|x, y| [byte(x), byte(y), 200]));
    press(&bare.display, "F1", "the panels", || !bare.shows(|x, y| [byte(x), byte(y), 200]));
    let at = |x: usize, y: usize| bare.display.pixels(320, 180)[y * 320 + x];
    let begins = || [at(20, 120), at(60, 160)];
    press(&bare.display, "F3", "the picture is beside them", || {
        let [[x, y, blue], [right, below, _]] = begins();
        blue == 200 && x == 20 && (60..115).contains(&y) && [right, below] == [x + 40, y + 40]
    });
    press(&bare.display, "F3", "it is under them again", || begins() == [[20, 120, 200], [60, 160, 200]]);
    bare.leave();
}

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
        let graph = include_str!("fixtures/window/flood.toml");
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

#[test]
fn frames_of_a_demo_are_counted() {
    let display = Display::start();
    let arguments = ["run", "worlds/valley.demo.toml", "--size", "160x90", "--frames", "5", "--validate", "-v"];
    let mut command = command(common::repository(), &arguments);
    Run::from(output(command.env("DISPLAY", &display.name).env_remove("WAYLAND_DISPLAY"))).exits(0);
}

#[test]
fn the_camera_is_recorded_into_the_demo() {
    let display = Display::start();
    let project = Project::shipped();
    let before = fs::read_to_string(project.path("worlds/sponge.demo.toml")).unwrap();
    let log_path = project.path("log");
    let mut child = Running::start(
        command(project.root(), &["run", "worlds/sponge.demo.toml", "--size", "320x180", "--validate", "--no-panels"])
            .env("DISPLAY", &display.name)
            .env_remove("WAYLAND_DISPLAY")
            .stderr(fs::File::create(&log_path).unwrap()),
    );
    let mut window = String::new();
    eventually("the window", || {
        display.xdotool(&["search", "--name", "raxel"]).trim().clone_into(&mut window);
        !window.is_empty()
    });
    let title = || display.xdotool(&["getwindowname", &window]);
    eventually("the title", || title().starts_with("inspect · "));
    display.xdotool(&["windowfocus", "--sync", &window]);
    press(&display, "space", "a pause", || title().contains("· paused"));
    let read = || fs::read_to_string(project.path("worlds/sponge.demo.toml")).unwrap();
    press(&display, "k", "the key is in the file", || read() != before);
    let recorded = read();
    // Every line of the file is still there, in order, but the camera of a key that happened to be at this time. Such a key keeps its own
    // alignment.
    let mut lines = recorded.lines();
    let stays = |line: &&str| !line.is_empty() && !line.starts_with("position") && !line.starts_with("look_at");
    assert!(before.lines().filter(stays).all(|line| lines.any(|new| new == line)), "{recorded}");
    let key = recorded.split("[[camera]]\n").find(|key| !before.contains(key.trim_end())).unwrap();
    let names: Vec<&str> = key.lines().filter_map(|line| Some(line.split_once('=')?.0.trim())).collect();
    assert!(["time", "position", "yaw", "pitch", "fov"].iter().all(|name| names.contains(name)), "{key}");
    eventually("the demo is read again", || log(&log_path).contains("gen 1"));
    assert!(!log(&log_path).contains("error"), "{}", log(&log_path));
    press(&display, "Escape", "it leaves", || child.ended());
    assert_eq!(child.finish().code(), Some(0), "{}", log(&log_path));
}

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

/// Works for minutes on the software driver: it leaves a loop after 65535 rounds, so a round is long and the groups are many.
const SPIN: &str = include_str!("fixtures/window/spin.comp");

#[test]
fn a_dispatch_that_does_not_end_is_named_and_keeps_neither_edits_nor_escape() {
    let display = Display::start();
    let project = Project::empty();
    project.write("graphs/spin.toml", include_str!("fixtures/window/spin.toml"));
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
    project.write("graphs/spin.toml", include_str!("fixtures/window/spin.toml"));
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
const NO_DISPLAY: &str = include_str!("fixtures/window/no_display.c");

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
const LOSS: &str = include_str!("fixtures/window/loss.c");

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
fn a_scale_computes_fewer_pixels_for_the_same_window() {
    let display = Display::start();
    let project = Project::shipped();
    let arguments = ["--world", "worlds/menger.toml", "--no-panels"];
    let mut child = Running::start(
        command(project.root(), &["run", "graphs/inspect.toml", "--size", "320x180", "--scale", "0.5", "--validate"])
            .args(arguments)
            .env("DISPLAY", &display.name)
            .env_remove("WAYLAND_DISPLAY")
            .stderr(Stdio::null()),
    );
    project
        .raxel(&["render", "graphs/inspect.toml", "--world", "worlds/menger.toml", "--size", "160x90", "-o", "r.png"])
        .exits(0);
    let half = image::open(project.path("r.png")).unwrap().into_rgb8();
    let pixels = (0..180).flat_map(|y| (0..320).map(move |x| (x, y)));
    let expected: Vec<[u8; 3]> = pixels.map(|(x, y)| half.get_pixel(x / 2, y / 2).0).collect();
    eventually("the smaller picture, enlarged", || display.pixels(320, 180) == expected);
    let window = display.xdotool(&["search", "--name", "raxel"]).trim().to_owned();
    display.xdotool(&["windowfocus", "--sync", &window]);
    press(&display, "Escape", "it leaves", || child.ended());
    assert_eq!(child.finish().code(), Some(0));

    let refused = project.raxel(&["run", "--scale", "0"]).exits(2);
    assert!(refused.stderr.contains("from 0.0625 to 4"), "{}", refused.stderr);
}

#[test]
fn without_a_display_the_way_out_is_said() {
    let mut command = command(common::repository(), &["run"]);
    let command = command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
    let said = Run::from(output(command)).exits(4).stderr;
    assert!(said.contains("raxel render") && !said.contains(".rs:"), "{said}");
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

/// A window of 600 × 400 with the picture, as red as its only param says, beside the slider of that param.
struct Slider {
    display: Display,
    project: Project,
    child: Running,
}

impl Slider {
    fn open() -> Self {
        let (display, project) = (Display::start(), Project::empty());
        project.write("graphs/bare.toml", include_str!("fixtures/window/bare.toml"));
        let push = "layout(push_constant) uniform PC { float red; } pc;\nvoid main()";
        let shader = BARE.replace("FORMAT", "rgba8").replace("VALUE", "vec4(pc.red, 0, 0, 1)");
        project.write("shaders/fill.comp", shader.replace("void main()", push));
        project.write(
            "worlds/box.toml",
            r##"name = "box"
[materials]
red = { albedo = "#ff0000" }
[[build]]
op = "box"
min = [0, 0, 0]
max = [4, 4, 4]
material = "red"
"##,
        );
        let docks =
            "docks = { across = { share = 0.5, left = { tabs = [\"picture\"] }, right = { tabs = [\"params\"] } } }\n";
        project.write(".raxel/window.toml", docks);
        let child = Running::start(
            command(
                project.root(),
                &["run", "graphs/bare.toml", "--world", "worlds/box.toml", "--size", "600x400", "--validate"],
            )
            .env("DISPLAY", &display.name)
            .env_remove("WAYLAND_DISPLAY")
            .stderr(fs::File::create(project.path("log")).unwrap()),
        );
        let slider = Self { display, project, child };
        eventually("the first picture", || slider.red() == [64, 0, 0]);
        let window = slider.display.xdotool(&["search", "--name", "raxel"]).trim().to_owned();
        slider.display.xdotool(&["windowfocus", "--sync", &window]);
        slider
    }

    fn log(&self) -> String {
        log(&self.project.path("log"))
    }

    /// A pixel below bar and tabs, left of the panel, and away from the pointer, which is in the picture, too.
    fn red(&self) -> [u8; 3] {
        self.display.pixels(600, 400)[330 * 600 + 40]
    }

    fn leave(mut self) {
        press(&self.display, "Escape", "it leaves", || self.child.ended());
        assert_eq!(self.child.finish().code(), Some(0), "{}", log(&self.project.path("log")));
    }
}

#[test]
fn a_write_is_undone_before_the_motion_that_it_wrote() {
    let slider = Slider::open();
    let display = &slider.display;
    let rest = || std::thread::sleep(Duration::from_millis(300));
    let file = || fs::read_to_string(slider.project.path("graphs/bare.toml")).unwrap();
    let first = file();
    display.xdotool(&["mousemove", "386", "137"]);
    rest();
    // It is let go of in the frame of its last motion.
    display.xdotool(&["mousedown", "1", "mousemove", "420", "137"]);
    rest();
    display.xdotool(&["mousemove", "470", "137", "mouseup", "1"]);
    eventually("the param follows", || slider.red() == [255, 0, 0]);
    display.xdotool(&["mousemove", "345", "56"]);
    rest();
    display.xdotool(&["click", "1"]);
    eventually("the file has the value", || file().contains("default = 1.0"));
    eventually("it is read", || slider.log().contains("gen 1"));
    // Keys are the window's where the pointer is.
    display.xdotool(&["mousemove", "100", "200"]);
    rest();
    press(display, "ctrl+z", "the file is as it was", || file() == first);
    eventually("that is read", || slider.log().contains("gen 2"));
    eventually("the window keeps the value", || slider.red() == [255, 0, 0]);
    rest();
    assert_eq!(slider.red(), [255, 0, 0], "it stays");
    press(display, "ctrl+z", "all of the motion is undone", || slider.red() == [64, 0, 0]);
    slider.leave();
}

#[test]
fn a_slider_that_is_recorded_makes_a_demo_and_undo_takes_it_back() {
    let slider = Slider::open();
    let Slider { display, project, .. } = &slider;
    let (red, log) = (|| slider.red(), || slider.log());
    let rest = || std::thread::sleep(Duration::from_millis(300));
    display.xdotool(&["mousemove", "441", "56"]);
    rest();
    display.xdotool(&["click", "1"]);
    rest();
    // The handle of the only slider, from a quarter to its upper end.
    display.xdotool(&["mousemove", "386", "137"]);
    rest();
    display.xdotool(&["mousedown", "1"]);
    for x in ["400", "420", "440", "470"] {
        rest();
        display.xdotool(&["mousemove", x, "137"]);
    }
    eventually("the param follows", || red() == [255, 0, 0]);
    display.xdotool(&["mouseup", "1"]);
    let demo = project.path("worlds/take.demo.toml");
    eventually("the demo", || log().contains("opened worlds/take.demo.toml"));
    let text = fs::read_to_string(&demo).unwrap();
    assert!(text.contains("world = \"box.toml\"\ngraph = \"bare.toml\"") && text.contains("[tracks.red]"), "{text}");
    assert!(text.contains("[0.0, 0.25]") && text.contains(", 1.0]"), "{text}");
    // The demo plays the motion, from dark to bright.
    eventually("it is dark again", || red()[0] < 128);
    eventually("it is bright again", || red() == [255, 0, 0]);
    display.xdotool(&["mousemove", "100", "200"]);
    press(display, "ctrl+z", "the demo is gone", || !demo.exists());
    eventually("the graph runs without it", || log().contains("opened graphs/bare.toml"));
    slider.leave();
}
