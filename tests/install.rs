//! raxel away from its repository: the binary alone, the archive and the package of a release, as a new user has them.

#![cfg(unix)]

mod common;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use common::{Run, output, repository};

/// A user without a file, a cache or a display.
struct User {
    home: tempfile::TempDir,
    binary: PathBuf,
}

impl User {
    fn with(binary: impl Into<PathBuf>) -> Self {
        let home = tempfile::tempdir().unwrap();
        fs::create_dir(home.path().join("here")).unwrap();
        Self { home, binary: binary.into() }
    }

    fn path(&self, path: &str) -> PathBuf {
        self.home.path().join(path)
    }

    fn command(&self, folder: &Path, arguments: &[&str]) -> Command {
        let mut command = Command::new(&self.binary);
        command.args(arguments).current_dir(folder).stdin(Stdio::null()).env("HOME", self.home.path());
        command.env("NO_COLOR", "1").env("XDG_CACHE_HOME", self.path(".cache"));
        for name in ["DISPLAY", "WAYLAND_DISPLAY", "RAXEL_CACHE", "RAXEL_HOME", "CLICOLOR_FORCE", "RUST_BACKTRACE"] {
            command.env_remove(name);
        }
        command
    }

    fn raxel_in(&self, folder: &Path, arguments: &[&str]) -> Run {
        output(&mut self.command(folder, arguments)).into()
    }

    /// Runs a verb that renders.
    fn renders_in(&self, folder: &Path, arguments: &[&str]) -> Run {
        self.raxel_in(folder, &[arguments, &PATIENT].concat())
    }

    /// Runs raxel in an empty folder, `here`.
    fn raxel(&self, arguments: &[&str]) -> Run {
        self.raxel_in(&self.path("here"), arguments)
    }

    /// Where `raxel demo` keeps its files.
    fn unpacked(&self) -> Option<PathBuf> {
        let entries = fs::read_dir(self.path(".cache/raxel")).ok()?;
        let name = |path: &PathBuf| path.file_name().unwrap().to_string_lossy().into_owned();
        entries.map(|entry| entry.unwrap().path()).find(|path| name(path).starts_with("shipped-"))
    }

    /// The first steps of a user who has just installed raxel.
    fn first_steps(&self) {
        let script = repository().join(".github/release/try");
        let run = Run::from(output(Command::new(script).arg(&self.binary).arg(self.path("steps")))).exits(0);
        assert!(!run.stdout.contains("BAD"), "{}", run.stdout);
        assert_shows_something(&self.path("steps/raxel-demo/dusk.png"), [64, 36]);
        assert_shows_something(&self.path("steps/own/p.png"), [64, 36]);
    }
}

/// On a machine that does much else, a frame of the software driver takes longer than the watchdog's own patience.
const PATIENT: [&str; 2] = ["--watchdog", "100"];

/// A picture of that size that is not of one colour.
#[track_caller]
fn assert_shows_something(path: &Path, size: [u32; 2]) {
    let picture = image::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display())).to_rgb8();
    assert_eq!([picture.width(), picture.height()], size);
    let first = *picture.get_pixel(0, 0);
    let others = picture.pixels().filter(|pixel| **pixel != first).count();
    assert!(others > picture.len() / 12, "{} is of one colour", path.display());
}

/// Whether `check` reports no mistake in any file.
fn all_ok(check: &Run) -> bool {
    !check.stderr.is_empty() && check.stderr.lines().all(|line| line.ends_with(": ok"))
}

fn binary() -> &'static str {
    env!("CARGO_BIN_EXE_raxel")
}

#[test]
fn the_demo_needs_no_project_no_network_and_no_display() {
    let user = User::with(binary());
    let run = user.renders_in(&user.path("here"), &["demo", "--size", "64x36", "--frames", "3", "--validate"]).exits(0);
    assert_shows_something(&user.path("here/raxel-demo/dusk.png"), [64, 36]);
    let film = user.path("here/raxel-demo/dusk.mp4");
    let frames = user.path("here/raxel-demo/dusk.frames");
    assert!(film.is_file() != frames.is_dir(), "a film, or its frames: {}", run.stderr);

    // Without ffmpeg on the path, its frames, and the command that makes the film of them.
    let mut without = user.command(&user.path("here"), &["demo", "--size=64x36", "--frames", "3", "--watchdog", "100"]);
    let run = Run::from(output(without.env("PATH", user.path("nothing")))).exits(0);
    assert!(run.stderr.contains("no film: ffmpeg is not installed; writing its frames instead"), "{}", run.stderr);
    let names: Vec<_> = (0..3).map(|n| frames.join(format!("{n:05}.png"))).collect();
    names.iter().for_each(|name| assert_shows_something(name, [64, 36]));
    let said = "where ffmpeg is: raxel film 'raxel-demo/dusk.frames/%05d.png' --fps 15 -o raxel-demo/dusk.mp4";
    let gpu = said.replace("--fps 15", "--fps 30");
    assert!(run.stderr.contains(said) || run.stderr.contains(&gpu), "{}", run.stderr);

    // A folder that somebody named, and another demo.
    let run = user.raxel(&["demo", "sponge", "--size", "64x36", "--frames", "1", "--no-window", "-o", "there/deep"]);
    run.exits(0);
    assert!(user.path("here/there/deep/sponge.png").is_file());
}

#[test]
fn the_demo_says_what_it_cannot_do_and_leaves_nothing() {
    let user = User::with(binary());
    let left = || fs::read_dir(user.path("here")).unwrap().count();
    let said = |arguments: &[&str], code| user.raxel(arguments).exits(code).stderr;
    assert!(said(&["demo", "duck"], 3).contains("did you mean `dusk`?"));
    assert!(said(&["demo", "nothing-like-it"], 3).contains("`valley`"));
    assert!(said(&["demo", "none.demo.toml"], 3).contains("there is no `none.demo.toml`"));
    assert!(said(&["demo", "-o", "a.png"], 2).contains("`raxel render DEMO -o FILE` writes one file"));
    assert!(said(&["demo", "--set", "nonsense=1", "--size", "64x36"], 2).contains("nonsense"));
    assert_eq!(left(), 0);
    fs::write(user.path("here/raxel-demo"), "a file of mine").unwrap();
    assert!(said(&["demo", "--size", "64x36"], 2).contains("`-o FOLDER` names another one"));
    assert_eq!(fs::read_to_string(user.path("here/raxel-demo")).unwrap(), "a file of mine");
}

/// A user can paste the commands of messages into a shell: in a folder with a space and letters beyond ASCII, in a locale other than UTF-8,
/// without a home.
#[test]
fn a_folder_of_any_name_does() {
    let user = User::with(binary());
    let folder = user.path("Mein Ördner");
    fs::create_dir(&folder).unwrap();
    let bare = |folder: &Path, arguments: &[&str]| -> Run {
        let mut command = user.command(folder, arguments);
        command.env_remove("HOME").env_remove("XDG_CACHE_HOME").env("LC_ALL", "C").env("PATH", "");
        output(&mut command).into()
    };
    let new = bare(&folder, &["new", "my voxels ü"]).exits(0);
    assert!(new.stderr.ends_with("; next: cd 'my voxels ü' && raxel run\n"), "{}", new.stderr);
    let project = folder.join("my voxels ü");
    bare(&project, &["check"]).exits(0);
    let render =
        bare(&project, &[&["render", "--size", "64x36", "-o", "ein bild ü.png"], &PATIENT[..]].concat()).exits(0);
    assert!(render.stderr.contains("ein bild ü.png (64×36"), "{}", render.stderr);
    assert_shows_something(&project.join("ein bild ü.png"), [64, 36]);
    // There is no ffmpeg: the frames of the film wait for one.
    let small = ["demo", "--no-window", "--size", "64x36", "--frames", "1", "-o", "so etwas"];
    let demo = bare(&folder, &[&small[..], &PATIENT[..]].concat()).exits(0);
    let film = "where ffmpeg is: raxel film 'so etwas/dusk.frames/%05d.png' --fps 15 -o 'so etwas/dusk.mp4'\n";
    assert!(demo.stderr.contains(film), "{}", demo.stderr);
    let run = bare(&project, &["run"]).exits(4);
    assert!(run.stderr.contains("needs no window"), "{}", run.stderr);
}

/// In a folder without write access, each verb that writes reports the error, and leaves nothing behind.
#[test]
fn a_folder_that_takes_no_files_is_no_riddle() {
    use std::os::unix::fs::PermissionsExt;
    // Nothing is closed to root: a user without rights runs it.
    let user = User::with(binary());
    user.raxel(&["new", "mine"]).exits(0);
    let mine = user.path("here/mine");
    // Not everybody may look into the folder of the build.
    let binary = user.path("raxel");
    fs::copy(&user.binary, &binary).unwrap();
    // Nor write where the tests keep their temporary files.
    let temporary = user.path("temporary");
    fs::create_dir(&temporary).unwrap();
    fs::set_permissions(&temporary, fs::Permissions::from_mode(0o777)).unwrap();
    let closed = |arguments: &[&str]| -> Run {
        let mut command = Command::new("setpriv");
        command.args(["--reuid=65534", "--regid=65534", "--clear-groups"]).arg(&binary).args(arguments);
        command.current_dir(&mine).stdin(Stdio::null()).env("NO_COLOR", "1").env("RAXEL_CACHE", "off");
        output(command.env("TMPDIR", &temporary).env_remove("HOME").env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY"))
            .into()
    };
    let is_root = fs::metadata("/proc/self").is_ok_and(|process| std::os::unix::fs::MetadataExt::uid(&process) == 0);
    if !is_root || !open_to_all(user.home.path()) {
        eprintln!("not root, or without setpriv: nobody else can be asked");
        return;
    }
    let before = common::files(&mine).len();
    closed(&["check"]).exits(0);
    for (arguments, said) in [
        (&["render", "--size", "32x18", "-o", "x.png"][..], "`x.png` cannot be written"),
        (&["new", "other"], "the folder `other` cannot be made"),
        (&["schema"], "cannot be written"),
        (&["shaders"], "cannot be made"),
        (&["man", "pages"], "the folder `pages` cannot be made"),
        (&["demo", "--no-window"], "`-o FOLDER` names another one"),
    ] {
        let run = closed(arguments).exits(2);
        assert!(
            run.stderr.contains(said) && run.stderr.matches("error: ").count() == 1,
            "{arguments:?}: {}",
            run.stderr
        );
    }
    assert_eq!(common::files(&mine).len(), before);
}

/// Lets everybody read a temporary folder, and run its programs; false without `setpriv`.
fn open_to_all(folder: &Path) -> bool {
    use std::os::unix::fs::PermissionsExt;
    fs::set_permissions(folder, fs::Permissions::from_mode(0o755)).unwrap();
    Command::new("setpriv").arg("--version").stdout(Stdio::null()).status().is_ok_and(|status| status.success())
}

/// A demo of the project around comes before raxel's own, and its picture lies in the project.
#[test]
fn the_demo_of_a_project_is_that_of_the_project() {
    let user = User::with(binary());
    user.raxel(&["new", "mine"]).exits(0);
    let mine = user.path("here/mine");
    let demo = include_str!("fixtures/install/dusk.demo.toml");
    fs::write(mine.join("worlds/dusk.demo.toml"), demo).unwrap();
    let small = ["--size", "64x36", "--fps", "3"];
    let run = user.raxel_in(&mine.join("graphs"), &[&["demo"], &small[..]].concat()).exits(0);
    assert_shows_something(&mine.join(".raxel/demo/dusk.png"), [64, 36]);
    assert!(run.stderr.contains("3 frames"), "{}", run.stderr);
    fs::remove_dir_all(mine.join(".raxel/demo")).unwrap();
    user.raxel(&[&["demo", "mine/worlds/dusk.demo.toml"], &small[..]].concat()).exits(0);
    assert_shows_something(&mine.join(".raxel/demo/dusk.png"), [64, 36]);
    // Nothing was unpacked, and nothing lies where the user is.
    assert!(!user.path("here/raxel-demo").exists() && user.unpacked().is_none());
}

/// Edited files of the demo stay, and missing files come back. Without a cache it works as well.
#[test]
fn the_files_of_the_demo_are_kept_and_mended() {
    let user = User::with(binary());
    let demo = ["demo", "sponge", "--size", "64x36", "--frames", "1"];
    user.raxel(&demo).exits(0);
    let kept = user.unpacked().expect("a folder with the files");
    let edited = fs::read_to_string(kept.join("worlds/sponge.demo.toml")).unwrap() + "# mine\n";
    fs::write(kept.join("worlds/sponge.demo.toml"), &edited).unwrap();
    fs::remove_file(kept.join("worlds/menger.toml")).unwrap();
    user.raxel(&demo).exits(0);
    assert_eq!(fs::read_to_string(kept.join("worlds/sponge.demo.toml")).unwrap(), edited);
    Run::from(output(user.command(&user.path("here"), &demo).env("RAXEL_CACHE", "off"))).exits(0);
}

#[test]
fn every_template_checks_renders_and_names_files_that_are_there() {
    let user = User::with(binary());
    for (template, file) in [
        ("voxel", "graphs/primary.toml"),
        // The same, by the name of its graph.
        ("primary", "graphs/primary.toml"),
        ("beauty", "graphs/beauty.toml"),
        ("post", "graphs/glow.toml"),
        ("simulation", "graphs/spots.toml"),
        ("minimal", "graphs/primary.toml"),
    ] {
        user.raxel(&["new", template, "--template", template]).exits(0);
        let project = user.path("here").join(template);
        let run = user.raxel_in(&project, &["check"]).exits(0);
        assert!(run.stdout.is_empty() && all_ok(&run), "{template}: {}{}", run.stdout, run.stderr);
        let readme = fs::read_to_string(project.join("README.md")).unwrap();
        for named in readme.split('`').filter(|span| span.contains('/') && !span.contains([' ', '*'])) {
            assert!(project.join(named).exists(), "the README of {template} names {named}");
        }
        assert!(readme.contains(file) && project.join(file).is_file(), "{template}");
        let size = ["--size", "64x36", "--frames", "2", "--validate", "-o", "p.png"];
        user.renders_in(&project, &[&["render"], &size[..]].concat()).exits(0);
        assert_shows_something(&project.join("p.png"), [64, 36]);
    }
}

#[test]
fn a_model_of_ones_own_becomes_the_world_of_a_new_project() {
    let user = User::with(binary());
    fs::copy(repository().join("worlds/models/hut.vox"), user.path("here/My Hut.vox")).unwrap();
    for template in ["beauty", "voxel"] {
        user.raxel(&["new", template, "--template", template, "--model", "My Hut.vox"]).exits(0);
        let project = user.path("here").join(template);
        let copied = fs::read(project.join("worlds/models/My_Hut.vox")).unwrap();
        assert!(copied == fs::read(user.path("here/My Hut.vox")).unwrap());
        let run = user.raxel_in(&project, &["check"]).exits(0);
        assert!(all_ok(&run), "{}", run.stderr);
        user.renders_in(&project, &["render", "--size", "64x36", "--frames", "2", "-o", "p.png"]).exits(0);
        assert_shows_something(&project.join("p.png"), [64, 36]);
        let info = user.raxel_in(&project, &["world", "info"]).exits(0).stdout;
        assert!(info.contains("worlds/My_Hut.toml"), "{info}");
        assert_stands_in_the_middle(&user, &project);
    }
    // An impossible request makes no project.
    fs::write(user.path("here/broken.vox"), "VOX?").unwrap();
    let refused = |arguments: &[&str], code, words: &str| {
        let run = user.raxel(&[&["new", "none"], arguments].concat()).exits(code);
        assert!(run.stderr.contains(words), "{}", run.stderr);
        assert!(!user.path("here/none").exists());
    };
    refused(&["--model", "broken.vox"], 3, "broken.vox");
    refused(&["--model", "absent.vox"], 3, "absent.vox");
    refused(&["--model", "My Hut.vox", "--template", "minimal"], 2, "--template beauty");
    fs::copy(user.path("here/My Hut.vox"), user.path("here/tree.vox")).unwrap();
    refused(&["--model", "tree.vox"], 2, "give the model another name");
    // A name that cannot be a key also works.
    fs::copy(user.path("here/My Hut.vox"), user.path("here/家.vox")).unwrap();
    user.raxel(&["new", "own", "--model", "家.vox"]).exits(0);
    let run = user.raxel_in(&user.path("here/own"), &["check"]).exits(0);
    assert!(all_ok(&run) && run.stderr.contains("worlds/model.toml: ok"), "{}", run.stderr);
}

/// The camera looks at the centre of the model, and the floor reaches as far on each side of it.
#[track_caller]
fn assert_stands_in_the_middle(user: &User, project: &Path) {
    let world = fs::read_to_string(project.join("worlds/My_Hut.toml")).unwrap();
    let (before, floor) = world.split_once("[[build]]\n").unwrap();
    let (_, model) = floor.split_once("[[build]]\n").unwrap();
    let middle = |text: &str| {
        fs::write(project.join("worlds/part.toml"), text).unwrap();
        let run = user.raxel_in(project, &["world", "info", "worlds/part.toml", "--format", "json"]).exits(0);
        let info: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
        let corner = |name: &str, axis: usize| info["info"]["bounds"][name][axis].as_f64().unwrap();
        [0, 1, 2].map(|axis| corner("min", axis).midpoint(corner("max", axis)))
    };
    let at = middle(&format!("{before}[[build]]\n{model}"));
    let around = middle(&world);
    let look_at = world.parse::<toml::Table>().unwrap()["camera"]["look_at"].as_array().unwrap().clone();
    for axis in 0..3 {
        let look_at = look_at[axis].as_float().unwrap();
        assert!((look_at - at[axis]).abs() <= 0.5, "the camera looks at {look_at} on axis {axis}, not at {}", at[axis]);
        assert!(axis == 1 || (around[axis] - at[axis]).abs() <= 0.5, "the floor is around {around:?}, not {at:?}");
    }
}

#[test]
fn every_verb_has_a_manual_page() {
    let user = User::with(binary());
    user.raxel(&["man", "pages/man1"]).exits(0);
    let help = user.raxel(&["help"]).exits(0).stdout;
    let (_, verbs) = help.split_once("Commands:").unwrap();
    let verbs = verbs.lines().skip(1).map_while(|line| line.strip_prefix("  "));
    let verbs: Vec<&str> = verbs.filter_map(|line| line.split(' ').next()).filter(|verb| *verb != "help").collect();
    assert!(verbs.len() > 20 && verbs.contains(&"demo") && verbs.contains(&"man"), "{verbs:?}");
    for verb in verbs.iter().copied().chain(["world-info", "world-import"]) {
        let page = fs::read_to_string(user.path(&format!("here/pages/man1/raxel-{verb}.1"))).unwrap();
        assert!(
            page.contains(".SH SYNOPSIS") && page.contains(&format!("raxel\\-{}", verb.replace('-', "\\-"))),
            "{page}"
        );
    }
    assert_eq!(user.raxel(&["man"]).exits(0).stdout, fs::read_to_string(user.path("here/pages/man1/raxel.1")).unwrap());
}

/// Packs the binary of this build.
fn packed(user: &User) -> PathBuf {
    let out = user.path("packed");
    let pack = repository().join(".github/release/pack");
    Run::from(output(Command::new(pack).args([binary(), "raxel-test"]).arg(&out))).exits(0);
    out
}

fn system(program: &str, arguments: &[&Path]) {
    Run::from(output(Command::new(program).args(arguments))).exits(0);
}

#[test]
fn the_archive_of_a_release_does_what_its_readme_says() {
    let user = User::with(binary());
    let out = packed(&user);
    system("tar", &["-C".as_ref(), user.home.path(), "-xzf".as_ref(), &out.join("raxel-test.tar.gz")]);
    let sum = fs::read_to_string(out.join("raxel-test.tar.gz.sha256")).unwrap();
    assert!(sum.trim_end().ends_with("  raxel-test.tar.gz"), "{sum}");
    let archive = user.path("raxel-test");
    let user = User { binary: archive.join("raxel"), ..user };
    user.first_steps();

    // Its README: every command, with less to compute, and every file that it names.
    let readme = fs::read_to_string(archive.join("README.md")).unwrap();
    let mut commands = 0;
    for line in readme.lines().filter_map(|line| line.strip_prefix("./raxel ")) {
        let words: Vec<&str> = line.split('#').next().unwrap().split_whitespace().collect();
        commands += 1;
        match words[0] {
            "run" => user.raxel_in(&archive, &["check"]).exits(0),
            "demo" => user.renders_in(&archive, &["demo", "--size", "64x36", "--frames", "1"]).exits(0),
            "render" => user.renders_in(&archive, &words).exits(0),
            _ => user.raxel_in(&archive, &words).exits(0),
        };
    }
    assert_eq!(commands, 4, "{readme}");
    for picture in ["valley.png", ".raxel/demo/dusk.png"] {
        assert!(archive.join(picture).is_file(), "{picture}");
    }
    let (_, table) = readme.split_once("## What is here").unwrap();
    let mut named = 0;
    for cell in table.lines().filter_map(|line| line.strip_prefix("| `")) {
        for name in cell.split('|').next().unwrap().split('`').filter(|name| !name.trim().is_empty()) {
            named += 1;
            assert!(archive.join(name).exists(), "{name}");
        }
    }
    assert!(named > 9, "{named}");
    for file in ["man/raxel-demo.1", "completions/_raxel", "docs/README.md", ".raxel/graph.schema.json", "LICENSE-MIT"]
    {
        assert!(archive.join(file).is_file(), "{file}");
    }
    for page in common::markdown::pages("docs") {
        assert!(archive.join(&page).is_file(), "{page}");
    }
}

#[test]
fn the_package_for_debian_runs_where_it_is_unpacked() {
    if Command::new("dpkg-deb").arg("--version").stdout(Stdio::null()).status().is_err() {
        eprintln!("there is no dpkg-deb: nothing is made that could be tested");
        return;
    }
    let user = User::with(binary());
    let out = packed(&user);
    let mut made = fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().path());
    let package = made.find(|path| path.extension().is_some_and(|extension| extension == "deb")).expect("a package");
    let root = user.path("root");
    system("dpkg-deb", &["-x".as_ref(), &package, &root]);
    let fields = Run::from(output(Command::new("dpkg-deb").arg("-I").arg(&package))).exits(0).stdout;
    assert!(fields.contains("Depends: libc6 (>= 2.") && fields.contains("libvulkan1"), "{fields}");
    for file in [
        "usr/share/man/man1/raxel.1.gz",
        "usr/share/bash-completion/completions/raxel",
        "usr/share/raxel/worlds/valley.toml",
        "usr/share/doc/raxel/copyright",
    ] {
        assert!(root.join(file).is_file(), "{file}");
    }
    User { binary: root.join("usr/bin/raxel"), ..user }.first_steps();
}
