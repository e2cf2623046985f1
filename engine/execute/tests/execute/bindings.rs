//! Every way a pass can be bound: buffers, sources, mips, layers, volumes, samplers, uniform blocks, indirect dispatch.

use raxel_execute::ExecuteError;

use crate::lab::{Lab, Planned, at, graph};

#[test]
fn buffers_sources_uniforms_and_indirect_dispatch() {
    let mut lab = Lab::new();
    let toml = r#"
name = "buffers"
present = "color"
[targets.color]
format = "r32ui"
[buffers.input]
source = "test.words"
[buffers.args]
size = 32
[buffers.total]
size = 4
clear = 5
[buffers.pixels]
size = { of = "color", stride = 4 }
[[passes]]
name = "arguments"
shader = "args.comp"
dispatch = [1, 1, 1]
bind = { args = "args" }
[passes.uniforms.setup]
groups = { type = "uvec3", value = [2, 1, 1] }
scale = { type = "f32", from = "frame.time" }
[[passes]]
name = "sum"
shader = "sum.comp"
dispatch = { indirect = "args", offset = 16 }
bind = { input_words = "input", total = "total", pixels = "pixels" }
[[passes]]
name = "show"
shader = "show.comp"
dispatch = { threads = "color" }
bind = { total = "total", pixels = "pixels", outColor = "color" }
specialization = { OFFSET = 1000 }
"#;
    let args = "#version 460
layout(local_size_x = 1) in;
buffer Args { uint words[8]; } args;
uniform Setup { uvec3 groups; float scale; } setup;
void main() {
    for (int i = 0; i < 3; ++i) args.words[4 + i] = setup.groups[i];
    args.words[0] = uint(setup.scale);
}";
    let sum = "#version 460
layout(local_size_x = 4) in;
readonly buffer Words { uint words[]; } input_words;
buffer Total { uint total; } total;
writeonly buffer Pixels { uint pixels[]; } pixels;
void main() {
    uint i = gl_GlobalInvocationID.x;
    atomicAdd(total.total, input_words.words[i]);
    pixels.pixels[i] = input_words.words[i] * 2u;
}";
    let show = "#version 460
layout(local_size_x = 8, local_size_y = 4) in;
layout(constant_id = 3) const uint OFFSET = 0u;
readonly buffer Total { uint total; } total;
readonly buffer Pixels { uint pixels[]; } pixels;
layout(r32ui) writeonly uniform uimage2D outColor;
void main() {
    uvec2 p = gl_GlobalInvocationID.xy;
    imageStore(outColor, ivec2(p), uvec4(p.y == 0u ? total.total + OFFSET : pixels.pixels[p.x]));
}";
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
    let toml = r#"
name = "images"
present = "color"
[targets.pyramid]
format = "r32f"
size = [8, 8]
mips = 3
[targets.stack]
format = "rgba8"
size = [4, 4]
layers = 3
[targets.volume]
format = "r32i"
size = [4, 4, 2]
[targets.color]
format = "rgba32f"
[[passes]]
name = "base"
shader = "base.comp"
dispatch = { threads = "pyramid" }
bind = { dst = { target = "pyramid", mip = 0 } }
[[passes]]
name = "down1"
shader = "down.comp"
dispatch = { threads = "pyramid", mip = 1 }
bind = { src = { target = "pyramid", mip = 0 }, dst = { target = "pyramid", mip = 1 } }
[[passes]]
name = "down2"
shader = "down.comp"
dispatch = { threads = "pyramid", mip = 2 }
bind = { src = { target = "pyramid", mip = 1 }, dst = { target = "pyramid", mip = 2 } }
[[passes]]
name = "layers"
shader = "layers.comp"
dispatch = { threads = "stack" }
bind = { dst = "stack" }
[[passes]]
name = "volume"
shader = "volume.comp"
dispatch = { threads = "volume" }
bind = { dst = "volume" }
[[passes]]
name = "all"
shader = "all.comp"
dispatch = { threads = "color" }
[passes.bind]
pyramid = { target = "pyramid", filter = "linear" }
one = { target = "stack", layer = 2 }
stack = "stack"
volume = "volume"
outColor = "color"
"#;
    let files = [
        ("graphs/test.toml", toml),
        (
            "shaders/base.comp",
            "#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(r32f) writeonly uniform image2D dst;
void main() { ivec2 p = ivec2(gl_GlobalInvocationID.xy); imageStore(dst, p, vec4(p.x + 8 * p.y)); }",
        ),
        (
            "shaders/down.comp",
            "#version 460
layout(local_size_x = 2, local_size_y = 2) in;
layout(r32f) readonly uniform image2D src;
layout(r32f) writeonly uniform image2D dst;
void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy), q = 2 * p;
    float sum = imageLoad(src, q).r + imageLoad(src, q + ivec2(1, 0)).r + imageLoad(src, q + ivec2(0, 1)).r
              + imageLoad(src, q + ivec2(1, 1)).r;
    imageStore(dst, p, vec4(sum * 0.25));
}",
        ),
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
        (
            "shaders/all.comp",
            "#version 460
layout(local_size_x = 8, local_size_y = 4) in;
uniform sampler2D pyramid;
layout(rgba8) readonly uniform image2D one;
uniform sampler2DArray stack;
uniform isampler3D volume;
layout(rgba32f) writeonly uniform image2D outColor;
void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    float top = textureLod(pyramid, vec2(0.5), 2.0).r;
    float layer = texelFetch(stack, ivec3(p.x % 4, 0, 1), 0).r * 5.0;
    float two = imageLoad(one, ivec2(3, 0)).b * 5.0 + imageLoad(one, ivec2(0)).r * 500.0;
    imageStore(outColor, p, vec4(top, layer, two, texelFetch(volume, ivec3(1, 2, 1), 0).r));
}",
        ),
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
