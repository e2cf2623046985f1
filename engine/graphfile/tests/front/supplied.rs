//! Targets that come from outside: what may be done with them, what a graph need not say, and every mistake.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::Arc;

use raxel_diagnostics::SourceMap;
use raxel_graph::checked::{Extent, Graph, Interval, ResourceKind, Usage};
use raxel_graph::plan::{DeviceLimits, Lifetime, PlanInput, Present, ResourceDesc, SourceSize, Step};
use raxel_graph::{plan, print};
use raxel_graphfile::{Options, compile_with};
use raxel_shader::Compiler;
use raxel_shader::format::Format;

use crate::files::{Project, sources};

const PATH: &str = "graphs/volume.toml";
const SHADER: &str = "shaders/volume.comp";

const GRAPH: &str = include_str!("../fixtures/supplied/volume.toml");

const TEXT: &str = include_str!("../fixtures/supplied/volume.comp");

fn project() -> Project {
    let mut project = Project::new();
    project.put(PATH, GRAPH);
    project.put(SHADER, TEXT);
    project
}

fn compiled(project: &Project) -> Graph {
    match project.compile(PATH).0 {
        Ok((graph, warnings)) => {
            assert_eq!(warnings, []);
            graph
        }
        Err(found) => panic!("{found:#?}"),
    }
}

/// Binding, resource and source of each access of the only pass.
fn bound(graph: &Graph) -> Vec<(&str, &str, Option<&str>)> {
    let pass = &graph.passes[0];
    let names = pass.accesses.iter().map(|access| {
        let resource = graph.resource(access.resource);
        let binding = &pass.shader.interface.bindings[access.binding.unwrap() as usize];
        (binding.name.as_str(), resource.name.as_str(), resource.source())
    });
    let mut names: Vec<_> = names.collect();
    names.sort_unstable();
    names
}

const EXPLICIT: [(&str, &str, Option<&str>); 3] = [
    ("outColor", "color", None),
    ("world", "world", Some("world.texture3d")),
    ("world_voxels", "voxels", Some("world.texture3d")),
];

#[test]
fn a_source_says_what_a_target_is() {
    let graph = compiled(&project());
    let voxels = graph.resource(graph.find_resource("voxels").unwrap());
    let ResourceKind::Target(target) = &voxels.kind else { panic!("{voxels:?}") };
    assert_eq!((target.format, target.extent, target.mips, target.layers), (Format::R16ui, Extent::Source, 0, 1));
    assert_eq!(bound(&graph), EXPLICIT);
    let access = graph.passes[0].accesses.iter().find(|access| access.usage == Usage::SampledImage).unwrap();
    assert_eq!((access.mips, access.access.writes()), (Interval::ALL, false), "all mips, to be read");
    assert!(graph.passes[0].shader.request.defines.contains(&("RX_LAYOUT_TEXTURE3D".to_owned(), "1".to_owned())));
}

#[test]
fn the_image_of_a_bound_buffer_need_not_be_named() {
    let unbound = project().edit(PATH, "world_voxels = \"voxels\", ", "");
    assert_eq!(bound(&compiled(&unbound)), EXPLICIT, "the target with that source is taken");
    let undeclared = unbound.edit(PATH, "[targets.voxels]\nsource = \"world.texture3d\"\ndisplay = \"id\"\n", "");
    let mut expected = EXPLICIT;
    expected[2].1 = "world_voxels";
    assert_eq!(bound(&compiled(&undeclared)), expected);
    // The name may be taken.
    let taken =
        undeclared.clone().edit(PATH, "[targets.color]", "[buffers.world_voxels]\nsize = 4\ninit = 1\n[targets.color]");
    expected[2].1 = "world_voxels_";
    let (compiled, _) = taken.compile(PATH);
    assert_eq!(bound(&compiled.unwrap().0), expected);
    // A source without an image has none to bind.
    let text = undeclared.edit(PATH, "world.texture3d", "world.tree64").rendered(PATH);
    assert!(text.contains("`world_voxels` is bound to nothing"), "{text}");
}

#[test]
fn a_graph_can_be_compiled_over_another_source() {
    let over = |project: &Project, source: &str| {
        let replace = |known: &str| known.starts_with("world.").then(|| source.to_owned());
        let compiler = Compiler::new(Arc::new(project.clone()));
        let options = Options { replace: &replace, ..Options::default() };
        compile_with(PATH, project, &compiler, &sources(), options, &mut SourceMap::default())
    };
    // A shader that follows the layout, as those do that include <raxel/world.glsl>.
    let follows = project()
        .edit(
            SHADER,
            "uniform usampler3D world_voxels;",
            "#ifdef RX_LAYOUT_TEXTURE3D\nuniform usampler3D world_voxels;\n#endif",
        )
        .edit(
            SHADER,
            "vec4(texelFetch(world_voxels, ivec3(pixel, world.root), 2))",
            "vec4(world.root)\n#ifdef RX_LAYOUT_TEXTURE3D\n * texelFetch(world_voxels, ivec3(0), 0)\n#endif\n",
        );
    let tree = over(&follows, "world.tree64").expect("the image and its binding are left out").0;
    assert_eq!(bound(&tree), [("outColor", "color", None), ("world", "world", Some("world.tree64"))]);
    assert_eq!(tree.find_resource("voxels"), None);

    let from_tree = follows
        .edit(PATH, "[targets.voxels]\nsource = \"world.texture3d\"\ndisplay = \"id\"\n", "")
        .edit(PATH, "world.texture3d", "world.tree64")
        .edit(PATH, "world_voxels = \"voxels\", ", "");
    assert_eq!(bound(&compiled(&from_tree)), bound(&tree));
    let volume = over(&from_tree, "world.texture3d").expect("the image is bound").0;
    assert_eq!(bound(&volume)[2].2, Some("world.texture3d"));
}

/// Nothing is made, cleared, ordered or shared of what comes from outside, and its size is the supplier's.
#[test]
fn plans_take_it_as_it_is() {
    let graph = Arc::new(compiled(&project()));
    let present = |resource: &str, mip| Present { mip, ..Present::of(graph.find_resource(resource).unwrap()) };
    let plan_within = |image_3d, image, present| {
        let sources = BTreeMap::from([("world.texture3d".to_owned(), SourceSize { bytes: 96, image })]);
        let limits = DeviceLimits { image_3d, ..DeviceLimits::PORTABLE };
        let input = PlanInput { present, limits, ..PlanInput::on_paper(&graph, [64, 32], &sources) };
        plan(graph.clone(), &input)
    };
    let plan = |image, present| plan_within(128, image, present);
    let made = plan(Some([64, 64, 128]), present("color", 0)).expect("it fits");
    let voxels = made.resources.iter().find(|planned| planned.resource == graph.find_resource("voxels").unwrap());
    let voxels = voxels.expect("it is live");
    let ResourceDesc::SourceImage(source, image) = &voxels.desc else { panic!("{voxels:?}") };
    assert_eq!((source.as_str(), image.extent, image.mips, image.volume), ("world.texture3d", [64, 64, 128], 8, true));
    assert_eq!((voxels.lifetime, voxels.clear, voxels.copies), (Lifetime::Persistent, None, 1));
    assert!(made.steps.iter().all(|step| !matches!(step, Step::Clear { .. })), "{:?}", made.steps);
    let text = print::text(&made);
    assert!(text.contains("r16ui 64×64×128, 8 mips from world.texture3d"), "{text}");
    let line = text.lines().find(|line| line.contains("from world.texture3d") && line.contains("voxels")).unwrap();
    assert!(line.ends_with("supplied"), "{line}");

    // Before it is there, no mip of it is too many; once it is there, some are.
    let unmade = print::text(&plan(None, present("voxels", 7)).expect("nothing is known against it"));
    let line = unmade.lines().find(|line| line.contains("r16ui from world.texture3d")).unwrap();
    assert!(line.contains(" — ") && line.ends_with("supplied"), "{line}");
    assert!(plan(Some([64, 64, 128]), present("voxels", 7)).is_ok());
    let errors = plan(Some([64, 64, 128]), present("voxels", 8)).expect_err("it has eight");
    assert!(errors[0].message.contains("no mip 8"), "{errors:?}");
    let errors = plan_within(127, Some([64, 64, 128]), present("color", 0)).expect_err("it is too deep");
    assert!(errors[0].message.contains("64×64×128 texels, but the device allows 127"), "{errors:?}");
}

/// The edit, and the message.
const MISTAKES: [(&str, &str, &str, &str); 12] = [
    (
        "RX0126",
        SHADER,
        "uniform usampler3D world_voxels;",
        "layout(r16ui) uniform uimage3D world_voxels;\nuvec4 both(ivec3 at) { imageStore(world_voxels, at, uvec4(1)); return imageLoad(world_voxels, at); }\n#define texelFetch(i, at, mip) both(at)",
    ),
    ("RX0015", PATH, "display = \"id\"", "format = \"r16ui\""),
    ("RX0015", PATH, "display = \"id\"", "size = [8, 8, 8]\nclear = 0"),
    (
        "RX0105",
        PATH,
        "[targets.voxels]\nsource = \"world.texture3d\"",
        "[targets.voxels]\nsource = \"world.texture2d\"",
    ),
    ("RX0122", PATH, "[targets.voxels]\nsource = \"world.texture3d\"", "[targets.voxels]\nsource = \"world.tree64\""),
    ("RX0122", PATH, "threads = \"color\"", "threads = \"voxels\""),
    ("RX0122", PATH, "format = \"rgba8\"", "format = \"rgba8\"\nsize = { of = \"voxels\" }"),
    ("RX0124", SHADER, "usampler3D", "sampler3D"),
    (
        "RX0125",
        SHADER,
        "uniform usampler3D world_voxels;",
        "uniform usampler2D world_voxels;\n#define texelFetch(i, at, mip) texelFetch(i, ivec2(0), mip)",
    ),
    ("RX0127", PATH, "\"voxels\"", "\"voxels@1\""),
    ("RX0128", PATH, "\"voxels\"", "{ target = \"voxels\", layer = 1 }"),
    ("RX0152", PATH, "display = \"id\"", "display = \"color\""),
];

#[test]
fn mistakes() {
    let mut said = String::new();
    for (code, file, old, new) in MISTAKES {
        let mut changed = project();
        let text = String::from_utf8(changed.files[file].to_vec()).unwrap();
        changed.put(file, &text.replacen(old, new, 1));
        let text = changed.rendered(PATH);
        let _ = writeln!(said, "──── {file}: {old:?} → {new:?}\n{text}");
        if !text.contains(&format!("[{code}]")) {
            let _ = writeln!(said, "!!!! no {code}");
        }
    }
    assert!(!said.contains("!!!!"), "{said}");
    insta::assert_snapshot!("supplied", said);
}

#[test]
fn a_base_with_a_source_is_overlaid() {
    let over = |text: &str| {
        let mut project = project();
        project.put("graphs/over.toml", &format!("extends = \"volume.toml\"\n{text}"));
        project
    };
    // A resource that is made here in place of a supplied one.
    let made = over("[targets.voxels]\nformat = \"r16ui\"\nsize = [4, 4, 4]\nmips = 3\ninit = 0");
    let (graph, _) = made.compile("graphs/over.toml").0.unwrap_or_else(|found| panic!("{found:#?}"));
    let ResourceKind::Target(target) = &graph.resource(graph.find_resource("voxels").unwrap()).kind else { panic!() };
    assert_eq!((target.source.as_ref(), target.extent), (None, Extent::Fixed3([4; 3])));
    // A key that the source excludes is met across files too.
    let text = over("[targets.voxels]\nmips = 3").rendered("graphs/over.toml");
    assert!(
        text.contains("[RX0015]") && text.contains("graphs/over.toml:3") && text.contains("graphs/volume.toml:8"),
        "{text}"
    );
}

/// Codes that are met here.
pub(crate) const CODES: [&str; 1] = ["RX0156"];

#[test]
fn a_file_that_cannot_be_read_is_an_error_at_its_name() {
    let graph = r#"
name = "files"
present = "color"
[targets.color]
source = "file.textures/a.png"
encoding = "srgb"
"#;
    let text = |text: &str| {
        let mut project = Project::new();
        project.put(PATH, text);
        project.rendered(PATH)
    };
    let said = text(graph);
    assert!(said.contains("[RX0156]") && said.contains("textures/a.png") && said.contains("named here"), "{said}");
    // Keys of files are of files only, and a file has its own extent.
    let said = text(&graph.replace("source = \"file.textures/a.png\"", "format = \"rgba8\""));
    assert!(said.contains("is from no file and takes no `encoding`"), "{said}");
    let said = text(&graph.replace("encoding = \"srgb\"", "size = [4, 4]"));
    assert!(said.contains("[RX0015]"), "{said}");
    let said = text(&graph.replace("file.textures/a.png", "file.../a.png"));
    assert!(said.contains("[RX0005]"), "{said}");
}
