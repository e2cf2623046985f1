//! Every way a pass can be bound: buffers, sources, mips, layers, volumes, samplers, uniform blocks, indirect dispatch.

use raxel_execute::ExecuteError;

use crate::lab::{Lab, Planned, at, graph};

#[test]
fn buffers_sources_uniforms_and_indirect_dispatch() {
    let mut lab = Lab::new();
    let toml = include_str!("../fixtures/bindings/buffers.toml");
    let args = r"#version 460
layout(local_size_x = 1) in;
buffer Args { uint words[8]; } args;
uniform Setup { uvec3 groups; float scale; } setup;
void main() {
    for (int i = 0; i < 3; ++i) args.words[4 + i] = setup.groups[i];
    args.words[0] = uint(setup.scale);
}";
    let sum = include_str!("../fixtures/bindings/sum.comp");
    let show = include_str!("../fixtures/bindings/show.comp");
    let files = [
        ("graphs/test.toml", toml),
        ("shaders/args.comp", args),
        ("shaders/sum.comp", sum),
        ("shaders/show.comp", show),
    ];
    let words: Vec<u8> = (1..=8u32).flat_map(u32::to_le_bytes).collect();
    let graph = graph(&files);
    let plan = {
        lab.supply("input", &words);
        lab.plan(&graph, &Planned { pinned: &["total", "args"], ..Planned::default() })
    };
    let missing = lab.executor.builder().prepare(plan.clone(), &raxel_execute::Sources::new());
    assert!(matches!(missing.err(), Some(ExecuteError::MissingSource { .. })));
    let prepared = lab.prepare(&plan).expect("it suits the device");
    lab.executor.swap(prepared);
    for frame in 3..6 {
        lab.frame_with(&at(frame), &[]);
        assert_eq!(lab.words("total"), [5 + 36]);
        assert_eq!(lab.words("args"), [frame, 0, 0, 0, 2, 1, 1, 0]);
        let texels = lab.integers("color", 0, 0);
        assert_eq!(texels[0][0], 1041);
        assert_eq!(texels[8..16].iter().map(|t| t[0]).collect::<Vec<_>>(), [2, 4, 6, 8, 10, 12, 14, 16]);
    }
    // Other bytes of the same source: the results follow.
    let words: Vec<u8> = (2..=9u32).flat_map(u32::to_le_bytes).collect();
    lab.supply("input", &words);
    let prepared = lab.prepare(&plan).expect("it suits the device");
    lab.executor.swap(prepared);
    lab.frame_with(&at(5), &[]);
    assert_eq!(lab.integers("color", 0, 0)[0][0], 1049);
}

#[test]
fn mips_layers_volumes_and_samplers() {
    let mut lab = Lab::new();
    let toml = include_str!("../fixtures/bindings/images.toml");
    let files = [
        ("graphs/test.toml", toml),
        (
            "shaders/base.comp",
            "#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(r32f) writeonly uniform image2D dst;
void main() { ivec2 p = ivec2(gl_GlobalInvocationID.xy); imageStore(dst, p, vec4(p.x + 8 * p.y)); }",
        ),
        ("shaders/down.comp", include_str!("../fixtures/bindings/down.comp")),
        (
            "shaders/layers.comp",
            "#version 460
layout(local_size_x = 4, local_size_y = 4) in;
layout(rgba8) writeonly uniform image2DArray dst;
void main() { ivec3 p = ivec3(gl_GlobalInvocationID); imageStore(dst, p, vec4(p.z, 0, p.x, 5) / 5.0); }",
        ),
        (
            "shaders/volume.comp",
            "#version 460
layout(local_size_x = 4, local_size_y = 4, local_size_z = 2) in;
layout(r32i) writeonly uniform iimage3D dst;
void main() { ivec3 p = ivec3(gl_GlobalInvocationID); imageStore(dst, p, ivec4(-p.x - 10 * p.y - 100 * p.z)); }",
        ),
        ("shaders/all.comp", include_str!("../fixtures/bindings/all.comp")),
    ];
    let pinned = ["pyramid", "stack", "volume"];
    lab.load(&files, &Planned { pinned: &pinned, ..Planned::default() });
    let report = lab.frame();
    assert_eq!(report.dispatched, 6);
    assert_eq!(lab.floats("pyramid", 0, 1, 0)[0][0], 4.5);
    assert_eq!(lab.floats("pyramid", 0, 2, 0).len(), 4);
    assert_eq!(lab.floats("stack", 0, 0, 2)[3], [0.4, 0.0, 0.6, 1.0]);
    assert_eq!(lab.integers("volume", 0, 1)[5][0] as i32, -111);
    let mean = (0..64).map(|i| i as f32).sum::<f32>() / 64.0;
    let texel = lab.floats("color", 0, 0, 0)[9];
    let expected = [mean, 1.0, 203.0, -111.0 - 10.0];
    assert!((0..4).all(|c| (texel[c] - expected[c]).abs() < 1e-3), "{texel:?} is not {expected:?}");
    assert_eq!(lab.frame().dispatched, 0, "a chain through the mips of one target settles");
}
