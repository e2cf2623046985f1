//! Small worlds, and sessions that show the light in them.

#![allow(dead_code, reason = "each test file uses a part of this")]

use raxel::{DebugTarget, Options, Session, Validation, Value};
use raxel_measure::light::{Effort, Epsilon, Scene};

use crate::common::{self, Project};

/// Materials and operations of a world, and where its camera stands and looks.
pub(crate) fn world(
    project: &Project,
    materials: &str,
    build: &[String],
    position: [f64; 3],
    look_at: [f64; 3],
    fov: f64,
) {
    let text = format!(
        r#"name = "test"
[camera]
position = {position:?}
look_at = {look_at:?}
fov = {fov:?}
[materials]
{materials}
{}"#,
        build.concat()
    );
    project.write("worlds/test.toml", text);
}

pub(crate) fn cuboid(material: &str, min: [i32; 3], max: [i32; 3], more: &str) -> String {
    format!("[[build]]\nop = \"box\"\nmin = {min:?}\nmax = {max:?}\nmaterial = \"{material}\"\n{more}\n")
}

pub(crate) fn open(project: &Project, graph: &str, size: [u32; 2], params: &[(&str, f32)]) -> Session {
    open_at(project, graph, size, params, 60.0)
}

/// The same, with this number of frames a second.
pub(crate) fn open_at(project: &Project, graph: &str, size: [u32; 2], params: &[(&str, f32)], rate: f64) -> Session {
    let mut session = Session::open(Options {
        project: Some(project.root().into()),
        graph: Some(project.path(graph)),
        world: Some(project.path("worlds/test.toml")),
        size,
        validation: Validation::Required,
        step: Some(1.0 / rate),
        ..Options::default()
    })
    .unwrap_or_else(|error| panic!("{graph}: {error}"));
    session.pin("radiance").unwrap();
    session.set_debug_target(DebugTarget::resource("radiance")).unwrap();
    for (name, value) in params {
        session.set_param(name, Value::F32(*value)).unwrap();
    }
    session
}

pub(crate) fn frames(session: &mut Session, count: u32) -> Vec<[f32; 4]> {
    for _ in 0..count {
        session.frame().unwrap();
    }
    let messages = session.device().log().take();
    assert!(messages.is_empty(), "{messages:#?}");
    session.read_target("radiance").unwrap().floats()
}

/// `worlds/test.toml` from its own camera, as the judge takes it.
pub(crate) fn scene() -> Scene {
    let (name, world) = ("test".to_owned(), "worlds/test.toml".to_owned());
    Scene { name, world, epsilon: Epsilon::NAMED, ..Scene::default() }
}

/// The settings of the judge for small still pictures: `frames` of each system, against at most `paths` paths a pixel.
pub(crate) fn effort(project: &Project, size: [u32; 2], frames: u32, paths: u32) -> Effort {
    Effort {
        project: project.root().to_owned(),
        device: None,
        validation: Validation::Required,
        size,
        frames,
        pan: 0,
        lag: 0,
        most_paths: paths,
        goal: 1e-9,
        keep: false,
    }
}

/// Neither sun nor sky.
pub(crate) const DARK: [(&str, f32); 2] = [("sun_strength", 0.0), ("sky_strength", 0.0)];

/// Project paths of the graphs that are judged.
pub(crate) fn systems(project: &Project) -> Vec<String> {
    let all = common::LIGHT.map(|folder| raxel::Project::at(project.root()).unwrap().graphs_in(folder)).concat();
    assert!(all.len() >= 2, "{all:?}");
    all
}
