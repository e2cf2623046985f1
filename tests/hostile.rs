//! Shaders and files that would end the process, or run for ever: raxel reports the mistake, or draws what it can.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod common;

use common::{Project, RunRaxel};

/// A graph of two passes: `far` writes shared memory far outside of its array, `color` is red from left to right.
fn shared_out_of_bounds(project: &Project) {
    project
        .write("graphs/shared.toml", include_str!("fixtures/hostile/shared.toml"))
        .write("shaders/far.comp", include_str!("fixtures/hostile/far.comp"))
        .write("shaders/color.comp", include_str!("fixtures/hostile/color.comp"))
        .write(
            "worlds/w.toml",
            r#"name = "w"
[materials.stone]
albedo = [0.5, 0.5, 0.5]
[[build]]
op = "box"
min = [0, 0, 0]
max = [4, 4, 4]
material = "stone"
"#,
        );
}

/// Without bounds the software driver writes into the memory of the process and ends it.
#[test]
fn shared_memory_out_of_bounds_harms_nobody() {
    let project = Project::empty();
    shared_out_of_bounds(&project);
    project
        .raxel(&[
            "render",
            "graphs/shared.toml",
            "--world",
            "worlds/w.toml",
            "-o",
            "o.png",
            "--size",
            "64x8",
            "--validate",
        ])
        .exits(0);
    let picture = image::open(project.path("o.png")).unwrap().to_rgb8();
    for (x, y, pixel) in picture.enumerate_pixels() {
        assert_eq!(pixel.0, [x as u8, 0, 0], "at {x}, {y}");
    }
}

/// Structs of structs double the compiler's work with each line. Excess that the text shows is refused at once; excess that macros hide
/// ends by a limit.
#[test]
fn a_shader_that_never_ends_compiling_is_given_up() {
    let project = Project::empty();
    let shader = |structs: &str| {
        format!(
            r"#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba8) uniform writeonly image2D outColor;
{structs}
void main() {{ A40 v, w; v = w; imageStore(outColor, ivec2(0), vec4(1)); }}
"
        )
    };
    let double = |i| format!("struct A{i} {{ A{0} a; A{0} b; }};\n", i - 1);
    let plain: String = (1..=40).map(double).collect();
    project
        .write("graphs/g.toml", include_str!("fixtures/hostile/structs.toml"))
        .write("shaders/a.comp", shader(&format!("struct A0 {{ int x; }};\n{plain}")));
    let run = project.raxel(&["check", "graphs/g.toml"]).exits(3);
    assert!(run.stdout.contains("RX0204") && run.stdout.contains("65536 members"), "{}", run.stdout);

    project.write("shaders/a.comp", shader("struct A40 { int x; };"));
    project.raxel(&["check", "graphs/g.toml"]).exits(0);
}
