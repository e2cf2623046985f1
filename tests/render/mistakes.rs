//! What cannot be rendered is said before anything runs.

use crate::common::{Project, Run, RunRaxel, command, output, raxel};
use crate::{MENGER, common, menger};

#[test]
fn a_film_needs_ffmpeg_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let film = folder.path().join("film.mp4");
    let arguments = [&MENGER[..], &["--frames", "2", "-o", film.to_str().unwrap()]].concat();
    let run: Run = output(command(common::repository(), &arguments).env("PATH", folder.path())).into();
    let said = run.exits(2).stderr;
    assert!(said.contains("needs ffmpeg") && said.contains("frames/%04d.png"), "{said}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is left behind");
}

#[test]
fn an_output_that_cannot_be_written_is_said_before_anything_runs() {
    let folder = tempfile::tempdir().unwrap();
    let inside = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    std::fs::create_dir(inside("d.png")).unwrap();
    // The graph does not exist either; the output is looked at first.
    for output in [inside("no/a.png"), inside("a"), inside("a.tga"), inside("%d%d.png")] {
        let run = raxel(&["render", "graphs/none.toml", "-o", &output]).exits(2);
        assert!(run.stderr.starts_with("error: "), "{}", run.stderr);
    }
    raxel(&["render", "graphs/none.toml", "-o", &inside("a.png")]).exits(3);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is written");
}

#[test]
fn broken_projects_write_nothing() {
    let project = Project::shipped();
    project.edit("shaders/primary.comp", "void main", "void mian");
    let before = project.files();
    let run = project.raxel(&["render", "-o", "p.png"]).exits(3);
    assert!(run.stdout.is_empty() && run.stderr.contains("shaders/primary.comp"), "{}", run.stderr);
    project.write("worlds/valley.toml", "[[build]]\nop = \"bix\"\n");
    let run = project.raxel(&["render", "-o", "p.png", "--format", "short"]).exits(3);
    assert!(run.stderr.contains("worlds/valley.toml:2:"), "both files are reported at once: {}", run.stderr);
    assert!(run.stderr.contains("shaders/primary.comp:"), "{}", run.stderr);
    assert_eq!(project.files(), before);
}

#[test]
fn names_and_values_on_the_command_line_are_checked() {
    for (arguments, said) in [
        (["--set", "sky_dpeth=1"], "did you mean `sky_depth`?"),
        (["--set", "sky_depth=much"], "sky_depth"),
        (["--set", "sky_depth"], "has no `=`"),
        (["--target", "dept"], "did you mean `depth`?"),
        (["--after", "inspct"], "did you mean `inspect`?"),
        (["--camera", "1,2"], "three numbers"),
        (["--camera", "above"], "`worlds/menger.toml` has no camera `above`"),
        (["--shard", "3/2"], "PART/PARTS"),
    ] {
        let run = menger(&[&arguments[..], &["-o", "never.png"]].concat()).exits(2);
        assert!(run.stderr.contains(said), "{arguments:?}: {}", run.stderr);
        assert!(!common::repository().join("never.png").exists());
    }
}

#[test]
fn without_a_driver_the_exit_code_is_4_with_the_command_that_installs_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    let mut command = command(common::repository(), &[&MENGER[..], &["-o", path.to_str().unwrap()]].concat());
    let command = command.env("VK_DRIVER_FILES", "/nonexistent.json").env("VK_ICD_FILENAMES", "/nonexistent.json");
    assert!(Run::from(output(command)).exits(4).stderr.contains("apt-get install"));
    assert!(!path.exists());
}
