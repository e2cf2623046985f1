//! How the picture is shown: magnified, compared, beside the panels, at another scale.

use std::fs;
use std::process::Stdio;

use crate::common::{Display, Project, RunRaxel, Running, command, eventually};
use crate::{BARE, Bare, press};

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
