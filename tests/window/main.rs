//! One real window, under Xvfb. It shows the picture that `render` writes, shows edits, takes keys, and closes in order.

#[path = "../common/mod.rs"]
mod common;

mod device;
mod files;
mod input;
mod long_work;
mod picture;
mod record;

use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use common::{Display, Project, RunRaxel, Running, command, eventually};

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
