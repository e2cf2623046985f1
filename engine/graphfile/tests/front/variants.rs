//! Buffers that only some worlds have: a pass that binds one is compiled with it and without it, under conditions that exclude each other.

use raxel_graph::checked::{Condition, Fact, Pass};

use crate::files::Project;

const GRAPH: &str = include_str!("../fixtures/variants/lit.toml");

const SHADER: &str = include_str!("../fixtures/variants/look.comp");

fn project(graph: &str) -> Project {
    let mut project = Project::new();
    project.put("graphs/lit.toml", graph);
    project.put("shaders/look.comp", SHADER);
    project
}

fn passes(graph: &str) -> Vec<Pass> {
    let project = project(graph);
    let (compiled, _) = project.compile("graphs/lit.toml");
    let (graph, warnings) = compiled.unwrap_or_else(|_| panic!("{}", project.rendered("graphs/lit.toml")));
    assert_eq!(warnings, []);
    assert_eq!(graph.cases("look").count(), graph.passes.len());
    graph.passes
}

#[test]
fn a_pass_is_compiled_with_the_binding_and_without() {
    let passes = passes(GRAPH);
    let [with, without] = &passes[..] else { panic!("{} passes", passes.len()) };
    assert_eq!((with.accesses.len(), without.accesses.len()), (2, 1));
    let asks = |pass: &Pass| pass.when.last().map(|when| (when.fact.clone(), when.negated));
    assert_eq!(asks(with), Some((Fact::WorldHasInstances, false)));
    assert_eq!(asks(without), Some((Fact::WorldHasInstances, true)));
    // Its own condition holds for both.
    assert!(passes.iter().all(|pass| matches!(pass.when[0], Condition { fact: Fact::Param(_), negated: false })));
    // In every world just one of them runs.
    for there in [true, false] {
        let holds = |fact: &Fact| *fact != Fact::WorldHasInstances || there;
        assert_eq!(passes.iter().map(|pass| pass.runs_where(holds)).collect::<Vec<_>>(), [there, !there]);
        assert!(!passes.iter().any(|pass| pass.runs_where(|fact| *fact == Fact::WorldHasInstances && there)));
    }
    let defines = |pass: &Pass| pass.shader.request.defines.clone();
    assert_eq!(defines(with), [("RX_BINDS_glow".to_owned(), "1".to_owned())]);
    assert_eq!(defines(without), []);
}

#[test]
fn a_pass_of_such_worlds_alone_has_no_other_case() {
    let passes = passes(
        &GRAPH
            .replace("when = \"param.on\"", "when = \"world.has_instances\"")
            .replace("[params.on]\ntype = \"bool\"\ndefault = true\n", ""),
    );
    assert_eq!(passes.len(), 1);
    assert_eq!(passes[0].accesses.len(), 2);
}

#[test]
fn a_mistake_in_both_cases_is_one_mistake() {
    let rendered = project(&GRAPH.replace("outColor = \"color\"", "outColour = \"color\"")).rendered("graphs/lit.toml");
    assert_eq!(rendered.matches("RX0121").count(), 1, "{rendered}");
}

#[test]
fn only_the_world_can_be_asked() {
    for wrong in ["world.has_instance", "param.on", "device.packets"] {
        let graph = GRAPH.replacen("when = \"world.has_instances\"", &format!("when = \"{wrong}\""), 1);
        let rendered = project(&graph).rendered("graphs/lit.toml");
        assert!(rendered.contains("RX0106") && rendered.contains(wrong), "{rendered}");
    }
}
