//! Every file that raxel ships runs: each graph over each world, each demo at each of its keys, with the validation layer silent.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use raxel::execute::TracedTexel;
use raxel::{DebugTarget, Observe, Options, Project, Session, Validation};
use raxel_graph::needs;
use raxel_graph::plan::{BindingLimits, DeviceLimits};

/// A small picture that is no multiple of a workgroup.
const SIZE: [u32; 2] = [50, 29];

/// Each pair opens and closes a device of its own, hundreds in all. The validation layer looks devices up in a table that has no lock while another
/// thread's device comes or goes, and has crashed there (KhronosGroup/Vulkan-ValidationLayers, issue 4391), so the tests take turns.
fn turn() -> MutexGuard<'static, ()> {
    static TURN: Mutex<()> = Mutex::new(());
    TURN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The time that a driver may take for a shader with checks of bounds.
const PATIENCE: Duration = Duration::from_secs(120);

fn repository() -> Project {
    Project::at(env!("CARGO_MANIFEST_DIR").as_ref()).unwrap()
}

/// The graphs that are run by name, the examples of the language, and the lighting systems.
fn graphs(project: &Project) -> Vec<String> {
    let examples = project.graphs_in("graphs/examples");
    let light = ["graphs/light", "graphs/light/views"].map(|folder| project.graphs_in(folder)).concat();
    let rivals = ["graphs/rivals", "graphs/rivals/light", "graphs/rivals/light/views"];
    let rivals = rivals.map(|folder| project.graphs_in(folder)).concat();
    assert!(!examples.is_empty() && !light.is_empty() && !rivals.is_empty());
    [project.graphs(), examples, light, rivals].concat()
}

/// A graph that names a model or a material runs over the worlds that have it.
fn has_models(graph: &str, world: &str) -> bool {
    match graph {
        "graphs/examples/model.toml" => world == "worlds/valley.toml",
        "graphs/rivals/light/views/lum_live.toml" => world == "worlds/meadow.toml",
        _ => true,
    }
}

fn options() -> Options {
    let project = Some(env!("CARGO_MANIFEST_DIR").into());
    // As in a window: with memory that is shared, and filled with poison before its use.
    let observe = Observe::Shown;
    Options { project, size: SIZE, validation: Validation::Required, observe, ..Options::default() }
}

fn open(what: &str, options: Options) -> Session {
    let session = Session::open(options).unwrap_or_else(|error| panic!("{what}: {error}"));
    // Most graphs show no instances, and warn over a world that has some.
    let warnings = session.warnings().iter().filter(|warning| warning.code.as_str() != "RX0449");
    let warnings: Vec<_> = warnings.map(|warning| warning.message.clone()).collect();
    assert!(warnings.is_empty(), "{what} has warnings: {warnings:?}");
    session
}

/// The picture of the second of the next two frames, which is drawn with the history of the first. The left button is held at the centre,
/// and the right trigger of a gamepad: canvases stay empty without them.
fn run(what: &str, session: &mut Session) -> Vec<u8> {
    let inputs = session.inputs();
    inputs.cursor = Some(SIZE.map(|size| size.cast_signed() / 2));
    inputs.button(1, true);
    inputs.set_gamepad_triggers([0.0, 1.0]);
    for _ in 0..2 {
        session.frame().unwrap_or_else(|error| panic!("{what}: {error}"));
    }
    let picture = session.read_presented().unwrap_or_else(|error| panic!("{what}: {error}"));
    assert_eq!([picture.width, picture.height], SIZE);
    let messages = session.device().log().take();
    assert!(messages.is_empty(), "{what}: {messages:#?}");
    picture.rgba
}

fn differs(rgba: &[u8]) -> bool {
    rgba.chunks_exact(4).any(|pixel| pixel != &rgba[..4])
}

/// The limits for a pass of raxel's own graphs: those of a small device with a driver of its own, for example a Raspberry Pi 5.
const SMALL: DeviceLimits = DeviceLimits {
    workgroup_invocations: 256,
    shared_memory: 16384,
    push_constants: 128,
    bindings: BindingLimits { storage_buffers: 8, storage_images: 4, ..DeviceLimits::PORTABLE.bindings },
    ..DeviceLimits::PORTABLE
};

/// Stops the test if a pass needs more than a small device has. Graphs that raxel is compared with may.
fn is_within(graph: &str, what: &str, session: &Session) {
    if graph.starts_with("graphs/rivals/") {
        return;
    }
    for need in needs(session.plan().expect("a frame was made"), &SMALL) {
        assert!(need.is_met(), "{what}: {} {} in pass `{}`, not {}", need.needs, need.what, need.pass, need.has);
    }
}

/// Runs each graph over those of the worlds that are wanted of it, by the numbers of both.
fn graphs_run_over(wanted: impl Fn(&str, usize, usize) -> bool) {
    let _turn = turn();
    let project = repository();
    let (graphs, mut worlds) = (graphs(&project), project.worlds());
    // Made to be measured: too large for some layouts on a software device, and for a test of every pair.
    worlds.retain(|world| world != "worlds/terrain.toml");
    // Streamed: tests/streaming.
    worlds.retain(|world| world != "worlds/frontier.toml");
    assert!(graphs.len() >= 3 && worlds.len() >= 3);
    for (number, graph) in graphs.iter().enumerate() {
        let worlds = worlds.iter().enumerate().filter(|(_, world)| has_models(graph, world));
        let worlds = worlds.filter(|(world, _)| wanted(graph, number, *world)).map(|(_, world)| world);
        for world in worlds {
            let what = format!("{graph} over {world}");
            let files = (Some(graph.into()), Some(world.into()));
            let mut session = open(&what, Options { graph: files.0, world: files.1, ..options() });
            let picture = run(&what, &mut session);
            // A crypt whose only light is an instance is black without instances.
            assert!(world == "worlds/lantern.toml" || differs(&picture), "{what} is of one colour");
            is_within(graph, &what, &session);
        }
    }
}

/// The graphs that are used most run over every world; each other graph over a quarter of them, a different one than the graph before it.
#[test]
fn every_graph_runs_over_some_worlds_and_the_first_ones_over_all() {
    graphs_run_over(|graph, number, world| graph.matches('/').count() == 1 || (number + world) % 4 == 0);
}

#[test]
#[ignore = "takes minutes"]
fn every_graph_runs_over_every_world() {
    graphs_run_over(|_, _, _| true);
}

/// No shader of an example goes beyond an array or an image. Larger ones take a software driver minutes with their checks.
#[test]
fn no_access_of_a_graph_is_out_of_bounds() {
    let _turn = turn();
    let project = repository();
    let mut graphs = [vec!["graphs/primary.toml".to_owned()], project.graphs_in("graphs/examples")].concat();
    // It extends `beauty`, whose tracers are too large.
    graphs.retain(|graph| graph != "graphs/examples/fair.toml");
    for graph in &graphs {
        let world = if has_models(graph, "worlds/menger.toml") { "worlds/menger.toml" } else { "worlds/valley.toml" };
        let files = (Some(graph.into()), Some(world.into()));
        let mut session = open(
            graph,
            Options { graph: files.0, world: files.1, check_bounds: true, watchdog: PATIENCE, ..options() },
        );
        run(graph, &mut session);
        session.wait().unwrap();
        let found = session.take_messages();
        let said: Vec<String> = (found.iter())
            .map(|found| {
                format!("{} {:?}", found.message, found.labels.first().map(|label| (&label.span.file, &label.text)))
            })
            .collect();
        assert!(said.is_empty(), "{graph}: {said:#?}");
    }
}

/// Shaders that record their writes draw the same pictures, and tell who wrote the texel in the middle.
#[test]
fn every_example_tells_who_wrote_a_texel() {
    let _turn = turn();
    let project = repository();
    let mut silent = Vec::new();
    for graph in [vec!["graphs/primary.toml".to_owned()], project.graphs_in("graphs/examples")].concat() {
        let world = if has_models(&graph, "worlds/menger.toml") { "worlds/menger.toml" } else { "worlds/valley.toml" };
        let pictures = [false, true].map(|record_writes| {
            let (graph_file, world) = (Some((&graph).into()), Some(world.into()));
            let mut session = open(&graph, Options { graph: graph_file, world, record_writes, ..options() });
            let present = session.graph().present;
            let target = session.graph().resource(present).name.clone();
            let size = session.plan().expect("it runs").sizes[present.0 as usize].texels(0);
            let [width, height, _] = size?;
            session.find_writers(Some(TracedTexel { target, mip: 0, layer: 0, at: [width / 2, height / 2] }));
            run(&graph, &mut session);
            session.wait().unwrap();
            let writers = session.writers();
            assert_eq!(!writers.is_empty(), record_writes, "{graph}");
            if record_writes && writers.iter().all(|pass| pass.count == 0) {
                silent.push(graph.clone());
            }
            Some(session.read_presented().unwrap().rgba)
        });
        assert!(pictures[0] == pictures[1], "{graph} draws another picture");
    }
    assert_eq!(
        silent,
        ["changed", "keep"].map(|name| format!("graphs/examples/{name}.toml")),
        "they leave texels as they are"
    );
}

#[test]
fn every_target_of_every_graph_can_be_shown() {
    let _turn = turn();
    let project = repository();
    for graph in graphs(&project) {
        let worlds = ["worlds/menger.toml", "worlds/valley.toml", "worlds/meadow.toml"];
        let world = worlds.into_iter().find(|world| has_models(&graph, world)).map(Into::into);
        let mut session = open(&graph, Options { graph: Some((&graph).into()), world, ..options() });
        let names: Vec<String> = session.graph().resources.iter().map(|resource| resource.name.clone()).collect();
        for name in names {
            let what = format!("{name} of {graph}");
            session.set_debug_target(DebugTarget::resource(name)).unwrap();
            run(&what, &mut session);
        }
    }
}

#[test]
fn every_demo_runs_at_each_of_its_keys() {
    let _turn = turn();
    let project = repository();
    assert!(!project.demos().is_empty());
    for path in project.demos() {
        let mut session = open(&path, Options { demo: Some((&path).into()), ..options() });
        let demo = session.demo().unwrap().clone();
        let mut times: Vec<f64> = demo.camera.iter().map(|key| key.time.value).collect();
        times.extend(demo.shows.iter().map(|key| key.time.value));
        for time in times {
            session.seek(time);
            let what = format!("{path} at {time} s");
            assert!(differs(&run(&what, &mut session)), "{what} is of one colour");
        }
    }
}
