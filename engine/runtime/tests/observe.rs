//! Showing, pinning and reading change nothing that later frames compute. On a real device with the validation layer on.
#![allow(clippy::float_cmp, reason = "texels are compared with the very values that were written")]

mod project;

use project::{Project, Sessions};
use raxel_graph::checked::Value;
use raxel_runtime::{Observe, Options, Session};

/// `color` is shown. It does not need `sum`, which adds up frames, `rare`, which only every third frame writes, or `copy`.
const GRAPH: &str = include_str!("fixtures/observe/numbers.toml");

const HEAD: &str = "#version 460\nlayout(local_size_x = 1) in;\n";

const NAMES: [&str; 5] = ["color", "copy", "sum", "rare", "valid"];

fn project() -> Project {
    let project = Project::filled();
    let push = "layout(push_constant) uniform Push { float value; };\n";
    let store = "layout(r32f) writeonly uniform image2D to;\n";
    project.write("graphs/numbers.toml", GRAPH);
    project.write(
        "shaders/set.comp",
        format!("{HEAD}{store}{push}void main() {{ imageStore(to, ivec2(0), vec4(value)); }}\n"),
    );
    project.write(
        "shaders/add.comp",
        format!(
            "{HEAD}layout(r32f) uniform image2D to;\n{push}\
             void main() {{ imageStore(to, ivec2(0), imageLoad(to, ivec2(0)) + value); }}\n"
        ),
    );
    project.write(
        "shaders/copy.comp",
        format!(
            "{HEAD}layout(r32f) readonly uniform image2D from;\n{store}\
             void main() {{ imageStore(to, ivec2(0), imageLoad(from, ivec2(0))); }}\n"
        ),
    );
    project.write(
        "shaders/told.comp",
        format!(
            "{HEAD}{store}layout(push_constant) uniform Push {{ uint still; uint valid; }};\n\
             void main() {{ imageStore(to, ivec2(0), vec4(still * 2u + valid)); }}\n"
        ),
    );
    project
}

fn open(project: &Project, observe: Observe) -> Session {
    let graph = Some("graphs/numbers.toml".into());
    Project::open_with(Options { graph, observe, step: Some(0.25), ..project.options() })
}

fn read(session: &mut Session, name: &str) -> Result<f32, String> {
    session.read_target(name).map(|texels| texels.floats()[0][0]).map_err(|error| error.to_string())
}

fn frame(session: &mut Session, frame: usize) {
    // The picture stands still now and then.
    session.set_param("value", Value::F32([1.0, 1.0, 1.0, 2.0, 0.5, 0.5][frame % 6])).unwrap();
    session.frame().unwrap();
}

const FRAMES: usize = 24;

/// The contents of every target after each frame, when everything can be read.
fn all(project: &Project) -> Vec<Vec<f32>> {
    let mut session = open(project, Observe::Everything);
    let mut frames = Vec::new();
    for number in 0..FRAMES {
        frame(&mut session, number);
        frames.push(NAMES.iter().map(|name| read(&mut session, name).unwrap()).collect());
    }
    project::assert_silent(&session);
    frames
}

#[test]
fn everything_can_be_read_without_being_pinned() {
    let project = project();
    let frames = all(&project);
    let times = |name| frames.iter().map(|values| values[name]).collect::<Vec<_>>();
    assert_eq!(times(0)[..6], [1.0, 1.0, 1.0, 2.0, 0.5, 0.5]);
    assert_eq!(times(2)[..6], [1.0, 2.0, 3.0, 5.0, 5.5, 6.0]);
    assert_eq!(times(1)[..6], [0.0, 1.0, 2.0, 3.0, 5.0, 5.5], "`sum` as the frame before left it");
    assert_eq!(times(3)[..7], [0.0, 0.0, 0.0, 0.75, 0.75, 0.75, 1.5]);
    assert_eq!(times(4)[..6], [0.0, 2.0, 5.0, 1.0, 1.0, 3.0], "`frame.still` and `history.valid`");
}

#[test]
fn what_is_not_shown_is_refused_until_it_is_pinned_and_never_stale() {
    let project = project();
    let frames = all(&project);
    let mut session = open(&project, Observe::Shown);
    for (number, left) in frames.iter().enumerate() {
        match number {
            5 => session.pin("copy").unwrap(),
            9 => session.set_debug_target_text("rare").unwrap(),
            13 => session.set_debug_target_text("copy").unwrap(),
            17 => session.set_debug_target_text("color").unwrap(),
            _ => {}
        }
        // A choice holds from the next frame on: a read is of the last one.
        if number == 5 {
            let refused = read(&mut session, "copy").unwrap_err();
            assert!(refused.contains("pin it to read it from the next frame on"), "{refused}");
        }
        frame(&mut session, number);
        for (name, left) in NAMES.iter().zip(left) {
            match read(&mut session, name) {
                Ok(value) => assert_eq!(value, *left, "`{name}` after frame {number}"),
                Err(refused) => assert!(refused.contains("pin"), "{refused}"),
            }
        }
        // Contents that later frames read are there for any shown target.
        for name in ["sum", "rare", "valid"] {
            read(&mut session, name).unwrap();
        }
        assert_eq!(read(&mut session, "copy").is_ok(), number >= 5);
        assert_eq!(read(&mut session, "color").is_ok(), !(9..17).contains(&number));
    }
    project::assert_silent(&session);
}
