//! Contents that stay from frame to frame: kept resources, tables made of constant inputs, partial stores.

use raxel_execute::moment::Moment;
use raxel_execute::{Builtins, FrameInputs, FrameReport};

use crate::lab::{Lab, Planned};

const HALF: (&str, &str) = ("shaders/half.comp", include_str!("../fixtures/kept/half.comp"));

const FULL: (&str, &str) = (
    "shaders/full.comp",
    r"#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f) writeonly uniform image2D outColor;
layout(push_constant) uniform Push { float value; };
void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (all(lessThan(p, imageSize(outColor)))) imageStore(outColor, p, vec4(value));
}",
);

const COPY: (&str, &str) = ("shaders/copy.comp", include_str!("../fixtures/kept/copy.comp"));

fn pass(name: &str, shader: &str, bind: &str, value: &str) -> String {
    format!(
        r#"[[passes]]
name = "{name}"
shader = "{shader}.comp"
dispatch = {{ threads = "color" }}
bind = {{ {bind} }}
push = {{ value = {value} }}
"#
    )
}

/// Half of `half` is stored, and all of it is copied to the picture.
fn half(partial: &str) -> String {
    let mut toml = "name = \"half\"\npresent = \"color\"\n".to_owned();
    for target in ["half", "color"] {
        toml += &format!("[targets.{target}]\nformat = \"rgba32f\"\n");
    }
    toml += &pass("half", "half", &format!("outColor = {{ target = \"half\"{partial} }}"), "\"frame.time\"");
    toml + &pass("copy", "copy", "image = \"half\", outColor = \"color\"", "0.0")
}

#[test]
fn a_store_that_leaves_texels_out_shows_when_memory_is_poisoned() {
    let mut lab = Lab::new();
    let load = |lab: &mut Lab, partial: &str, poison: bool| {
        let files = [("graphs/test.toml", &*half(partial)), HALF, COPY];
        lab.load(&files, &Planned { poison, ..Planned::default() });
        for time in [1.0, 2.0] {
            lab.frame_with(&Builtins { frame_time: time, ..Builtins::default() }, &[]);
        }
        lab.floats("color", 0, 0, 0)
    };
    let forgotten = load(&mut lab, "", true);
    assert!(forgotten[0][0].is_nan() && forgotten[3][0].is_nan(), "{:?}", &forgotten[..8]);
    assert_eq!(forgotten[4], [2.0; 4]);
    // Said, the target is kept, from `init` on.
    for poison in [true, false] {
        let said = load(&mut lab, ", partial = true", poison);
        assert_eq!((said[0], said[4]), ([0.0; 4], [2.0; 4]));
    }
}

#[test]
fn a_partial_store_lies_over_what_an_earlier_pass_stored() {
    let mut lab = Lab::new();
    let mut toml = "name = \"over\"\npresent = \"color\"\n[targets.color]\nformat = \"rgba32f\"\n".to_owned();
    toml += &pass("full", "full", "outColor = \"color\"", "\"frame.time\"");
    toml += &pass("half", "half", "outColor = { target = \"color\", partial = true }", "\"frame.delta\"");
    lab.load(&[("graphs/test.toml", &toml), HALF, FULL], &Planned { poison: true, ..Planned::default() });
    let mut frame = |time: f32, delta: f32| {
        let report = lab.frame_with(&Builtins { frame_time: time, frame_delta: delta, ..Builtins::default() }, &[]);
        let texels = lab.floats("color", 0, 0, 0);
        (report.dispatched, texels[0][0], texels[4][0])
    };
    assert_eq!(frame(1.0, 7.0), (2, 1.0, 7.0));
    assert_eq!(frame(1.0, 7.0).0, 0);
    // Either of them alone runs both: the memo does not take the half for the whole.
    assert_eq!(frame(2.0, 7.0), (2, 2.0, 7.0));
    assert_eq!(frame(2.0, 8.0), (2, 2.0, 8.0));
}

/// A table that only a param goes into, its blur, and a picture that changes with the time.
const TABLE: &str = include_str!("../fixtures/kept/table.toml");

#[test]
fn a_table_of_what_stands_still_is_made_once() {
    let mut lab = Lab::new();
    let mut toml = TABLE.to_owned();
    toml += &pass("table", "full", "outColor = \"table\"", "\"param.sun\"");
    toml += &pass("blur", "copy", "image = \"table\", outColor = \"blurred\"", "0.0");
    toml += &pass("first", "copy", "image = \"blurred\", outColor = \"first\"", "\"frame.time\"");
    toml += &pass("second", "copy", "image = \"first\", outColor = \"second\"", "0.0");
    toml += &pass("third", "copy", "image = \"second\", outColor = \"third\"", "0.0");
    toml += &pass("last", "copy", "image = \"third\", outColor = \"color\"", "0.0");
    let plan = lab.load(&[("graphs/test.toml", &toml), FULL, COPY], &Planned::default());
    assert!(!plan.blocks.is_empty(), "what changes with the time shares memory");
    let at = |time: f32| Builtins { frame_time: time, ..Builtins::default() };
    assert_eq!(lab.frame_with(&at(0.0), &[]).dispatched, 6);
    for frame in 1..4_u8 {
        assert_eq!(lab.frame_with(&at(f32::from(frame)), &[]).dispatched, 4, "the table and its blur are in place");
        assert_eq!(lab.floats("color", 0, 0, 0)[0][0], 0.5 + f32::from(frame));
    }
    let sun = [raxel_graph::checked::Value::F32(2.0)];
    assert_eq!(lab.frame_with(&at(3.0), &sun).dispatched, 6);
    assert_eq!(lab.floats("color", 0, 0, 0)[0][0], 5.0);
    let text = raxel_graph::print::text(&plan);
    assert_eq!(text.matches("apart: made without camera, cursor and time").count(), 2, "{text}");
}

#[test]
fn what_is_kept_stays_and_a_clear_of_it_is_no_work_for_a_still_frame() {
    let mut lab = Lab::new();
    let mut toml = "name = \"kept\"\npresent = \"color\"\n[targets.color]\nformat = \"rgba32f\"\n".to_owned();
    toml += r#"[targets.canvas]
format = "rgba32f"
keep = true
[targets.sheet]
format = "rgba32f"
keep = true
clear = 3.0
"#;
    toml += &pass("paint", "half", "outColor = { target = \"canvas\", partial = true }", "\"frame.time\"");
    toml += &pass("sheet", "half", "outColor = { target = \"sheet\", partial = true }", "\"frame.delta\"");
    toml += &pass("show", "copy", "image = \"sheet\", outColor = \"color\"", "0.0");
    let plan = lab.load(
        &[("graphs/test.toml", &toml), HALF, COPY],
        &Planned { pinned: &["canvas"], poison: true, ..Planned::default() },
    );
    assert!(plan.resources.iter().all(|r| r.lifetime == raxel_graph::plan::Lifetime::Persistent));
    let frame = |lab: &mut Lab, time: f32, delta: f32| -> FrameReport {
        let builtins = Builtins { frame_time: time, frame_delta: delta, ..Builtins::default() };
        let inputs =
            FrameInputs { builtins: &builtins, params: &[], overrides: &[], clock: Moment::START, disabled: &[] };
        lab.executor.frame(&inputs).unwrap_or_else(|error| panic!("{error}"))
    };
    for time in [1.0, 2.0] {
        frame(&mut lab, time, 5.0);
    }
    assert_eq!(lab.floats("color", 0, 0, 0)[..5], [[3.0; 4], [3.0; 4], [3.0; 4], [3.0; 4], [5.0; 4]]);
    assert_eq!(lab.floats("canvas", 0, 0, 0)[4], [2.0; 4]);
    // Other numbers of the canvas do not touch the sheet, which is cleared in each frame and in place all the same.
    let moved = frame(&mut lab, 3.0, 5.0);
    assert_eq!((moved.dispatched, moved.clears), (1, 0));
}

#[test]
fn a_pass_rests_when_everything_stands_still() {
    let mut lab = Lab::new();
    let mut toml = r#"name = "still"
present = "color"
[targets.color]
format = "rgba32f"
keep = true
"#
    .to_owned();
    toml += &pass("add", "add", "sum = \"color\"", "1.0").replace("[[passes]]", "[[passes]]\nevery = { still = 3 }");
    let add = r"#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f) uniform image2D sum;
layout(push_constant) uniform Push { float value; };
void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (all(lessThan(p, imageSize(sum)))) imageStore(sum, p, imageLoad(sum, p) + value);
}";
    lab.load(&[("graphs/test.toml", &toml), ("shaders/add.comp", add)], &Planned::default());
    let mut frame = |still: u32| {
        let report = lab.frame_with(&Builtins { frame_still: still, ..Builtins::default() }, &[]);
        (report.dispatched, lab.floats("color", 0, 0, 0)[0][0])
    };
    assert_eq!([0, 1, 2, 3, 4].map(&mut frame), [(1, 1.0), (1, 2.0), (1, 3.0), (0, 3.0), (0, 3.0)]);
    assert_eq!(frame(0), (1, 4.0));
}
