//! Demos are counted and recorded, and what is written is undone.

use std::fs;
use std::time::Duration;

use crate::common::{Display, Project, Run, Running, command, eventually, output, repository};
use crate::{BARE, log, press};

#[test]
fn frames_of_a_demo_are_counted() {
    let display = Display::start();
    let arguments = ["run", "worlds/valley.demo.toml", "--size", "160x90", "--frames", "5", "--validate", "-v"];
    let mut command = command(repository(), &arguments);
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

/// A take that has ended by itself stays until it can be written.
#[test]
fn a_take_that_cannot_be_written_is_written_by_a_later_key() {
    let display = Display::start();
    let project = Project::shipped();
    let log_path = project.path("log");
    let graph = ["run", "graphs/examples/paint.toml", "--world", "worlds/menger.toml"];
    let options = ["--size", "320x180", "--no-panels"];
    let mut child = Running::start(
        command(project.root(), &[&graph[..], &options].concat())
            .env("DISPLAY", &display.name)
            .env_remove("WAYLAND_DISPLAY")
            .stderr(fs::File::create(&log_path).unwrap()),
    );
    eventually("the empty canvas", || display.pixels(320, 180)[0].iter().all(|channel| *channel > 200));
    let window = display.xdotool(&["search", "--name", "raxel"]).trim().to_owned();
    let title = || display.xdotool(&["getwindowname", &window]);
    display.xdotool(&["windowfocus", "--sync", &window]);
    press(&display, "F9", "a take begins", || title().contains("· recording"));
    let (worlds, away) = (project.path("worlds"), project.path("away"));
    fs::rename(&worlds, &away).unwrap();
    display.xdotool(&["windowsize", "--sync", &window, "200", "150"]);
    let refused = || log(&log_path).matches("take.demo.toml").count();
    eventually("it cannot be written", || refused() > 0);
    let told = refused();
    std::thread::sleep(Duration::from_millis(500));
    assert_eq!(refused(), told, "once: {}", log(&log_path));
    assert!(title().contains("· recording"), "{}", title());
    fs::rename(&away, &worlds).unwrap();
    press(&display, "F9", "the take is written", || log(&log_path).contains("wrote a take"));
    assert!(log(&log_path).contains("it ended early"), "{}", log(&log_path));
    eventually("the take has ended", || !title().contains("· recording"));
    press(&display, "Escape", "it leaves", || child.ended());
    assert_eq!(child.finish().code(), Some(0), "{}", log(&log_path));
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
        project.write("graphs/bare.toml", include_str!("../fixtures/window/bare.toml"));
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
