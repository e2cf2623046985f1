//! The files that `-o` leaves behind when something goes wrong: nothing that is half made, and no exit code 0.

#![cfg(unix)]

mod common;

use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use common::{FullDisk, Project, Run, RunRaxel, Running, command, output, raxel};

/// A picture of the shipped graph that needs no big world.
const MENGER: [&str; 6] = ["render", "graphs/inspect.toml", "--world", "worlds/menger.toml", "--size", "96x54"];

/// Names in a folder, in order.
fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// The same command where no file may become larger than 32 KiB.
fn with_small_files(arguments: &[&str]) -> Run {
    let mut raxel = command(common::repository(), arguments);
    output(FullDisk::with_room(32 << 10).under(&mut raxel).env("RAXEL_CACHE", "off")).into()
}

#[test]
fn a_film_that_does_not_fit_is_no_film() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.mkv", "a.webm", "a.mp4", "a.mov", "a.gif"] {
        let path = folder.path().join(name);
        let demo = ["render", "worlds/valley.demo.toml", "--size", "320x180", "--frames", "60", "-o"];
        let run = with_small_files(&[&demo[..], &[path.to_str().unwrap()]].concat()).exits(2);
        assert!(
            run.stderr.contains("error: ffmpeg gave up: ") && run.stderr.contains("No space left on device"),
            "{}",
            run.stderr
        );
        assert_eq!(names(folder.path()), [""; 0], "{name}");
    }
}

/// An ffmpeg that ends while frames are written to it.
#[test]
fn the_frames_of_a_film_are_kept_when_ffmpeg_ends() {
    use std::os::unix::fs::PermissionsExt;
    let project = Project::shipped();
    project.write("bin/ffmpeg", "#!/bin/sh\nhead -c 30000 > /dev/null\necho 'no more' >&2\nexit 1\n");
    fs::set_permissions(project.path("bin/ffmpeg"), fs::Permissions::from_mode(0o755)).unwrap();
    let demo = ["render", "worlds/valley.demo.toml", "--size", "32x18", "--frames", "40", "-o"];
    let path = std::env::var("PATH").unwrap_or_default();
    // An earlier film had more frames than this one.
    project.write("film.frames/00041.png", "old");
    project.write("film.frames/notes.txt", "mine");
    let mut raxel = command(project.root(), &[&demo[..], &["film.mp4"]].concat());
    let run = Run::from(output(raxel.env("PATH", format!("{}:{path}", project.path("bin").display())))).exits(2);
    assert!(run.stderr.contains("error: ffmpeg gave up: no more"), "{}", run.stderr);
    assert!(run.stderr.contains("raxel film 'film.frames/%05d.png' --fps 30 -o film.mp4"), "{}", run.stderr);
    assert!(!project.path("film.mp4").exists());
    project.raxel(&[&demo[..], &["frames/%05d.png"]].concat()).exits(0);
    for frame in 0..40 {
        let [kept, other] = ["film.frames", "frames"].map(|folder| project.path(&format!("{folder}/{frame:05}.png")));
        assert!(fs::read(kept).unwrap() == fs::read(other).unwrap(), "frame {frame}");
    }
    assert!(!project.path("film.frames/00041.png").exists() && project.path("film.frames/notes.txt").exists());
}

/// raxel renders frames again only if ffmpeg fails.
#[test]
fn a_film_that_cannot_be_put_in_its_place_is_not_rendered_again() {
    use std::os::unix::fs::PermissionsExt;
    let project = Project::shipped();
    project.write("bin/ffmpeg", "#!/bin/sh\ncat > /dev/null\nmkdir -p film.mp4/full\n");
    fs::set_permissions(project.path("bin/ffmpeg"), fs::Permissions::from_mode(0o755)).unwrap();
    let path = std::env::var("PATH").unwrap_or_default();
    let demo = ["render", "worlds/valley.demo.toml", "--size", "32x18", "--frames", "3", "-o", "film.mp4"];
    let mut raxel = command(project.root(), &demo);
    let run = Run::from(output(raxel.env("PATH", format!("{}:{path}", project.path("bin").display())))).exits(2);
    assert!(run.stderr.contains("film.mp4` cannot be written"), "{}", run.stderr);
    assert!(!run.stderr.contains("its frames") && !project.path("film.frames").exists(), "{}", run.stderr);
}

#[test]
fn a_picture_that_does_not_fit_is_no_picture() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let picture = ["render", "graphs/inspect.toml", "--world", "worlds/menger.toml", "--size", "640x360", "-o"];
    let run = with_small_files(&[&picture[..], &[path.to_str().unwrap()]].concat()).exits(2);
    assert!(run.stderr.contains("a.exr` cannot be written: No space left on device"), "{}", run.stderr);
    assert_eq!(names(folder.path()), [""; 0]);
}

/// Ends a render that would take hours while its outputs are being made, and gives the signal that it died of.
fn stopped_by(signal: &str, project: &Project, to: &str) -> Option<i32> {
    let folder = project.path("out");
    fs::create_dir(&folder).unwrap();
    // A graph that looks back: of others only the frames that are written are computed.
    let keeping = ["render", "graphs/examples/keep.toml", "--world", "worlds/menger.toml", "--size", "64x36"];
    let arguments = [&keeping[..], &["--frames", "10000000", "-o", to]].concat();
    // Tests that run under `nohup` inherit that HUP is ignored; here it must not be.
    let mut raxel = Command::new("env");
    raxel.arg("--default-signal=HUP,INT,TERM").arg(env!("CARGO_BIN_EXE_raxel")).args(arguments);
    raxel.env("RAXEL_CACHE", "off").current_dir(project.root()).stdin(Stdio::null()).stderr(Stdio::null());
    let mut child = Running::start(&mut raxel);
    let start = Instant::now();
    while names(&folder).is_empty() {
        assert!(!child.ended() && start.elapsed() < Duration::from_secs(60), "nothing is being made");
        std::thread::sleep(Duration::from_millis(5));
    }
    // Long enough for ffmpeg to have opened its file.
    std::thread::sleep(Duration::from_millis(300));
    child.signal(signal);
    let status = child.finish();
    assert_eq!(names(&folder), [""; 0], "{signal} leaves something of {to}");
    fs::remove_dir(&folder).unwrap();
    status.signal()
}

#[test]
fn signals_leave_nothing_half_made() {
    let project = Project::shipped();
    for (signal, number) in [("INT", 2), ("TERM", 15), ("HUP", 1)] {
        assert_eq!(stopped_by(signal, &project, "out/a.png"), Some(number));
    }
    for to in ["out/a.mp4", "out/a.webm"] {
        assert_eq!(stopped_by("TERM", &project, to), Some(15));
    }
}

/// `raxel bench reload` edits a copy of the project among the system's temporary files.
#[test]
fn a_signal_removes_the_copy_that_a_bench_edits() {
    let project = Project::shipped();
    let temporary = tempfile::tempdir().unwrap();
    let arguments = ["bench", "reload", "graphs/inspect.toml", "--world", "worlds/menger.toml", "--edits", "10000"];
    let mut child = Running::start(
        command(project.root(), &arguments).env("TMPDIR", temporary.path()).stdout(Stdio::null()).stderr(Stdio::null()),
    );
    let start = Instant::now();
    while names(temporary.path()).is_empty() {
        assert!(!child.ended() && start.elapsed() < Duration::from_secs(60), "there is no copy");
        std::thread::sleep(Duration::from_millis(5));
    }
    std::thread::sleep(Duration::from_millis(500));
    child.signal("TERM");
    assert_eq!(child.finish().signal(), Some(15));
    let copies: Vec<String> = names(temporary.path()).into_iter().filter(|name| name.starts_with("raxel-")).collect();
    assert_eq!(copies, [""; 0]);
}

/// `nohup` means it.
#[test]
fn a_signal_that_is_ignored_stays_ignored() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    let mut shell = Command::new("sh");
    let script = "trap '' HUP; \"$0\" \"$@\" & child=$!; sleep 1; kill -s HUP $child; wait $child";
    let arguments = [&MENGER[..], &["--frames", "300", "-o", path.to_str().unwrap()]].concat();
    shell.args(["-c", script, env!("CARGO_BIN_EXE_raxel")]).args(arguments).current_dir(common::repository());
    shell.env("RAXEL_CACHE", "off");
    Run::from(output(&mut shell)).exits(0);
    assert!(path.is_file());
}

#[test]
fn a_pipe_that_nobody_reads_is_not_waited_for_and_one_that_is_read_works() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("a.png");
    assert!(output(Command::new("mkfifo").arg(&pipe)).status.success());
    let arguments = [&MENGER[..], &["-o", pipe.to_str().unwrap()]].concat();
    let run = raxel(&arguments).exits(2);
    assert!(run.stderr.contains("it is a pipe without a reader"), "{}", run.stderr);

    // The reader opens its end first, for it waits for a writer.
    let reader = std::thread::spawn({
        let pipe = pipe.clone();
        move || output(Command::new("timeout").args(["300", "cat"]).arg(pipe)).stdout
    });
    std::thread::sleep(Duration::from_millis(300));
    raxel(&arguments).exits(0);
    let picture = image::load_from_memory(&reader.join().unwrap()).unwrap();
    assert_eq!((picture.width(), picture.height()), (96, 54));
}

#[test]
#[cfg(target_os = "linux")]
fn the_reason_is_the_right_one() {
    let folder = tempfile::tempdir().unwrap();
    let inside = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    fs::create_dir(inside("d.png")).unwrap();
    std::os::unix::fs::symlink("/dev/full", inside("full.png")).unwrap();
    for (to, reason) in [
        ("/proc/a.png".to_owned(), "no file can be made in `/proc`"),
        (inside("o.png/"), "is a folder, and its name is that of a file"),
        (inside("d.png"), "is a folder, and its name is that of a file"),
        (inside("full.png"), "No space left on device"),
    ] {
        let run = raxel(&[&MENGER[..], &["-o", &to]].concat()).exits(2);
        assert!(run.stderr.contains(reason), "{to}: {}", run.stderr);
    }
    assert_eq!(names(folder.path()), ["d.png", "full.png"]);
    assert_eq!(names(&folder.path().join("d.png")), [""; 0]);
}

#[test]
fn refusals_leave_no_folder() {
    let project = Project::shipped();
    let before = project.files();
    for (arguments, code) in [
        (&["render", "graphs/none.toml", "-o", "new/frames/%04d.png"][..], 3),
        (&["bench", "no_such_graph", "-o", "new/bench"], 3),
        (&["bench", "--worlds", "no_such_world", "--export", "new/export"], 3),
        (&["stress", "--world", "worlds/none.toml", "-o", "new/stress"], 3),
    ] {
        project.raxel(arguments).exits(code);
        assert!(!project.path("new").exists(), "{arguments:?}");
    }
    assert_eq!(project.files(), before);
}

/// raxel writes a new project whole, or not at all.
#[test]
fn half_a_project_does_not_stay() {
    let folder = tempfile::tempdir().unwrap();
    let mut raxel = command(folder.path(), &["new", "a/b/voxels"]);
    let run = Run::from(output(FullDisk::with_room(8 << 10).under(&mut raxel))).exits(2);
    assert!(run.stderr.contains("cannot be written: No space left on device"), "{}", run.stderr);
    assert_eq!(names(folder.path()), [""; 0]);
}

/// An EXR has the extent of the target, and so has the message about it; signed integers keep all their bits.
#[test]
fn an_exr_of_signed_integers_far_from_the_origin() {
    let project = Project::empty();
    let graph = include_str!("fixtures/output/integers.toml");
    let shader = r"#version 460
layout(local_size_x = 8) in;
layout(r32i) writeonly uniform iimage2D cells;
void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
if (p.x < 5) imageStore(cells, p, ivec4(-16777217 - 1000000007 * p.x + p.y));
}
";
    project.write("graphs/i.toml", graph).write("shaders/p.comp", shader);
    let run = project.raxel(&["render", "-o", "i.exr", "--size", "64x36", "--format", "json"]).exits(0);
    assert_eq!(run.json()[0]["size"], serde_json::json!([5, 3]));
    let run = project.raxel(&["render", "-o", "i.exr", "--size", "64x36"]).exits(0);
    assert!(run.stderr.contains("(5×3, "), "{}", run.stderr);
    let image = exr::prelude::read_first_flat_layer_from_file(project.path("i.exr")).unwrap();
    let exr::prelude::FlatSamples::U32(found) = &image.layer_data.channel_data.list[0].sample_data else {
        panic!("no integers")
    };
    let expected = |i: i32| (-16_777_217i32).wrapping_sub(1_000_000_007i32.wrapping_mul(i % 5)) + i / 5;
    assert!(found.iter().map(|v| v.cast_signed()).eq((0..15).map(expected)), "{found:?}");
}
