//! The invocations that write a texel: their lines and values, races, volumes, layers and mips, and what a shader with records computes.

mod project;

use std::time::Duration;

use project::{Project, Sessions, assert_silent};
use raxel_execute::{PassWrites, TracedTexel};
use raxel_graph::checked::Value;
use raxel_runtime::reload::ReloadEvent;
use raxel_runtime::{Observe, Options, Session};

const GRAPH: &str = include_str!("fixtures/writers/writers.toml");

/// Two images go through a function that writes its argument.
const FILL: &str = include_str!("fixtures/writers/fill.comp");

/// One invocation writes the texel of another.
const AGAIN: &str = r"#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f) uniform writeonly image2D color;
layout(push_constant) uniform PC { uint round; } pc;
void main() {
    if (gl_GlobalInvocationID.xy != uvec2(9, 1)) return;
    imageStore(color, ivec2(2, 3), vec4(0.0, 1.0, 2.0, float(pc.round)));
}
";

const LEVEL: &str = include_str!("fixtures/writers/level.comp");

const DEEP: &str = include_str!("fixtures/writers/deep.comp");

const THIRD: &str = r"#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rg16f) uniform writeonly image2D third;
void main() {
    ivec3 at = ivec3(gl_GlobalInvocationID);
    if (at.z == 3) imageStore(third, at.xy, vec4(9.0, 8.0, 7.0, 6.0));
}
";

const RACE: &str = include_str!("fixtures/writers/race.comp");

fn project() -> Project {
    let project = Project::filled();
    project.write("graphs/writers.toml", GRAPH);
    let shaders =
        [("fill", FILL), ("again", AGAIN), ("level", LEVEL), ("deep", DEEP), ("third", THIRD), ("race", RACE)];
    for (name, text) in shaders {
        project.write(&format!("shaders/{name}.comp"), text);
    }
    project
}

fn options(project: &Project) -> Options {
    Options { graph: Some("graphs/writers.toml".into()), observe: Observe::Everything, ..project.options() }
}

fn open(project: &Project) -> Session {
    Project::open_with(Options { record_writes: true, ..options(project) })
}

fn texel(target: &str, at: [u32; 2]) -> TracedTexel {
    TracedTexel { target: target.to_owned(), mip: 0, layer: 0, at }
}

fn frame(session: &mut Session) -> Vec<PassWrites> {
    session.frame().unwrap_or_else(|error| panic!("{error}"));
    session.wait().unwrap();
    assert_silent(session);
    session.writers()
}

/// The writers of a texel as text: pass, line, invocation, workgroup, value.
fn written(session: &mut Session, texel: TracedTexel) -> Vec<String> {
    session.find_writers(Some(texel));
    let passes = frame(session);
    passes.iter().flat_map(|pass| pass.writes.iter().map(|write| shown(&pass.pass, write))).collect()
}

fn shown(pass: &str, write: &raxel_execute::InvocationWrite) -> String {
    let (file, line) = write.place.as_ref().expect("the source is known");
    let value = write.value.texts(4).join(" ");
    format!("{pass} {file}:{line} {:?} of {:?}: {value}", write.invocation, write.workgroup)
}

#[test]
fn a_texel_has_its_pass_line_invocation_and_value() {
    let project = project();
    let mut session = open(&project);
    assert!(session.records_writes());
    assert_eq!(frame(&mut session), [], "nobody has asked");
    session.set_param("n", Value::U32(7)).unwrap();
    let again = |round: u32| format!("again[{round}] shaders/again.comp:7 [9, 1, 0] of [1, 0, 0]: 0 1 2 {round}");
    let mut all = vec!["fill shaders/fill.comp:7 [2, 3, 0] of [0, 0, 0]: 2 3 7 0.5".to_owned()];
    all.extend([0, 1, 2].map(again));
    assert_eq!(written(&mut session, texel("color", [2, 3])), all);
    // A pass that ran and did not write it is told, too.
    let ran: Vec<(String, u32)> = session.writers().into_iter().map(|pass| (pass.pass, pass.count)).collect();
    assert_eq!(ran.len(), 4, "{ran:?}");
    // The argument of two functions.
    assert_eq!(
        written(&mut session, texel("pale", [9, 6])),
        ["fill shaders/fill.comp:7 [9, 6, 0] of [1, 1, 0]: -1 -1 -1 -1"]
    );
}

#[test]
fn mips_layers_and_slices_are_told_apart() {
    let project = project();
    let mut session = open(&project);
    let low = TracedTexel { mip: 1, ..texel("levels", [3, 2]) };
    assert_eq!(written(&mut session, low), ["level shaders/level.comp:8 [3, 2, 0] of [0, 0, 0]: 0.75"]);
    assert_eq!(
        written(&mut session, texel("levels", [3, 2])),
        ["level shaders/level.comp:7 [3, 2, 0] of [0, 0, 0]: 0.25"]
    );
    let slice = TracedTexel { layer: 5, ..texel("volume", [1, 6]) };
    assert_eq!(written(&mut session, slice), ["deep shaders/deep.comp:7 [1, 6, 5] of [0, 1, 2]: -5"]);
    let layer = |layer| TracedTexel { layer, ..texel("layers", [4, 0]) };
    assert_eq!(written(&mut session, layer(1)), ["deep shaders/deep.comp:8 [4, 0, 1] of [1, 0, 0]: 1 1"]);
    // Another binding shows the third layer alone.
    let third = "third shaders/third.comp:6 [4, 0, 3] of [0, 0, 3]: 9 8";
    assert_eq!(written(&mut session, layer(2)), ["deep shaders/deep.comp:8 [4, 0, 2] of [1, 0, 1]: 2 2", third]);
    // There is no such texel.
    for wrong in [
        texel("none", [0, 0]),
        TracedTexel { mip: 1, ..texel("color", [0, 0]) },
        TracedTexel { layer: 8, ..texel("volume", [0, 0]) },
        texel("color", [1 << 20, 0]),
    ] {
        session.find_writers(Some(wrong));
        assert_eq!(frame(&mut session), []);
    }
}

#[test]
fn a_race_is_told_and_atomic_operations_have_their_results() {
    let project = project();
    let mut session = open(&project);
    let of = |session: &mut Session, at: TracedTexel| {
        session.find_writers(Some(at));
        frame(session).into_iter().find(|pass| pass.pass == "race").expect("it ran")
    };
    let race = of(&mut session, texel("spots", [0, 0]));
    let [width, height] = session.size().map(|side| side.div_ceil(8));
    assert_eq!((race.count, race.writes.len(), race.races()), (width * height, (width * height) as usize, true));
    assert!(race.writes.iter().all(|write| {
        let [x, y, _] = write.workgroup;
        write.value.texts(4) == [x.to_string(), y.to_string(), "0".to_owned(), "1".to_owned()]
    }));
    // Each addition is one of an order, and no race.
    let sum = of(&mut session, texel("counts", [1, 2]));
    let threads = 64 * width * height;
    assert_eq!((sum.count, sum.writes.len(), sum.races()), (threads, 256.min(threads as usize), false));
    let mut values: Vec<u32> = sum.writes.iter().map(|write| write.value.words[0]).collect();
    values.sort_unstable();
    values.dedup();
    assert_eq!(values.len(), sum.writes.len(), "no two additions leave the same");
    assert!(values.iter().all(|value| (*value - 5) % 3 == 0 && *value <= 5 + 3 * threads));
    // A comparison that fails writes nothing.
    let max = of(&mut session, texel("counts", [0, 0]));
    let [write] = max.writes.as_slice() else { panic!("{max:?}") };
    assert_eq!((max.count, shown("race", write).as_str()), (1, "race shaders/race.comp:9 [1, 1, 0] of [0, 0, 0]: 7"));
}

/// A paused frame tells of another texel, and computes the same as shaders without records.
#[test]
fn a_frame_that_stands_still_tells_and_nothing_else_changes() {
    let project = project();
    let mut all = Vec::new();
    for record in [false, true] {
        let mut session = Project::open_with(Options { record_writes: record, ..options(&project) });
        session.pause(true);
        session.frame().unwrap();
        // Some passes run in every frame: they change contents that they read.
        let usual = session.frame().unwrap().dispatched;
        for at in [[2, 3], [5, 5], [2, 3]] {
            session.find_writers(Some(texel("color", at)));
            let found = frame(&mut session);
            let names: Vec<&str> = found.iter().map(|pass| pass.pass.as_str()).collect();
            assert_eq!(names, if record { &["fill", "again[0]", "again[1]", "again[2]"][..] } else { &[] });
            assert_eq!(session.frame().unwrap().dispatched, usual, "once");
            session.wait().unwrap();
            assert_eq!(session.writers(), found, "what is known stays");
        }
        let read = |session: &mut Session, name: &str| session.read_target(name).unwrap().bytes;
        // `spots` has a race.
        let names = ["color", "pale", "volume", "layers", "levels", "counts"];
        all.push(names.map(|name| read(&mut session, name)));
        assert_eq!(session.clock().now().map(|now| now.time.seconds()), Some(0.0), "no time went by");
    }
    assert_eq!(all[0], all[1]);
}

const TIMED_GRAPH: &str = r#"
name = "timed"
present = "color"
[clocks.sim]
hz = 4
most = 2
[targets.ticks]
format = "rgba32f"
clock = "sim"
[targets.color]
format = "rgba32f"
[[passes]]
name = "tick"
every = "sim"
shader = "tick.comp"
dispatch = { threads = "ticks" }
bind = { to = "ticks" }
push = { tick = "clock.sim.tick", time = "frame.time", index = "frame.index", phase = "clock.sim.delta" }
[[passes]]
name = "show"
shader = "tick.comp"
dispatch = { threads = "color" }
bind = { to = "color" }
push = { tick = "clock.sim.tick", time = "frame.time", index = "frame.index", phase = "clock.sim.phase" }
"#;

const TICK: &str = "#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f) uniform writeonly image2D to;
layout(push_constant) uniform PC { uint tick; float time; uint index; float phase; } pc;
void main() { imageStore(to, ivec2(gl_GlobalInvocationID.xy), vec4(pc.tick, pc.time, pc.index, pc.phase)); }
";

/// The values of each write of a pass, in order.
fn values(passes: &[PassWrites], pass: &str) -> Vec<[f32; 4]> {
    let writes = passes.iter().filter(|known| known.pass == pass).flat_map(|known| &known.writes);
    writes.map(|write| std::array::from_fn(|axis| f32::from_bits(write.value.words[axis]))).collect()
}

/// Values of time are those that the shader saw in the recorded frame, whatever ran since, and whether the clock was due or stood still.
#[test]
#[allow(
    clippy::cast_possible_truncation,
    clippy::float_cmp,
    reason = "whole numbers, and values that a shader has copied"
)]
fn the_values_of_time_are_those_of_the_recorded_frame() {
    let project = Project::filled();
    project.write("graphs/timed.toml", TIMED_GRAPH);
    project.write("shaders/tick.comp", TICK);
    // Two ticks a frame, one in every second frame, and some that lie between two frames.
    for step in [0.5, 0.125, 0.3] {
        let graph = Some("graphs/timed.toml".into());
        let mut session = Project::open_with(Options {
            graph,
            observe: Observe::Everything,
            record_writes: true,
            step: Some(step),
            ..project.options()
        });
        let mut tick_of_before = None;
        for number in 0..12_u16 {
            // Time stands still in the last frames.
            session.pause(number >= 8);
            // Another texel makes passes run that have nothing to do.
            let at = if number % 3 == 0 { [2, 3] } else { [5, 1] };
            let target = if number % 2 == 0 { "color" } else { "ticks" };
            session.find_writers(Some(texel(target, at)));
            let passes = frame(&mut session);
            let now = session.clock().now().unwrap();
            let texel = session.read_target(target).unwrap().texel(at).unwrap().0;
            let context = format!("step {step}, frame {number}: {passes:?}");
            if target == "color" {
                assert_eq!(values(&passes, "show"), [texel], "{context}");
                assert_eq!(texel[1..3], [now.time.seconds() as f32, now.index as f32], "{context}");
                assert!(passes.iter().all(|pass| pass.frame == now.index), "{context}");
                // What is known stays while other frames run that do not run the pass.
                assert_eq!(session.writers(), passes);
            } else {
                let ticks = values(&passes, "tick");
                let due = tick_of_before.is_none_or(|before| before != texel[0]);
                assert_eq!(ticks.is_empty(), !due, "{context}");
                assert_eq!(ticks.last(), due.then_some(&texel), "{context}");
                assert!(ticks.is_sorted_by(|a, b| a[0] + 1.0 == b[0]), "{context}");
                assert!(ticks.iter().all(|tick| tick[1..3] == texel[1..3]), "of one frame: {context}");
            }
            tick_of_before = Some(session.read_target("ticks").unwrap().texel(at).unwrap().0[0]);
        }
        // The pass of a clock that is not due has the values of its last frame.
        session.pause(false);
        session.find_writers(Some(texel("ticks", [1, 1])));
        let ran = (0..4).map(|_| frame(&mut session)).find(|passes| !values(passes, "tick").is_empty()).unwrap();
        session.pause(true);
        assert_eq!((frame(&mut session), frame(&mut session)), (ran.clone(), ran), "step {step}");
    }
}

/// A session that watches its files makes shaders with records while it runs, and without them again.
#[test]
fn records_are_switched_while_it_runs() {
    let project = project();
    let mut session = Project::open_with(options(&project));
    session.find_writers(Some(texel("color", [5, 5])));
    assert_eq!(frame(&mut session), []);
    for on in [true, false, true] {
        assert!(session.record_writes(on));
        let events = session.wait_reload(Duration::from_secs(60));
        assert!(matches!(events.as_slice(), [ReloadEvent::Reloaded(_)]), "{events:?}");
        assert_eq!(session.records_writes(), on);
        assert_eq!(!frame(&mut session).is_empty(), on);
    }
    // Checks of bounds and records are made side by side.
    assert!(session.check_bounds(true));
    session.wait_reload(Duration::from_secs(60));
    assert_eq!(frame(&mut session)[0].writes.len(), 1);
    session.find_writers(None);
    assert_eq!(frame(&mut session), []);
    assert!(!Project::open_with(Options { watch: false, ..options(&project) }).record_writes(true));
}
