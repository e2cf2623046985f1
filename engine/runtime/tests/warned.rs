//! Counts of shaders that should be 0: reported once with the count, until they are gone, and never waited for.
#![allow(missing_docs, reason = "a test")]

mod project;

use std::time::Duration;

use project::{Project, Sessions, assert_silent};
use raxel_graph::checked::Value;
use raxel_runtime::reload::ReloadEvent;
use raxel_runtime::{Options, Session};

/// Counts `param.lost` in the second word, and one less in the third: nothing is stored where that is 0.
const SHADER: &str = include_str!("fixtures/warned/counting.comp");

const GRAPH: &str = include_str!("fixtures/warned/counting.toml");

fn project() -> Project {
    let project = Project::filled();
    project.write("graphs/counting.toml", GRAPH);
    project.write("shaders/counting.comp", SHADER);
    project
}

/// Runs a frame with `lost` pixels that find no room; returns the messages once the device has finished it.
fn frame(session: &mut Session, lost: u32) -> Vec<String> {
    session.set_param("lost", Value::U32(lost)).unwrap();
    session.frame().unwrap_or_else(|error| panic!("{error}"));
    session.wait().unwrap();
    assert_silent(session);
    session.take_messages().into_iter().map(|said| format!("{}: {}", said.code, said.message)).collect()
}

#[test]
fn a_count_is_said_once_until_it_has_gone() {
    let project = project();
    // Every frame counts, also one that nothing has changed in.
    let graph = Some("graphs/counting.toml".into());
    let mut session = Project::open_with(Options { graph, memo: false, ..project.options() });
    let none: [&str; 0] = [];
    assert_eq!(frame(&mut session, 0), none);
    assert_eq!(frame(&mut session, 1), ["RX0411: pixels found no room: 1"]);
    assert_eq!(frame(&mut session, 9), ["RX0411: more than one found none: 8"]);
    let now = session.counted();
    let now: Vec<&str> = now.iter().map(|counted| counted.message.as_str()).collect();
    assert_eq!(now, ["pixels found no room: 9", "more than one found none: 8"]);
    // A smaller count is no news, and a count that comes and goes is none either.
    for lost in [3, 0, 5, 0] {
        assert_eq!(frame(&mut session, lost), none);
    }
    assert_eq!(session.counted().len(), 2);
    for _ in 0..58 {
        assert_eq!(frame(&mut session, 0), none);
    }
    assert_eq!(session.counted().len(), 2, "59 frames are not 60");
    assert_eq!(frame(&mut session, 0), none);
    assert!(session.counted().is_empty(), "{:?}", session.counted());
    assert_eq!(frame(&mut session, 1), ["RX0411: pixels found no room: 1"]);
}

#[test]
fn a_still_picture_dispatches_nothing_for_it() {
    let project = project();
    let mut session = project.open_graph("graphs/counting.toml");
    frame(&mut session, 2);
    let before = session.device().submitted();
    for _ in 0..4 {
        let report = session.frame().unwrap();
        assert_eq!((report.dispatched, report.clears, report.barriers), (0, 0, 0), "{report:?}");
        assert!(session.take_messages().is_empty());
    }
    assert!(session.device().submitted() == before, "something was submitted");
    // It is still so, and reported on request.
    assert_eq!(session.counted().len(), 2);
}

/// The frame that counts is not waited for: it is read when its place among the frames in flight is used again.
#[test]
fn a_count_is_there_two_frames_later_without_waiting() {
    let project = project();
    let mut session = project.open_graph("graphs/counting.toml");
    session.set_param("lost", Value::U32(4)).unwrap();
    session.frame().unwrap();
    for _ in 0..2 {
        session.frame().unwrap();
    }
    assert_eq!(session.counted().len(), 2);
    assert_silent(&session);
}

#[test]
fn an_edit_of_the_graph_says_it_anew_and_points_at_it() {
    let project = project();
    let mut session = project.open_graph("graphs/counting.toml");
    frame(&mut session, 4);
    let edited = GRAPH.replace("pixels found no room", "pixels were left out");
    project.write("graphs/counting.toml", &edited);
    let events = session.wait_reload(Duration::from_secs(60));
    assert!(events.iter().any(|event| matches!(event, ReloadEvent::Reloaded(_))), "{events:?}");
    session.set_param("lost", Value::U32(5)).unwrap();
    session.frame().unwrap();
    session.wait().unwrap();
    let said = session.take_messages();
    assert_eq!(said[0].message, "pixels were left out: 5");
    assert_eq!(said[0].help, ["make room"]);
    let span = &said[0].labels[0].span;
    let text = session.texts().get(&span.file).unwrap();
    assert_eq!(&text[span.range.clone()], "\"pixels were left out\"");
    assert_silent(&session);
}
