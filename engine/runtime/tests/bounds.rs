//! Accesses out of bounds, found by checks that are switched on: arrays, vectors and images, and what a checked shader computes.
#![allow(missing_docs, reason = "a test")]

mod project;

use std::time::Duration;

use project::{Project, Sessions, assert_silent};
use raxel_diagnostics::Severity;
use raxel_graph::checked::Value;
use raxel_runtime::reload::ReloadEvent;
use raxel_runtime::{Observe, Options, Session};

const GRAPH: &str = include_str!("fixtures/bounds/bounds.toml");

/// A shader that runs `body` in the invocation (2, 1), with `n`.
fn shader(body: &str) -> String {
    format!(
        r"#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f) uniform image2D outColor;
struct Pair {{ vec2 a; uint b; }};
layout(std430) buffer Counts {{ uint four[4]; uint rest[]; }} counts;
layout(push_constant) uniform PC {{ uint n; }} pc;
shared uint ours[16];
void main() {{
    uint n = pc.n;
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (at == ivec2(0)) imageStore(outColor, at, vec4(counts.four[0], counts.rest[0], 0, n));
    if (at != ivec2(2, 1)) return;
{body}
}}
"
    )
}

/// The first line of `body` in a shader.
const LINE: usize = 13;

fn project(body: &str) -> Project {
    let project = Project::filled();
    project.write("graphs/bounds.toml", GRAPH);
    project.write("shaders/count.comp", shader(body));
    project
}

fn open(project: &Project, check_bounds: bool) -> Session {
    let (graph, observe) = (Some("graphs/bounds.toml".into()), Observe::Everything);
    Project::open_with(Options { graph, observe, check_bounds, memo: false, ..project.options() })
}

/// Runs a frame, and gives what is found in it: messages with their labels.
fn found(session: &mut Session, n: u32) -> Vec<(String, String, usize)> {
    session.set_param("n", Value::U32(n)).unwrap();
    session.frame().unwrap_or_else(|error| panic!("{error}"));
    session.wait().unwrap();
    assert_silent(session);
    let said = session.take_messages();
    let found = said.iter().map(|message| {
        assert_eq!((message.code.as_str(), message.severity), ("RX0413", Severity::Error));
        let label = &message.labels[0];
        assert_eq!(&*label.span.file, "shaders/count.comp");
        let text = session.texts().get(&label.span.file).unwrap();
        let line = text[..label.span.range.start].lines().count();
        (message.message.clone(), label.text.clone(), line)
    });
    found.collect()
}

/// A body's access with an `n` out of bounds: the message, and the beginning of its label.
fn beyond(body: &str, inside: u32, n: u32) -> (String, String) {
    let project = project(body);
    let mut session = open(&project, true);
    assert_eq!(found(&mut session, inside), [], "{body}");
    let all = found(&mut session, n);
    let [(message, label, line)] = all.as_slice() else { panic!("{body}: {all:?}") };
    assert_eq!(*line, LINE, "{body}");
    let label = label.strip_suffix(", first in invocation (2, 1, 0) of frame 1").unwrap_or_else(|| panic!("{label}"));
    (message.clone(), label.to_owned())
}

#[test]
fn each_kind_of_access_is_found_at_its_line() {
    for (body, inside, n, name, what, label) in [
        ("    counts.rest[n] = 1u;", 5, 6, "counts.rest", "1 write", "index 6 of 6 elements"),
        ("    counts.four[n] += 1u;", 3, 4, "counts.four", "1 write", "index 4 of 4 elements"),
        ("    atomicAdd(counts.rest[n - 1u], 2u);", 1, 0, "counts.rest", "1 write", "index -1 of 6 elements"),
        ("    if (counts.rest[n] == 99u) discardAll();", 5, 900, "counts.rest", "1 read", "index 900 of 6 elements"),
        ("    ours[n] = 1u;", 15, 16, "ours", "1 write", "index 16 of 16 elements"),
        (
            "    uint own[3]; own[n] = n; imageStore(outColor, at, vec4(own[0]));",
            2,
            3,
            "own",
            "1 write",
            "index 3 of 3 elements",
        ),
        (
            "    vec4 v = vec4(n); v[n] = 2.0; imageStore(outColor, at, v);",
            3,
            5,
            "v",
            "1 write",
            "index 5 of 4 elements",
        ),
        (
            "    Pair p[2]; p[n].a[0] = 1.0; imageStore(outColor, at, vec4(p[0].a[0]));",
            1,
            2,
            "p",
            "1 write",
            "index 2 of 2 elements",
        ),
        ("    imageStore(outColor, ivec2(n, 1), vec4(1));", 15, 16, "outColor", "1 write", "texel (16, 1) of 16×16"),
        (
            "    imageStore(outColor, at, imageLoad(outColor, ivec2(3, int(n) - 1)));",
            1,
            0,
            "outColor",
            "1 read",
            "texel (3, -1) of 16×16",
        ),
        (
            "    for (uint i = 0u; i < n; i++) counts.four[i] = 1u;",
            4,
            9,
            "counts.four",
            "5 writes",
            "index 4 of 4 elements",
        ),
    ] {
        let body = body.replace("discardAll()", "imageStore(outColor, at, vec4(0))");
        let (message, found) = beyond(&body, inside, n);
        assert_eq!(message, format!("`{name}` is accessed out of bounds in pass `count`: {what}"), "{body}");
        assert_eq!(found, label, "{body}");
    }
}

/// Two accesses of one line are two, and each is reported once, until it has not happened for 60 frames.
#[test]
fn an_access_is_said_once() {
    let project = project("    counts.four[n] = counts.rest[n + 2u];");
    let mut session = open(&project, true);
    assert_eq!(found(&mut session, 4).len(), 2);
    assert_eq!(found(&mut session, 5), []);
    assert_eq!(session.counted().len(), 2);
    for _ in 0..60 {
        assert_eq!(found(&mut session, 3), []);
    }
    assert_eq!(session.counted(), []);
    assert_eq!(found(&mut session, 4).len(), 2);
}

/// Without checks nothing is found, and with them the shader computes the same.
#[test]
fn checks_are_off_at_first_and_change_nothing() {
    let project =
        project("    imageStore(outColor, ivec2(n, 3), vec4(counts.rest[n & 3u], at, 1)); counts.four[n & 3u] = n;");
    let mut pictures = Vec::new();
    for check in [false, true] {
        let mut session = open(&project, check);
        assert_eq!(session.checks_bounds(), check);
        assert_eq!(session.has_prints(), check);
        assert_eq!(found(&mut session, 20).len(), usize::from(check));
        assert_eq!(found(&mut session, 3), []);
        let counts = session.read_buffer("counts", 0..40).unwrap();
        pictures.push((session.read_presented().unwrap().rgba, counts));
    }
    assert_eq!(pictures[0], pictures[1]);
}

/// A session that watches its files switches checks on and off while it runs, and keeps its state.
#[test]
fn checks_are_switched_while_it_runs() {
    let project = project("    counts.four[n] = 1u;");
    let graph = Some("graphs/bounds.toml".into());
    let mut session = Project::open_with(Options { graph, memo: false, ..project.options() });
    assert_eq!(found(&mut session, 4), []);
    for (on, count) in [(true, 1), (false, 0), (true, 1)] {
        assert!(session.check_bounds(on));
        let events = session.wait_reload(Duration::from_secs(60));
        assert!(matches!(events.as_slice(), [ReloadEvent::Reloaded(_)]), "{events:?}");
        assert_eq!(session.checks_bounds(), on);
        assert_eq!(found(&mut session, 4).len(), count);
    }
    let options = Options { graph: Some("graphs/bounds.toml".into()), watch: false, ..project.options() };
    assert!(!Project::open_with(options).check_bounds(true), "nothing compiles where nothing watches");
}
