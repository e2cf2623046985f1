//! Shaders count, print and assert, and the writers of a texel are told.

use crate::common::{Project, RunRaxel};

/// A full queue is reported at the end, once, with its place in the graph; one with room is not.
#[test]
fn what_passes_count_is_said_at_the_end() {
    let project = Project::shipped();
    let render = |more: &[&str]| {
        let scene = ["render", "graphs/examples/warnings.toml", "--world", "worlds/menger.toml", "--size", "96x54"];
        project.raxel(&[&scene[..], more, &["--frames", "4", "-o", "a.png"]].concat()).exits(0)
    };
    assert!(!render(&[]).stderr.contains("RX0411"));
    project.edit("graphs/examples/warnings.toml", "count = 262144", "count = 64");
    let said = render(&[]).stderr;
    assert_eq!(said.matches("warning[RX0411]: pixels show the sky").count(), 1, "{said}");
    assert!(said.contains("graphs/examples/warnings.toml:") && said.contains("raise `count`"), "{said}");
    let lines = render(&["--format", "json"]).stderr;
    let found = lines.lines().filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok());
    let found: Vec<_> = found.filter(|found| found["code"] == "RX0411").collect();
    assert_eq!(found.len(), 1, "{lines}");
}

/// Prints of a pass come frame by frame, and a failed assertion is an error after the picture was written.
#[test]
fn shaders_print_and_assert() {
    let project = Project::shipped();
    let scene =
        ["render", "graphs/examples/print.toml", "--world", "worlds/menger.toml", "--size", "96x54", "-o", "a.png"];
    let said = project.raxel(&scene).exits(0).stderr;
    let line = said.lines().find(|line| line.contains("voxel (")).unwrap_or_else(|| panic!("{said}"));
    assert!(
        line.starts_with("shaders/examples/print.comp:") && line.contains(": `look`, frame 0, (48, 27, 0): "),
        "{line}"
    );
    let json = project.raxel(&[&scene[..], &["--format", "json"]].concat()).exits(0).stderr;
    let event = json.lines().filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok());
    let event = event.into_iter().find(|event| event["event"] == "printed").unwrap_or_else(|| panic!("{json}"));
    assert_eq!(
        (&event["pass"], &event["frame"], &event["lines"][0]["invocation"][1]),
        (&"look".into(), &0.into(), &27.into())
    );

    project.edit("shaders/examples/print.comp", "rx_assert(!found || hit.t >= 0.0)", "rx_assert(pixel.y != 3)");
    std::fs::remove_file(project.path("a.png")).unwrap();
    let said = project.raxel(&scene).exits(1).stderr;
    assert!(said.contains("error[RX0412]: `rx_assert(pixel.y != 3)` failed in pass `look`: 96 invocations"), "{said}");
    assert!(said.contains("shaders/examples/print.comp:") && said.contains(", 3, 0) of frame 0"), "{said}");
    assert!(project.path("a.png").exists());
}

/// `a` stores 1, and `b` copies it into the shown target. `c` stores 2, and nothing shown depends on it.
#[test]
fn texels_are_those_that_the_last_writer_left() {
    let project = Project::empty();
    let set = "shader = 'set.comp'\ndispatch = [1, 1, 1]\nbind = { to = 't' }\n";
    let graph = format!(
        r"name = 'numbers'
present = 'fin'
[targets.t]
format = 'r32f'
size = [1, 1]
[targets.fin]
format = 'r32f'
size = [1, 1]
[[passes]]
name = 'a'
{set}push = {{ value = 1.0 }}
[[passes]]
name = 'b'
shader = 'copy.comp'
dispatch = [1, 1, 1]
bind = {{ from = 't', to = 'fin' }}
[[passes]]
name = 'c'
{set}push = {{ value = 2.0 }}
"
    );
    let head = "#version 460\nlayout(local_size_x = 1) in;\nlayout(r32f) writeonly uniform image2D to;\n";
    let set = "layout(push_constant) uniform Push { float value; };\n\
               void main() { imageStore(to, ivec2(0), vec4(value)); }\n";
    let copy = "layout(r32f) readonly uniform image2D from;\n\
                void main() { imageStore(to, ivec2(0), imageLoad(from, ivec2(0))); }\n";
    project.write("graphs/numbers.toml", graph);
    project.write("shaders/set.comp", format!("{head}{set}")).write("shaders/copy.comp", format!("{head}{copy}"));
    let first = |file: &str| {
        let image = exr::prelude::read_first_flat_layer_from_file(project.path(file)).unwrap();
        image.layer_data.channel_data.list[0].sample_data.values_as_f32().next().unwrap()
    };
    let render = ["render", "graphs/numbers.toml", "--size", "1x1", "--frames", "3", "-o", "f/%d.exr"];
    for (more, value) in [(&["--target", "t"][..], 2), (&["--target", "fin"], 1), (&["--layers", "t"], 2)] {
        project.raxel(&[&render[..], more].concat()).exits(0);
        assert_eq!([0, 1, 2].map(|frame| first(&format!("f/{frame}.exr")) as u32), [value; 3], "{more:?}");
    }
    // A point within a frame has a picture, but leaves no texels.
    for after in [&["--target", "t", "--after", "a"][..], &["--target", "t,after=a"]] {
        let refused = project.raxel(&[&render[..], after].concat()).exits(2);
        assert!(refused.stderr.contains("an EXR has the texels at the end of the frame"), "{}", refused.stderr);
    }
}
