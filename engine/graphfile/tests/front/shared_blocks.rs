//! `[blocks.*]`: values that are written once and fill every block of their name.

use std::fmt::Write as _;

use raxel_graph::checked::{Builtin, Graph, Value, ValueOrigin};

use crate::files::Project;

const PATH: &str = "graphs/held.toml";
const FIRST: &str = "shaders/first.comp";
const SECOND: &str = "shaders/second.comp";

const GRAPH: &str = include_str!("../fixtures/shared_blocks/held.toml");

/// The push constants by the name of their instance, with all four members in an order of their own.
const FIRST_TEXT: &str = include_str!("../fixtures/shared_blocks/first.comp");

/// A uniform block and the push constants, each by its own name, with some of the members.
const SECOND_TEXT: &str = include_str!("../fixtures/shared_blocks/second.comp");

fn project() -> Project {
    let mut project = Project::new();
    project.put(PATH, GRAPH);
    project.put(FIRST, FIRST_TEXT);
    project.put(SECOND, SECOND_TEXT);
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

fn pushed(graph: &Graph, pass: usize) -> Vec<(&str, u32, ValueOrigin)> {
    graph.passes[pass].push.iter().map(|fill| (&fill.member[..], fill.offset, fill.from.clone())).collect()
}

#[test]
fn a_shared_block_fills_every_block_of_its_name() {
    let graph = compiled(&project());
    let sun = ValueOrigin::Param(graph.find_param("sun").unwrap());
    let weight = |value| ValueOrigin::Value(Value::F32(value));
    assert_eq!(
        pushed(&graph, 0),
        [
            ("sun", 0, sun.clone()),
            ("weights[0]", 4, weight(1.0)),
            ("weights[1]", 8, weight(2.0)),
            ("index", 12, ValueOrigin::Builtin(Builtin::FrameIndex)),
            ("view", 16, ValueOrigin::Builtin(Builtin::CameraViewToWorld)),
        ]
    );
    // The pass's own value lies over it.
    assert_eq!(pushed(&graph, 1), [("index", 0, ValueOrigin::Value(Value::U32(7)))]);
    let shared = compiled(&project().edit(PATH, "push.index = 7\n", ""));
    assert_eq!(pushed(&shared, 1), [("index", 0, ValueOrigin::Builtin(Builtin::FrameIndex))]);

    // The same as a uniform block, whose members are far apart.
    let uniform = project()
        .edit(FIRST, "layout(push_constant) uniform Push", "layout(std140) uniform frame")
        .edit(FIRST, "} frame;", "} held;\n#define frame held")
        .edit(PATH, "push.index = 7\n", "");
    let graph = compiled(&uniform);
    let fills = &graph.passes[0].uniforms[0].fills;
    let offsets: Vec<_> = fills.iter().map(|fill| (&fill.member[..], fill.offset)).collect();
    assert_eq!(offsets, [("sun", 0), ("weights[0]", 16), ("weights[1]", 32), ("index", 48), ("view", 64)]);
    assert_eq!(fills[0].from, sun);
    // One element over the shared list.
    let element = uniform.edit(PATH, "bind = { outDepth", "uniforms.held.\"weights[1]\" = 9.0\nbind = { outDepth");
    let fills = &compiled(&element).passes[0].uniforms[0].fills;
    assert_eq!([&fills[1].from, &fills[2].from], [&weight(1.0), &weight(9.0)]);
}

#[test]
fn blocks_are_laid_over_those_of_a_base() {
    let mut project = project();
    let over = r#"extends = "held.toml"
[blocks.frame]
index = 3
weights = [4.0, 5.0]
[params.sun]
default = 2.0
"#;
    project.put("graphs/over.toml", over);
    let (graph, warnings) = project.compile("graphs/over.toml").0.unwrap_or_else(|_| panic!());
    assert_eq!(warnings, []);
    let values: Vec<_> = pushed(&graph, 0).into_iter().map(|(_, _, from)| from).collect();
    assert_eq!(
        values[1..4],
        [4.0, 5.0]
            .map(|value| ValueOrigin::Value(Value::F32(value)))
            .into_iter()
            .chain([ValueOrigin::Value(Value::U32(3))])
            .collect::<Vec<_>>()
    );
    // Taken away as a whole, and one member of it.
    project.put("graphs/over.toml", "extends = \"held.toml\"\nblocks.frame.remove = true\n");
    assert!(
        project.rendered("graphs/over.toml").contains("the shader has push constants, but pass `first` declares none")
    );
    project.put("graphs/over.toml", "extends = \"held.toml\"\nblocks.frame.sun = { remove = true }\n");
    assert!(project.rendered("graphs/over.toml").contains("`sun` of the shader has no value in `[blocks.frame]`"));
    project.put("graphs/over.toml", "extends = \"held.toml\"\nblocks.frame.moon = { remove = true }\n");
    assert!(project.rendered("graphs/over.toml").contains("the base has no member `moon`"));
}

/// A mistake in a shared block is one mistake, however many passes it fills.
#[test]
fn mistakes() {
    let cases: &[(&str, &str, &str, &str)] = &[
        ("RX0161", PATH, "index = \"frame.index\"", "index = \"frame.index\"\nmoon = 1.0"),
        ("RX0161", PATH, "[targets.depth]", "[blocks.Helt]\nunused = [0, 0, 0, 0]\n[targets.depth]"),
        ("RX0110", PATH, "index = \"frame.index\"\n", "indx = \"frame.index\"\n"),
        ("RX0110", PATH, "weights = [1.0, 2.0]\n", "\"weights[0]\" = 1.0\n"),
        ("RX0110", FIRST, "uint index;", "uint index;\n    float moon;"),
        ("RX0113", PATH, "type = \"f32\", from", "type = \"i32\", from"),
        ("RX0114", PATH, "view = \"camera.view_to_world\"", "view = \"camera.fov\""),
        ("RX0117", PATH, "weights = [1.0, 2.0]", "weights = [1.0, 2.0, 3.0]"),
        ("RX0104", PATH, "\"frame.index\"", "\"frame.indes\""),
        ("RX0111", PATH, "push.index = 7", "push.indx = 7"),
        ("RX0154", PATH, "[blocks.frame]", "[blocks.other]\nremove = true\n[blocks.frame]"),
        ("RX0108", PATH, "[blocks.frame]", "[blocks.\"the frame\"]"),
    ];
    let mut said = String::new();
    for (code, file, old, new) in cases {
        // A second pass over the same shader, in which everything is wrong in the same way.
        let twice = GRAPH.replace(
            "[[passes]]\nname = \"second\"",
            r#"[[passes]]
name = "again"
shader = "first.comp"
dispatch = { threads = "depth" }
bind = { outDepth = "depth" }

[[passes]]
name = "second""#,
        );
        let mut project = project();
        project.put(PATH, &twice);
        let text = project.edit(file, old, new).rendered(PATH);
        assert!(text.contains(&format!("[{code}]")), "{code} is not in\n{text}\nafter {old:?} → {new:?}");
        let file = file.rsplit('/').next().unwrap();
        writeln!(said, "──── {file}: {old:?} → {new:?}\n{text}").unwrap();
    }
    insta::assert_snapshot!(said);
}
