//! A full disk, a folder that takes no files, and clocks that were set back. In place of a full disk, a library before libc refuses to write to
//! files. Memory that a driver keeps in files without a name stays.
#![cfg(target_os = "linux")]

mod common;

use std::fs;
use std::time::{Duration, SystemTime};

use common::{FullDisk, Project, Run, RunRaxel, command, output};

/// The verbs that write, and the path that the message names.
const WRITERS: &[(&[&str], &str)] = &[
    (&["render", "-o", "a.png"], "a.png"),
    (&["render", "-o", "a.jpg"], "a.jpg"),
    (&["render", "-o", "a.exr"], "a.exr"),
    (&["render", "-o", "frames/%02d.png", "--frames", "2"], "frames/00.png"),
    (&["world", "export", "worlds/box.toml", "-o", "a.vox"], "a.vox"),
    (&["shaders", "-o", "spv"], "spv"),
    (&["schema"], ".raxel"),
    (&["new", "made"], "made"),
    (&["stress", "--world", "worlds/box.toml", "--rays", "200", "--layouts", "tree64", "-o", "a.csv"], "a.csv"),
    (&["stress", "--world", "worlds/box.toml", "--rays", "200", "--layouts", "tree64", "-o", "a.json"], "a.json"),
];

fn project() -> Project {
    let project = Project::empty();
    project.write("graphs/fill.toml", include_str!("fixtures/disk_full/fill.toml"));
    project.write(
        "shaders/fill.comp",
        r"#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f) uniform writeonly image2D dst;
void main() { imageStore(dst, ivec2(gl_GlobalInvocationID.xy), vec4(0.25)); }
",
    );
    project.write(
        "worlds/box.toml",
        r##"name = "box"
[materials]
red = { albedo = "#ff0000" }
[[build]]
op = "box"
min = [0, 0, 0]
max = [4, 4, 4]
material = "red"
"##,
    );
    project.write("raxel.toml", "graph = \"fill.toml\"\nworld = \"box.toml\"\nsize = [32, 32]\n");
    project
}

fn on_a_full_disk(project: &Project, arguments: &[&str]) -> Run {
    output(FullDisk::with_room(0).under(&mut command(project.root(), arguments)).env("RAXEL_CACHE", "off")).into()
}

#[test]
fn a_full_disk_is_said_with_the_path_and_leaves_nothing_half_written() {
    for (arguments, path) in WRITERS {
        let project = project();
        let before = project.files();
        let run = on_a_full_disk(&project, arguments);
        assert_eq!(run.code, 2, "{arguments:?}\n{}", run.stderr);
        assert!(run.stderr.contains(path) && run.stderr.contains("cannot be written"), "{arguments:?}\n{}", run.stderr);
        assert!(run.stderr.contains("No space left on device"), "{arguments:?}: the reason\n{}", run.stderr);
        assert_eq!(project.files(), before, "{arguments:?}");
        // With room it works.
        project.raxel(arguments).exits(0);
    }
}

#[test]
fn a_full_disk_leaves_what_was_there() {
    for (arguments, path) in WRITERS.iter().filter(|(_, path)| path.starts_with("a.")) {
        let project = project();
        project.write(path, "old");
        let run = on_a_full_disk(&project, arguments).exits(2);
        assert!(run.stderr.contains("cannot be written"), "{}", run.stderr);
        assert_eq!(fs::read(project.path(path)).unwrap(), b"old", "{arguments:?}");
    }
}

#[test]
fn a_cache_on_a_full_disk_is_no_reason_to_stop() {
    let project = project();
    let cache = project.path("cache");
    let picture = |full: Option<&FullDisk>| {
        // The picture goes to a pipe, so that only the cache meets the full disk.
        let mut command = command(project.root(), &["render", "-o", "-"]);
        if let Some(full) = full {
            full.under(&mut command);
        }
        let run = output(command.env("RAXEL_CACHE", &cache));
        assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
        run.stdout
    };
    let without_room = picture(Some(&FullDisk::with_room(0)));
    assert!(!without_room.is_empty());
    // Twice: what the full disk has left behind is not taken for a shader.
    assert!(picture(None) == without_room && picture(None) == without_room);
}

#[test]
fn a_folder_that_takes_no_files_is_named() {
    let project = project();
    project.write("file", "");
    for place in ["/proc/a.png", "file/a.png"] {
        let run = project.raxel(&["render", "-o", place]).exits(2);
        assert!(run.stderr.contains(place) && run.stderr.contains("cannot be written"), "{}", run.stderr);
    }
}

#[test]
fn a_clock_that_was_set_back_changes_no_picture() {
    let project = project();
    let cache = project.path("cache");
    let picture = |file: &str| {
        let mut command = command(project.root(), &["render", "-o", file]);
        Run::from(output(command.env("RAXEL_CACHE", &cache))).exits(0);
        fs::read(project.path(file)).unwrap()
    };
    let first = picture("a.png");
    let years = Duration::from_secs(40 * 365 * 86_400);
    for times in [SystemTime::now() + years, SystemTime::now() - years] {
        for entry in fs::read_dir(&cache).unwrap().flatten().filter(|entry| entry.path().is_file()) {
            fs::File::options().write(true).open(entry.path()).unwrap().set_modified(times).unwrap();
        }
        assert_eq!(picture("b.png"), first);
        // A file that is newer than its date says.
        let text = fs::read_to_string(project.path("shaders/fill.comp")).unwrap();
        project.write("shaders/fill.comp", text.replace("0.25", "0.75"));
        fs::File::options().write(true).open(project.path("shaders/fill.comp")).unwrap().set_modified(times).unwrap();
        assert_ne!(picture("c.png"), first);
        project.write("shaders/fill.comp", text);
    }
}
