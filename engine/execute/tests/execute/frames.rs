//! Frames: dispatch, history, clears, aliasing, swaps, the memo, timings, errors.

use std::sync::Arc;

use raxel_execute::moment::{Fraction, Moment};
use raxel_execute::{Builtins, ExecuteError, FrameInputs, Override};
use raxel_graph::checked::{PassId, Value};
use raxel_graph::plan::{Lifetime, Plan, Step};

use crate::lab::{Lab, Planned, at, graph};

const FILL: (&str, &str) = (
    "shaders/fill.comp",
    r"#version 460
layout(local_size_x = 4, local_size_y = 4) in;
layout(rgba32f) writeonly uniform image2D outColor;
layout(push_constant) uniform Push { vec4 color; } push;
void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (all(lessThan(p, imageSize(outColor)))) imageStore(outColor, p, push.color + vec4(p, 0.0, 0.0));
}",
);

#[test]
fn one_pass_reaches_the_host() {
    let mut lab = Lab::new();
    let toml = include_str!("../fixtures/frames/one.toml");
    lab.load(&[("graphs/test.toml", toml), FILL], &Planned::default());
    let report = lab.frame();
    assert_eq!((report.dispatched, report.displayed), (1, true));
    let texels = lab.floats("color", 0, 0, 0);
    assert_eq!(texels.len(), 32);
    assert_eq!(texels[0], [0.5, 0.25, 0.0, 1.0]);
    assert_eq!(texels[8 + 3], [3.5, 1.25, 0.0, 1.0]);
    let picture = lab.executor.read_presented().expect("a frame ran");
    assert_eq!((picture.width, picture.height), (8, 4));
    // 0.5 and 0.25 in sRGB.
    assert_eq!(picture.rgba[..4], [188, 137, 0, 255]);
    assert_eq!(lab.executor.timings().len(), 1);
    let time = lab.executor.timings()[0].nanoseconds.expect("the device has timestamps and the frame is finished");
    assert!(time >= 0.0);
}

const ACCUMULATE: &str = include_str!("../fixtures/frames/accumulate.toml");

const ADD: (&str, &str) = ("shaders/add.comp", include_str!("../fixtures/frames/add.comp"));

#[test]
fn history_rotates_and_clears_and_inits_hold() {
    let mut lab = Lab::new();
    lab.load(&[("graphs/test.toml", ACCUMULATE), ADD], &Planned::default());
    for frame in 1..=5u8 {
        let report = lab.frame();
        assert_eq!((report.dispatched, report.skipped), (1, 0), "accumulation always runs");
        let expected = [10.0 + f32::from(frame), 0.25 * f32::from(frame), 0.0, 1.0];
        assert_eq!(lab.floats("color", 0, 0, 0)[31], expected);
        let before = [9.0 + f32::from(frame), 0.25 * f32::from(frame - 1), 0.0, 1.0];
        assert_eq!(lab.floats("color", 1, 0, 0)[0], before);
    }
    lab.executor.reset_history();
    lab.frame();
    assert_eq!(lab.floats("color", 0, 0, 0)[0], [11.0, 0.25, 0.0, 1.0]);
}

#[test]
fn a_swap_keeps_what_is_described_alike() {
    let mut lab = Lab::new();
    let first = lab.plan(&graph(&[("graphs/test.toml", ACCUMULATE), ADD]), &Planned::default());
    let prepared = lab.prepare(&first).expect("it suits the device");
    let report = lab.executor.swap(prepared);
    assert_eq!(report.created, ["color", "scratch"]);
    for _ in 0..3 {
        lab.frame();
    }
    // An edited shader and a scratch target of another size: the history survives.
    let toml = ACCUMULATE.replace("[4, 4]", "[2, 2]");
    let add = ADD.1.replace("p % 4", "p % 2").replace("1.0, add", "100.0, add");
    let second = lab.plan(&graph(&[("graphs/test.toml", &toml), (ADD.0, &add)]), &Planned::default());
    let prepared = lab.prepare(&second).expect("it suits the device");
    lab.frame();
    let report = lab.executor.swap(prepared);
    assert_eq!((report.kept, report.created), (vec!["color".to_owned()], vec!["scratch".to_owned()]));
    lab.frame();
    assert_eq!(lab.floats("color", 0, 0, 0)[5], [114.0, 1.25, 0.0, 1.0]);
    // Another init is another description.
    let toml = toml.replace("10.0", "20.0");
    let third = lab.plan(&graph(&[("graphs/test.toml", &toml), (ADD.0, &add)]), &Planned::default());
    let prepared = lab.prepare(&third).expect("it suits the device");
    assert_eq!(lab.executor.swap(prepared).created, ["color"]);
    lab.frame();
    assert_eq!(lab.floats("color", 0, 0, 0)[5], [120.0, 0.25, 0.0, 1.0]);
}

/// A chain of `length` passes. Each scales the output of the one before it and adds `frame.index` where `moving`.
pub(crate) fn chain(length: usize, moving: &[usize]) -> Vec<(String, String)> {
    let mut toml = r#"name = "chain"
present = "color"
[params.gain]
type = "f32"
default = 1.0
"#
    .to_owned();
    for i in 0..length - 1 {
        toml += &format!("[targets.t{i}]\nformat = \"rgba32f\"\n");
    }
    toml += "[targets.color]\nformat = \"rgba32f\"\n";
    for i in 0..length {
        let out = if i == length - 1 { "color".to_owned() } else { format!("t{i}") };
        let from = if moving.contains(&i) { "frame.time" } else { "param.gain" };
        let (shader, input) =
            if i == 0 { ("start.comp", String::new()) } else { ("link.comp", format!("before = \"t{}\", ", i - 1)) };
        toml += &format!(
            r#"[[passes]]
name = "p{i}"
shader = "{shader}"
dispatch = {{ threads = "{out}" }}
bind = {{ {input}outColor = "{out}" }}
push.add = {{ type = "f32", from = "{from}" }}
"#
        );
    }
    let shader = |read: &str, input: &str| {
        format!(
            r"#version 460
layout(local_size_x = 8, local_size_y = 8) in;
{input}layout(rgba32f) writeonly uniform image2D outColor;
layout(push_constant) uniform Push {{ float add; }} push;
void main() {{
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(outColor)))) return;
    imageStore(outColor, p, {read} + vec4(push.add, p, 1.0));
}}"
        )
    };
    vec![
        ("graphs/test.toml".to_owned(), toml),
        ("shaders/start.comp".to_owned(), shader("vec4(0.0)", "")),
        (
            "shaders/link.comp".to_owned(),
            shader("0.5 * imageLoad(before, p)", "layout(rgba32f) readonly uniform image2D before;\n"),
        ),
    ]
}

fn load(lab: &mut Lab, files: &[(String, String)], how: &Planned<'_>) -> Arc<Plan> {
    let files: Vec<_> = files.iter().map(|(path, text)| (path.as_str(), text.as_str())).collect();
    lab.load(&files, how)
}

#[test]
fn aliased_memory_gives_the_same_picture() {
    // A resource that is the same in every frame shares no memory.
    let files = chain(6, &[0]);
    let mut pictures = Vec::new();
    for alias in [false, true] {
        let mut lab = Lab::new();
        let plan = load(&mut lab, &files, &Planned { alias, ..Planned::default() });
        let shared =
            plan.resources.iter().filter(|r| matches!(r.lifetime, Lifetime::Transient { place: Some(_), .. })).count();
        assert_eq!(shared > 1, alias, "{:?}", plan.blocks);
        for frame in 0..3 {
            lab.frame_with(&at(frame), &[Value::F32(frame as f32)]);
        }
        pictures.push(lab.floats("color", 0, 0, 0));
        if alias {
            let error = lab.executor.read_target(lab.find("t1"), 0, 0, 0).expect_err("its memory is another's now");
            assert!(matches!(error, ExecuteError::NotKept { .. }), "{error}");
        }
    }
    assert_eq!(pictures[0], pictures[1]);
    assert!(pictures[0].iter().any(|texel| texel[0] > 2.0));
}

#[test]
fn a_still_frame_dispatches_nothing_and_a_change_reruns_what_depends_on_it() {
    let mut lab = Lab::new();
    load(&mut lab, &chain(5, &[3]), &Planned { alias: false, ..Planned::default() });
    assert_eq!(lab.frame_with(&at(7), &[]).dispatched, 5);
    let still = lab.frame_with(&at(7), &[]);
    assert_eq!((still.dispatched, still.skipped, still.barriers, still.displayed), (0, 5, 0, false));
    let moved = lab.frame_with(&at(8), &[]);
    assert_eq!((moved.dispatched, moved.skipped, moved.displayed), (2, 3, true));
    lab.executor.set_memo(false);
    assert_eq!(lab.frame_with(&at(8), &[]).dispatched, 5);
    lab.executor.set_memo(true);
    assert_eq!(lab.frame_with(&at(8), &[]).dispatched, 5, "nobody knows what happened meanwhile");
    assert_eq!(lab.frame_with(&at(8), &[]).dispatched, 0);
}

#[test]
fn disabled_passes_and_overrides() {
    let mut lab = Lab::new();
    let plan = load(&mut lab, &chain(3, &[]), &Planned { alias: false, pinned: &["t1"], ..Planned::default() });
    let last = plan.graph.find_pass("p2").expect("it is there");
    let builtins = Builtins::default();
    let over = [Override { pass: PassId(0), uniform: None, fill: 0, value: Value::F32(64.0) }];
    let inputs =
        FrameInputs { builtins: &builtins, params: &[], overrides: &over, clock: Moment::START, disabled: &[last] };
    let report = lab.executor.frame(&inputs).expect("it runs");
    assert_eq!((report.dispatched, report.idle), (2, 1));
    // t0 = 64, t1 = 32 + 1, color stays at init.
    assert_eq!(lab.floats("t1", 0, 0, 0)[0][0], 33.0);
    assert_eq!(lab.floats("color", 0, 0, 0)[0], [0.0; 4]);
}

#[test]
fn every_runs_on_its_own_clock() {
    let mut lab = Lab::new();
    let toml = include_str!("../fixtures/frames/every.toml");
    lab.load(&[("graphs/test.toml", toml), FILL], &Planned::default());
    lab.executor.set_memo(false);
    let builtins = Builtins::default();
    let ran: Vec<u32> = [0.0, 0.05, 0.1, 0.15, 0.19, 0.31, 0.32]
        .into_iter()
        .map(|clock| {
            let inputs =
                FrameInputs { builtins: &builtins, params: &[], overrides: &[], clock: clock.into(), disabled: &[] };
            lab.executor.frame(&inputs).expect("it runs").dispatched
        })
        .collect();
    assert_eq!(ran, [1, 0, 1, 0, 0, 1, 0]);
    // At 60 frames a second every second one, with none late: in floats, 62 × (1 / 60) × 30 is below 31.
    lab.load(&[("graphs/test.toml", &toml.replace("hz = 10", "hz = 30")), FILL], &Planned::default());
    lab.executor.reset_history();
    let step = Fraction::of(1.0 / 60.0);
    for frame in 0..260 {
        let clock = Moment::of_frame(frame, step);
        let inputs = FrameInputs { builtins: &builtins, params: &[], overrides: &[], clock, disabled: &[] };
        let ran = lab.executor.frame(&inputs).expect("it runs").dispatched;
        assert_eq!(ran, u32::from(frame.is_multiple_of(2)), "frame {frame}");
    }
}

#[test]
fn a_missing_barrier_is_reported() {
    let mut lab = Lab::new();
    lab.expect_messages = true;
    let files = chain(3, &[]);
    let files: Vec<_> = files.iter().map(|(path, text)| (path.as_str(), text.as_str())).collect();
    let plan = lab.plan(&graph(&files), &Planned { alias: false, ..Planned::default() });
    let mut broken = (*plan).clone();
    for step in &mut broken.steps {
        if let Step::Barrier(barrier) = step {
            barrier.memory = None;
        }
    }
    let prepared = lab.prepare(&Arc::new(broken)).expect("it suits the device");
    lab.executor.swap(prepared);
    lab.frame();
    lab.executor.wait().expect("software does not mind");
    let messages = lab.device.log().take();
    let hazard = |id: &str| messages.iter().any(|message| message.id.contains(id));
    assert!(hazard("SYNC-HAZARD-READ-AFTER-WRITE") || hazard("SYNC-HAZARD-READ_AFTER_WRITE"), "{messages:#?}");
}

#[test]
fn what_cannot_be_had_is_an_error() {
    let mut lab = Lab::new();
    assert!(matches!(lab.executor.read_presented(), Err(ExecuteError::NoPlan)));
    let builtins = Builtins::default();
    let inputs = FrameInputs { builtins: &builtins, params: &[], overrides: &[], clock: Moment::START, disabled: &[] };
    assert!(matches!(lab.executor.frame(&inputs), Err(ExecuteError::NoPlan)));
    lab.load(&[("graphs/test.toml", ACCUMULATE), ADD], &Planned::default());
    lab.frame();
    let color = lab.find("color");
    for (age, mip, layer, part) in [(2, 0, 0, "`@2`"), (0, 1, 0, "mip 1"), (0, 0, 1, "layer 1")] {
        let error = lab.executor.read_target(color, age, mip, layer).expect_err("there is none").to_string();
        assert!(error.contains(part), "{error}");
    }
    let error = lab.executor.read_buffer(color, 0, 0..4).expect_err("it is a target");
    assert!(matches!(error, ExecuteError::OutOfRange { .. }));
}

/// A graph with many features: history, mips, a clear, an atomic counter, in-place work, aliased scratch, a pass with `every`.
fn busy() -> Vec<(&'static str, String)> {
    let toml = include_str!("../fixtures/frames/busy.toml");
    let head = "#version 460\nlayout(local_size_x = 4, local_size_y = 4) in;\n";
    let push = "layout(push_constant) uniform Push { int add; } push;\n";
    let image = |access: &str, name: &str| format!("layout(r32ui) {access} uniform uimage2D {name};\n");
    let guard = "void main() {\n    ivec2 p = ivec2(gl_GlobalInvocationID.xy);\n    if (any(greaterThanEqual(p, imageSize(dst)))) return;\n";
    let make = format!(
        "{head}{}{push}{guard}    imageStore(dst, p, uvec4(p.x * 7 + p.y * 31 + push.add));\n}}",
        image("writeonly", "dst")
    );
    let copy = format!(
        "{head}{}{}{push}{guard}    uint v = imageLoad(src, p).r;\n    imageStore(dst, p, uvec4(v * 3u + uint(push.add)));\n}}",
        image("readonly", "src"),
        image("writeonly", "dst")
    );
    let mark = format!(
        "{head}{}{}{push}buffer Count {{ uint count; }} count;\n{guard}    \
         if (((p.x + push.add) & 1) == 0) imageStore(dst, p, imageLoad(dst, p) * 5u + imageLoad(src, p));\n    \
         atomicAdd(count.count, uint(push.add));\n}}",
        image("readonly", "src"),
        image("", "dst")
    );
    let mixed = format!(
        "{head}{}{}{}readonly buffer Count {{ uint count; }} count;\n{guard}    \
         imageStore(dst, p, imageLoad(a, p) * 7u + imageLoad(b, p) * 13u + count.count);\n}}",
        image("readonly", "a"),
        image("readonly", "b"),
        image("writeonly", "dst")
    );
    vec![
        ("graphs/test.toml", toml.to_owned()),
        ("shaders/make.comp", make),
        ("shaders/copy.comp", copy),
        ("shaders/mark.comp", mark),
        ("shaders/mix.comp", mixed),
    ]
}

#[test]
fn leaving_passes_out_never_changes_a_picture() {
    let files = busy();
    let files: Vec<_> = files.iter().map(|(path, text)| (*path, text.as_str())).collect();
    let (mut full, mut lean) = (Lab::new(), Lab::new());
    full.executor.set_memo(false);
    let graph = graph(&files);
    let mut presents = ["color", "marks", "seen@1", "slow"].into_iter().cycle();
    let mut random = 1u32;
    let mut below = |n: u32| {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (random >> 16) % n
    };
    let mut params = [1, 1, 1];
    let mut skipped = 0;
    for frame in 0..120 {
        if frame % 30 == 0 {
            // Another debug target: a new plan that keeps what it can.
            let present = presents.next().expect("it cycles");
            for lab in [&mut full, &mut lean] {
                let plan = lab.plan(&graph, &Planned { present, pinned: &["color"], ..Planned::default() });
                let prepared = lab.prepare(&plan).expect("it suits the device");
                lab.executor.swap(prepared);
            }
        }
        if below(3) == 0 {
            params[below(3) as usize] = 1 + below(3) as i32;
        }
        if below(25) == 0 {
            full.executor.reset_history();
            lean.executor.reset_history();
        }
        let values = params.map(Value::I32);
        let reports = [&mut full, &mut lean].map(|lab| lab.frame_with(&at(frame), &values));
        skipped += reports[1].skipped;
        assert_eq!(reports[0].skipped, 0);
        let pictures = [&mut full, &mut lean].map(|lab| lab.executor.read_presented().expect("a frame ran"));
        assert_eq!(pictures[0], pictures[1], "frame {frame}");
        if frame % 7 == 0 {
            assert_eq!(full.integers("color", 0, 0), lean.integers("color", 0, 0), "frame {frame}");
        }
    }
    assert!(skipped > 300, "only {skipped} passes were left out");
}
