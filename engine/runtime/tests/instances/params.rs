//! Params move instances.

use std::fs;
use std::path::PathBuf;

use raxel_graph::checked::Value;
use raxel_layouts::instances::Rotation;
use raxel_runtime::session::Validation;
use raxel_runtime::{OpenError, Options, Session};

use crate::project::{Project, Sessions, assert_silent};
use crate::{bytes, hits, judge, load, open, options, project, rays_for};

#[test]
fn params_move_them_and_nothing_runs_while_they_stand() {
    let instances = r#"[[instances]]
model = "crate"
position = [-20, 3, 4]
slide = { param = "tide", along = [0.0, 0.5, 0.0] }
[[instances]]
model = "crate"
position = [30, 3, 4]
turn = { param = "spin", about = [0.5, 0.0, 0.5] }
[[instances]]
model = "mast"
position = [1, 20, 4]
turn = { param = "wind", axis = "z", default = 10 }
"#;
    let project = project([0; 3], 9, instances);
    let loaded = load(&project);
    let of = |tide: f64, spin: f64| {
        let value = move |param: &str| match param {
            "tide" => Some(tide),
            "spin" => Some(spin),
            _ => None,
        };
        loaded.instances.frames(value)
    };
    let places = [(0.0, 0), (7.0, 0), (8.0, 90), (8.0, 33), (0.0, 0)];
    let frames: Vec<_> = places.iter().map(|&(tide, spin)| of(tide, f64::from(spin))).collect();
    assert!(frames[2][..2].iter().all(|frame| matches!(frame.turn, Rotation::Quarter(_))));
    assert!(matches!(frames[1][0].turn, Rotation::Free(_)));
    let rays = rays_for(&loaded, &frames[0]);
    fs::write(project.path("data/rays.bin"), bytes(&rays)).unwrap();
    let mut session = open(&project);
    for ((tide, spin), frames) in places.into_iter().zip(&frames) {
        session.set_param("tide", Value::F32(tide as f32)).unwrap();
        session.set_param("spin", Value::I32(spin)).unwrap();
        let found = hits(&mut session);
        judge(&session, frames, &rays, &found);
        assert_eq!(session.frame().unwrap().dispatched, 0);
    }
    assert_silent(&session);
}

#[test]
fn a_param_that_the_graph_lacks_is_named() {
    let instances =
        "[[instances]]\nmodel = \"dot\"\nposition = [0, 0, 0]\nslide = { param = \"tides\", along = [0, 1, 0] }\n";
    let project = project([0; 3], 9, instances);
    let Err(OpenError::Project { diagnostics, .. }) = Session::open(options(&project)) else { panic!("it opens") };
    let found =
        diagnostics.iter().find(|found| found.code.as_str() == "RX0447").unwrap_or_else(|| panic!("{diagnostics:#?}"));
    assert_eq!(
        found.message,
        "instances of `worlds/test.toml` are moved by `tides`, which is not a param of the graph"
    );
    assert_eq!(found.help, ["did you mean `tide`?"]);
}

#[test]
fn the_flock_flies() {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap();
    let mut session = Project::open_with(Options {
        project: Some(root.clone()),
        graph: Some(root.join("graphs/examples/flock.toml")),
        world: Some(root.join("worlds/flock.toml")),
        size: [96, 54],
        validation: Validation::Required,
        ..Options::default()
    });
    let home = session.instance_frames();
    assert_eq!(home.len(), 512);
    let mut places = Vec::new();
    for _ in 0..8 {
        session.frame().unwrap();
        places.push(session.instance_frames());
    }
    assert!(places[1] == home, "not before the third frame");
    let [before, after] = [&places[5], &places[7]];
    for ((frame, before), home) in after.iter().zip(before).zip(&home) {
        assert!(frame != before && frame != home, "every bird flies on");
        // About a voxel in a thirtieth of a second.
        assert!((0..3).all(|axis| (frame.cell[axis] - before.cell[axis]).abs() <= 3), "{frame:?} {before:?}");
    }
    assert!(session.take_messages().is_empty());
    assert_silent(&session);
}
