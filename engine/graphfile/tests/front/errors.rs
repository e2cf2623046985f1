//! Every class of mistake: what a person sees, whole. Each case is the one graph without a mistake, edited in one place.
//! `INSTA_UPDATE=always cargo test -p raxel-graph --release --test front` rewrites the snapshots; read the difference.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::sync::Arc;

use raxel_diagnostics::{Severity, SourceMap, codes};
use raxel_graph::checked::{Graph, Pass};
use raxel_graphfile::{Options, compile_with};
use raxel_shader::Compiler;

use crate::files::{Project, sources};

const BASE: &str = "graphs/base.toml";
const PRIMARY: &str = "shaders/primary.comp";
const PYRAMID: &str = "shaders/pyramid.comp";
const PROBES: &str = "shaders/probes.comp";

/// The code that is expected, the file that is edited, the piece, and what it becomes.
type Case = (&'static str, &'static str, &'static str, &'static str);

const NAMES: &[Case] = &[
    ("RX0100", BASE, r#"outHit = "hit""#, r#"outHit = "hti""#),
    ("RX0100", BASE, r#"present = "color""#, r#"present = "picture""#),
    ("RX0100", BASE, r#"threads = "hit""#, r#"threads = "hat""#),
    ("RX0100", BASE, r#"{ of = "hit", scale = 0.5 }"#, r#"{ of = "pit", scale = 0.5 }"#),
    ("RX0100", BASE, r#"indirect = "args""#, r#"indirect = "arguments""#),
    ("RX0101", BASE, r#"from = "param.exposure""#, r#"from = "param.exposre""#),
    ("RX0101", BASE, r#""!param.probes""#, r#""!param.probe""#),
    ("RX0103", BASE, r#"format = "rg32ui""#, r#"format = "rg32u""#),
    ("RX0103", BASE, r#"format = "rg32ui""#, r#"format = "R32G32_UINT""#),
    ("RX0104", BASE, r#"from = "camera.cell""#, r#"from = "camera.cel""#),
    ("RX0104", BASE, r#"from = "param.exposure""#, r#"from = "exposure""#),
    ("RX0104", BASE, r#"from = "camera.cell""#, r#"from = "moon.phase""#),
    ("RX0105", BASE, r#"source = "world.tree64""#, r#"source = "world.tree""#),
    ("RX0106", BASE, r#"when = "world.has_emission""#, r#"when = "world.has_emision""#),
    ("RX0106", BASE, r#"when = "world.has_emission""#, r#"when = "frame.index > 3""#),
    ("RX0107", BASE, "[buffers.rays]", "[buffers.hit]\nsize = 4\n[buffers.rays]"),
    ("RX0107", BASE, r#"name = "finish""#, r#"name = "pyramid""#),
    ("RX0108", BASE, "[params.tint]", "[params.\"tint@2\"]\ntype = \"f32\"\ndefault = 0.0\n[params.tint]"),
    (
        "RX0119",
        BASE,
        r#"type = "vec3"
default"#,
        r#"type = "float3"
default"#,
    ),
    ("RX0119", BASE, r#"{ type = "i32", value = 0 }"#, r#"{ type = "int", value = 0 }"#),
    ("RX0013", BASE, r#"present = "color""#, ""),
    ("RX0013", BASE, r#"shader = "pyramid.comp""#, ""),
    ("RX0013", BASE, r#"dispatch = { threads = "hit" }"#, ""),
    ("RX0013", BASE, r#"format = "r32f""#, ""),
    ("RX0013", BASE, "size = 64\n", ""),
    ("RX0013", BASE, "default = true", ""),
    (
        "RX0013",
        BASE,
        r#"name = "pyramid"
shader"#,
        "shader",
    ),
    ("RX0011", BASE, "dispatch = [4, 4]", "dispath = [4, 4]"),
];

const VALUES: &[Case] = &[
    ("RX0117", BASE, "default = [1.0, 1.0, 1.0]", "default = [1.0, 1.0]"),
    ("RX0117", BASE, "default = true", "default = 1"),
    ("RX0150", BASE, "clear = 0.0", "clear = [0.0, 1.0]"),
    ("RX0150", BASE, r#"format = "rg32ui""#, "format = \"rg32ui\"\nclear = 0.5"),
    ("RX0150", BASE, "init = 1\n\n[[passes]]", "init = 1.0\n\n[[passes]]"),
    ("RX0150", BASE, "init = [0.0, 0.0, 0.0, 1.0]", "init = true"),
    ("RX0015", BASE, "clear = 0.0", "clear = 0.0\ninit = 0.0"),
    ("RX0015", BASE, r#"source = "world.tree64""#, "source = \"world.tree64\"\nsize = 64"),
    ("RX0015", BASE, "size = [32, 32, 16]", "size = [32, 32, 16]\nlayers = 2"),
    ("RX0151", BASE, r#"format = "rg32ui""#, "format = \"rg32ui\"\nsize = { of = \"pyramid\" }"),
    ("RX0151", BASE, r#"size = { of = "hit", stride = 16 }"#, r#"size = { of = "rays", stride = 16 }"#),
    ("RX0122", BASE, r#"size = { of = "hit", stride = 16 }"#, r#"size = { of = "counters", stride = 16 }"#),
    ("RX0100", BASE, r#"size = { of = "hit", stride = 16 }"#, r#"size = { of = "wold", stride = 16 }"#),
    ("RX0015", BASE, r#"size = { of = "hit", stride = 16 }"#, r#"size = { of = "hit", scale = 0.5, stride = 16 }"#),
    ("RX0015", BASE, "size = [64, 64]\nlayers = 4", "size = { of = \"world\" }\nlayers = 4"),
    ("RX0014", BASE, r#"size = { of = "hit", stride = 16 }"#, "size = { count = 8, per = 2, stride = 16 }"),
    ("RX0014", BASE, r#"size = { of = "hit", stride = 16 }"#, r#"size = { of = "world", scale = 0, stride = 16 }"#),
    ("RX0108", BASE, r#"source = "world.tree64""#, "size = { count = 8, stride = 16 }"),
    ("RX0117", BASE, "size = 64\ninit = 0", "values = [1, true, 2, true]"),
    ("RX0117", BASE, "size = 64\ninit = 0", "values = [[1, 2], [3]]\ntype = \"vec2\""),
    ("RX0119", BASE, "size = 64\ninit = 0", "values = [1, 2]\ntype = \"float\""),
    ("RX0014", BASE, "size = 64\ninit = 0", "values = []"),
    ("RX0015", BASE, "size = 64\ninit = 0", "values = [1, 2]\nsize = 8"),
    ("RX0015", BASE, "size = 64\ninit = 0", "size = 64\ntype = \"f32\""),
    ("RX0126", BASE, "size = 64\ninit = 0", "values = [1, 2]\ntype = \"u32\""),
    ("RX0114", BASE, "size = { of = \"hit\", stride = 16 }\nclear = 0", "values = [[1, 2, 3]]\ntype = \"ivec3\""),
    ("RX0013", BASE, "size = 64\ninit = 0", "size = 64\ninit = 0\nwarnings = [{ offset = 4 }]"),
    ("RX0011", BASE, "size = 64\ninit = 0", "size = 64\ninit = 0\nwarnings = [{ says = \"lost\", ofset = 4 }]"),
    ("RX0014", BASE, "size = 64\ninit = 0", "size = 64\ninit = 0\nwarnings = [{ says = \"lost\", offset = 6 }]"),
    ("RX0014", BASE, "size = 64\ninit = 0", "size = 64\ninit = 0\nwarnings = [{ says = \" \" }]"),
    ("RX0012", BASE, "size = 64\ninit = 0", "size = 64\ninit = 0\nwarnings = { says = \"lost\" }"),
    ("RX0015", BASE, r#"source = "world.tree64""#, "source = \"world.tree64\"\nwarnings = [{ says = \"lost\" }]"),
    ("RX0152", BASE, r#"display = { map = "turbo", range = [0.0, 500.0] }"#, r#"display = "id""#),
    ("RX0152", BASE, r#"map = "turbo", range"#, r#"map = "turbo", channel = 1, range"#),
    ("RX0014", BASE, r#"map = "turbo", range = [0.0, 500.0]"#, r#"map = "jet""#),
    ("RX0014", BASE, "range = [0.0, 500.0]", "range = [500.0, 0.0]"),
    ("RX0014", BASE, "range = [0.0, 500.0]", "range = [1.0, 1.00000001]"),
    ("RX0153", BASE, "default = 1.0", "default = 9.0"),
    ("RX0153", BASE, "range = [0.0, 8.0]", "range = [8.0, 0.0]"),
    ("RX0153", BASE, "default = true", "default = true\nrange = [0.0, 1.0]"),
    ("RX0157", BASE, "default = true", "default = true\nchoices = [\"off\", \"on\"]"),
    ("RX0157", BASE, "type = \"bool\"\ndefault = true", "type = \"u32\"\ndefault = 2\nchoices = [\"off\", \"on\"]"),
    ("RX0157", BASE, "type = \"bool\"\ndefault = true", "type = \"u32\"\ndefault = 0\nchoices = [\"off\", \"off\"]"),
    (
        "RX0015",
        BASE,
        "type = \"bool\"\ndefault = true",
        "type = \"u32\"\ndefault = 0\nchoices = [\"off\", \"on\"]\nrange = [0, 1]",
    ),
    ("RX0014", BASE, "default = true", "default = true\nchoices = [\"off\"]"),
    ("RX0014", BASE, "default = true", "default = true\nchoices = [\"off\", \" \"]"),
    ("RX0012", BASE, "default = true", "default = true\nchoices = [\"off\", 1]"),
    ("RX0158", BASE, "default = true", "default = true\ncolor = true"),
    ("RX0012", BASE, "default = true", "default = true\nunit = 3"),
    ("RX0014", BASE, "dispatch = [4, 4]", "dispatch = [4, 4]\nsubgroup = 48"),
    ("RX0014", BASE, "dispatch = [4, 4]", "dispatch = [4, 4]\nsubgroup = 256"),
    ("RX0014", BASE, "hz = 20", "hz = 0"),
    ("RX0014", BASE, "frames = 4", "frames = 0"),
    ("RX0014", BASE, "size = 0.5", "size = -0.5"),
    ("RX0014", BASE, "size = [32, 32, 16]", "size = [32, 0, 16]"),
    ("RX0014", BASE, "size = [32, 32, 16]", "size = [32]"),
    ("RX0012", BASE, "history = 1", "history = \"one\""),
    ("RX0014", BASE, "size = { count = 4, stride = 12 }", "size = { count = 4, stride = 10 }"),
    ("RX0128", BASE, "layers = 4", "layers = 4\nmips = 8"),
    ("RX0146", BASE, "MAX_STEPS = 256", "\"MAX-STEPS\" = 256, MAX_STEPS = 256"),
    ("RX0146", BASE, "NAME = \"vec3(1)\"", "NAME = \"vec3(\\n1)\""),
    ("RX0147", BASE, "!param.probes", "!param.exposure"),
];

const BINDINGS: &[Case] = &[
    ("RX0120", BASE, r#"outDepth = "half_depth", "#, ""),
    ("RX0121", BASE, r#"outDepth = "half_depth""#, r#"outDeph = "half_depth""#),
    ("RX0121", BASE, r#"depth = "half_depth" }"#, r#"depth = "half_depth", everything = "hit" }"#),
    ("RX0121", PYRAMID, "texelFetch(depth, pixel * 4, 0)", "0.0"),
    ("RX0121", BASE, r#"depth = "half_depth" }"#, r#"near = "half_depth" }"#),
    ("RX0122", BASE, r#"world = "world""#, r#"world = "hit""#),
    ("RX0122", BASE, r#"outHit = "hit""#, r#"outHit = "counters""#),
    ("RX0122", BASE, r#"threads = "hit""#, r#"threads = "counters""#),
    ("RX0122", BASE, r#"indirect = "args""#, r#"indirect = "masks""#),
    ("RX0122", BASE, "counters = \"counters\"\n", "counters = { target = \"counters\", mip = 0 }\n"),
    ("RX0123", BASE, r#"format = "r32f""#, r#"format = "r16f""#),
    ("RX0123", PRIMARY, "layout(rgba16f)", "layout(rgba32f)"),
    ("RX0124", PYRAMID, "uniform sampler2D depth", "uniform usampler2D depth"),
    ("RX0125", BASE, "size = [32, 32, 16]", "size = [32, 32]"),
    ("RX0125", BASE, "mask = { target = \"masks\", layer = 1 }", "mask = \"masks\""),
    ("RX0125", BASE, "cascades = \"cascades\"\n", "cascades = \"irradiance\"\n"),
    ("RX0126", BASE, r#"outColor = "color""#, r#"outColor = "color@1""#),
    ("RX0126", "shaders/include/world.glsl", "readonly ", ""),
    ("RX0127", BASE, "color@1", "color@2"),
    ("RX0127", BASE, "color@1", "color@last"),
    ("RX0127", BASE, r#"present = "color""#, r#"present = "color@1""#),
    ("RX0128", BASE, "{ target = \"pyramid\", mip = 1 }", "{ target = \"pyramid\", mip = 5 }"),
    ("RX0128", BASE, "layer = 2", "layer = 3"),
    ("RX0128", BASE, "threads = \"pyramid\", mip = 1", "threads = \"pyramid\", mip = 5"),
    ("RX0129", BASE, "{ target = \"pyramid\", mip = 1 }", "\"pyramid\""),
    ("RX0129", BASE, "indirect = \"args\", offset = 12", "indirect = \"counters\""),
    (
        "RX0130",
        PYRAMID,
        "uniform sampler2D depth;",
        "uniform texture2D depth;\nuniform sampler s;\n#define texelFetch(a, b, c) texelFetch(sampler2D(a, s), b, c)",
    ),
    ("RX0131", PYRAMID, "sampler2D depth;", "sampler2D depth[2];\n#define depth depth[0]"),
    ("RX0132", "shaders/include/world.glsl", "ivec3 origin;\n    uint root;", "uint root;\n    ivec3 origin;"),
    ("RX0132", "shaders/include/world.glsl", "uint words[];", "int words[];"),
    ("RX0132", "shaders/include/world.glsl", "ivec3 origin;", "vec3 origin;"),
    ("RX0133", BASE, "{ target = \"pyramid\", mip = 0 }", "{ target = \"pyramid\", mip = 0, filter = \"linear\" }"),
    ("RX0133", BASE, "depth = \"half_depth\" }", "depth = { target = \"hit\", filter = \"linear\" } }"),
    ("RX0134", BASE, "size = 64\n", "size = 32\n"),
    ("RX0135", BASE, "{ of = \"hit\", stride = 16 }", "{ of = \"hit\", stride = 12 }"),
    ("RX0135", BASE, "{ of = \"hit\", stride = 16 }", "{ of = \"hit\", per = 2, stride = 64 }"),
    ("RX0135", BASE, "{ of = \"hit\", stride = 16 }", "{ count = 10, stride = 32 }"),
];

const BLOCKS: &[Case] = &[
    ("RX0110", BASE, "exposure    = { type = \"f32\", from = \"param.exposure\" }\n", ""),
    (
        "RX0110",
        BASE,
        "colors = [[0.0, 0.3, 0.8, 1.0], [1.0, 1.0, 1.0, 1.0]]\n",
        "\"colors[0]\" = [0.0, 0.3, 0.8, 1.0]\n",
    ),
    (
        "RX0110",
        PYRAMID,
        "void main() {",
        "layout(push_constant) uniform Push { float bias; int level; };\nvoid main() { if (bias > level) return;",
    ),
    ("RX0111", BASE, "exposure    = {", "exposre     = {"),
    ("RX0111", BASE, "extent      = ", "fov         = \"camera.fov\"\nextent      = "),
    (
        "RX0111",
        BASE,
        "[passes.uniforms.sky.sun]\ndirection",
        "[passes.uniforms.sky.moon]\nphase = 1.0\n[passes.uniforms.sky.sun]\ndirection",
    ),
    ("RX0112", BASE, "offset = 16", "offset = 12"),
    ("RX0113", BASE, "exposure    = { type = \"f32\"", "exposure    = { type = \"i32\""),
    ("RX0113", BASE, "colors = [[", "colors.type = \"vec4[3]\"\ncolors.value = [["),
    ("RX0114", BASE, "extent      = \"target.hit.size\"", "extent      = \"camera.fov\""),
    ("RX0114", BASE, "{ type = \"ivec3\", from = \"camera.cell\" }", "{ type = \"ivec3\", from = \"camera.frac\" }"),
    ("RX0115", PRIMARY, "ivec2 extent;", "ivec2 extent;\n    vec4 more[2];"),
    ("RX0116", PRIMARY, "int debug_mode;", "double debug_mode;"),
    ("RX0117", BASE, "{ type = \"i32\", value = 0 }", "{ type = \"i32\", value = 0.5 }"),
    ("RX0117", BASE, "value = [0, 1, 0]", "value = [0, 1]"),
    ("RX0117", BASE, "colors = [[0.0, 0.3, 0.8, 1.0], ", "colors = ["),
    ("RX0118", BASE, "depth = \"half_depth\" }", "depth = \"half_depth\" }\npush = { level = 1 }"),
    ("RX0118", BASE, "[passes.uniforms.sky]", "[passes.uniforms.Sky]\nsun = 1.0\n[passes.uniforms.sky]"),
    ("RX0118", BASE, "[passes.uniforms.sky]", "[passes.uniforms.outHit]\nsun = 1.0\n[passes.uniforms.sky]"),
    (
        "RX0015",
        BASE,
        "debug_mode  = { type = \"i32\", value = 0 }",
        "debug_mode  = { value = 0, from = \"frame.index\" }",
    ),
    ("RX0015", BASE, "Rays = \"rays\" }", "Rays = \"rays\", sky = \"counters\" }"),
    ("RX0014", BASE, "debug_mode  = { type = \"i32\", value = 0 }", "debug_mode  = { type = \"i32\" }"),
];

const DISPATCH: &[Case] = &[
    ("RX0140", BASE, "dispatch = [4, 4]", "dispatch = [4, 0]"),
    ("RX0140", BASE, "dispatch = [4, 4]", "dispatch = { threads = [0, 4, 4] }"),
    ("RX0014", BASE, "dispatch = [4, 4]", "dispatch = { groups = [4, 4], threads = \"hit\" }"),
    ("RX0014", BASE, "dispatch = [4, 4]", "dispatch = { threads = [4, 4], mip = 1 }"),
    ("RX0014", BASE, "dispatch = [4, 4]", "dispatch = { threads = \"hit\", tile = [8, 8] }"),
    ("RX0140", BASE, "dispatch = [4, 4]", "dispatch = { groups = \"hit\", tile = [8, 0] }"),
    ("RX0128", BASE, "dispatch = [4, 4]", "dispatch = { groups = \"hit\", mip = 3 }"),
    ("RX0122", BASE, "dispatch = [4, 4]", "dispatch = { groups = \"args\" }"),
    ("RX0012", BASE, "dispatch = [4, 4]", "dispatch = \"hit\""),
    ("RX0142", BASE, "offset = 12 }", "offset = 10 }"),
    ("RX0142", BASE, "offset = 12 }", "offset = 40 }"),
    ("RX0142", BASE, "indirect = \"args\", offset = 12", "indirect = \"world\""),
    ("RX0142", BASE, "indirect = \"args\", offset = 12", "count = \"args\", offset = 48"),
    ("RX0142", BASE, "indirect = \"args\", offset = 12", "count = \"args\", offset = 6"),
    ("RX0142", BASE, "indirect = \"args\", offset = 12", "count = \"world\""),
    ("RX0100", BASE, "indirect = \"args\", offset = 12", "count = \"arg\""),
    ("RX0122", BASE, "indirect = \"args\", offset = 12", "count = \"hit\""),
    ("RX0014", BASE, "indirect = \"args\", offset = 12", "count = \"args\", indirect = \"args\""),
    ("RX0100", BASE, "indirect = \"args\", offset = 12", "indirect = \"probe_update.arguments\""),
    ("RX0143", BASE, "WIDTH = 8", "WIDTH = 0"),
    ("RX0144", BASE, "BOUNCES = 2", "BOUNCE = 2"),
    ("RX0144", BASE, "shader = \"pyramid.comp\"", "shader = \"pyramid.comp\"\nspecialization = { LEVELS = 2 }"),
    ("RX0145", BASE, "BOUNCES = 2", "BOUNCES = 2.0"),
    ("RX0145", BASE, "BOUNCES = 2", "BOUNCES = \"buffer.rays.count\""),
    ("RX0145", BASE, "BOUNCES = 2", "BOUNCES = \"param.exposure\""),
    ("RX0122", BASE, "dispatch = { threads = \"hit\" }", "dispatch = { threads = \"rays\", mip = 1 }"),
    ("RX0122", BASE, "WIDTH = 8", "WIDTH = \"buffer.counters.count\""),
    ("RX0122", BASE, "WIDTH = 8", "WIDTH = \"buffer.hit.count\""),
    ("RX0104", BASE, "WIDTH = 8", "WIDTH = \"buffer.rays.size\""),
    ("RX0005", BASE, "shader = \"pyramid.comp\"", "shader = \"../../pyramid.comp\""),
    ("RX0001", BASE, "shader = \"pyramid.comp\"", "shader = \"pyramyd.comp\""),
];

const FLOW: &[Case] = &[
    ("RX0160", BASE, "init = 1\n\n[targets.irradiance]", "\n[targets.irradiance]"),
    ("RX0160", BASE, "init = 1\n\n[[passes]]", "init = 1\nwarnings = [{ says = \"lost\" }]\n\n[[passes]]"),
    ("RX0161", BASE, "[buffers.rays]", "[buffers.spare]\nsize = 4\n[buffers.rays]"),
    ("RX0161", BASE, "when = \"!param.probes\"\n", ""),
    ("RX0162", BASE, "present = \"color\"", "present = \"picture\"\ntargets.picture.format = \"rgba8\""),
    (
        "RX0164",
        PROBES,
        "layout(local_size_x = 4",
        "#extension GL_EXT_shader_atomic_float : require\nshared float sum;\n#define atomicAdd(a, b) atomicAdd(a, b) + uint(atomicAdd(sum, 1.0))\nlayout(local_size_x = 4",
    ),
    ("RX0163", BASE, "depth = \"half_depth\" }", "depth = { target = \"half_depth\", filter = \"linear\" } }"),
    ("RX0163", BASE, "dispatch = [4, 4]", "dispatch = [80000, 70000]"),
    ("RX0152", BASE, "display = \"raw\"", "display = { map = \"raw\", range = [0.0, 2.0] }"),
    (
        "RX0163",
        PROBES,
        "void main() {",
        "shared double sum;\nvoid main() { sum = counters.total; counters.each[1] = uint(sum);",
    ),
];

#[test]
fn names() {
    check("names", NAMES);
}

#[test]
fn values() {
    check("values", VALUES);
}

#[test]
fn bindings() {
    check("bindings", BINDINGS);
}

#[test]
fn blocks() {
    check("blocks", BLOCKS);
}

#[test]
fn dispatch() {
    check("dispatch", DISPATCH);
}

#[test]
fn flow() {
    check("flow", FLOW);
}

/// The writers of a wrong target are not known, so no message names them.
#[test]
fn a_wrong_target_is_not_unwritten_too() {
    let project = Project::new().edit(BASE, "present = \"color\"", "present = \"half_depth\"");
    let text =
        project.edit(BASE, r#"display = { map = "turbo", range = [0.0, 500.0] }"#, r#"display = "id""#).rendered(BASE);
    assert!(text.contains("[RX0152]") && !text.contains("[RX0162]"), "{text}");
}

/// A key that is there under a wrong name is one mistake, and not a missing one as well.
#[test]
fn a_misspelt_key_is_said_once() {
    for (right, wrong) in [
        ("present = \"color\"", "presnt = \"color\""),
        ("name    = \"base\"", "nmae    = \"base\""),
        ("format = \"rg32ui\"", "fromat = \"rg32ui\""),
    ] {
        let text = Project::new().edit(BASE, right, wrong).rendered(BASE);
        assert_eq!((text.matches("error[").count(), text.matches("[RX0011]").count()), (1, 1), "{text}");
    }
}

/// Every case has its code, and all messages of a family of cases are one snapshot.
fn check(family: &str, cases: &[Case]) {
    let mut said = String::new();
    for (code, file, old, new) in cases {
        let text = Project::new().edit(file, old, new).rendered(BASE);
        assert!(text.contains(&format!("[{code}]")), "{code} is not in\n{text}\nafter {old:?} → {new:?}");
        writeln!(said, "──── {file}: {old:?} → {new:?}\n{text}").unwrap();
    }
    insta::assert_snapshot!(family, said);
}

/// A code without a case is a check that was never seen to fail.
#[test]
fn every_code_of_the_front_end_has_a_case() {
    let families: [&[Case]; 6] = [NAMES, VALUES, BINDINGS, BLOCKS, DISPATCH, FLOW];
    let mut seen: BTreeSet<&str> = families.into_iter().flatten().map(|case| case.0).collect();
    seen.extend(crate::extends::CODES);
    seen.extend(crate::clocks::CODES);
    seen.extend(crate::supplied::CODES);
    let all = codes::graph::ALL.iter().map(|(code, _)| code.as_str()).filter(|code| *code < "RX0170");
    let missing: Vec<&str> = all.filter(|code| !seen.contains(code)).collect();
    assert!(missing.is_empty(), "no case for {missing:?}");
}

/// A term that is commented out takes its bindings, its block and its members with it. In a running window that is a warning, and every resource is
/// accessed as before.
#[test]
fn what_a_shader_does_not_use_is_a_warning_where_that_is_asked_for() {
    let compile = |project: &Project, unused: Severity| {
        let compiler = Compiler::new(Arc::new(project.clone()));
        let options = Options { unused, ..Options::default() };
        compile_with(BASE, project, &compiler, &sources(), options, &mut SourceMap::default())
    };
    let accesses = |graph: &Graph| -> Vec<_> {
        let of_pass = |pass: &Pass| {
            let mut accesses: Vec<_> =
                pass.accesses.iter().map(|a| (a.resource.0, a.age, a.mips, a.access, a.usage)).collect();
            accesses.sort_by_key(|access| (access.0, access.1));
            accesses
        };
        graph.passes.iter().map(of_pass).collect()
    };
    let push = "layout(push_constant) uniform Push { float bias; } push;\nvoid main() {";
    let bias = "depth = \"half_depth\" }\npush = { bias = 1.0, slope = 2.0 }";
    let whole = Project::new().edit(BASE, "depth = \"half_depth\" }", bias).edit(PYRAMID, "void main() {", push).edit(
        PYRAMID,
        "texelFetch(depth, pixel * 4, 0)",
        "texelFetch(depth, pixel * 4, 0) * push.bias",
    );
    let (graph, warnings) = compile(&whole, Severity::Warning).expect("only a member too many");
    assert_eq!(warnings.iter().map(|warning| warning.code.as_str()).collect::<Vec<_>>(), ["RX0111"]);

    let without = whole.edit(PYRAMID, "texelFetch(depth, pixel * 4, 0) * push.bias", "vec4(0.0)");
    let (less, warnings) = compile(&without, Severity::Warning).expect("only warnings");
    let said: Vec<&str> = warnings.iter().map(|warning| warning.message.as_str()).collect();
    let expected = [
        "`shaders/pyramid.comp` declares `depth` and does not use it",
        "`shaders/pyramid.comp` declares push constants and does not use them",
    ];
    assert_eq!(said, expected);
    assert_eq!(accesses(&less), accesses(&graph));

    let errors = compile(&without, Severity::Error).expect_err("`raxel check` is strict");
    let said: Vec<&str> = errors.iter().filter(|error| error.is_error()).map(|error| error.message.as_str()).collect();
    assert_eq!(said, expected);
}

/// A base that was emptied is one mistake, and not also everything that the graph over it refers to.
#[test]
fn an_empty_graph_is_said_to_be_empty() {
    let mut project = Project::new();
    project.put("graphs/over.toml", "extends = \"base.toml\"\n[params.exposure]\ndefault = 2.0\n");
    for text in ["", "# Nothing.\n"] {
        project.put(BASE, text);
        for path in [BASE, "graphs/over.toml"] {
            let said = project.rendered(path);
            assert!(said.contains("`graphs/base.toml` is empty") && said.matches("error[").count() == 1, "{said}");
        }
    }
}

#[test]
fn all_mistakes_of_all_passes_come_at_once() {
    let project = Project::new()
        .edit(BASE, r#"outHit = "hit""#, r#"outHit = "hti""#)
        .edit(BASE, r#"exposure    = { type = "f32""#, r#"exposure    = { type = "i32""#)
        .edit(BASE, r#"format = "r8""#, r#"format = "r9""#)
        .edit(BASE, "dispatch = [4, 4]", "dispatch = [4, 0]")
        .edit(PYRAMID, "uniform sampler2D depth", "uniform usampler2D depth");
    insta::assert_snapshot!("at_once", project.rendered(BASE));
}

#[test]
fn errors_of_several_shaders_come_together_and_once_each() {
    let project =
        Project::new().edit(PYRAMID, "imageStore(below", "imageSture(below").edit(PROBES, "vec4 light", "vec5 light");
    let text = project.rendered(BASE);
    assert!(text.contains("imageSture") && text.contains("vec5"), "{text}");
    // Two passes use probes.comp; its mistakes are reported for the first.
    assert_eq!(text.matches("for pass `probe_update`").count(), text.matches("for pass").count() - 1, "{text}");
}

/// Thousands of targets, each a part of the next, are followed once, and the cycle at their end is reported once.
#[test]
fn a_long_chain_of_sizes_ends_in_one_cycle() {
    let chain: String = (0..4000).fold(String::new(), |mut chain, n| {
        let next = if n == 3999 { 3998 } else { n + 1 };
        writeln!(chain, "[targets.part{n}]\nformat = \"r8\"\nsize = {{ of = \"part{next}\" }}").unwrap();
        chain
    });
    let mut project = Project::new();
    project.put("graphs/chain.toml", &format!("extends = \"base.toml\"\n{chain}"));
    let text = project.rendered("graphs/chain.toml");
    assert_eq!(text.matches("[RX0151]").count(), 1, "{text}");
    assert!(text.contains("the size of `part3998` is measured by itself: part3998 → part3999 → part3998\n"), "{text}");
}

#[test]
fn a_wrong_value_of_a_table_is_one_mistake() {
    let mut project = Project::new();
    let table = "[buffers.weights]\ntype = \"vec2\"\nvalues = [[1.0, \"x\"]]\n";
    project.put("graphs/table.toml", &format!("extends = \"base.toml\"\n{table}"));
    let text = project.rendered("graphs/table.toml");
    assert!(text.contains("[RX0012]") && !text.contains("[RX0015]"), "{text}");
}
