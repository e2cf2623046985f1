//! Graphs that extend others.

use std::fmt::Write as _;

use raxel_graph::checked::{Clear, Dispatch, ResourceKind, Value};

use crate::files::Project;

/// The codes that only a graph with a base can show.
pub(crate) const CODES: [&str; 4] = ["RX0102", "RX0109", "RX0154", "RX0155"];

const OVER: &str = "graphs/variants/over.toml";

fn over(text: &str) -> Project {
    let mut project = Project::new();
    project.put(OVER, &format!("extends = \"../base.toml\"\n{text}"));
    project
}

#[test]
fn an_overlay_changes_what_it_names_and_nothing_else() {
    let project = over(include_str!("../fixtures/extends/over.toml"));
    let (compiled, _) = project.compile(OVER);
    let (graph, warnings) = compiled.unwrap_or_else(|_| panic!("{}", project.rendered(OVER)));
    assert_eq!(graph.name, "over");
    assert_eq!(graph.about, "first hit, a pyramid over it, probes");
    let names: Vec<&str> = graph.passes.iter().map(|pass| &pass.name[..]).collect();
    assert_eq!(names, ["primary", "probe_update", "pyramid", "pyramid_2"]);
    assert_eq!(graph.params[0].default, Value::F32(2.0));
    assert_eq!(graph.params[0].range, Some([0.0, 8.0]));
    // `init` replaces the base's `clear`: they exclude each other.
    let ResourceKind::Target(depth) = &graph.resource(graph.find_resource("half_depth").unwrap()).kind else {
        panic!()
    };
    assert_eq!((depth.clear, depth.init), (None, Some(Clear::Float([1.0, 0.0, 0.0, 0.0]))));
    let primary = graph.pass(graph.find_pass("primary").unwrap());
    assert_eq!(primary.dispatch, Dispatch::Groups([1, 2, 3]));
    assert_eq!((primary.push.len(), primary.subgroup_size), (6, Some(32)));
    assert!(primary.shader.request.defines.contains(&("MAX_STEPS".to_owned(), "16".to_owned())));
    assert!(graph.pass(graph.find_pass("probe_update").unwrap()).when.is_empty());
    assert_eq!(graph.files[..2], [OVER, "graphs/base.toml"]);
    // The bool param has lost its only user.
    assert_eq!(warnings.iter().map(|w| w.code.as_str()).collect::<Vec<_>>(), ["RX0161"]);
}

#[test]
fn mistakes_point_into_the_file_that_they_are_in() {
    let mut said = String::new();
    for text in [
        // A value of the base that an overlay makes wrong: both files are shown.
        "[targets.half_depth]\nformat = \"rgba16f\"\n",
        "[params.exposure]\ntype = \"i32\"\n",
        "[[passes]]\nname = \"extra\"\nafter = \"primry\"\nshader = \"pyramid.comp\"\ndispatch = [1]\n",
        "[[passes]]\nname = \"primry\"\nremove = true\n",
        "[targets.hitt]\nremove = true\n",
        "[targets.hit]\nremove = true\n",
        "[targets.hit]\nremove = true\nformat = \"r8\"\n",
        "[[passes]]\nname = \"primary\"\n[passes.push]\nfoo = { remove = true }\n",
        "[[passes]]\nname = \"new\"\nshader = \"pyramid.comp\"\ndispatch = [1]\nbind = { above = { remove = true } }\n",
        "[[passes]]\nname = \"finish\"\ndispatch = [1]\n[[passes]]\nname = \"finish\"\ndispatch = [2]\n",
    ] {
        writeln!(said, "──── {text:?}\n{}", over(text).rendered(OVER)).unwrap();
    }
    insta::assert_snapshot!("extends", said);
}

#[test]
fn a_row_that_does_not_end_is_named() {
    let mut project = over("");
    project.put("graphs/base.toml", "extends = \"variants/over.toml\"\n");
    let mut said = project.rendered(OVER);
    project.put("graphs/base.toml", "extends = \"missing.toml\"\n");
    said += &project.rendered(OVER);
    project.put("graphs/base.toml", "extends = \"../../outside.toml\"\n");
    said += &project.rendered(OVER);
    for n in 0..20 {
        project.put(&format!("graphs/{n}.toml"), &format!("extends = \"{}.toml\"\n", n + 1));
    }
    said += &project.rendered("graphs/0.toml");
    project.put(
        "graphs/alone.toml",
        r#"name = "a"
[targets.x]
remove = true
[[passes]]
name = "p"
after = "q"
"#,
    );
    said += &project.rendered("graphs/alone.toml");
    insta::assert_snapshot!("chains", said);
}

#[test]
fn counts_have_caps() {
    let mut project = Project::new();
    let mut many = String::new();
    for n in 0..=4096 {
        writeln!(many, "[params.p{n}]\ntype = \"f32\"\ndefault = 0.0").unwrap();
    }
    project.put("graphs/many.toml", &many);
    assert!(project.rendered("graphs/many.toml").contains("[RX0155]"));
}
