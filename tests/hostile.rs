//! Shaders and files that would end the process, or run for ever: raxel reports the mistake, or draws what it can.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

mod common;

use common::Project;

/// A graph of two passes: `far` writes shared memory far outside of its array, `color` is red from left to right.
fn shared_out_of_bounds(project: &Project) {
    project
        .write(
            "graphs/shared.toml",
            "name = \"shared\"\npresent = \"color\"\n[targets.far]\nformat = \"r32ui\"\n[targets.color]\nformat = \"rgba8\"\n\
             [[passes]]\nname = \"far\"\nshader = \"far.comp\"\ndispatch = { threads = \"far\" }\nbind = { outFar = \"far\" }\n\
             [[passes]]\nname = \"color\"\nshader = \"color.comp\"\ndispatch = { threads = \"color\" }\n\
             bind = { far = \"far\", outColor = \"color\" }\n",
        )
        .write(
            "shaders/far.comp",
            "#version 460\nlayout(local_size_x = 8, local_size_y = 8) in;\n\
             layout(r32ui) uniform writeonly uimage2D outFar;\nshared uint s[64];\nshared vec4 v;\n\
             void main() {\n    uint k = gl_LocalInvocationIndex;\n    s[k * 100000u] = k;\n    v[k * 100000u] = 1.0;\n    barrier();\n\
             \x20   imageStore(outFar, ivec2(gl_GlobalInvocationID.xy), uvec4(s[k * 100000u] & 0u));\n}\n",
        )
        .write(
            "shaders/color.comp",
            "#version 460\nlayout(local_size_x = 8, local_size_y = 8) in;\nlayout(r32ui) uniform readonly uimage2D far;\n\
             layout(rgba8) uniform writeonly image2D outColor;\nshared uint s[64];\nvoid main() {\n\
             \x20   ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);\n    s[gl_LocalInvocationIndex] = imageLoad(far, pixel).x;\n    barrier();\n\
             \x20   imageStore(outColor, pixel, vec4(float(pixel.x + int(s[63u - gl_LocalInvocationIndex])) / 255.0, 0.0, 0.0, 1.0));\n}\n",
        )
        .write("worlds/w.toml", "name = \"w\"\n[materials.stone]\nalbedo = [0.5, 0.5, 0.5]\n[[build]]\nop = \"box\"\nmin = [0, 0, 0]\nmax = [4, 4, 4]\nmaterial = \"stone\"\n");
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
            "#version 460\nlayout(local_size_x = 8, local_size_y = 8) in;\nlayout(rgba8) uniform writeonly image2D outColor;\n\
             {structs}\nvoid main() {{ A40 v, w; v = w; imageStore(outColor, ivec2(0), vec4(1)); }}\n"
        )
    };
    let double = |i| format!("struct A{i} {{ A{0} a; A{0} b; }};\n", i - 1);
    let plain: String = (1..=40).map(double).collect();
    project
        .write(
            "graphs/g.toml",
            "name = \"g\"\npresent = \"color\"\n[targets.color]\nformat = \"rgba8\"\n[[passes]]\nname = \"a\"\nshader = \"a.comp\"\n\
             dispatch = { threads = \"color\" }\nbind = { outColor = \"color\" }\n",
        )
        .write("shaders/a.comp", shader(&format!("struct A0 {{ int x; }};\n{plain}")));
    let run = project.raxel(&["check", "graphs/g.toml"]).exits(3);
    assert!(run.stdout.contains("RX0204") && run.stdout.contains("65536 members"), "{}", run.stdout);

    project.write("shaders/a.comp", shader("struct A40 { int x; };"));
    project.raxel(&["check", "graphs/g.toml"]).exits(0);
}
