//! Prints of passes, and assertions of shaders: values, order, limits, passes, frames in flight, edits.
#![allow(missing_docs, reason = "a test")]

mod project;

use std::time::Duration;

use project::{Project, Sessions, assert_silent};
use raxel_diagnostics::Severity;
use raxel_execute::PassPrints;
use raxel_graph::checked::Value;
use raxel_runtime::reload::ReloadEvent;
use raxel_runtime::{Options, Session};

/// The shader that stores `pc.n` after it has run `body` with `at`, the invocation, and `n`.
fn shader(body: &str) -> String {
    format!(
        r"#version 460
#include <raxel/print.glsl>
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f) uniform writeonly image2D outColor;
layout(push_constant) uniform PC {{ uint n; }} pc;
void main() {{
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    uint n = pc.n;
    imageStore(outColor, at, vec4(n));
{body}
}}
"
    )
}

/// The first line of `body` in a shader.
const LINE: u32 = 10;

const GRAPH: &str = include_str!("fixtures/prints/print.toml");

fn project(body: &str) -> Project {
    let project = Project::filled();
    project.write("graphs/print.toml", GRAPH);
    project.write("shaders/print.comp", shader(body));
    project
}

/// Runs a frame and gives what passes have printed in it.
fn frame(session: &mut Session, n: u32) -> Vec<PassPrints> {
    session.set_param("n", Value::U32(n)).unwrap();
    session.frame().unwrap_or_else(|error| panic!("{error}"));
    session.wait().unwrap();
    assert_silent(session);
    session.take_prints()
}

fn texts(prints: &[PassPrints]) -> Vec<&str> {
    prints.iter().flat_map(|prints| &prints.lines).map(|line| line.text.as_str()).collect()
}

/// The prints of a body in the first frame, in a world of its own.
fn printed(body: &str) -> Vec<String> {
    let project = project(body);
    let prints = frame(&mut project.open_graph("graphs/print.toml"), 3);
    texts(&prints).into_iter().map(str::to_owned).collect()
}

#[test]
fn every_type_is_printed_as_it_is() {
    let body = r#"
    if (at != ivec2(0)) return;
    float f = float(n) * 0.5;
    debugPrintfEXT("%u %d %f %d", n, -int(n), f, n == 3u);
    debugPrintfEXT("%v2f|%v3f|%.1v4f", vec2(f, -f), vec3(f, 0.0, 1.0 / (f - f)), vec4(f));
    debugPrintfEXT("%v2d|%v3d|%v4d", ivec2(-1, int(n)), ivec3(at, 7), ivec4(at, at));
    debugPrintfEXT("%v2u|%v3x|%v4u", uvec2(n, 4294967295u), uvec3(255u, n, n), uvec4(n));
    debugPrintfEXT("%v2d|%v3d", bvec2(n == 3u, n == 4u), greaterThan(vec3(f), vec3(1.0, 2.0, 1.5)));
    debugPrintfEXT("%g%% done", f);
    debugPrintfEXT("no value");"#;
    assert_eq!(
        printed(body),
        [
            "3 -3 1.500000 true",
            "1.500000, -1.500000|1.500000, 0.000000, inf|1.5, 1.5, 1.5, 1.5",
            "-1, 3|0, 0, 7|0, 0, 0, 0",
            "3, 4294967295|ff, 3, 3|3, 3, 3, 3",
            "true, false|true, false, false",
            "1.5% done",
            "no value",
        ]
    );
}

/// Lines of one invocation come in the order of the program, from loops and functions as well.
#[test]
fn lines_are_in_order_and_know_their_place() {
    let body = "    if (at != ivec2(5, 6)) return;
    for (uint i = 0u; i < n; i++) {
        debugPrintfEXT(\"a %u\", i);
        if (i == 1u) debugPrintfEXT(\"b\");
    }";
    let project = project(body);
    let mut session = project.open_graph("graphs/print.toml");
    let prints = frame(&mut session, 3);
    assert_eq!(texts(&prints), ["a 0", "a 1", "b", "a 2"]);
    let [prints] = prints.as_slice() else { panic!("{prints:?}") };
    assert_eq!((prints.pass.as_str(), prints.frame, prints.omitted.len()), ("print", 0, 0));
    assert!(prints.lines.iter().all(|line| line.invocation == [5, 6, 0]), "{prints:?}");
    let lines: Vec<u32> = prints.lines.iter().map(|line| line.place.as_ref().unwrap().1).collect();
    assert_eq!(lines, [LINE + 2, LINE + 2, LINE + 3, LINE + 2]);
    assert_eq!(&*prints.lines[0].place.as_ref().unwrap().0, "shaders/print.comp");
    assert_eq!(session.printed(), std::slice::from_ref(prints));
}

#[test]
fn a_flood_is_counted_and_leaves_others_their_room() {
    let body = "    for (int i = 0; i < 1000; i++) debugPrintfEXT(\"flood %d\", i);
    if (at == ivec2(15, 15)) debugPrintfEXT(\"drop\");";
    let project = project(body);
    let prints = frame(&mut project.open_graph("graphs/print.toml"), 0);
    let all = texts(&prints);
    assert_eq!(all.iter().filter(|text| text.starts_with("flood")).count(), 256);
    assert_eq!(all.iter().filter(|text| **text == "drop").count(), 1);
    let omitted: Vec<_> = prints[0].omitted.iter().map(|omitted| omitted.count).collect();
    assert_eq!(omitted, [256_000 - 256]);
    let again = frame(&mut project.open_graph("graphs/print.toml"), 1);
    assert_eq!(again[0].omitted, prints[0].omitted, "each frame begins with none");
}

const TWO: &str = r#"
[targets.other]
format = "rgba32f"

[[passes]]
name = "again"
shader = "print.comp"
dispatch = { threads = "other" }
bind = { outColor = "other" }
push = { n = "param.n" }
"#;

/// Passes that share a pipeline have each their own part of the buffer.
#[test]
fn two_passes_of_one_shader_print_each_for_itself() {
    let project = project("    if (at == ivec2(0)) debugPrintfEXT(\"n %u\", n);");
    project.write("graphs/print.toml", &(GRAPH.to_owned() + TWO));
    let observe = raxel_runtime::Observe::Everything;
    let options = Options { graph: Some("graphs/print.toml".into()), observe, ..project.options() };
    let mut session = Project::open_with(options);
    for n in [1, 2] {
        let prints = frame(&mut session, n);
        let passes: Vec<&str> = prints.iter().map(|prints| prints.pass.as_str()).collect();
        assert_eq!(passes, ["print", "again"]);
        let text = format!("n {n}");
        assert_eq!(texts(&prints), [&text, &text]);
    }
}

/// Frames are not waited for: each is read when its place among those in flight is used again, and none is mixed with another.
#[test]
fn frames_in_flight_keep_what_they_print_apart() {
    let project = project("    if (at.y == 0) debugPrintfEXT(\"%u\", n);");
    let mut session = project.open_graph("graphs/print.toml");
    for n in 0..8 {
        session.set_param("n", Value::U32(n)).unwrap();
        session.frame().unwrap();
    }
    session.wait().unwrap();
    let prints = session.take_prints();
    assert_eq!(prints.len(), 8);
    for (prints, n) in prints.iter().zip(0u64..) {
        assert_eq!(prints.frame, n);
        assert_eq!(prints.lines.len(), 16);
        assert!(prints.lines.iter().all(|line| line.text == n.to_string()), "{prints:?}");
    }
    assert_silent(&session);
}

/// A picture that stands still runs no pass, so nothing is printed and nothing is submitted.
#[test]
fn a_pass_that_is_skipped_prints_nothing() {
    let project = project("    if (at == ivec2(0)) debugPrintfEXT(\"%u\", n);");
    let mut session = project.open_graph("graphs/print.toml");
    assert_eq!(texts(&frame(&mut session, 1)), ["1"]);
    let before = session.device().submitted();
    for _ in 0..4 {
        assert!(frame(&mut session, 1).is_empty());
    }
    assert!(session.device().submitted() == before, "something was submitted");
    assert_eq!(session.printed().len(), 1, "what it printed when it ran last");
}

fn reload(session: &mut Session) {
    let events = session.wait_reload(Duration::from_secs(60));
    assert!(events.iter().any(|event| matches!(event, ReloadEvent::Reloaded(_))), "{events:?}");
}

/// An edit of a text, and of the line that it stands on, is printed by the next frame although nothing else has changed.
#[test]
fn printing_is_switched_by_editing_the_shader() {
    let project = project("");
    let mut session = project.open_graph("graphs/print.toml");
    assert!(!session.has_prints());
    assert!(frame(&mut session, 1).is_empty());
    for (body, text, line) in [
        ("    if (at == ivec2(0)) debugPrintfEXT(\"one %u\", n);", "one 1", LINE),
        ("    if (at == ivec2(0)) debugPrintfEXT(\"two %u\", n);", "two 1", LINE),
        ("    // a comment\n    if (at == ivec2(0)) debugPrintfEXT(\"two %u\", n);", "two 1", LINE + 1),
    ] {
        project.write("shaders/print.comp", shader(body));
        reload(&mut session);
        let prints = frame(&mut session, 1);
        assert_eq!(texts(&prints), [text], "{body}");
        assert_eq!(prints[0].lines[0].place.as_ref().unwrap().1, line, "{body}");
    }
    project.write("shaders/print.comp", shader(""));
    reload(&mut session);
    assert!(frame(&mut session, 1).is_empty() && session.printed().is_empty() && !session.has_prints());
}

#[test]
fn an_assertion_is_an_error_once_until_it_holds() {
    let project = project("    rx_assert(n < 5u || at.y > 0 /* )( */);");
    let graph = Some("graphs/print.toml".into());
    let mut session = Project::open_with(Options { graph, memo: false, ..project.options() });
    let mut said = |n: u32| {
        assert!(frame(&mut session, n).is_empty(), "an assertion is no line");
        let said = session.take_messages();
        (said, session.counted().into_iter().map(|failing| failing.message).collect::<Vec<_>>())
    };
    assert_eq!(said(1), (Vec::new(), Vec::new()));
    let (first, failing) = said(7);
    let message = "`rx_assert(n < 5u || at.y > 0 /* )( */)` failed in pass `print`: 16 invocations";
    assert_eq!(failing, [message]);
    let [first] = first.as_slice() else { panic!("{first:?}") };
    assert_eq!((first.code.to_string().as_str(), first.message.as_str()), ("RX0412", message));
    assert_eq!(first.severity, Severity::Error);
    let label = &first.labels[0];
    assert!(label.text.ends_with(", 0, 0) of frame 1"), "{}", label.text);
    assert_eq!(said(8), (Vec::new(), vec![message.to_owned()]), "it is said once");
    for _ in 0..60 {
        assert!(said(1).0.is_empty());
    }
    assert_eq!(said(1), (Vec::new(), Vec::new()), "it has held for 60 frames");
    assert_eq!(said(9).0.len(), 1);
    let span = session.take_messages().is_empty().then(|| label.span.clone()).unwrap();
    assert_eq!(&session.texts().get(&span.file).unwrap()[span.range], "rx_assert");
}

#[test]
fn what_cannot_be_printed_is_an_error_at_its_line() {
    for (body, wrong) in [
        ("debugPrintfEXT(\"%f %f\", 1.0);", "its text has 2 conversions, and it has 1 value"),
        ("debugPrintfEXT(\"%s\", 1);", "`%s` is no conversion"),
        ("debugPrintfEXT(\"%f\", mat2(1.0));", "value 1 is no 32-bit number"),
        ("debugPrintfEXT(\"%\", 1);", "ends within a conversion"),
    ] {
        let project = project(&format!("\n    {body}"));
        let options = Options { graph: Some("graphs/print.toml".into()), ..project.options() };
        let error = Session::open(options).err().expect("it does not open");
        let raxel_runtime::OpenError::Project { diagnostics, texts } = error else { panic!("{error}") };
        let found = &diagnostics[0];
        assert_eq!(found.code.to_string(), "RX0218");
        assert!(found.message.contains(wrong), "{}", found.message);
        let span = &found.labels[0].span;
        assert_eq!(&texts.get(&span.file).unwrap()[span.range.clone()], "debugPrintfEXT");
    }
}
