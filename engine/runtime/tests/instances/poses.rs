//! Shaders move instances.

use std::fs;

use raxel_graph::checked::Value;
use raxel_layouts::instances::{Frame, Pose, Rotation};
use raxel_oracle::sets::Random;
use raxel_runtime::{Options, Session};
use raxel_worldfile::Loaded;

use crate::project::{Project, Sessions, assert_silent};
use crate::{GRAPH, RAYS, bytes, hits, judge_some, load, open, options, project, random_instances, rays_for};

/// Puts the first instances where a buffer says, one record a thread, and traces the rays of a file two frames long.
const POSE_SHADER: &str = include_str!("../fixtures/instances/pose.comp");

const POSE_PASS: &str = r#"
[params.kind]
type = "u32"
default = 0
range = [0, 3]
[params.wrong]
type = "u32"
default = 0
range = [0, 2]
[buffers.wanted]
source = "file.data/wanted.bin"
[buffers.poses]
source = "world.poses"
[[passes]]
name = "pose"
shader = "pose.comp"
dispatch = { threads = [64, 1, 1] }
bind = { poses = "poses", Wanted = "wanted" }
push = { kind = "param.kind", wrong = "param.wrong" }
"#;

/// The words that the shader reads, and the same as the file of a world would say it: a cell, a place in it, three angles.
fn wanted(count: usize, seed: u64) -> (Vec<u8>, Vec<Pose>) {
    let mut random = Random::new(seed);
    let mut words = Vec::new();
    let mut poses = Vec::new();
    for i in 0..count {
        let cell: [i32; 3] = std::array::from_fn(|_| random.below(70) as i32 - 35);
        let free = i % 2 == 1;
        let place: [f32; 3] = std::array::from_fn(|_| if free { random.unit() * 3.0 - 1.0 } else { 0.0 });
        let turn: [f32; 3] =
            std::array::from_fn(|_| if free { random.unit() * 700.0 - 350.0 } else { 90.0 * random.below(4) as f32 });
        words.extend(cell.map(i32::cast_unsigned));
        words.extend(place.map(f32::to_bits));
        words.push(std::f32::consts::FRAC_1_SQRT_2.to_bits());
        words.extend(turn.map(f32::to_bits));
        words.extend([0, 0]);
        let position = std::array::from_fn(|axis| f64::from(cell[axis]) + f64::from(place[axis]));
        poses.push(Pose::new(position, turn.map(f64::from)));
    }
    (words.into_iter().flat_map(u32::to_le_bytes).collect(), poses)
}

/// A world of 60 instances whose first 48 a shader puts elsewhere, the file and the poses; and the graph's text without the pass.
fn posed(seed: u64) -> (Project, Loaded, Vec<Pose>) {
    let project = project([0; 3], seed, &random_instances([0; 3], seed));
    let (bytes, poses) = wanted(48, seed + 100);
    fs::write(project.path("data/wanted.bin"), bytes).unwrap();
    project.write("graphs/instances.toml", format!("{GRAPH}{POSE_PASS}").replace("\"RAYS\"", &RAYS.to_string()));
    project.write("shaders/pose.comp", POSE_SHADER);
    let loaded = load(&project);
    (project, loaded, poses)
}

#[test]
fn shaders_move_them_two_frames_later_and_exactly() {
    let (project, loaded, poses) = posed(3);
    let home = loaded.instances.frames(|_| None);
    let own: Vec<Option<Pose>> = poses.iter().copied().map(Some).collect();
    let away = loaded.instances.frames_with(&own, |_| None);
    assert!(away[..48].iter().any(|frame| matches!(frame.turn, Rotation::Quarter(_))));
    assert_eq!(away[48..], home[48..]);
    // A turn about Z by a quarter, from a quaternion of `f32`, is one of whole numbers.
    let turned: Vec<_> = poses
        .iter()
        .map(|pose| Some(Pose { rotation: Pose::new([0.0; 3], [0.0, 0.0, 90.0]).rotation, ..*pose }))
        .collect();
    let turned = loaded.instances.frames_with(&turned, |_| None);
    let rays = rays_for(&loaded, &home);
    fs::write(project.path("data/rays.bin"), bytes(&rays)).unwrap();
    let mut session = open(&project);
    let expect = |session: &mut Session, frames: &[Frame], name: &str| {
        let found = hits(session);
        assert!(session.instance_frames() == frames, "{name}");
        judge_some(session, frames, &rays, &found);
    };
    expect(&mut session, &home, "nothing is written");
    for (kind, before, after) in [(1, &home, &away), (3, &away, &turned), (2, &turned, &home), (1, &home, &away)] {
        session.set_param("kind", Value::U32(kind)).unwrap();
        expect(&mut session, before, "written");
        expect(&mut session, before, "on its way");
        expect(&mut session, after, "there");
        expect(&mut session, after, "and there it stays");
        assert_eq!(
            session.frame().unwrap().dispatched,
            0,
            "a pass that has written what it would write again is not run"
        );
    }
    // Another beginning has no past.
    session.reset();
    session.set_param("kind", Value::U32(0)).unwrap();
    for _ in 0..4 {
        expect(&mut session, &home, "from the start");
    }
    assert!(session.take_messages().is_empty());
    assert_silent(&session);
}

#[test]
fn what_is_wrong_with_poses_of_shaders_is_said_once_and_left_out() {
    let (project, loaded, poses) = posed(5);
    let own: Vec<Option<Pose>> = poses.iter().copied().map(Some).collect();
    let away = loaded.instances.frames_with(&own, |_| None);
    let rays = rays_for(&loaded, &away);
    fs::write(project.path("data/rays.bin"), bytes(&rays)).unwrap();
    // Without the memo the pass writes them in every frame.
    let mut session = Project::open_with(Options { memo: false, ..options(&project) });
    session.set_param("kind", Value::U32(1)).unwrap();
    let mut run = |wrong: u32| -> Vec<String> {
        session.set_param("wrong", Value::U32(wrong)).unwrap();
        let mut said = Vec::new();
        for _ in 0..4 {
            let found = hits(&mut session);
            let frames = session.instance_frames();
            judge_some(&session, &frames, &rays, &found);
            said.extend(session.take_messages());
        }
        assert!(session.instance_frames() == away);
        said.iter().map(|message| format!("{}: {}", message.code, message.message)).collect()
    };
    let said = run(1);
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(
        said[0].starts_with("RX0475: passes have written poses that are wrong: the pose of instance 1 has a number"),
        "{said:?}"
    );
    // 48 writers of 401 poses each: all but 16,384 are lost, and the same pose again is no other one.
    let said = run(2);
    assert_eq!(said, ["RX0476: passes have written 2864 more poses than the 16384 that one frame can take"]);
    assert_eq!(run(0), [""; 0]);
    assert_silent(&session);
}
