//! From the start of the program to its first picture: no shader of an earlier run is compiled again, in any state of the cache on disk.

mod common;

use std::fs;
use std::path::{Path, PathBuf};

use common::{Run, command, output, repository};

/// A folder for a cache, and one for pictures.
struct Lab {
    folder: tempfile::TempDir,
}

impl Lab {
    fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    fn cache(&self) -> PathBuf {
        self.folder.path().join("cache")
    }

    fn picture(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn command(&self, name: &str) -> std::process::Command {
        let picture = self.picture(name);
        let arguments =
            ["-v", "render", "graphs/inspect.toml", "--world", "worlds/menger.toml", "--size", "48x27", "-o"];
        let mut command = command(repository(), &[&arguments[..], &[picture.to_str().unwrap()]].concat());
        command.env("RAXEL_CACHE", self.cache());
        command
    }

    /// Renders; the picture, and how many shaders were compiled.
    fn render(&self, name: &str) -> (Vec<u8>, usize, String) {
        let run = Run::from(output(&mut self.command(name))).exits(0);
        (fs::read(self.picture(name)).unwrap(), compiled(&run.stderr), run.stderr)
    }
}

/// `compiled shaders/x.comp in 12 ms`.
fn compiled(stderr: &str) -> usize {
    stderr.lines().filter(|line| line.contains("compiled ") && line.contains(".comp in ")).count()
}

fn files(folder: &Path) -> Vec<PathBuf> {
    fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect()
}

#[test]
fn a_second_start_compiles_nothing_and_damage_costs_one_warning() {
    let lab = Lab::new();
    let (first, compiled_first, stderr) = lab.render("a.png");
    // The graph's shader, and the one that shows it.
    assert!(compiled_first >= 2, "{stderr}");
    let (second, compiled_again, stderr) = lab.render("b.png");
    assert_eq!(compiled_again, 0, "{stderr}");
    assert!(first == second && !stderr.contains("RX0485"), "{stderr}");

    for file in files(&lab.cache()) {
        fs::write(file, b"not what was written").unwrap();
    }
    let (third, compiled_third, stderr) = lab.render("c.png");
    assert_eq!((compiled_third, stderr.matches("RX0485").count()), (compiled_first, 1), "{stderr}");
    let (fourth, compiled_fourth, stderr) = lab.render("d.png");
    assert_eq!((compiled_fourth, stderr.matches("RX0485").count()), (0, 0), "{stderr}");
    assert!(first == third && first == fourth);
}

#[test]
fn passes_that_differ_in_constants_are_compiled_once_and_that_is_said() {
    let lab = Lab::new();
    for folder in ["graphs", "shaders"] {
        fs::create_dir(lab.picture(folder)).unwrap();
    }
    let graph = |second: f32| {
        let pass = |name: &str, added: f32| {
            format!(
                r#"[[passes]]
name = "{name}"
shader = "add.comp"
specialization = {{ ADDED = {added:?} }}
dispatch = {{ threads = "color" }}
bind = {{ outColor = "color" }}
"#
            )
        };
        format!(
            r#"name = "add"
present = "color"
[targets.color]
format = "rgba32f"
clear = [0.0, 0.0, 0.0, 0.0]
{}{}{}"#,
            pass("a", 0.5),
            pass("b", second),
            pass("c", 0.5)
        )
    };
    let shader = r"#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 0) const float ADDED = 1.0;
layout(rgba32f) uniform image2D outColor;
void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    imageStore(outColor, pixel, imageLoad(outColor, pixel) + ADDED);
}
";
    fs::write(lab.picture("graphs/add.toml"), graph(0.25)).unwrap();
    fs::write(lab.picture("shaders/add.comp"), shader).unwrap();
    let mut command = command(
        lab.folder.path(),
        &["-v", "render", "graphs/add.toml", "--size", "8x8", "-o", lab.picture("a.png").to_str().unwrap()],
    );
    let run = Run::from(output(command.env("RAXEL_CACHE", lab.cache()))).exits(0);
    let said = |line: &str| run.stderr.lines().filter(|said| said.contains(line)).count();
    assert_eq!(said("compiled shaders/add.comp in "), 1, "{}", run.stderr);
    assert_eq!((said("made the pipeline of pass `a` in "), said("made the pipeline of pass `b` in ")), (1, 1));
    assert_eq!((said("pass `c` shares the pipeline of pass `a`"), said("made the pipeline of pass `c` in ")), (1, 0));
}

#[test]
fn processes_that_start_together_do_not_disturb_each_other() {
    let lab = Lab::new();
    std::thread::scope(|scope| {
        let runs: Vec<_> = (0..4)
            .map(|i| {
                let lab = &lab;
                scope.spawn(move || lab.render(&format!("{i}.png")))
            })
            .collect();
        let runs: Vec<_> = runs.into_iter().map(|run| run.join().unwrap()).collect();
        for (picture, _, stderr) in &runs {
            assert!(*picture == runs[0].0 && !stderr.contains("RX0485"), "{stderr}");
        }
    });
    assert!(files(&lab.cache()).iter().all(|file| file.extension().is_some_and(|ending| ending == "kept")));
    assert_eq!(lab.render("after.png").1, 0);
}

#[test]
fn the_cache_is_where_the_environment_says_or_nowhere() {
    let lab = Lab::new();
    let home = lab.picture("home");
    fs::create_dir(&home).unwrap();
    let run = |cache: Option<&str>| {
        let mut command = lab.command("a.png");
        command.env("HOME", &home).env_remove("XDG_CACHE_HOME").env_remove("RAXEL_CACHE");
        command.envs(cache.map(|cache| ("RAXEL_CACHE", cache)));
        Run::from(output(&mut command)).exits(0)
    };
    let kept = home.join(".cache/raxel");
    run(Some("off"));
    assert!(!kept.exists());
    run(None);
    if cfg!(target_os = "linux") {
        assert!(!files(&kept).is_empty());
    }
    // A cache that cannot be written costs only time.
    fs::write(lab.picture("file"), b"").unwrap();
    let below = lab.picture("file").join("below");
    assert!(!run(below.to_str()).stderr.contains("RX0485"));
}
