//! Mouse, keyboard, gamepad and time of day, as passes see them: held by a person, driven by a demo, recorded as a take.

#![allow(clippy::float_cmp, reason = "these values are exact")]

mod project;

use std::path::Path;

use project::{Project, Sessions, assert_silent, box_world};
use raxel_edit::{Brush, Operation};
use raxel_execute::PassOutcome;
use raxel_graph::checked::Value;
use raxel_runtime::camera::Camera;
use raxel_runtime::inputs::{Key, KeySet};
use raxel_runtime::take::{Ended, TakeError};
use raxel_runtime::{Options, Session};
use raxel_world::Bounds;

const SHADER: &str = include_str!("fixtures/inputs/told.comp");

const GRAPH: &str = include_str!("fixtures/inputs/told.toml");

fn told_project() -> Project {
    let project = Project::filled();
    project.write("graphs/told.toml", GRAPH);
    project.write("shaders/told.comp", SHADER);
    project.write("worlds/box.toml", box_world(4));
    project
}

fn open(project: &Project) -> Session {
    let world = Some(Path::new("worlds/box.toml").to_owned());
    let graph = Some(Path::new("graphs/told.toml").to_owned());
    Project::open_with(Options { graph, world, step: Some(1.0 / 50.0), ..project.options() })
}

/// The shader's inputs in one more frame: cursor and buttons, drag, wheel and time of day, keys.
fn told(session: &mut Session) -> [[f32; 4]; 4] {
    session.frame().unwrap();
    let texels = session.read_target("told").unwrap().floats();
    [texels[0], texels[1], texels[2], texels[3]]
}

fn key(name: &str) -> Key {
    Key::named(name).unwrap()
}

#[test]
fn a_frame_is_told_what_is_held() {
    let project = told_project();
    let mut session = open(&project);
    let none = [[-1.0, -1.0, 0.0, 0.0], [-1.0; 4], [0.0; 4], [0.0; 4]];
    assert_eq!(told(&mut session), none);
    session.set_cursor(Some([3, 4]));
    let inputs = session.inputs();
    inputs.button(1, true);
    inputs.turn([0.5, -2.0]);
    inputs.key(key("KeyW"), true);
    inputs.set_time_of_day(100.0);
    let [mouse, drag, wheel, keys] = told(&mut session);
    assert_eq!((mouse, drag), ([3.0, 4.0, 1.0, 1.0], [3.0, 4.0, 3.0, 4.0]));
    assert_eq!((wheel[..2].to_vec(), keys), (vec![0.5, -2.0], [1.0, 1.0, 1.0, 0.0]));
    assert!((wheel[2] - 100.02).abs() < 1e-3, "a frame later: {}", wheel[2]);
    session.set_cursor(Some([7, 4]));
    let inputs = session.inputs();
    inputs.button(1, false);
    inputs.button(2, true);
    inputs.key(key("KeyW"), false);
    inputs.key(key("Space"), true);
    let [mouse, drag, _, keys] = told(&mut session);
    assert_eq!((mouse, drag), ([7.0, 4.0, 2.0, 2.0], [7.0, 4.0, 3.0, 4.0]));
    assert_eq!(keys, [0.0, 0.0, 1.0, 1.0]);
    session.reset();
    let [mouse, drag, wheel, keys] = told(&mut session);
    assert_eq!((mouse, drag, wheel[1]), ([7.0, 4.0, 2.0, 2.0], [-1.0; 4], 0.0));
    assert_eq!(keys, [0.0, 0.0, 0.0, 1.0], "nothing was toggled since");
    assert_silent(&session);
}

#[test]
fn a_frame_is_told_of_the_gamepad() {
    let project = told_project();
    let mut session = open(&project);
    let gamepad = |session: &mut Session| {
        session.frame().unwrap();
        let texels = session.read_target("told").unwrap().floats();
        [texels[5], texels[6]]
    };
    assert_eq!(gamepad(&mut session), [[0.0; 4]; 2]);
    let inputs = session.inputs();
    inputs.set_gamepad_sticks([0.5, -0.25, 0.0, 1.0]);
    inputs.set_gamepad_triggers([0.0, 0.75]);
    inputs.gamepad_button(1 << 3, true);
    assert_eq!(gamepad(&mut session), [[0.5, -0.25, 0.0, 1.0], [0.0, 0.75, 8.0, 8.0]]);
    assert_eq!(gamepad(&mut session)[1], [0.0, 0.75, 8.0, 0.0]);
    session.inputs().rest_gamepad();
    assert_eq!(gamepad(&mut session), [[0.0; 4]; 2]);
    assert_silent(&session);
}

#[test]
fn an_input_that_no_pass_reads_disturbs_nothing() {
    let project = told_project();
    project.write("graphs/still.toml", project::VALID_GRAPH.replace("\"valid.comp\"", "\"still.comp\""));
    project.write("shaders/still.comp", project::VALID);
    let mut session = project.open_graph("graphs/still.toml");
    let still = |session: &mut Session| {
        session.frame().unwrap();
        session.read_target("sum").unwrap().floats()[0][1]
    };
    assert_eq!((still(&mut session), still(&mut session)), (0.0, 1.0));
    session.inputs().key(key("KeyW"), true);
    session.inputs().button(1, true);
    session.inputs().turn([0.0, 1.0]);
    session.inputs().set_gamepad_sticks([1.0; 4]);
    session.inputs().hold_gamepad_buttons(1);
    assert_eq!(still(&mut session), 2.0);
}

/// A pass that reads keys runs again when they change, and not otherwise.
#[test]
fn a_key_wakes_the_passes_that_read_it() {
    let project = Project::filled();
    project.write(
        "graphs/keys.toml",
        project::FILL_GRAPH
            .replace("bind = {", "bind = { keys = \"keys\",")
            .replace("[[passes]]", "[buffers.keys]\nsource = \"input.keys\"\n[[passes]]"),
    );
    let shader = project::fill("vec4(rx_key(RX_KEY_ARROW_UP))").replace("//INCLUDE", "#include <raxel/keys.glsl>");
    project.write("shaders/fill.comp", &shader);
    let mut session = project.open_graph("graphs/keys.toml");
    let frame = |session: &mut Session| {
        session.frame().unwrap();
        (session.outcomes()[0] == PassOutcome::Dispatched, project::red(session))
    };
    assert_eq!(frame(&mut session), (true, 0.0));
    assert_eq!(frame(&mut session), (false, 0.0));
    session.inputs().key(key("ArrowUp"), true);
    assert_eq!(frame(&mut session), (true, 1.0));
    // It was pressed in that frame, and not in this one: two changes.
    assert_eq!(frame(&mut session), (true, 1.0));
    assert_eq!(frame(&mut session), (false, 1.0));
    assert_silent(&session);
}

/// Does something else in each frame of a session.
fn play(session: &mut Session, frame: i32) {
    if frame % 3 == 0 {
        session.set_cursor((frame != 9).then_some([frame, 15 - frame]));
    }
    if frame == 4 || frame == 12 {
        session.inputs().hold_buttons(1);
    }
    if frame == 7 {
        session.inputs().hold_buttons(4);
        session.inputs().turn([0.0, 1.5]);
    }
    if frame == 3 || frame == 10 {
        session.inputs().hold_gamepad_buttons(1 << (frame % 4) | 1 << 14);
    }
    if (4..9).contains(&frame) {
        let axis = f64::from(frame) / 10.0;
        session.inputs().set_gamepad_sticks([axis, -axis, f64::from(0.3_f32), 0.0]);
        session.inputs().set_gamepad_triggers([0.0, axis]);
    }
    let keys: &[&str] = if (5..8).contains(&frame) { &["KeyW", "Space"] } else { &[] };
    session.inputs().hold_keys(keys.iter().map(|name| key(name)).collect::<KeySet>());
    if frame == 6 {
        session.set_param("gain", Value::F32(2.5)).unwrap();
        session.set_param("steps", Value::U32(4)).unwrap();
    }
    if frame > 7 {
        let mut camera = Camera::at([0.25 + f64::from(frame), 7.3, -2.0]);
        camera.yaw = 0.1 * f64::from(frame);
        camera.pitch = -0.3;
        session.set_camera(camera);
    }
}

#[test]
fn a_take_gives_the_same_bytes() {
    let project = told_project();
    let mut session = open(&project);
    // Inputs before it are not part of it.
    session.inputs().set_time_of_day(43_200.5);
    session.frame().unwrap();
    session.record().unwrap();
    assert_eq!(session.record(), Err(TakeError::Recording));
    assert_eq!(session.take("take"), Err(TakeError::Empty));
    let bytes = |session: &mut Session| {
        session.frame().unwrap();
        session.read_target("told").unwrap().bytes
    };
    let played: Vec<Vec<u8>> = (0..16)
        .map(|frame| {
            play(&mut session, frame);
            bytes(&mut session)
        })
        .collect();
    let take = session.take("take").unwrap();
    session.stop_recording();
    assert_eq!((take.seconds, take.ended, session.take("take")), (16.0 / 50.0, None, Err(TakeError::NotRecording)));
    assert_silent(&session);

    project.write("worlds/take.demo.toml", &take.text);
    let demo = || {
        let demo = Some(Path::new("worlds/take.demo.toml").to_owned());
        Project::open_with(Options { demo, step: Some(1.0 / 50.0), ..project.options() })
    };
    let mut again = demo();
    let of_demo = again.demo().unwrap();
    assert_eq!((of_demo.frames(), of_demo.size, of_demo.fps.to_bits()), (16, [16, 16], 50.0_f64.to_bits()));
    for (frame, played) in played.iter().enumerate() {
        assert!(bytes(&mut again) == *played, "frame {frame}:\n{}", take.text);
    }
    // A part of it gets the same inputs as the whole: presses are those since the frame before.
    for start in [4, 5, 7, 12] {
        let mut part = demo();
        part.start_at(start as u64);
        let told = bytes(&mut part);
        let first = 8 * 16;
        assert!(told[..first] == played[start][..first], "from frame {start}");
    }
    assert_silent(&again);
}

#[test]
fn a_take_ends_where_it_cannot_go_on() {
    let project = told_project();
    let mut session = open(&project);
    let ended = |session: &mut Session, disturb: &dyn Fn(&mut Session)| {
        session.record().unwrap();
        for _ in 0..3 {
            session.frame().unwrap();
        }
        disturb(session);
        session.frame().unwrap();
        session.frame().unwrap();
        let take = session.take("take").unwrap();
        session.stop_recording();
        (take.ended, (take.seconds * 50.0).round())
    };
    assert_eq!(ended(&mut session, &|_| {}), (None, 5.0));
    assert_eq!(ended(&mut session, &Session::reset), (Some(Ended::TimeWentBack), 3.0));
    assert_eq!(ended(&mut session, &|session| session.resize(8, 8)), (Some(Ended::OtherSize), 3.0));
    assert_eq!(ended(&mut session, &|session| session.seek(700.0)), (Some(Ended::Full), 3.0));
    // A take is written while it goes on. The end of that ends no later take.
    session.record().unwrap();
    session.frame().unwrap();
    let earlier = session.take_so_far().unwrap();
    let identity = earlier.identity();
    assert!(session.is_take_written());
    drop(earlier);
    assert!(session.is_take_written(), "whether it was written was not reported yet");
    session.stop_recording_of(&identity);
    assert!(session.recording().is_none() && !session.is_take_written());
    session.record().unwrap();
    assert!(!session.is_take_written());
    session.stop_recording_of(&identity);
    assert!(session.recording().is_some());
    session.stop_recording();
    // Without a world there is no demo.
    let empty = Project::filled();
    assert_eq!(empty.open().record(), Err(TakeError::NoWorld));
}

/// Edits made while a take is recorded stand in its demo, for the frames that saw them first.
#[test]
fn a_take_holds_edits() {
    let project = told_project();
    let mut session = open(&project);
    let voxels = |session: &mut Session| {
        session.frame().unwrap();
        session.read_target("told").unwrap().floats()[7][0]
    };
    let before = voxels(&mut session);
    session.record().unwrap();
    let material = 1;
    let mut seen = Vec::new();
    for frame in 0..10 {
        match frame {
            2 => {
                let bounds = Bounds { min: [20, 0, 0], max: [23, 2, 2] };
                session.edit(&[Operation::Box { bounds, brush: Brush::Add(material) }]).unwrap();
            }
            4 => {
                session.edit(&[Operation::set([21, 0, 0], 0), Operation::set([30, 5, -5], material)]).unwrap();
            }
            6 => {
                session.edit(&[Operation::sphere([40.25, 3.0, 0.5], 3.0, Brush::Add(material))]).unwrap();
            }
            8 => {
                let (base, height) = ([40, 0, 0].map(|at| at * 256), 4);
                let brush = Brush::Subtract;
                session.edit(&[Operation::Cylinder { axis: 1, base, radius: 512, height, brush }]).unwrap();
            }
            _ => {}
        }
        seen.push(voxels(&mut session));
    }
    assert_eq!(seen[..5], [before, before, before + 12.0, before + 12.0, before + 12.0]);
    assert!(seen[6] > seen[5] && seen[8] < seen[7], "{seen:?}");
    let take = session.take("take").unwrap();
    session.stop_recording();
    project.write("worlds/take.demo.toml", &take.text);
    let demo = Some(Path::new("worlds/take.demo.toml").to_owned());
    let mut again = Project::open_with(Options { demo, step: Some(1.0 / 50.0), ..project.options() });
    let shown: Vec<f32> = (0..10).map(|_| voxels(&mut again)).collect();
    assert_eq!(shown, seen, "{}", take.text);
    assert_silent(&again);

    // No demo's file can say an undo.
    session.record().unwrap();
    voxels(&mut session);
    assert!(session.undo().unwrap());
    voxels(&mut session);
    assert_eq!(session.take("take").unwrap().ended, Some(Ended::Unsaid));
}
