//! The inspection of the shown target: a copy of it as it is at its point of the frame, another way of showing it, and the outcome of each
//! pass.
#![allow(clippy::float_cmp, reason = "texels are compared with the very values that were written")]

mod project;

use std::sync::Arc;
use std::time::Duration;

use project::{Project, Sessions, assert_silent};
use raxel_execute::{Captured, Comparison, Mismatch, PassOutcome, ReferenceValues, Region, Texels, TracedTexel};
use raxel_graph::checked::{Display, DisplayMap, Value};
use raxel_runtime::debug_target::DebugTarget;
use raxel_runtime::{Observe, Options, Session};

/// Two passes write the same target one after the other; a third writes a buffer; a fourth is not shown.
const GRAPH: &str = include_str!("fixtures/inspect/steps.toml");

const WRITE: &str = r"#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rg32f) uniform writeonly image2D outColor;
layout(push_constant) uniform PC { float value; } pc;
void main() { imageStore(outColor, ivec2(gl_GlobalInvocationID.xy), vec4(pc.value, gl_GlobalInvocationID.x, 0.0, 1.0)); }
";

const DOUBLE: &str = r"#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rg32f) uniform image2D color;
void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    imageStore(color, pixel, 2.0 * imageLoad(color, pixel));
}
";

const NUMBER: &str = r"#version 460
layout(local_size_x = 8) in;
layout(std430) writeonly buffer Numbers { uint items[]; } numbers;
void main() { numbers.items[gl_GlobalInvocationID.x] = 100u + gl_GlobalInvocationID.x; }
";

fn open() -> (Project, Session) {
    let project = Project::filled();
    project.write("graphs/steps.toml", GRAPH);
    project.write("shaders/write.comp", WRITE);
    project.write("shaders/double.comp", DOUBLE);
    project.write("shaders/number.comp", NUMBER);
    let graph = Some("graphs/steps.toml".into());
    // As in a window: resources that are not shown are culled.
    let session = Project::open_with(Options { graph, observe: Observe::Shown, ..project.options() });
    (project, session)
}

/// The copy that the next frame takes.
fn captured(session: &mut Session) -> Captured {
    session.capture_shown(0..u64::MAX);
    session.frame().unwrap();
    let ticket = session.captured().expect("the frame has shown something");
    assert!(session.captured().is_none(), "once");
    while session.wait_picture(Duration::from_millis(50)).unwrap() != raxel_execute::Progress::Done {}
    ticket.poll().unwrap().expect("the device has finished")
}

fn texels(session: &mut Session) -> Texels {
    match captured(session) {
        Captured::Texels(texels) => std::sync::Arc::unwrap_or_clone(texels),
        Captured::Bytes { .. } => panic!("a target is shown"),
    }
}

#[test]
fn a_copy_is_of_the_point_of_the_frame_that_is_shown() {
    let (_project, mut session) = open();
    let red = |session: &mut Session| texels(session).texel([3, 2]).unwrap().0;
    assert_eq!(red(&mut session), [0.5, 6.0, 0.0, 1.0], "at the end both passes have written");
    session.set_debug_target_text("color,after=first").unwrap();
    assert_eq!(red(&mut session), [0.25, 3.0, 0.0, 1.0], "the second pass writes over it later in the frame");
    // Also when nothing else makes the frame run, and of the newest value.
    assert_eq!(red(&mut session)[0], 0.25);
    session.set_param("value", Value::F32(3e38)).unwrap();
    session.set_debug_target_text("color").unwrap();
    let (floats, bits) = texels(&mut session).texel([0, 0]).unwrap();
    assert_eq!((floats[0], bits[0]), (f32::INFINITY, 0x7f80_0000), "its double is not a finite number");
    assert_eq!(texels(&mut session).texel([99, 0]), None);
    assert_silent(&session);
}

/// A texel is seen as each pass leaves it, in each frame in which one writes it.
#[test]
fn a_texel_is_followed_over_the_passes_of_a_frame() {
    let (_project, mut session) = open();
    let traced = TracedTexel { target: "color".to_owned(), mip: 0, layer: 0, at: [3, 2] };
    let trace = |session: &mut Session| {
        session.frame().unwrap();
        session.wait().unwrap();
        let trace = session.texel_trace()?.poll().unwrap().expect("the frame is over");
        let write = |write: &raxel_execute::TexelWrite| (write.pass.clone(), write.texel.floats()[0]);
        Some(trace.writes.iter().map(write).collect::<Vec<_>>())
    };
    let writes = |first: f32| {
        let write = |pass: &str, by: f32| (pass.to_owned(), [by * first, by * 3.0, 0.0, 1.0]);
        Some(vec![write("first", 1.0), write("second", 2.0)])
    };
    assert_eq!(trace(&mut session), None, "nobody has asked");
    session.trace_texel(Some(traced.clone()));
    assert_eq!(trace(&mut session), None, "no pass runs again for it");
    for value in [1.0, 0.125] {
        session.set_param("value", Value::F32(value)).unwrap();
        assert_eq!(trace(&mut session), writes(value));
    }
    // There is no such texel, or nothing writes it.
    let wrong = [
        TracedTexel { target: "none".to_owned(), ..traced.clone() },
        TracedTexel { target: "numbers".to_owned(), ..traced.clone() },
        TracedTexel { target: "unseen".to_owned(), ..traced.clone() },
        TracedTexel { mip: 1, at: [0, 0], ..traced.clone() },
        TracedTexel { layer: 1, ..traced.clone() },
        TracedTexel { at: [0, 1 << 20], ..traced },
    ];
    for (texel, value) in wrong.into_iter().zip([2.0, 3.0, 4.0, 5.0, 6.0, 7.0]) {
        session.trace_texel(Some(texel));
        session.set_param("value", Value::F32(value)).unwrap();
        assert_eq!(trace(&mut session), None);
    }
    session.trace_texel(None);
    session.set_param("value", Value::F32(0.75)).unwrap();
    assert_eq!(trace(&mut session), None);
    assert_silent(&session);
}

#[test]
fn each_round_of_a_loop_is_a_point_of_the_frame() {
    let (project, _) = open();
    let looped = GRAPH
        .replace("[targets.color]", "[loops.more]\ncount = 3\n[targets.color]")
        .replace("name = \"second\"\n", "name = \"second\"\nloop = \"more\"\n");
    project.write("graphs/rounds.toml", &looped);
    let mut session = project.open_graph("graphs/rounds.toml");
    let mut red = |target: &str| {
        session.set_debug_target_text(target).unwrap_or_else(|error| panic!("{target}: {error}"));
        texels(&mut session).texel([0, 0]).unwrap().0[0]
    };
    assert_eq!(red("color,after=first"), 0.25);
    assert_eq!([0, 1, 2].map(|round| red(&format!("color,after=second[{round}]"))), [0.5, 1.0, 2.0]);
    assert_eq!(red("color,after=second"), 2.0, "the last round");
    assert_eq!(red("color,after=second[9]"), 2.0, "there is no such round");
    for wrong in ["first[0]", "second[x]", "second[", "third[0]"] {
        assert!(session.set_debug_target_text(&format!("color,after={wrong}")).is_err(), "{wrong}");
    }
    assert_silent(&session);
}

#[test]
fn a_copy_of_a_buffer_is_the_part_that_was_asked_for() {
    let (_project, mut session) = open();
    session.set_debug_target_text("numbers").unwrap();
    let Captured::Bytes { start: 0, total: 32, bytes } = captured(&mut session) else { panic!("all of the buffer") };
    assert_eq!(bytes[28..], 107_u32.to_le_bytes());
    session.capture_shown(8..1000);
    session.frame().unwrap();
    session.wait().unwrap();
    let ticket = session.captured().unwrap();
    let Some(Captured::Bytes { start: 8, total: 32, bytes }) = ticket.poll().unwrap() else { panic!("a part of it") };
    assert_eq!((bytes.len(), &bytes[..4]), (24, &102_u32.to_le_bytes()[..]));
    // Behind its end there is nothing to copy.
    session.capture_shown(4096..8192);
    session.frame().unwrap();
    assert!(session.captured().is_none());
    assert_silent(&session);
}

#[test]
fn what_is_shown_can_be_mapped_in_another_way() {
    let (_project, mut session) = open();
    session.frame().unwrap();
    let pixel = |session: &mut Session| session.read_presented().unwrap().rgba[..4].to_vec();
    let own = pixel(&mut session);
    let gray = Display { map: DisplayMap::Gray, range: [0.0, 2.0], channel: 0 };
    session.set_display(Some(gray));
    assert!(session.frame().unwrap().displayed);
    assert_eq!(pixel(&mut session), [64, 64, 64, 255], "a quarter of the range");
    assert!(!session.frame().unwrap().displayed, "it stays");
    // A channel that is not there is the last one: the first column has 0 in it.
    session.set_display(Some(Display { channel: 3, ..gray }));
    session.frame().unwrap();
    assert_eq!(pixel(&mut session)[..3], [0, 0, 0]);
    session.set_display(None);
    session.frame().unwrap();
    assert_eq!(pixel(&mut session), own);
    assert_silent(&session);
}

#[test]
fn each_pass_says_what_became_of_it() {
    let (_project, mut session) = open();
    session.frame().unwrap();
    assert_eq!(session.outcomes(), [PassOutcome::Dispatched; 2], "the passes that are planned");
    session.frame().unwrap();
    assert_eq!(session.outcomes(), [PassOutcome::Skipped; 2]);
    session.wait().unwrap();
    let times = session.gpu_times();
    let sum: f64 = times.passes.iter().filter_map(|time| time.nanoseconds).sum();
    assert!(times.frame == Some(0) && times.span.is_some_and(|span| span >= sum && sum > 0.0), "{times:?}");
}

#[test]
fn a_device_that_is_given_up_is_opened_anew() {
    let (_project, mut session) = open();
    session.frame().unwrap();
    let before = session.device().id();
    session.wait().unwrap();
    session.cancel().unwrap();
    assert_ne!(session.device().id(), before);
    session.frame().unwrap();
    assert_eq!(texels(&mut session).texel([0, 0]).unwrap().0[0], 0.5);
}

/// A row of the picture that a frame shows, one channel of it.
fn row(session: &mut Session, y: u32, channel: usize) -> Vec<u8> {
    session.frame().unwrap();
    let picture = session.read_presented().unwrap();
    let row = (y * picture.width * 4) as usize..((y + 1) * picture.width * 4) as usize;
    picture.rgba[row].iter().skip(channel).step_by(4).copied().collect()
}

/// The second channel is 2 x: it is shown in grey, 0 to 255.
const GRAY: Display = Display { map: DisplayMap::Gray, range: [0.0, 255.0], channel: 1 };

#[test]
fn a_part_of_the_target_fills_the_picture_texel_by_texel() {
    let (_project, mut session) = open();
    session.set_display(Some(GRAY));
    let width = session.size()[0] as usize;
    let whole = row(&mut session, 0, 0);
    assert!(whole.iter().enumerate().all(|(x, gray)| usize::from(*gray) == 2 * x), "{whole:?}");
    session.set_region(Region { origin: [0.5, 0.0], size: 0.25 });
    let part = row(&mut session, 0, 0);
    let expected = |x: usize| 2 * (width / 2 + x / 4);
    assert!(part.iter().enumerate().all(|(x, gray)| usize::from(*gray) == expected(x)), "{part:?}");
    // A picture that stands still is the same once more, and the whole comes back.
    assert_eq!(row(&mut session, 0, 0), part);
    session.set_region(Region::WHOLE);
    assert_eq!(row(&mut session, 0, 0), whole);
    assert_silent(&session);
}

#[test]
fn a_target_is_compared_with_what_it_was() {
    let (_project, mut session) = open();
    session.set_display(Some(Display { channel: 0, range: [0.0, 1.0], ..GRAY }));
    let kept = texels(&mut session);
    let reference = Arc::new(session.builder().reference(&kept).unwrap());
    assert_eq!((reference.extent(), session.mismatch(&reference)), (session.size(), None));
    session.set_param("value", Value::F32(0.125)).unwrap();
    let width = session.size()[0] as usize;
    let (now, before) = (vec![64; width], vec![128; width]);
    assert_eq!(row(&mut session, 1, 0), now);
    let shows = |session: &mut Session, comparison, channel| {
        session.set_comparison(Some((reference.clone(), comparison)));
        row(session, 1, channel)
    };
    assert_eq!(shows(&mut session, Comparison::Reference, 0), before);
    let wiped = shows(&mut session, Comparison::Wipe(0.25), 0);
    assert_eq!(wiped, [&now[..width / 4], &before[width / 4..]].concat());
    // It has become darker by a quarter: blue, and twice as bright when amplified.
    let blue = shows(&mut session, Comparison::Difference(1.0), 2);
    assert_eq!(blue, vec![64; width]);
    assert_eq!(shows(&mut session, Comparison::Difference(2.0), 2), vec![128; width]);
    assert!(shows(&mut session, Comparison::Difference(2.0), 0)[0] < 20, "red stays dark");
    session.set_param("value", Value::F32(0.25)).unwrap();
    assert_eq!(shows(&mut session, Comparison::Difference(9.0), 2), vec![0; width], "equal is black");

    // A picture of a screen: its own colours.
    let extent = session.size();
    let white = vec![[1.0, 0.5, 0.0]; (extent[0] * extent[1]) as usize];
    let displayed = session.builder().reference_picture(&white, extent, ReferenceValues::Displayed).unwrap();
    session.set_comparison(Some((Arc::new(displayed), Comparison::Reference)));
    assert_eq!([0, 1, 2].map(|channel| row(&mut session, 0, channel)[0]), [255, 128, 0]);

    // A target that cannot be compared is shown by itself, with a message.
    session.set_comparison(Some((reference.clone(), Comparison::Reference)));
    session.set_debug_target_text("numbers").unwrap();
    session.frame().unwrap();
    assert_eq!(session.mismatch(&reference), Some(Mismatch::Buffer));
    session.set_debug_target_text("color").unwrap();
    session.resize(extent[0], extent[1] - 8);
    assert_eq!(row(&mut session, 0, 0), before);
    let other = [extent[0], extent[1] - 8];
    assert_eq!(session.mismatch(&reference), Some(Mismatch::Extent { shown: other, kept: extent }));
    session.set_comparison(None);
    assert_silent(&session);
}

/// `unseen` is half of `color` in each frame, and only the comparison needs it.
#[test]
fn a_target_is_compared_with_another_one_of_the_same_frame() {
    let (_project, mut session) = open();
    session.set_display(Some(Display { channel: 0, range: [0.0, 1.0], ..GRAY }));
    let width = session.size()[0] as usize;
    let other = DebugTarget::resource("unseen");
    let error = session.compare_live(&DebugTarget::resource("unsen"), Comparison::Reference).unwrap_err();
    assert!(error.to_string().contains("unsen"), "{error}");
    let shows = |session: &mut Session, comparison, channel| {
        session.compare_live(&other, comparison).unwrap();
        let row = row(session, 0, channel);
        assert_eq!(session.live_mismatch(), None);
        row
    };
    for (value, grays) in [(0.125, [64, 32]), (0.25, [128, 64]), (0.375, [191, 96])] {
        session.set_param("value", Value::F32(value)).unwrap();
        let [color, unseen] = grays.map(|gray| vec![gray; width]);
        assert_eq!(shows(&mut session, Comparison::Reference, 0), unseen);
        let wiped = shows(&mut session, Comparison::Wipe(0.25), 0);
        assert_eq!(wiped, [&color[..width / 4], &unseen[width / 4..]].concat());
        // Orange, as bright as the difference.
        assert_eq!(shows(&mut session, Comparison::Difference(1.0), 0), unseen);
    }
    // A picture that stands still makes no work.
    session.wait().unwrap();
    let before = session.device().submitted();
    for _ in 0..3 {
        session.frame().unwrap();
    }
    session.wait().unwrap();
    assert_eq!(session.device().submitted(), before);

    // A buffer, a point within the frame, another extent: the target is shown alone, and the reason is known.
    session.compare_live(&DebugTarget::resource("numbers"), Comparison::Reference).unwrap();
    assert_eq!(row(&mut session, 0, 0), vec![191; width]);
    assert_eq!(session.live_mismatch(), Some(Mismatch::Buffer));
    session.compare_live(&other, Comparison::Reference).unwrap();
    session.set_debug_target_text("color,after=first").unwrap();
    assert_eq!(row(&mut session, 0, 0), vec![96; width]);
    assert_eq!(session.live_mismatch(), Some(Mismatch::Early));
    session.set_debug_target_text("color").unwrap();
    let [across, down] = session.size();
    session.resize(across, down - 8);
    session.set_param("value", Value::F32(0.125)).unwrap();
    assert_eq!(row(&mut session, 0, 0), vec![32; width], "both have the new extent");
    session.set_comparison(None);
    assert_eq!(row(&mut session, 0, 0), vec![64; width]);
    assert_eq!(session.live_mismatch(), None);
    assert_silent(&session);
}
