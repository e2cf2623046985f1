//! Exit codes are a contract with scripts: each of them from the binary, 0 to 6.

mod common;

use std::time::Instant;

use common::{Project, Run, RunRaxel, Running, command, output, raxel, repository};

/// A picture of the shipped graph that needs no big world.
const MENGER: [&str; 6] = ["render", "graphs/inspect.toml", "--world", "worlds/menger.toml", "--size", "32x18"];

/// Runs it with variables of the environment.
fn with(arguments: &[&str], variables: &[(&str, &str)]) -> Run {
    output(command(repository(), arguments).envs(variables.iter().copied())).into()
}

#[test]
fn code_0_means_that_it_was_done() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("a.png");
    raxel(&[&MENGER[..], &["-o", picture.to_str().unwrap()]].concat()).exits(0);
    assert!(picture.is_file());
}

#[test]
fn code_1_means_that_a_check_failed() {
    // A tracer that claims to be exact, and is wrong.
    let project = Project::empty();
    let march = "bool rx_march(RxRay ray, out RxHit hit) {\n    bool found = rx_trace(ray, hit);\n    hit.face ^= 1u;\n    return found;\n}\n";
    project.write("shaders/include/raxel/rivals/march.glsl", march);
    let run = project.raxel(&["stress", "--scenes", "menger@near", "--layouts", "tree64", "--rays", "2000"]).exits(1);
    assert!(run.stderr.contains("tree64 is wrong about "), "{}", run.stderr);
}

#[test]
fn code_2_means_that_the_command_line_is_wrong_or_an_output_cannot_be_written() {
    assert!(raxel(&["render"]).exits(2).stderr.contains("--output"));
    let run = raxel(&[&MENGER[..], &["-o", "/nonexistent/a.png"]].concat()).exits(2);
    assert!(run.stderr.contains("does not exist"), "{}", run.stderr);
}

/// In every verb.
#[test]
fn code_3_means_that_a_file_of_the_project_is_wrong_or_missing() {
    let project = Project::shipped();
    project.write("graphs/wrong.toml", "present = 3\n");
    for arguments in [
        &["check", "graphs/wrong.toml"][..],
        &["graph", "graphs/wrong.toml"],
        &["shaders", "graphs/wrong.toml", "-o", "spv"],
        &["render", "graphs/wrong.toml", "-o", "a.png"],
        &["bench", "graphs/wrong.toml", "--worlds", "menger"],
        &["check", "worlds/none.toml"],
        &["graph", "graphs/none.toml"],
        &["shaders", "graphs/none.toml", "-o", "spv"],
        &["render", "graphs/none.toml", "-o", "a.png"],
        &["render", "--world", "worlds/none.toml", "-o", "a.png"],
        &["render", "worlds/none.demo.toml", "-o", "a.png"],
        &["bench", "--worlds", "worlds/none.toml"],
        &["bench", "graphs/none.toml"],
        &["bench", "reload", "graphs/none.toml"],
        &["stress", "--world", "worlds/none.toml"],
        &["world", "info", "worlds/none.toml"],
        &["world", "export", "worlds/none.toml", "-o", "a.vox"],
        &["world", "import", "none.vox"],
    ] {
        let run = project.raxel(arguments);
        assert_eq!(run.code, 3, "{arguments:?}\n{}", run.stderr);
    }
}

#[test]
fn code_4_means_that_there_is_no_suitable_device() {
    let none = [("VK_DRIVER_FILES", "/nonexistent.json"), ("VK_ICD_FILENAMES", "/nonexistent.json")];
    for arguments in [&["doctor"][..], &["stress"], &["bench", "hit", "--worlds", "menger"]] {
        let run = with(arguments, &none).exits(4);
        assert!((run.stdout + &run.stderr).contains("`VK_DRIVER_FILES=/nonexistent.json` says which drivers"));
    }
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("a.png");
    raxel(&[&MENGER[..], &["--device", "no such device", "-o", picture.to_str().unwrap()]].concat()).exits(4);
    assert!(!picture.exists());
}

/// A project with a pass that does this number of steps in a round, for each of 65536 pixels.
fn slow(steps: usize) -> Project {
    let project = Project::empty();
    let graph = include_str!("fixtures/exit_codes/slow.toml");
    // That driver leaves loops after 65535 rounds, so a round is long.
    let step = "x = fract(x * 1.37 + 0.11); ".repeat(steps);
    let shader = format!(
        r"#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(r32f) writeonly uniform image2D color;
void main() {{
    float x = float(gl_GlobalInvocationID.x);
    for (int i = 0; i < 60000; ++i) {{ {step} }}
    imageStore(color, ivec2(gl_GlobalInvocationID.xy), vec4(x));
}}
"
    );
    project.write("graphs/slow.toml", graph).write("shaders/spin.comp", shader);
    project
}

/// Its frames take seconds on a software device, and are given up after half a second.
#[test]
fn code_5_means_that_the_device_was_lost_or_did_not_answer() {
    let project = slow(64);
    let run = project.raxel(&["render", "-o", "a.png", "--size", "64x64", "--watchdog", "0.08"]).exits(5);
    assert!(run.stderr.contains("`spin`") && run.stderr.contains("--watchdog SECONDS"), "{}", run.stderr);
    assert_eq!(project.files(), ["graphs/slow.toml", "shaders/spin.comp"], "nothing is written");
}

/// A software device computes on threads of the process. raxel must not give it up for a time in which these threads could not run. Here the process
/// is stopped again and again, each time for longer than the watchdog allows.
#[test]
#[cfg(target_os = "linux")]
fn a_software_device_is_not_given_up_for_the_time_in_which_its_process_was_stopped() {
    let project = slow(2);
    let picture = ["render", "-o", "a.png", "--size", "64x64", "--device", "llvmpipe", "--watchdog"];
    let started = Instant::now();
    project.raxel(&[&picture[..], &["100"]].concat()).exits(0);
    // The frame takes most of it. A software device has six times the watchdog's time.
    let (whole, limit) = (started.elapsed(), started.elapsed().mul_f64(1.5));
    let watchdog = (limit.as_secs_f64() / 6.0).to_string();
    let mut child = Running::start(&mut command(project.root(), &[&picture[..], &[&watchdog]].concat()));
    for _ in 0..3 {
        std::thread::sleep(whole / 4);
        child.signal("STOP");
        std::thread::sleep(limit.mul_f64(1.2));
        child.signal("CONT");
    }
    assert_eq!(child.finish().code(), Some(0));
}

/// With its best practices switched on, the layer has something to say about any program.
#[test]
fn code_6_means_that_the_validation_layer_has_spoken() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("a.png");
    let arguments = [&MENGER[..], &["--validate", "-o", picture.to_str().unwrap()]].concat();
    let talkative = [("VK_LAYER_ENABLES", "VK_VALIDATION_FEATURE_ENABLE_BEST_PRACTICES_EXT")];
    let run = with(&arguments, &talkative).exits(6);
    assert!(run.stderr.contains("validation warning[") && run.stderr.contains("has complained"), "{}", run.stderr);
    with(&arguments, &[]).exits(0);
}
