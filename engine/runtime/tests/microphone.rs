//! The microphone as a target: what a device captures, what a file has in its place, and takes that give the same bytes again.
#![allow(missing_docs, clippy::cast_possible_truncation, clippy::float_cmp, reason = "a test")]

mod project;

use std::path::Path;
use std::time::Duration;

use project::{Project, Sessions, assert_silent, box_world, write_wav};
use raxel_runtime::inputs::Feed;
use raxel_runtime::reload::ReloadEvent;
use raxel_runtime::take::Ended;
use raxel_runtime::{OpenError, Options, Session};

/// Two targets of one microphone: the first is shown with a moving trace of the last frame.
const GRAPH: &str = include_str!("fixtures/microphone/microphone.toml");

/// Each texel of the sound, a little of what the last frame had, of the other target's mips, and of mouse and gamepad.
const SHADER: &str = include_str!("fixtures/microphone/show.comp");

/// Samples of a frame.
const STEP: usize = 960;

fn project() -> Project {
    let project = Project::filled();
    project.write("graphs/microphone.toml", GRAPH);
    project.write("shaders/show.comp", SHADER);
    project.write("worlds/box.toml", box_world(4));
    project
}

fn options(project: &Project) -> Options {
    Options {
        graph: Some("graphs/microphone.toml".into()),
        world: Some("worlds/box.toml".into()),
        step: Some(1.0 / 50.0),
        size: [512, 2],
        ..project.options()
    }
}

fn open_demo(project: &Project, path: &str) -> Session {
    Project::open_with(Options { graph: None, world: None, demo: Some(Path::new(path).to_owned()), ..options(project) })
}

fn bytes(session: &mut Session) -> Vec<u8> {
    session.frame().unwrap_or_else(|error| panic!("{error}"));
    session.read_target("color").unwrap().bytes
}

/// Spectrum and waveform of the next frame.
fn rows(session: &mut Session) -> [Vec<f32>; 2] {
    session.frame().unwrap_or_else(|error| panic!("{error}"));
    let texels: Vec<f32> =
        session.read_texels("exact", 0, 0, 0).unwrap().floats().iter().map(|texel| texel[0]).collect();
    let (spectrum, waveform) = texels.split_at(512);
    [spectrum.to_vec(), waveform.to_vec()]
}

fn is_silent([spectrum, waveform]: &[Vec<f32>; 2]) -> bool {
    spectrum.iter().all(|value| *value == 0.0) && waveform.iter().all(|value| *value == 0.5)
}

/// A tone that lies on a texel of the spectrum, at a sample.
fn tone(texel: usize, at: usize) -> f64 {
    0.25 * (std::f64::consts::TAU * texel as f64 * at as f64 / 2048.0).sin()
}

/// Captures a frame of a tone at 48,000 samples a second.
fn capture(feed: &mut Feed, texel: usize, frame: usize) {
    let samples = (STEP * frame..STEP * (frame + 1)).map(|at| tone(texel, at) as f32);
    feed.hear(&samples.collect::<Vec<_>>());
}

#[test]
fn without_a_device_it_is_silent_and_runs_nothing() {
    let project = project();
    let still = GRAPH.replace("history = 1\n", "").replace("before = \"color@1\", ", "");
    project.write("graphs/microphone.toml", still);
    let still = SHADER.replace("layout(r32f) uniform readonly image2D before;\n", "");
    project.write("shaders/show.comp", still.replace(" + 0.125 * imageLoad(before, at).x", ""));
    let mut session = Project::open_with(options(&project));
    assert!(session.hears_microphone() && session.wants_capture());
    assert!(is_silent(&rows(&mut session)));
    let before = session.device().submitted();
    for _ in 0..3 {
        session.frame().unwrap();
    }
    session.wait().unwrap();
    assert_eq!(session.device().submitted(), before, "silence after silence");
    session.seek(80_000.0);
    assert!(is_silent(&rows(&mut session)));
    assert_silent(&session);
}

#[test]
fn a_frame_hears_what_was_captured() {
    let project = project();
    let mut session = Project::open_with(options(&project));
    let mut feed = session.microphone().line().feed(48_000, 1).unwrap();
    rows(&mut session);
    for frame in 0..20 {
        capture(&mut feed, 40, frame);
        let [spectrum, waveform] = rows(&mut session);
        if frame > 3 {
            let loudest = (0..512).max_by(|a, b| spectrum[*a].total_cmp(&spectrum[*b])).unwrap();
            assert_eq!(loudest, 40, "frame {frame}");
        }
        for (at, value) in waveform.iter().enumerate() {
            let expected = 0.5 + 0.5 * tone(40, STEP * (frame + 1) + at - 512);
            assert!((f64::from(*value) - expected).abs() < 1e-4, "frame {frame}, {at}: {value} {expected}");
        }
    }
    // The device stalls: silence, which no frame waits for.
    let [_, waveform] = rows(&mut session);
    assert!(waveform.iter().all(|value| *value == 0.5));
    for seconds in [1.0, 2.0, 3.0] {
        session.seek(seconds);
        assert!(is_silent(&rows(&mut session)));
    }
    assert!(session.microphone().is_stuck());
    session.seek(80_000.0);
    assert!(is_silent(&rows(&mut session)));
    assert_silent(&session);
}

/// Does something else in each frame: mouse and gamepad, and a device that comes, stalls, gives what is no number, goes, and comes back as
/// another one.
fn play(session: &mut Session, feed: &mut Option<Feed>, frame: usize) {
    match frame {
        2 => *feed = Some(session.microphone().line().feed(44_100, 2).unwrap()),
        17 => *feed = None,
        21 => *feed = Some(session.microphone().line().feed(192_000, 8).unwrap()),
        _ => {}
    }
    session.set_cursor(Some([i32::try_from(frame).unwrap(), 1]));
    session.inputs().hold_buttons(u32::from(frame % 11 > 5));
    session.inputs().hold_gamepad_buttons(1 << (frame % 5));
    let axis = f64::from((0.1 * frame as f32).sin());
    session.inputs().set_gamepad_sticks([axis, 0.0, 0.0, -axis]);
    let Some(feed) = feed else { return };
    let (rate, channels) = if frame < 17 { (882, 2) } else { (3840, 8) };
    let samples = (0..rate * channels).map(|at| {
        let turn = (frame * rate + at / channels) as f32 / rate as f32;
        if frame == 9 && at % 7 == 0 { f32::NAN } else { 0.3 * (140.0 * turn).sin() + 0.05 * (at % channels) as f32 }
    });
    match frame {
        // It stalls, and then gives the samples that it kept.
        5 | 6 => {}
        7 => (0..3).for_each(|_| feed.hear(&samples.clone().collect::<Vec<_>>())),
        _ => feed.hear(&samples.collect::<Vec<_>>()),
    }
}

#[test]
fn a_take_gives_the_same_bytes() {
    let project = project();
    let mut session = Project::open_with(options(&project));
    // Samples before it are not part of it.
    let mut before = session.microphone().line().feed(48_000, 1).unwrap();
    for frame in 0..4 {
        capture(&mut before, 100, frame);
        bytes(&mut session);
    }
    drop(before);
    session.record().unwrap();
    let mut feed = None;
    let played: Vec<Vec<u8>> = (0..32)
        .map(|frame| {
            play(&mut session, &mut feed, frame);
            bytes(&mut session)
        })
        .collect();
    assert!(played.windows(2).filter(|pair| pair[0] != pair[1]).count() > 25, "it sounds");
    let take = session.take("a-take").unwrap();
    session.stop_recording();
    assert_eq!(take.ended, None);
    assert!(take.text.contains("\nmicrophone = \"a-take.wav\"\n"), "{}", take.text);
    assert_silent(&session);

    project.write("worlds/a-take.demo.toml", &take.text);
    write_wav(&project.path("worlds/a-take.wav"), &take.sound.unwrap());
    let mut again = open_demo(&project, "worlds/a-take.demo.toml");
    assert!(again.hears_microphone() && !again.wants_capture());
    // A device of the window is not heard over it.
    let mut other = again.microphone().line().feed(48_000, 1).unwrap();
    for (frame, played) in played.iter().enumerate() {
        capture(&mut other, 7, frame);
        assert!(bytes(&mut again) == *played, "frame {frame}");
    }
    // A frame hears the same, whichever was before.
    let row = |session: &mut Session| rows(session);
    again.seek(0.4);
    let there = row(&mut again);
    again.reset();
    assert!(is_silent(&row(&mut again)));
    again.seek(0.4);
    assert_eq!(row(&mut again), there);
    // After its end is silence.
    again.seek(100.0);
    row(&mut again);
    assert_silent(&again);

    // A take of a take is that take.
    again.record().unwrap();
    for _ in 0..32 {
        bytes(&mut again);
    }
    let once_more = again.take("b").unwrap();
    assert_eq!(once_more.sound.map(|sound| sound.len()), Some(31 * STEP));
    assert_eq!(once_more.ended, None);
}

#[test]
fn a_take_that_heard_nothing_has_no_sound() {
    let project = project();
    let mut session = Project::open_with(options(&project));
    session.record().unwrap();
    bytes(&mut session);
    bytes(&mut session);
    let take = session.take("take").unwrap();
    assert_eq!(take.sound, None);
    assert!(!take.text.contains("microphone ="), "{}", take.text);
}

#[test]
fn a_file_is_heard_in_place_of_a_device() {
    let project = project();
    let samples: Vec<i16> = (0..48_000).map(|at| (32_767.0 * tone(40, at)).round() as i16).collect();
    write_wav(&project.path("tone.wav"), &samples);
    let mut session = Project::open_with(options(&project));
    let mut feed = session.microphone().line().feed(48_000, 1).unwrap();
    session.give_sound(Some("tone.wav")).unwrap();
    assert!(!session.wants_capture());
    session.seek(0.5);
    feed.hear(&vec![1.0; 4800]);
    let [_, waveform] = rows(&mut session);
    for (at, value) in waveform.iter().enumerate() {
        let expected = 0.5 + 0.5 * tone(40, 24_000 + at - 512);
        assert!((f64::from(*value) - expected).abs() < 1e-4, "{at}: {value} {expected}");
    }
    session.seek(3.0);
    assert!(is_silent(&rows(&mut session)), "it does not begin again");
    // It is refused, and nothing has changed.
    std::fs::write(project.path("no.wav"), b"no sound at all").unwrap();
    for (path, why) in [
        ("gone.wav", "`gone.wav` does not exist"),
        ("no.wav", "`no.wav` cannot be read: ffprobe says:"),
        ("../a.wav", "`../a.wav` is not a path inside the project"),
    ] {
        let error = session.give_sound(Some(path)).unwrap_err();
        assert!(error.starts_with(why), "{error}");
        assert_eq!(session.microphone().given().unwrap().path, "tone.wav");
    }
    // Another sound ends a take.
    session.record().unwrap();
    bytes(&mut session);
    bytes(&mut session);
    session.give_sound(None).unwrap();
    bytes(&mut session);
    let take = session.take("take").unwrap();
    assert_eq!((take.ended, take.sound), (Some(Ended::OtherSound), Some(samples[..STEP].to_vec())));
}

const DEMO: &str = r#"world = "box.toml"
graph = "microphone.toml"
duration = 1.0
size = [512, 2]
[inputs]
microphone = "../tone.wav"
"#;

#[test]
fn a_saved_sound_of_a_demo_is_taken_over() {
    let project = project();
    let level = |level: i16| write_wav(&project.path("tone.wav"), &vec![level; 48_000]);
    level(16_384);
    project.write("worlds/a.demo.toml", DEMO);
    let mut session = Project::open_with(Options {
        watch: true,
        graph: None,
        world: None,
        demo: Some("worlds/a.demo.toml".into()),
        ..options(&project)
    });
    session.seek(0.5);
    assert_eq!(rows(&mut session)[1], [0.75; 512]);
    level(-16_384);
    let events = session.wait_reload(Duration::from_secs(60));
    assert!(events.iter().any(|event| matches!(event, ReloadEvent::Reloaded(_))), "{events:?}");
    session.seek(0.5);
    assert_eq!(rows(&mut session)[1], [0.25; 512]);
    assert_silent(&session);
}

fn mistakes(options: Options) -> (String, String) {
    let error = Session::open(options).err().expect("it does not open");
    let OpenError::Project { diagnostics, texts } = error else { panic!("{error}") };
    let span = &diagnostics[0].labels[0].span;
    (diagnostics[0].message.clone(), texts.get(&span.file).unwrap()[span.range.clone()].to_owned())
}

#[test]
fn what_a_demo_cannot_hear_is_an_error_at_its_name() {
    let project = project();
    project.write("worlds/a.demo.toml", DEMO);
    let demo = || Options { graph: None, world: None, demo: Some("worlds/a.demo.toml".into()), ..options(&project) };
    assert_eq!(mistakes(demo()), ("`tone.wav` does not exist".to_owned(), "\"../tone.wav\"".to_owned()));
    std::fs::write(project.path("tone.wav"), b"no sound at all").unwrap();
    let (message, at) = mistakes(demo());
    assert!(message.starts_with("`tone.wav` cannot be read: ffprobe says:") && at == "\"../tone.wav\"", "{message}");
}

#[test]
fn what_the_microphone_does_not_give_is_an_error_at_its_key() {
    let sound = "source = \"input.microphone\"\n\n[targets.exact]";
    for (more, wrong, at) in [
        ("encoding = \"srgb\"", "`input.microphone` is a sound, and holds no colours", "\"srgb\""),
        ("format = \"rgba8\"", "`input.microphone` has 1 channel of 32 bits, which `rgba8` does not fit", "\"rgba8\""),
        ("size = [4, 4]", "`source` and `size` exclude each other: the source gives the size and the contents", "size"),
        ("init = 0", "`source` and `init` exclude each other: the source gives the size and the contents", "init"),
    ] {
        let project = project();
        project.write(
            "graphs/microphone.toml",
            GRAPH.replace(sound, &format!("source = \"input.microphone\"\n{more}\n\n[targets.exact]")),
        );
        let (message, place) = mistakes(options(&project));
        assert_eq!((message.as_str(), place.as_str()), (wrong, at));
    }
    let project = project();
    project.write("graphs/microphone.toml", format!("{GRAPH}\n[buffers.sound2]\nsource = \"input.microphone\"\n"));
    let (message, place) = mistakes(options(&project));
    assert_eq!(message, "`input.microphone` supplies an image and no buffer");
    assert_eq!(place, "\"input.microphone\"");
    // A misspelt one is recognized.
    project.write("graphs/microphone.toml", GRAPH.replacen("input.microphone", "input.microfone", 1));
    assert_eq!(mistakes(options(&project)).0, "there is no source of images `input.microfone`");
}
