//! Small pictures of the outputs of passes: their contents, the times at which they are made, and that none is made unasked.
#![allow(missing_docs, reason = "a test")]

mod project;

use std::collections::BTreeMap;

use project::{Project, Sessions, assert_silent};
use raxel_execute::Thumbnail;
use raxel_runtime::{Observe, Options, Session};

/// Four targets that could share memory, written in turn; the second in place.
const GRAPH: &str = include_str!("fixtures/thumbnails/thumbnails.toml");

const FILL: &str = r"#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba8) uniform writeonly image2D outColor;
layout(push_constant) uniform PC { float red; } pc;
void main() { imageStore(outColor, ivec2(gl_GlobalInvocationID.xy), COLOR); }
";

const COPY: &str = include_str!("fixtures/thumbnails/copy.comp");

fn open() -> (Project, Session) {
    let project = Project::filled();
    project.write("graphs/thumbnails.toml", GRAPH);
    project.write("shaders/fill.comp", FILL);
    project.write("shaders/copy.comp", COPY);
    let graph = Some("graphs/thumbnails.toml".into());
    // As in a window: with memory that is shared.
    let session = Project::open_with(Options { graph, observe: Observe::Shown, ..project.options() });
    (project, session)
}

/// Runs frames, and gives the newest thumbnail of each pass.
fn frames(session: &mut Session, count: usize) -> BTreeMap<usize, Thumbnail> {
    let mut newest = BTreeMap::new();
    for _ in 0..count {
        session.frame().unwrap();
        session.wait().unwrap();
        newest.extend(session.take_thumbnails().into_iter().map(|thumbnail| (thumbnail.pass, thumbnail)));
    }
    assert_silent(session);
    newest
}

/// The colour of a thumbnail of one colour.
fn color(thumbnail: &Thumbnail) -> [u8; 4] {
    let [width, height] = thumbnail.size.map(|side| side as usize);
    assert_eq!(thumbnail.rgba.len(), 4 * width * height);
    let first: [u8; 4] = thumbnail.rgba[..4].try_into().unwrap();
    assert!(thumbnail.rgba.chunks_exact(4).all(|pixel| pixel == first), "{thumbnail:?}");
    first
}

const WHITE: [u8; 4] = [255; 4];
const BLACK: [u8; 4] = [0, 0, 0, 255];

#[test]
fn each_pass_has_a_picture_of_what_it_leaves() {
    let (_project, mut session) = open();
    session.make_thumbnails(true);
    let found = frames(&mut session, 6);
    let colors: Vec<[u8; 4]> = found.values().map(color).collect();
    assert_eq!(colors, [[255, 0, 0, 255], [0, 0, 255, 255], [0, 255, 0, 255], WHITE]);
    // As large as there is room for, in the proportions of the target.
    let sizes: Vec<[u32; 2]> = found.values().map(|thumbnail| thumbnail.size).collect();
    assert_eq!(sizes, [[60, 60], [96, 24], [60, 60], [60, 60]]);
}

/// A picture that stands still is made once, a few a frame; then nothing runs until something changes.
#[test]
fn a_still_frame_makes_each_once_and_then_nothing() {
    let (_project, mut session) = open();
    assert!(frames(&mut session, 3).is_empty(), "nobody has asked");
    let before = session.device().submitted();
    assert!(frames(&mut session, 2).is_empty() && session.device().submitted() == before);
    session.make_thumbnails(true);
    assert_eq!(frames(&mut session, 1).len(), 2, "two a frame");
    assert_eq!(frames(&mut session, 1).len(), 2);
    // The reason of their run is no reason to make them again.
    frames(&mut session, 4);
    let before = session.device().submitted();
    assert!(frames(&mut session, 4).is_empty() && session.device().submitted() == before);
    session.set_param("red", raxel_graph::checked::Value::F32(0.0)).unwrap();
    let found = frames(&mut session, 6);
    let colors: Vec<[u8; 4]> = found.values().map(color).collect();
    assert_eq!(colors, [BLACK, BLACK, BLACK, WHITE]);
    session.make_thumbnails(false);
    session.set_param("red", raxel_graph::checked::Value::F32(1.0)).unwrap();
    assert!(frames(&mut session, 4).is_empty());
}

/// The shown picture is the same bytes while thumbnails are made.
#[test]
fn they_change_no_picture() {
    let (_project, mut session) = open();
    session.set_debug_target_text("middle").unwrap();
    frames(&mut session, 2);
    let before = session.read_presented().unwrap().rgba;
    session.make_thumbnails(true);
    frames(&mut session, 5);
    assert!(session.read_presented().unwrap().rgba == before);
}
