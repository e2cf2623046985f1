//! A sound as a target: the spectrum and the waveform of each time, the same in every run; its end, its edits, and files that are no sounds.
#![allow(missing_docs, clippy::cast_possible_truncation, clippy::float_cmp, reason = "a test")]

mod project;

use std::time::Duration;

use project::{Project, Sessions, assert_silent, write_wav};
use raxel_runtime::reload::ReloadEvent;
use raxel_runtime::{OpenError, Options, Session};

const GRAPH: &str = include_str!("fixtures/sound/sound.toml");

/// Each texel of the sound, as the sampler gives it.
const SHADER: &str = r"#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(r32f) uniform writeonly image2D outColor;
uniform sampler2D sound;
void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    imageStore(outColor, at, vec4(textureLod(sound, (vec2(at) + 0.5) / textureSize(sound, 0), 0.0).x));
}
";

/// Samples of a second.
const RATE: usize = 48_000;

/// A sample of a tone that lies on a texel of the spectrum.
fn tone(texel: usize, at: usize) -> f64 {
    0.1 * (std::f64::consts::TAU * texel as f64 * at as f64 / 2048.0).sin()
}

/// A second of silence, a second of each tone.
fn samples(tones: &[usize]) -> Vec<i16> {
    let tones = tones.iter().enumerate().flat_map(|(second, texel)| {
        (0..RATE).map(move |at| (32_767.0 * tone(*texel, RATE * (second + 1) + at)).round() as i16)
    });
    std::iter::repeat_n(0, RATE).chain(tones).collect()
}

fn project(tones: &[usize]) -> Project {
    let project = Project::filled();
    project.write("graphs/sound.toml", GRAPH);
    project.write("shaders/show.comp", SHADER);
    write_wav(&project.path("tone.wav"), &samples(tones));
    project
}

fn options(project: &Project) -> Options {
    Options { graph: Some("graphs/sound.toml".into()), step: Some(0.1), size: [512, 2], ..project.options() }
}

/// Both rows of the next frame.
fn rows(session: &mut Session) -> [Vec<f32>; 2] {
    session.frame().unwrap_or_else(|error| panic!("{error}"));
    let texels: Vec<f32> = session.read_target("color").unwrap().floats().iter().map(|texel| texel[0]).collect();
    assert_silent(session);
    assert_eq!(texels.len(), 1024);
    let (spectrum, waveform) = texels.split_at(512);
    [spectrum.to_vec(), waveform.to_vec()]
}

fn loudest(row: &[f32]) -> usize {
    (0..row.len()).max_by(|a, b| row[*a].total_cmp(&row[*b])).unwrap()
}

#[test]
fn each_frame_hears_what_sounds_at_its_time() {
    let project = project(&[40, 137]);
    let mut runs = Vec::new();
    for _ in 0..2 {
        let mut session = Project::open_with(options(&project));
        let heard: Vec<_> = (0..34).map(|_| rows(&mut session)).collect();
        let [spectrum, waveform] = &heard[10];
        assert!(spectrum.iter().all(|value| *value == 0.0) && waveform.iter().all(|value| *value == 0.5));
        for (frame, texel) in [(15, 40), (20, 40), (25, 137), (30, 137)] {
            let [spectrum, waveform] = &heard[frame];
            assert_eq!(loudest(spectrum), texel, "at frame {frame}");
            for (at, value) in waveform.iter().enumerate() {
                let expected = 0.5 + 0.5 * tone(texel, frame * RATE / 10 - 512 + at);
                assert!((f64::from(*value) - expected).abs() < 1e-3, "frame {frame}, {at}: {value} {expected}");
            }
        }
        // After three seconds it begins again, and the last tone fades.
        assert!(heard[33][0][137] > 0.0 && heard[33][0][137] < heard[30][0][137]);
        assert!(heard[33][1].iter().all(|value| *value == 0.5));
        // A seek hears the same as the frames that came there, forwards and backwards.
        session.seek(2.5);
        assert_eq!(rows(&mut session), heard[25]);
        session.seek(1.5);
        assert_eq!(rows(&mut session), heard[15]);
        session.reset();
        assert_eq!(rows(&mut session), heard[0]);
        runs.push(heard);
    }
    assert_eq!(runs[0], runs[1]);
}

#[test]
fn a_paused_or_silent_sound_runs_nothing() {
    let project = project(&[40]);
    let mut session = Project::open_with(options(&project));
    rows(&mut session);
    let stands_still = |session: &mut Session| {
        let before = session.device().submitted();
        for _ in 0..3 {
            session.frame().unwrap();
        }
        session.wait().unwrap();
        session.device().submitted() == before
    };
    assert!(stands_still(&mut session), "silence after silence");
    session.seek(1.5);
    rows(&mut session);
    assert!(!stands_still(&mut session), "it plays");
    session.pause(true);
    rows(&mut session);
    assert!(stands_still(&mut session), "the clock stands still");
}

#[test]
fn another_sound_and_other_texels_are_taken_over() {
    let project = project(&[40]);
    let mut session = Project::open_with(options(&project));
    session.seek(1.5);
    let quiet = rows(&mut session)[0][40];
    write_wav(&project.path("tone.wav"), &samples(&[137]));
    let events = session.wait_reload(Duration::from_secs(60));
    assert!(events.iter().any(|event| matches!(event, ReloadEvent::Reloaded(_))), "{events:?}");
    session.seek(1.5);
    assert_eq!(loudest(&rows(&mut session)[0]), 137);
    assert_eq!(session.read_texels("sound", 0, 0, 0).unwrap().format.name(), "r16f");
    project.write("graphs/sound.toml", GRAPH.replace(".wav\"", ".wav\"\nformat = \"r32f\"\nmips = 2"));
    session.wait_reload(Duration::from_secs(60));
    session.seek(1.5);
    session.frame().unwrap();
    let texels = session.read_texels("sound", 0, 0, 0).unwrap();
    assert_eq!(texels.format.name(), "r32f");
    assert!((texels.floats()[137][0] - quiet).abs() < 0.01, "both tones are equally loud");
    let mean = session.read_texels("sound", 0, 1, 0).unwrap().floats()[68][0];
    assert!(mean > 0.2, "{mean}");
}

#[test]
fn what_is_no_sound_is_an_error_at_its_source() {
    let written = project(&[]);
    std::fs::write(written.path("tone.wav"), b"no sound at all").unwrap();
    let silent = project(&[]);
    write_wav(&silent.path("tone.wav"), &[]);
    let listed = project(&[]);
    std::fs::rename(listed.path("tone.wav"), listed.path("other.wav")).unwrap();
    std::fs::write(listed.path("tone.wav"), b"ffconcat version 1.0\nfile other.wav\n").unwrap();
    let coloured = project(&[40]);
    coloured.write("graphs/sound.toml", GRAPH.replace(".wav\"", ".wav\"\nencoding = \"srgb\""));
    let gone = project(&[]);
    std::fs::remove_file(gone.path("tone.wav")).unwrap();
    for (project, wrong, at) in [
        (written, "`tone.wav` cannot be read: ffprobe says:", "\"file.tone.wav\""),
        (silent, "`tone.wav` cannot be read: ", "\"file.tone.wav\""),
        (listed, "`tone.wav` cannot be read: ffprobe says:", "\"file.tone.wav\""),
        (coloured, "`tone.wav` is a sound, and holds no colours", "\"srgb\""),
        (gone, "`tone.wav` does not exist", "\"file.tone.wav\""),
    ] {
        let error = Session::open(options(&project)).err().expect("it does not open");
        let OpenError::Project { diagnostics, texts } = error else { panic!("{error}") };
        assert!(diagnostics[0].message.starts_with(wrong), "{wrong}: {}", diagnostics[0].message);
        let span = &diagnostics[0].labels[0].span;
        assert_eq!(&texts.get(&span.file).unwrap()[span.range.clone()], at);
    }
}
