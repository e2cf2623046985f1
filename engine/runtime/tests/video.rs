//! A video as a target: the frame of each time, the same in every run; its end, its edits, and files that are no videos.
#![allow(missing_docs, reason = "a test")]

mod project;

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use project::{Project, Sessions, assert_silent};
use raxel_graph::checked::Value;
use raxel_runtime::reload::ReloadEvent;
use raxel_runtime::{OpenError, Options, Session};

const GRAPH: &str = include_str!("fixtures/video/video.toml");

const SHADER: &str = include_str!("fixtures/video/show.comp");

/// Writes a video without loss: a frame of one colour for each number, ten a second.
fn write_clip(path: &Path, reds: &[u8]) {
    let mut ffmpeg = Command::new("ffmpeg")
        .args(["-v", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgba", "-s", "8x4", "-r", "10", "-i", "-"])
        .args(["-c:v", "png"])
        .arg(path)
        .stdin(Stdio::piped())
        .spawn()
        .expect("ffmpeg is installed");
    let mut pipe = ffmpeg.stdin.take().unwrap();
    for red in reds {
        std::io::Write::write_all(&mut pipe, &[*red, 7, 9, 255].repeat(8 * 4)).unwrap();
    }
    drop(pipe);
    assert!(ffmpeg.wait().unwrap().success());
}

fn project(reds: &[u8]) -> Project {
    let project = Project::filled();
    project.write("graphs/video.toml", GRAPH);
    project.write("shaders/show.comp", SHADER);
    write_clip(&project.path("clip.mkv"), reds);
    project
}

fn options(project: &Project) -> Options {
    Options { graph: Some("graphs/video.toml".into()), step: Some(0.1), ..project.options() }
}

/// The red of the next frame, which is of one colour.
fn red(session: &mut Session) -> u8 {
    session.frame().unwrap_or_else(|error| panic!("{error}"));
    let rgba = session.read_presented().unwrap().rgba;
    assert_silent(session);
    assert!(rgba.chunks_exact(4).all(|pixel| pixel == &rgba[..4]));
    assert_eq!(rgba[2], 9);
    rgba[0]
}

#[test]
fn each_frame_shows_the_frame_of_its_time_and_the_end_is_the_beginning() {
    let project = project(&[10, 60, 110, 160, 210]);
    for _ in 0..2 {
        let mut session = Project::open_with(options(&project));
        let reds: Vec<u8> = (0..12).map(|_| red(&mut session)).collect();
        assert_eq!(reds, [10, 60, 110, 160, 210, 10, 60, 110, 160, 210, 10, 60]);
        session.seek(0.35);
        assert_eq!([red(&mut session), red(&mut session)], [160, 210]);
        session.seek(0.15);
        assert_eq!(red(&mut session), 60);
        session.reset();
        assert_eq!(red(&mut session), 10);
    }
}

/// Slower and faster than the video; and a clock that stands still makes no work.
#[test]
fn frames_are_repeated_and_left_out() {
    let project = project(&[10, 60, 110, 160, 210]);
    let mut slow = Project::open_with(Options { step: Some(0.04), ..options(&project) });
    let reds: Vec<u8> = (0..8).map(|_| red(&mut slow)).collect();
    assert_eq!(reds, [10, 10, 10, 60, 60, 110, 110, 110]);
    slow.pause(true);
    red(&mut slow);
    let before = slow.device().submitted();
    for _ in 0..3 {
        slow.frame().unwrap();
    }
    slow.wait().unwrap();
    assert!(slow.device().submitted() == before, "a paused video runs nothing");
    let mut fast = Project::open_with(Options { step: Some(0.2), ..options(&project) });
    let reds: Vec<u8> = (0..4).map(|_| red(&mut fast)).collect();
    assert_eq!(reds, [10, 110, 210, 60]);
}

/// With a clock that follows the wall, no frame waits for a decoder, and the picture gets there all the same.
#[test]
fn a_live_clock_waits_for_no_frame_of_a_video() {
    let project = project(&[10, 60, 110, 160, 210]);
    let mut session = Project::open_with(Options { step: None, ..options(&project) });
    let mut seen = std::collections::BTreeSet::new();
    let until = std::time::Instant::now() + Duration::from_secs(60);
    while seen.len() < 3 && std::time::Instant::now() < until {
        seen.insert(red(&mut session));
    }
    assert!(seen.len() >= 3, "{seen:?}");
}

#[test]
fn another_video_and_other_texels_are_taken_over() {
    let project = project(&[10, 60, 110]);
    let mut session = Project::open_with(options(&project));
    assert_eq!([red(&mut session), red(&mut session)], [10, 60]);
    write_clip(&project.path("clip.mkv"), &[20, 30, 40, 50]);
    let events = session.wait_reload(Duration::from_secs(60));
    assert!(events.iter().any(|event| matches!(event, ReloadEvent::Reloaded(_))), "{events:?}");
    assert_eq!([red(&mut session), red(&mut session)], [40, 50]);
    session.set_param("add", Value::F32(0.5)).unwrap();
    assert_eq!(red(&mut session), 20);
    // As light, with mips.
    project.write("graphs/video.toml", GRAPH.replace(".mkv\"", ".mkv\"\nencoding = \"srgb\"\nmips = \"full\""));
    session.wait_reload(Duration::from_secs(60));
    session.seek(0.0);
    session.frame().unwrap();
    let texels = session.read_texels("clip", 0, 0, 0).unwrap();
    assert_eq!(texels.format.name(), "rgba16f");
    session.frame().unwrap();
    let light = session.read_texels("clip", 0, 2, 0).unwrap().floats()[0][0];
    let expected = ((30.0_f32 / 255.0 + 0.055) / 1.055).powf(2.4);
    assert!((light - expected).abs() < 1e-3, "{light} {expected}");
}

#[test]
fn what_is_no_video_is_an_error_at_its_source() {
    for (bytes, wrong) in [
        (b"no video at all".as_slice(), "`clip.mkv` cannot be read: ffprobe says:"),
        (b"", "`clip.mkv` cannot be read"),
        // A list of files, which would lead to another one.
        (b"ffconcat version 1.0\nfile other.mkv\n", "`clip.mkv` cannot be read"),
    ] {
        let project = project(&[10]);
        write_clip(&project.path("other.mkv"), &[10]);
        std::fs::write(project.path("clip.mkv"), bytes).unwrap();
        let error = Session::open(options(&project)).err().expect("it does not open");
        let OpenError::Project { diagnostics, texts } = error else { panic!("{error}") };
        assert!(diagnostics[0].message.starts_with(wrong), "{}", diagnostics[0].message);
        let span = &diagnostics[0].labels[0].span;
        assert_eq!(&texts.get(&span.file).unwrap()[span.range.clone()], "\"file.clip.mkv\"");
    }
}
