//! Help, completions, and words that are wrong, moved or explained.

use crate::common::{Project, Run, RunRaxel, output, raxel};

#[test]
fn help_version_and_wrong_use() {
    let help = raxel(&["--help"]).exits(0);
    for verb in [
        "run", "render", "check", "graph", "list", "world", "shaders", "new", "init", "schema", "bench", "stress",
        "doctor", "explain", "clean",
    ] {
        assert!(help.stdout.contains(&format!("\n  {verb} ")), "help names {verb}");
    }
    for more in ["--help", "-h"] {
        assert_eq!(raxel(&["help", more]).exits(0).stdout, raxel(&["help"]).exits(0).stdout);
        assert_eq!(raxel(&["help", "world", more]).exits(0).stdout, raxel(&["help", "world"]).exits(0).stdout);
    }
    assert!(raxel(&["--version"]).exits(0).stdout.starts_with("raxel "));
    raxel(&[]).exits(2);
    assert!(raxel(&["chekc"]).exits(2).stderr.contains("check"), "a verb is suggested");
    raxel(&["render", "--size", "0x10", "-o", "a.png"]).exits(2);
    raxel(&["render", "--size", "ten", "-o", "a.png"]).exits(2);
}

#[test]
fn two_outputs_of_a_command_have_two_names() {
    let project = Project::shipped();
    let run = project.raxel(&["render", "graphs/primary.toml", "--trace", "a.png", "-o", "./a.png"]).exits(2);
    assert!(run.stderr.contains("raxel is writing another file there"), "{}", run.stderr);
    // That of the refused command.
    assert!(std::fs::read_to_string(project.path("a.png")).unwrap().contains("traceEvents"));
}

#[test]
fn explain_prints_pages_and_suggests() {
    assert!(raxel(&["explain", "rx11"]).exits(0).stdout.starts_with("# RX0011: unknown key"));
    assert!(raxel(&["explain"]).exits(0).stdout.contains("RX0011  unknown key\n"));
    let wrong = raxel(&["explain", "RX9911"]).exits(2);
    assert!(wrong.stdout.is_empty() && wrong.stderr.contains("did you mean `RX"));
}

/// A key that stood elsewhere before is refused, with its present place.
#[test]
fn what_has_moved_is_named_with_its_new_place() {
    let project = Project::shipped();
    let moved = [
        ("graphs/naive.toml", "graphs/rivals/naive.toml"),
        ("graphs/light/ddgi.toml", "graphs/rivals/light/ddgi.toml"),
        ("graphs/light/views/lum_live.toml", "graphs/rivals/light/views/lum_live.toml"),
        ("graphs/bench/dda.toml", "graphs/rivals/march/dda.toml"),
    ];
    for (old, new) in moved {
        let run = project.raxel(&["check", old]).exits(3);
        assert!(run.stdout.contains(&format!("did you mean `{new}`?")), "{}", run.stdout);
    }
    // The name alone is enough to be found.
    let run = project.raxel(&["render", "primary.toml", "-o", "a.png"]).exits(3);
    assert!(run.stderr.contains("did you mean `graphs/primary.toml`?"), "{}", run.stderr);
    for (verb, old, new) in [("bench", moved[3].0, moved[3].1), ("light", moved[1].0, moved[1].1)] {
        let verbs: &[&str] = if verb == "light" { &["bench", "light"] } else { &["bench"] };
        let run = project.raxel(&[verbs, &[old]].concat()).exits(3);
        assert!(run.stderr.contains(&format!("did you mean `{new}`?")), "{}", run.stderr);
    }
    for (nearly, whole) in [
        ("primry.toml", "graphs/primary.toml"),
        ("graphs/primary", "graphs/primary.toml"),
        ("primary", "graphs/primary.toml"),
        ("worlds/vallye.toml", "worlds/valley.toml"),
    ] {
        let run = project.raxel(&["check", nearly]).exits(3);
        assert!(run.stdout.contains(&format!("did you mean `{whole}`?")), "{nearly}: {}", run.stdout);
    }
    let run = project.raxel(&["shaders", "--library", "raxel/tree64.glsl"]).exits(2);
    assert!(run.stderr.contains("did you mean `raxel/internal/layouts/tree64.glsl`?"), "{}", run.stderr);

    project.edit("graphs/inspect.toml", "\"inspect.comp\"", "\"naive.comp\"");
    let run = project.raxel(&["check", "graphs/inspect.toml"]).exits(3);
    assert!(run.stdout.contains("did you mean `rivals/naive.comp`?"), "{}", run.stdout);
    project.edit("shaders/bench/first_hit.comp", "#include <raxel/rivals/march.glsl>", "#include <raxel/march.glsl>");
    let run = project.raxel(&["check", "graphs/bench/first_hit.toml"]).exits(3);
    assert!(run.stdout.contains("did you mean `<raxel/rivals/march.glsl>`?"), "{}", run.stdout);
}

#[test]
fn completions_name_the_verbs() {
    for shell in ["bash", "zsh", "fish", "powershell"] {
        assert!(raxel(&["completions", shell]).exits(0).stdout.contains("render"), "{shell}");
    }
}

/// The same range as in the files of worlds and demos, and a camera cannot look at where it is.
#[test]
fn a_camera_of_the_command_line_is_held_to_the_rules_of_files() {
    let project = Project::shipped();
    let render = |camera: &[&str]| {
        let line = [&["render", "--world", "worlds/menger.toml", "--size", "32x18", "-o", "a.png"], camera].concat();
        project.raxel(&line)
    };
    let run = render(&["--camera", "1e300,0,0"]).exits(2);
    assert!(run.stderr.contains("it must be in -2147483648…2147483648"), "{}", run.stderr);
    render(&["--camera", "0,0,nan"]).exits(2);
    render(&["--look-at", "0,-3e9,0"]).exits(2);
    let run = render(&["--camera", "0.1,7.5,-3", "--look-at", "0.1,7.5,-3"]).exits(2);
    assert!(run.stderr.contains("is where the camera is"), "{}", run.stderr);
    assert!(!project.path("a.png").exists());
    render(&["--camera", "0.1,7.5,-3", "--look-at", "0.1,-80,-3"]).exits(0);
}

/// As for every other result: a program that asks for the version must not take nothing for one.
#[test]
#[cfg(target_os = "linux")]
fn a_help_or_version_that_cannot_be_written_is_an_error() {
    for arguments in [&["--version"][..], &["--help"], &["render", "--help"], &["help", "check"]] {
        let mut shell = std::process::Command::new("sh");
        shell.args(["-c", "exec \"$0\" \"$@\" > /dev/full", env!("CARGO_BIN_EXE_raxel")]).args(arguments);
        let said = Run::from(output(&mut shell)).exits(2).stderr;
        assert!(said.starts_with("error: stdout cannot be written"), "{arguments:?}: {said}");
    }
}
