//! Exit codes are a contract with scripts: each of them from the binary, 0 to 6.

mod common;

use common::{Project, Run, command, output, raxel, repository};

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
        with(arguments, &none).exits(4);
    }
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("a.png");
    raxel(&[&MENGER[..], &["--device", "no such device", "-o", picture.to_str().unwrap()]].concat()).exits(4);
    assert!(!picture.exists());
}

/// Its frames take seconds on a software device, and are given up after half a second.
#[test]
fn code_5_means_that_the_device_was_lost_or_did_not_answer() {
    let project = Project::empty();
    let graph = "name = 'slow'\npresent = 'color'\n[targets.color]\nformat = 'r32f'\nsize = [256, 256]\n[[passes]]\nname = 'spin'\n\
                 shader = 'spin.comp'\ndispatch = { threads = 'color' }\nbind = { color = 'color' }\n";
    // That driver leaves loops after 65535 rounds, so a round is long.
    let step = "x = fract(x * 1.37 + 0.11); ".repeat(64);
    let shader = format!(
        "#version 460\nlayout(local_size_x = 8, local_size_y = 8) in;\nlayout(r32f) writeonly uniform image2D color;\n\
         void main() {{\n    float x = float(gl_GlobalInvocationID.x);\n    for (int i = 0; i < 60000; ++i) {{ {step} }}\n    \
         imageStore(color, ivec2(gl_GlobalInvocationID.xy), vec4(x));\n}}\n"
    );
    project.write("graphs/slow.toml", graph).write("shaders/spin.comp", shader);
    let run = project.raxel(&["render", "-o", "a.png", "--size", "64x64", "--watchdog", "0.08"]).exits(5);
    assert!(run.stderr.contains("`spin`") && run.stderr.contains("--watchdog SECONDS"), "{}", run.stderr);
    assert_eq!(project.files(), ["graphs/slow.toml", "shaders/spin.comp"], "nothing is written");
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
